/* The counters of the tools are those of the world. */
#include "judge.h"

#include <string.h>

static const char counts[] = "counts";
static const char wire[] = "counts-of-outputs";

struct tally {
    uint64_t received, foreign, dropped, bytes, beats;
};

/* One that came to the tool's socket. */
static void take_in(struct tally *t, const record_datagram *d,
                    record_endpoint sensor)
{
    const bool is_sensors = record_is_same(d->from, sensor);
    if (d->fate == RECORD_DROPPED) {
        t->dropped++;
    } else if (d->fate == RECORD_READ && is_sensors) {
        t->received++;
        t->bytes += d->len;
    } else if (d->fate == RECORD_READ) {
        t->foreign++;
    }
}

static bool is_beat(const record_datagram *d, int index)
{
    return d->sender == index && !d->is_copy &&
           d->packet == RECORD_IS_HEARTBEAT;
}

/* What the world saw of a tool until a moment. */
static struct tally count(const struct record *record, int index,
                          int64_t until_ns)
{
    struct tally t = {0};
    const record_endpoint sensor = {
        record_host_of(&record->tools[index]),
        (uint16_t)record_port_of(&record->tools[index])};
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        t.beats += is_beat(d, index) ? 1 : 0;
        if (d->reader == index && d->fate_ns <= until_ns) {
            take_in(&t, d, sensor);
        }
    }
    return t;
}

static int64_t last_beat_ns(const struct record *record, int index)
{
    int64_t last_ns = 0;
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && d->packet == RECORD_IS_HEARTBEAT) {
            last_ns = d->sent_ns;
        }
    }
    return last_ns;
}

/* When a recording stopped counting: a session that switches the laser off
 * reads on for that, from its n-th number of a `d` behind the last heartbeat.
 */
static int64_t counted_until(const struct record *record, int index, unsigned n)
{
    const int64_t beat_ns = last_beat_ns(record, index);
    uint32_t sequence = 0;
    unsigned seen = 0;
    if (record_option(&record->tools[index], "--laser") == NULL) {
        return RECORD_NEVER;
    }
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender != index || d->sent_ns < beat_ns ||
            d->packet != RECORD_IS_TLV || strcmp(d->command, "d") != 0 ||
            (seen > 0 && d->sequence == sequence)) {
            continue;
        }
        sequence = d->sequence;
        if (seen++ == n) {
            return d->sent_ns;
        }
    }
    return RECORD_NEVER;
}

static void compare(const record_tool *tool, const char *key, uint64_t said,
                    uint64_t least, uint64_t most, struct verdict *out)
{
    if (said < least || said > most) {
        verdict_broken(out, counts, tool->ended_ns,
                       "%s [%ld] says %s: %llu, and it was %llu",
                       tool->arguments[0], tool->id, key,
                       (unsigned long long)said,
                       (unsigned long long)(said < least ? least : most));
    }
}

static bool counts_fit(const record_tool *tool, const struct tally *t)
{
    uint64_t received = 0;
    uint64_t foreign = 0;
    (void)record_json_number(tool->out, "received", &received);
    (void)record_json_number(tool->out, "foreign_source", &foreign);
    return received == t->received && foreign == t->foreign;
}

/* A `d` that the host could not send says nothing. */
static bool is_without_end(const struct record *record, int index)
{
    const record_tool *tool = &record->tools[index];
    const int64_t from_ns = last_beat_ns(record, index);
    return !record_is_calm(record, "address", from_ns, tool->ended_ns) ||
           !record_is_calm(record, "cable", from_ns, tool->ended_ns);
}

/* A `d` that a hazard asked for may come right before that of the end. */
static struct tally count_recorded(const struct record *record, int index)
{
    const record_tool *tool = &record->tools[index];
    const struct tally first =
        count(record, index, counted_until(record, index, 0));
    if (counts_fit(tool, &first)) {
        return first;
    }
    const struct tally second =
        count(record, index, counted_until(record, index, 1));
    return counts_fit(tool, &second) ? second : first;
}

/* In each output: what it took and what its buffer dropped is what came. */
static void judge_outputs(const record_tool *tool, uint64_t received,
                          struct verdict *out)
{
    const char *at = strstr(tool->out, "\"outputs\":");
    while (at != NULL && (at = strstr(at, "\"end\":")) != NULL) {
        uint64_t took = 0;
        uint64_t dropped = 0;
        if (strstr(at, "\"done\"") == NULL ||
            !record_json_number(at, "datagrams", &took) ||
            !record_json_number(at, "dropped", &dropped)) {
            return;
        }
        const char *end = at + strlen("\"end\":");
        end += strspn(end, " ");
        if (strncmp(end, "\"done\"", 6) == 0) {
            verdict_asked(out, wire);
            if (took + dropped != received) {
                verdict_broken(out, wire, tool->ended_ns,
                               "lumdump [%ld]: an output took %llu and dropped "
                               "%llu of %llu",
                               tool->id, (unsigned long long)took,
                               (unsigned long long)dropped,
                               (unsigned long long)received);
            }
        }
        at = end;
    }
}

static void judge_recording_counts(const struct record *record, int index,
                                   struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    uint64_t received = 0;
    uint64_t n = 0;
    if (!record_json_number(tool->out, "received", &received)) {
        return;
    }
    verdict_asked(out, counts);
    const struct tally t = count_recorded(record, index);
    const struct tally all = count(record, index, RECORD_NEVER);
    const struct tally least =
        count(record, index, last_beat_ns(record, index));
    const bool is_open = is_without_end(record, index);
    compare(tool, "received", received, is_open ? least.received : t.received,
            is_open ? all.received : t.received, out);
    if (record_json_number(tool->out, "foreign_source", &n)) {
        compare(tool, "foreign_source", n, is_open ? least.foreign : t.foreign,
                is_open ? all.foreign : t.foreign, out);
    }
    if (record_json_number(tool->out, "kernel_drops", &n)) {
        compare(tool, "kernel_drops", n, least.dropped, all.dropped, out);
    }
    if (record_json_number(tool->out, "heartbeats_sent", &n)) {
        compare(tool, "heartbeats_sent", n, all.beats, all.beats, out);
    }
    judge_outputs(tool, received, out);
}

/* Behind the lines of --every stands its sum. */
static void judge_heartbeat_counts(const struct record *record, int index,
                                   struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    const struct tally t = count(record, index, RECORD_NEVER);
    const char *said = strstr(tool->out, "\"duration_s\":");
    uint64_t n = 0;
    if (!record_json_number(said, "heartbeats", &n)) {
        return;
    }
    verdict_asked(out, counts);
    compare(tool, "heartbeats", n, t.beats, t.beats, out);
    if (record_json_number(said, "packets", &n)) {
        compare(tool, "packets", n, t.received, t.received, out);
    }
    if (record_json_number(said, "bytes", &n)) {
        compare(tool, "bytes", n, t.bytes, t.bytes, out);
    }
    if (record_json_number(said, "kernel_drops", &n)) {
        compare(tool, "kernel_drops", n, t.dropped, t.dropped, out);
    }
}

void judge_counts(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        if (tool->ended_ns == RECORD_NEVER || tool->out == NULL ||
            !record_owns(tool)) {
            continue;
        }
        if (record_is_program(tool, "lumdump")) {
            judge_recording_counts(record, (int)i, out);
        } else if (strcmp(record_word(tool, 0), "heartbeat") == 0) {
            judge_heartbeat_counts(record, (int)i, out);
        }
    }
}
