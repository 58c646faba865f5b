/* prove_fixed [CASES [SEED]]: how far integer points (lum/points_fixed.h) are
 * from those of section 7 of docs/protocol.md in double. Fails where one is
 * farther than the bounds of docs/fixed.md allow, or where the two disagree on
 * which words give points.
 *
 * All raw angles of each axis, each time of flight (one of 997 where CASES is
 * 10,000,000 or less), and CASES random words under random calibrations;
 * 1,000,000 where it is not said. Status 2 where the arguments are not numbers
 * from 1 on. */
#include "lum/points_fixed.h"

#include "reference.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NEAR_MM     250000.0
#define NEAR_MAX_MM 0.15 /* of axes and grid, at ranges up to NEAR_MM */

#define DEGREE 1000000

/* The bound of docs/fixed.md, term by term, in millimetres. */
#define ROUNDING      0.0867           /* range, coordinates, 8 fs */
#define RANGE_BIT     (1.0 / 16777216) /* for each bit behind the first */
#define RANGE_BASE    1.9e-8           /* of the first bit's range */
#define MOUNT         1.08e-8          /* of the mount's length */
#define DIRECTION     2.97e-7          /* of the range */
#define DIRECTION_LSB 2.5e-7 /* of the range, at an angle lsb of 1 degree */

/* What points_fixed.h promises. */
#define PROMISED           0.17
#define PROMISED_DIRECTION 3.2e-7

/* A line of one word or more for each pixel, and what is known of its eye. */
typedef struct bench {
    lum_calibration calibration;
    lum_layout layout;
    lum_fixed_projector projector;
    reference reference;
    int32_t first_tof;
    double bound;       /* of the first bit */
    double bound_range; /* of the range */
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[LUM_LINE_PIXELS];
    lum_fixed_point points[LUM_LINE_PIXELS];
} bench;

/* What was seen. */
typedef struct tally {
    uint64_t words;
    uint64_t points;
    double near_mm;  /* farthest off at ranges up to NEAR_MM */
    double far_mm;   /* farthest off beyond */
    double of_bound; /* largest part of the bound that was used up */
    uint64_t wrong;  /* beyond their bounds, or not where they ought to be */
} tally;

static uint64_t next_random(uint64_t *seed)
{
    uint64_t z = *seed += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* The bounds of an eye, whatever the angles. */
static void set_bounds(bench *b)
{
    const reference *r = &b->reference;
    const double *m = r->mount_mm;
    const double lsb_deg = (double)b->layout.profile.angle_lsb_pdeg * 1e-12;
    b->first_tof = LUM_TOF_MIN;
    while (b->first_tof < LUM_TOF_MAX &&
           !reference_has_range(r, b->first_tof)) {
        b->first_tof++;
    }
    b->bound = ROUNDING + reference_range_mm(r, b->first_tof) * RANGE_BASE +
               sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) * MOUNT;
    b->bound_range = DIRECTION + lsb_deg * DIRECTION_LSB;
}

static bool bind(bench *b, unsigned eye)
{
    if (lum_fixed_projector_init(&b->projector, &b->calibration, &b->layout) !=
        LUM_OK) {
        return false;
    }
    reference_init(&b->reference, &b->calibration, eye,
                   b->layout.profile.angle_lsb_pdeg);
    set_bounds(b);
    memset(b->marks, 0xff, sizeof b->marks);
    b->line = (lum_line){.angles = b->angles,
                         .angle_marks = b->marks,
                         .words = b->words,
                         .angle_count = LUM_LINE_PIXELS,
                         .eye = (uint8_t)eye};
    return true;
}

static void measure(const bench *b, const lum_fixed_point *p, tally *t)
{
    const lum_angle *raw = &b->angles[lum_word_pixel(p->word)];
    const int32_t tof = lum_word_tof(p->word);
    const double range = reference_range_mm(&b->reference, tof);
    const double bound =
        b->bound + range * b->bound_range + (tof - b->first_tof) * RANGE_BIT;
    const double promised =
        PROMISED + range * (b->bound_range - DIRECTION + PROMISED_DIRECTION);
    double at[3];
    reference_point_mm(&b->reference, tof, raw->azimuth, raw->elevation, at);
    const double dx = (double)p->x / LUM_FIXED_PER_MM - at[0];
    const double dy = (double)p->y / LUM_FIXED_PER_MM - at[1];
    const double dz = (double)p->z / LUM_FIXED_PER_MM - at[2];
    const double off = sqrt(dx * dx + dy * dy + dz * dz);
    double *worst = range <= NEAR_MM ? &t->near_mm : &t->far_mm;
    *worst = fmax(*worst, off);
    t->of_bound = fmax(t->of_bound, off / bound);
    t->wrong += off <= fmin(bound, promised) ? 0u : 1u;
    t->points++;
}

/* Project the line and empty it. */
static void run(bench *b, tally *t)
{
    lum_point_losses losses = {0, 0};
    const uint32_t n = b->line.word_count;
    const size_t count = lum_points_fixed_compute(&b->projector, &b->line, 0, n,
                                                  b->points, &losses);
    size_t k = 0;
    for (uint32_t i = 0; i < n; i++) {
        if (!reference_has_range(&b->reference, lum_word_tof(b->words[i]))) {
            continue;
        }
        if (k < count && b->points[k].word == b->words[i]) {
            measure(b, &b->points[k], t);
        } else {
            t->wrong++;
        }
        k++;
    }
    t->wrong += k == count && losses.no_range == n - k ? 0u : 1u;
    t->words += n;
    b->line.word_count = 0;
}

static void put(bench *b, int32_t tof, int azimuth, int elevation, tally *t)
{
    const uint32_t i = b->line.word_count++;
    b->angles[i] = (lum_angle){(int16_t)azimuth, (int16_t)elevation};
    b->words[i] = lum_word_make(tof, true, i);
    if (b->line.word_count == LUM_LINE_PIXELS) {
        run(b, t);
    }
}

static void report(const char *what, const tally *t)
{
    (void)printf("%-8s %11" PRIu64 " words %11" PRIu64
                 " points  to 250 m %.4f mm  beyond %.4f mm  of the bound "
                 "%.3f  wrong %" PRIu64 "\n",
                 what, t->words, t->points, t->near_mm, t->far_mm, t->of_bound,
                 t->wrong);
}

/* Calibrations by hand; degrees, metres. */
typedef struct view {
    double azimuth_center, azimuth_width, elevation_min, elevation_max;
    double roll, pitch, yaw, mount;
    double lsb_deg; /* 0: full scale is half the span */
    uint32_t tof_lsb_fs;
    double offset_ps;
} view;

static const view views[] = {
    {0, 60, -17, 3, 0, 0, -30, 0, 0, 13000, 0}, /* the default's blue eye */
    {0, 60, -17, 3, 0, 0, 30, 0, 0, 13000, 0},  /* and its green one */
    {1.5, 58.25, -14.75, 4.5, 1, -2, 31, 0.123456, 0, 13000, 777},
    {0, 60, -17, 3, 90, 0, 0, 1, 0, 13000, 0},
    {0, 60, -17, 3, 0, 90, 0, -1, 0, 13000, 0},
    {0, 60, -17, 3, 0, 0, 90, 0, 0, 13000, 0},
    {0, 60, -17, 3, 45, 45, 45, 1000, 0, 13000, -5e6},
    {-100, 89.999, -89, 0.5, 170, -80, 300, -1000, 0, 13000, 5e6},
    {180, 360, -90, 90, 0, 0, 0, 0, 0, 1000000, 1e7},
    {-180, 360, -90, 90, -360, 360, -360, 1000, 0, 1000000, -1e7},
    {0, 180, -45, 45, 359.999999, -359.999999, 180, 0, 0, 6500, 0},
    {10, 0.000001, 0, 0.000001, 45, 45, 45, 0, 0, 13000, 0},
    {0, 60, -90, -89.999999, 0, -90, 0, 0, 0, 1, 1e6},
    {0, 60, -90, -89.999999, 0, -90, 0, 0, 0, 1, 1e7},
    {0, 60, -17, 3, 10, 20, 30, 0, 0.0009155, 13000, 0},
    {0, 60, -17, 3, 10, 20, 30, 0, 0.0055, 13000, 0},
    {90, 60, 17, 90, -35, 125, 215, -1000, 0.999999999999, 1000000, 0},
    {0, 60, -17, 3, 10, 20, 30, 0, 1.0, 13000, 0},
    {0, 60, -17, 3, 10, 20, 30, 0, 1e-12, 13000, 0},
};

#define VIEWS (sizeof views / sizeof views[0])

static int32_t udeg(double degrees)
{
    return (int32_t)lround(degrees * 1e6);
}

static bool bind_view(bench *b, const view *v, unsigned eye)
{
    lum_eye_calibration *e = &b->calibration.eye[eye];
    const int32_t mount = (int32_t)lround(v->mount * 1e6);
    lum_calibration_default(&b->calibration);
    lum_layout_default(&b->layout);
    b->layout.profile.angle_lsb_pdeg = (uint64_t)llround(v->lsb_deg * 1e12);
    b->calibration.tof_lsb_fs = v->tof_lsb_fs;
    *e = (lum_eye_calibration){
        .tof_offset_fs = (int64_t)llround(v->offset_ps * 1e3),
        .azimuth_center_udeg = udeg(v->azimuth_center),
        .azimuth_width_udeg = udeg(v->azimuth_width),
        .elevation_min_udeg = udeg(v->elevation_min),
        .elevation_max_udeg = udeg(v->elevation_max),
        .mount_um = {mount, -mount, mount / 3},
        .mount_roll_udeg = udeg(v->roll),
        .mount_pitch_udeg = udeg(v->pitch),
        .mount_yaw_udeg = udeg(v->yaw),
    };
    return bind(b, eye);
}

static void measure_axes(bench *b, tally *t)
{
    static const int others[] = {-32768, 0, 32767};
    int32_t nearest = 0;
    int32_t tof = 0;
    if (!reference_reach(&b->reference, NEAR_MM, &nearest, &tof)) {
        tof = nearest;
    }
    for (unsigned k = 0; k < sizeof others / sizeof others[0]; k++) {
        for (int raw = -32768; raw <= 32767; raw++) {
            put(b, tof, raw, others[k], t);
            put(b, tof, others[k], raw, t);
        }
    }
    run(b, t);
}

static void measure_grid(bench *b, int tof_step, tally *t)
{
    const int angle_step = 65535 / 5;
    for (int az = -32768; az <= 32767; az += angle_step) {
        for (int32_t tof = LUM_TOF_MIN; tof <= LUM_TOF_MAX; tof += tof_step) {
            /* an elevation for each time of flight: all, in the long run */
            const int el = (int)((uint32_t)tof * 40503u >> 7 & 0xffffu);
            put(b, tof, az, el - 32768, t);
        }
        put(b, LUM_TOF_MAX, az, az, t);
    }
    run(b, t);
}

static bool prove_views(bench *b, int tof_step, tally *axes, tally *grid)
{
    for (size_t i = 0; i < VIEWS; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            if (!bind_view(b, &views[i], eye)) {
                return false;
            }
            measure_axes(b, axes);
            measure_grid(b, tof_step, grid);
        }
    }
    return true;
}

/* One of the range's values; its ends more often than the others. */
static int64_t between(uint64_t *seed, int64_t min, int64_t max)
{
    const uint64_t r = next_random(seed);
    if (r % 16u < 2u) {
        return r % 16u == 0 ? min : max;
    }
    return min + (int64_t)(next_random(seed) % (uint64_t)(max - min + 1));
}

static void draw_eye(lum_eye_calibration *e, uint64_t *seed)
{
    const int32_t turn = 360 * DEGREE;
    const int64_t ten_us = INT64_C(10000000000);
    e->tof_offset_fs =
        next_random(seed) % 2u == 0 ? 0 : between(seed, -ten_us, ten_us);
    e->azimuth_center_udeg = (int32_t)between(seed, -turn / 2, turn / 2);
    e->azimuth_width_udeg = (int32_t)between(seed, 1, turn);
    e->elevation_min_udeg = (int32_t)between(seed, -turn / 4, turn / 4 - 1);
    e->elevation_max_udeg =
        (int32_t)between(seed, e->elevation_min_udeg + 1, turn / 4);
    for (unsigned i = 0; i < 3; i++) {
        e->mount_um[i] = (int32_t)between(seed, -1000000000, 1000000000);
    }
    e->mount_roll_udeg = (int32_t)between(seed, -turn, turn);
    e->mount_pitch_udeg = (int32_t)between(seed, -turn, turn);
    e->mount_yaw_udeg = (int32_t)between(seed, -turn, turn);
}

static bool draw(bench *b, uint64_t *seed)
{
    const unsigned eye = (unsigned)(next_random(seed) % LUM_EYES);
    lum_calibration_default(&b->calibration);
    lum_layout_default(&b->layout);
    draw_eye(&b->calibration.eye[eye], seed);
    b->calibration.speed_of_light =
        (uint32_t)between(seed, 200000000, 310000000);
    if (next_random(seed) % 2u == 0) {
        b->calibration.tof_lsb_fs = (uint32_t)between(seed, 1, 1000000);
    }
    if (next_random(seed) % 2u == 0) {
        const unsigned shift = (unsigned)(next_random(seed) % 40u);
        b->layout.profile.angle_lsb_pdeg =
            (uint64_t)between(seed, 1, (int64_t)LUM_ANGLE_LSB_MAX_PDEG) >>
            shift;
    }
    return bind(b, eye);
}

/* Words of one random calibration: half of them up to 250 m, half anywhere from
 * a little before the first point on. */
static void put_random(bench *b, uint64_t words, uint64_t *seed, tally *t)
{
    int32_t low = 0;
    int32_t high = 0;
    if (!reference_reach(&b->reference, NEAR_MM, &low, &high)) {
        low = low <= LUM_TOF_MAX ? low : LUM_TOF_MAX;
        high = low;
    }
    for (uint64_t i = 0; i < words; i++) {
        const int32_t before = low > LUM_TOF_MIN + 64 ? 64 : 0;
        const int32_t from = i % 2u == 0 ? low : low - before;
        const int32_t to = i % 2u == 0 ? high : LUM_TOF_MAX;
        const uint64_t r = next_random(seed);
        const uint64_t span = (uint64_t)(to - from) + 1u;
        put(b, from + (int32_t)(((r >> 32) * span) >> 32),
            (int)(r & 0xffffu) - 32768, (int)((r >> 16) & 0xffffu) - 32768, t);
    }
    run(b, t);
}

static bool prove_random(bench *b, uint64_t cases, uint64_t seed, tally *t)
{
    const uint64_t each = 50000;
    while (t->points < cases) {
        const uint64_t left = cases - t->points;
        if (!draw(b, &seed)) {
            return false;
        }
        put_random(b, left < each ? left : each, &seed, t);
    }
    return true;
}

static int prove(bench *b, uint64_t cases, uint64_t seed)
{
    tally axes = {0};
    tally grid = {0};
    tally random = {0};
    /* the long form takes each time of flight */
    const int tof_step = cases > 10000000u ? 1 : 997;
    if (!prove_views(b, tof_step, &axes, &grid) ||
        !prove_random(b, cases, seed, &random)) {
        (void)fputs("prove_fixed: a calibration was refused\n", stderr);
        return EXIT_FAILURE;
    }
    report("axes", &axes);
    report("grid", &grid);
    report("random", &random);
    const double near_mm =
        fmax(axes.near_mm, fmax(grid.near_mm, random.near_mm));
    const bool fine = axes.wrong + grid.wrong + random.wrong == 0 &&
                      fmax(axes.near_mm, grid.near_mm) <= NEAR_MAX_MM;
    (void)printf("%s: at most %.4f mm off at ranges up to 250 m; %" PRIu64
                 " points, the random ones from seed %" PRIu64 "\n",
                 fine ? "proven" : "NOT PROVEN", near_mm,
                 axes.points + grid.points + random.points, seed);
    return fine ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* Digits alone, and not 0: a proof of no points would succeed. */
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
    uint64_t cases = 1000000u;
    uint64_t seed = 1u;
    if (argc > 3 || (argc > 1 && !read_number(argv[1], &cases)) ||
        (argc > 2 && !read_number(argv[2], &seed))) {
        (void)fputs("usage: prove_fixed [CASES [SEED]], numbers from 1 on\n",
                    stderr);
        return 2;
    }
    bench *b = calloc(1, sizeof *b);
    if (b == NULL) {
        (void)fputs("prove_fixed: no memory\n", stderr);
        return EXIT_FAILURE;
    }
    const int status = prove(b, cases, seed);
    free(b);
    return status;
}
