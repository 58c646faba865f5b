/* The names of an output's files, and the run's right to them. */
#ifndef LUMDUMP_FILE_NAMES_H
#define LUMDUMP_FILE_NAMES_H

#include "bag_folder.h"
#include "options.h"
#include "retention.h"

#include "base/claim.h"

#define FILE_NAME_BYTES 4096u

struct file_names {
    enum {
        FILE_NAMES_ONE,       /* the output is one file */
        FILE_NAMES_OF_FRAMES, /* each frame has a file */
        FILE_NAMES_NUMBERED,  /* one after another */
        FILE_NAMES_IN_FOLDER  /* of rosbag2, one after another */
    } kind;
    const struct options *options;
    const char *name;            /* as the option gives it */
    unsigned number;             /* of the newest numbered file; 0: none */
    lum_claim claim;             /* to the name of which others are made */
    struct retention *retention; /* NULL: no file is removed */
    struct bag_folder *folder;   /* NULL: there is none */
};

/* Those of the i-th output, without any right to them. */
struct file_names file_names_of(const struct options *options, size_t i);

/* Take the right to all names, if there may be several files; make the folder.
 * 0, or -1 with the reason in error and errno. */
int file_names_take(struct file_names *names, lum_error *error);

/* The name of the next file, or of that of a frame; it may be made in room. One
 * of the run's inputs is refused. NULL with the reason in error and errno. */
const char *file_names_next(struct file_names *names, int64_t frame,
                            char room[FILE_NAME_BYTES], lum_error *error);

/* Whether files of an earlier, longer run follow the newest one; out says so.
 */
bool file_names_find_stale(const struct file_names *names, lum_error *out);

/* Give the right back, if any was taken. */
void file_names_give_back(struct file_names *names);

#endif
