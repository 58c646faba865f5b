/* Whether two names are of one file. */
#ifndef LUM_TOOLS_SAME_FILE_H
#define LUM_TOOLS_SAME_FILE_H

#include <stdbool.h>

/* Through links and hard links too; "-" is standard input, and standard output.
 * Only for regular files: other files cannot be overwritten. */
bool same_file(const char *input, const char *output);

#endif
