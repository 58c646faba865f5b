#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include "../common/input_files.h"
#include "lum/version.h"

#include <getopt.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

enum {
    OPT_LAYOUT = 256,
    OPT_PROFILE,
    OPT_CALIBRATION,
    OPT_SET,
    OPT_NAME,
    OPT_VERSION
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"layout", no_argument, NULL, OPT_LAYOUT},
    {"profile", required_argument, NULL, OPT_PROFILE},
    {"calibration", required_argument, NULL, OPT_CALIBRATION},
    {"set", required_argument, NULL, OPT_SET},
    {"name", required_argument, NULL, OPT_NAME},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, OPT_VERSION},
    {NULL, 0, NULL, 0},
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

/* getopt_long() accepts any beginning of a name; here, as with the other tools,
 * the full name is required. The word that was read is before optind, or before
 * its value. */
static enum parsed check_spelling(char **argv, const struct option *option)
{
    const char *word = argv[optind - 1];
    if (option->has_arg == required_argument && optarg == word) {
        word = argv[optind - 2];
    }
    const char *name = word + strspn(word, "-");
    const size_t len = strcspn(name, "=");
    return len == strlen(option->name)
               ? PARSED_RUN
               : refuse("--%.*s: no such option; did you mean --%s? See "
                        "lumtable --help",
                        (int)len, name, option->name);
}

/* What follows it makes it no keyword. */
static bool is_identifier(const char *name)
{
    const size_t len = strlen(name);
    return len <= NAME_MAX_LENGTH && strspn(name, LETTERS) > 0 &&
           strspn(name, LETTERS "_0123456789") == len;
}

static enum parsed add_setting(struct options *out)
{
    lum_error why = {""};
    if (set_keys_add(&out->set, optarg, &why)) {
        return PARSED_RUN;
    }
    return why.text[0] != '\0'
               ? refuse("--set: %s", why.text)
               : refuse("--set: '%s' is not %s", optarg, SET_KEYS_ALLOWED);
}

static enum parsed set_option(int option, struct options *out)
{
    switch (option) {
    case 'h':
        (void)fputs(help_text, stdout);
        return PARSED_DONE;
    case OPT_VERSION:
        (void)puts("lumtable " LUM_VERSION);
        return PARSED_DONE;
    case OPT_LAYOUT:
        out->is_layout = true;
        break;
    case OPT_PROFILE:
        out->profile = optarg;
        break;
    case OPT_CALIBRATION:
        out->calibration = optarg;
        break;
    case OPT_SET:
        return add_setting(out);
    case OPT_NAME:
        out->name = optarg;
        break;
    case 'o':
        out->output = optarg;
        break;
    default:
        return refuse("see lumtable --help");
    }
    return PARSED_RUN;
}

/* A calibration and a name are of tables alone. */
static enum parsed check_layout(const struct options *o)
{
    const char *key = set_keys_first(&o->set, false);
    if (o->calibration != NULL) {
        return refuse(
            "--layout: --calibration goes with tables alone; leave it out");
    }
    if (o->name != NULL) {
        return refuse("--layout: --name goes with tables alone; leave it out");
    }
    return key == NULL ? PARSED_RUN
                       : refuse("--layout: '%s' is of a calibration, which "
                                "goes with tables alone",
                                key);
}

static enum parsed check(int argc, char **argv, const struct options *o)
{
    const struct input_file inputs[] = {{o->calibration, "--calibration"},
                                        {o->profile, "--profile"}};
    lum_error why = {""};
    if (optind < argc) {
        return refuse("'%s': files are named by --profile and --calibration",
                      argv[optind]);
    }
    if (input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                               &why) != 0) {
        return refuse("%s", why.text);
    }
    if (o->is_layout) {
        return check_layout(o);
    }
    return o->name == NULL || is_identifier(o->name)
               ? PARSED_RUN
               : refuse("--name: '%s' is not a name in C: a letter, then "
                        "letters, digits and _, 40 at most",
                        o->name);
}

enum parsed options_parse(int argc, char **argv, struct options *out)
{
    int option = 0;
    int which = -1;
    *out = (struct options){.output = "-"};
    while ((option = getopt_long(argc, argv, "o:h", long_options, &which)) !=
           -1) {
        if (which >= 0 && option != '?' &&
            check_spelling(argv, &long_options[which]) != PARSED_RUN) {
            return PARSED_BAD;
        }
        which = -1;
        const enum parsed parsed = set_option(option, out);
        if (parsed != PARSED_RUN) {
            return parsed;
        }
    }
    return check(argc, argv, out);
}
