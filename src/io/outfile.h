/** @file
 * Where an output's bytes end up: under NAME.part until they are whole, or in
 * place where the output is no regular file. Internal to the io layer. */
#ifndef LUM_IO_OUTFILE_H
#define LUM_IO_OUTFILE_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stdint.h>

/** An output that is open. */
typedef struct lum_outfile {
    char *name;     /**< as the caller gave it, for messages */
    char *path;     /**< its final name; NULL: written in place */
    char *part;     /**< its present name; NULL: written in place */
    int fd;         /**< to write to */
    bool seekable;  /**< a regular file, not opened to append */
    bool may_block; /**< no regular file: its reader may take his time */
    int64_t base;   /**< where our first byte stands; 0 if not seekable */
} lum_outfile;

/** Open an output. A file that is there stays as it is until
 * lum_outfile_finish(); links to files are followed; NAME.part of an earlier
 * run is removed.
 * @param path its name, or "-" for standard output, which is duplicated.
 * @param out  written only on success.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_open(const char *path, lum_outfile *out,
                                    lum_error *error);

/** Close it and give it its name. lum_outfile_discard() has to follow.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_finish(lum_outfile *file, lum_error *error);

/** Free it; what lum_outfile_finish() has not named is removed. */
void lum_outfile_discard(lum_outfile *file);

/** Say what could not be done to it, and why; leave code in errno.
 * @param code an errno.
 * @return -1. */
int lum_outfile_fail(const lum_outfile *file, int code, const char *doing,
                     lum_error *error);

#endif
