/* A layout and a projector as constants. */
#ifndef LUMTABLE_TABLES_H
#define LUMTABLE_TABLES_H

#include "lum/points_fixed.h"
#include "lum/profile.h"
#include "source.h"

void tables_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout,
                  const lum_fixed_projector *projector);

#endif
