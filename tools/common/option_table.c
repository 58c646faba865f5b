#define _POSIX_C_SOURCE 200809L
#include "option_table.h"

#include "nearest.h"
#include "number.h"

#include "base/text.h"

#include <getopt.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define FIRST      0x100 /* what getopt_long() returns for the first option */
#define NAME_BYTES 32    /* of an option in a message */

/* A command line, being read. */
struct reader {
    const struct option_table *table;
    struct option named[OPTIONS_MAX + 1];
    char letters[2 * OPTIONS_MAX + 3];
    int argc;
    char **argv;
    void *options;
    struct option_result *out;
};

static bool takes_value(const struct option_spec *s)
{
    return s->kind != OPTION_FLAG && s->kind != OPTION_SHOW;
}

LUM_PRINTF(2, 3)
static enum option_end refuse(const struct reader *r, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)fprintf(stderr, "%s: ", r->table->program);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
    return OPTIONS_REFUSED;
}

/* The option string for getopt_long(): it stops at the first word, because
 * next() handles the words, and prints no messages. */
static void describe(struct reader *r)
{
    const struct option_table *t = r->table;
    char *letter = r->letters;
    *letter++ = '+';
    *letter++ = ':';
    for (size_t i = 0; i < t->count; i++) {
        const struct option_spec *s = &t->specs[i];
        r->named[i] = (struct option){
            s->name, takes_value(s) ? required_argument : no_argument, NULL,
            FIRST + (int)i};
        if (s->letter != '\0') {
            *letter++ = s->letter;
            if (takes_value(s)) {
                *letter++ = ':';
            }
        }
    }
    *letter = '\0';
    r->named[t->count] = (struct option){NULL, 0, NULL, 0};
}

/* It may be in the middle of an earlier line. */
static void restart(struct reader *r)
{
    char *none[] = {r->argv[0], NULL};
    opterr = 0;
    optind = 0;
    (void)getopt_long(1, none, r->letters, r->named, NULL);
    optind = 1;
}

static void keep(struct reader *r, char *word)
{
    r->argv[++r->out->count] = word;
}

static bool is_word(const struct reader *r, const char *text)
{
    return text[0] != '-' || text[1] == '\0' ||
           (r->table->has_negatives && strchr(".0123456789", text[1]) != NULL);
}

/* The next option, as getopt_long() gives it; -1 after the last. */
static int next(struct reader *r)
{
    while (optind < r->argc && is_word(r, r->argv[optind])) {
        keep(r, r->argv[optind++]);
    }
    if (optind < r->argc && strcmp(r->argv[optind], "--") != 0) {
        return getopt_long(r->argc, r->argv, r->letters, r->named, NULL);
    }
    while (++optind < r->argc) {
        keep(r, r->argv[optind]);
    }
    return -1;
}

/* table->count: none. */
static size_t find(const struct reader *r, int option)
{
    size_t i = 0;
    if (option >= FIRST) {
        return (size_t)(option - FIRST);
    }
    while (i < r->table->count &&
           (option == '\0' || r->table->specs[i].letter != option)) {
        i++;
    }
    return i;
}

/* near: the option that getopt_long() found, or NULL. */
static enum option_end refuse_name(const struct reader *r, const char *word,
                                   const char *near)
{
    const char *names[OPTIONS_MAX];
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    for (size_t i = 0; i < r->table->count; i++) {
        names[i] = r->table->specs[i].name;
    }
    if (near == NULL) {
        near = nearest(name, names, r->table->count);
    }
    return near != NULL
               ? refuse(r, "--%s: no such option; did you mean --%s? See %s",
                        name, near, r->table->help)
               : refuse(r, "--%s: no such option; see %s", name,
                        r->table->help);
}

static void say_allowed(const struct option_spec *s, char *out, size_t size)
{
    if (s->allowed != NULL) {
        (void)snprintf(out, size, "%s", s->allowed);
    } else if (s->kind == OPTION_WHOLE) {
        (void)snprintf(out, size, "a whole number from %lld to %lld",
                       (long long)s->min, (long long)s->max);
    } else if (s->kind == OPTION_REAL) {
        (void)snprintf(out, size, "a number from %g to %g", s->low, s->high);
    } else if (s->kind == OPTION_WORD) {
        (void)snprintf(out, size, "one of");
        for (const struct option_word *w = s->words; w->text != NULL; w++) {
            lum_text_add(out, size, " %s", w->text);
        }
    } else {
        (void)snprintf(out, size, "the name of a file");
    }
}

static void store(const struct option_spec *s, void *options, int64_t number)
{
    uint8_t *at = (uint8_t *)options + s->at;
    const uint8_t of_8 = (uint8_t)number;
    const uint16_t of_16 = (uint16_t)number;
    const uint32_t of_32 = (uint32_t)number;
    const void *from = s->size == sizeof of_8    ? (const void *)&of_8
                       : s->size == sizeof of_16 ? (const void *)&of_16
                       : s->size == sizeof of_32 ? (const void *)&of_32
                                                 : (const void *)&number;
    memcpy(at, from, s->size);
}

static bool take_word(const struct option_spec *s, const char *text,
                      void *options)
{
    for (const struct option_word *w = s->words; w->text != NULL; w++) {
        if (strcmp(w->text, text) == 0) {
            store(s, options, w->number);
            return true;
        }
    }
    return false;
}

static bool take_number(const struct option_spec *s, const char *text,
                        void *options)
{
    int64_t whole = 0;
    double real = 0.0;
    if (s->kind == OPTION_WHOLE) {
        if (!number_parse_int(text, s->min, s->max, &whole)) {
            return false;
        }
        store(s, options, whole);
        return true;
    }
    if (!number_parse_real(text, s->low, s->high, &real)) {
        return false;
    }
    memcpy((uint8_t *)options + s->at, &real, sizeof real);
    return true;
}

static bool take_size(const struct option_spec *s, const char *text,
                      void *options)
{
    double bytes = 0.0;
    if (!number_parse_size(text, s->low, s->high, &bytes)) {
        return false;
    }
    store(s, options, (int64_t)bytes);
    return true;
}

static void show(const struct option_spec *s)
{
    if (s->show != NULL) {
        s->show();
    } else {
        (void)fputs(s->text, stdout);
    }
}

static bool take(const struct option_spec *s, const char *text, void *options,
                 lum_error *why)
{
    switch (s->kind) {
    case OPTION_FLAG:
        store(s, options, 1);
        return true;
    case OPTION_TEXT:
        memcpy((uint8_t *)options + s->at, (const void *)&text, sizeof text);
        return *text != '\0';
    case OPTION_WORD:
        return take_word(s, text, options);
    case OPTION_WHOLE:
    case OPTION_REAL:
        return take_number(s, text, options);
    case OPTION_SIZE:
        return take_size(s, text, options);
    case OPTION_CALL:
        return s->call((uint8_t *)options + s->at, text, why);
    case OPTION_SHOW:
    default:
        show(s);
        return true;
    }
}

static enum option_end take_option(const struct reader *r, size_t i)
{
    const struct option_spec *s = &r->table->specs[i];
    lum_error why = {""};
    if (!take(s, optarg, r->options, &why)) {
        char allowed[256];
        say_allowed(s, allowed, sizeof allowed);
        return why.text[0] != '\0' ? refuse(r, "--%s: %s", s->name, why.text)
                                   : refuse(r, "--%s: '%s' is not %s", s->name,
                                            optarg, allowed);
    }
    if (s->has != 0) {
        *(bool *)((uint8_t *)r->options + s->has) = true;
    }
    r->out->given |= UINT64_C(1) << i;
    r->out->text[i] = optarg;
    return s->kind == OPTION_SHOW ? OPTIONS_SHOWN : OPTIONS_READ;
}

/* What getopt_long() refuses: an option that is known takes no value, or lacks
 * its own. */
static enum option_end refuse_option(const struct reader *r, const char *word)
{
    const size_t i = find(r, optopt);
    if (i == r->table->count) {
        return word[1] == '-' ? refuse_name(r, word + 2, NULL)
                              : refuse(r, "-%c: no such option; see %s", optopt,
                                       r->table->help);
    }
    const struct option_spec *s = &r->table->specs[i];
    if (!takes_value(s)) {
        const char *value = strchr(word, '=');
        return refuse(r, "--%s takes no value: '%s'", s->name,
                      value != NULL ? value + 1 : "");
    }
    char allowed[256];
    say_allowed(s, allowed, sizeof allowed);
    return refuse(r, "--%s: a value is missing: %s", s->name, allowed);
}

/* getopt_long() takes any beginning of a name. */
static bool is_spelt_out(const char *word, const char *name)
{
    return strcspn(word, "=") == strlen(name);
}

static enum option_end read_option(const struct reader *r, int option,
                                   const char *word)
{
    const char *name = word[1] == '-' ? word + 2 : NULL;
    const size_t i = find(r, option == '?' || option == ':' ? optopt : option);
    if (name != NULL && i < r->table->count &&
        !is_spelt_out(name, r->table->specs[i].name)) {
        return refuse_name(r, name, r->table->specs[i].name);
    }
    return option == '?' || option == ':' ? refuse_option(r, word)
                                          : take_option(r, i);
}

enum option_end option_table_read(const struct option_table *table, int argc,
                                  char **argv, void *options,
                                  struct option_result *out)
{
    struct reader r = {
        .table = table, .argc = argc, .argv = argv, .options = options};
    enum option_end end = OPTIONS_READ;
    r.out = out;
    *out = (struct option_result){.count = 0};
    describe(&r);
    restart(&r);
    while (end == OPTIONS_READ) {
        const int from = optind;
        const int count = out->count;
        const int option = next(&r);
        if (option == -1) {
            break;
        }
        /* Words that were kept stood before it. */
        end = read_option(&r, option, argv[from + out->count - count]);
    }
    return end;
}

bool option_table_has(const struct option_result *result, size_t i)
{
    return (result->given >> i & 1u) != 0;
}
