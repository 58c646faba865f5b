/* The layout of the packets that are sent. */
#ifndef LUMSIM_LAYOUT_H
#define LUMSIM_LAYOUT_H

#include "options.h"

#include <stdbool.h>

/* Where the profile is from, for messages. */
const char *layout_source(const struct options *o);

/* Take a profile's layout into o->render. False: packets cannot be made of it;
 * complains. */
bool layout_take(struct options *o, const lum_profile *profile);

#endif
