/** @file
 * A point's coordinates, four numbers at once where the compiler can. Internal
 * to points. */
#ifndef LUM_POINTS_COORDINATES_H
#define LUM_POINTS_COORDINATES_H

#include "lum/points.h"

#include <string.h>

/** Write x, y, z and a fourth number without meaning: range * d + mount. */
static inline void lum_put_lanes(void *to, float range, const lum_direction *d,
                                 const lum_direction *mount)
{
#if defined(__GNUC__)
    typedef float lanes __attribute__((vector_size(16)));
    const lanes at = {range, range, range, range};
    lanes direction;
    lanes offset;
    memcpy(&direction, d, sizeof direction);
    memcpy(&offset, mount, sizeof offset);
    const lanes v = at * direction + offset;
    memcpy(to, &v, sizeof v);
#else
    const lum_direction v = {range * d->x + mount->x, range * d->y + mount->y,
                             range * d->z + mount->z, 0.0f};
    memcpy(to, &v, sizeof v);
#endif
}

#endif
