#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/points.h"
#include "lum/points_fixed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE    1000000
#define WORDS_MAX 4096u

/* Of points_are_the_same_integers_on_every_target. */
#define POINTS_DIGEST UINT64_C(0x9bb81b0ad5fe71ca)

/* Under the calibration of scene_new() a bit is 1 ns, so 150 mm. */
#define BIT (150 * LUM_FIXED_PER_MM)

/* A line made by hand, its points and its losses. */
struct scene {
    lum_calibration calibration;
    lum_layout layout;
    lum_fixed_projector *projector;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS_MAX];
    lum_fixed_point *points;
    size_t count;
    lum_point_losses losses;
};

/* 180 degrees wide, 180 degrees high, at the origin; blue looks ahead. */
static struct scene *scene_new(void)
{
    struct scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->projector = malloc(sizeof *s->projector);
    assert_non_null(s->projector);
    lum_calibration_default(&s->calibration);
    lum_layout_default(&s->layout);
    s->calibration.tof_lsb_fs = 1000000u;
    s->calibration.eye[0] =
        (lum_eye_calibration){.azimuth_width_udeg = 180 * DEGREE,
                              .elevation_min_udeg = -90 * DEGREE,
                              .elevation_max_udeg = 90 * DEGREE};
    memset(s->marks, 0xff, sizeof s->marks);
    s->line = (lum_line){.angles = s->angles,
                         .angle_marks = s->marks,
                         .words = s->words,
                         .angle_count = LUM_LINE_PIXELS};
    return s;
}

static void scene_free(struct scene *s)
{
    free(s->points);
    free(s->projector);
    free(s);
}

static void put(struct scene *s, int32_t tof, uint32_t pixel)
{
    assert_true(s->line.word_count < WORDS_MAX);
    s->words[s->line.word_count++] = lum_word_make(tof, true, pixel);
}

static void unmark(struct scene *s, uint32_t pixel)
{
    s->marks[pixel / 32u] &= ~(UINT32_C(1) << (pixel % 32u));
    s->line.angle_count--;
}

static void bind(struct scene *s)
{
    assert_int_equal(
        lum_fixed_projector_init(s->projector, &s->calibration, &s->layout),
        LUM_OK);
}

/* Room for exactly as many points as there are words. */
static void project_part(struct scene *s, uint32_t first, uint32_t count)
{
    const uint32_t left =
        first < s->line.word_count ? s->line.word_count - first : 0;
    const size_t room = count < left ? count : left;
    free(s->points);
    s->points = malloc(room * sizeof *s->points + 1u);
    assert_non_null(s->points);
    s->count = lum_points_fixed_compute(s->projector, &s->line, first, count,
                                        s->points, &s->losses);
    assert_true(s->count <= room);
}

static void project(struct scene *s)
{
    bind(s);
    project_part(s, 0, UINT32_MAX);
}

/* The only point of a word of 100 bits at some raw angles. */
static lum_fixed_point look(struct scene *s, int azimuth, int elevation)
{
    s->angles[7] = (lum_angle){(int16_t)azimuth, (int16_t)elevation};
    s->line.word_count = 0;
    put(s, 100, 7);
    project(s);
    assert_int_equal(s->count, 1);
    assert_int_equal(s->points[0].word, lum_word_make(100, true, 7));
    return s->points[0];
}

/* Within one unit of a point in bits. */
static void assert_at(lum_fixed_point p, double x, double y, double z)
{
    assert_true(fabs(p.x - x * BIT) <= 1.0);
    assert_true(fabs(p.y - y * BIT) <= 1.0);
    assert_true(fabs(p.z - z * BIT) <= 1.0);
}

static void axes_are_forward_left_up(void **state)
{
    struct scene *s = scene_new();
    const double h = 100 * sqrt(0.5);
    (void)state;
    const lum_fixed_point ahead = look(s, 0, 0);
    assert_int_equal(ahead.x, 100 * BIT);
    assert_int_equal(ahead.y, 0);
    assert_int_equal(ahead.z, 0);
    assert_at(look(s, 16384, 0), h, h, 0);
    assert_at(look(s, -16384, 0), h, -h, 0);
    assert_at(look(s, -32768, 0), 0, -100, 0);
    assert_at(look(s, 0, 16384), h, 0, h);
    assert_at(look(s, 0, -16384), h, 0, -h);
    assert_at(look(s, 0, -32768), 0, 0, -100);
    assert_at(look(s, -16384, -16384), 50, -50, -h);
    scene_free(s);
}

static void every_quarter_of_a_turn_is_told_apart(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.eye[0].azimuth_width_udeg = 360 * DEGREE;
    for (int raw = -32768; raw <= 32767; raw += 2048) {
        const double a = raw * (3.14159265358979323846 / 32768.0);
        assert_at(look(s, raw, 0), 100 * cos(a), 100 * sin(a), 0);
    }
    scene_free(s);
}

static void the_middle_of_the_span_is_at_raw_zero(void **state)
{
    struct scene *s = scene_new();
    const double seven = 7 * 3.14159265358979323846 / 180;
    (void)state;
    s->calibration.eye[0].elevation_min_udeg = -17 * DEGREE;
    s->calibration.eye[0].elevation_max_udeg = 3 * DEGREE;
    assert_at(look(s, 0, 0), 100 * cos(seven), 0, -100 * sin(seven));
    s->calibration.eye[0].elevation_min_udeg = -7 * DEGREE - 1;
    s->calibration.eye[0].elevation_max_udeg = -7 * DEGREE + 1;
    assert_at(look(s, 0, 0), 100 * cos(seven), 0, -100 * sin(seven));
    s->calibration.eye[0].elevation_min_udeg = -DEGREE;
    s->calibration.eye[0].elevation_max_udeg = DEGREE;
    s->calibration.eye[0].azimuth_center_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 0, 100, 0);
    s->calibration.eye[0].azimuth_center_udeg = -180 * DEGREE;
    assert_at(look(s, 0, 0), -100, 0, 0);
    scene_free(s);
}

static void mounts_turn_by_the_right_hand(void **state)
{
    struct scene *s = scene_new();
    lum_eye_calibration *e = &s->calibration.eye[0];
    (void)state;
    e->mount_yaw_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 0, 100, 0);
    e->mount_yaw_udeg = -360 * DEGREE;
    assert_at(look(s, 0, 0), 100, 0, 0);
    e->mount_yaw_udeg = 0;
    e->mount_pitch_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 0, 0, -100);
    e->mount_pitch_udeg = 0;
    e->mount_roll_udeg = 90 * DEGREE;
    assert_at(look(s, -32768, 0), 0, 0, -100);
    scene_free(s);
}

static void a_mount_turns_by_as_little_as_a_microdegree(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.eye[0].azimuth_center_udeg = 90 * DEGREE;
    put(s, LUM_TOF_MAX, 0);
    for (int32_t udeg = -1; udeg <= 1; udeg++) {
        s->calibration.eye[0].mount_roll_udeg = udeg;
        project(s);
        /* 78.6 km to the left: 22 units a microdegree */
        assert_true(abs(s->points[0].z - 22 * udeg) <= 8);
    }
    scene_free(s);
}

static void mounts_turn_by_roll_then_pitch_then_yaw(void **state)
{
    struct scene *s = scene_new();
    lum_eye_calibration *e = &s->calibration.eye[0];
    (void)state;
    /* left, rolled up, pitched to the front, yawed to the left again */
    e->azimuth_center_udeg = 90 * DEGREE;
    e->mount_roll_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 0, 0, 100);
    e->mount_pitch_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 100, 0, 0);
    e->mount_yaw_udeg = 90 * DEGREE;
    assert_at(look(s, 0, 0), 0, 100, 0);
    scene_free(s);
}

static void the_mount_is_added(void **state)
{
    struct scene *s = scene_new();
    const int32_t um[3] = {1000000, -2000000, 500};
    (void)state;
    memcpy(s->calibration.eye[0].mount_um, um, sizeof um);
    const lum_fixed_point p = look(s, 0, 0);
    assert_int_equal(p.x, 100 * BIT + 16000);
    assert_int_equal(p.y, -32000);
    assert_int_equal(p.z, 8);
    scene_free(s);
}

static void each_eye_has_its_own_calibration(void **state)
{
    struct scene *s = scene_new();
    const double a = 30 * 3.14159265358979323846 / 180;
    const double e = 7 * 3.14159265358979323846 / 180;
    (void)state;
    s->line.eye = 1;
    assert_at(look(s, 0, 0), 100 * cos(e) * cos(a), 100 * cos(e) * sin(a),
              -100 * sin(e));
    scene_free(s);
}

static void an_lsb_of_the_profile_is_the_scale_of_both_axes(void **state)
{
    struct scene *s = scene_new();
    const double h = 100 * sqrt(0.5);
    (void)state;
    s->layout.profile.angle_lsb_pdeg = UINT64_C(10000000000); /* 0.01 */
    assert_at(look(s, 4500, 0), h, h, 0);
    assert_at(look(s, 0, 4500), h, 0, h);
    s->layout.profile.angle_lsb_pdeg = 1;
    assert_at(look(s, 32767, -32768), 100, 0, 0);
    scene_free(s);
}

static void angles_beyond_a_turn_wrap(void **state)
{
    struct scene *s = scene_new();
    const double h = 100 * sqrt(0.5);
    (void)state;
    s->layout.profile.angle_lsb_pdeg = LUM_ANGLE_LSB_MAX_PDEG;
    assert_at(look(s, 45, 0), h, h, 0);
    assert_at(look(s, 360 * 91, 0), 100, 0, 0);
    assert_at(look(s, 45 - 360 * 91, 0), h, h, 0);
    assert_at(look(s, 0, 45 + 360 * 90), h, 0, h);
    assert_at(look(s, 0, 180 - 360), -100, 0, 0);
    scene_free(s);
}

static void ranges_are_rounded_to_the_nearest_unit(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.tof_lsb_fs = 1000; /* 2.4 units */
    for (uint32_t i = 1; i <= 5; i++) {
        put(s, (int32_t)i, 0);
    }
    put(s, LUM_TOF_MAX, 0);
    project(s);
    assert_int_equal(s->count, 6);
    assert_int_equal(s->points[0].x, 2);
    assert_int_equal(s->points[1].x, 5);
    assert_int_equal(s->points[2].x, 7);
    assert_int_equal(s->points[3].x, 10);
    assert_int_equal(s->points[4].x, 12);
    assert_true(abs(s->points[5].x - 1258289) <= 1);
    scene_free(s);
}

static void the_offset_is_added_to_each_time_of_flight(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.eye[0].tof_offset_fs = 2500000; /* two and a half bits */
    put(s, -3, 0);
    put(s, -2, 0);
    put(s, 7, 0);
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->points[0].x, BIT / 2);
    assert_int_equal(s->points[1].x, BIT * 19 / 2);
    assert_int_equal(s->losses.no_range, 1);
    scene_free(s);
}

static void each_eye_has_its_own_offset(void **state)
{
    static const int64_t offsets_fs[LUM_EYES] = {3000000, -5000000};
    static const int32_t least[LUM_EYES] = {-2, 6};
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct scene *s = scene_new();
        s->calibration.eye[1] = s->calibration.eye[0];
        for (unsigned i = 0; i < LUM_EYES; i++) {
            s->calibration.eye[i].tof_offset_fs = offsets_fs[i];
        }
        s->line.eye = (uint8_t)eye;
        put(s, least[eye] - 1, 0);
        put(s, least[eye], 0);
        put(s, 100, 0);
        project(s);
        assert_int_equal(s->losses.no_range, 1);
        assert_int_equal(s->count, 2);
        assert_int_equal(s->points[0].x, BIT);
        assert_int_equal(s->points[1].x, (101 - least[eye]) * BIT);
        scene_free(s);
    }
}

static void words_without_range_give_no_point(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, LUM_TOF_MIN, 0);
    put(s, -1, 0);
    put(s, 0, 0);
    put(s, 1, 0);
    put(s, 0, 1);
    put(s, 1, 1);
    s->losses.no_range = UINT32_MAX;
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->points[0].word, s->words[3]);
    assert_int_equal(s->points[1].word, s->words[5]);
    assert_true(s->losses.no_range == UINT32_MAX + UINT64_C(4));
    assert_int_equal(s->losses.no_angle, 0);
    scene_free(s);
}

static void words_without_angles_give_no_point(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    put(s, 5, 30);
    put(s, 5, 31);
    put(s, 0, 31);
    put(s, 5, 32);
    put(s, 5, 32);
    put(s, 5, 33);
    unmark(s, 31);
    unmark(s, 32);
    s->losses.no_angle = UINT32_MAX;
    project(s);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->points[0].word, s->words[0]);
    assert_int_equal(s->points[1].word, s->words[5]);
    assert_true(s->losses.no_angle == UINT32_MAX + UINT64_C(4));
    assert_int_equal(s->losses.no_range, 0);
    scene_free(s);
}

static void no_time_of_flight_may_be_long_enough(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.tof_lsb_fs = 19000;
    s->calibration.eye[0].tof_offset_fs = -INT64_C(10000000000);
    put(s, LUM_TOF_MIN, 0);
    put(s, LUM_TOF_MAX, 0);
    project(s);
    assert_int_equal(s->count, 0);
    assert_int_equal(s->losses.no_range, 2);
    scene_free(s);
}

static void every_time_of_flight_may_be_long_enough(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    s->calibration.tof_lsb_fs = 10000;
    s->calibration.eye[0].tof_offset_fs = INT64_C(10000000000);
    put(s, LUM_TOF_MIN, 0);
    put(s, LUM_TOF_MAX, 0);
    project(s);
    assert_int_equal(s->count, 2);
    assert_true(abs(s->points[0].x - 11417088) <= 1);
    assert_true(abs(s->points[1].x - 36582888) <= 1);
    scene_free(s);
}

static void the_farthest_point_fits(void **state)
{
    struct scene *s = scene_new();
    lum_eye_calibration *e = &s->calibration.eye[0];
    (void)state;
    s->calibration.speed_of_light = 310000000;
    e->tof_offset_fs = INT64_C(10000000000);
    e->mount_um[0] = 1000000000;
    put(s, LUM_TOF_MAX, 0);
    project(s);
    /* 534,287 ns are 82,814.485 m, and 1 km more */
    assert_true(abs(s->points[0].x - 1341031760) <= 8);
    e->azimuth_center_udeg = 180 * DEGREE;
    e->mount_um[0] = -1000000000;
    project(s);
    assert_true(abs(s->points[0].x + 1341031760) <= 8);
    scene_free(s);
}

static void a_calibration_out_of_range_is_refused(void **state)
{
    struct scene *s = scene_new();
    lum_fixed_projector p;
    (void)state;
    memset(&p, 0x5a, sizeof p);
    const lum_fixed_projector before = p;
    s->calibration.eye[1].azimuth_width_udeg = 0;
    assert_int_equal(lum_fixed_projector_init(&p, &s->calibration, &s->layout),
                     LUM_E_VALUE);
    s->calibration.eye[1].azimuth_width_udeg = 1;
    s->calibration.tof_lsb_fs = 0;
    assert_int_equal(lum_fixed_projector_init(&p, &s->calibration, &s->layout),
                     LUM_E_VALUE);
    assert_memory_equal(&p, &before, sizeof p);
    scene_free(s);
}

/* Some words for each pixel, some of them without a point. */
static void fill(struct scene *s, uint64_t seed)
{
    s->line.word_count = 0;
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        const uint32_t r = next_random(&seed);
        s->angles[pixel] = (lum_angle){(int16_t)((int)(r & 0xffffu) - 32768),
                                       (int16_t)((int)(r >> 16) - 32768)};
        for (uint32_t n = next_random(&seed) % 4u; n > 0; n--) {
            put(s, (int32_t)(next_random(&seed) % 520000u) - 2000, pixel);
        }
    }
}

static void blocks_make_what_the_whole_makes(void **state)
{
    static const uint32_t sizes[] = {1, 2, 7, 64, 1000, 4096};
    static lum_fixed_point whole[WORDS_MAX];
    struct scene *s = scene_new();
    (void)state;
    fill(s, 3);
    unmark(s, 0);
    unmark(s, 500);
    unmark(s, 501);
    project(s);
    const size_t count = s->count;
    const lum_point_losses losses = s->losses;
    memcpy(whole, s->points, count * sizeof *whole);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        size_t n = 0;
        s->losses = (lum_point_losses){0, 0};
        for (uint32_t at = 0; at < s->line.word_count; at += sizes[i]) {
            project_part(s, at, sizes[i]);
            assert_true(n + s->count <= count);
            assert_memory_equal(&whole[n], s->points, s->count * sizeof *whole);
            n += s->count;
        }
        assert_int_equal(n, count);
        assert_memory_equal(&s->losses, &losses, sizeof losses);
    }
    scene_free(s);
}

static void a_block_ends_where_the_line_does(void **state)
{
    struct scene *s = scene_new();
    (void)state;
    for (uint32_t i = 0; i < 10; i++) {
        put(s, 100, i);
    }
    bind(s);
    project_part(s, 8, 5);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->points[0].word, s->words[8]);
    project_part(s, 9, UINT32_MAX);
    assert_int_equal(s->count, 1);
    project_part(s, 3, 2);
    assert_int_equal(s->count, 2);
    assert_int_equal(s->points[1].word, s->words[4]);
    project_part(s, 5, 0);
    assert_int_equal(s->count, 0);
    project_part(s, 10, 1);
    assert_int_equal(s->count, 0);
    project_part(s, UINT32_MAX, UINT32_MAX);
    assert_int_equal(s->count, 0);
    assert_int_equal(s->losses.no_angle + s->losses.no_range, 0);
    scene_free(s);
}

static double distance_mm(const lum_fixed_point *p, const lum_point *q)
{
    const double dx = (double)p->x / LUM_FIXED_PER_MM - (double)q->x * 1e3;
    const double dy = (double)p->y / LUM_FIXED_PER_MM - (double)q->y * 1e3;
    const double dz = (double)p->z / LUM_FIXED_PER_MM - (double)q->z * 1e3;
    return sqrt(dx * dx + dy * dy + dz * dz);
}

static void points_are_those_in_float(void **state)
{
    static lum_direction directions[LUM_LINE_PIXELS];
    static lum_point points[WORDS_MAX];
    struct scene *s = scene_new();
    lum_projector projector;
    (void)state;
    lum_calibration_default(&s->calibration);
    assert_int_equal(
        lum_projector_init(&projector, &s->calibration, &s->layout), LUM_OK);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_point_losses losses = {0, 0};
        s->line.eye = (uint8_t)eye;
        s->losses = losses;
        fill(s, 17 + eye);
        unmark(s, 9 + eye);
        project(s);
        lum_directions_compute(&projector, &s->line, directions);
        assert_int_equal(lum_points_compute(&projector, &s->line, directions,
                                            points, &losses),
                         s->count);
        assert_memory_equal(&losses, &s->losses, sizeof losses);
        for (size_t i = 0; i < s->count; i++) {
            assert_int_equal(s->points[i].word, points[i].word);
            /* float: a few 2^-24 of 1 km */
            assert_true(distance_mm(&s->points[i], &points[i]) < 1.0);
        }
    }
    scene_free(s);
}

/* FNV-1a over the value's bytes, lowest first. */
static uint64_t mix(uint64_t digest, int32_t value)
{
    for (unsigned i = 0; i < 4; i++) {
        digest ^= ((uint32_t)value >> (8u * i)) & 0xffu;
        digest *= UINT64_C(0x100000001b3);
    }
    return digest;
}

static int32_t draw(uint64_t *seed, int32_t min, int32_t max)
{
    return min + (int32_t)(next_random(seed) % (uint32_t)(max - min + 1));
}

static void draw_eye(lum_eye_calibration *e, uint64_t *seed)
{
    const int32_t turn = 360 * DEGREE;
    e->tof_offset_fs = draw(seed, -10000, 10000) * INT64_C(1000000);
    e->azimuth_center_udeg = draw(seed, -turn / 2, turn / 2);
    e->azimuth_width_udeg = draw(seed, 1, turn);
    e->elevation_min_udeg = draw(seed, -turn / 4, 0);
    e->elevation_max_udeg = draw(seed, 1, turn / 4);
    for (unsigned i = 0; i < 3; i++) {
        e->mount_um[i] = draw(seed, -1000000000, 1000000000);
    }
    e->mount_roll_udeg = draw(seed, -turn, turn);
    e->mount_pitch_udeg = draw(seed, -turn, turn);
    e->mount_yaw_udeg = draw(seed, -turn, turn);
}

static void points_are_the_same_integers_on_every_target(void **state)
{
    struct scene *s = scene_new();
    uint64_t digest = UINT64_C(0xcbf29ce484222325);
    uint64_t seed = 1;
    (void)state;
    for (unsigned round = 0; round < 50; round++) {
        draw_eye(&s->calibration.eye[0], &seed);
        draw_eye(&s->calibration.eye[1], &seed);
        s->calibration.tof_lsb_fs = (uint32_t)draw(&seed, 1, 1000000);
        s->calibration.speed_of_light =
            (uint32_t)draw(&seed, 200000000, 310000000);
        s->layout.profile.angle_lsb_pdeg =
            round % 3u == 0 ? next_random(&seed) * UINT64_C(200) : 0;
        s->line.eye = (uint8_t)(round % LUM_EYES);
        fill(s, next_random(&seed));
        project(s);
        for (size_t i = 0; i < s->count; i++) {
            digest = mix(digest, s->points[i].x);
            digest = mix(digest, s->points[i].y);
            digest = mix(digest, s->points[i].z);
        }
    }
    if (digest != POINTS_DIGEST) {
        fail_msg("digest is %016llx", (unsigned long long)digest);
    }
    scene_free(s);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(axes_are_forward_left_up),
    cmocka_unit_test(every_quarter_of_a_turn_is_told_apart),
    cmocka_unit_test(the_middle_of_the_span_is_at_raw_zero),
    cmocka_unit_test(mounts_turn_by_the_right_hand),
    cmocka_unit_test(a_mount_turns_by_as_little_as_a_microdegree),
    cmocka_unit_test(mounts_turn_by_roll_then_pitch_then_yaw),
    cmocka_unit_test(the_mount_is_added),
    cmocka_unit_test(each_eye_has_its_own_calibration),
    cmocka_unit_test(an_lsb_of_the_profile_is_the_scale_of_both_axes),
    cmocka_unit_test(angles_beyond_a_turn_wrap),
    cmocka_unit_test(ranges_are_rounded_to_the_nearest_unit),
    cmocka_unit_test(the_offset_is_added_to_each_time_of_flight),
    cmocka_unit_test(each_eye_has_its_own_offset),
    cmocka_unit_test(words_without_range_give_no_point),
    cmocka_unit_test(words_without_angles_give_no_point),
    cmocka_unit_test(no_time_of_flight_may_be_long_enough),
    cmocka_unit_test(every_time_of_flight_may_be_long_enough),
    cmocka_unit_test(the_farthest_point_fits),
    cmocka_unit_test(a_calibration_out_of_range_is_refused),
    cmocka_unit_test(blocks_make_what_the_whole_makes),
    cmocka_unit_test(a_block_ends_where_the_line_does),
    cmocka_unit_test(points_are_those_in_float),
    cmocka_unit_test(points_are_the_same_integers_on_every_target),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
