/** @file
 * The shape of fields whose values are known: bytes that are always 0, and
 * bytes that fields share. Internal. */
#ifndef LUM_INFER_SHAPE_H
#define LUM_INFER_SHAPE_H

#include "infer/state.h"

/** Give fields their shape. Values do not change. */
void lum_infer_shape(lum_infer_state *state);

/** Whether two fields share bytes as no profile can say.
 * @param one which, if so
 * @param two the other one */
bool lum_infer_clash(const lum_infer_state *state, unsigned *one,
                     unsigned *two);

/** A wider field with the same values, all of whose further bytes are 0 and of
 * no other field.
 * @return false: there is none. */
bool lum_infer_wider(const lum_infer_state *state, lum_field field,
                     lum_field *out);

#endif
