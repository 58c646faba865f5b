#include "zone.h"

#include "lum/group.h"

#define MM_SQUARE ((uint64_t)LUM_FIXED_PER_MM * LUM_FIXED_PER_MM)

zone_sight zone_empty(void)
{
    return (zone_sight){.nearest_square = UINT64_MAX};
}

static uint64_t square(int32_t length)
{
    return (uint64_t)((int64_t)length * length);
}

static bool in_box(const zone *z, const lum_fixed_point *p)
{
    return p->x >= z->min[0] && p->x <= z->max[0] && p->y >= z->min[1] &&
           p->y <= z->max[1] && p->z >= z->min[2] && p->z <= z->max[2];
}

static bool in_sector(const zone *z, const lum_fixed_point *p)
{
    const int64_t y = (int64_t)p->y * ZONE_SLOPE_ONE;

    return p->x > 0 && y <= (int64_t)p->x * z->left &&
           y >= (int64_t)p->x * z->right &&
           square(p->x) + square(p->y) <= square(z->range);
}

bool zone_holds(const zone *z, const lum_fixed_point *point)
{
    return in_box(z, point) && (z->range == 0 || in_sector(z, point));
}

void zone_look(const zone *z, zone_sight *sight, const lum_fixed_point *points,
               size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const lum_fixed_point *p = &points[i];
        if (!lum_word_is_rising(p->word) || !zone_holds(z, p)) {
            continue;
        }
        const uint64_t distance = square(p->x) + square(p->y) + square(p->z);
        sight->hits++;
        if (distance < sight->nearest_square) {
            sight->nearest_square = distance;
        }
    }
}

/* A bit of the root for two of the square; rounds down. */
static uint32_t root(uint64_t value)
{
    uint64_t result = 0;

    for (uint64_t bit = UINT64_C(1) << 62; bit != 0; bit >>= 2) {
        if (value >= result + bit) {
            value -= result + bit;
            result = (result >> 1) + bit;
        } else {
            result >>= 1;
        }
    }
    return (uint32_t)result;
}

uint32_t zone_nearest_mm(const zone_sight *sight)
{
    return sight->hits == 0 ? 0 : root(sight->nearest_square / MM_SQUARE);
}
