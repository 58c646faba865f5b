#include "shell.h"

#include "limits.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A line that was read together with the one before is taken at the next turn
 * of the shell, which waits for a second at most. */
#define TURN_NS (1100 * RECORD_MS)

/* --- Words --- */

static bool is_command(const char *word, size_t len)
{
    size_t digits = 0;
    while (digits < len && isdigit((unsigned char)word[digits])) {
        digits++;
    }
    if (digits == 0) {
        return len == 1 && (*word == 'u' || *word == 'd');
    }
    return digits + 1 == len && strchr("pgbyhGBf", word[digits]) != NULL;
}

/* The manual's text, with single spaces. */
static bool is_raw(const char *text)
{
    bool is_fine = *text != '\0';
    while (is_fine && *text != '\0') {
        const size_t len = strcspn(text, " ");
        is_fine = is_command(text, len);
        text += len;
        text += *text == ' ' ? 1 : 0;
    }
    return is_fine;
}

static char *trim(char *text)
{
    text += strspn(text, " \t\r");
    size_t len = strlen(text);
    while (len > 0 && strchr(" \t\r", text[len - 1]) != NULL) {
        text[--len] = '\0';
    }
    return text;
}

static void add_word(record_tool *as, char *word)
{
    if (as->count < RECORD_ARGUMENTS) {
        as->arguments[as->count++] = word;
    }
}

/* Between blanks, and between '...'. */
static void add_words(record_tool *as, char *text)
{
    while (*text != '\0') {
        const bool is_quoted = *text == '\'';
        text += is_quoted ? 1 : 0;
        add_word(as, text);
        text += strcspn(text, is_quoted ? "'" : " \t");
        if (*text != '\0') {
            *text++ = '\0';
        }
        text += strspn(text, " \t");
    }
}

/* The shell's options hold for all its commands. */
static void add_options(record_tool *as, const record_tool *shell)
{
    for (unsigned i = 0; i < shell->count; i++) {
        const char *a = shell->arguments[i];
        if (strcmp(a, "shell") != 0 && strcmp(a, "--heartbeat") != 0) {
            add_word(as, shell->arguments[i]);
        }
    }
}

static shell_kind kind_of(const record_tool *as)
{
    static const struct {
        const char *word;
        shell_kind kind;
    } kinds[] = {
        {"power", SHELL_SETTING}, {"threshold", SHELL_SETTING},
        {"lines", SHELL_SETTING}, {"holdoff", SHELL_SETTING},
        {"yscan", SHELL_SETTING}, {"offset", SHELL_SETTING},
        {"laser", SHELL_LASER},   {"status", SHELL_STATUS},
        {"set-ip", SHELL_MOVE},   {"time", SHELL_TIME},
    };
    if (record_option(as, "--dry-run") != NULL || record_watches(as) ||
        record_option(as, "--shape") != NULL) {
        return SHELL_OTHER;
    }
    if (strcmp(record_word(as, 0), "send") == 0) {
        const char *text = record_word(as, 1);
        const bool is_laser =
            record_has_word(text, "u") || record_has_word(text, "d");
        return !is_raw(text) ? SHELL_OTHER
               : is_laser    ? SHELL_LASER
                             : SHELL_SETTING;
    }
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(record_word(as, 0), kinds[i].word) == 0) {
            return kinds[i].kind;
        }
    }
    return SHELL_OTHER;
}

/* --- Reports --- */

/* What says that it is done. */
static void find_report(const shell_line *line, char *out, size_t size)
{
    const record_tool *as = &line->as;
    const char *word = record_word(as, 0);
    if (record_option(as, "--json") != NULL) {
        (void)snprintf(out, size, "%s",
                       line->kind == SHELL_STATUS ? "\"status\": "
                                                  : "\"done\": true");
    } else if (strcmp(word, "laser") == 0) {
        const bool is_on = strcmp(record_word(as, 1), "on") == 0;
        (void)snprintf(out, size,
                       is_on ? ": laser on done; " : ": laser off; ");
    } else if (line->kind == SHELL_STATUS) {
        (void)snprintf(out, size, ", status 0x");
    } else if (line->kind == SHELL_TIME) {
        (void)snprintf(out, size, "  was 0 at ");
    } else if (line->kind == SHELL_MOVE) {
        (void)snprintf(out, size, "%s: the sensor answers there now",
                       record_word(as, 1));
    } else if (strcmp(word, "send") == 0) {
        (void)snprintf(out, size, ": %s done; ", record_word(as, 1));
    } else {
        const char *third = record_word(as, 2);
        (void)snprintf(out, size, ": %s %s%s%s done; ", word,
                       record_word(as, 1), *third != '\0' ? " " : "", third);
    }
}

/* When a text was printed up to a place. */
static int64_t printed_ns(const record_tool *tool, size_t place, bool is_err)
{
    for (size_t i = 0; i < tool->print_count; i++) {
        const record_print *p = &tool->prints[i];
        if ((is_err ? p->err : p->out) >= place) {
            return p->t_ns;
        }
    }
    return RECORD_NEVER;
}

/* The end of the line in which it stands. */
static size_t end_of(const char *text, const char *at)
{
    return (size_t)(at - text) + strcspn(at, "\n") + 1;
}

static char *copy(const char *text, size_t len)
{
    char *out = malloc(len + 1);
    if (out == NULL) {
        abort();
    }
    memcpy(out, text, len);
    out[len] = '\0';
    return out;
}

static bool is_of(const shell_line *line, const char *text, int64_t t_ns)
{
    char report[SHELL_BYTES + 40];
    find_report(line, report, sizeof report);
    return line->kind != SHELL_OTHER && line->typed_ns <= t_ns &&
           strstr(text, report) != NULL;
}

/* The line that a report is of: reports come in the order of the lines, and not
 * of all. Of two lines with one text it is that which is not over yet. */
static shell_line *find_line(struct shell *s, size_t from, const char *text,
                             int64_t t_ns)
{
    shell_line *late = NULL;
    for (size_t i = from; i < s->count; i++) {
        shell_line *l = &s->lines[i];
        if (is_of(l, text, t_ns) && t_ns <= l->due_ns) {
            return l;
        }
        late = late == NULL && is_of(l, text, t_ns) ? l : late;
    }
    return late;
}

static int64_t line_limit(const shell_line *line)
{
    /* The longest that is no search, and asks for a settings' file. */
    return line->kind == SHELL_OTHER ? 60 * RECORD_S
                                     : limits_of_lumctl(&line->as);
}

/* What lines report, and not what is printed unasked. */
static bool is_report(const char *text)
{
    return strstr(text, " done; ") != NULL ||
           strstr(text, ": laser off; ") != NULL;
}

static void claim_reports(struct shell *s)
{
    const char *out = s->tool->out;
    size_t next = 0;
    size_t told = 0;
    for (size_t at = 0; out[at] != '\0';) {
        const size_t len = strcspn(out + at, "\n");
        char *text = copy(out + at, len);
        at += len + (out[at + len] == '\n' ? 1 : 0);
        const int64_t t_ns = printed_ns(s->tool, at, false);
        shell_line *line = find_line(s, next, text, t_ns);
        if (line != NULL) {
            next = (size_t)(line - s->lines) + 1;
            line->is_done = true;
            line->as.ended_ns = t_ns;
            line->as.out = copy(out + told, at - told);
            told = at;
        } else if (is_report(text)) {
            s->unclaimed++;
        }
        free(text);
    }
}

static bool is_for_on(const shell_line *line)
{
    return strcmp(record_word(&line->as, 0), "laser") == 0
               ? strcmp(record_word(&line->as, 1), "on") == 0
               : record_has_word(record_word(&line->as, 1), "u");
}

/* When the next line that is reported was over. */
static int64_t next_over_ns(const struct shell *s, const shell_line *line)
{
    const shell_line *end = s->lines + s->count;
    for (const shell_line *l = line + 1; l < end; l++) {
        if (l->is_done) {
            return l->as.ended_ns;
        }
    }
    return RECORD_NEVER;
}

/* A laser on that was not done may say that it is taken back. */
static void take_back(const struct shell *s, shell_line *line, size_t *told)
{
    static const char taken[] = " cancelled: it will not";
    const char *at = strstr(s->tool->err + *told, taken);
    if (line->kind != SHELL_LASER || line->is_done || !is_for_on(line) ||
        at == NULL) {
        return;
    }
    const size_t end = end_of(s->tool->err, at);
    const int64_t t_ns = printed_ns(s->tool, end, true);
    if (t_ns >= line->as.began_ns && t_ns <= line->due_ns &&
        t_ns <= next_over_ns(s, line)) {
        line->as.ended_ns = t_ns;
        line->as.err = copy(s->tool->err + *told, end - *told);
        *told = end;
    }
}

/* When each began, and is due: by what is known of those before. Before their
 * reports are known it is the latest. */
static void set_times(const struct record *record, struct shell *s,
                      bool knows_reports)
{
    int64_t over_ns = s->tool->began_ns; /* the last that was reported */
    int64_t due_ns = s->tool->began_ns;  /* the one before */
    size_t told = 0;
    for (size_t i = 0; i < s->count; i++) {
        shell_line *l = &s->lines[i];
        l->as.began_ns = l->typed_ns > over_ns ? l->typed_ns : over_ns;
        due_ns = l->typed_ns > due_ns ? l->typed_ns : due_ns;
        l->due_ns = due_ns + TURN_NS + limits_with_grace(line_limit(l)) +
                    limits_of_lock(record, s->tool);
        l->due_ns += record_stopped_ns(s->tool, due_ns, l->due_ns);
        l->as.ended_ns = l->is_done ? l->as.ended_ns : l->due_ns;
        if (knows_reports) {
            take_back(s, l, &told);
        }
        due_ns = l->as.ended_ns;
        over_ns = l->is_done || l->as.err != NULL ? l->as.ended_ns : over_ns;
        l->as.status = l->is_done ? 0 : 1 << 8;
    }
}

/* --- Lines --- */

static bool is_no_command(const char *text)
{
    return *text == '\0' || *text == '#' || strcmp(text, "quit") == 0 ||
           strcmp(text, "exit") == 0 || strcmp(text, "help") == 0;
}

static void take_line(struct shell *s, const record_typed *typed)
{
    static char send[] = "send";
    shell_line *line = &s->lines[s->count];
    memset(line, 0, sizeof *line);
    (void)snprintf(line->words, sizeof line->words, "%s", typed->text);
    char *text = trim(line->words);
    if (is_no_command(text)) {
        return;
    }
    s->count++;
    add_options(&line->as, s->tool);
    if (is_raw(text)) {
        add_word(&line->as, send);
        add_word(&line->as, text);
    } else {
        add_words(&line->as, text);
    }
    line->kind = kind_of(&line->as);
    line->typed_ns = typed->t_ns;
    line->as.host = s->tool->host;
    line->as.id = s->tool->id;
}

bool shell_is_one(const record_tool *tool)
{
    return record_is_program(tool, "lumctl") &&
           strcmp(record_word(tool, 0), "shell") == 0;
}

void shell_read(const struct record *record, const record_tool *tool,
                struct shell *out)
{
    memset(out, 0, sizeof *out);
    out->tool = tool;
    if (tool->out == NULL || tool->err == NULL) {
        return;
    }
    for (size_t i = 0; i < tool->typed_count; i++) {
        if (out->count == SHELL_LINES) {
            out->is_full = true;
            return;
        }
        take_line(out, &tool->typed[i]);
    }
    set_times(record, out, false);
    claim_reports(out);
    set_times(record, out, true);
}

void shell_free(struct shell *shell)
{
    for (size_t i = 0; i < shell->count; i++) {
        free(shell->lines[i].as.out);
        free(shell->lines[i].as.err);
    }
    shell->count = 0;
}
