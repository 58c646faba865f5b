#include "ctl.h"
#include "setting.h"

#include "lum/command.h"
#include "lum/host/command_text.h"

#include <stdio.h>
#include <string.h>

struct parameter {
    const char *name;
    const char *side; /* NULL: it has none */
    const char *unit; /* after the limits */
    lum_command_id id;
};

static const struct parameter table[] = {
    {"power", NULL, " percent", LUM_COMMAND_POWER},
    {"threshold", "green", " percent", LUM_COMMAND_THRESHOLD_GREEN},
    {"threshold", "blue", " percent", LUM_COMMAND_THRESHOLD_BLUE},
    {"holdoff", NULL, "", LUM_COMMAND_HOLDOFF},
    {"offset", "green", "", LUM_COMMAND_OFFSET_GREEN},
    {"offset", "blue", "", LUM_COMMAND_OFFSET_BLUE},
    {"lines", NULL, "", LUM_COMMAND_LINE_MODE},
};

#define PARAMETERS (sizeof table / sizeof table[0])

/* All settings except the Y scan, which is a separate command. Otherwise this
 * does not compile. */
typedef char every_setting_is_here[PARAMETERS == SETTINGS - 1u ? 1 : -1];

static bool has_sides(const char *name)
{
    return strcmp(name, "threshold") == 0 || strcmp(name, "offset") == 0;
}

static const struct parameter *find(const char *name, const char *side)
{
    for (size_t i = 0; i < PARAMETERS; i++) {
        const struct parameter *p = &table[i];
        if (strcmp(p->name, name) == 0 &&
            (p->side == NULL || strcmp(p->side, side) == 0)) {
            return p;
        }
    }
    return NULL;
}

static void describe(const struct parameter *p, char *out, size_t size)
{
    const lum_command_spec *spec = &lum_command_specs[p->id];
    if (p->id == LUM_COMMAND_LINE_MODE) {
        (void)snprintf(out, size, "640 or 64");
    } else if (spec->step > 1) {
        (void)snprintf(out, size, "a whole number from %u to %u in steps of %u",
                       (unsigned)spec->min, (unsigned)spec->max,
                       (unsigned)spec->step);
    } else {
        (void)snprintf(out, size, "a whole number from %u to %u%s",
                       (unsigned)spec->min, (unsigned)spec->max, p->unit);
    }
}

/* The mode's number; any other value makes no command. */
static const char *mode_of(const char *lines)
{
    return strcmp(lines, "640") == 0  ? "0"
           : strcmp(lines, "64") == 0 ? "1"
                                      : "";
}

/* The command's text, if the value is one that it takes. */
static bool compose(const struct parameter *p, const char *value, char *out,
                    size_t size)
{
    const char *number =
        p->id == LUM_COMMAND_LINE_MODE ? mode_of(value) : value;
    const char *text = out;
    lum_command command;
    const int n =
        snprintf(out, size, "%s%c", number, lum_command_specs[p->id].letter);
    size_t left = n > 0 && (size_t)n < size ? (size_t)n : 0;
    return lum_command_parse(&text, &left, &command) == LUM_OK && left == 0;
}

static enum exit_status set(struct ctl *ctl, const struct parameter *p,
                            int count, char **words)
{
    char text[32];
    char allowed[64];
    char name[32];
    char typed[64];
    describe(p, allowed, sizeof allowed);
    (void)snprintf(name, sizeof name, "%s%s%s", p->name,
                   p->side != NULL ? " " : "", p->side != NULL ? p->side : "");
    if (count == 0) {
        return ctl_complain(EXIT_BAD, "%s: a value is missing: %s", name,
                            allowed);
    }
    if (count > 1) {
        return ctl_complain(EXIT_BAD, "%s: '%s' is one word too many: %s", name,
                            words[1], allowed);
    }
    if (!compose(p, words[0], text, sizeof text)) {
        return ctl_complain(EXIT_BAD, "%s: '%s' is not %s", name, words[0],
                            allowed);
    }
    (void)snprintf(typed, sizeof typed, "%s %s", name, words[0]);
    return ctl_command_words(ctl, text, typed);
}

enum exit_status command_parameter(struct ctl *ctl, int count, char **words)
{
    const bool sides = has_sides(words[0]);
    const int used = sides ? 2 : 1;
    if (count < used) {
        return ctl_complain(EXIT_BAD, "%s: which eye? %s green N or %s blue N",
                            words[0], words[0], words[0]);
    }
    const struct parameter *p = find(words[0], sides ? words[1] : "");
    if (p == NULL) {
        return ctl_complain(EXIT_BAD, "%s: '%s' is not an eye: green or blue",
                            words[0], words[1]);
    }
    return set(ctl, p, count - used, words + used);
}
