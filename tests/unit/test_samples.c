#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WORDS_MAX 1200u

/* A line that looks straight ahead, so that x is the range. */
struct scene {
    lum_calibration calibration;
    lum_projector projector;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS_MAX];
    uint32_t *exact; /* words, no longer than they are */
    lum_selection selection;
    lum_sample_workspace workspace;
    lum_sample *out;
    size_t count;
    lum_point_losses losses;
};

static struct scene *scene_new(void)
{
    struct scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    lum_calibration_default(&s->calibration);
    s->calibration.eye[0].elevation_min_udeg = -10000000;
    s->calibration.eye[0].elevation_max_udeg = 10000000;
    s->calibration.eye[0].mount_yaw_udeg = 0;
    lum_selection_default(&s->selection);
    s->selection.edges = LUM_EDGES_BOTH;
    memset(s->marks, 0xff, sizeof s->marks);
    s->line = (lum_line){.angles = s->angles,
                         .angle_marks = s->marks,
                         .angle_count = LUM_LINE_PIXELS};
    return s;
}

static void scene_free(struct scene *s)
{
    free(s->workspace.returns);
    free(s->out);
    free(s->exact);
    free(s);
}

static void keep_words(struct scene *s)
{
    free(s->exact);
    s->exact = (uint32_t *)(void *)exact_copy(s->words, s->line.word_count *
                                                            sizeof *s->words);
    s->line.words = s->exact;
}

static void put(struct scene *s, int32_t tof, bool rising, uint32_t pixel)
{
    assert_true(s->line.word_count < WORDS_MAX);
    s->words[s->line.word_count++] = lum_word_make(tof, rising, pixel);
}

/* Room for exactly as many as there are words. */
static void compute(struct scene *s)
{
    lum_layout layout;
    const size_t n = s->line.word_count;
    lum_layout_default(&layout);
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    keep_words(s);
    free(s->workspace.returns);
    free(s->out);
    s->workspace.returns = malloc(n * sizeof(lum_return) + 1u);
    s->out = malloc(n * sizeof *s->out + 1u);
    assert_true(s->workspace.returns != NULL && s->out != NULL);
    s->losses = (lum_point_losses){0, 0};
    s->count = lum_samples_compute(&s->projector, &s->line, &s->selection,
                                   &s->workspace, s->out, &s->losses);
}

/* What came out, by tof: every test gives each word its own. */
static void assert_tofs(struct scene *s, const int32_t *tofs, size_t n)
{
    compute(s);
    assert_int_equal(s->count, n);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(lround(s->out[i].range / 0.00195), tofs[i]);
    }
}

#define ASSERT_TOFS(s, ...)                                                    \
    assert_tofs((s), (const int32_t[]){__VA_ARGS__},                           \
                sizeof(const int32_t[]){__VA_ARGS__} / sizeof(int32_t))

static void assert_near(double value, double expected, double bound)
{
    if (!(fabs(value - expected) <= bound)) {
        fail_msg("%g, expected %g", value, expected);
    }
}

static void the_default_is_all_rising_returns(void **state)
{
    lum_selection d;
    (void)state;
    memset(&d, 0xff, sizeof d);
    lum_selection_default(&d);
    assert_int_equal(d.edges, LUM_EDGES_RISING);
    assert_int_equal(d.returns, LUM_RETURNS_ALL);
    assert_false(d.has_range || d.has_box);
}

static void a_sample_has_all_that_is_known(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->line.eye = 1;
    s->angles[30].azimuth = 16384;    /* 15 degrees of 60 */
    s->angles[30].elevation = -16384; /* 5 below the middle of -17 and 3 */
    s->calibration.eye[1].mount_um[0] = 1000000;
    s->calibration.eye[1].mount_um[1] = -3000000;
    s->calibration.eye[1].mount_um[2] = 2000000;
    s->calibration.eye[1].mount_yaw_udeg = 0;
    s->calibration.eye[1].tof_offset_fs = -2600000; /* 200 bits */
    put(s, 5000, true, 30);
    put(s, 5100, false, 30);
    put(s, 6000, true, 30);
    compute(s);
    const lum_sample *p = &s->out[0];
    const double range = 4800 * 0.00195;
    const double deg = 3.14159265358979323846 / 180.0;
    const double az = 15 * deg, el = -12 * deg;
    assert_int_equal(s->count, 3);
    assert_near(p->range, range, 1e-5);
    assert_near(p->azimuth, 15.0, 1e-5);
    assert_near(p->elevation, -12.0, 1e-5);
    assert_near(p->pulse_width, 100 * 0.013, 1e-5);
    assert_near(p->x, range * cos(el) * cos(az) + 1.0, 1e-4);
    assert_near(p->y, range * cos(el) * sin(az) - 3.0, 1e-4);
    assert_near(p->z, range * sin(el) + 2.0, 1e-4);
    assert_int_equal(p->pixel, 30);
    assert_int_equal(p->edge, 1);
    assert_int_equal(p->return_number, 1);
    assert_int_equal(p->number_of_returns, 2);
    assert_int_equal(p->pad, 0);
    assert_int_equal(s->out[1].edge, 0);
    assert_int_equal(s->out[1].number_of_returns, 1);
    assert_near(s->out[1].pulse_width, 0, 0);
    assert_int_equal(s->out[2].return_number, 2);
    assert_near(s->out[2].pulse_width, 0, 0);
    scene_free(s);
}

static void angles_of_samples_follow_an_lsb(void **state)
{
    struct scene *s = scene_new();
    lum_layout layout;
    lum_return returns[1];
    lum_sample out[1];
    (void)state;
    lum_layout_default(&layout);
    layout.profile.angle_lsb_pdeg = UINT64_C(1000000000); /* 0.001 degree */
    s->calibration.eye[0].azimuth_center_udeg = 1500000;
    s->angles[0].azimuth = -2000;
    s->angles[0].elevation = 4000;
    put(s, 1000, true, 0);
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    keep_words(s);
    s->workspace.returns = returns;
    assert_int_equal(lum_samples_compute(&s->projector, &s->line, &s->selection,
                                         &s->workspace, out, &s->losses),
                     1);
    s->workspace.returns = NULL;
    assert_near(out[0].azimuth, -0.5, 1e-6);
    assert_near(out[0].elevation, 4.0, 1e-6);
    scene_free(s);
}

static void losses_need_not_be_counted(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, 1000, true, 0);
    put(s, 0, true, 1);
    compute(s);
    assert_int_equal(s->losses.no_range, 1);
    assert_int_equal(lum_samples_compute(&s->projector, &s->line, &s->selection,
                                         &s->workspace, s->out, NULL),
                     1);
    assert_int_equal(s->losses.no_range, 1);
    scene_free(s);
}

/* Three rising and two falling words of pixel 4, one of each of pixel 9. */
static struct scene *two_pixels(void)
{
    struct scene *s = scene_new();
    put(s, 100, true, 4);
    put(s, 110, false, 4);
    put(s, 200, true, 4);
    put(s, 230, false, 4);
    put(s, 300, true, 4);
    put(s, 400, true, 9);
    put(s, 450, false, 9);
    return s;
}

static void edges_are_selected(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.edges = LUM_EDGES_BOTH;
    ASSERT_TOFS(s, 100, 110, 200, 230, 300, 400, 450);
    s->selection.edges = LUM_EDGES_RISING;
    ASSERT_TOFS(s, 100, 200, 300, 400);
    s->selection.edges = LUM_EDGES_FALLING;
    ASSERT_TOFS(s, 110, 230, 450);
    scene_free(s);
}

static void returns_are_selected_by_pixel_and_edge(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.returns = LUM_RETURNS_FIRST;
    ASSERT_TOFS(s, 100, 110, 400, 450);
    s->selection.returns = LUM_RETURNS_LAST;
    ASSERT_TOFS(s, 230, 300, 400, 450);
    s->selection.returns = LUM_RETURNS_NUMBER;
    s->selection.return_number = 2;
    ASSERT_TOFS(s, 200, 230);
    s->selection.return_number = 3;
    ASSERT_TOFS(s, 300);
    s->selection.return_number = 1;
    ASSERT_TOFS(s, 100, 110, 400, 450);
    s->selection.return_number = 4;
    assert_tofs(s, NULL, 0);
    scene_free(s);
}

static void a_choice_that_is_none_is_every_return(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.returns = (lum_return_choice)(LUM_RETURNS_NUMBER + 1);
    ASSERT_TOFS(s, 100, 110, 200, 230, 300, 400, 450);
    scene_free(s);
}

static void the_strongest_is_the_widest_pulse(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.edges = LUM_EDGES_RISING;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    ASSERT_TOFS(s, 200, 400);
    scene_free(s);
}

static void the_strongest_may_be_the_first_or_the_last(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->selection.edges = LUM_EDGES_RISING;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    put(s, 100, true, 0);
    put(s, 190, false, 0);
    put(s, 200, true, 0);
    put(s, 210, false, 0);
    put(s, 300, true, 999);
    put(s, 310, false, 999);
    put(s, 400, true, 999);
    put(s, 490, false, 999);
    ASSERT_TOFS(s, 100, 400);
    scene_free(s);
}

static void among_equals_the_first_is_the_strongest(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->selection.edges = LUM_EDGES_RISING;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    put(s, 100, true, 3);
    put(s, 110, false, 3);
    put(s, 200, true, 3);
    put(s, 220, false, 3);
    put(s, 300, true, 3);
    put(s, 320, false, 3);
    put(s, 500, true, 7); /* widths unknown are all 0 */
    put(s, 600, true, 7);
    ASSERT_TOFS(s, 200, 500);
    scene_free(s);
}

static void falling_words_have_no_width_so_the_first_is_strongest(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.edges = LUM_EDGES_FALLING;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    ASSERT_TOFS(s, 110, 450);
    scene_free(s);
}

static void each_edge_has_its_strongest(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    ASSERT_TOFS(s, 110, 200, 400, 450);
    scene_free(s);
}

/* Pixel 0 is the first there is, and pixels may follow without a gap. */
static void neighbours_do_not_share_a_strongest(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    s->selection.edges = LUM_EDGES_RISING;
    put(s, 100, true, 0);
    put(s, 200, true, 1);
    put(s, 300, false, 2);
    put(s, 400, true, 3);
    ASSERT_TOFS(s, 100, 200, 400);
    scene_free(s);
}

/* They are words of their pixel, of which only one can be the strongest. */
static void a_word_without_range_may_be_the_strongest(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    s->selection.edges = LUM_EDGES_RISING;
    put(s, 0, true, 3);
    put(s, 90, false, 3);
    put(s, 200, true, 3);
    put(s, 210, false, 3);
    assert_tofs(s, NULL, 0);
    scene_free(s);
}

static void words_passed_over_belong_to_their_own_pixel(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->selection.returns = LUM_RETURNS_STRONGEST;
    s->selection.edges = LUM_EDGES_RISING;
    put(s, -500, true, 2);
    put(s, -20, false, 2);
    put(s, -10, true, 2);
    put(s, -5, true, 3);
    put(s, -4, false, 3);
    put(s, 0, true, 3);
    put(s, 10, false, 3);
    put(s, 200, true, 3);
    put(s, 290, false, 3);
    ASSERT_TOFS(s, 200);
    scene_free(s);
}

static void a_range_includes_its_ends(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    compute(s);
    s->selection.has_range = true;
    s->selection.range_min = s->out[1].range;
    s->selection.range_max = s->out[3].range;
    ASSERT_TOFS(s, 110, 200, 230);
    s->selection.range_min = nextafterf(s->selection.range_min, 1e9f);
    s->selection.range_max = nextafterf(s->selection.range_max, 0.0f);
    ASSERT_TOFS(s, 200);
    scene_free(s);
}

static void a_range_of_no_number_selects_nothing(void **state)
{
    struct scene *s = two_pixels();
    (void)state;
    s->selection.has_range = true;
    s->selection.range_min = NAN;
    s->selection.range_max = 1e9f;
    assert_tofs(s, NULL, 0);
    scene_free(s);
}

static void a_box_includes_its_faces(void **state)
{
    (void)state;
    for (unsigned axis = 0; axis < 3; axis++) {
        for (int side = -1; side <= 1; side += 2) {
            struct scene *s = scene_new();
            put(s, 1000, true, 0);
            s->angles[0].azimuth = 8000;
            s->angles[0].elevation = 8000;
            compute(s);
            const float at[3] = {s->out[0].x, s->out[0].y, s->out[0].z};
            s->selection.has_box = true;
            for (unsigned k = 0; k < 3; k++) {
                s->selection.box_min[k] = -100.0f;
                s->selection.box_max[k] = 100.0f;
            }
            float *face = side < 0 ? &s->selection.box_min[axis]
                                   : &s->selection.box_max[axis];
            *face = at[axis];
            ASSERT_TOFS(s, 1000);
            *face = nextafterf(at[axis], side < 0 ? 1e9f : -1e9f);
            assert_tofs(s, NULL, 0);
            scene_free(s);
        }
    }
}

static void a_box_is_about_the_sensor_and_a_range_about_the_eye(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.eye[0].mount_um[0] = 100000000; /* 100 m ahead */
    put(s, 1000, true, 0);
    s->selection.has_range = true;
    s->selection.range_max = 2.0f;
    ASSERT_TOFS(s, 1000);
    s->selection.has_box = true;
    s->selection.box_min[0] = 101.0f;
    s->selection.box_max[0] = 102.0f;
    s->selection.box_max[1] = 1.0f;
    s->selection.box_min[1] = -1.0f;
    s->selection.box_max[2] = 1.0f;
    s->selection.box_min[2] = -1.0f;
    ASSERT_TOFS(s, 1000);
    scene_free(s);
}

static void losses_count_all_words_whatever_is_asked_for(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, 0, true, 1);
    put(s, -5, false, 1);
    put(s, 100, true, 2);
    put(s, 100, false, 3);
    put(s, 0, true, 3);
    s->marks[0] &= ~(UINT32_C(1) << 3);
    s->line.angle_count--;
    s->selection.edges = LUM_EDGES_FALLING;
    s->selection.returns = LUM_RETURNS_LAST;
    assert_tofs(s, NULL, 0);
    assert_int_equal(s->losses.no_range, 2);
    assert_int_equal(s->losses.no_angle, 2);
    scene_free(s);
}

static void a_pixel_without_angles_costs_no_other_its_samples(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, 100, true, 30);
    put(s, 200, true, 31);
    put(s, 300, true, 32);
    s->marks[0] &= ~(UINT32_C(1) << 31);
    s->line.angle_count--;
    ASSERT_TOFS(s, 100, 300);
    assert_int_equal(s->losses.no_angle, 1);
    scene_free(s);
}

/* Numbers are those of all words of the pixel, also of those without range. */
static void a_word_without_range_is_still_a_return(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, 0, true, 1);
    put(s, 1, true, 1);
    s->selection.returns = LUM_RETURNS_FIRST;
    assert_tofs(s, NULL, 0);
    s->selection.returns = LUM_RETURNS_ALL;
    ASSERT_TOFS(s, 1);
    assert_int_equal(s->out[0].return_number, 2);
    assert_int_equal(s->out[0].number_of_returns, 2);
    scene_free(s);
}

/* Words of all kinds: with and without a range, angles and a pulse. */
static void put_mixed(struct scene *s, uint32_t n)
{
    uint32_t seed = n;
    for (uint32_t i = 0; i < n; i++) {
        seed = seed * 1664525u + 1013904223u;
        const int32_t tof = (int32_t)(seed >> 12) % 90000 - 3000;
        put(s, tof, (seed >> 9 & 3u) != 0, i * LUM_LINE_PIXELS / WORDS_MAX);
    }
}

/* Without a limit, words are taken many at a time. */
static void limits_that_all_keep_change_nothing(void **state)
{
    static const uint32_t counts[] = {1,   2,   255, 256,  257,
                                      511, 512, 513, 1023, WORDS_MAX};
    static const lum_edges edges[] = {LUM_EDGES_RISING, LUM_EDGES_FALLING,
                                      LUM_EDGES_BOTH};
    (void)state;
    for (size_t i = 0; i < 6u * sizeof counts / sizeof counts[0]; i++) {
        struct scene *s = scene_new();
        struct scene *limited = scene_new();
        s->selection.edges = edges[i % 3u];
        limited->selection = s->selection;
        limited->selection.has_range = true;
        limited->selection.range_min = -INFINITY;
        limited->selection.range_max = INFINITY;
        if (i % 2u == 0) {
            s->line.angle_count = limited->line.angle_count =
                LUM_LINE_PIXELS - 32u;
            s->marks[3] = limited->marks[3] = 0;
        }
        put_mixed(s, counts[i / 6u]);
        put_mixed(limited, counts[i / 6u]);
        compute(s);
        compute(limited);
        assert_int_equal(s->count, limited->count);
        assert_memory_equal(s->out, limited->out, s->count * sizeof *s->out);
        scene_free(s);
        scene_free(limited);
    }
}

static void a_line_without_words_has_no_samples(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    assert_tofs(s, NULL, 0);
    scene_free(s);
}

/* lum_samples_compute() writes these as four numbers in a row. */
static void the_range_follows_x_y_and_z(void **state)
{
    (void)state;
    assert_int_equal(offsetof(lum_sample, y),
                     offsetof(lum_sample, x) + sizeof(float));
    assert_int_equal(offsetof(lum_sample, z),
                     offsetof(lum_sample, y) + sizeof(float));
    assert_int_equal(offsetof(lum_sample, range),
                     offsetof(lum_sample, z) + sizeof(float));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_range_follows_x_y_and_z),
    cmocka_unit_test(the_default_is_all_rising_returns),
    cmocka_unit_test(a_sample_has_all_that_is_known),
    cmocka_unit_test(angles_of_samples_follow_an_lsb),
    cmocka_unit_test(losses_need_not_be_counted),
    cmocka_unit_test(edges_are_selected),
    cmocka_unit_test(returns_are_selected_by_pixel_and_edge),
    cmocka_unit_test(a_choice_that_is_none_is_every_return),
    cmocka_unit_test(the_strongest_is_the_widest_pulse),
    cmocka_unit_test(the_strongest_may_be_the_first_or_the_last),
    cmocka_unit_test(among_equals_the_first_is_the_strongest),
    cmocka_unit_test(falling_words_have_no_width_so_the_first_is_strongest),
    cmocka_unit_test(each_edge_has_its_strongest),
    cmocka_unit_test(neighbours_do_not_share_a_strongest),
    cmocka_unit_test(a_word_without_range_may_be_the_strongest),
    cmocka_unit_test(words_passed_over_belong_to_their_own_pixel),
    cmocka_unit_test(a_range_includes_its_ends),
    cmocka_unit_test(a_range_of_no_number_selects_nothing),
    cmocka_unit_test(a_box_includes_its_faces),
    cmocka_unit_test(a_box_is_about_the_sensor_and_a_range_about_the_eye),
    cmocka_unit_test(losses_count_all_words_whatever_is_asked_for),
    cmocka_unit_test(a_pixel_without_angles_costs_no_other_its_samples),
    cmocka_unit_test(a_word_without_range_is_still_a_return),
    cmocka_unit_test(limits_that_all_keep_change_nothing),
    cmocka_unit_test(a_line_without_words_has_no_samples),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
