/* What kind of file a name is. */
#ifndef LUM_TOOLS_FILE_LOOK_H
#define LUM_TOOLS_FILE_LOOK_H

#include <stdbool.h>
#include <stdint.h>

enum file_kind {
    FILE_REGULAR,
    FILE_DIRECTORY,
    FILE_PIPE, /* that has a name, or a standard stream that is one */
    FILE_DEVICE
};

struct file_look {
    enum file_kind kind;
    uint64_t volume; /* with number, the same for two names of one file; both
                        0: not known */
    uint64_t number;
    uint64_t bytes;     /* of a regular file */
    int64_t modified_s; /* since 1970, rounded down; of a regular file */
};

/* Links are followed. name: "-" for standard output. False: there is none, or
 * it may not be looked at. */
bool file_look(const char *name, struct file_look *out);

/* The same, but a link is looked at itself, and is no regular file; "-" is a
 * file of this name. */
bool file_look_itself(const char *name, struct file_look *out);

/* As file_look(), but "-" is standard input. */
bool file_look_input(const char *name, struct file_look *out);

bool file_look_is_same(const struct file_look *a, const struct file_look *b);

/* Whether opening a pipe by this name would wait for its reader. */
bool file_look_opens_late(const char *name);

/* Whether it is a link to a missing file. */
bool file_look_is_dangling(const char *name);

#endif
