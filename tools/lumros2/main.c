/* lumros2: messages of an MCAP file as topics of ROS 2, through DDS. */
#include "../common/interrupt.h"
#include "bus.h"
#include "options.h"
#include "publisher.h"

#include <inttypes.h>
#include <stdio.h>

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2
};

static void summarize(struct bus *bus)
{
    for (size_t i = 0; i < bus_topics(bus); i++) {
        const struct bus_count count = bus_count(bus, i);
        (void)fprintf(stderr,
                      "lumros2: %s: %" PRIu64 " messages, %.1f MB, %" PRIu64
                      " dropped\n",
                      count.name, count.messages, (double)count.bytes * 1e-6,
                      count.dropped);
    }
}

static int run(const struct options *options)
{
    struct bus *bus = NULL;
    lum_error error = {""};
    const int result = publisher_run(options, &bus, &error);
    if (!options->quiet && bus != NULL) {
        summarize(bus);
    }
    bus_close(bus);
    if (result != 0) {
        (void)fprintf(stderr, "lumros2: %s\n", error.text);
    }
    return result == 0 ? EXIT_DONE : EXIT_FAILED;
}

int main(int argc, char **argv)
{
    static struct options options;
    switch (options_parse(argc, argv, &options)) {
    case OPTIONS_SHOWN:
        return fflush(stdout) == 0 ? EXIT_DONE : EXIT_FAILED;
    case OPTIONS_REFUSED:
        return EXIT_BAD;
    case OPTIONS_READ:
    default:
        break;
    }
    interrupt_catch();
    return run(&options);
}
