/* Where x, y and z of points in the world are 0. */
#ifndef LUMDUMP_WORLD_H
#define LUMDUMP_WORLD_H

#include "pose_motion.h"

/* Note the origin for the outputs, and say it. motion: NULL if nothing moves.
 * -1 with the reason in error: an output would not name it. */
int world_begin(struct options *options, const struct motion *motion,
                lum_error *error);

#endif
