/** @file
 * Where an output's bytes end up: in a file that gets its name when it is whole
 * or when it begins, or in place where the output is no regular file. Internal.
 *
 * Until a file has its name it stands beside it as `NAME.0123456789ab.part`,
 * under a number that no other file has, and is locked. As long as an output is
 * open nobody else may write one of its name (base/claim.h). */
#ifndef LUM_BASE_OUTFILE_H
#define LUM_BASE_OUTFILE_H

#include "base/claim.h"
#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/** When a file gets its name. */
typedef enum lum_outfile_kind {
    LUM_OUTFILE_WHOLE, /**< by lum_outfile_finish() */
    LUM_OUTFILE_GROWS  /**< by lum_outfile_show(), and then it stays */
} lum_outfile_kind;

/** An output that is open. */
typedef struct lum_outfile {
    char *name;       /**< as the caller gave it, for messages */
    char *path;       /**< its final name; NULL: written in place */
    char *part;       /**< its present name, while it is another */
    int fd;           /**< to write to */
    bool seekable;    /**< a regular file, not opened to append */
    bool may_block;   /**< no regular file: its reader may take his time */
    int64_t base;     /**< where our first byte stands; 0 if not seekable */
    dev_t device;     /**< of the file made, to know it again */
    ino_t inode;      /**< likewise */
    size_t unstarted; /**< bytes whose way to the disk has not begun */
    bool owes_name;   /**< it has its name, and the disk need not */
    lum_claim claim;  /**< to its name */
} lum_outfile;

/** Open an output. A file that is there stays as it is until it is replaced,
 * and gives its mode, and its owner where this process may, to what replaces
 * it; links to files are followed. Where a growing file cannot be made anew
 * since its directory may not be written in, the one that is there is emptied.
 * @param path its name, or "-" for standard output, which is duplicated.
 * @param out  written only on success.
 * @return 0, or -1 with the reason in error and in errno: EBUSY if another
 *         process, or another output of this one, writes it. */
LUM_MUST_CHECK int lum_outfile_open(const char *path, lum_outfile_kind kind,
                                    lum_outfile *out, lum_error *error);

/** Give it its name before it is whole, if it has another. From then on it
 * stays, whatever becomes of the rest. Does not wait for the disk, which gets
 * the name for certain by lum_outfile_finish().
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_show(lum_outfile *file, lum_error *error);

/** Tell that n bytes more were written, so that the disk begins with them while
 * more are made. */
void lum_outfile_wrote(lum_outfile *file, size_t n);

/** Close it and give it its name, once its bytes are on the disk, and then wait
 * until the name is; those of what is written in place are the reader's.
 * lum_outfile_discard() has to follow.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_finish(lum_outfile *file, lum_error *error);

/** Free it; what has not got its name is removed. */
void lum_outfile_discard(lum_outfile *file);

/** Say what could not be done to it, and why; leave code in errno.
 * @param code an errno.
 * @return -1. */
int lum_outfile_fail(const lum_outfile *file, int code, const char *doing,
                     lum_error *error);

#endif
