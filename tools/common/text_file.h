/* A text to a file that stands under its name only when it is whole. */
#ifndef LUM_TOOLS_TEXT_FILE_H
#define LUM_TOOLS_TEXT_FILE_H

#include "base/outfile.h"
#include "lum/base/error.h"

#include <stddef.h>

/* path: "-" is standard output; a link is followed. 0, or -1 with the reason in
 * error and in errno: EPIPE where its reader has left. */
int text_file_save(const char *path, const char *text, size_t len,
                   lum_error *error);

/* The same, but its name waits for lum_outfile_finish(), and
 * lum_outfile_discard() ends it. On -1 nothing is left to do. */
int text_file_begin(const char *path, const char *text, size_t len,
                    lum_outfile *file, lum_error *error);

#endif
