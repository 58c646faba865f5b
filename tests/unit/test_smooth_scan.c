/* Smoothing against the angles that the simulator knows. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/smooth.h"
#include "sim/scan.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PIXELS LUM_LINE_PIXELS
#define LINES  64u
#define SEEDS  8u

/* A line's direction of sweep: even ones run to the right. */
#define SWEEPS 2u
#define AXES   2u

/* Errors of an axis: over all pixels, and of each pixel by sweep, since what a
 * filter drags along changes its sign with the motion. */
struct errors {
    double squares;
    double count;
    double sum[SWEEPS][PIXELS];
    double lines[SWEEPS];
};

struct scene {
    lum_scan scan;
    lum_scan_line scanned;
    lum_line line;
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    lum_angle out[PIXELS];
    struct errors raw[AXES]; /* azimuth, elevation; in deviations of noise */
    struct errors smooth[AXES];
};

static struct scene *scene_new(void)
{
    struct scene *s = calloc(1, sizeof *s);
    lum_calibration calibration;
    lum_layout layout;
    assert_non_null(s);
    lum_calibration_default(&calibration);
    lum_layout_default(&layout);
    assert_int_equal(lum_scan_init(&s->scan, &calibration, &layout, LINES),
                     LUM_OK);
    memset(s->marks, 0xff, sizeof s->marks);
    s->line = (lum_line){.angles = s->scanned.reading,
                         .angle_marks = s->marks,
                         .angle_count = PIXELS};
    return s;
}

static void add_error(struct errors *e, unsigned sweep, unsigned pixel,
                      double degrees)
{
    const double error = degrees / LUM_SCAN_NOISE_DEG;
    e->squares += error * error;
    e->count += 1.0;
    e->sum[sweep][pixel] += error;
}

static void add_angle(struct errors e[AXES], const struct scene *s,
                      unsigned eye, unsigned line, unsigned pixel,
                      lum_angle raw)
{
    const lum_scan_eye *x = &s->scan.eye[eye];
    const unsigned sweep = line % SWEEPS;
    add_error(&e[0], sweep, pixel,
              raw.azimuth / x->azimuth_bits + x->azimuth_center -
                  (double)s->scanned.azimuth[pixel]);
    add_error(&e[1], sweep, pixel,
              raw.elevation / x->elevation_bits + x->elevation_center -
                  (double)s->scanned.elevation[pixel]);
}

static void add_line(struct scene *s, unsigned eye, unsigned line)
{
    for (unsigned p = 0; p < PIXELS; p++) {
        if (lum_line_has_angles(&s->line, p)) {
            add_angle(s->raw, s, eye, line, p, s->scanned.reading[p]);
            add_angle(s->smooth, s, eye, line, p, s->out[p]);
        }
    }
    for (unsigned axis = 0; axis < AXES; axis++) {
        s->raw[axis].lines[line % SWEEPS] += 1.0;
        s->smooth[axis].lines[line % SWEEPS] += 1.0;
    }
}

/* Both eyes, all lines, several seeds. */
static void measure(struct scene *s, uint32_t window, uint32_t order)
{
    lum_smooth filter;
    assert_int_equal(lum_smooth_init(&filter, window, order), LUM_OK);
    for (unsigned i = 0; i < SEEDS * LUM_EYES * LINES; i++) {
        const unsigned line = i % LINES;
        const unsigned eye = i / LINES % LUM_EYES;
        lum_random random;
        lum_random_init(&random, i, 0);
        lum_scan_compute(&s->scan, eye, line, &random, &s->scanned);
        lum_smooth_line(&filter, &s->line, s->out);
        add_line(s, eye, line);
    }
}

static double rms(const struct errors *e)
{
    return sqrt(e->squares / e->count);
}

static double worst_bias(const struct errors *e)
{
    double worst = 0.0;
    for (unsigned sweep = 0; sweep < SWEEPS; sweep++) {
        for (unsigned p = 0; p < PIXELS; p++) {
            worst = fmax(worst, fabs(e->sum[sweep][p]) / e->lines[sweep]);
        }
    }
    return worst;
}

static void assert_better(const struct scene *s, double share)
{
    for (unsigned axis = 0; axis < AXES; axis++) {
        const double before = rms(&s->raw[axis]);
        const double after = rms(&s->smooth[axis]);
        const double bias = worst_bias(&s->smooth[axis]);
        print_message("%s: %.2f of the noise, then %.3f; bias of a pixel at "
                      "most %.3f\n",
                      axis == 0 ? "azimuth" : "elevation", before, after, bias);
        assert_true(before > 0.95 && before < 1.05);
        assert_true(after < share * before);
        assert_true(bias < 0.2);
    }
}

static void the_error_halves_and_nothing_is_displaced(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    measure(s, LUM_SMOOTH_WINDOW, LUM_SMOOTH_ORDER(LUM_SMOOTH_WINDOW));
    assert_better(s, 0.3);
    free(s);
}

static void the_widest_window_displaces_nothing_either(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    measure(s, LUM_SMOOTH_WINDOW_MAX, LUM_SMOOTH_ORDER(LUM_SMOOTH_WINDOW_MAX));
    assert_better(s, 0.22);
    free(s);
}

static void half_the_error_takes_eleven_pixels(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    measure(s, 11, 2);
    assert_better(s, 0.5);
    free(s);
}

/* The middle packet of the three that bring a line's angles. */
static void a_lost_packet_displaces_nothing_beside_it(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    for (unsigned p = 334; p < 668; p++) {
        s->marks[p / 32u] &= ~((uint32_t)1 << (p % 32u));
    }
    measure(s, LUM_SMOOTH_WINDOW, LUM_SMOOTH_ORDER(LUM_SMOOTH_WINDOW));
    assert_better(s, 0.33);
    free(s);
}

/* Order 1 is why the default is 2. */
static void a_straight_line_would_displace_the_ends(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    measure(s, LUM_SMOOTH_WINDOW, 1);
    assert_true(worst_bias(&s->smooth[0]) > 1.0);
    free(s);
}

static void off_leaves_the_readings(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    measure(s, 1, 0);
    assert_memory_equal(s->out, s->scanned.reading, sizeof s->out);
    assert_memory_equal(s->smooth, s->raw, sizeof s->raw);
    free(s);
}

/* A mirror that swings like a pendulum and turns inside the line, or stands
 * still at its ends; lumsim's does neither. */
static double worst_bias_of_swing(double turns, double phase)
{
    const double noise = 5.46; /* of an encoder, in bits of 60 degrees */
    const unsigned lines = 500;
    struct scene *s = scene_new();
    double *sum = s->smooth[0].sum[0];
    lum_smooth filter;
    double worst = 0.0;
    assert_int_equal(lum_smooth_init(&filter, LUM_SMOOTH_WINDOW, 2), LUM_OK);
    for (unsigned i = 0; i < lines * PIXELS; i++) {
        const unsigned p = i % PIXELS;
        const double turn = phase + turns * (p + 0.5) / PIXELS;
        const double angle = 32000.0 * cos(6.283185307179586 * turn);
        lum_random random;
        lum_random_init(&random, i, 1);
        s->scanned.reading[p].azimuth =
            (int16_t)lrint(angle + noise * (double)lum_random_normal(&random));
        sum[p] -= angle;
        if (p == PIXELS - 1) {
            lum_smooth_line(&filter, &s->line, s->out);
            for (unsigned k = 0; k < PIXELS; k++) {
                sum[k] += s->out[k].azimuth;
            }
        }
    }
    for (unsigned p = 0; p < PIXELS; p++) {
        worst = fmax(worst, fabs(sum[p]) / lines / noise);
    }
    free(s);
    return worst;
}

static void turns_of_the_mirror_are_not_cut_short(void **state)
{
    (void)state;
    assert_true(worst_bias_of_swing(0.5, 0.0) < 0.2);  /* at both ends */
    assert_true(worst_bias_of_swing(0.5, 0.25) < 0.2); /* in the middle */
    assert_true(worst_bias_of_swing(1.0, 0.0) < 0.2);  /* everywhere */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_error_halves_and_nothing_is_displaced),
        cmocka_unit_test(the_widest_window_displaces_nothing_either),
        cmocka_unit_test(half_the_error_takes_eleven_pixels),
        cmocka_unit_test(a_lost_packet_displaces_nothing_beside_it),
        cmocka_unit_test(a_straight_line_would_displace_the_ends),
        cmocka_unit_test(off_leaves_the_readings),
        cmocka_unit_test(turns_of_the_mirror_are_not_cut_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
