/* Lines of a live sensor: a session that owns it, and a reader. live_lines
 * ADDRESS. Needs lumsdk::net and lumsdk::frame. */
#include "lum/frame/reader.h"
#include "lum/net/live.h"
#include "lum/net/resolve.h"

#include <stdio.h>

#define LINES 100

/* Whether the lines came. Heartbeats go out inside lum_reader_next(). */
static bool run(lum_sensor *sensor, lum_error *error)
{
    const lum_framer_options lines = {.struct_size = sizeof lines,
                                      .wants = LUM_WANT_LINES};
    const lum_live_options live = {
        .struct_size = sizeof live, .sensor = sensor, .duration_ms = 10000};
    lum_record_source records = {.struct_size = sizeof records};
    const lum_reader_options options = {
        .struct_size = sizeof options, .records = &records, .framer = &lines};
    lum_reader *reader = NULL;
    lum_framer_event event;
    int count = 0;
    uint64_t words = 0;
    if (lum_live_source(&live, &records, error) != 0 ||
        lum_reader_open(&options, &reader, error) != 0) {
        return false;
    }
    int status = 0;
    while (count < LINES &&
           (status = lum_reader_next(reader, &event, error)) > 0) {
        const lum_line *line = lum_framer_line(lum_reader_framer(reader));
        (void)printf("frame %lld, eye %u, line %lu: %lu words\n",
                     (long long)line->frame, line->eye,
                     (unsigned long)line->number,
                     (unsigned long)line->word_count);
        words += line->word_count;
        count++;
    }
    if (count > 0 && words == 0) {
        (void)fputs("no line has ranges: the laser is off, and this program "
                    "leaves it so\n",
                    stderr);
    }
    lum_reader_close(reader);
    return count == LINES ||
           (status == 0 && lum_error_set(error, "too few lines in 10 s") == 0);
}

int main(int argc, char **argv)
{
    lum_sensor_options options;
    lum_sensor *sensor = NULL;
    lum_error error;
    lum_sensor_options_default(&options);
    options.owns = true; /* heartbeats, and so the data */
    if (argc != 2) {
        (void)fputs("usage: live_lines ADDRESS\n", stderr);
        return 2;
    }
    const bool good =
        lum_resolve(argv[1], &options.sensor.address, &error) == 0 &&
        lum_sensor_open(&options, &sensor, &error) == LUM_NET_OK &&
        run(sensor, &error);
    if (!good) {
        (void)fprintf(stderr, "live_lines: %s\n", error.text);
    }
    lum_sensor_close(sensor);
    return good ? 0 : 1;
}
