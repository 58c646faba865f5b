/* flatten CAPTURE OUTPUT: the datagrams of a capture as a flat file, for
 * targets without files: of each its length (u32), capture time (i64), both
 * little-endian, and its bytes. */
#include "lum/capture/capture.h"

#include <stdio.h>
#include <stdlib.h>

#define SENSOR_PORT 5517u

static void put_le(uint8_t *out, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        out[i] = (uint8_t)(value >> (8u * i));
    }
}

static bool write_datagram(FILE *out, const lum_record *record)
{
    uint8_t head[12];

    put_le(head, record->len, 4);
    put_le(head + 4, (uint64_t)record->time_ns, 8);
    return fwrite(head, 1, sizeof head, out) == sizeof head &&
           fwrite(record->payload, 1, record->len, out) == record->len;
}

static bool is_wanted(const lum_record *record)
{
    return lum_record_is_datagram(record) &&
           (record->source_port == SENSOR_PORT ||
            record->destination_port == SENSOR_PORT);
}

/* What a damaged capture holds before the damage counts, as for lumdump. */
static bool flatten(lum_capture *capture, FILE *out)
{
    lum_error error = {{0}};
    lum_record record;
    int more;

    while ((more = lum_capture_next(capture, &record, &error)) > 0) {
        if (is_wanted(&record) && !write_datagram(out, &record)) {
            return false;
        }
    }
    if (more < 0) {
        (void)fprintf(stderr, "flatten: %s\n", error.text);
    }
    return true;
}

int main(int argc, char **argv)
{
    lum_error error = {{0}};
    lum_capture *capture = NULL;
    FILE *out;
    bool ok;

    if (argc != 3) {
        (void)fputs("usage: flatten CAPTURE OUTPUT\n", stderr);
        return 2;
    }
    if (lum_capture_open(argv[1], &capture, &error) != 0) {
        (void)fprintf(stderr, "flatten: %s\n", error.text);
        return EXIT_FAILURE;
    }
    out = fopen(argv[2], "wb");
    ok = out != NULL && flatten(capture, out);
    if (out != NULL && fclose(out) != 0) {
        ok = false;
    }
    lum_capture_close(capture);
    if (!ok) {
        (void)fprintf(stderr, "flatten: %s cannot be written\n", argv[2]);
    }
    return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
