#include "player.h"

#include "../common/interrupt.h"
#include "../common/printable.h"
#include "capture/mcap_messages.h"
#include "lum/base/time.h"
#include "pace.h"

#include <stdio.h>
#include <string.h>

#define NOWHERE SIZE_MAX /* of a topic that is not published */

#define MS_NS       INT64_C(1000000)
#define SLICE_MS    20   /* between looks at signals */
#define SETTLE_MS   1000 /* --rate 0: for readers that take nothing */
#define FINISH_MS   3000 /* for the last messages */
#define MEET_MS     500  /* until a reader that is known knows the writer */
#define PACE_MIN_NS INT64_C(1000000)

struct player {
    const struct options *options;
    struct bus *bus;
    lum_source *source;
    lum_mcap_messages *file;
    const char *name;                          /* of the source, for messages */
    size_t places[LUM_MCAP_CHANNELS_KEPT_MAX]; /* in the bus, of its topics */
    uint64_t counts[LUM_MCAP_CHANNELS_KEPT_MAX]; /* of messages, this round */
    uint64_t messages;                           /* of all, this round */
    bool has_begun;
    struct pace pace;
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

static void wait_for_readers(const struct player *p)
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

static void say_skipped(const struct player *p, const lum_mcap_topic *topic,
                        const char *why)
{
    char name[NAMES_BYTES];
    if (!p->options->quiet) {
        (void)fprintf(stderr, "lumros2: warning: %s: topic %s %s\n", p->name,
                      printable((const uint8_t *)topic->name,
                                strlen(topic->name), name, sizeof name),
                      why);
    }
}

static void say_topic(const struct player *p, const struct bus_topic *topic)
{
    if (!p->options->quiet) {
        (void)fprintf(stderr, "lumros2: domain %lld: %s, %s, %s\n",
                      (long long)p->options->domain, topic->name, topic->type,
                      qos_name(topic->kind));
    }
}

static int add_topic(struct player *p, const lum_mcap_message *m,
                     lum_error *error)
{
    char name[NAMES_BYTES];
    char type[NAMES_BYTES];
    p->places[m->index] = NOWHERE;
    p->counts[m->index] = 0;
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

static void say_readers(const struct player *p)
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

static void await(struct player *p, uint64_t log_ns)
{
    if (!p->has_begun) {
        p->has_begun = true;
        wait_for_readers(p);
        pace_begin(&p->pace, p->options->rate, lum_time_monotonic_ns());
    }
    if (is_paced(p->options)) {
        sleep_until(pace_due(&p->pace, log_ns));
    }
}

static int publish(struct player *p, const lum_mcap_message *m,
                   lum_error *error)
{
    const size_t place = p->places[m->index];
    if (place == NOWHERE) {
        return 0;
    }
    await(p, m->log_ns);
    if (interrupt_signal() != 0) {
        return 0;
    }
    p->messages++;
    p->counts[m->index]++;
    if (bus_publish(p->bus, place, m->bytes, m->len, error) != 0) {
        return -1;
    }
    if (p->options->has_rate && !is_paced(p->options)) {
        settle(p->bus, SETTLE_MS);
    }
    say_readers(p);
    return 0;
}

static int take(struct player *p, lum_mcap_event event,
                const lum_mcap_message *m, lum_error *error)
{
    return event == LUM_MCAP_HAS_TOPIC ? add_topic(p, m, error)
                                       : publish(p, m, error);
}

/* --- Rounds --- */

/* A signal ends the reading of a pipe, too. */
static int fail(const struct player *p, const lum_error *why, lum_error *error)
{
    return interrupt_signal() != 0
               ? 0
               : lum_error_set(error, "%s: %s", p->name, why->text);
}

static int play(struct player *p, lum_error *error)
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

/* The next round begins as long after the last message as messages of the topic
 * that has most of them are apart. */
static void end_round(struct player *p)
{
    uint64_t most = 0;
    for (size_t i = 0; i < LUM_MCAP_CHANNELS_KEPT_MAX; i++) {
        most = p->counts[i] > most ? p->counts[i] : most;
    }
    const uint64_t span = p->pace.last_ns - p->pace.log_ns;
    const double apart =
        most > 1 ? (double)span / (double)(most - 1u) / p->pace.rate : 0.0;
    const int64_t last =
        p->pace.host_ns + (int64_t)((double)span / p->pace.rate);
    const int64_t next =
        (int64_t)apart > PACE_MIN_NS ? (int64_t)apart : PACE_MIN_NS;
    pace_begin(&p->pace, p->pace.rate, last + next);
}

static int play_file(struct player *p, lum_error *error)
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

static int play_once(struct player *p, lum_error *error)
{
    memset(p->counts, 0, sizeof p->counts);
    p->messages = 0;
    if (lum_source_open(p->options->source, &p->source, error) != 0) {
        return -1;
    }
    const int result = play_file(p, error);
    lum_mcap_messages_free(p->file);
    lum_source_close(p->source);
    return result;
}

static int check_messages(const struct player *p, lum_error *error)
{
    return p->messages != 0 || interrupt_signal() != 0
               ? 0
               : lum_error_set(error, "%s: it has no messages of ROS 2",
                               p->name);
}

int player_run(const struct options *options, struct bus **bus,
               lum_error *error)
{
    const bool is_stream = strcmp(options->source, "-") == 0;
    struct player p = {.options = options,
                       .name = is_stream ? "standard input" : options->source};
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
