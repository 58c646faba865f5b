/* The code that reads the packets of one layout. */
#ifndef LUMTABLE_LAYOUT_H
#define LUMTABLE_LAYOUT_H

#include "lum/profile.h"
#include "source.h"

void layout_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout);

#endif
