/** @file
 * Readings of line number and eye, which only together make sense. Internal. */
#ifndef LUM_INFER_READINGS_H
#define LUM_INFER_READINGS_H

#include "infer/state.h"

/** Find the line number and the eye: eyes take turns, and for each of them the
 * number rises by 1 from line to line. The clock's bits are known already. With
 * one eye alone, only the line number is taken.
 * @return 0, or -1 without memory. */
int lum_infer_find_lines(lum_infer_state *state);

/** With one eye alone, once all other fields are known: a place for the eye.
 * @return 0, or -1 without memory. */
int lum_infer_place_one_eye(lum_infer_state *state);

#endif
