/* The loops of lum_kernels in vectors of LUM_LANES numbers. Each file that
 * includes this makes them for one kind of processor. */
#include "../kernels.h"
#include "vector.h"

#include "../column_loops.h"
#include "../motion_loops.h"

/* --- Directions --- */

/* Of LUM_LANES pixels. */
LUM_IN_LOOP void put_directions(const lum_polynomials *polynomials,
                                const lum_angle *angles, lum_direction *out)
{
    const whole pairs = SPREAD(load_whole(angles));
    const whole azimuth = (whole)((bits)pairs << 16) >> 16;
    const whole elevation = pairs >> 16;
    number v[4] = {{0}};
    lum_polynomials_compute(polynomials, to_number(azimuth),
                            to_number(elevation), &v[0], &v[1], &v[2]);
    turn_groups(v);
    for (unsigned r = 0; r < 4; r++) {
        store_number(&out[GROUPS * r], v[r]);
    }
}

/* A last vector that is not full takes pixels of the one before again. */
static void compute_directions(const lum_polynomials *polynomials,
                               const lum_angle *angles, lum_direction *out)
{
    const unsigned last = LUM_LINE_PIXELS - LUM_LANES;
    const lum_polynomials own = *polynomials; /* which out cannot be part of */
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i += LUM_LANES) {
        const unsigned at = i < last ? i : last;
        put_directions(&own, angles + at, out + at);
    }
}

/* --- Points --- */

LUM_IN_LOOP uint32_t sum_of(whole v)
{
    uint32_t sum = 0;
    for (unsigned i = 0; i < LUM_LANES; i++) {
        sum += (uint32_t)v[i];
    }
    return sum;
}

/* A time of flight is in a word's upper 20 bits, signed. What is true is -1. */
static uint32_t count_below(const uint32_t *words, uint32_t n, int32_t min_tof,
                            uint32_t *rising)
{
    const uint32_t end = n / LUM_LANES * LUM_LANES;
    whole below = {0};
    whole up = {0};
    for (uint32_t i = 0; i < end; i += LUM_LANES) {
        const whole word = load_whole(words + i);
        const whole is_below = word >> 12 < min_tof;
        const whole rises = (word & (int32_t)LUM_WORD_RISING) != 0;
        below -= is_below;
        up -= rises & ~is_below;
    }
    const uint32_t rest =
        lum_plain_count_below(words + end, n - end, min_tof, rising);
    *rising += sum_of(up);
    return rest + sum_of(below);
}

#if LUM_LANES > 4
/* By eight words, whatever the processor has: a table of their places has 256
 * rows then. */
static uint32_t choose(const lum_word_choice *choice, const uint32_t *words,
                       uint32_t n, uint32_t *out)
{
    const uint32_t end = n / 8u * 8u;
    const lum_word_choice own = *choice;
    uint32_t count = 0;
    for (uint32_t i = 0; i < end; i += 8u) {
        const eight word = load_eight(words + i);
        const eight chosen = (word >> 12 >= own.min_tof) &
                             ((word & (int32_t)own.mask) == (int32_t)own.value);
        count += store_chosen(out + count, word, chosen);
    }
    return count + lum_plain_choose(choice, words + end, n - end, out + count);
}

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
    const number v = range * load_directions(directions, words, 1) + m->mount;
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

#else
/* Baseline processors cannot move words by a table, and plain C has as many
 * numbers at once. */
#define choose         lum_plain_choose
#define compute_points lum_plain_points
#endif

/* --- Columns --- */

/* As the compiler makes vector code of it for this processor. */
static void compute_ranges(const lum_eye_projector *eye, const uint32_t *words,
                           uint32_t n, float *restrict out)
{
    const double lsb = eye->range_lsb;
    const double offset = eye->range_offset;
    for (uint32_t i = 0; i < n; i++) {
        out[i] = (float)(lum_word_tof(words[i]) * lsb + offset);
    }
}

/* Of LUM_LANES words. Vector c has the directions of words c, c + 4, c + 8...,
 * so that their order is that of the words when they are columns. */
LUM_IN_LOOP void put_columns(const lum_column_source *from, uint32_t at,
                             float *x, float *y, float *z)
{
    const number range = load_number(from->ranges + at);
    const float *mount = from->mount;
    number v[4];
    for (unsigned c = 0; c < 4; c++) {
        v[c] = load_directions(from->directions, from->words + at + c, 4);
    }
    turn_groups(v);
    store_number(x + at, range * v[0] + mount[0]);
    store_number(y + at, range * v[1] + mount[1]);
    store_number(z + at, range * v[2] + mount[2]);
}

static void compute_columns(const lum_column_source *from, float *x, float *y,
                            float *z)
{
    const uint32_t end = from->count / LUM_LANES * LUM_LANES;
    const float mount[3] = {from->mount[0], from->mount[1], from->mount[2]};
    const lum_column_source own = {from->words, from->ranges, end,
                                   from->directions, mount};
    for (uint32_t i = 0; i < end; i += LUM_LANES) {
        put_columns(&own, i, x, y, z);
    }
    const lum_column_source rest = {from->words + end, from->ranges + end,
                                    from->count - end, from->directions,
                                    from->mount};
    lum_plain_columns(&rest, x + end, y + end, z + end);
}

/* --- Other columns, and motion --- */

#if LUM_LANES > 4
static void compute_numbers(const lum_column_numbers *from,
                            const lum_column_places *to)
{
    lum_numbers_loop(from, to);
}

static void compute_times(float *pixels, size_t n, int64_t from_ns,
                          int64_t period_ns)
{
    lum_times_loop(pixels, n, from_ns, period_ns);
}

static size_t count_times(const lum_motion *motion, const float *time, size_t n)
{
    return lum_count_loop(motion, time, n);
}

static void move_points(const lum_motion *motion, const lum_motion_points *from,
                        size_t n, float *const out[3])
{
    for (unsigned row = 0; row < 3u; row++) {
        lum_move_loop(motion, from, n, out[row], row);
    }
}
#else
#define compute_numbers lum_plain_numbers
#define compute_times   lum_plain_times
#define count_times     lum_plain_count
#define move_points     lum_plain_move
#endif

/* --- Pictures --- */

static void compute_pixels(const lum_image_scale *scale, const float *x,
                           const float *y, const float *z, size_t n,
                           uint32_t *out)
{
    const size_t end = n / LUM_LANES * LUM_LANES;
    const lum_image_scale own = *scale; /* which out cannot be part of */
    for (size_t i = 0; i < end; i += LUM_LANES) {
        const whole pixel = lum_pixel_compute(
            &own, load_number(x + i), load_number(y + i), load_number(z + i));
        memcpy(out + i, &pixel, sizeof pixel);
    }
    lum_plain_pixels(scale, x + end, y + end, z + end, n - end, out + end);
}

#define LUM_KERNELS(name)                                                      \
    {                                                                          \
        name, compute_directions, count_below, choose, compute_points,         \
            compute_ranges, compute_columns, compute_numbers, compute_times,   \
            count_times, move_points, compute_pixels                           \
    }
