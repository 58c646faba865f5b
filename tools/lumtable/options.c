#include "options.h"

#include "../common/input_files.h"
#include "../common/option_table.h"
#include "lum/version.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

static void show_help(void)
{
    (void)fputs(help_text, stdout);
}

static void show_version(void)
{
    (void)puts("lumtable " LUM_VERSION);
}

static bool take_set(void *options, const char *text, lum_error *why)
{
    return set_keys_add(&((struct options *)options)->set, text, why);
}

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
    {"set", .kind = OPTION_CALL, .call = take_set, .allowed = SET_KEYS_ALLOWED},
    {"name", .kind = OPTION_CALL, .call = take_name,
     .allowed = "a name in C: a letter, then letters, digits and _, 40 at "
                "most"},
    {"help", .letter = 'h', .kind = OPTION_SHOW, .show = show_help},
    {"version", .kind = OPTION_SHOW, .show = show_version},
};

LUM_PRINTF(1, 2) static enum parsed refuse(const char *format, ...)
{
    va_list arguments;
    (void)fputs("lumtable: ", stderr);
    va_start(arguments, format);
    (void)vfprintf(stderr, format, arguments);
    va_end(arguments);
    (void)fputc('\n', stderr);
    return PARSED_BAD;
}

/* A calibration and a name are of tables alone. */
static enum parsed check_layout(const struct options *o)
{
    const char *key = set_keys_first(&o->set, false);
    if (o->calibration != NULL || o->name != NULL) {
        return refuse("--layout: --%s goes with tables alone; leave it out",
                      o->calibration != NULL ? "calibration" : "name");
    }
    return key == NULL ? PARSED_RUN
                       : refuse("--layout: '%s' is of a calibration, which "
                                "goes with tables alone",
                                key);
}

static enum parsed check(int words, char **argv, const struct options *o)
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
    return o->is_layout ? check_layout(o) : PARSED_RUN;
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {
        "lumtable", "lumtable --help", specs, sizeof specs / sizeof specs[0],
        false};
    struct option_result result;
    *out = (struct options){.output = "-"};
    switch (option_table_read(&table, argc, argv, out, &result)) {
    case OPTIONS_SHOWN:
        return PARSED_DONE;
    case OPTIONS_REFUSED:
        return PARSED_BAD;
    case OPTIONS_READ:
    default:
        return check(result.count, argv, out);
    }
}
