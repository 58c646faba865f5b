/* Exit statuses in calm, and after one signal (docs/man, EXIT STATUS). */
#include "judge.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

static const char calm[] = "status-in-calm";
static const char told[] = "status-of-signal";

static bool is_word(const record_tool *tool, const char *word)
{
    return record_is_program(tool, "lumctl") &&
           strcmp(record_word(tool, 0), word) == 0;
}

/* Another program has the session, and it says so. */
static bool is_second(const record_tool *tool)
{
    return tool->err != NULL &&
           strstr(tool->err, "has the session with") != NULL;
}

/* --- In calm --- */

/* Whether it ends with 0 if nothing is wrong. laser on and send have reasons of
 * the sensor's not to; status, find, show, save and doctor tell of more than
 * whether they are done; set-ip depends on the network. */
static bool has_to_succeed(const record_tool *tool)
{
    static const char *const words[] = {
        "power", "threshold", "lines", "holdoff", "offset", "yscan", "time"};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (is_word(tool, words[i])) {
            return true;
        }
    }
    if (is_word(tool, "laser")) {
        return strcmp(record_word(tool, 1), "off") == 0;
    }
    return record_owns(tool) && record_option(tool, "--duration") != NULL &&
           (!record_is_program(tool, "lumctl") ||
            record_option(tool, "--laser") == NULL);
}

static bool is_in_calm(const struct record *record, const record_tool *tool)
{
    const int64_t from_ns = tool->began_ns - 2 * RECORD_S;
    return tool->signal_count == 0 && tool->stop_count == 0 &&
           !tool->has_stalled && !tool->is_wrong && !tool->met_others &&
           !tool->was_cut && !is_second(tool) &&
           !record_is_shared(record, tool) &&
           record_answers(record, record_host_of(tool), from_ns,
                          tool->ended_ns) &&
           record_is_calm(record, NULL, from_ns, tool->ended_ns);
}

static void judge_calm(const struct record *record, const record_tool *tool,
                       struct verdict *out)
{
    if (!has_to_succeed(tool) || record_option(tool, "--dry-run") != NULL ||
        !is_in_calm(record, tool)) {
        return;
    }
    verdict_asked(out, calm);
    if (record_exit_status(tool) != 0) {
        verdict_broken(out, calm, tool->ended_ns,
                       "%s %s [%ld] ends with %d, and nothing was wrong",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       record_exit_status(tool));
    }
}

/* --- After one signal --- */

/* Those that end in good order; nohup's SIGHUP may have been ignored. */
static bool is_taken(const record_tool *tool, int number)
{
    return number == SIGINT || number == SIGTERM || number == SIGQUIT ||
           (number == SIGHUP && !record_is_program(tool, "lumctl"));
}

static bool has_begun(const struct record *record, int index, int64_t t_ns)
{
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && d->packet == RECORD_IS_HEARTBEAT &&
            d->sent_ns < t_ns) {
            return true;
        }
    }
    return false;
}

static bool has_data(const struct record *record, int index)
{
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->reader == index && d->packet == RECORD_IS_DATA &&
            d->fate == RECORD_READ) {
            return true;
        }
    }
    return false;
}

/* Steps that are missing are a failure, and not its usual end. */
static bool was_interrupted(const record_tool *tool)
{
    return is_word(tool, "sweep") && tool->err != NULL &&
           strstr(tool->err, "not all steps are done: ") != NULL;
}

/* An owner ends by itself, and says how. */
static void judge_owner(const struct record *record, int index,
                        struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    const int status = record_exit_status(tool);
    verdict_asked(out, told);
    if (WIFSIGNALED(tool->status) &&
        WTERMSIG(tool->status) == tool->signals[0].number &&
        !was_interrupted(tool)) {
        verdict_broken(out, told, tool->ended_ns,
                       "%s [%ld] ends by signal %d, not in good order",
                       tool->arguments[0], tool->id, tool->signals[0].number);
    } else if (status == 0 && record_is_program(tool, "lumdump") &&
               !has_data(record, index)) {
        verdict_broken(out, told, tool->ended_ns,
                       "lumdump [%ld] ends with 0 after a signal, and no data "
                       "had come",
                       tool->id);
    }
}

/* What was interrupted ends by the signal. */
static void judge_other(const record_tool *tool, struct verdict *out)
{
    if (tool->err == NULL ||
        strstr(tool->err, "lumctl: interrupted: whether") == NULL) {
        return;
    }
    verdict_asked(out, told);
    if (!WIFSIGNALED(tool->status)) {
        verdict_broken(out, told, tool->ended_ns,
                       "lumctl %s [%ld] was interrupted, and ends with %d",
                       record_word(tool, 0), tool->id,
                       record_exit_status(tool));
    }
}

static void judge_signalled(const struct record *record, int index,
                            struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    if (tool->signal_count != 1 || tool->was_cut || tool->has_stalled ||
        is_word(tool, "shell")) {
        return;
    }
    if (!record_owns(tool)) {
        judge_other(tool, out);
    } else if (is_taken(tool, tool->signals[0].number) &&
               has_begun(record, index, tool->signals[0].t_ns)) {
        judge_owner(record, index, out);
    }
}

void judge_ends(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        if (record->tools[i].ended_ns != RECORD_NEVER) {
            judge_calm(record, &record->tools[i], out);
            judge_signalled(record, (int)i, out);
        }
    }
}
