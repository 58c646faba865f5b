/** @file
 * The second best reading. Internal. */
#ifndef LUM_INFER_SECOND_H
#define LUM_INFER_SECOND_H

#include "infer/state.h"

/** Set the second best reading of a result: the profile with the rival of a
 * field. There is none if no profile can say it, or if it decodes the packets
 * as the profile does.
 * @param field a ::lum_group_field. */
void lum_infer_second(const lum_infer_state *state, unsigned field,
                      lum_infer_result *out);

#endif
