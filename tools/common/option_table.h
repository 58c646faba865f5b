/* Options of a command line, by a table, on top of getopt_long(): their order,
 * their values, and the messages for wrong ones. Options and words may come in
 * any order; "--" ends the options. Names of options cannot be abbreviated: the
 * beginning of a name must not switch a laser on. */
#ifndef LUM_TOOLS_OPTION_TABLE_H
#define LUM_TOOLS_OPTION_TABLE_H

#include "lum/base/error.h"
#include "lum/version.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most options of a table. */
#define OPTIONS_MAX 60

/* What an option does with the field that it names. */
enum option_kind {
    OPTION_FLAG,  /* takes nothing: sets a bool */
    OPTION_SHOW,  /* takes nothing: shows something, and ends the reading */
    OPTION_TEXT,  /* keeps its text, which is not empty, in a const char * */
    OPTION_WORD,  /* one of some words: its number into an unsigned, an enum or
                     a bool */
    OPTION_WHOLE, /* a whole number from min to max, into an integer */
    OPTION_REAL,  /* a number from low to high, into a double */
    OPTION_SIZE,  /* bytes from low to high, with a unit, into an unsigned
                     integer */
    OPTION_CALL   /* calls a function with its field and its text */
};

/* A word that an option takes, and its number; the last has no text. */
struct option_word {
    const char *text;
    unsigned number;
};

struct option_spec {
    const char *name;
    char letter; /* 0: none */
    enum option_kind kind;
    unsigned group; /* which commands or modes have it; the tool's own bits */
    size_t at;      /* its field in the tool's options, and how large it is */
    size_t size;
    size_t has; /* a bool that it also sets; 0: none */
    int64_t min;
    int64_t max;
    double low;
    double high;
    const struct option_word *words;
    /* Without a field it gets the options. False: why says the reason, or is
     * empty for "'TEXT' is not ALLOWED". */
    bool (*call)(void *field, const char *text, lum_error *why);
    void (*show)(void); /* NULL: the text is shown */
    const char *text;
    const char *value;   /* what it takes, for --help; may be NULL */
    const char *allowed; /* of a value; NULL: as its kind says */
    const char *help;    /* what it does, for --help; may be NULL */
};

/* The field of an option. */
#define OPTION_INTO(type, field)                                               \
    .at = offsetof(type, field), .size = sizeof(((type *)NULL)->field)

/* What help.txt of the tool's folder says. */
extern const char help_text[];

/* Of each tool, at the end of its table. */
#define OPTION_HELP                                                            \
    {                                                                          \
        "help", .letter = 'h', .kind = OPTION_SHOW, .text = help_text          \
    }
#define OPTION_VERSION(program)                                                \
    {                                                                          \
        "version", .kind = OPTION_SHOW, .text = program " " LUM_VERSION "\n"   \
    }

struct option_table {
    const char *program; /* begins each message */
    const char *help;    /* where to find more, for example "lumctl --help" */
    const struct option_spec *specs;
    size_t count;
    bool has_negatives; /* words such as -1 and -.5 are no options */
};

/* What was read. */
struct option_result {
    int count;      /* words, now from argv[1] on */
    uint64_t given; /* a bit for each option, by its place in the table */
    const char *text[OPTIONS_MAX]; /* what it took last, by the same; NULL:
                                      nothing */
};

enum option_end {
    OPTIONS_READ,
    OPTIONS_SHOWN,  /* an OPTION_SHOW was given */
    OPTIONS_REFUSED /* a message was printed */
};

/* Reads the options of a command line into the tool's; argv[0] is the program.
 * The text of options and words is not copied. Not for two threads at once. */
enum option_end option_table_read(const struct option_table *table, int argc,
                                  char **argv, void *options,
                                  struct option_result *out);

/* Whether an option was given. */
bool option_table_has(const struct option_result *result, size_t i);

#endif
