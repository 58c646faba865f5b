/** @file
 * What the sources of an output (base/outfile.h) share. Where nothing else is
 * said, a function returns 0, or -1 with the reason in error and in errno.
 * Internal. */
#ifndef LUM_BASE_OUTFILE_PARTS_H
#define LUM_BASE_OUTFILE_PARTS_H

#include "base/outfile.h"

#include <sys/stat.h>

/* --- Messages: outfile.c. They return -1. --- */

int lum_outfile_refuse(int code, const char *name, const char *why,
                       lum_error *error);

/** The directory does not exist: ENOENT. */
int lum_outfile_refuse_directory(const lum_outfile *file, lum_error *error);

/* --- Each system's: outfile_posix.c, outfile_windows.c --- */

/** As lum_outfile_open(), into a file that has only its name for messages. */
LUM_MUST_CHECK int lum_outfile_system_open(lum_outfile *file,
                                           lum_outfile_kind kind,
                                           const char *path, lum_error *error);

/** Learn whether the output is a file, and where it begins. */
void lum_outfile_system_learn(lum_outfile *file);

/* --- Places on the disk: outfile_io_posix.c --- */

/** Give back those that nothing was written to; if that fails, the file keeps
 * them. */
void lum_outfile_release(const lum_outfile *file);

/* --- The unfinished file: outfile_posix.c --- */

/** Open it under a free number, or set part to NULL. No message. */
LUM_MUST_CHECK int lum_outfile_part_create(lum_outfile *file, mode_t mode);

/** Let only those read it who could read the file that it replaces. */
void lum_outfile_part_keep_mode(const lum_outfile *file,
                                const struct stat *old);

/** Lock the file that is open, and note what it is known by. */
LUM_MUST_CHECK int lum_outfile_part_settle(lum_outfile *file, lum_error *error);

/** Whether a name is that of the file that is open. */
bool lum_outfile_part_is_at(const lum_outfile *file, const char *name);

/** Close the file; an unfinished one is removed, unless its name is another
 * file's by now. On Windows in outfile_windows.c. */
void lum_outfile_part_drop(lum_outfile *file);

/* --- A file without its name: outfile_lost_posix.c --- */

/** The message what became of it, where (a name, or ""), rest: ENOENT; -1. */
int lum_outfile_lost_fail(const lum_outfile *file, const char *what,
                          const char *where, const char *rest,
                          lum_error *error);

/** At the end: lum_outfile_check(), and a removed file is put back. */
LUM_MUST_CHECK int lum_outfile_lost_recover(const lum_outfile *file,
                                            lum_error *error);

#endif
