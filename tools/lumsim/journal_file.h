/* The file of a log: it exists from its first line on, and only one run can
 * write it. */
#ifndef LUMSIM_JOURNAL_FILE_H
#define LUMSIM_JOURNAL_FILE_H

#include "lum/base/error.h"

#include <stdio.h>

struct journal_file;

/* Create or replace it. stream: to write to. 0, or -1 with the reason in
 * error. */
int journal_file_open(const char *path, struct journal_file **out,
                      FILE **stream, lum_error *error);

/* Close the stream and free it. 0, or the errno of what could not be written.
 */
int journal_file_close(struct journal_file *file);

#endif
