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

#define WORDS_MAX 4096u

/* A line made by hand, its points and its losses. */
struct scene {
    lum_calibration calibration;
    lum_projector projector;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t *marks;
    uint32_t words[WORDS_MAX];
    uint32_t *exact; /* words, no longer than they are */
    lum_direction directions[LUM_LINE_PIXELS];
    lum_point *points;
    size_t count;
    lum_point_losses losses;
};

static struct scene *scene_new(void)
{
    struct scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    lum_calibration_default(&s->calibration);
    s->marks = malloc(LUM_PIXEL_MARK_WORDS * sizeof *s->marks);
    assert_non_null(s->marks);
    memset(s->marks, 0xff, LUM_PIXEL_MARK_WORDS * sizeof *s->marks);
    s->line = (lum_line){.angles = s->angles,
                         .angle_marks = s->marks,
                         .angle_count = LUM_LINE_PIXELS};
    return s;
}

static void scene_free(struct scene *s)
{
    free(s->points);
    free(s->exact);
    free(s->marks);
    free(s);
}

static void put(struct scene *s, int32_t tof, bool rising, uint32_t pixel)
{
    assert_true(s->line.word_count < WORDS_MAX);
    s->words[s->line.word_count++] = lum_word_make(tof, rising, pixel);
}

static void unmark(struct scene *s, uint32_t pixel)
{
    s->marks[pixel / 32u] &= ~(UINT32_C(1) << (pixel % 32u));
    s->line.angle_count--;
}

/* Room for exactly as many points as there are words. */
/* The marks are those of the words that points have. */
static void assert_marked(const struct scene *s)
{
    uint8_t *marks = malloc(s->line.word_count + 1u);
    size_t n = 0;
    assert_non_null(marks);
    lum_points_mark(&s->projector, &s->line, marks);
    for (uint32_t i = 0; i < s->line.word_count; i++) {
        assert_in_range(marks[i], 0, 1);
        if (marks[i] == 1) {
            assert_true(n < s->count);
            assert_int_equal(s->points[n++].word, s->words[i]);
        }
    }
    assert_int_equal(n, s->count);
    free(marks);
}

static void project(struct scene *s)
{
    lum_layout layout;
    lum_layout_default(&layout);
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    free(s->exact);
    s->exact = (uint32_t *)(void *)exact_copy(s->words, s->line.word_count *
                                                            sizeof *s->words);
    s->line.words = s->exact;
    free(s->points);
    s->points = malloc(s->line.word_count * sizeof *s->points + 1u);
    assert_non_null(s->points);
    lum_directions_compute(&s->projector, &s->line, s->directions);
    s->count = lum_points_compute(&s->projector, &s->line, s->directions,
                                  s->points, &s->losses);
    assert_marked(s);
}

static void assert_point(const lum_point *p, double x, double y, double z,
                         uint32_t word)
{
    assert_true(fabs(p->x - x) < 5e-4);
    assert_true(fabs(p->y - y) < 5e-4);
    assert_true(fabs(p->z - z) < 5e-4);
    assert_int_equal(p->word, word);
}

static void assert_counted(const struct scene *s)
{
    lum_point_losses losses = {0, 0};
    uint64_t rising = 77;
    uint64_t falling = 77;
    uint64_t up = 0;
    lum_points_count(&s->projector, &s->line, &rising, &falling, &losses);
    for (size_t i = 0; i < s->count; i++) {
        up += lum_word_is_rising(s->points[i].word) ? 1u : 0u;
    }
    assert_int_equal(rising, up);
    assert_int_equal(falling, s->count - up);
    assert_int_equal(losses.no_angle, s->losses.no_angle);
    assert_int_equal(losses.no_range, s->losses.no_range);
}

/* Raw angles of 0 look straight ahead. */
static void level(struct scene *s, unsigned eye)
{
    s->calibration.eye[eye].elevation_min_udeg = -10000000;
    s->calibration.eye[eye].elevation_max_udeg = 10000000;
    s->calibration.eye[eye].mount_yaw_udeg = 0;
}

static void a_bit_of_tof_is_the_manuals_length(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    level(s, 0);
    put(s, 1, true, 0);
    put(s, 1000, false, 999);
    put(s, LUM_TOF_MAX, true, 5);
    project(s);
    assert_int_equal(s->count, 3);
    assert_true(fabs(s->points[0].x - 0.00195) < 1e-8);
    assert_point(&s->points[1], 1.95, 0, 0, s->words[1]);
    assert_point(&s->points[2], 524287 * 0.00195, 0, 0, s->words[2]);
    scene_free(s);
}

static void the_speed_of_light_and_the_lsb_may_be_chosen(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    level(s, 0);
    s->calibration.speed_of_light = 299792458;
    s->calibration.tof_lsb_fs = 26000;
    put(s, 100000, true, 0);
    project(s);
    assert_point(&s->points[0], 100000 * 26e-12 * 299792458.0 / 2, 0, 0,
                 s->words[0]);
    scene_free(s);
}

static void an_offset_is_added_to_each_time(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    level(s, 0);
    s->calibration.eye[0].tof_offset_fs = -1300000; /* 100 bits */
    put(s, 100, true, 0);
    put(s, 101, true, 1);
    put(s, 1100, true, 2);
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->losses.no_range, 1);
    assert_point(&s->points[0], 0.00195, 0, 0, s->words[1]);
    assert_point(&s->points[1], 1.95, 0, 0, s->words[2]);
    scene_free(s);
}

/* Without angles of pixel 9 the line goes another way. */
static void assert_offset_of(unsigned eye, bool whole)
{
    struct scene *s = scene_new();
    level(s, 0);
    level(s, 1);
    s->calibration.eye[0].tof_offset_fs = 1300000; /* 100 bits */
    s->calibration.eye[1].tof_offset_fs = -1300000;
    s->line.eye = (uint8_t)eye;
    if (!whole) {
        unmark(s, 9);
    }
    const int32_t none = eye == 0 ? -100 : 100;
    put(s, none, true, 0);
    put(s, none + 1, true, 1);
    put(s, none + 1000, true, 2);
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->losses.no_range, 1);
    assert_point(&s->points[0], 0.00195, 0, 0, s->words[1]);
    assert_point(&s->points[1], 1.95, 0, 0, s->words[2]);
    assert_counted(s);
    scene_free(s);
}

static void each_eye_has_its_own_offset(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_offset_of(eye, true);
        assert_offset_of(eye, false);
    }
}

static void an_offset_may_reach_times_below_zero(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    level(s, 0);
    s->calibration.eye[0].tof_offset_fs = 1300000;
    put(s, -100, true, 0);
    put(s, -99, true, 1);
    project(s);
    assert_int_equal(s->count, 1);
    assert_point(&s->points[0], 0.00195, 0, 0, s->words[1]);
    scene_free(s);
}

static void the_mount_is_added_last(void **state)
{
    (void)state;
    for (unsigned without = 0; without < 2; without++) {
        struct scene *s = scene_new();
        level(s, 1);
        s->line.eye = 1;
        s->calibration.eye[1].mount_yaw_udeg = 90000000;
        s->calibration.eye[1].mount_um[0] = 1000000;
        s->calibration.eye[1].mount_um[1] = -2500000;
        s->calibration.eye[1].mount_um[2] = 125000;
        put(s, 1000, true, 0);
        if (without > 0) {
            unmark(s, 9);
        }
        project(s);
        assert_point(&s->points[0], 1.0, 1.95 - 2.5, 0.125, s->words[0]);
        scene_free(s);
    }
}

/* A whole line goes another way once a word of it has no range. */
static void mount_and_offset_are_added_to_all_words_of_a_line(void **state)
{
    (void)state;
    for (unsigned lacks = 0; lacks < 2; lacks++) {
        struct scene *s = scene_new();
        lum_eye_calibration *e = &s->calibration.eye[0];
        level(s, 0);
        e->tof_offset_fs = 1300000; /* 100 bits */
        e->mount_um[0] = 1000000;
        e->mount_um[1] = -2500000;
        e->mount_um[2] = 125000;
        put(s, 900, true, 0);
        if (lacks != 0) {
            put(s, -200, true, 1);
        }
        put(s, 1900, false, 2);
        project(s);
        assert_int_equal(s->count, 2);
        assert_int_equal(s->losses.no_range, lacks);
        assert_point(&s->points[0], 2.95, -2.5, 0.125, s->words[0]);
        assert_point(&s->points[1], 4.9, -2.5, 0.125, s->words[1 + lacks]);
        scene_free(s);
    }
}

static void words_without_a_range_give_no_point(void **state)
{
    static const int32_t tofs[] = {LUM_TOF_MIN, -1, 0, 1, LUM_TOF_MAX};
    struct scene *s = scene_new();
    (void)state;
    for (uint32_t i = 0; i < 5; i++) {
        put(s, tofs[i], i % 2 == 0, i);
    }
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->losses.no_range, 3);
    assert_int_equal(s->losses.no_angle, 0);
    assert_int_equal(s->points[0].word, s->words[3]);
    assert_int_equal(s->points[1].word, s->words[4]);
    scene_free(s);
}

static void words_without_angles_give_no_point(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    unmark(s, 31);
    unmark(s, 32);
    unmark(s, 999);
    for (uint32_t pixel = 30; pixel < 34; pixel++) {
        put(s, 1000, pixel % 2 == 0, pixel);
    }
    put(s, 1000, true, 999);
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->losses.no_angle, 3);
    assert_int_equal(s->points[0].word, s->words[0]);
    assert_int_equal(s->points[1].word, s->words[3]);
    scene_free(s);
}

static void a_word_without_either_lacks_its_angles(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    unmark(s, 5);
    put(s, 0, true, 5);
    put(s, 0, true, 6);
    project(s);
    assert_int_equal(s->count, 0);
    assert_int_equal(s->losses.no_angle, 1);
    assert_int_equal(s->losses.no_range, 1);
    scene_free(s);
}

static void losses_are_added_to(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->losses = (lum_point_losses){100, 1000};
    unmark(s, 5);
    put(s, 1, true, 5);
    put(s, 0, true, 6);
    project(s);
    assert_int_equal(s->losses.no_angle, 101);
    assert_int_equal(s->losses.no_range, 1001);
    scene_free(s);
}

static void losses_of_a_whole_line_are_added_to(void **state)
{
    struct scene *s = scene_new();
    lum_point_losses counted = {100, 1000};
    uint64_t rising = 0;
    uint64_t falling = 0;
    (void)state;
    s->losses = counted;
    put(s, 0, true, 6);
    put(s, 1, true, 6);
    project(s);
    lum_points_count(&s->projector, &s->line, &rising, &falling, &counted);
    assert_true(s->losses.no_angle == 100 && s->losses.no_range == 1001);
    assert_true(counted.no_angle == 100 && counted.no_range == 1001);
    unmark(s, 6);
    lum_points_count(&s->projector, &s->line, &rising, &falling, &counted);
    assert_true(counted.no_angle == 102 && counted.no_range == 1001);
    scene_free(s);
}

static void a_line_without_words_has_no_points(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    project(s);
    assert_int_equal(s->count, 0);
    unmark(s, 0);
    project(s);
    assert_int_equal(s->count, 0);
    scene_free(s);
}

/* Lines of chance: marked and whole, whose points and counts must agree. */
static void fill(struct scene *s, uint64_t *seed, bool whole)
{
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        s->angles[pixel].azimuth = (int16_t)(next_random(seed) % 60000u);
        s->angles[pixel].elevation = (int16_t)(next_random(seed) % 60000u);
        if (!whole && next_random(seed) % 4 == 0) {
            unmark(s, pixel);
        }
        for (uint32_t k = next_random(seed) % 4; k > 0; k--) {
            put(s, (int32_t)(next_random(seed) % 3000u) - 1000,
                next_random(seed) % 2 == 0, pixel);
        }
    }
}

static void assert_as_projected(const struct scene *s)
{
    const double lsb = 0.00195;
    size_t n = 0;
    for (uint32_t i = 0; i < s->line.word_count; i++) {
        const uint32_t word = s->words[i];
        const uint32_t pixel = lum_word_pixel(word);
        if (!lum_line_has_angles(&s->line, pixel) || lum_word_tof(word) <= 0) {
            continue;
        }
        const lum_direction d = s->directions[pixel];
        const double range = lum_word_tof(word) * lsb;
        assert_true(n < s->count);
        assert_point(&s->points[n++], range * (double)d.x, range * (double)d.y,
                     range * (double)d.z, word);
    }
    assert_int_equal(n, s->count);
}

static void points_and_counts_agree_on_lines_of_chance(void **state)
{
    uint64_t seed = 3;
    (void)state;
    for (unsigned round = 0; round < 40; round++) {
        struct scene *s = scene_new();
        fill(s, &seed, round % 2 == 0);
        project(s);
        assert_as_projected(s);
        assert_counted(s);
        scene_free(s);
    }
}

/* n words with a range, but for the one at hole where there is such. */
static void assert_projected(uint32_t n, uint32_t hole)
{
    struct scene *s = scene_new();
    for (uint32_t i = 0; i < n; i++) {
        put(s, i == hole ? 0 : 1 + (int32_t)i, i % 3 == 0, i / 4);
    }
    project(s);
    assert_int_equal(s->count, n - (hole < n ? 1u : 0u));
    assert_as_projected(s);
    assert_counted(s);
    scene_free(s);
}

static void lines_of_every_length_are_projected(void **state)
{
    (void)state;
    for (uint32_t n = 1; n<1100; n += n % 256> 3 && n % 256 < 250 ? 41 : 1) {
        assert_projected(n, n);
        assert_projected(n, 0);
        assert_projected(n, n - 1);
        assert_projected(n, n / 2);
    }
}

static void a_line_of_nothing_but_words_without_range_is_counted(void **state)
{
    (void)state;
    for (int32_t tof = -4; tof <= 0; tof++) {
        struct scene *s = scene_new();
        for (uint32_t pixel = 0; pixel < 50; pixel++) {
            put(s, tof, pixel % 2 == 0, pixel);
        }
        project(s);
        assert_int_equal(s->count, 0);
        assert_counted(s);
        scene_free(s);
    }
}

/* Only times of flight from some value on have a range: from the lowest of all,
 * the highest, and none. */
static void the_ends_of_all_times_of_flight_are_counted(void **state)
{
    static const struct {
        int64_t offset_fs;
        size_t count;
    } cases[] = {{524289, 6},  {524288, 4},  {524287, 2},      {0, 2},
                 {-524286, 2}, {-524287, 0}, {-10000000000, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct scene *s = scene_new();
        s->calibration.tof_lsb_fs = 1;
        s->calibration.eye[0].tof_offset_fs = cases[i].offset_fs;
        for (unsigned edge = 0; edge < 2; edge++) {
            put(s, LUM_TOF_MIN, edge != 0, edge);
            put(s, LUM_TOF_MIN + 1, edge != 0, edge);
            put(s, LUM_TOF_MAX, edge != 0, edge);
        }
        project(s);
        assert_int_equal(s->count, cases[i].count);
        assert_counted(s);
        scene_free(s);
    }
}

static void a_full_line_is_counted(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    for (uint32_t i = 0; i < 4u * LUM_LINE_PIXELS; i++) {
        put(s, 1000, true, i / 4u);
    }
    project(s);
    assert_int_equal(s->count, 4u * LUM_LINE_PIXELS);
    assert_counted(s);
    scene_free(s);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_bit_of_tof_is_the_manuals_length),
    cmocka_unit_test(the_speed_of_light_and_the_lsb_may_be_chosen),
    cmocka_unit_test(an_offset_is_added_to_each_time),
    cmocka_unit_test(each_eye_has_its_own_offset),
    cmocka_unit_test(an_offset_may_reach_times_below_zero),
    cmocka_unit_test(the_mount_is_added_last),
    cmocka_unit_test(mount_and_offset_are_added_to_all_words_of_a_line),
    cmocka_unit_test(words_without_a_range_give_no_point),
    cmocka_unit_test(words_without_angles_give_no_point),
    cmocka_unit_test(a_word_without_either_lacks_its_angles),
    cmocka_unit_test(losses_are_added_to),
    cmocka_unit_test(losses_of_a_whole_line_are_added_to),
    cmocka_unit_test(a_line_without_words_has_no_points),
    cmocka_unit_test(points_and_counts_agree_on_lines_of_chance),
    cmocka_unit_test(lines_of_every_length_are_projected),
    cmocka_unit_test(a_line_of_nothing_but_words_without_range_is_counted),
    cmocka_unit_test(a_full_line_is_counted),
    cmocka_unit_test(the_ends_of_all_times_of_flight_are_counted),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
