/* A command is reported done only if the device carried it out. */
#include "judge.h"
#include "shell.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char done[] = "done-true";
static const char on[] = "on-true";
static const char off[] = "off-true";
static const char twice[] = "off-seen-twice";
static const char taken[] = "taken-back";
static const char moved[] = "move-true";
static const char said[] = "status-true";
static const char same[] = "done-as-status";
static const char waited[] = "wait-true";

/* Between the two looks of laser off (docs/man/lumctl.1, laser off); the clocks
 * of two hosts may differ by their drift. */
#define APART_NS (295 * RECORD_MS)

/* The log of a device tells when it looked, which may be shortly before what it
 * then read was sent. */
#define LOG_NS (1 * RECORD_MS)

#define LASER_CMD_ON 0x0800u /* docs/protocol.md, section 5 */
#define HAZARDS      0x01efu /* but for HEARTBEAT_TIMEOUT alone: idle */

/* What one tool did at devices. */
struct deed {
    const struct record *record;
    const record_tool *sender; /* who sent it */
    const record_tool *tool;   /* the same, or a line that it was told */
    struct verdict *out;
};

static bool is_of(const struct deed *d, const record_line *line)
{
    return (line->event == RECORD_TLV || line->event == RECORD_SET_IP) &&
           line->t_ns >= d->tool->began_ns && line->t_ns <= d->tool->ended_ns &&
           record_sender(d->record, line->peer, line->t_ns + LOG_NS) ==
               d->sender;
}

/* What is looked for in the notes of a device. */
static bool is_poll(const record_line *line)
{
    return line->event == RECORD_TLV &&
           strncmp(line->text, "status poll", 11) == 0;
}

/* The last packet of the tool by which a device carried a command out, or
 * (NULL) was polled; NULL: none. */
static const record_line *find_last(const struct deed *d, const char *command,
                                    const record_device **device)
{
    const record_line *last = NULL;
    for (size_t i = 0; i < d->record->device_count; i++) {
        const record_device *at = &d->record->devices[i];
        for (size_t k = 0; k < at->count; k++) {
            const record_line *l = &at->lines[k];
            const bool fits =
                command != NULL ? record_was_done(l, command) : is_poll(l);
            if (fits && is_of(d, l)) {
                last = l;
                *device = at;
            }
        }
    }
    return last;
}

/* --- Settings --- */

static void require(const struct deed *d, const char *command)
{
    const record_device *device = NULL;
    verdict_asked(d->out, done);
    if (find_last(d, command, &device) == NULL) {
        verdict_broken(d->out, done, d->tool->ended_ns,
                       "lumctl [%ld] says that '%s' is done, and no sensor "
                       "did it",
                       d->tool->id, command);
    }
}

static void judge_on(const struct deed *d);

/* It was down at least once: another may switch it on again. */
static void judge_off_once(const struct deed *d)
{
    const record_device *device = NULL;
    verdict_asked(d->out, off);
    if (find_last(d, "d", &device) == NULL ||
        !record_laser_was(device, false, d->tool->began_ns,
                          d->tool->ended_ns)) {
        verdict_broken(d->out, off, d->tool->ended_ns,
                       "lumctl [%ld] says that d is done, and the laser was "
                       "on all the time",
                       d->tool->id);
    }
}

/* The last of u and d counts. */
static void require_each(const struct deed *d, const char *text)
{
    char last = ' ';
    char word[32];
    while (*text != '\0') {
        const size_t len = strcspn(text, " ");
        (void)snprintf(word, sizeof word, "%.*s", (int)len, text);
        if (strcmp(word, "u") == 0 || strcmp(word, "d") == 0) {
            last = word[0];
        } else {
            require(d, word);
        }
        text += len;
        text += strspn(text, " ");
    }
    if (last == 'u') {
        judge_on(d);
    } else if (last == 'd') {
        judge_off_once(d);
    }
}

/* Commands whose text is a number and a letter (docs/protocol.md, section 4).
 */
static bool find_setting(const record_tool *tool, char out[32])
{
    static const struct {
        const char *word, *second, *letter;
    } settings[] = {{"power", NULL, "p"},       {"threshold", "green", "g"},
                    {"threshold", "blue", "b"}, {"yscan", NULL, "y"},
                    {"holdoff", NULL, "h"},     {"offset", "green", "G"},
                    {"offset", "blue", "B"}};
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        const bool has_second = settings[i].second != NULL;
        const char *value = record_word(tool, has_second ? 2 : 1);
        if (strcmp(record_word(tool, 0), settings[i].word) == 0 &&
            *value != '\0' &&
            (!has_second ||
             strcmp(record_word(tool, 1), settings[i].second) == 0)) {
            (void)snprintf(out, 32, "%s%s", value, settings[i].letter);
            return true;
        }
    }
    if (strcmp(record_word(tool, 0), "lines") == 0) {
        const bool is_many = strcmp(record_word(tool, 1), "640") == 0;
        (void)snprintf(out, 32, "%s", is_many ? "0f" : "1f");
        return true;
    }
    return false;
}

/* --- The laser --- */

static void judge_on(const struct deed *d)
{
    const record_device *device = NULL;
    const record_line *heard = find_last(d, "u", &device);
    verdict_asked(d->out, on);
    if (heard == NULL) {
        verdict_broken(d->out, on, d->tool->ended_ns,
                       "lumctl [%ld] says that the laser is on, and no sensor "
                       "did it",
                       d->tool->id);
    } else if (!record_laser_was(device, true, d->tool->began_ns,
                                 d->tool->ended_ns)) {
        verdict_broken(d->out, on, d->tool->ended_ns,
                       "lumctl [%ld] says that the laser is on, and it never "
                       "came up",
                       d->tool->id);
    }
}

/* Another `u` after a look. */
static bool is_on_again(const record_device *device, int64_t from_ns,
                        int64_t to_ns)
{
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->t_ns >= from_ns && l->t_ns <= to_ns && record_was_done(l, "u")) {
            return true;
        }
    }
    return false;
}

/* The first time that a request of a tool was heard: repeats have its number.
 */
static int64_t first_heard(const struct deed *d, const record_device *device,
                           const record_line *last)
{
    int64_t first_ns = last->t_ns;
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->sequence == last->sequence && strcmp(l->text, last->text) == 0 &&
            is_of(d, l) && l->t_ns < first_ns) {
            first_ns = l->t_ns;
        }
    }
    return first_ns;
}

static void judge_off(const struct deed *d)
{
    const record_device *device = NULL;
    const record_device *looked = NULL;
    const record_line *heard = find_last(d, "d", &device);
    const record_line *look = find_last(d, NULL, &looked);
    const int64_t end_ns = d->tool->ended_ns;
    verdict_asked(d->out, off);
    if (heard == NULL || look == NULL) {
        verdict_broken(d->out, heard == NULL ? off : twice, end_ns,
                       "%s [%ld] says that the laser is off, and %s",
                       d->tool->arguments[0], d->tool->id,
                       heard == NULL ? "no sensor got the command"
                                     : "did not look a second time");
        return;
    }
    const int64_t look_ns = first_heard(d, looked, look);
    if (record_laser_is_up(device, end_ns) &&
        !is_on_again(device, look_ns, end_ns)) {
        verdict_broken(d->out, off, end_ns,
                       "%s [%ld] says that the laser is off, and it is on",
                       d->tool->arguments[0], d->tool->id);
    }
    verdict_asked(d->out, twice);
    if (look_ns - first_heard(d, device, heard) < APART_NS) {
        verdict_broken(d->out, twice, end_ns,
                       "%s [%ld] says that the laser is off: it looked only "
                       "once, or too soon again",
                       d->tool->arguments[0], d->tool->id);
    }
}

static void judge_taken_back(const struct deed *d)
{
    const record_device *device = NULL;
    const record_line *heard = find_last(d, "d", &device);
    verdict_asked(d->out, taken);
    if (heard == NULL ||
        ((record_status_at(device, d->tool->ended_ns) & LASER_CMD_ON) != 0 &&
         !is_on_again(device, heard->t_ns, d->tool->ended_ns))) {
        verdict_broken(d->out, taken, d->tool->ended_ns,
                       "lumctl [%ld] says that laser on is taken back, and it "
                       "is in effect",
                       d->tool->id);
    }
}

/* --- Addresses and statuses --- */

static bool had_address(const record_device *device, uint32_t address,
                        int64_t from_ns, int64_t to_ns)
{
    uint32_t at = 0;
    for (size_t i = 0; i < device->count && device->lines[i].t_ns <= to_ns;
         i++) {
        const record_line *l = &device->lines[i];
        if (l->event != RECORD_START &&
            (l->event != RECORD_MOVE || !l->is_yes)) {
            continue;
        }
        at = l->peer.address;
        if (at == address && l->t_ns >= from_ns) {
            return true;
        }
    }
    return at == address;
}

static void judge_move(const struct deed *d)
{
    const char *text = record_word(d->tool, 1);
    const uint32_t address = record_address(text, NULL);
    verdict_asked(d->out, moved);
    for (size_t i = 0; i < d->record->device_count; i++) {
        if (had_address(&d->record->devices[i], address, d->tool->began_ns,
                        d->tool->ended_ns)) {
            return;
        }
    }
    verdict_broken(d->out, moved, d->tool->ended_ns,
                   "lumctl [%ld] says that the sensor is at %s, and none is",
                   d->tool->id, text);
}

static bool had_status(const record_device *device, unsigned status,
                       int64_t from_ns, int64_t to_ns)
{
    if (record_status_at(device, from_ns) == status) {
        return true;
    }
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->event == RECORD_STATUS && l->t_ns >= from_ns &&
            l->t_ns <= to_ns && l->status == status) {
            return true;
        }
    }
    return false;
}

/* When the request of an answer was sent for the first time; an answer that
 * nobody asked for tells of its own moment. */
static int64_t asked_ns(const struct deed *d, const record_datagram *answer)
{
    const int index = (int)(d->sender - d->record->tools);
    for (size_t i = 0; i < d->record->datagram_count; i++) {
        const record_datagram *q = &d->record->datagrams[i];
        if (q->sender == index && q->packet == RECORD_IS_TLV &&
            q->sequence == answer->sequence && q->sent_ns <= answer->sent_ns) {
            return q->sent_ns;
        }
    }
    return answer->sent_ns;
}

/* A device had it between a request and its answer, which the tool read. */
static bool was_answered(const struct deed *d, unsigned status)
{
    const int index = (int)(d->sender - d->record->tools);
    for (size_t i = 0; i < d->record->datagram_count; i++) {
        const record_datagram *a = &d->record->datagrams[i];
        if (a->reader != index || a->fate != RECORD_READ ||
            a->packet != RECORD_IS_TLV || a->fate_ns < d->tool->began_ns ||
            a->fate_ns > d->tool->ended_ns) {
            continue;
        }
        const int64_t from_ns = asked_ns(d, a) - LOG_NS;
        for (size_t k = 0; k < d->record->device_count; k++) {
            if (had_status(&d->record->devices[k], status, from_ns,
                           a->sent_ns + LOG_NS)) {
                return true;
            }
        }
    }
    return false;
}

/* In JSON, or for people: "status 0x0200". */
static bool find_status(const record_tool *tool, unsigned *out)
{
    static const char hex[] = ", status 0x";
    uint64_t number = 0;
    const char *at = tool->out != NULL ? strstr(tool->out, hex) : NULL;
    if (record_json_number(tool->out, "status", &number)) {
        *out = (unsigned)number;
        return true;
    }
    if (at != NULL) {
        *out = (unsigned)strtoul(at + sizeof hex - 1, NULL, 16);
    }
    return at != NULL;
}

static void judge_status_said(const struct deed *d)
{
    unsigned status = 0;
    if (record_watches(d->tool) || !find_status(d->tool, &status)) {
        return;
    }
    verdict_asked(d->out, said);
    if (!was_answered(d, status)) {
        verdict_broken(d->out, said, d->tool->ended_ns,
                       "lumctl [%ld] says status %u, which no sensor had "
                       "between a request and its answer",
                       d->tool->id, status);
    }
}

/* --- The command --- */

static void judge_laser(const struct deed *d)
{
    const int status = record_exit_status(d->tool);
    if (strcmp(record_word(d->tool, 1), "off") == 0) {
        if (status == 0) {
            judge_off(d);
        }
    } else if (status == 0) {
        judge_on(d);
    } else if (d->tool->err != NULL &&
               strstr(d->tool->err, " cancelled: it will not") != NULL) {
        judge_taken_back(d);
    }
}

static void judge_json(const struct deed *d)
{
    bool is_done = false;
    if (record_json_bool(d->tool->out, "done", &is_done)) {
        verdict_asked(d->out, same);
        if (is_done != (record_exit_status(d->tool) == 0)) {
            verdict_broken(d->out, same, d->tool->ended_ns,
                           "lumctl [%ld] prints done: %s, and ends with %d",
                           d->tool->id, is_done ? "true" : "false",
                           record_exit_status(d->tool));
        }
    }
}

/* A session with --laser that a sensor heard. */
static bool has_switched(const struct deed *d)
{
    const record_device *device = NULL;
    return find_last(d, "u", &device) != NULL;
}

/* Whether a sensor was at any time as `wait` says. */
static bool was_so(const struct deed *d, const record_device *device,
                   const char *goal)
{
    bool is_so = false;
    for (int64_t i = -1; i < (int64_t)device->count && !is_so; i++) {
        const int64_t t_ns = i < 0 ? d->tool->began_ns : device->lines[i].t_ns;
        const unsigned status = record_status_at(device, t_ns);
        is_so = t_ns >= d->tool->began_ns && t_ns <= d->tool->ended_ns &&
                (strcmp(goal, "clear") != 0 || (status & HAZARDS) == 0);
        is_so = is_so &&
                (strcmp(goal, "up") != 0 || record_laser_is_up(device, t_ns));
        is_so = is_so && (strcmp(goal, "down") != 0 ||
                          !record_laser_is_up(device, t_ns));
    }
    return is_so;
}

static void judge_wait(const struct deed *d)
{
    const char *goal = record_word(d->tool, 1);
    bool is_so = false;
    for (size_t i = 0; i < d->record->device_count; i++) {
        is_so = is_so || was_so(d, &d->record->devices[i], goal);
    }
    verdict_asked(d->out, waited);
    if (!is_so) {
        verdict_broken(d->out, waited, d->tool->ended_ns,
                       "lumctl wait %s [%ld] ends with 0, and no sensor was so",
                       goal, d->tool->id);
    }
}

static void judge_done_command(const struct deed *d)
{
    char command[32];
    const char *word = record_word(d->tool, 0);
    if (find_setting(d->tool, command)) {
        require(d, command);
    } else if (strcmp(word, "send") == 0) {
        require_each(d, record_word(d->tool, 1));
    } else if (strcmp(word, "set-ip") == 0) {
        judge_move(d);
    } else if (strcmp(word, "wait") == 0) {
        judge_wait(d);
    }
}

static void judge_lumctl(const struct deed *d)
{
    const char *word = record_word(d->tool, 0);
    if (strcmp(word, "laser") == 0) {
        judge_laser(d);
    } else if (strcmp(word, "status") == 0) {
        judge_status_said(d);
    } else if (record_exit_status(d->tool) == 0) {
        judge_done_command(d);
    }
    if (record_option(d->tool, "--laser") != NULL &&
        record_exit_status(d->tool) == 0 && has_switched(d)) {
        judge_off(d);
    }
    judge_json(d);
}

/* Each line of a shell is a command. */
static void judge_shell(const struct record *record, const record_tool *tool,
                        struct verdict *out)
{
    static struct shell shell; /* too large for a stack */
    shell_read(record, tool, &shell);
    for (size_t i = 0; i < shell.count; i++) {
        const record_tool *as = &shell.lines[i].as;
        const struct deed d = {record, tool, as, out};
        if (shell.lines[i].is_done || as->err != NULL) {
            judge_lumctl(&d);
        }
    }
    shell_free(&shell);
}

static void judge_tool(const struct record *record, const record_tool *tool,
                       struct verdict *out)
{
    const struct deed d = {record, tool, tool, out};
    if (shell_is_one(tool)) {
        judge_shell(record, tool, out);
    } else if (tool->ended_ns == RECORD_NEVER || record_exit_status(tool) < 0) {
        return;
    } else if (record_is_program(tool, "lumctl")) {
        judge_lumctl(&d);
    } else if (record_option(tool, "--laser") != NULL &&
               record_exit_status(tool) == 0) {
        judge_off(&d);
    }
}

void judge_done(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        if (!tool->met_others && record_option(tool, "--dry-run") == NULL &&
            record_is_undamaged(record, tool->began_ns, tool->ended_ns)) {
            judge_tool(record, tool, out);
        }
    }
}
