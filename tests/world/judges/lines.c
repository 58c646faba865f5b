/* Each line that is typed into a shell: what it reports is true (done.c), in
 * time, and what nothing keeps from being done is done. */
#include "judge.h"
#include "shell.h"

#include <string.h>

static const char late[] = "line-in-time";
static const char typed[] = "line-typed";
static const char calm[] = "line-in-calm";
static const char room[] = "room-for-all";

static bool is_signalled(const record_tool *tool, int64_t from_ns,
                         int64_t to_ns)
{
    for (unsigned i = 0; i < tool->signal_count; i++) {
        const int64_t t_ns = tool->signals[i].t_ns;
        if (t_ns >= from_ns && t_ns <= to_ns) {
            return true;
        }
    }
    return false;
}

/* The longest that needs no second try: laser off looks again after 0.3 s, time
 * asks eight times. A shell that reads lines together waits between them. */
#define CALM_NS (2500 * RECORD_MS)

/* Nothing befalls it from before it is begun until it is due. */
static bool is_calm(const struct record *record, const record_tool *tool,
                    const shell_line *line)
{
    const int64_t from_ns = line->as.began_ns - 2 * RECORD_S;
    const int64_t to_ns = line->as.began_ns + CALM_NS;
    const bool lives = tool->ended_ns > to_ns &&
                       record_asked_to_end(tool) > to_ns &&
                       record_stopped_ns(tool, from_ns, to_ns) == 0 &&
                       !is_signalled(tool, from_ns, to_ns);
    return lives && !tool->has_stalled && !tool->met_others &&
           record_answers(record, record_host_of(tool), from_ns, to_ns) &&
           record_is_calm(record, NULL, from_ns, to_ns);
}

/* The laser has reasons of its own not to come on. */
static bool has_to_be_done(const shell_line *line)
{
    return line->kind == SHELL_SETTING || line->kind == SHELL_STATUS ||
           line->kind == SHELL_TIME ||
           (line->kind == SHELL_LASER &&
            strcmp(record_word(&line->as, 1), "off") == 0);
}

static void judge_time(const record_tool *tool, const shell_line *line,
                       struct verdict *out)
{
    if (!line->is_done || tool->has_stalled) {
        return;
    }
    verdict_asked(out, late);
    verdict_asked(out, typed);
    if (line->as.ended_ns > line->due_ns) {
        verdict_broken(out, late, line->as.ended_ns,
                       "shell [%ld] reports %s %s, typed at %.3f s, as done "
                       "%.3f s after its limit",
                       tool->id, record_word(&line->as, 0),
                       record_word(&line->as, 1), (double)line->typed_ns * 1e-9,
                       (double)(line->as.ended_ns - line->due_ns) * 1e-9);
    }
}

static void judge_line(const struct record *record, const record_tool *tool,
                       const shell_line *line, struct verdict *out)
{
    judge_time(tool, line, out);
    if (!has_to_be_done(line) || !is_calm(record, tool, line)) {
        return;
    }
    verdict_asked(out, calm);
    if (!line->is_done || line->as.ended_ns > line->as.began_ns + CALM_NS) {
        verdict_broken(out, calm, line->as.began_ns + CALM_NS,
                       "shell [%ld] does not report %s %s, typed at %.3f s, "
                       "though nothing is wrong",
                       tool->id, record_word(&line->as, 0),
                       record_word(&line->as, 1),
                       (double)line->typed_ns * 1e-9);
    }
}

static void judge_shell(const struct record *record, const record_tool *tool,
                        struct verdict *out)
{
    static struct shell shell; /* too large for a stack */
    shell_read(record, tool, &shell);
    if (shell.is_full) {
        verdict_broken(out, room, tool->began_ns,
                       "the judges' table of lines of a shell is full");
    }
    for (size_t i = 0; i < shell.count; i++) {
        judge_line(record, tool, &shell.lines[i], out);
    }
    if (shell.count > 0 && shell.unclaimed > 0) {
        verdict_broken(out, typed, tool->ended_ns,
                       "shell [%ld] reports %u lines as done that nobody typed",
                       tool->id, shell.unclaimed);
    }
    shell_free(&shell);
}

void judge_lines(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        if (shell_is_one(&record->tools[i])) {
            judge_shell(record, &record->tools[i], out);
        }
    }
}
