/* Any bytes as a capture file. */
#include "lum/capture/capture.h"

#include <stdint.h>
#include <stdlib.h>

#define SMALLEST_RECORD 16u
#define LARGEST_PAYLOAD 65507u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static void check_record(const lum_record *r)
{
    static volatile uint8_t last;
    const int64_t limit_ns = INT64_C(1) << 62;
    require(r->kind >= LUM_RECORD_DATAGRAM && r->kind <= LUM_RECORD_OTHER);
    require(r->time_ns > -limit_ns && r->time_ns < limit_ns);
    require(r->len <= LARGEST_PAYLOAD);
    require(r->kind == LUM_RECORD_DATAGRAM || r->len == 0);
    for (size_t i = 0; i < r->len; i++) {
        last = r->payload[i];
    }
    (void)last;
}

static void check_comments(const lum_capture *capture)
{
    const size_t count = lum_capture_comment_count(capture, 0);
    require(count <= LUM_CAPTURE_COMMENTS_MAX);
    for (size_t i = 0; i < count; i++) {
        size_t len = 0;
        const char *text = lum_capture_comment(capture, 0, i, &len);
        require(len <= LUM_CAPTURE_COMMENT_BYTES_MAX);
        require(text[len] == '\0');
    }
    require(count == LUM_CAPTURE_COMMENTS_MAX ||
            lum_capture_comments_left_out(capture, 0) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lum_capture *capture = NULL;
    lum_record record;
    lum_error error;
    uint64_t records = 0;
    uint64_t dropped = 0;
    uint64_t kept = 0;
    int result = 0;
    lum_source *source = lum_source_from_memory("fuzz", data, size);
    if (source == NULL ||
        lum_capture_open_source(source, &capture, &error) != 0) {
        return 0;
    }
    while ((result = lum_capture_next(capture, &record, &error)) == 1) {
        check_record(&record);
        records++;
        dropped += record.dropped_fragments;
        kept += record.kind == LUM_RECORD_FRAGMENT;
        require(records <= size / SMALLEST_RECORD);
    }
    dropped += record.dropped_fragments;
    require(dropped <= kept);
    require(lum_capture_next(capture, &record, &error) == 0);
    require(record.dropped_fragments == 0);
    check_comments(capture);
    lum_capture_close(capture);
    return 0;
}
