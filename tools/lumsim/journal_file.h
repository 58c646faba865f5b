/* The file of a log: there from its first line on, and one run's alone. */
#ifndef LUMSIM_JOURNAL_FILE_H
#define LUMSIM_JOURNAL_FILE_H

#include "lum/base/error.h"

#include <stdio.h>

struct journal_file;

/* Make it anew. stream: to write to. 0, or -1 with the reason in error. */
int journal_file_open(const char *path, struct journal_file **out,
                      FILE **stream, lum_error *error);

/* Close the stream and free it. 0, or the errno of what could not be written.
 */
int journal_file_close(struct journal_file *file);

#endif
