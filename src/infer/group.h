/** @file
 * The fields that an identity of the manual gives away: the tag, the number of
 * samples, the first sample's index. Internal. */
#ifndef LUM_INFER_GROUP_H
#define LUM_INFER_GROUP_H

#include "infer/state.h"

/** Find the tag: 2 where samples are angles, 3 where they are ranges. */
void lum_infer_find_tag(lum_infer_state *state);

/** Find num_samples: 4 times it, and the samples' offset, is the length. */
void lum_infer_find_num_samples(lum_infer_state *state);

/** Find first_sample_index: 0, 334, 668 of angles; of ranges, the words that
 * came before. */
void lum_infer_find_first(lum_infer_state *state);

#endif
