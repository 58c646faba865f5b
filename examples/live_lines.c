/* Lines of a live sensor: a session that owns it, and a framer. live_lines
 * ADDRESS. Needs lumsdk::net and lumsdk::frame. */
#include "lum/base/time.h"
#include "lum/frame/framer.h"
#include "lum/net/sensor.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>

#define NS_PER_S INT64_C(1000000000)
#define LINES    100

/* Takes a datagram; counts the lines that it completed. */
static int take(lum_framer *framer, uint32_t sensor,
                const lum_received *datagram)
{
    const lum_record record = {.time_ns = datagram->utc_ns,
                               .payload = datagram->bytes,
                               .len = datagram->len,
                               .source = sensor,
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    int lines = 0;
    while (lum_framer_push(framer, &record, NULL) == LUM_FRAMER_LINE) {
        const lum_line *line = lum_framer_line(framer);
        (void)printf("frame %lld, eye %u, line %lu: %lu words\n",
                     (long long)line->frame, line->eye,
                     (unsigned long)line->number,
                     (unsigned long)line->word_count);
        lines++;
    }
    return lines;
}

/* Whether the lines came. lum_sensor_receive() sends the heartbeats. */
static bool run(lum_sensor *sensor, uint32_t address, lum_framer *framer)
{
    const int64_t end = lum_time_monotonic_ns() + 10 * NS_PER_S;
    lum_sensor_event event;
    int lines = 0;
    while (lines < LINES) {
        lum_sensor_receive(sensor, end, &event);
        if (event.kind == LUM_SENSOR_IDLE || event.kind == LUM_SENSOR_FAILED) {
            return false;
        }
        if (event.kind == LUM_SENSOR_DATAGRAMS) {
            for (size_t i = 0; i < event.datagram_count; i++) {
                lines += take(framer, address, &event.datagrams[i]);
            }
        }
    }
    return true;
}

/* a.b.c.d */
static bool parse(const char *text, uint32_t *address)
{
    uint32_t value = 0;
    for (int i = 0; i < 4; i++) {
        char *end = NULL;
        const unsigned long part = strtoul(text, &end, 10);
        if (end == text || part > 255 || *end != (i < 3 ? '.' : '\0')) {
            return false;
        }
        value = value << 8 | (uint32_t)part;
        text = end + 1;
    }
    *address = value;
    return true;
}

int main(int argc, char **argv)
{
    const lum_framer_options lines = {.struct_size = sizeof lines,
                                      .wants = LUM_WANT_LINES};
    lum_framer *framer = NULL;
    lum_sensor_options options;
    lum_sensor *sensor = NULL;
    lum_error error;
    lum_sensor_options_default(&options);
    options.owns = true; /* heartbeats, and so the data */
    if (argc != 2 || !parse(argv[1], &options.sensor.address)) {
        (void)fputs("usage: live_lines ADDRESS\n", stderr);
        return 2;
    }
    if (lum_framer_new(&lines, &framer, &error) != 0 ||
        lum_sensor_open(&options, &sensor, &error) != LUM_NET_OK) {
        (void)fprintf(stderr, "live_lines: %s\n", error.text);
        lum_framer_free(framer);
        return 1;
    }
    const bool good = run(sensor, options.sensor.address, framer);
    lum_sensor_close(sensor);
    lum_framer_free(framer);
    return good ? 0 : 1;
}
