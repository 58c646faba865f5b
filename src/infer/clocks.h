/** @file
 * The sensor's clock, and how long its ticks and lines are. Internal. */
#ifndef LUM_INFER_CLOCKS_H
#define LUM_INFER_CLOCKS_H

#include "infer/state.h"

/** Find which bits follow the time of capture, before it is known which are the
 * line's and the eye's: as a whole they are a clock, and alone none of them
 * tells the eye.
 * @return 0, or -1 without memory. */
int lum_infer_follow_time(lum_infer_state *state);

/** Find the clock among what other fields have left: it rises as the time of
 * capture does. Its unit and the length of lines come with it.
 * @return 0, or -1 without memory. */
int lum_infer_find_clock(lum_infer_state *state);

#endif
