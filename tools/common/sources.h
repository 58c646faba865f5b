/* The captures that a run reads, also those in a folder of rosbag2. */
#ifndef LUM_TOOLS_SOURCES_H
#define LUM_TOOLS_SOURCES_H

#include "input_files.h"
#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* So much of a file is read beforehand to learn what the sensor's clock does: a
 * clock that is off by 50 ppm has shifted by 200 us then. */
#define SOURCES_LEARN_NS INT64_C(4000000000)

/* Room for what several are called together. */
#define SOURCES_NAME_BYTES 1024u

struct source_identity;

struct sources {
    const char *const *paths; /* "-" is standard input; a folder of rosbag2 is
                                 the files in it */
    size_t count;             /* 0: a sensor */
    char **expanded;          /* the same list, if there is such a folder */
    lum_error folder_error;   /* "", or why the first folder has none */
    char name[SOURCES_NAME_BYTES];
    struct source_identity *identities; /* of those that are there, sorted */
    size_t identity_count;
};

/* paths: kept. To be freed by sources_free() whatever the result. 0; -1 with
 * the reason in error: there is no memory, one of several is a sensor, one is
 * an address and no file, or two are one file, by whatever names. What cannot
 * be opened is told when it is. */
int sources_init(struct sources *out, const char *const *paths, size_t count,
                 lum_error *error);

/* To be asked before they are opened. 0, or -1 with the reason in error: one is
 * a folder without captures. */
int sources_check_folders(const struct sources *sources, lum_error *error);

void sources_free(struct sources *sources);

/* Look at one output, as input_files_check(): it is none of the sources, nor of
 * the other files that the run reads. */
int sources_check(const struct sources *sources,
                  const struct input_file *inputs, size_t count,
                  const char *output, lum_error *error);

/* The name by which standard input is one of them; NULL: it is none. */
const char *sources_find_stdin(const struct sources *sources);

/* Whether it can be read twice. */
bool sources_is_file(const char *path);

/* Whether all can. */
bool sources_are_files(const struct sources *sources);

#endif
