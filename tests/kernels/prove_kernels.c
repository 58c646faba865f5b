/* prove_kernels [LINES [SEED]]: that every kind of vector code this processor
 * can run gives the bits of plain C, over random lines of random calibrations;
 * 20,000 where it is not said. Also that lum_points_compute(), with the code
 * that is in use (LUM_CPU), gives the points of each word alone.
 * Status 2 where the arguments are not numbers from 1 on. */
#include "points/kernels.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MICRO 1000000
/* 45 degrees of 32,768 bits */
#define NARROW_LSB_PDEG UINT64_C(1373291015)
#define EACH            50u   /* lines of a calibration */
#define WORDS_MAX       1200u /* more than four blocks */
#define SPARE           16u   /* behind the end, where nothing may be written */
#define NOT_OVERWRITE   0xa5

/* A random line of a random eye. */
typedef struct bench {
    lum_projector projector;
    lum_eye_projector *eye; /* in it */
    lum_polynomials polynomials;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS_MAX];
    lum_direction expected[LUM_LINE_PIXELS + SPARE];
    lum_direction directions[LUM_LINE_PIXELS + SPARE];
    lum_point expected_points[WORDS_MAX + SPARE];
    lum_point points[WORDS_MAX + SPARE];
} bench;

static uint32_t draw(uint64_t *seed)
{
    uint64_t z = *seed += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)(z >> 32);
}

static int32_t between(uint64_t *seed, int32_t min, int32_t max)
{
    return min + (int32_t)(draw(seed) % (uint32_t)(max - min + 1));
}

/* --- Random lines --- */

/* Angles of up to 45 degrees either way, which the polynomials reach. */
static bool draw_eye(bench *b, uint64_t *seed)
{
    const int32_t turn = 360 * MICRO;
    const unsigned eye = draw(seed) % LUM_EYES;
    lum_calibration c;
    lum_layout layout;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    lum_eye_calibration *e = &c.eye[eye];
    const int32_t middle = between(seed, -45 * MICRO, 45 * MICRO);
    e->azimuth_center_udeg = between(seed, -turn / 2, turn / 2);
    e->azimuth_width_udeg = between(seed, 1, turn / 4);
    e->elevation_min_udeg = middle - between(seed, 1, turn / 8);
    e->elevation_max_udeg = middle + between(seed, 1, turn / 8);
    e->mount_roll_udeg = between(seed, -turn, turn);
    e->mount_pitch_udeg = between(seed, -turn, turn);
    e->mount_yaw_udeg = between(seed, -turn, turn);
    for (unsigned i = 0; i < 3; i++) {
        e->mount_um[i] = between(seed, -10 * MICRO, 10 * MICRO);
    }
    if (draw(seed) % 2u == 0) {
        layout.profile.angle_lsb_pdeg =
            draw(seed) % (NARROW_LSB_PDEG >> draw(seed) % 20u) + 1u;
    }
    if (lum_projector_init(&b->projector, &c, &layout) != LUM_OK) {
        return false;
    }
    b->eye = &b->projector.eye[eye];
    lum_polynomials_init(&b->polynomials, b->eye);
    b->line = (lum_line){.angles = b->angles,
                         .angle_marks = b->marks,
                         .words = b->words,
                         .eye = (uint8_t)eye};
    return b->eye->narrow;
}

/* One in four lines lacks angles, and half of them ranges. */
static void draw_line(bench *b, uint64_t *seed)
{
    const uint32_t kind = draw(seed);
    const int32_t lowest = kind % 2u == 0 ? b->eye->min_tof : -2000;
    memset(b->marks, 0xff, sizeof b->marks);
    b->line.angle_count = LUM_LINE_PIXELS;
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        const uint32_t r = draw(seed);
        memcpy(&b->angles[i], &r, sizeof r);
    }
    for (unsigned k = kind % 8u < 2u ? draw(seed) % 40u : 0; k > 0; k--) {
        const uint32_t pixel = draw(seed) % LUM_LINE_PIXELS;
        const uint32_t bit = UINT32_C(1) << pixel % 32u;
        if ((b->marks[pixel / 32u] & bit) != 0) {
            b->line.angle_count--;
        }
        b->marks[pixel / 32u] &= ~bit;
    }
    /* short lines more often, so that all ends are met */
    b->line.word_count = draw(seed) % (kind % 16u < 12u ? 70u : WORDS_MAX + 1u);
    for (uint32_t i = 0; i < b->line.word_count; i++) {
        const uint32_t r = draw(seed);
        const int32_t tof = lowest + (int32_t)(r >> (r % 16u == 0 ? 12 : 18));
        b->words[i] = lum_word_make(tof < LUM_TOF_MAX ? tof : LUM_TOF_MAX,
                                    r % 2u != 0, draw(seed) % LUM_LINE_PIXELS);
    }
}

/* --- What is compared --- */

static bool same(const void *a, const void *b, size_t bytes, const char *what,
                 const char *name)
{
    if (memcmp(a, b, bytes) == 0) {
        return true;
    }
    (void)printf("%s: %s differ from plain C\n", name, what);
    return false;
}

static bool same_directions(bench *b, const lum_kernels *k)
{
    memset(b->directions, NOT_OVERWRITE, sizeof b->directions);
    k->directions(&b->polynomials, b->angles, b->directions);
    return same(b->directions, b->expected, sizeof b->expected, "directions",
                k->name);
}

static bool same_counts(const bench *b, const lum_kernels *k,
                        const uint32_t *words, uint32_t n)
{
    uint32_t rising = 77;
    uint32_t expected = 77;
    const uint32_t below = k->count_below(words, n, b->eye->min_tof, &rising);
    if (below == lum_plain_count_below(words, n, b->eye->min_tof, &expected) &&
        rising == expected) {
        return true;
    }
    (void)printf("%s: words are not counted as by plain C\n", k->name);
    return false;
}

/* What is behind the chosen words in their n places may be anything. */
static bool same_choice(const bench *b, const lum_kernels *k,
                        const uint32_t *words, uint32_t n)
{
    uint32_t out[LUM_POINTS_BLOCK + SPARE];
    uint32_t expected[LUM_POINTS_BLOCK + SPARE];
    static const uint32_t masks[3] = {0, LUM_WORD_RISING, LUM_WORD_RISING};
    static const uint32_t values[3] = {0, 0, LUM_WORD_RISING};
    for (unsigned i = 0; i < 3; i++) {
        const lum_word_choice choice = {b->eye->min_tof, masks[i], values[i]};
        memset(out, NOT_OVERWRITE, sizeof out);
        memset(expected, NOT_OVERWRITE, sizeof expected);
        const uint32_t count = k->choose(&choice, words, n, out);
        if (count != lum_plain_choose(&choice, words, n, expected) ||
            !same(out, expected, count * sizeof *out, "chosen words",
                  k->name) ||
            !same(out + n, expected + n, SPARE * sizeof *out,
                  "places behind the chosen words", k->name)) {
            return false;
        }
    }
    return true;
}

/* Columns lie one after another, each with room behind it. */
static bool same_columns(bench *b, const lum_kernels *k, const uint32_t *words,
                         uint32_t n)
{
    const uint32_t step = n + SPARE;
    float ranges[LUM_POINTS_BLOCK + SPARE];
    float expected_ranges[LUM_POINTS_BLOCK + SPARE];
    float xyz[3u * (LUM_POINTS_BLOCK + SPARE)];
    float expected[3u * (LUM_POINTS_BLOCK + SPARE)];
    memset(ranges, NOT_OVERWRITE, sizeof ranges);
    memset(expected_ranges, NOT_OVERWRITE, sizeof expected_ranges);
    memset(xyz, NOT_OVERWRITE, sizeof xyz);
    memset(expected, NOT_OVERWRITE, sizeof expected);
    const lum_column_source from = {words, expected_ranges, n, b->expected,
                                    b->eye->mount};
    k->ranges(b->eye, words, n, ranges);
    lum_plain_ranges(b->eye, words, n, expected_ranges);
    k->columns(&from, xyz, xyz + step, xyz + 2u * step);
    lum_plain_columns(&from, expected, expected + step, expected + 2u * step);
    return same(ranges, expected_ranges, sizeof ranges, "ranges", k->name) &&
           same(xyz, expected, sizeof xyz, "columns", k->name);
}

/* Columns of a block, each with room behind it. */
typedef struct numbers {
    float floats[3][LUM_POINTS_BLOCK + SPARE];
    uint16_t shorts[3][LUM_POINTS_BLOCK + SPARE];
    uint8_t edge[LUM_POINTS_BLOCK + SPARE];
} numbers;

static lum_column_places places_of(numbers *to)
{
    memset(to, NOT_OVERWRITE, sizeof *to);
    return (lum_column_places){.azimuth = to->floats[0],
                               .elevation = to->floats[1],
                               .pulse_width = to->floats[2],
                               .pixel = to->shorts[0],
                               .return_number = to->shorts[1],
                               .number_of_returns = to->shorts[2],
                               .edge = to->edge};
}

/* Any floats serve for degrees. */
static bool same_numbers(const bench *b, const lum_kernels *k,
                         const uint32_t *words, uint32_t n)
{
    numbers made;
    numbers expected;
    lum_return returns[LUM_POINTS_BLOCK];
    const lum_column_places places = places_of(&made);
    const lum_column_places expected_places = places_of(&expected);
    const lum_column_numbers from = {.words = words,
                                     .returns = returns,
                                     .count = n,
                                     .azimuth = &b->expected[0].x,
                                     .elevation = &b->expected[1].y,
                                     .tof_lsb_ns = b->projector.tof_lsb_ns};
    lum_returns_compute(words, n, returns);
    k->numbers(&from, &places);
    lum_plain_numbers(&from, &expected_places);
    return same(&made, &expected, sizeof made, "numbers", k->name);
}

/* Directions as points, in a view before the sensor, whatever its size. */
static bool same_pixels(const bench *b, const lum_kernels *k)
{
    static uint32_t pixels[LUM_LINE_PIXELS];
    static uint32_t expected[LUM_LINE_PIXELS];
    static float x[3][LUM_LINE_PIXELS];
    const uint32_t n = b->line.word_count % LUM_LINE_PIXELS;
    const lum_image_view view = {60.0f, -60.0f, 40.0f, -40.0f, n + 1u, 777};
    lum_image_scale scale;
    if (lum_image_scale_init(&scale, &view) != LUM_OK) {
        return false;
    }
    for (uint32_t i = 0; i < n; i++) {
        x[0][i] = b->expected[i].x;
        x[1][i] = b->expected[i].y;
        x[2][i] = b->expected[i].z;
    }
    memset(pixels, NOT_OVERWRITE, sizeof pixels);
    memset(expected, NOT_OVERWRITE, sizeof expected);
    k->pixels(&scale, x[0], x[1], x[2], n, pixels);
    lum_plain_pixels(&scale, x[0], x[1], x[2], n, expected);
    return same(pixels, expected, sizeof pixels, "pixels", k->name);
}

/* The times of pixels, and points moved by a motion whose numbers are random
 * too. */
static bool same_motion(const bench *b, const lum_kernels *k,
                        const uint32_t *words, uint32_t n)
{
    const uint32_t step = n + SPARE;
    float times[LUM_POINTS_BLOCK + SPARE];
    float expected_times[LUM_POINTS_BLOCK + SPARE];
    float xyz[3u * (LUM_POINTS_BLOCK + SPARE)];
    float expected[3u * (LUM_POINTS_BLOCK + SPARE)];
    lum_motion motion = {.from_s = 1e-4f, .to_s = 1e-3f};
    memset(times, NOT_OVERWRITE, sizeof times);
    memset(xyz, NOT_OVERWRITE, sizeof xyz);
    memset(expected, NOT_OVERWRITE, sizeof expected);
    for (uint32_t i = 0; i < n; i++) {
        times[i] = (float)lum_word_pixel(words[i]);
    }
    memcpy(expected_times, times, sizeof times);
    for (unsigned i = 0; i < 12u; i++) {
        motion.matrix[i] = b->expected[i].x;
        motion.slope[i] = b->expected[i].y;
    }
    k->times(times, n, 12345, 1562001);
    lum_plain_times(expected_times, n, 12345, 1562001);
    const float *at = &b->expected[0].x;
    const lum_motion_points from = {at, at + 1, at + 2, times};
    float *const out[3] = {xyz, xyz + step, xyz + 2u * step};
    float *const plain[3] = {expected, expected + step, expected + 2u * step};
    k->move(&motion, &from, n, out);
    lum_plain_move(&motion, &from, n, plain);
    const size_t inside = k->count(&motion, times, n);
    const size_t expected_inside = lum_plain_count(&motion, times, n);
    return same(times, expected_times, sizeof times, "times", k->name) &&
           same(xyz, expected, sizeof xyz, "moved points", k->name) &&
           same(&inside, &expected_inside, sizeof inside, "times inside",
                k->name);
}

/* From each place of the line on, a block at a time. */
static bool same_blocks(bench *b, const lum_kernels *k)
{
    for (uint32_t at = 0; at < b->line.word_count; at += LUM_POINTS_BLOCK) {
        const uint32_t left = b->line.word_count - at;
        const uint32_t n = left < LUM_POINTS_BLOCK ? left : LUM_POINTS_BLOCK;
        const uint32_t *words = b->words + at;
        const size_t bytes = (n + SPARE) * sizeof *b->points;
        memset(b->points, NOT_OVERWRITE, bytes);
        memset(b->expected_points, NOT_OVERWRITE, bytes);
        k->points(b->eye, words, n, b->expected, b->points);
        lum_plain_points(b->eye, words, n, b->expected, b->expected_points);
        if (!same(b->points, b->expected_points, bytes, "points", k->name) ||
            !same_counts(b, k, words, n) || !same_choice(b, k, words, n) ||
            !same_columns(b, k, words, n) || !same_numbers(b, k, words, n) ||
            !same_motion(b, k, words, n)) {
            return false;
        }
    }
    return true;
}

/* Each word alone. */
static size_t expect_points(bench *b, lum_point_losses *losses)
{
    size_t n = 0;
    for (uint32_t i = 0; i < b->line.word_count; i++) {
        const uint32_t pixel = lum_word_pixel(b->words[i]);
        if ((b->marks[pixel / 32u] >> pixel % 32u & 1u) == 0) {
            losses->no_angle++;
        } else if (lum_word_tof(b->words[i]) < b->eye->min_tof) {
            losses->no_range++;
        } else {
            lum_plain_points(b->eye, &b->words[i], 1, b->expected,
                             &b->expected_points[n++]);
        }
    }
    return n;
}

static bool same_line(bench *b)
{
    const char *name = lum_points_vectors();
    lum_point_losses expected = {0, 0};
    lum_point_losses losses = {0, 0};
    lum_directions_compute(&b->projector, &b->line, b->directions);
    const size_t n = expect_points(b, &expected);
    const size_t count = lum_points_compute(&b->projector, &b->line,
                                            b->directions, b->points, &losses);
    if (count != n || losses.no_angle != expected.no_angle ||
        losses.no_range != expected.no_range) {
        (void)printf("%s: points of a line are not as many\n", name);
        return false;
    }
    return same(b->directions, b->expected,
                LUM_LINE_PIXELS * sizeof *b->expected, "directions of a line",
                name) &&
           same(b->points, b->expected_points, n * sizeof *b->points,
                "points of a line", name);
}

/* --- The proof --- */

static bool prove_line(bench *b, const lum_kernels **kinds, size_t count)
{
    lum_plain_directions(&b->polynomials, b->angles, b->expected);
    for (size_t i = 0; i < count; i++) {
        if (!same_directions(b, kinds[i]) || !same_blocks(b, kinds[i]) ||
            !same_pixels(b, kinds[i])) {
            return false;
        }
    }
    return same_line(b);
}

/* The one that LUM_CPU names, if the processor has it. */
static bool is_in_use(const lum_kernels **kinds, size_t count)
{
    const char *name = getenv("LUM_CPU");
    const char *expected = kinds[0]->name;
    for (size_t i = 0; name != NULL && i < count; i++) {
        expected = strcmp(name, kinds[i]->name) == 0 ? name : expected;
    }
    return strcmp(lum_points_vectors(), expected) == 0;
}

static int prove(bench *b, uint64_t lines, uint64_t seed)
{
    const lum_kernels *kinds[LUM_KERNELS_MAX];
    const size_t count = lum_kernels_list(kinds);
    uint64_t state = seed;
    if (!is_in_use(kinds, count)) {
        (void)printf("NOT PROVEN: %s is in use\n", lum_points_vectors());
        return EXIT_FAILURE;
    }
    memset(b->expected, NOT_OVERWRITE, sizeof b->expected);
    for (uint64_t i = 0; i < lines; i++) {
        if (i % EACH == 0 && !draw_eye(b, &state)) {
            (void)fputs(
                "prove_kernels: a calibration was refused, or is not narrow\n",
                stderr);
            return EXIT_FAILURE;
        }
        draw_line(b, &state);
        if (!prove_line(b, kinds, count)) {
            (void)printf("NOT PROVEN: line %" PRIu64 " of seed %" PRIu64 "\n",
                         i, seed);
            return EXIT_FAILURE;
        }
    }
    (void)printf("proven:");
    for (size_t i = 0; i < count; i++) {
        (void)printf(" %s", kinds[i]->name);
    }
    (void)printf(" give the same bits; in use: %s; %" PRIu64
                 " random lines from seed %" PRIu64 "\n",
                 lum_points_vectors(), lines, seed);
    return EXIT_SUCCESS;
}

/* Digits alone, and not 0: a proof of no lines would succeed. */
static bool read_number(const char *text, uint64_t *out)
{
    if (strspn(text, "0123456789") != strlen(text)) {
        return false;
    }
    errno = 0;
    *out = strtoull(text, NULL, 10);
    return errno == 0 && *out != 0;
}

int main(int argc, char **argv)
{
    static bench b;
    uint64_t lines = 20000u;
    uint64_t seed = 1u;
    if (argc > 3 || (argc > 1 && !read_number(argv[1], &lines)) ||
        (argc > 2 && !read_number(argv[2], &seed))) {
        (void)fputs("usage: prove_kernels [LINES [SEED]]\n", stderr);
        return 2;
    }
    return prove(&b, lines, seed);
}
