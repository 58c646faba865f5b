/* Whether two names stand for one file. */
#ifndef LUM_TOOLS_SAME_FILE_H
#define LUM_TOOLS_SAME_FILE_H

#include <stdbool.h>

/* Through links and hard links too; "-" is standard input, and standard output.
 * Only of regular files: what else there is cannot be written over. */
bool same_file(const char *input, const char *output);

#endif
