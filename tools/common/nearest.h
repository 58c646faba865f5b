/* What a mistyped name may have meant. */
#ifndef LUM_TOOLS_NEAREST_H
#define LUM_TOOLS_NEAREST_H

#include <stddef.h>

/* The name that differs by the fewest letters, if these are at most two and
 * less than half of its own; NULL if none is near. */
const char *nearest(const char *text, const char *const *names, size_t count);

#endif
