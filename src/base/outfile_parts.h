/** @file
 * What the sources of an output (base/outfile.h) share. Where nothing else is
 * said, a function returns 0, or -1 with the reason in error and in errno.
 * Internal. */
#ifndef LUM_BASE_OUTFILE_PARTS_H
#define LUM_BASE_OUTFILE_PARTS_H

#include "base/outfile.h"

/* --- Messages: outfile_common.c. They return -1. --- */

int lum_outfile_refuse(int code, const char *name, const char *why,
                       lum_error *error);

/** The directory does not exist: ENOENT. */
int lum_outfile_refuse_directory(const lum_outfile *file, lum_error *error);

#if defined(_WIN32)
/** What an error of Windows is: an errno; 0: the call is to be made again. */
int lum_outfile_code(unsigned long error);
#endif

/* --- Each system's: outfile_posix.c, outfile_windows.c --- */

/** As lum_outfile_open(), into a file that has only its name for messages. */
LUM_MUST_CHECK int lum_outfile_system_open(lum_outfile *file,
                                           lum_outfile_kind kind,
                                           const char *path, lum_error *error);

/** Learn whether the output is a file, and where it begins. */
void lum_outfile_system_learn(lum_outfile *file);

/** Close the file; an unfinished one is removed, unless its name is another
 * file's by now. */
void lum_outfile_part_drop(lum_outfile *file);

/* --- Places on the disk: outfile_io_posix.c --- */

/** Give back those that nothing was written to; if that fails, the file keeps
 * them. */
void lum_outfile_release(const lum_outfile *file);

#endif
