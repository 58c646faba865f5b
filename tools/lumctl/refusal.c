#include "refusal.h"

#include "ctl.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static bool is_part_of_word(char c)
{
    return isalnum((unsigned char)c) != 0;
}

/* Whether a text has a word, not as a part of another. */
static bool names_word(const char *text, const char *word, size_t len)
{
    for (const char *at = text; *at != '\0'; at++) {
        if (strncmp(at, word, len) == 0 &&
            (at == text || !is_part_of_word(at[-1])) &&
            !is_part_of_word(at[len])) {
            return true;
        }
    }
    return false;
}

#define LINE_BYTES sizeof((struct ctl_answer *)0)->debug

/* The next line of debug texts in lower case beside the line itself. False:
 * there is none. */
static bool next_line(const char **debug, char *line, char *lower)
{
    const size_t len = strcspn(*debug, "\n");
    const size_t n = len < LINE_BYTES ? len : LINE_BYTES - 1;
    if (**debug == '\0') {
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        line[i] = (*debug)[i];
        lower[i] = (char)tolower((unsigned char)line[i]);
    }
    line[n] = '\0';
    lower[n] = '\0';
    *debug += len + ((*debug)[len] == '\n' ? 1u : 0u);
    return true;
}

static bool refuses(const char *lower)
{
    static const char *const stems[] = {
        "refus",     "reject",  "invalid",     "error",
        "unknown",   "denied",  "cannot",      "out of range",
        "malformed", "illegal", "not allowed", "unsupported"};
    for (size_t i = 0; i < sizeof stems / sizeof stems[0]; i++) {
        if (strstr(lower, stems[i]) != NULL) {
            return true;
        }
    }
    return false;
}

/* Whether a line plainly says that what it names was done. */
static bool confirms(const char *lower)
{
    static const char *const yes[] = {"set", "done", "ok", "accepted",
                                      "applied"};
    static const char *const no[] = {"not",    "no",  "range", "limit",
                                     "failed", "max", "min",   "must"};
    bool has_yes = false;
    for (size_t i = 0; i < sizeof yes / sizeof yes[0]; i++) {
        has_yes = has_yes || names_word(lower, yes[i], strlen(yes[i]));
    }
    for (size_t i = 0; i < sizeof no / sizeof no[0]; i++) {
        has_yes = has_yes && !names_word(lower, no[i], strlen(no[i]));
    }
    return has_yes && !refuses(lower);
}

static void add_name(struct refusal *out, const char *word, size_t len)
{
    const size_t n = strlen(out->names);
    if (!names_word(out->names, word, len)) {
        (void)snprintf(out->names + n, sizeof out->names - n, "%s%.*s",
                       n != 0 ? " " : "", (int)len, word);
    }
}

/* Notes the commands that a line refuses. */
static void read_line(const char *text, const char *line, const char *lower,
                      struct refusal *out)
{
    const bool is_confirmation = confirms(lower);
    bool is_named = false;
    while (*text != '\0') {
        const size_t len = strcspn(text, " ");
        const bool is_here = names_word(line, text, len);
        is_named = is_named || is_here;
        if (is_here && !is_confirmation) {
            add_name(out, text, len);
        }
        text += len + (text[len] == ' ' ? 1u : 0u);
    }
    out->has_unnamed = out->has_unnamed || (!is_named && refuses(lower));
}

bool refusal_find(const char *text, const char *debug, struct refusal *out)
{
    char line[LINE_BYTES];
    char lower[LINE_BYTES] = "";
    out->names[0] = '\0';
    out->has_unnamed = false;
    while (next_line(&debug, line, lower)) {
        read_line(text, line, lower, out);
    }
    return out->names[0] != '\0' || out->has_unnamed;
}
