#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/frame/framer.h"
#include "lum/frame/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CASES   300u
#define MOST    3000u
#define CHOICES 5u

/* Points, and a picture of them. */
struct picture {
    float x[MOST];
    float y[MOST];
    float z[MOST];
    float width[MOST];
    uint8_t eye[MOST];
    lum_image_points points;
    lum_image_options options;
    lum_image_counts counts;
    uint32_t pixels[MOST];
    uint32_t index[4096];
};

static uint32_t draw(uint64_t *seed)
{
    uint64_t z = *seed += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)(z >> 32);
}

static float between(uint64_t *seed, float min, float max)
{
    return min + (max - min) * (float)draw(seed) / 4294967296.0f;
}

static size_t size_of(const struct picture *p)
{
    return (size_t)p->options.view.rows * p->options.view.columns;
}

static struct picture *make(void)
{
    struct picture *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->points = (lum_image_points){.struct_size = sizeof p->points,
                                   .x = p->x,
                                   .y = p->y,
                                   .z = p->z,
                                   .pulse_width = p->width,
                                   .eye = p->eye};
    p->options = (lum_image_options){.struct_size = sizeof p->options,
                                     .eyes = LUM_IMAGE_BOTH};
    p->counts.struct_size = sizeof p->counts;
    lum_image_view_default(&p->options.view, LUM_IMAGE_BOTH, 0);
    p->options.view.rows = 16;
    p->options.view.columns = 64;
    return p;
}

/* The last one; degrees and metres. */
static void add(struct picture *p, double azimuth, double elevation,
                double range)
{
    const double radians = 3.14159265358979 / 180.0;
    const double level = range * cos(elevation * radians);
    const size_t i = p->points.count++;
    p->x[i] = (float)(level * cos(azimuth * radians));
    p->y[i] = (float)(level * sin(azimuth * radians));
    p->z[i] = (float)(range * sin(elevation * radians));
}

static void picture(struct picture *p)
{
    memset(p->index, 0x55, sizeof p->index);
    memset(p->pixels, 0x55, sizeof p->pixels);
    assert_int_equal(lum_image_index(&p->points, &p->options, p->index,
                                     p->pixels, &p->counts),
                     LUM_OK);
}

/* Of widths and distances, few are different, so that many are equal. */
static void draw_points(struct picture *p, uint64_t *seed)
{
    const size_t count = draw(seed) % MOST;
    p->points.count = 0;
    while (p->points.count < count) {
        const size_t i = p->points.count;
        add(p, between(seed, -80.0f, 80.0f), between(seed, -25.0f, 10.0f),
            (double)(draw(seed) % 5u + 1u));
        p->eye[i] = (uint8_t)(draw(seed) % 8u / 7u);
        p->width[i] = (float)(draw(seed) % 4u);
    }
    p->points.eye = draw(seed) % 4u == 0 ? NULL : p->eye;
    p->options.eyes = draw(seed) % 3u + 1u;
    p->options.choice = (lum_image_choice)(draw(seed) % CHOICES);
    p->options.view.rows = draw(seed) % 32u + 1u;
    p->options.view.columns = draw(seed) % 128u + 1u;
    if (draw(seed) % 2u == 0) {
        p->options.view.left_deg = between(seed, 0.0f, 180.0f);
        p->options.view.right_deg = between(seed, -179.0f, -1.0f);
        p->options.view.top_deg = between(seed, 1.0f, 90.0f);
    }
}

static bool is_asked(const struct picture *p, size_t i)
{
    return p->points.eye == NULL || (p->options.eyes >> p->eye[i] & 1u) != 0;
}

static float square_of(const struct picture *p, size_t i)
{
    return p->x[i] * p->x[i] + p->y[i] * p->y[i] + p->z[i] * p->z[i];
}

/* Whether a later point takes a pixel from an earlier one. */
static bool takes(const struct picture *p, size_t later, size_t earlier)
{
    const float nearer = square_of(p, later) - square_of(p, earlier);
    const bool results[CHOICES] = {
        [LUM_IMAGE_NEAREST] = nearer<0.0f, [LUM_IMAGE_FARTHEST] = nearer> 0.0f,
        [LUM_IMAGE_STRONGEST] = p->width[later] > p->width[earlier],
        [LUM_IMAGE_FIRST] = false,
        [LUM_IMAGE_LAST] = true};
    return results[p->options.choice];
}

/* The picture again, from the pixels of the points. */
static void assert_consistent(const struct picture *p)
{
    uint32_t expected[4096];
    lum_image_counts counts = {.filled = 0};
    memset(expected, 0xff, sizeof expected);
    for (uint32_t i = 0; i < p->points.count; i++) {
        const uint32_t pixel = p->pixels[i];
        if (!is_asked(p, i) || pixel == LUM_FRAME_MISSING) {
            assert_int_equal(pixel, LUM_FRAME_MISSING);
            counts.outside += is_asked(p, i);
            continue;
        }
        assert_true(pixel < size_of(p));
        counts.filled += expected[pixel] == LUM_FRAME_MISSING;
        counts.hidden += expected[pixel] != LUM_FRAME_MISSING;
        if (expected[pixel] == LUM_FRAME_MISSING ||
            takes(p, i, expected[pixel])) {
            expected[pixel] = i;
        }
    }
    assert_memory_equal(p->index, expected, size_of(p) * sizeof *expected);
    assert_int_equal(p->counts.filled, counts.filled);
    assert_int_equal(p->counts.hidden, counts.hidden);
    assert_int_equal(p->counts.outside, counts.outside);
}

/* A place in pixels, by the library's own functions. */
static void assert_place(const struct picture *p, uint32_t i)
{
    const lum_image_view *v = &p->options.view;
    const double degrees = 180.0 / 3.14159265358979;
    const double x = (double)p->x[i];
    const double y = (double)p->y[i];
    const double az = atan2(y, x) * degrees;
    const double el = atan2((double)p->z[i], hypot(x, y)) * degrees;
    const double column =
        (v->left_deg - az) / (v->left_deg - v->right_deg) * v->columns;
    const double row =
        (v->top_deg - el) / (v->top_deg - v->bottom_deg) * v->rows;
    const double bound = 0.02; /* of a pixel: the finest are 0.1 degrees */
    if (p->pixels[i] == LUM_FRAME_MISSING) {
        assert_true(column < -0.5 + bound ||
                    column > v->columns + 0.5 - bound || row < -0.5 + bound ||
                    row > v->rows + 0.5 - bound);
        return;
    }
    const double at_column = p->pixels[i] % v->columns;
    const uint32_t at_line = p->pixels[i] / v->columns;
    const double at_row = at_line;
    const double last_column = at_column + 1.0 < v->columns ? 1.0 : 1.5;
    const double last_row = at_row + 1.0 < v->rows ? 1.0 : 1.5;
    assert_true(column > at_column - (at_column > 0 ? 0.0 : 0.5) - bound);
    assert_true(column < at_column + last_column + bound);
    assert_true(row > at_row - (at_row > 0 ? 0.0 : 0.5) - bound);
    assert_true(row < at_row + last_row + bound);
}

static void index_and_pixels_agree_whatever_the_points(void **state)
{
    struct picture *p = make();
    uint64_t seed = 34;
    (void)state;
    for (unsigned i = 0; i < CASES; i++) {
        draw_points(p, &seed);
        picture(p);
        assert_consistent(p);
        for (uint32_t k = 0; k < p->points.count; k++) {
            if (is_asked(p, k)) {
                assert_place(p, k);
            }
        }
    }
    free(p);
}

static void left_is_left_and_up_is_up(void **state)
{
    struct picture *p = make();
    (void)state;
    add(p, 59.0, 2.5, 10.0);
    add(p, -59.0, 2.5, 10.0);
    add(p, 59.0, -16.5, 10.0);
    add(p, -59.0, -16.5, 10.0);
    picture(p);
    assert_int_equal(p->index[0], 0);
    assert_int_equal(p->index[63], 1);
    assert_int_equal(p->index[15 * 64], 2);
    assert_int_equal(p->index[15 * 64 + 63], 3);
    free(p);
}

static void half_a_pixel_beyond_an_edge_belongs_to_it(void **state)
{
    struct picture *p = make();
    (void)state;
    add(p, 60.9, 3.6, 10.0);
    add(p, -60.9, -17.6, 10.0);
    add(p, 61.0, 0.0, 10.0);
    add(p, 0.0, -17.7, 10.0);
    add(p, 180.0, 0.0, 10.0);
    add(p, 0.0, 0.0, 0.0);
    add(p, 0.0, 0.0, (double)NAN);
    picture(p);
    assert_int_equal(p->pixels[0], 0);
    assert_int_equal(p->pixels[1], 16 * 64 - 1);
    for (unsigned i = 2; i < 7; i++) {
        assert_int_equal(p->pixels[i], LUM_FRAME_MISSING);
    }
    assert_int_equal(p->counts.outside, 5);
    free(p);
}

static void a_view_can_look_back(void **state)
{
    struct picture *p = make();
    (void)state;
    p->options.view = (lum_image_view){225.0f, 135.0f, 80.0f, 0.0f, 1, 3};
    add(p, -150.0, 40.0, 10.0);
    add(p, 180.0, 40.0, 10.0);
    add(p, 140.0, 40.0, 10.0);
    add(p, 0.0, 40.0, 10.0);
    picture(p);
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(p->pixels[i], i);
    }
    assert_int_equal(p->pixels[3], LUM_FRAME_MISSING);
    free(p);
}

/* A line of the green eye, as a frame. */
static lum_frame *frame_of(lum_columns columns)
{
    static struct drive_line line;
    static uint32_t words[2000];
    lum_framer *framer = NULL;
    lum_view view;
    lum_view_default(&view);
    view.columns = columns;
    for (uint32_t i = 0; i < 2000; i++) {
        words[i] = lum_word_make((int32_t)(3000u + i), true, i / 2u);
    }
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = &view, .view_count = 1};
    assert_int_equal(lum_framer_new(&options, &framer, NULL), 0);
    drive_make(&line, LUM_EYE_GREEN, 3, 1500, words, 2000);
    for (size_t i = 0; i < line.count; i++) {
        const lum_record record = drive_record(&line, i, DRIVE_SENSOR, 1);
        assert_int_equal(lum_framer_push(framer, &record, NULL),
                         LUM_FRAMER_NONE);
    }
    assert_int_equal(lum_framer_flush(framer), LUM_FRAMER_FRAME);
    lum_frame *frame = lum_frame_keep(lum_framer_frame(framer, 0));
    lum_framer_free(framer);
    return frame;
}

static void a_frame_is_as_its_arrays(void **state)
{
    lum_frame *f = frame_of(LUM_COLUMNS_ALL);
    struct picture *p = make();
    static uint32_t index[4096];
    static float numbers[4096];
    (void)state;
    p->points.count = lum_frame_count(f);
    p->points.x = lum_frame_floats(f, LUM_COLUMN_X);
    p->points.y = lum_frame_floats(f, LUM_COLUMN_Y);
    p->points.z = lum_frame_floats(f, LUM_COLUMN_Z);
    p->points.eye = lum_frame_uint8s(f, LUM_COLUMN_EYE);
    for (uint32_t eyes = LUM_IMAGE_BLUE; eyes <= LUM_IMAGE_BOTH; eyes++) {
        const size_t bytes = size_of(p) * sizeof *index;
        p->options.eyes = eyes;
        picture(p);
        assert_int_equal(
            lum_frame_image_index(f, &p->options, index, NULL, NULL), LUM_OK);
        assert_memory_equal(index, p->index, bytes);
        assert_int_equal(p->counts.filled > 0, eyes != LUM_IMAGE_BLUE);
        assert_int_equal(
            lum_frame_image(f, LUM_COLUMN_PIXEL, index, size_of(p), numbers),
            LUM_OK);
        for (size_t i = 0; i < size_of(p); i++) {
            assert_true(index[i] == LUM_FRAME_MISSING
                            ? isnan(numbers[i])
                            : numbers[i] == lum_frame_uint16s(
                                                f, LUM_COLUMN_PIXEL)[index[i]]);
        }
    }
    lum_frame_release(f);
    free(p);
}

static void sizes_follow_lines_and_eyes(void **state)
{
    lum_frame *f = frame_of(LUM_COLUMNS_XYZ);
    lum_image_options o = {.struct_size = sizeof o};
    lum_image_view v;
    (void)state;
    assert_int_equal(lum_frame_image_default(f, LUM_IMAGE_GREEN, &o), LUM_OK);
    assert_int_equal(o.view.rows, 64);
    assert_int_equal(o.view.columns, 800);
    lum_image_view_default(&v, LUM_IMAGE_BOTH, 640);
    assert_int_equal(v.rows, 640);
    assert_int_equal(v.columns, 1600);
    lum_image_view_default(&v, LUM_IMAGE_BLUE, 65);
    assert_int_equal(v.rows, 128);
    assert_true(v.left_deg == 0.0f && v.right_deg == -60.0f);
    lum_image_view_default(&v, 7, UINT32_MAX);
    lum_image_scale scale;
    assert_int_equal(lum_image_scale_init(&scale, &v), LUM_OK);
    o.struct_size = 0;
    assert_int_equal(lum_frame_image_default(f, 1, &o), LUM_E_VALUE);
    lum_frame_release(f);
}

static void assert_refused(const struct picture *p)
{
    uint32_t index = 7;
    uint32_t pixels = 7;
    assert_int_equal(
        lum_image_index(&p->points, &p->options, &index, &pixels, NULL),
        LUM_E_VALUE);
    assert_true(index == 7 && pixels == 7);
}

static void what_cannot_be_is_refused_and_writes_nothing(void **state)
{
    const lum_image_view views[] = {
        {0.0f, 0.0f, 3.0f, -17.0f, 1, 1},
        {0.0f, 1.0f, 3.0f, -17.0f, 1, 1},
        {361.0f, 1.0f, 3.0f, -17.0f, 1, 1},
        {200.0f, -161.0f, 3.0f, 0.0f, 1, 1},
        {9.0f, 0.0f, 91.0f, -17.0f, 1, 1},
        {9.0f, 0.0f, 3.0f, -91.0f, 1, 1},
        {9.0f, 0.0f, 3.0f, 3.0f, 1, 1},
        {9.0f, NAN, 3.0f, 0.0f, 1, 1},
        {9.0f, 0.0f, 3.0f, 0.0f, 0, 1},
        {9.0f, 0.0f, 3.0f, 0.0f, 1, 0},
        {9.0f, 0.0f, 3.0f, 0.0f, 1u << 15, (1u << 13) + 1u}};
    struct picture *p = make();
    const lum_image_options fine = p->options;
    (void)state;
    add(p, 1.0, 0.0, 5.0);
    for (size_t i = 0; i < sizeof views / sizeof views[0]; i++) {
        p->options.view = views[i];
        assert_refused(p);
    }
    p->options = fine;
    p->options.eyes = 4;
    assert_refused(p);
    p->options.eyes = 0;
    assert_refused(p);
    p->options = fine;
    p->options.choice = (lum_image_choice)CHOICES;
    assert_refused(p);
    p->options.choice = LUM_IMAGE_STRONGEST;
    p->points.pulse_width = NULL;
    assert_refused(p);
    p->options = fine;
    p->options.struct_size = 0;
    assert_refused(p);
    p->options = fine;
    p->points.struct_size = 0;
    assert_refused(p);
    p->points.struct_size = sizeof p->points;
    p->points.z = NULL;
    assert_refused(p);
    p->points.z = p->z;
    p->counts.struct_size = 0;
    assert_int_equal(
        lum_image_index(&p->points, &p->options, p->index, NULL, &p->counts),
        LUM_E_VALUE);
    free(p);
}

static void a_frame_without_a_column_is_refused(void **state)
{
    lum_frame *f =
        frame_of(LUM_COLUMN_BIT(LUM_COLUMN_X) | LUM_COLUMN_BIT(LUM_COLUMN_Y));
    lum_image_options o = {.struct_size = sizeof o};
    uint32_t index = 0;
    float number = 0.0f;
    (void)state;
    assert_int_equal(lum_frame_image_default(f, LUM_IMAGE_BOTH, &o), LUM_OK);
    assert_int_equal(lum_frame_image_index(f, &o, NULL, NULL, NULL),
                     LUM_E_VALUE);
    assert_int_equal(lum_frame_image(f, LUM_COLUMN_Z, &index, 1, &number),
                     LUM_E_VALUE);
    assert_int_equal(lum_frame_image(f, LUM_COLUMN_X, &index, 1, &number),
                     LUM_OK);
    index = (uint32_t)lum_frame_count(f);
    assert_int_equal(lum_frame_image(f, LUM_COLUMN_X, &index, 1, &number),
                     LUM_E_VALUE);
    lum_frame_release(f);
}

static uint32_t hash_of(const uint32_t *numbers, size_t n)
{
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < n; i++) {
        hash = (hash ^ numbers[i]) * 16777619u;
    }
    return hash;
}

/* A whole number of the generator that tests/view/facts_pictures.mjs has too.
 */
static float turn_of(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 20);
}

/* Its image.js has these sums as well. */
static void the_page_of_lumview_has_the_same_picture(void **state)
{
    struct picture *p = make();
    uint32_t seed = 1;
    (void)state;
    p->points.eye = NULL;
    for (p->points.count = 0; p->points.count < MOST; p->points.count++) {
        p->x[p->points.count] = turn_of(&seed) / 64.0f - 1.0f;
        p->y[p->points.count] = (turn_of(&seed) - 2048.0f) / 32.0f;
        p->z[p->points.count] = (turn_of(&seed) - 3072.0f) / 128.0f;
    }
    picture(p);
    assert_int_equal(hash_of(p->pixels, MOST), 1585087420u);
    assert_int_equal(hash_of(p->index, size_of(p)), 2793020274u);
    free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(index_and_pixels_agree_whatever_the_points),
        cmocka_unit_test(left_is_left_and_up_is_up),
        cmocka_unit_test(half_a_pixel_beyond_an_edge_belongs_to_it),
        cmocka_unit_test(a_view_can_look_back),
        cmocka_unit_test(a_frame_is_as_its_arrays),
        cmocka_unit_test(sizes_follow_lines_and_eyes),
        cmocka_unit_test(what_cannot_be_is_refused_and_writes_nothing),
        cmocka_unit_test(a_frame_without_a_column_is_refused),
        cmocka_unit_test(the_page_of_lumview_has_the_same_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
