/* Exit statuses are those of the manual pages (docs/man, EXIT STATUS), and say
 * what was. */
#include "judge.h"

#include <signal.h>
#include <string.h>
#include <sys/wait.h>

static const char known[] = "status-known";
static const char by_signal[] = "ends-by-signal";
static const char refused[] = "status-2";
static const char silent[] = "status-3";
static const char hazard[] = "status-4";
static const char fine[] = "status-0";
static const char calm[] = "answers-in-calm";
static const char outputs[] = "status-of-outputs";

#define HAZARDS  0x01ffu /* docs/protocol.md, section 5 */
#define IDLE_BIT 0x0010u /* HEARTBEAT_TIMEOUT alone is no hazard: idle */

/* lumctl 0 to 4, lumdump and lumview 0 to 3, lumsim 0 to 2. */
static int highest(const record_tool *tool)
{
    if (record_is_program(tool, "lumctl")) {
        return 4;
    }
    return record_is_program(tool, "lumsim") ? 2 : 3;
}

static bool is_word(const record_tool *tool, const char *word)
{
    return record_is_program(tool, "lumctl") &&
           strcmp(record_word(tool, 0), word) == 0;
}

/* --- 2: bad arguments --- */

/* set-ip refuses what would strand the sensor, which depends on the network; a
 * shell ends with the status of a line; a sweep may not be able to read its
 * plan. */
static void judge_refused(const record_tool *tool, int status,
                          struct verdict *out)
{
    if (tool->is_wrong) {
        verdict_asked(out, refused);
    }
    if (tool->is_wrong != (status == 2) &&
        !(status == 2 && (is_word(tool, "set-ip") || is_word(tool, "shell") ||
                          is_word(tool, "sweep")))) {
        verdict_broken(out, refused, tool->ended_ns,
                       "%s %s [%ld] ends with %d: its arguments are %s",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       status, tool->is_wrong ? "bad" : "good");
    }
}

/* --- 3: no answer --- */

/* One request, whose answer ends it. */
static bool is_single(const record_tool *tool)
{
    static const char *const words[] = {"status", "power", "threshold",
                                        "lines",  "yscan", "holdoff",
                                        "offset", "send",  "tlv"};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (is_word(tool, words[i])) {
            return !record_watches(tool);
        }
    }
    return false;
}

static bool sent_sequence(const struct record *record, int index,
                          uint32_t sequence)
{
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && d->packet == RECORD_IS_TLV &&
            d->sequence == sequence) {
            return true;
        }
    }
    return false;
}

/* One that is stopped meanwhile may give up as soon as it goes on. */
static int64_t end_of_tries(const record_tool *tool, int64_t from_ns,
                            int64_t wait_ns)
{
    int64_t end_ns = from_ns + wait_ns;
    for (unsigned i = 0; i < tool->stop_count; i++) {
        const record_span s = tool->stops[i];
        if (s.to_ns > from_ns && s.from_ns < end_ns) {
            end_ns = s.from_ns;
        }
    }
    return end_ns;
}

/* When lumctl stopped waiting for an answer to its request at the latest: its
 * tries are over, or it switches off what it may have switched on, which can be
 * late if it cannot send. */
static int64_t gave_up(const struct record *record, int index)
{
    const record_tool *tool = &record->tools[index];
    const bool is_off = strcmp(record_word(tool, 1), "d") == 0;
    const double tries = record_number(tool, "--retries", 4) + 1;
    const double wait_ms = tries * record_number(tool, "--timeout", 400);
    int64_t until_ns = RECORD_NEVER;
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender != index || d->packet != RECORD_IS_TLV) {
            continue;
        }
        if (until_ns == RECORD_NEVER) {
            until_ns = end_of_tries(tool, d->sent_ns, (int64_t)(wait_ms * 1e6));
        }
        if (!is_off && strcmp(d->command, "d") == 0) {
            return d->sent_ns < until_ns ? d->sent_ns : until_ns;
        }
    }
    return until_ns;
}

/* Until when data would have ended a session's wait for it; what comes during
 * laser off is too late. */
static int64_t waits_until(const record_tool *tool)
{
    const double s = record_is_program(tool, "lumctl")
                         ? record_number(tool, "--duration", 4.9)
                         : 4.9;
    return tool->began_ns + (int64_t)((s < 4.9 ? s : 4.9) * 1e9);
}

static bool is_answer(const struct record *record, int index,
                      const record_datagram *d)
{
    const record_tool *tool = &record->tools[index];
    if (is_single(tool)) {
        return d->packet == RECORD_IS_TLV &&
               d->fate_ns < gave_up(record, index) &&
               sent_sequence(record, index, d->sequence);
    }
    return record_owns(tool) && !is_word(tool, "shell") &&
           !is_word(tool, "sweep") && d->packet == RECORD_IS_DATA &&
           d->fate_ns < waits_until(tool) &&
           d->fate_ns < record_asked_to_end(tool);
}

/* What a tool read that belies its status 3. */
static const record_datagram *find_answer(const struct record *record,
                                          int index)
{
    const record_tool *tool = &record->tools[index];
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->reader == index && d->fate == RECORD_READ && !d->is_damaged &&
            d->from.address == record_host_of(tool) &&
            is_answer(record, index, d)) {
            return d;
        }
    }
    return NULL;
}

static void judge_silent(const struct record *record, int index,
                         struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    const record_datagram *d = find_answer(record, index);
    verdict_asked(out, silent);
    if (d != NULL) {
        verdict_broken(out, silent, tool->ended_ns,
                       "%s %s [%ld] says that nothing answered, and read "
                       "datagram %llu at %.3f s",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       (unsigned long long)d->number,
                       (double)d->fate_ns * 1e-9);
    }
}

/* --- In calm: a sensor that can answer does --- */

/* All the time, with nothing that could explain it. */
static bool is_calm(const struct record *record, const record_tool *tool)
{
    const int64_t from_ns = tool->began_ns - 2 * RECORD_S;
    return record_answers(record, record_host_of(tool), from_ns,
                          tool->ended_ns) &&
           record_is_calm(record, NULL, from_ns, tool->ended_ns) &&
           tool->stop_count == 0 && tool->signal_count == 0 &&
           !tool->has_stalled && !record_is_shared(record, tool);
}

/* A request may be refused, with status 1; the dice ask for nothing that would
 * be. Laser on has other reasons. */
static void judge_in_calm(const struct record *record, const record_tool *tool,
                          int status, struct verdict *out)
{
    const bool is_recording =
        record_is_program(tool, "lumdump") && record_owns(tool);
    const bool is_asking = is_single(tool) && !is_word(tool, "send");
    if ((!is_recording && !is_asking) || tool->is_wrong ||
        !is_calm(record, tool)) {
        return;
    }
    verdict_asked(out, calm);
    if (status == 3 || (is_asking && status == 1)) {
        verdict_broken(out, calm, tool->ended_ns,
                       "%s %s [%ld] ends with %d, and nothing was wrong",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       status);
    }
}

/* An output that failed is told by the status too. */
static void judge_outputs(const record_tool *tool, int status,
                          struct verdict *out)
{
    if (!record_is_program(tool, "lumdump") || tool->out == NULL ||
        (strstr(tool->out, "\"end\": \"failed\"") == NULL &&
         strstr(tool->out, "\"end\": \"stalled\"") == NULL)) {
        return;
    }
    verdict_asked(out, outputs);
    if (status != 1) {
        verdict_broken(out, outputs, tool->ended_ns,
                       "lumdump [%ld] says that an output failed, and ends "
                       "with %d",
                       tool->id, status);
    }
}

/* --- 4: a hazard --- */

static bool had(const struct record *record, const record_tool *tool,
                unsigned bits, bool always)
{
    for (size_t i = 0; i < record->device_count; i++) {
        const record_device *d = &record->devices[i];
        bool is_so = (record_status_at(d, tool->began_ns) & bits) != 0;
        for (size_t k = 0; k < d->count; k++) {
            const record_line *l = &d->lines[k];
            if (l->event == RECORD_STATUS && l->t_ns >= tool->began_ns &&
                l->t_ns <= tool->ended_ns) {
                const bool has = (l->status & bits) != 0;
                is_so = always ? is_so && has : is_so || has;
            }
        }
        if (is_so != always) {
            return is_so;
        }
    }
    return always;
}

static void judge_hazard(const struct record *record, const record_tool *tool,
                         int status, struct verdict *out)
{
    if (status == 4) {
        verdict_asked(out, hazard);
        if (!had(record, tool, HAZARDS, false)) {
            verdict_broken(out, hazard, tool->ended_ns,
                           "lumctl %s [%ld] ends with 4, and there was no "
                           "hazard",
                           record_word(tool, 0), tool->id);
        }
    } else if (status == 0 && is_word(tool, "status") &&
               !record_watches(tool)) {
        verdict_asked(out, fine);
        if (record->device_count > 0 &&
            had(record, tool, HAZARDS & ~IDLE_BIT, true)) {
            verdict_broken(out, fine, tool->ended_ns,
                           "lumctl status [%ld] ends with 0 during a hazard",
                           tool->id);
        }
    }
}

/* --- */

static void judge_end(const record_tool *tool, struct verdict *out)
{
    const int number = WTERMSIG(tool->status);
    verdict_asked(out, by_signal);
    if (!record_was_signalled(tool, number) &&
        !(number == SIGKILL && tool->was_cut)) {
        verdict_broken(out, by_signal, tool->ended_ns,
                       "%s %s [%ld] ends by signal %d, which nobody sent",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       number);
    }
}

void judge_status(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        const int status = record_exit_status(tool);
        if (tool->ended_ns == RECORD_NEVER) {
            continue;
        }
        if (status < 0) {
            judge_end(tool, out);
            continue;
        }
        verdict_asked(out, known);
        if (status > highest(tool)) {
            verdict_broken(out, known, tool->ended_ns,
                           "%s [%ld] ends with %d, which no manual page has",
                           tool->arguments[0], tool->id, status);
        }
        judge_refused(tool, status, out);
        judge_outputs(tool, status, out);
        if (tool->met_others) {
            continue;
        }
        judge_in_calm(record, tool, status, out);
        if (status == 3) {
            judge_silent(record, (int)i, out);
        }
        if (record_is_undamaged(record, tool->began_ns, tool->ended_ns)) {
            judge_hazard(record, tool, status, out);
        }
    }
}
