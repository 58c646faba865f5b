/** @file
 * The line number and the eye: what makes lines and frames come together.
 * Internal. */
#ifndef LUM_INFER_LINES_H
#define LUM_INFER_LINES_H

#include "infer/state.h"

/** Find the line number and the eye, which only together make sense: for each
 * eye, the number rises by 1 from line to line.
 * @return 0, or -1 without memory. */
int lum_infer_find_lines(lum_infer_state *state);

#endif
