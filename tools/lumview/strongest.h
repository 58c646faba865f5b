/* Which points have the widest pulse of their pixel and edge. */
#ifndef LUMVIEW_STRONGEST_H
#define LUMVIEW_STRONGEST_H

#include "lum/points.h"

#include <stddef.h>
#include <stdint.h>

/* Marks samples of a line as LUM_RETURNS_STRONGEST chooses them: out gets 1 or
 * 0 of each. samples: of the line, in its words' order. returns: room for all
 * words of the line; overwritten. Linear. */
void strongest_mark(const lum_line *line, lum_return *returns,
                    const lum_sample *samples, size_t count, uint8_t *out);

#endif
