#include "lanes.h"

#include "../common/interrupt.h"
#include "lum/base/time.h"

#include <inttypes.h>

#define SECOND_NS INT64_C(1000000000)

#define BUFFER_BYTES (UINT64_C(64) << 20)

/* How long an output may make no progress with its buffer full. */
#define STALL_NS (5 * SECOND_NS)

/* How long a laser stays on for messages that nobody reads. */
#define UNREAD_NS (3 * SECOND_NS)

/* At the end. */
#define PIPE_NS       (3 * SECOND_NS)
#define PIPE_TOTAL_NS (60 * SECOND_NS)
#define FILE_NS       (30 * SECOND_NS)
#define TOLD_NS       (10 * SECOND_NS)
#define CUT_NS        (SECOND_NS / 2) /* after a signal: what is about to end */
#define LOOK_NS       (SECOND_NS / 200)

/* --- The beginning --- */

int lanes_open(struct lanes *lanes, struct pass *run, lum_error *error)
{
    const uint64_t asked = run->options->live.buffer;
    const size_t size = (size_t)(asked != 0 ? asked : BUFFER_BYTES);
    lanes->has_laser = run->options->live.laser || run->options->live.guards;
    lanes->summary = lane_new(run, LANE_OF_SUMMARY, size, error);
    if (lanes->summary == NULL) {
        return -1;
    }
    lanes->list[0] = lanes->summary;
    for (size_t i = 0; i < run->options->output_count; i++) {
        lanes->list[i + 1u] = lanes->summary;
        lanes->list[i] = lane_new(run, i, size, error);
        lanes->count++;
        if (lanes->list[i] == NULL) {
            return -1;
        }
    }
    return 0;
}

/* The summary's, which waits for no disk, comes last: where it is started, all
 * are. */
int lanes_start(struct lanes *lanes, struct lane_ends ends, lum_error *error)
{
    int result = 0;
    for (size_t i = 0; i < lanes->count && result == 0; i++) {
        result = lane_start(lanes->list[i], ends, error);
    }
    if (result == 0) {
        result = interrupt_signal() != 0
                     ? -1
                     : lane_start(lanes->summary, ends, error);
    }
    for (size_t i = 0; i < lanes->count && result != 0; i++) {
        lane_stop(lanes->list[i]);
    }
    return result;
}

/* --- Data --- */

void lanes_put(struct lanes *lanes, const struct ring_item *item)
{
    for (size_t i = 0; i <= lanes->count; i++) {
        lane_put(lanes->list[i], item);
    }
}

void lanes_publish(struct lanes *lanes)
{
    for (size_t i = 0; i <= lanes->count; i++) {
        ring_publish(lanes->list[i]->ring);
    }
}

void lanes_wake(struct lanes *lanes)
{
    for (size_t i = 0; i <= lanes->count; i++) {
        ring_wake(lanes->list[i]->ring);
    }
}

/* --- While it runs --- */

static size_t count_living(const struct lanes *lanes)
{
    size_t n = 0;
    for (size_t i = 0; i < lanes->count; i++) {
        n += lanes->list[i]->end == LANE_LIVES ? 1u : 0u;
    }
    return n;
}

/* NULL: it is the run's end anyway. */
static const char *what_follows(const struct lanes *lanes)
{
    return count_living(lanes) > 0 ? "that output has ended, the others go on"
                                   : NULL;
}

/* A reader that has left is no failure, and the last one ends the run without a
 * word.
 * then: what follows from it, or NULL. */
static void tell_end(const struct lane *lane, const char *then, struct say *say)
{
    if (lane->end == LANE_FAILED) {
        say_error(say, "%s%s%s", lane->error.text, then != NULL ? ": " : "",
                  then != NULL ? then : "");
    } else if (lane->end == LANE_READER_LEFT && then != NULL) {
        say_warn(say, "the reader of %s has left: %s", lane_name(lane), then);
    }
}

/* cut_off: as a signal said so. */
static void tell_given_up(struct lane *lane, bool cut_off, const char *then,
                          struct say *say)
{
    say_error(say, "%s %s given up; what was written of it is incomplete%s%s",
              lane_name(lane),
              cut_off ? "was waited for and is" : "makes no progress and is",
              then != NULL ? ": " : "", then != NULL ? then : "");
}

/* Losses of a recording are reported even with --quiet. */
static void tell_drops(struct lane *lane, struct say *say, int64_t now_ns)
{
    if (lane->end != LANE_LIVES ||
        !say_is_due(&lane->told, lane->dropped, now_ns)) {
        return;
    }
    if (lane->kind == LANE_RECORDING) {
        say_error(say,
                  "%s is too slow for the data: %" PRIu64
                  " datagrams are missing from this recording so far; record "
                  "to a faster disk, or try a larger --buffer",
                  lane_name(lane), lane->dropped);
    } else if (lane->kind == LANE_POINTS) {
        say_warn(say,
                 "%s is too slow for the data: %" PRIu64
                 " datagrams are missing from it so far; write less (--eye, "
                 "--frames, only a pcap), to a faster disk, or try --buffer",
                 lane_name(lane), lane->dropped);
    } else {
        say_warn(say,
                 "this machine is too busy for the data: %" PRIu64
                 " datagrams are missing from the summary so far",
                 lane->dropped);
    }
}

/* Files that are lost are told even with --quiet. */
static void tell_lost(struct lane *lane, struct say *say)
{
    lum_error lost;
    while (lane_take_lost(lane, &lost)) {
        say_error(say, "%s", lost.text);
    }
}

static void watch_output(struct lanes *lanes, struct lane *lane,
                         struct say *say, int64_t now_ns)
{
    tell_lost(lane, say);
    if (lane_look(lane, now_ns)) {
        tell_end(lane, what_follows(lanes), say);
    }
    tell_drops(lane, say, now_ns);
    if (count_living(lanes) > 1
            ? lane->kind != LANE_RECORDING &&
                  lane_stands_still(lane, now_ns, STALL_NS)
            : lanes->has_laser && lane_is_unread(lane, now_ns, UNREAD_NS)) {
        lane_drop(lane, now_ns);
        tell_given_up(lane, false, what_follows(lanes), say);
    }
}

static void watch_summary(struct lane *lane, struct say *say, int64_t now_ns)
{
    if (lane_look(lane, now_ns)) {
        tell_end(lane, NULL, say);
    }
    tell_drops(lane, say, now_ns);
}

bool lanes_watch(struct lanes *lanes, struct say *say, int64_t now_ns)
{
    for (size_t i = 0; i < lanes->count; i++) {
        watch_output(lanes, lanes->list[i], say, now_ns);
    }
    watch_summary(lanes->summary, say, now_ns);
    return lanes->count == 0 || count_living(lanes) > 0;
}

uint64_t lanes_dropped(const struct lanes *lanes)
{
    uint64_t n = 0;
    for (size_t i = 0; i <= lanes->count; i++) {
        n += lanes->list[i]->dropped;
    }
    return n;
}

static unsigned level(const struct lane *lane)
{
    return lane->end == LANE_LIVES ? (unsigned)(ring_level(lane->ring) * 100u /
                                                ring_size(lane->ring))
                                   : 0;
}

unsigned lanes_level(const struct lanes *lanes)
{
    unsigned most = 0;
    for (size_t i = 0; i <= lanes->count; i++) {
        const unsigned one = level(lanes->list[i]);
        most = one > most ? one : most;
    }
    return most;
}

/* --- The end --- */

static bool has_time(const struct lane *lane, int64_t now_ns, int64_t began_ns)
{
    const int64_t still_ns = now_ns - lane->moves.at_ns;
    return lane->target == LANE_FILE
               ? still_ns < FILE_NS
               : still_ns < PIPE_NS && now_ns - began_ns < PIPE_TOTAL_NS;
}

/* How the end began. */
struct ending {
    int64_t began_ns;
    unsigned signals; /* so many had come */
    int64_t cut_ns;   /* when another was seen; 0: none */
};

/* Whether it is to be waited for any longer. */
static bool is_pending(struct lanes *lanes, struct lane *lane, struct say *say,
                       int64_t now_ns, const struct ending *ending)
{
    const int64_t began_ns = ending->began_ns;
    if (lane_look(lane, now_ns)) {
        tell_end(lane, NULL, say);
    }
    if (lane->end != LANE_LIVES) {
        return false;
    }
    const bool cut_off =
        ending->cut_ns != 0 && now_ns - ending->cut_ns >= CUT_NS;
    if (cut_off || !has_time(lane, now_ns, began_ns)) {
        lane_drop(lane, now_ns);
        tell_given_up(lane, cut_off, NULL, say);
        return false;
    }
    if (!lanes->is_waiting && now_ns - began_ns > TOLD_NS) {
        lanes->is_waiting = true;
        say_warn(say, "waiting for %s to be written; Ctrl-C gives it up",
                 lane_name(lane));
    }
    return true;
}

void lanes_finish(struct lanes *lanes, bool keep)
{
    for (size_t i = 0; i <= lanes->count; i++) {
        if (lanes->list[i]->end == LANE_LIVES) {
            lane_finish(lanes->list[i], keep);
        }
    }
}

/* The summary's lane waits only for its turn. */
static bool is_summary_pending(struct lanes *lanes, struct say *say,
                               int64_t now_ns)
{
    watch_summary(lanes->summary, say, now_ns);
    return lanes->summary->end == LANE_LIVES;
}

void lanes_end(struct lanes *lanes, struct say *say)
{
    struct ending ending = {.began_ns = lum_time_monotonic_ns(),
                            .signals = interrupt_count()};
    int64_t now_ns = ending.began_ns;
    bool waits = true;
    for (size_t i = 0; i < lanes->count; i++) {
        lanes->list[i]->moves.at_ns = now_ns;
    }
    for (; waits; now_ns = lum_time_monotonic_ns()) {
        if (ending.cut_ns == 0 && interrupt_count() != ending.signals) {
            ending.cut_ns = now_ns;
        }
        waits = is_summary_pending(lanes, say, now_ns);
        for (size_t i = 0; i < lanes->count; i++) {
            waits |= is_pending(lanes, lanes->list[i], say, now_ns, &ending);
            tell_lost(lanes->list[i], say);
        }
        say_flush(say);
        if (waits) {
            lum_time_sleep_until(now_ns + LOOK_NS);
        }
    }
}

bool lanes_have_failed(const struct lanes *lanes)
{
    bool have = false;
    for (size_t i = 0; i <= lanes->count; i++) {
        have |= lanes->list[i]->end >= LANE_FAILED;
    }
    return have;
}

bool lanes_have_no_reader(const struct lanes *lanes)
{
    bool have = lanes->count > 0;
    for (size_t i = 0; i < lanes->count; i++) {
        have &= lanes->list[i]->end == LANE_READER_LEFT;
    }
    return have;
}

void lanes_note_left_out(const struct lanes *lanes, struct summary *summary)
{
    struct summary_outputs *all = &summary->outputs;
    for (size_t i = 0; i < lanes->count; i++) {
        const struct pass *pass = &lanes->list[i]->own;
        const struct summary_outputs *one = &pass->summary.outputs;
        if (lanes->list[i]->runs) {
            continue;
        }
        if (one->left_out_count > 0) {
            all->left_out[all->left_out_count++] = one->left_out[0];
        }
        if (one->drawn_count > 0) {
            all->drawn[all->drawn_count++] = one->drawn[0];
        }
        outputs_add_retention(&all->retention, &pass->notes.retention);
    }
}

bool lanes_free(struct lanes *lanes)
{
    bool is_all = true;
    for (size_t i = 0; i <= lanes->count; i++) {
        is_all &= lane_free(lanes->list[i]);
    }
    return is_all;
}
