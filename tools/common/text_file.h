/* A text to a file that stands under its name only when it is whole. */
#ifndef LUM_TOOLS_TEXT_FILE_H
#define LUM_TOOLS_TEXT_FILE_H

#include "lum/base/error.h"

#include <stddef.h>

/* path: "-" is standard output; a link is followed. 0, or -1 with the reason in
 * error and in errno: EPIPE where its reader has left. */
int text_file_save(const char *path, const char *text, size_t len,
                   lum_error *error);

#endif
