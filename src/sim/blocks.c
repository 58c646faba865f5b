#include "blocks.h"

#include "rotation.h"

#include <math.h>

/* Things stand at odd angles and are different on each side, so that no turned
 * view of the place looks like another. They are few, so that much is seen of
 * walls and floor: large faces tell more of an eye than many small ones. */
static const lum_block room[] = {
    {{0.6f, -0.4f, 1.5f}, {8.0f, 6.0f, 3.0f}, {0.0f, 0.0f, 0.0f}, 0.7f},
    /* A crate and a cupboard ahead; behind, a crate, a pillar, a slanted wall.
     */
    {{2.4f, 1.2f, 0.6f}, {0.7f, 1.0f, 1.2f}, {0.0f, 0.0f, 31.0f}, 0.5f},
    {{2.0f, -2.0f, 0.9f}, {1.0f, 0.6f, 1.8f}, {0.0f, 0.0f, 17.0f}, 0.4f},
    {{-1.6f, 1.6f, 0.5f}, {0.8f, 1.2f, 1.0f}, {0.0f, 0.0f, 40.0f}, 0.45f},
    {{-2.2f, -1.8f, 1.5f}, {0.6f, 0.6f, 3.0f}, {0.0f, 0.0f, -20.0f}, 0.6f},
    {{-2.7f, -0.1f, 1.18f}, {0.06f, 1.8f, 2.6f}, {0.0f, 25.0f, 176.0f}, 0.55f},
};

static const lum_block yard[] = {
    {{0.0f, 0.0f, 4.5f}, {30.0f, 20.0f, 9.0f}, {0.0f, 0.0f, 0.0f}, 0.5f},
    /* A garage, a chimney, a ramp, a leaning wall, a crate. */
    {{9.5f, 6.0f, 1.5f}, {6.0f, 5.0f, 3.0f}, {0.0f, 0.0f, 12.0f}, 0.55f},
    {{4.2f, 3.2f, 2.0f}, {0.8f, 0.8f, 4.0f}, {0.0f, 0.0f, 40.0f}, 0.4f},
    {{6.8f, -5.5f, 0.1f}, {5.0f, 3.0f, 1.2f}, {0.0f, -14.0f, 30.0f}, 0.3f},
    {{12.4f, -7.4f, 2.3f}, {0.3f, 6.0f, 5.0f}, {0.0f, 22.0f, -31.0f}, 0.6f},
    {{5.0f, -1.9f, 0.6f}, {1.4f, 1.0f, 1.2f}, {0.0f, 0.0f, 20.0f}, 0.5f},
    /* A garden wall, a shed, a container, crates, a pillar. */
    {{1.5f, 8.0f, 1.0f}, {8.0f, 0.3f, 2.0f}, {0.0f, 0.0f, -5.0f}, 0.45f},
    {{-9.0f, 6.0f, 1.1f}, {4.0f, 3.0f, 2.2f}, {0.0f, 0.0f, -24.0f}, 0.35f},
    {{-8.5f, -5.5f, 1.3f}, {6.0f, 2.4f, 2.6f}, {0.0f, 0.0f, 33.0f}, 0.4f},
    {{-4.0f, 2.6f, 0.5f}, {1.2f, 1.2f, 1.0f}, {0.0f, 0.0f, 55.0f}, 0.5f},
    {{-3.6f, -2.8f, 0.75f}, {1.3f, 1.1f, 1.1f}, {10.0f, 18.0f, -30.0f}, 0.55f},
    {{-0.8f, -7.0f, 1.5f}, {0.6f, 0.6f, 3.0f}, {0.0f, 0.0f, 25.0f}, 0.5f},
};

lum_blocks lum_blocks_of_room(void)
{
    return (lum_blocks){room, sizeof room / sizeof room[0], false};
}

lum_blocks lum_blocks_of_yard(void)
{
    return (lum_blocks){yard, sizeof yard / sizeof yard[0], true};
}

/* How far outside the block a point lies along each of its axes; below 0:
 * inside. */
static void measure(const lum_block *b, const double at[3], double out[3])
{
    float m[9];
    lum_rotation_make((double)b->turn_deg[0], (double)b->turn_deg[1],
                      (double)b->turn_deg[2], m);
    for (int i = 0; i < 3; i++) {
        double along = 0.0;
        for (int k = 0; k < 3; k++) {
            along += (double)m[3 * k + i] * (at[k] - (double)b->middle[k]);
        }
        out[i] = fabs(along) - 0.5 * (double)b->size[i];
    }
}

static bool is_inside(lum_blocks blocks, const double at[3], double margin_m)
{
    double out[3];
    const lum_block *b = &blocks.list[0];
    measure(b, at, out);
    /* Towards the sky nothing is too near. */
    const bool is_high = blocks.is_open && at[2] > (double)b->middle[2];
    return out[0] <= -margin_m && out[1] <= -margin_m &&
           out[2] <= (is_high ? 0.0 : -margin_m);
}

static bool is_outside(const lum_block *b, const double at[3], double margin_m)
{
    double out[3];
    double square = 0.0;
    measure(b, at, out);
    for (int i = 0; i < 3; i++) {
        square += out[i] > 0.0 ? out[i] * out[i] : 0.0;
    }
    return square >= margin_m * margin_m;
}

bool lum_blocks_leave_open(lum_blocks blocks, const double at[3],
                           double margin_m)
{
    if (!is_inside(blocks, at, margin_m)) {
        return false;
    }
    for (size_t i = 1; i < blocks.count; i++) {
        if (!is_outside(&blocks.list[i], at, margin_m)) {
            return false;
        }
    }
    return true;
}
