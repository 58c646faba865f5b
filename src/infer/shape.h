/** @file
 * The shape of fields whose values are known: bytes that are always 0, and
 * bytes that fields share. Internal. */
#ifndef LUM_INFER_SHAPE_H
#define LUM_INFER_SHAPE_H

#include "infer/state.h"

/** Give fields their shape. Values do not change. */
void lum_infer_shape(lum_infer_state *state);

/** A wider field with the same values, all of whose further bytes are 0 and of
 * no other field.
 * @return false: there is none. */
bool lum_infer_wider(const lum_infer_state *state, lum_field field,
                     lum_field *out);

#endif
