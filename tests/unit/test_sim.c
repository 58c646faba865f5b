#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/assembler.h"
#include "lum/group.h"
#include "lum/packet.h"
#include "lum/points.h"
#include "sim/fault.h"
#include "sim/packets.h"
#include "sim/random.h"
#include "sim/render.h"
#include "sim/scan.h"
#include "sim/scene.h"
#include "sim/shape.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979

/* Furthest that noise takes a range, and the rounding to a tof. */
#define RANGE_BOUND (LUM_RENDER_NOISE_M * LUM_RANDOM_NORMAL_MAX + 0.002f)

/* --- random numbers --- */

static void xoshiro_gives_its_published_numbers(void **state)
{
    static const uint64_t expected[] = {UINT64_C(11520),
                                        UINT64_C(0),
                                        UINT64_C(1509978240),
                                        UINT64_C(1215971899390074240),
                                        UINT64_C(1216172134540287360),
                                        UINT64_C(607988272756665600),
                                        UINT64_C(16172922978634559625)};
    lum_random r = {{1, 2, 3, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        assert_true(lum_random_next(&r) == expected[i]);
    }
}

static void streams_of_a_seed_differ_and_repeat(void **state)
{
    lum_random a;
    lum_random b;
    lum_random again;
    (void)state;
    lum_random_init(&a, 7, 0);
    lum_random_init(&b, 7, 1);
    lum_random_init(&again, 7, 0);
    for (int i = 0; i < 100; i++) {
        const uint64_t x = lum_random_next(&a);
        assert_true(x == lum_random_next(&again));
        assert_true(x != lum_random_next(&b));
    }
}

static void golden_numbers_of_a_stream_never_change(void **state)
{
    lum_random r;
    (void)state;
    lum_random_init(&r, 1, 2);
    assert_true(lum_random_next(&r) == UINT64_C(6851237923183208601));
    assert_true(lum_random_next(&r) == UINT64_C(4317682303100657501));
}

static void normal_numbers_have_mean_0_and_deviation_1(void **state)
{
    lum_random r;
    double sum = 0.0;
    double squares = 0.0;
    const int n = 100000;
    (void)state;
    lum_random_init(&r, 3, 0);
    for (int i = 0; i < n; i++) {
        const float x = lum_random_normal(&r);
        assert_true(fabsf(x) <= LUM_RANDOM_NORMAL_MAX);
        sum += (double)x;
        squares += (double)x * (double)x;
    }
    assert_true(fabs(sum / n) < 0.02);
    assert_true(fabs(sqrt(squares / n) - 1.0) < 0.02);
}

static void chances_of_0_and_1_are_certain(void **state)
{
    lum_random r;
    (void)state;
    lum_random_init(&r, 3, 0);
    for (int i = 0; i < 10000; i++) {
        assert_false(lum_random_chance(&r, 0.0));
        assert_true(lum_random_chance(&r, 1.0));
        assert_true(lum_random_below(&r, 3) < 3);
        const float x = lum_random_between(&r, -2.0f, 5.0f);
        assert_true(x >= -2.0f && x < 5.0f);
    }
}

/* --- shapes --- */

static lum_ray ray_to(float x, float y, float z)
{
    const float length = sqrtf(x * x + y * y + z * z);
    const float d[3] = {x / length, y / length, z / length};
    return lum_ray_make(d);
}

static void a_ray_meets_each_shape_where_it_stands(void **state)
{
    /* All fill the box from 10 to 12 along x; a ray along x meets them here. */
    static const float first[LUM_SHAPES] = {10.0f, 10.5f, 10.0f, 10.0f,
                                            10.0f, 10.0f, 10.0f, 11.0f};
    static const lum_face upright = {.along = {0.0f, 1.0f, 0.0f},
                                     .up = {0.0f, 0.0f, 1.0f},
                                     .normal = {1.0f, 0.0f, 0.0f},
                                     .half = {1.0f, 1.0f}};
    const lum_ray ray = ray_to(1.0f, 0.0f, 0.0f);
    const lum_ray past = ray_to(10.0f, 1.2f, 0.0f);
    (void)state;
    for (int kind = 0; kind < LUM_SHAPES; kind++) {
        lum_hit hit;
        const lum_shape shape = {.min = {10.0f, -1.0f, -1.0f},
                                 .max = {12.0f, 1.0f, 1.0f},
                                 .reflectivity = 0.5f,
                                 .cover = 0.4f,
                                 .lean = {1.0f, 1.0f, 0.2f},
                                 .opening = {1.0f, 3.0f, 0.2f, 0.0f},
                                 .face = &upright,
                                 .kind = (lum_shape_kind)kind};
        assert_true(lum_shape_cast(&shape, &ray, &hit));
        assert_float_equal(hit.range, first[kind], 0.01);
        assert_float_equal(hit.cover, kind == LUM_SHAPE_LEAVES ? 0.4f : 1.0f,
                           1e-3);
        assert_true(hit.cosine > 0.0f && hit.cosine <= 1.001f);
        assert_false(lum_shape_cast(&shape, &past, &hit));
    }
}

static void a_window_lies_behind_its_facade(void **state)
{
    const lum_shape house = {.min = {-6.0f, 10.0f, -2.0f},
                             .max = {6.0f, 20.0f, 10.0f},
                             .reflectivity = 0.5f,
                             .opening = {3.0f, 3.0f, 0.3f, 3.0f},
                             .kind = LUM_SHAPE_FACADE};
    const lum_ray pane = ray_to(-1.5f, 10.0f, -0.5f);
    const lum_ray wall = ray_to(-2.9f, 10.0f, -0.5f);
    lum_hit hit;
    (void)state;
    assert_true(lum_shape_cast(&house, &pane, &hit));
    assert_float_equal(hit.range * pane.d[1], 10.3, 1e-3);
    assert_true(lum_shape_cast(&house, &wall, &hit));
    assert_float_equal(hit.range * wall.d[1], 10.0, 1e-3);
}

static void the_rim_of_a_pole_stops_part_of_a_beam(void **state)
{
    const lum_shape pole = {.min = {19.9f, -0.1f, -2.0f},
                            .max = {20.1f, 0.1f, 4.0f},
                            .reflectivity = 0.5f,
                            .kind = LUM_SHAPE_PILLAR};
    const lum_ray rim = ray_to(20.0f, 0.1f, 0.0f);
    const lum_ray past = ray_to(20.0f, 0.12f, 0.0f);
    lum_hit hit;
    (void)state;
    assert_true(lum_shape_cast(&pole, &rim, &hit));
    assert_true(hit.cover > 0.3f && hit.cover < 0.7f);
    assert_false(lum_shape_cast(&pole, &past, &hit));
}

/* --- the scene --- */

static void the_ground_is_road_kerb_and_pavement(void **state)
{
    static const lum_ground ground = {.is_there = true,
                                      .road_z = -1.8f,
                                      .pavement_z = -1.6f,
                                      .kerb_right_y = -4.0f,
                                      .kerb_left_y = 8.0f,
                                      .marks_x = 0.0f,
                                      .crossing_x = 50.0f};
    static const float aims[4][3] = {{10.0f, 2.0f, -1.8f},
                                     {1.0f, 8.0f, -1.7f},
                                     {1.0f, -4.0f, -1.7f},
                                     {10.0f, 9.0f, -1.6f}};
    lum_hit hit;
    (void)state;
    for (int i = 0; i < 4; i++) {
        const lum_ray ray = ray_to(aims[i][0], aims[i][1], aims[i][2]);
        assert_true(lum_ground_cast(&ground, &ray, &hit));
        for (int k = 0; k < 3; k++) {
            assert_float_equal(hit.range * ray.d[k], aims[i][k], 1e-4);
        }
    }
    const lum_ray level = ray_to(1.0f, 0.0f, 0.0f);
    assert_false(lum_ground_cast(&ground, &level, &hit));
}

/* The same answer as asking every shape, cells or not. */
static size_t cast_at_all(const lum_scene *scene, const lum_ray *ray,
                          float *nearest)
{
    size_t count = 0;
    lum_hit hit;
    *nearest = LUM_STREET_REACH;
    if (lum_ground_cast(&scene->ground, ray, &hit)) {
        *nearest = hit.range;
        count++;
    }
    for (size_t i = 0; i < scene->shapes.count; i++) {
        if (lum_shape_cast(&scene->shapes.items[i], ray, &hit) &&
            hit.range < LUM_STREET_REACH) {
            *nearest = hit.range < *nearest ? hit.range : *nearest;
            count++;
        }
    }
    return count;
}

static void cells_lose_no_shape(void **state)
{
    const float eye[3] = {0.3f, -0.1f, 0.2f};
    const lum_place_options street = {.kind = LUM_PLACE_STREET};
    lum_place place;
    lum_scene scene;
    lum_random r;
    (void)state;
    memset(&scene, 0, sizeof scene);
    lum_random_init(&r, 5, 5);
    lum_place_init(&place, &street, 11);
    assert_int_equal(lum_scene_set(&scene, &place, 3.7, eye), 0);
    for (int i = 0; i < 3000; i++) {
        lum_hit hits[LUM_SCENE_HITS_MAX];
        float nearest = 0.0f;
        const lum_ray ray = ray_to(lum_random_between(&r, -0.2f, 1.0f),
                                   lum_random_between(&r, -1.0f, 1.0f),
                                   lum_random_between(&r, -0.4f, 0.2f));
        const size_t all = cast_at_all(&scene, &ray, &nearest);
        const size_t n = lum_scene_cast(&scene, &ray, hits);
        assert_true(n <= LUM_SCENE_HITS_MAX && n <= all);
        assert_true((n > 0) == (all > 0));
        if (n > 0) {
            assert_true(hits[0].range == nearest);
        }
        for (size_t k = 1; k < n; k++) {
            assert_true(hits[k - 1].range <= hits[k].range);
            assert_true(hits[k - 1].cover < 1.0f);
        }
    }
    lum_scene_free(&scene);
}

static void a_scene_is_the_same_again(void **state)
{
    const float eye[3] = {0.0f, 0.0f, 0.0f};
    const lum_place_options street = {.kind = LUM_PLACE_STREET};
    lum_place place;
    lum_place other;
    lum_scene a;
    lum_scene b;
    (void)state;
    memset(&a, 0, sizeof a);
    memset(&b, 0, sizeof b);
    lum_place_init(&place, &street, 4);
    lum_place_init(&other, &street, 5);
    assert_int_equal(lum_scene_set(&a, &place, 1.0, eye), 0);
    assert_int_equal(lum_scene_set(&b, &place, 9.0, eye), 0);
    assert_int_equal(lum_scene_set(&b, &place, 1.0, eye), 0);
    assert_int_equal(a.shapes.count, b.shapes.count);
    for (size_t i = 0; i < a.shapes.count; i++) {
        /* But for the padding at its end. */
        assert_memory_equal(&a.shapes.items[i], &b.shapes.items[i],
                            offsetof(lum_shape, kind) + sizeof(lum_shape_kind));
    }
    assert_int_equal(lum_scene_set(&b, &other, 1.0, eye), 0);
    assert_true(a.shapes.count != b.shapes.count);
    lum_scene_free(&a);
    lum_scene_free(&b);
}

/* --- lines --- */

struct fixture {
    lum_render_options options;
    lum_render render;
    lum_sim_line line;
    lum_sim_line other;
    lum_packet_batch batches[LUM_EYES];
};

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return -1;
    }
    lum_render_options_default(&f->options);
    f->options.seed = 42;
    *state = f;
    return lum_render_init(&f->render, &f->options) == LUM_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    lum_render_free(&f->render);
    free(f);
    return 0;
}

static void render(struct fixture *f, int64_t frame, uint32_t line,
                   unsigned eye)
{
    assert_int_equal(lum_render_line(&f->render, frame, line, eye, &f->line),
                     LUM_OK);
}

static void lines_sweep_to_and_fro_inside_the_span(void **state)
{
    struct fixture *f = *state;
    lum_scan_line *scanned = malloc(sizeof *scanned);
    lum_random r;
    assert_non_null(scanned);
    for (uint32_t line = 0; line < 4; line++) {
        lum_random_init(&r, 1, line);
        lum_scan_compute(&f->render.scan, LUM_EYE_BLUE, line, &r, scanned);
        const float first = scanned->azimuth[0];
        const float last = scanned->azimuth[LUM_LINE_PIXELS - 1];
        assert_true(line % 2 == 0 ? first > 29.0f && last < -29.0f
                                  : first < -29.0f && last > 29.0f);
        for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
            assert_true(fabsf(scanned->azimuth[p]) < 30.0f);
            assert_true(scanned->elevation[p] < 3.0f);
            assert_true(scanned->elevation[p] >
                        3.0f - 0.33f * (float)(line + 1));
        }
    }
    free(scanned);
}

static void readings_are_true_angles_but_for_small_noise(void **state)
{
    struct fixture *f = *state;
    const double bound =
        LUM_SCAN_NOISE_DEG * (double)LUM_RANDOM_NORMAL_MAX + 0.0006;
    lum_scan_line *s = malloc(sizeof *s);
    lum_random r;
    bool noisy = false;
    assert_non_null(s);
    lum_random_init(&r, 1, 1);
    lum_scan_compute(&f->render.scan, LUM_EYE_GREEN, 63, &r, s);
    for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
        const double az = s->reading[p].azimuth / 32768.0 * 30.0;
        const double el = s->reading[p].elevation / 32768.0 * 10.0 - 7.0;
        assert_true(fabs(az - (double)s->azimuth[p]) < bound);
        assert_true(fabs(el - (double)s->elevation[p]) < bound);
        noisy = noisy || fabs(az - (double)s->azimuth[p]) > 0.003;
    }
    assert_true(noisy);
    free(s);
}

static void a_line_is_the_same_in_any_order_of_rendering(void **state)
{
    struct fixture *f = *state;
    render(f, 3, 40, LUM_EYE_GREEN);
    f->other = f->line;
    render(f, 1, 2, LUM_EYE_BLUE);
    assert_memory_not_equal(f->other.angles, f->line.angles,
                            sizeof f->line.angles);
    render(f, 3, 40, LUM_EYE_GREEN);
    assert_int_equal(f->line.word_count, f->other.word_count);
    assert_memory_equal(f->line.words, f->other.words,
                        f->line.word_count * sizeof f->line.words[0]);
    assert_memory_equal(f->line.angles, f->other.angles, sizeof f->line.angles);
    assert_memory_equal(f->line.truth, f->other.truth,
                        f->line.truth_count * sizeof f->line.truth[0]);
}

static void every_word_is_good_and_edges_alternate_in_order(void **state)
{
    struct fixture *f = *state;
    unsigned several = 0;
    for (uint32_t line = 0; line < 64; line += 3) {
        const lum_sim_line *l = &f->line;
        render(f, 1, line, line & 1u);
        assert_int_equal(l->word_count, 2 * l->truth_count);
        for (size_t i = 0; i < l->word_count; i++) {
            const uint32_t w = l->words[i];
            const uint32_t before = i > 0 ? l->words[i - 1] : w;
            assert_true(lum_word_is_good(w));
            assert_true(lum_word_is_rising(w) == (i % 2 == 0));
            assert_true(lum_word_pixel(before) <= lum_word_pixel(w));
            if (i > 0 && lum_word_pixel(before) == lum_word_pixel(w)) {
                assert_true(lum_word_tof(before) < lum_word_tof(w));
                several += i % 2 == 0;
            }
        }
    }
    assert_true(several > 100);
}

static void truth_agrees_with_words_within_the_noise(void **state)
{
    struct fixture *f = *state;
    const lum_sim_line *l = &f->line;
    for (uint32_t line = 5; line < 64; line += 7) {
        render(f, 2, line, line & 1u);
        assert_true(l->truth_count > 0);
        for (size_t i = 0; i < l->truth_count; i++) {
            const lum_sample *s = &l->truth[i];
            const int32_t rise = lum_word_tof(l->words[2 * i]);
            const int32_t fall = lum_word_tof(l->words[2 * i + 1]);
            const float range = (float)rise * 0.00195f;
            const float width = (float)(fall - rise) * 0.013f;
            assert_int_equal(lum_word_pixel(l->words[2 * i]), s->pixel);
            assert_true(fabsf(range - s->range) < RANGE_BOUND);
            assert_true(fabsf(width - s->pulse_width) < 0.007f);
            assert_true(width > 1.99f && width < 30.0f);
            assert_true(s->range > 0.5f && s->range < LUM_STREET_REACH);
        }
    }
}

static void truth_points_lie_where_their_angles_say(void **state)
{
    struct fixture *f = *state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        render(f, 1, 30, eye);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            const lum_sample *s = &f->line.truth[i];
            const double yaw = eye == LUM_EYE_BLUE ? -30.0 : 30.0;
            const double az = ((double)s->azimuth + yaw) * PI / 180.0;
            const double el = (double)s->elevation * PI / 180.0;
            const double r = (double)s->range;
            assert_true(fabs((double)s->x - r * cos(el) * cos(az)) < 2e-4);
            assert_true(fabs((double)s->y - r * cos(el) * sin(az)) < 2e-4);
            assert_true(fabs((double)s->z - r * sin(el)) < 2e-4);
            assert_true(s->return_number >= 1 &&
                        s->return_number <= s->number_of_returns);
        }
    }
}

static void low_lines_see_the_road(void **state)
{
    struct fixture *f = *state;
    size_t road = 0;
    render(f, 1, 63, LUM_EYE_GREEN);
    for (size_t i = 0; i < f->line.truth_count; i++) {
        road += fabsf(f->line.truth[i].z + 1.8f) < 0.001f;
    }
    assert_true(road > 300);
}

static void a_mount_moves_the_eye_and_not_the_street(void **state)
{
    struct fixture *f = *state;
    lum_render_options options = f->options;
    lum_render *moved = malloc(sizeof *moved);
    size_t road = 0;
    assert_non_null(moved);
    options.calibration.eye[LUM_EYE_GREEN].mount_um[2] = 500000;
    options.calibration.eye[LUM_EYE_GREEN].mount_pitch_udeg = 2000000;
    assert_int_equal(lum_render_init(moved, &options), LUM_OK);
    assert_int_equal(lum_render_line(moved, 1, 63, LUM_EYE_GREEN, &f->line),
                     LUM_OK);
    for (size_t i = 0; i < f->line.truth_count; i++) {
        road += fabsf(f->line.truth[i].z + 1.8f) < 0.001f;
    }
    assert_true(road > 300);
    lum_render_free(moved);
    free(moved);
}

static void returns_max_limits_a_pixel(void **state)
{
    struct fixture *f = *state;
    f->options.returns_max = 1;
    lum_render *one = malloc(sizeof *one);
    assert_non_null(one);
    assert_int_equal(lum_render_init(one, &f->options), LUM_OK);
    for (uint32_t line = 0; line < 20; line++) {
        assert_int_equal(lum_render_line(one, 1, line, 0, &f->line), LUM_OK);
        for (size_t i = 0; i < f->line.truth_count; i++) {
            assert_int_equal(f->line.truth[i].number_of_returns, 1);
        }
    }
    lum_render_free(one);
    free(one);
}

static size_t count_points(const lum_render_options *options,
                           lum_sim_line *line, float *width)
{
    lum_render *r = malloc(sizeof *r);
    size_t count = 0;
    assert_non_null(r);
    assert_int_equal(lum_render_init(r, options), LUM_OK);
    for (uint32_t i = 0; i < 64; i += 8) {
        assert_int_equal(lum_render_line(r, 1, i, 0, line), LUM_OK);
        count += line->truth_count;
        *width = line->truth[0].pulse_width;
    }
    lum_render_free(r);
    free(r);
    return count;
}

static void less_power_or_more_threshold_sees_less(void **state)
{
    struct fixture *f = *state;
    lum_render_options weak = f->options;
    lum_render_options strict = f->options;
    float width[3];
    weak.gain = 0.02f;
    strict.threshold = 50.0f;
    const size_t full = count_points(&f->options, &f->line, &width[0]);
    const size_t less = count_points(&weak, &f->line, &width[1]);
    const size_t fewer = count_points(&strict, &f->line, &width[2]);
    assert_true(full > 6000);
    assert_true(less < full - 200 && fewer < full - 200);
    assert_true(width[1] < width[0]);
    assert_true(width[2] >= width[0]);
}

static void a_tof_offset_shifts_words_and_not_ranges(void **state)
{
    struct fixture *f = *state;
    render(f, 1, 50, LUM_EYE_BLUE);
    f->other = f->line;
    lum_render *shifted = malloc(sizeof *shifted);
    assert_non_null(shifted);
    f->options.calibration.eye[LUM_EYE_BLUE].tof_offset_fs = 13000 * 1000;
    assert_int_equal(lum_render_init(shifted, &f->options), LUM_OK);
    assert_int_equal(lum_render_line(shifted, 1, 50, 0, &f->line), LUM_OK);
    assert_int_equal(f->line.word_count, f->other.word_count);
    for (size_t i = 0; i < f->line.word_count; i++) {
        const int32_t by =
            lum_word_tof(f->other.words[i]) - lum_word_tof(f->line.words[i]);
        assert_true(by >= 999 && by <= 1001);
    }
    lum_render_free(shifted);
    free(shifted);
}

static void an_angle_scale_that_cannot_reach_the_span_is_refused(void **state)
{
    struct fixture *f = *state;
    lum_profile profile;
    lum_render *r = malloc(sizeof *r);
    assert_non_null(r);
    lum_profile_default(&profile);
    profile.angle_lsb_pdeg = UINT64_C(900000000);
    assert_int_equal(lum_layout_init(&f->options.layout, &profile, NULL, NULL),
                     LUM_OK);
    assert_int_equal(lum_render_init(r, &f->options), LUM_E_VALUE);
    profile.angle_lsb_pdeg = UINT64_C(1000000000);
    assert_int_equal(lum_layout_init(&f->options.layout, &profile, NULL, NULL),
                     LUM_OK);
    assert_int_equal(lum_render_init(r, &f->options), LUM_OK);
    lum_render_free(r);
    free(r);
}

static void lines_last_as_the_rate_says(void **state)
{
    struct fixture *f = *state;
    const lum_render *r = &f->render;
    assert_true(lum_render_clock_us(r, 1, 0) == LUM_RENDER_CLOCK_US);
    assert_true(lum_render_clock_us(r, 1, 2) == LUM_RENDER_CLOCK_US + 3125);
    assert_true(lum_render_clock_us(r, 2, 0) == LUM_RENDER_CLOCK_US + 100000);
}

/* --- packets --- */

static lum_group decode(const struct fixture *f, const lum_sim_packet *packet)
{
    lum_group g = {0};
    assert_int_equal(
        lum_packet_decode(&f->options.layout, packet->bytes, packet->len, &g),
        LUM_PACKET_DATA);
    assert_int_equal(packet->len, 24 + 4 * g.num_samples);
    return g;
}

static void angles_are_cut_334_334_332(void **state)
{
    static const uint32_t cuts[3] = {334, 334, 332};
    struct fixture *f = *state;
    lum_packet_batch *b = &f->batches[0];
    uint32_t first = 0;
    render(f, 1, 20, LUM_EYE_GREEN);
    assert_int_equal(lum_packets_build(&f->options.layout, &f->line, b),
                     LUM_OK);
    for (unsigned i = 0; i < 3; i++) {
        const lum_group g = decode(f, &b->packets[i]);
        assert_int_equal(g.tag, LUM_TAG_ANGLES);
        assert_int_equal(g.num_samples, cuts[i]);
        assert_int_equal(g.first_sample_index, first);
        assert_int_equal(g.line, 20);
        assert_int_equal(g.eye, LUM_EYE_GREEN);
        for (uint32_t k = 0; k < g.num_samples; k++) {
            const lum_angle a = lum_group_angle(&f->options.layout, &g, k);
            assert_int_equal(a.azimuth, f->line.angles[first + k].azimuth);
            assert_int_equal(a.elevation, f->line.angles[first + k].elevation);
        }
        first += g.num_samples;
    }
}

static void range_packets_are_full_and_cut_no_pixel(void **state)
{
    struct fixture *f = *state;
    lum_packet_batch *b = &f->batches[0];
    for (uint32_t line = 0; line < 64; line += 5) {
        size_t words = 0;
        render(f, 1, line, LUM_EYE_BLUE);
        assert_int_equal(lum_packets_build(&f->options.layout, &f->line, b),
                         LUM_OK);
        for (size_t i = 3; i < b->count; i++) {
            const lum_group g = decode(f, &b->packets[i]);
            assert_int_equal(g.tag, LUM_TAG_RANGES);
            assert_int_equal(g.first_sample_index, words);
            assert_true(b->packets[i].len <= LUM_PACKET_BYTES_MAX);
            assert_true(i + 1 == b->count || g.num_samples > 362 - 2 * 4);
            for (uint32_t k = 0; k < g.num_samples; k++) {
                assert_int_equal(lum_group_word(&g, k),
                                 f->line.words[words + k]);
            }
            words += g.num_samples;
            assert_true(words == f->line.word_count ||
                        lum_word_pixel(f->line.words[words - 1]) !=
                            lum_word_pixel(f->line.words[words]));
        }
        assert_int_equal(words, f->line.word_count);
    }
}

static void eyes_take_turns_over_the_time_of_a_line(void **state)
{
    struct fixture *f = *state;
    lum_sim_packet *order[LUM_EYES * LUM_PACKETS_LINE_MAX];
    int64_t before = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        render(f, 1, 1, eye);
        assert_int_equal(
            lum_packets_build(&f->options.layout, &f->line, &f->batches[eye]),
            LUM_OK);
    }
    const size_t n = lum_packets_spread(f->batches, 1562500.0, order);
    assert_int_equal(n, f->batches[0].count + f->batches[1].count);
    for (size_t i = 0; i < n; i++) {
        assert_true(order[i]->time_ns > before);
        before = order[i]->time_ns;
        if (i < 6) {
            assert_int_equal(decode(f, order[i]).eye, i % 2);
        }
    }
    assert_true(before == LUM_RENDER_CLOCK_US * 1000 + 2 * 1562500 - 500);
}

static void a_layout_with_narrow_fields_is_refused(void **state)
{
    lum_profile profile;
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    assert_int_equal(lum_packets_check(&layout, 640), LUM_OK);
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_LINE].bytes = 1;
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    assert_int_equal(lum_packets_check(&layout, 64), LUM_OK);
    assert_int_equal(lum_packets_check(&layout, 640), LUM_E_VALUE);
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].bytes = 1;
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    assert_int_equal(lum_packets_check(&layout, 64), LUM_E_VALUE);
}

/* --- through the assembler and the projector --- */

struct decoder {
    lum_assembler assembler;
    lum_line_slot slots[8];
    uint32_t words[8 * 16384];
    lum_reach reach[2 * 8];
    lum_projector projector;
    lum_sample_workspace workspace;
    lum_return returns[16384];
    lum_sample samples[16384];
};

static void compare_samples(struct decoder *d, const lum_sim_line *truth)
{
    const lum_line *line = lum_assembler_line(&d->assembler);
    lum_selection selection;
    lum_point_losses losses = {0, 0};
    lum_selection_default(&selection);
    d->workspace.returns = d->returns;
    const size_t n = lum_samples_compute(&d->projector, line, &selection,
                                         &d->workspace, d->samples, &losses);
    assert_int_equal(line->number, truth->number);
    assert_true(line->clock_us == truth->clock_us);
    assert_int_equal(n, truth->truth_count);
    for (size_t i = 0; i < n; i++) {
        const lum_sample *a = &d->samples[i];
        const lum_sample *b = &truth->truth[i];
        /* The readings' noise, across the line of sight. */
        const float across =
            b->range * 0.00032f * LUM_RANDOM_NORMAL_MAX / 3.0f + RANGE_BOUND;
        assert_int_equal(a->pixel, b->pixel);
        assert_int_equal(a->return_number, b->return_number);
        assert_int_equal(a->number_of_returns, b->number_of_returns);
        assert_float_equal(a->pulse_width, b->pulse_width, 0.01);
        assert_float_equal(a->x, b->x, across);
        assert_float_equal(a->y, b->y, across);
        assert_float_equal(a->z, b->z, across);
    }
}

static void push_line(struct fixture *f, struct decoder *d)
{
    lum_packet_batch *b = &f->batches[0];
    assert_int_equal(lum_packets_build(&f->options.layout, &f->line, b),
                     LUM_OK);
    for (size_t i = 0; i < b->count; i++) {
        const lum_group g = decode(f, &b->packets[i]);
        assert_int_equal(lum_assembler_push(&d->assembler, &g, 0), LUM_OK);
    }
}

static void decoded_points_are_the_truth_within_the_noise(void **state)
{
    struct fixture *f = *state;
    struct decoder *d = calloc(1, sizeof *d);
    lum_assembler_config config;
    assert_non_null(d);
    lum_assembler_config_default(&config);
    assert_int_equal(lum_projector_init(&d->projector, &f->options.calibration,
                                        &f->options.layout),
                     LUM_OK);
    for (uint32_t line = 3; line < 64; line += 20) {
        const lum_assembler_storage storage =
            LUM_ASSEMBLER_STORAGE(d->slots, d->words, d->reach);
        assert_int_equal(lum_assembler_init(&d->assembler, &config,
                                            &f->options.layout, &storage),
                         LUM_OK);
        render(f, 1, line, line & 1u);
        push_line(f, d);
        assert_int_equal(lum_assembler_flush(&d->assembler), LUM_LINE_READY);
        compare_samples(d, &f->line);
    }
    free(d);
}

/* --- faults --- */

#define PACKETS 500u

struct arrivals {
    size_t count;
    uint32_t number[2 * PACKETS];
    unsigned flipped[2 * PACKETS];
};

static unsigned count_bits(uint8_t x)
{
    unsigned n = 0;
    for (; x != 0; x &= (uint8_t)(x - 1)) {
        n++;
    }
    return n;
}

/* Packets have the low byte of their number 20 times, then the high one, so
 * that it survives three flipped bits. */
static uint8_t most_frequent(const uint8_t *p)
{
    uint8_t found = 0;
    for (unsigned bit = 0; bit < 8; bit++) {
        unsigned votes = 0;
        for (size_t i = 0; i < 20; i++) {
            votes += (p[i] >> bit) & 1u;
        }
        found |= (uint8_t)(votes > 10 ? 1u << bit : 0u);
    }
    return found;
}

static void note_arrivals(lum_fault *fault, struct arrivals *out)
{
    const lum_sim_packet *p;
    while ((p = lum_fault_pull(fault)) != NULL) {
        const uint8_t low = most_frequent(p->bytes);
        const uint8_t high = most_frequent(p->bytes + 20);
        unsigned flipped = 0;
        for (size_t i = 0; i < 20; i++) {
            flipped += count_bits(p->bytes[i] ^ low);
            flipped += count_bits(p->bytes[20 + i] ^ high);
        }
        assert_int_equal(p->len, 40);
        assert_true(out->count < 2 * PACKETS);
        out->number[out->count] = (uint32_t)low | ((uint32_t)high << 8);
        out->flipped[out->count++] = flipped;
    }
}

static void run_faults(double loss, double duplicate, double reorder,
                       double corrupt, uint64_t seed, struct arrivals *out)
{
    const double probability[LUM_FAULT_KINDS] = {loss, duplicate, reorder,
                                                 corrupt};
    lum_fault *fault = malloc(sizeof *fault);
    lum_sim_packet *packet = calloc(1, sizeof *packet);
    assert_non_null(fault);
    assert_non_null(packet);
    memset(out, 0, sizeof *out);
    lum_fault_init(fault, probability, seed);
    for (uint32_t i = 0; i < PACKETS; i++) {
        packet->time_ns = (int64_t)i * 1000;
        packet->len = 40;
        memset(packet->bytes, (int)(i & 0xffu), 20);
        memset(packet->bytes + 20, (int)(i >> 8), 20);
        lum_fault_push(fault, packet);
        note_arrivals(fault, out);
    }
    lum_fault_flush(fault);
    note_arrivals(fault, out);
    free(packet);
    free(fault);
}

static void probability_0_changes_nothing(void **state)
{
    struct arrivals a;
    (void)state;
    run_faults(0, 0, 0, 0, 1, &a);
    assert_int_equal(a.count, PACKETS);
    for (uint32_t i = 0; i < PACKETS; i++) {
        assert_int_equal(a.number[i], i);
        assert_int_equal(a.flipped[i], 0);
    }
}

static void loss_of_1_loses_everything(void **state)
{
    struct arrivals a;
    (void)state;
    run_faults(1, 1, 1, 1, 1, &a);
    assert_int_equal(a.count, 0);
}

static void duplicate_of_1_doubles_everything(void **state)
{
    struct arrivals a;
    (void)state;
    run_faults(0, 1, 0, 0, 1, &a);
    assert_int_equal(a.count, 2 * PACKETS);
    for (uint32_t i = 0; i < 2 * PACKETS; i++) {
        assert_int_equal(a.number[i], i / 2);
    }
}

static void corrupt_of_1_flips_1_to_3_bits_of_each(void **state)
{
    struct arrivals a;
    (void)state;
    run_faults(0, 0, 0, 1, 1, &a);
    assert_int_equal(a.count, PACKETS);
    for (uint32_t i = 0; i < PACKETS; i++) {
        assert_int_equal(a.number[i], i);
        assert_in_range(a.flipped[i], 1, 3);
    }
}

static void reorder_displaces_by_a_few_and_loses_nothing(void **state)
{
    struct arrivals a;
    bool seen[PACKETS] = {false};
    unsigned displaced = 0;
    (void)state;
    run_faults(0, 0, 0.2, 0, 1, &a);
    assert_int_equal(a.count, PACKETS);
    for (uint32_t i = 0; i < PACKETS; i++) {
        const uint32_t n = a.number[i];
        assert_false(seen[n]);
        seen[n] = true;
        displaced += n != i;
        assert_true(n <= i + LUM_FAULT_REACH && i <= n + LUM_FAULT_REACH);
    }
    assert_true(displaced > PACKETS / 10);
}

static void a_packet_that_waits_leaves_behind_later_ones(void **state)
{
    struct arrivals a;
    unsigned behind = 0;
    uint32_t furthest = 0;
    (void)state;
    run_faults(0, 0, 0.05, 0, 9, &a);
    for (uint32_t i = 1; i < PACKETS; i++) {
        const uint32_t by = i > a.number[i] ? i - a.number[i] : 0;
        behind += a.number[i] < a.number[i - 1];
        furthest = by > furthest ? by : furthest;
    }
    assert_true(behind > 5 && behind < 50);
    assert_int_equal(furthest, LUM_FAULT_REACH);
}

static void everything_at_once_stays_in_bounds(void **state)
{
    struct arrivals a;
    (void)state;
    run_faults(0, 1, 1, 1, 1, &a);
    assert_int_equal(a.count, 2 * PACKETS);
    run_faults(0.5, 0.5, 0.5, 0.5, 1, &a);
    assert_true(a.count > PACKETS / 2 && a.count < PACKETS);
}

static void faults_repeat_with_their_seed(void **state)
{
    struct arrivals a;
    struct arrivals b;
    (void)state;
    run_faults(0.1, 0.1, 0.1, 0.1, 5, &a);
    run_faults(0.1, 0.1, 0.1, 0.1, 5, &b);
    assert_memory_equal(&a, &b, sizeof a);
    run_faults(0.1, 0.1, 0.1, 0.1, 6, &b);
    assert_memory_not_equal(&a, &b, sizeof a);
}

static void a_fault_leaves_the_others_alone(void **state)
{
    struct arrivals a;
    struct arrivals b;
    size_t k = 0;
    (void)state;
    run_faults(0.1, 0, 0, 0, 5, &a);
    run_faults(0.1, 0, 0, 0.3, 5, &b);
    assert_int_equal(a.count, b.count);
    for (; k < a.count; k++) {
        assert_int_equal(a.number[k], b.number[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(xoshiro_gives_its_published_numbers),
        cmocka_unit_test(streams_of_a_seed_differ_and_repeat),
        cmocka_unit_test(golden_numbers_of_a_stream_never_change),
        cmocka_unit_test(normal_numbers_have_mean_0_and_deviation_1),
        cmocka_unit_test(chances_of_0_and_1_are_certain),
        cmocka_unit_test(a_ray_meets_each_shape_where_it_stands),
        cmocka_unit_test(a_window_lies_behind_its_facade),
        cmocka_unit_test(the_rim_of_a_pole_stops_part_of_a_beam),
        cmocka_unit_test(the_ground_is_road_kerb_and_pavement),
        cmocka_unit_test(cells_lose_no_shape),
        cmocka_unit_test(a_scene_is_the_same_again),
        cmocka_unit_test(a_layout_with_narrow_fields_is_refused),
        cmocka_unit_test(probability_0_changes_nothing),
        cmocka_unit_test(loss_of_1_loses_everything),
        cmocka_unit_test(duplicate_of_1_doubles_everything),
        cmocka_unit_test(corrupt_of_1_flips_1_to_3_bits_of_each),
        cmocka_unit_test(reorder_displaces_by_a_few_and_loses_nothing),
        cmocka_unit_test(a_packet_that_waits_leaves_behind_later_ones),
        cmocka_unit_test(everything_at_once_stays_in_bounds),
        cmocka_unit_test(faults_repeat_with_their_seed),
        cmocka_unit_test(a_fault_leaves_the_others_alone),
#define WITH_LINES(test)                                                       \
    cmocka_unit_test_setup_teardown(test, set_up, tear_down)
        WITH_LINES(lines_sweep_to_and_fro_inside_the_span),
        WITH_LINES(readings_are_true_angles_but_for_small_noise),
        WITH_LINES(a_line_is_the_same_in_any_order_of_rendering),
        WITH_LINES(every_word_is_good_and_edges_alternate_in_order),
        WITH_LINES(truth_agrees_with_words_within_the_noise),
        WITH_LINES(truth_points_lie_where_their_angles_say),
        WITH_LINES(low_lines_see_the_road),
        WITH_LINES(a_mount_moves_the_eye_and_not_the_street),
        WITH_LINES(returns_max_limits_a_pixel),
        WITH_LINES(less_power_or_more_threshold_sees_less),
        WITH_LINES(a_tof_offset_shifts_words_and_not_ranges),
        WITH_LINES(an_angle_scale_that_cannot_reach_the_span_is_refused),
        WITH_LINES(lines_last_as_the_rate_says),
        WITH_LINES(angles_are_cut_334_334_332),
        WITH_LINES(range_packets_are_full_and_cut_no_pixel),
        WITH_LINES(eyes_take_turns_over_the_time_of_a_line),
        WITH_LINES(decoded_points_are_the_truth_within_the_noise),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
