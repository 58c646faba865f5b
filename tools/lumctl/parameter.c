/* The commands that set one value, such as power and threshold. */
#include "ctl.h"
#include "setting.h"

#include "lum/command.h"
#include "lum/host/command_text.h"

#include <stdio.h>
#include <string.h>

static bool has_sides(const char *name)
{
    return strcmp(name, "threshold") == 0 || strcmp(name, "offset") == 0;
}

/* Of a name such as "threshold green"; LUM_COMMANDS: there is none. */
static lum_command_id find(const char *name)
{
    size_t i = 0;
    while (i < SETTINGS && strcmp(settings[i].name, name) != 0) {
        i++;
    }
    return i < SETTINGS ? settings[i].id : LUM_COMMANDS;
}

static bool is_percent(lum_command_id id)
{
    return id == LUM_COMMAND_POWER || id == LUM_COMMAND_THRESHOLD_GREEN ||
           id == LUM_COMMAND_THRESHOLD_BLUE;
}

static void describe(lum_command_id id, char *out, size_t size)
{
    const lum_command_spec *spec = &lum_command_specs[id];
    if (id == LUM_COMMAND_LINE_MODE) {
        (void)snprintf(out, size, "640 or 64");
    } else if (spec->step > 1) {
        (void)snprintf(out, size, "a whole number from %u to %u in steps of %u",
                       (unsigned)spec->min, (unsigned)spec->max,
                       (unsigned)spec->step);
    } else {
        (void)snprintf(out, size, "a whole number from %u to %u%s",
                       (unsigned)spec->min, (unsigned)spec->max,
                       is_percent(id) ? " percent" : "");
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
static bool compose(lum_command_id id, const char *value, char *out,
                    size_t size)
{
    const char *number = id == LUM_COMMAND_LINE_MODE ? mode_of(value) : value;
    const char *text = out;
    lum_command command;
    const int n =
        snprintf(out, size, "%s%c", number, lum_command_specs[id].letter);
    size_t left = n > 0 && (size_t)n < size ? (size_t)n : 0;
    return lum_command_parse(&text, &left, &command) == LUM_OK && left == 0;
}

static enum exit_status set(struct ctl *ctl, lum_command_id id,
                            const char *name, int count, char **words)
{
    char text[32];
    char allowed[64];
    char typed[64];
    describe(id, allowed, sizeof allowed);
    if (count == 0) {
        return ctl_complain(EXIT_BAD, "%s: a value is missing: %s", name,
                            allowed);
    }
    if (count > 1) {
        return ctl_complain(EXIT_BAD, "%s: '%s' is one word too many: %s", name,
                            words[1], allowed);
    }
    if (!compose(id, words[0], text, sizeof text)) {
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
    char name[32];
    (void)snprintf(name, sizeof name, "%s%s%.16s", words[0], sides ? " " : "",
                   sides ? words[1] : "");
    const lum_command_id id = find(name);
    if (id == LUM_COMMANDS) {
        return ctl_complain(EXIT_BAD, "%s: '%s' is not an eye: green or blue",
                            words[0], words[1]);
    }
    return set(ctl, id, name, count - used, words + used);
}
