/* Two owners of one sensor on one host are told of each other: the second one
 * does not begin, and says who has the session (docs/man/lumdump.1, A SENSOR).
 * The protocol has no way to tell owners on two hosts. */
#include "judge.h"

#include <string.h>

static const char alone[] = "one-owner";
static const char told[] = "owner-told";
static const char invented[] = "owner-invented";

static const char text[] = "has the session with";

struct beats {
    int64_t first_ns, last_ns;
};

static struct beats beats_of(const struct record *record, int index,
                             uint32_t to)
{
    struct beats b = {RECORD_NEVER, -1};
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && d->packet == RECORD_IS_HEARTBEAT &&
            d->to.address == to) {
            b.first_ns = d->sent_ns < b.first_ns ? d->sent_ns : b.first_ns;
            b.last_ns = d->sent_ns;
        }
    }
    return b;
}

/* On one host and by one interface. */
static bool are_rivals(const record_tool *a, const record_tool *b)
{
    return a->host == b->host && record_owns(a) && record_owns(b) &&
           record_host_of(a) == record_host_of(b) &&
           record_option(a, "--interface") == NULL &&
           record_option(b, "--interface") == NULL;
}

static void judge_both(const struct record *record, int a, int b,
                       struct verdict *out)
{
    const uint32_t to = record_host_of(&record->tools[a]);
    const struct beats first = beats_of(record, a, to);
    const struct beats second = beats_of(record, b, to);
    verdict_asked(out, alone);
    if (first.last_ns > second.first_ns && second.last_ns > first.first_ns) {
        verdict_broken(out, alone, second.first_ns,
                       "%s [%ld] and %s [%ld] both send heartbeats",
                       record->tools[a].arguments[0], record->tools[a].id,
                       record->tools[b].arguments[0], record->tools[b].id);
    }
}

/* A sweep looks at its plan and its folder first, which may be all that it
 * comes to. */
static bool is_elsewhere(const record_tool *tool)
{
    return strcmp(record_word(tool, 0), "sweep") == 0;
}

/* b begins while a has the session, and until it ends. */
static void judge_second(const struct record *record, int a, int b,
                         struct verdict *out)
{
    const record_tool *tool = &record->tools[b];
    const struct beats first =
        beats_of(record, a, record_host_of(&record->tools[a]));
    if (tool->ended_ns == RECORD_NEVER || record_exit_status(tool) < 0 ||
        tool->is_wrong || tool->err == NULL ||
        first.first_ns > tool->began_ns || first.last_ns < tool->ended_ns ||
        is_elsewhere(tool)) {
        return;
    }
    verdict_asked(out, told);
    if (record_exit_status(tool) != 1 || strstr(tool->err, text) == NULL) {
        verdict_broken(out, told, tool->ended_ns,
                       "%s [%ld] began while [%ld] had the session, ended "
                       "with %d, and was not told",
                       tool->arguments[0], tool->id, record->tools[a].id,
                       record_exit_status(tool));
    }
}

static bool takes_sessions(const record_tool *tool)
{
    return record_owns(tool) || strcmp(record_word(tool, 0), "doctor") == 0;
}

static void judge_told(const struct record *record, int index,
                       struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    if (tool->err == NULL || strstr(tool->err, text) == NULL) {
        return;
    }
    verdict_asked(out, invented);
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *other = &record->tools[i];
        if (other != tool && other->host == tool->host &&
            takes_sessions(other) && other->began_ns <= tool->ended_ns &&
            other->ended_ns >= tool->began_ns) {
            return;
        }
    }
    verdict_broken(out, invented, tool->ended_ns,
                   "%s [%ld] says that another has the session, and none is "
                   "there",
                   tool->arguments[0], tool->id);
}

void judge_owners(const struct record *record, struct verdict *out)
{
    for (size_t a = 0; a < record->tool_count; a++) {
        judge_told(record, (int)a, out);
        for (size_t b = a + 1; b < record->tool_count; b++) {
            if (are_rivals(&record->tools[a], &record->tools[b])) {
                judge_both(record, (int)a, (int)b, out);
                judge_second(record, (int)a, (int)b, out);
            }
        }
    }
}
