/* The captures that a run reads. */
#ifndef LUMDUMP_SOURCES_H
#define LUMDUMP_SOURCES_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Room for what several are called together. */
#define SOURCES_NAME_BYTES 1024u

struct source_identity;

struct sources {
    const char *const *paths; /* "-" is standard input */
    size_t count;             /* 0: a sensor */
    char name[SOURCES_NAME_BYTES];
    struct source_identity *identities; /* of those that are there, sorted */
    size_t identity_count;
};

/* paths: kept. Call sources_free() after it, with any result. 0; -1 with the
 * reason in error: there is no memory, or two names are of one file. A file
 * that cannot be opened is reported when it is its turn. */
int sources_init(struct sources *out, const char *const *paths, size_t count,
                 lum_error *error);

void sources_free(struct sources *sources);

/* Whether a name, "-" for standard output, stands for one of them. Only for
 * regular files: other files cannot be overwritten. */
bool sources_have(const struct sources *sources, const char *output);

/* Whether all can be read twice. */
bool sources_are_files(const struct sources *sources);

#endif
