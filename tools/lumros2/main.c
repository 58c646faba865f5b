/* lumros2: messages of an MCAP file as topics of ROS 2, through DDS. */
#include "../common/interrupt.h"
#include "../common/printable.h"
#include "bus.h"
#include "capture/mcap_messages.h"
#include "lum/base/time.h"
#include "options.h"
#include "schedule.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define NOWHERE SIZE_MAX /* of a topic that is not published */

#define MS_NS        INT64_C(1000000)
#define SLICE_MS     20   /* between looks at signals */
#define SETTLE_MS    1000 /* --rate 0: for readers that take nothing */
#define FINISH_MS    3000 /* for the last messages */
#define MEET_MS      500  /* until a reader that is known knows the writer */
#define ROUND_MIN_NS INT64_C(100000000)

/* What a round had of a topic of the file. */
struct part {
    uint64_t count;
    int64_t first_ns; /* when it was due, by the host's clock */
    int64_t last_ns;
};

struct publisher {
    const struct options *options;
    struct bus *bus;
    lum_source *source;
    lum_mcap_messages *file;
    const char *name;                          /* of the source, for messages */
    size_t places[LUM_MCAP_CHANNELS_KEPT_MAX]; /* in the bus, of its topics */
    struct part parts[LUM_MCAP_CHANNELS_KEPT_MAX];
    uint64_t messages; /* of all topics, this round */
    bool has_begun;
    int64_t round_ns; /* its begin, by the host's monotonic clock */
    struct schedule schedule;
};

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2
};

static bool is_paced(const struct options *o)
{
    return o->has_rate && o->rate > 0.0;
}

/* --- Waiting --- */

static void pause_ms(int ms)
{
    lum_time_sleep_until(lum_time_monotonic_ns() + ms * MS_NS);
}

static void sleep_until(int64_t ns)
{
    while (interrupt_signal() == 0 && lum_time_monotonic_ns() < ns) {
        const int64_t slice = lum_time_monotonic_ns() + SLICE_MS * MS_NS;
        lum_time_sleep_until(slice < ns ? slice : ns);
    }
}

/* Until reliable readers have all that was sent. */
static void settle(struct bus *bus, int ms)
{
    const int64_t end = lum_time_monotonic_ns() + ms * MS_NS;
    while (!bus_wait(bus, SLICE_MS) && interrupt_signal() == 0 &&
           lum_time_monotonic_ns() < end) {
    }
}

static void wait_for_readers(const struct publisher *p)
{
    while (interrupt_signal() == 0 &&
           bus_readers(p->bus) < (unsigned)p->options->readers) {
        pause_ms(SLICE_MS);
    }
    if (p->options->readers > 0) {
        sleep_until(lum_time_monotonic_ns() + MEET_MS * MS_NS);
    }
}

/* --- Topics --- */

static void say_skipped(const struct publisher *p,
                        const lum_mcap_messages_topic *topic, const char *why)
{
    char name[NAMES_BYTES];
    if (!p->options->quiet) {
        (void)fprintf(stderr, "lumros2: warning: %s: topic %s %s\n", p->name,
                      printable((const uint8_t *)topic->name,
                                strlen(topic->name), name, sizeof name),
                      why);
    }
}

static void say_topic(const struct publisher *p, const struct bus_topic *topic)
{
    if (!p->options->quiet) {
        (void)fprintf(stderr, "lumros2: domain %lld: %s, %s, %s\n",
                      (long long)p->options->domain, topic->name, topic->type,
                      qos_name(topic->kind));
    }
}

static int add_topic(struct publisher *p, const lum_mcap_message *m,
                     lum_error *error)
{
    char name[NAMES_BYTES];
    char type[NAMES_BYTES];
    p->places[m->index] = NOWHERE;
    if (strcmp(m->topic->encoding, "cdr") != 0 ||
        !names_dds_type(m->topic->type, type)) {
        say_skipped(p, m->topic, "has no messages of ROS 2 and is left out");
        return 0;
    }
    if (!names_topic(&p->options->names, m->topic->name, name)) {
        say_skipped(p, m->topic, "has no name of ROS 2 and is left out");
        return 0;
    }
    const struct bus_topic topic = {name, m->topic->type,
                                    qos_of(&p->options->qos, name),
                                    (uint32_t)p->options->qos.depth};
    const size_t before = bus_topics(p->bus);
    if (bus_add(p->bus, &topic, &p->places[m->index], error) != 0) {
        return -1;
    }
    if (bus_topics(p->bus) != before) {
        say_topic(p, &topic);
    }
    return 0;
}

static void say_readers(const struct publisher *p)
{
    for (size_t i = 0; p->options->verbose && i < bus_topics(p->bus); i++) {
        const struct bus_count count = bus_count(p->bus, i);
        if (count.has_new_count) {
            (void)fprintf(stderr, "lumros2: %s: %u reader%s\n", count.name,
                          count.readers, count.readers == 1 ? "" : "s");
        }
    }
}

/* --- Messages --- */

static void note(struct part *part, int64_t due_ns)
{
    if (part->count++ == 0) {
        part->first_ns = due_ns;
    }
    part->last_ns = due_ns;
}

static void begin_round(struct publisher *p, int64_t host_ns)
{
    p->round_ns = host_ns;
    schedule_begin(&p->schedule, p->options->rate, host_ns);
}

static void await(struct publisher *p, const lum_mcap_message *m)
{
    if (!p->has_begun) {
        p->has_begun = true;
        wait_for_readers(p);
        begin_round(p, lum_time_monotonic_ns());
    }
    if (is_paced(p->options)) {
        const int64_t due_ns = schedule_due(&p->schedule, m->log_ns);
        note(&p->parts[m->index], due_ns);
        sleep_until(due_ns);
    }
}

static int publish(struct publisher *p, const lum_mcap_message *m,
                   lum_error *error)
{
    const size_t place = p->places[m->index];
    if (place == NOWHERE) {
        return 0;
    }
    await(p, m);
    if (interrupt_signal() != 0) {
        return 0;
    }
    p->messages++;
    if (bus_publish(p->bus, place, m->bytes, m->len, error) != 0) {
        return -1;
    }
    if (p->options->has_rate && !is_paced(p->options)) {
        settle(p->bus, SETTLE_MS);
    }
    say_readers(p);
    return 0;
}

static int take(struct publisher *p, lum_mcap_event event,
                const lum_mcap_message *m, lum_error *error)
{
    return event == LUM_MCAP_HAS_TOPIC ? add_topic(p, m, error)
                                       : publish(p, m, error);
}

/* --- Rounds --- */

/* A signal ends the reading of a pipe, too. */
static int fail(const struct publisher *p, const lum_error *why,
                lum_error *error)
{
    return interrupt_signal() != 0
               ? 0
               : lum_error_set(error, "%s: %s", p->name, why->text);
}

static int play(struct publisher *p, lum_error *error)
{
    lum_mcap_message m;
    lum_error why = {""};
    lum_mcap_event event = LUM_MCAP_HAS_TOPIC;
    while (interrupt_signal() == 0 && event > LUM_MCAP_ENDED) {
        event = lum_mcap_messages_next(p->file, &m, &why);
        if (event == LUM_MCAP_FAILED ||
            (event > LUM_MCAP_ENDED && take(p, event, &m, &why) != 0)) {
            return fail(p, &why, error);
        }
    }
    return 0;
}

/* The next round begins so that the messages of the topic that has most of them
 * go on in their rhythm. */
static void end_round(struct publisher *p)
{
    const struct part *most = &p->parts[0];
    for (size_t i = 1; i < LUM_MCAP_CHANNELS_KEPT_MAX; i++) {
        most = p->parts[i].count > most->count ? &p->parts[i] : most;
    }
    const int64_t span = most->last_ns - most->first_ns;
    const int64_t round =
        most->count > 1 ? span + span / (int64_t)(most->count - 1u) : 0;
    begin_round(p, p->round_ns + (round > ROUND_MIN_NS ? round : ROUND_MIN_NS));
}

static int play_file(struct publisher *p, lum_error *error)
{
    lum_error why = {""};
    p->file = lum_mcap_messages_new(p->source, &why);
    if (p->file == NULL) {
        return fail(p, &why, error);
    }
    return p->bus != NULL ||
                   bus_open((unsigned)p->options->domain, &p->bus, error) == 0
               ? play(p, error)
               : -1;
}

static void say_damage(const struct publisher *p)
{
    lum_error damage = {""};
    if (p->file != NULL && lum_mcap_messages_damaged(p->file, &damage) != 0 &&
        !p->options->quiet) {
        (void)fprintf(stderr, "lumros2: warning: %s\n", damage.text);
    }
}

static int play_once(struct publisher *p, lum_error *error)
{
    memset(p->parts, 0, sizeof p->parts);
    p->messages = 0;
    if (lum_source_open(p->options->source, &p->source, error) != 0) {
        return -1;
    }
    const int result = play_file(p, error);
    say_damage(p);
    lum_mcap_messages_free(p->file);
    lum_source_close(p->source);
    return result;
}

static int check_messages(const struct publisher *p, lum_error *error)
{
    return p->messages != 0 || interrupt_signal() != 0
               ? 0
               : lum_error_set(error, "%s: it has no messages of ROS 2",
                               p->name);
}

/* Plays the source to its end, or again and again, until a signal comes. *bus,
 * the caller's to close, is joined when the source has shown what it is; NULL
 * before. */
static int publisher_run(const struct options *options, struct bus **bus,
                         lum_error *error)
{
    const bool is_stream = strcmp(options->source, "-") == 0;
    struct publisher p = {.options = options,
                          .name =
                              is_stream ? "standard input" : options->source};
    int result = 0;
    do {
        result = play_once(&p, error);
        if (result == 0) {
            result = check_messages(&p, error);
        }
        if (is_paced(options)) {
            end_round(&p);
        }
    } while (result == 0 && options->loops && interrupt_signal() == 0);
    if (p.bus != NULL) {
        settle(p.bus, FINISH_MS);
        say_readers(&p);
    }
    *bus = p.bus;
    return result;
}

/* --- The program --- */

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
