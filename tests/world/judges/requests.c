/* Requests are sent and repeated as the manual page says, and heartbeats come
 * several times a second from a program that owns a sensor. */
#include "judge.h"

#include <string.h>

static const char number[] = "one-number";
static const char tries[] = "tries";
static const char hurry[] = "pause-of-tries";
static const char gap[] = "heartbeat-gap";

/* Several a second (docs/protocol.md, section 6): five if nothing is said; two
 * may be late. */
#define GAP_NS (1000 * RECORD_MS)

static bool is_single(const record_tool *tool)
{
    static const char *const words[] = {
        "status",  "power",  "threshold", "lines", "yscan",
        "holdoff", "offset", "send",      "tlv",   "laser"};
    if (!record_is_program(tool, "lumctl") || record_watches(tool) ||
        strcmp(record_word(tool, 1), "off") == 0) {
        return false;
    }
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(record_word(tool, 0), words[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Whether a packet is the request's own: what takes a laser on back, or insists
 * on an off, is another. */
static bool is_own(const record_tool *tool, const record_datagram *d)
{
    const bool is_poll = strcmp(record_word(tool, 0), "status") == 0;
    return d->packet == RECORD_IS_TLV && !d->is_copy &&
           strcmp(record_word(tool, 1), "d") != 0 &&
           strcmp(d->command, "d") != 0 && is_poll == (d->command[0] == '\0');
}

static const record_datagram *next_try(const struct record *record, int index,
                                       size_t *at)
{
    while (*at < record->datagram_count) {
        const record_datagram *d = &record->datagrams[(*at)++];
        if (d->sender == index && is_own(&record->tools[index], d)) {
            return d;
        }
    }
    return NULL;
}

/* A stop right before a try makes it late, and the next one comes when it is
 * due. */
#define SENDS_NS (1 * RECORD_MS)

static bool was_held_up(const record_tool *tool, const record_datagram *d)
{
    return record_stopped_ns(tool, d->sent_ns - SENDS_NS, d->sent_ns) > 0;
}

static void judge_tries(const struct record *record, int index,
                        struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    const double timeout_ms = record_number(tool, "--timeout", 400);
    const int64_t pause_ns = (int64_t)(timeout_ms * 0.98e6);
    const unsigned most = (unsigned)record_number(tool, "--retries", 4) + 1;
    const record_datagram *before = NULL;
    const record_datagram *d = NULL;
    const record_datagram *first = NULL;
    unsigned count = 0;
    size_t at = 0;
    while ((d = next_try(record, index, &at)) != NULL) {
        first = first == NULL ? d : first;
        count++;
        if (before != NULL) {
            verdict_asked(out, number);
            verdict_asked(out, hurry);
            if (d->sequence != first->sequence) {
                verdict_broken(out, number, d->sent_ns,
                               "lumctl %s [%ld] repeats its request with "
                               "another number",
                               record_word(tool, 0), tool->id);
                return;
            }
            if (d->sent_ns - before->sent_ns < pause_ns &&
                !was_held_up(tool, before)) {
                verdict_broken(out, hurry, d->sent_ns,
                               "lumctl %s [%ld] repeats its request after %.3f "
                               "s already",
                               record_word(tool, 0), tool->id,
                               (double)(d->sent_ns - before->sent_ns) * 1e-9);
            }
        }
        before = d;
    }
    verdict_asked(out, tries);
    if (count > most) {
        verdict_broken(out, tries, tool->ended_ns,
                       "lumctl %s [%ld] sends its request %u times, not %u",
                       record_word(tool, 0), tool->id, count, most);
    }
}

/* What keeps an owner from sending, or is for its user to be without. */
static bool is_excused(const struct record *record, const record_tool *tool,
                       int64_t from_ns, int64_t to_ns)
{
    return !record_is_calm(record, "cable", from_ns, to_ns) ||
           !record_is_calm(record, "address", from_ns, to_ns) ||
           !record_is_calm(record, "slow-host", from_ns, to_ns) ||
           record_stopped_ns(tool, from_ns, to_ns) > 0 ||
           (record_is_program(tool, "lumctl") && tool->has_stalled);
}

struct pulse {
    const struct record *record;
    const record_tool *tool;
    int64_t most_ns;
    int64_t last_ns; /* -1: none is expected now */
    struct verdict *out;
};

static void check_gap(const struct pulse *p, int64_t t_ns)
{
    if (p->last_ns < 0) {
        return;
    }
    verdict_asked(p->out, gap);
    if (t_ns - p->last_ns > p->most_ns &&
        !is_excused(p->record, p->tool, p->last_ns, t_ns)) {
        verdict_broken(p->out, gap, t_ns,
                       "%s [%ld] sends no heartbeat for %.3f s",
                       p->tool->arguments[0], p->tool->id,
                       (double)(t_ns - p->last_ns) * 1e-9);
    }
}

static void take(struct pulse *p, const record_datagram *d)
{
    if (d->packet == RECORD_IS_HEARTBEAT) {
        check_gap(p, d->sent_ns);
        p->last_ns = d->sent_ns;
    } else if (d->packet == RECORD_IS_TLV && strcmp(d->command, "d") == 0) {
        p->last_ns = -1; /* during laser off none are sent, and at the end */
    }
}

/* Until it is to end by itself or is told to. */
static void judge_gaps(const struct record *record, int index,
                       struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    const double rate = record_number(tool, "--rate", 5.0);
    struct pulse p = {record, tool, GAP_NS + (int64_t)(1e9 / rate), -1, out};
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && !d->is_copy) {
            take(&p, d);
        }
    }
    if (record_option(tool, "--duration") == NULL &&
        tool->ended_ns == RECORD_NEVER &&
        record_asked_to_end(tool) == RECORD_NEVER) {
        check_gap(&p, record->now_ns);
    }
}

void judge_requests(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        if (is_single(&record->tools[i])) {
            judge_tries(record, (int)i, out);
        }
        if (record_owns(&record->tools[i])) {
            judge_gaps(record, (int)i, out);
        }
    }
}
