/* The loops of lum_kernels in vectors of LUM_LANES numbers. Each file that
 * includes this makes them for one kind of processor. */
#include "kernels.h"
#include "vector.h"

/* --- Directions --- */

/* Of LUM_LANES pixels. */
LUM_IN_LOOP void put_directions(const lum_turn *turn, const lum_angle *angles,
                                lum_direction *out)
{
    const whole pairs = SPREAD(load_whole(angles));
    const whole azimuth = (whole)((bits)pairs << 16) >> 16;
    const whole elevation = pairs >> 16;
    number v[4] = {{0}};
    lum_turn_to(turn, to_number(azimuth), to_number(elevation), &v[0], &v[1],
                &v[2]);
    turn_groups(v);
    for (unsigned r = 0; r < 4; r++) {
        store_number(&out[GROUPS * r], v[r]);
    }
}

/* A last vector that is not full takes pixels of the one before again. */
static void compute_directions(const lum_turn *turn, const lum_angle *angles,
                               lum_direction *out)
{
    const unsigned last = LUM_LINE_PIXELS - LUM_LANES;
    const lum_turn own = *turn; /* which out cannot be part of */
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i += LUM_LANES) {
        const unsigned at = i < last ? i : last;
        put_directions(&own, angles + at, out + at);
    }
}

/* --- Points --- */

/* A time of flight is in a word's upper 20 bits, signed. */
static uint32_t count_below(const uint32_t *words, uint32_t n, int32_t min_tof)
{
    const uint32_t end = n / LUM_LANES * LUM_LANES;
    whole below = {0};
    for (uint32_t i = 0; i < end; i += LUM_LANES) {
        below -= load_whole(words + i) >> 12 < min_tof; /* -1 where it is so */
    }
    uint32_t sum = lum_plain_count_below(words + end, n - end, min_tof);
    for (unsigned i = 0; i < LUM_LANES; i++) {
        sum += (uint32_t)below[i];
    }
    return sum;
}

#if LUM_LANES > 4
/* What all points of an eye are made with. */
struct maker {
    number mount; /* in each group */
    float range_lsb;
    float range_offset;
};

/* The points of GROUPS words. A word takes the place of the fourth number. */
LUM_IN_LOOP void put_points(const struct maker *m, const uint32_t *words,
                            const lum_direction *directions, lum_point *out)
{
    const whole word = load_to_groups(words);
    const number range = to_number(word >> 12) * m->range_lsb + m->range_offset;
    const number v = range * load_directions(directions, words) + m->mount;
    store_number(out, WITH_FOURTH(v, (number)word));
}

static void compute_points(const lum_eye_projector *eye, const uint32_t *words,
                           uint32_t n, const lum_direction *directions,
                           lum_point *out)
{
    const uint32_t end = n / GROUPS * GROUPS;
    struct maker maker = {.range_lsb = (float)eye->range_lsb,
                          .range_offset = (float)eye->range_offset};
    for (unsigned i = 0; i < LUM_LANES; i++) {
        maker.mount[i] = i % 4u < 3u ? eye->mount[i % 4u] : 0.0f;
    }
    for (uint32_t i = 0; i < end; i += GROUPS) {
        put_points(&maker, words + i, directions, out + i);
    }
    lum_plain_points(eye, words + end, n - end, directions, out + end);
}

const lum_kernels KERNELS = {NAME, compute_directions, count_below,
                             compute_points};
#else
/* Plain C has as many numbers at once. */
const lum_kernels KERNELS = {NAME, compute_directions, count_below,
                             lum_plain_points};
#endif
