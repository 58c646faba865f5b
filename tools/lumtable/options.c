#include "options.h"

#include "../common/input_files.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

/* What follows it makes it no keyword. */
static bool take_name(void *options, const char *text, lum_error *why)
{
    (void)why;
    ((struct options *)options)->name = text;
    return strlen(text) <= NAME_MAX_LENGTH && strspn(text, LETTERS) > 0 &&
           text[strspn(text, LETTERS "_0123456789")] == '\0';
}

#define INTO(field) OPTION_INTO(struct options, field)

static const struct option_spec specs[] = {
    {"output", .letter = 'o', .kind = OPTION_TEXT, INTO(output)},
    {"layout", .kind = OPTION_FLAG, INTO(is_layout)},
    {"profile", .kind = OPTION_TEXT, INTO(profile)},
    {"calibration", .kind = OPTION_TEXT, INTO(calibration)},
    {"set", .kind = OPTION_CALL, .call = set_keys_add, INTO(set),
     .allowed = SET_KEYS_ALLOWED},
    {"name", .kind = OPTION_CALL, .call = take_name,
     .allowed = "a name in C: a letter, then letters, digits and _, 40 at "
                "most"},
    OPTION_HELP,
    OPTION_VERSION("lumtable"),
};

LUM_PRINTF(1, 2) static enum option_end refuse(const char *format, ...)
{
    va_list arguments;
    (void)fputs("lumtable: ", stderr);
    va_start(arguments, format);
    (void)vfprintf(stderr, format, arguments);
    va_end(arguments);
    (void)fputc('\n', stderr);
    return OPTIONS_REFUSED;
}

/* A calibration and a name are of tables alone. */
static enum option_end check_layout(const struct options *o)
{
    const char *key = set_keys_first(&o->set, false);
    if (o->calibration != NULL || o->name != NULL) {
        return refuse("--layout: --%s goes with tables alone; leave it out",
                      o->calibration != NULL ? "calibration" : "name");
    }
    return key == NULL ? OPTIONS_READ
                       : refuse("--layout: '%s' is of a calibration, which "
                                "goes with tables alone",
                                key);
}

static enum option_end check(int words, char **argv, const struct options *o)
{
    const struct input_file inputs[] = {{o->calibration, "--calibration"},
                                        {o->profile, "--profile"}};
    lum_error why = {""};
    if (words > 0) {
        return refuse("'%s': files are named by --profile and --calibration",
                      argv[1]);
    }
    if (input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                               &why) != 0) {
        return refuse("%s", why.text);
    }
    return o->is_layout ? check_layout(o) : OPTIONS_READ;
}

enum option_end options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumtable", "lumtable --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){.output = "-"};
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    return end == OPTIONS_READ ? check(result.count, argv, out) : end;
}
