/* Lines of a live sensor: a session that owns it, and the core's assembler.
 * live_lines ADDRESS. Needs lumsdk::net. */
#include "lum/assembler.h"
#include "lum/base/time.h"
#include "lum/net/sensor.h"
#include "lum/packet.h"

#include <stdio.h>
#include <stdlib.h>

#define NS_PER_S INT64_C(1000000000)
#define OPEN     4     /* lines of an eye at a time */
#define REACH    8     /* lines */
#define WORDS    16384 /* of a line */
#define LINES    100

/* Takes a datagram; counts the lines that it completed. */
static int take(lum_assembler *assembler, const lum_layout *layout,
                const lum_received *datagram)
{
    lum_group group;
    lum_result result;
    int lines = 0;
    if (lum_packet_decode(layout, datagram->bytes, datagram->len, &group) !=
        LUM_PACKET_DATA) {
        return 0;
    }
    while ((result = lum_assembler_push(assembler, &group, datagram->utc_ns)) >
           LUM_OK) {
        if (result == LUM_LINE_READY) {
            const lum_line *line = lum_assembler_line(assembler);
            (void)printf("frame %lld, eye %u, line %lu: %lu words\n",
                         (long long)line->frame, line->eye,
                         (unsigned long)line->number,
                         (unsigned long)line->word_count);
            lines++;
        }
    }
    return lines;
}

/* Whether the lines came. lum_sensor_receive() keeps the heartbeats going. */
static bool run(lum_sensor *sensor, lum_assembler *assembler,
                const lum_layout *layout)
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
                lines += take(assembler, layout, &event.datagrams[i]);
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
    static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN)];
    static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN, WORDS)];
    static lum_reach reach[LUM_ASSEMBLER_REACH(REACH)];
    static const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    static lum_assembler assembler;
    lum_assembler_config config;
    lum_sensor_options options;
    lum_sensor *sensor = NULL;
    lum_error error;
    lum_sensor_options_default(&options);
    lum_assembler_config_default(&config);
    config.open_lines = OPEN;
    config.words_per_line = WORDS;
    config.reorder_lines = REACH;
    options.owns = true; /* heartbeats, and so the data */
    if (argc != 2 || !parse(argv[1], &options.sensor.address)) {
        (void)fputs("usage: live_lines ADDRESS\n", stderr);
        return 2;
    }
    if (lum_assembler_init(&assembler, &config, &options.layout, &storage) !=
            LUM_OK ||
        lum_sensor_open(&options, &sensor, &error) != LUM_NET_OK) {
        (void)fprintf(stderr, "live_lines: %s\n", error.text);
        return 1;
    }
    const bool good = run(sensor, &assembler, &options.layout);
    lum_sensor_close(sensor);
    return good ? 0 : 1;
}
