#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "picture/picture_internal.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#define CELLS ((size_t)LUM_PANORAMA_CELLS * LUM_PANORAMA_CELLS)

enum {
    WIDTH = 200,
    HEIGHT = 100
};

static const lum_box all = {0, 0, WIDTH, HEIGHT};
static const lum_rgb black = {0, 0, 0};
static const lum_rgb white = {255, 255, 255};

static lum_canvas *make_canvas(void)
{
    lum_canvas *canvas = lum_canvas_new(WIDTH, HEIGHT);
    assert_non_null(canvas);
    return canvas;
}

static bool is_colour(const lum_canvas *canvas, int x, int y, lum_rgb colour)
{
    const lum_rgb c = lum_canvas_get(canvas, x, y);
    return c.r == colour.r && c.g == colour.g && c.b == colour.b;
}

static bool is_black(const lum_canvas *canvas, int x, int y)
{
    return is_colour(canvas, x, y, black);
}

/* Pixels in a box that are neither the panel nor black. */
static int count_painted(const lum_canvas *canvas, lum_box box)
{
    int n = 0;
    for (int y = box.y; y < box.y + box.height; y++) {
        for (int x = box.x; x < box.x + box.width; x++) {
            n += !is_black(canvas, x, y) && !is_colour(canvas, x, y, lum_panel);
        }
    }
    return n;
}

/* The smallest box around what is not black. */
static lum_box find_painted(const lum_canvas *canvas)
{
    int left = WIDTH;
    int right = 0;
    int top = HEIGHT;
    int bottom = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH;
        const int y = i / WIDTH;
        if (!is_black(canvas, x, y)) {
            left = x < left ? x : left;
            right = x + 1 > right ? x + 1 : right;
            top = y < top ? y : top;
            bottom = y + 1 > bottom ? y + 1 : bottom;
        }
    }
    const lum_box box = {left, top, right - left, bottom - top};
    return box;
}

/* A canvas with a white text on black, at 100, 50. */
static lum_canvas *write_text(const char *text, float size, lum_align align)
{
    const lum_style style = {size, align, white, black, 0.0f};
    lum_canvas *canvas = make_canvas();
    lum_canvas_text(canvas, &style, 100, 50, text);
    return canvas;
}

static lum_box measure_text(const char *text, float size, lum_align align)
{
    lum_canvas *canvas = write_text(text, size, align);
    const lum_box box = find_painted(canvas);
    lum_canvas_free(canvas);
    return box;
}

static bool are_equal(const lum_canvas *a, const lum_canvas *b)
{
    int different = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        different += !is_colour(a, i % WIDTH, i / WIDTH,
                                lum_canvas_get(b, i % WIDTH, i / WIDTH));
    }
    return different == 0;
}

static lum_raster *make_raster(void)
{
    lum_raster *raster = calloc(1, sizeof *raster);
    assert_non_null(raster);
    lum_raster_begin(raster, NULL);
    return raster;
}

static void add(lum_raster *raster, uint8_t eye, float azimuth, float elevation,
                float range)
{
    const float radians = 3.14159265f / 180.0f;
    const float turned = (azimuth + (eye == LUM_EYE_GREEN ? 30.0f : -30.0f));
    const float level = range * cosf(elevation * radians);
    const lum_sample sample = {.x = level * cosf(turned * radians),
                               .y = level * sinf(turned * radians),
                               .z = range * sinf(elevation * radians),
                               .range = range};
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &sample, .count = 1, .eye = eye};
    lum_raster_add(raster, &line);
}

static void what_lies_outside_of_the_canvas_does_nothing(void **state)
{
    const lum_style style = {14.0f, LUM_ALIGN_LEFT, white, white, 1.0f};
    const lum_box around = {-5, -5, 5, HEIGHT + 10};
    const lum_box beyond = {WIDTH, 0, 10, 10};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_canvas_set(canvas, -1, 0, white);
    lum_canvas_set(canvas, 0, HEIGHT, white);
    lum_canvas_set(canvas, WIDTH, 0, white);
    lum_canvas_fill(canvas, around, white);
    lum_canvas_fill(canvas, beyond, white);
    lum_canvas_text(canvas, &style, -200, -50, "Out");
    lum_canvas_circle(canvas, all, -1e5f, 0.0f, 10.0f, white);
    assert_int_equal(count_painted(canvas, all), 0);
    assert_true(is_colour(canvas, -1, 0, black));
    assert_true(is_colour(canvas, WIDTH, HEIGHT, black));
    lum_canvas_free(canvas);
    lum_canvas_free(NULL);
}

static void pixels_and_boxes_have_exactly_their_colour(void **state)
{
    const lum_rgb pixel = {1, 128, 254};
    const lum_rgb colour = {12, 13, 16};
    const lum_box box = {10, 20, 30, 40};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_canvas_fill(canvas, box, colour);
    lum_canvas_set(canvas, 0, 0, pixel);
    lum_canvas_set(canvas, 39, 59, pixel); /* drawn over the box */
    lum_canvas_set(canvas, WIDTH - 1, HEIGHT - 1, pixel);
    assert_true(is_colour(canvas, 0, 0, pixel));
    assert_true(is_colour(canvas, 39, 59, pixel));
    assert_true(is_colour(canvas, WIDTH - 1, HEIGHT - 1, pixel));
    for (int y = 19; y < 61; y++) {
        for (int x = 9; x < 41; x++) {
            const bool inside = x >= 10 && x < 40 && y >= 20 && y < 60;
            assert_true((x == 39 && y == 59) ||
                        is_colour(canvas, x, y, inside ? colour : black));
        }
    }
    lum_canvas_free(canvas);
}

static void a_box_hides_the_pixels_below_it(void **state)
{
    const lum_box box = {5, 5, 10, 10};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_canvas_set(canvas, 7, 7, white);
    lum_canvas_fill(canvas, box, lum_grid);
    assert_true(is_colour(canvas, 7, 7, lum_grid));
    lum_canvas_free(canvas);
}

static void a_circle_has_its_radius_and_stays_in_its_box(void **state)
{
    const lum_box box = {0, 0, 100, HEIGHT};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_canvas_circle(canvas, box, 80.5f, 50.5f, 30.0f, white);
    const lum_box painted = find_painted(canvas);
    assert_in_range(painted.x, 49, 51);
    assert_int_equal(painted.x + painted.width, 100);
    assert_in_range(painted.y, 19, 21);
    assert_in_range(painted.height, 60, 63);
    assert_false(is_black(canvas, 50, 50));
    assert_false(is_black(canvas, 80, 80));
    assert_true(is_black(canvas, 80, 50));
    lum_canvas_free(canvas);
}

static void text_stands_where_it_was_asked_for(void **state)
{
    (void)state;
    const lum_box left = measure_text("-15", 20.0f, LUM_ALIGN_LEFT);
    const lum_box middle = measure_text("-15", 20.0f, LUM_ALIGN_MIDDLE);
    const lum_box right = measure_text("-15", 20.0f, LUM_ALIGN_RIGHT);
    assert_in_range(left.x, 99, 104);
    assert_in_range(left.width, 20, 50);
    assert_in_range(2 * middle.x + middle.width, 195, 205);
    assert_in_range(right.x + right.width, 96, 101);
    assert_in_range(2 * left.y + left.height, 97, 103);
    assert_int_equal(middle.y, left.y);
    assert_int_equal(right.height, left.height);
}

static void text_is_as_large_as_it_was_asked_for(void **state)
{
    (void)state;
    for (int size = 12; size <= 48; size += 12) {
        const lum_box digit = measure_text("0", (float)size, LUM_ALIGN_MIDDLE);
        assert_in_range(digit.height, size / 2, size);
    }
}

static bool differ(const char *a, const char *b)
{
    lum_canvas *one = write_text(a, 30.0f, LUM_ALIGN_MIDDLE);
    lum_canvas *other = write_text(b, 30.0f, LUM_ALIGN_MIDDLE);
    const bool result = !are_equal(one, other);
    lum_canvas_free(one);
    lum_canvas_free(other);
    return result;
}

/* And none is the box that stands for what the letters lack. */
static void each_character_is_drawn(void **state)
{
    (void)state;
    for (int c = '!'; c <= '~'; c++) {
        const char text[] = {(char)c, '\0'};
        assert_true(measure_text(text, 30.0f, LUM_ALIGN_MIDDLE).width > 0);
        assert_true(differ(text, "\xc2\xb0"));
    }
}

static void upper_and_lower_case_and_digits_differ(void **state)
{
    (void)state;
    for (int i = 0; i < 26; i++) {
        const char upper[] = {(char)('A' + i), '\0'};
        const char lower[] = {(char)('a' + i), '\0'};
        assert_true(differ(upper, lower));
    }
    for (int i = 0; i < 100; i++) {
        const char one[] = {(char)('0' + i / 10), '\0'};
        const char other[] = {(char)('0' + i % 10), '\0'};
        assert_true(differ(one, other) == (i / 10 != i % 10));
    }
    assert_true(measure_text("x", 40.0f, LUM_ALIGN_LEFT).height <
                measure_text("X", 40.0f, LUM_ALIGN_LEFT).height);
}

static void *draw_texts(void *argument)
{
    lum_canvas *canvas = make_canvas();
    lum_canvas **out = (lum_canvas **)argument;
    for (int i = 0; i < 40; i++) {
        const lum_style style = {10.0f + (float)(i % 8), LUM_ALIGN_LEFT, white,
                                 black, 1.0f};
        lum_canvas_text(canvas, &style, i % 5, 2 * i, "Luminar 0123456789");
    }
    *out = canvas;
    return NULL;
}

/* lumdump draws each of its pictures in a thread of its own. */
static void threads_draw_the_same_at_the_same_time(void **state)
{
    enum {
        THREADS = 4
    };
    lum_canvas *canvas[THREADS] = {NULL};
    pthread_t threads[THREADS];
    (void)state;
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(
            pthread_create(&threads[i], NULL, draw_texts, &canvas[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        assert_true(are_equal(canvas[i], canvas[0]));
    }
    for (int i = 0; i < THREADS; i++) {
        lum_canvas_free(canvas[i]);
    }
}

static void text_is_smooth_and_nothing_but_grey(void **state)
{
    lum_canvas *canvas = write_text("Range", 30.0f, LUM_ALIGN_MIDDLE);
    int between = 0;
    int full = 0;
    (void)state;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const lum_rgb c = lum_canvas_get(canvas, i % WIDTH, i / WIDTH);
        assert_true(c.r == c.g && c.g == c.b);
        between += c.r > 20 && c.r < 235;
        full += c.r > 235;
    }
    assert_true(between > 50);
    assert_true(full > 50);
    lum_canvas_free(canvas);
}

static void a_text_can_cover_what_is_behind_it(void **state)
{
    lum_style style = {20.0f, LUM_ALIGN_MIDDLE, black, black, 0.5f};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_canvas_fill(canvas, all, white);
    lum_canvas_text(canvas, &style, 100, 50, "1         1");
    assert_in_range(lum_canvas_get(canvas, 100, 50).r, 120, 135);
    assert_true(is_colour(canvas, 100, 20, white));
    style.cover = 0.0f;
    lum_canvas_text(canvas, &style, 100, 80, "1         1");
    assert_true(is_colour(canvas, 100, 80, white));
    lum_canvas_free(canvas);
}

static void the_colour_scale_goes_from_red_to_violet(void **state)
{
    (void)state;
    assert_int_equal(lum_colour(0.0f).r, 214);
    assert_int_equal(lum_colour(-7.0f).r, 214);
    assert_int_equal(lum_colour(1.0f).b, 225);
    assert_int_equal(lum_colour(99.0f).b, 225);
    assert_int_equal(lum_colour(0.5f).g, 210);
}

static void steps_are_one_two_or_five(void **state)
{
    (void)state;
    assert_true(lum_nice_step(100.0f, 5) == 20.0f);
    assert_true(lum_nice_step(60.0f, 6) == 10.0f);
    assert_true(lum_nice_step(26.0f, 5) == 5.0f);
    assert_true(lum_nice_step(3.0f, 3) == 1.0f);
}

static void the_nearest_return_of_a_cell_wins(void **state)
{
    lum_raster *raster = make_raster();
    (void)state;
    add(raster, LUM_EYE_BLUE, 0.0f, -7.0f, 20.0f);
    add(raster, LUM_EYE_BLUE, 0.0f, -7.0f, 10.0f);
    add(raster, LUM_EYE_BLUE, 0.0f, -7.0f, 30.0f);
    const lum_panorama *blue = &raster->eye[LUM_EYE_BLUE];
    size_t filled = 0;
    for (size_t i = 0; i < CELLS; i++) {
        filled += blue->nearest[i] > 0.0f;
        assert_true(blue->nearest[i] <= 0.0f || blue->nearest[i] == 10.0f);
        assert_true(raster->eye[LUM_EYE_GREEN].nearest[i] == 0.0f);
    }
    assert_int_equal(filled, 1);
    free(raster);
}

static void angles_outside_of_the_calibration_are_left_out(void **state)
{
    lum_raster *raster = make_raster();
    (void)state;
    add(raster, LUM_EYE_BLUE, 31.0f, -7.0f, 20.0f);
    add(raster, LUM_EYE_BLUE, 0.0f, 90.0f, 20.0f);
    add(raster, UINT8_MAX, -1e30f, -1e30f, 1e30f);
    for (size_t i = 0; i < CELLS; i++) {
        assert_true(raster->eye[0].nearest[i] == 0.0f);
    }
    assert_true(raster->points == 3);
    free(raster);
}

static void ranges_have_shares(void **state)
{
    lum_raster *raster = make_raster();
    (void)state;
    assert_true(lum_raster_range(raster, 0.98) == 0.0f);
    for (int i = 0; i < 100; i++) {
        add(raster, LUM_EYE_BLUE, 0.0f, 0.0f, 0.55f + (float)i);
    }
    const float most = lum_raster_range(raster, 0.98);
    assert_true(most > 97.5f && most < 97.7f);
    free(raster);
}

static void left_is_drawn_on_the_left_and_up_at_the_top(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {30, 10, 140, 60};
    const lum_box top_left = {80, 10, 20, 30};
    const lum_box bottom_right = {120, 40, 50, 30};
    const lum_box bottom_left = {80, 40, 20, 30};
    const lum_depth depth = {1.0f, 100.0f};
    (void)state;
    add(raster, LUM_EYE_BLUE, 29.0f, 2.0f, 10.0f);
    add(raster, LUM_EYE_BLUE, -29.0f, -16.0f, 10.0f);
    for (float azimuth = 0.0f; azimuth < 20.0f; azimuth += 0.05f) {
        add(raster, LUM_EYE_BLUE, azimuth, 1.0f, 10.0f);
    }
    lum_draw_panorama(canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_true(count_painted(canvas, top_left) >= 10);
    assert_true(count_painted(canvas, bottom_right) >= 1);
    assert_int_equal(count_painted(canvas, bottom_left), 0);
    free(raster);
    lum_canvas_free(canvas);
}

static void sparse_lines_are_stretched_until_they_meet(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {30, 10, 140, 60};
    const lum_box inside = {70, 15, 90, 50};
    const lum_depth depth = {1.0f, 100.0f};
    (void)state;
    for (int line = 0; line < 8; line++) {
        for (float azimuth = -29.9f; azimuth < 30.0f; azimuth += 0.06f) {
            add(raster, LUM_EYE_BLUE, azimuth, -16.0f + 2.5f * (float)line,
                10.0f);
        }
    }
    lum_draw_panorama(canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_int_equal(count_painted(canvas, inside), 90 * 50);
    free(raster);
    lum_canvas_free(canvas);
}

/* Lines 2 degrees apart, points as wide as a pixel; holes of three pixels. */
static void holes_between_pixels_are_closed_and_larger_ones_stay(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {0, 0, 100, 50};
    const lum_box small = {20, 0, 20, 50};
    const lum_box large = {60, 0, 12, 50};
    const lum_depth depth = {1.0f, 100.0f};
    (void)state;
    for (int line = 0; line < 10; line++) {
        for (int x = 0; x < 100; x++) {
            if ((x < 24 || x > 25) && (x < 62 || x > 69)) {
                add(raster, LUM_EYE_BLUE, 29.7f - 0.6f * (float)x,
                    -16.0f + 2.0f * (float)line, 10.0f);
            }
        }
    }
    lum_draw_panorama(canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_int_equal(count_painted(canvas, small), 20 * 50);
    assert_in_range(count_painted(canvas, large), 3 * 50, 6 * 50);
    free(raster);
    lum_canvas_free(canvas);
}

static void pictures_of_nothing_and_of_one_point_can_be_drawn(void **state)
{
    const lum_box box = {30, 10, 140, 60};
    const lum_depth depth = {0.5f, 1.0f};
    (void)state;
    for (int points = 0; points < 2; points++) {
        lum_canvas *canvas = make_canvas();
        lum_raster *raster = make_raster();
        for (int i = 0; i < points; i++) {
            add(raster, LUM_EYE_BLUE, 0.0f, 0.0f, 1e5f);
        }
        lum_draw_panorama(canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
        lum_draw_ground(canvas, box, raster, depth);
        lum_draw_scale(canvas, box, depth);
        free(raster);
        lum_canvas_free(canvas);
    }
}

static void angles_stand_beside_a_range_image(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {60, 10, 120, 60};
    const lum_box left = {0, 0, 54, HEIGHT};
    const lum_box below = {54, 76, WIDTH - 54, HEIGHT - 76};
    const lum_box on_top = {0, 0, WIDTH, 8};
    const lum_depth depth = {1.0f, 100.0f};
    (void)state;
    lum_draw_panorama(canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_true(count_painted(canvas, left) > 50);
    assert_true(count_painted(canvas, below) > 50);
    assert_int_equal(count_painted(canvas, on_top), 0);
    assert_int_equal(count_painted(canvas, box), 0);
    free(raster);
    lum_canvas_free(canvas);
}

static int count_numbers(lum_depth depth)
{
    const lum_box bar = {10, 0, 20, HEIGHT};
    lum_canvas *canvas = make_canvas();
    int n = 0;
    lum_draw_scale(canvas, bar, depth);
    for (int y = 0; y < HEIGHT; y++) {
        n += is_colour(canvas, 30, y, lum_ink);
    }
    lum_canvas_free(canvas);
    return n;
}

static void a_short_scale_has_more_numbers_than_1_2_and_5(void **state)
{
    const lum_depth wide = {0.9f, 110.0f};
    const lum_depth narrow = {3.5f, 8.5f};
    const lum_depth narrowest = {8.1f, 16.2f};
    (void)state;
    assert_int_equal(count_numbers(wide), 7); /* 1 2 5 10 20 50 100 */
    assert_int_equal(count_numbers(narrow), 5);
    assert_int_equal(count_numbers(narrowest), 2);
}

static void the_scale_is_red_below_and_violet_above(void **state)
{
    const lum_box bar = {10, 0, 20, HEIGHT};
    const lum_depth depth = {1.0f, 100.0f};
    lum_canvas *canvas = make_canvas();
    (void)state;
    lum_draw_scale(canvas, bar, depth);
    assert_true(is_colour(canvas, 10, HEIGHT - 1, lum_colour(0.0f)));
    assert_true(is_colour(canvas, 29, 0, lum_colour(1.0f)));
    assert_true(is_black(canvas, 9, HEIGHT / 2));
    lum_canvas_free(canvas);
}

static bool is_green(lum_rgb c)
{
    return c.g > 90 && c.g > c.b + 20;
}

/* From the top down to where the panel begins again: points, and no ring. */
static int count_top_band(const lum_canvas *canvas, int x)
{
    int n = 0;
    int y = 0;
    while (y < HEIGHT && is_colour(canvas, x, y, lum_panel)) {
        y++;
    }
    for (; y < HEIGHT && !is_colour(canvas, x, y, lum_panel); y++, n++) {
        assert_true(is_green(lum_canvas_get(canvas, x, y)));
    }
    return n;
}

static void rings_stand_behind_the_points(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_depth depth = {1.0f, 100.0f};
    int ring = 0;
    (void)state;
    for (int i = -500; i <= 500; i++) { /* on the ring of 10 m */
        const float y = 0.01f * (float)i;
        const lum_sample sample = {
            .x = sqrtf(100.0f - y * y), .y = y, .range = 10.0f};
        const lum_line_samples line = {.samples = &sample, .count = 1};
        lum_raster_add(raster, &line);
    }
    lum_draw_ground(canvas, all, raster, depth);
    for (int x = WIDTH / 2 - 40; x < WIDTH / 2 - 30; x++) {
        assert_in_range(count_top_band(canvas, x), 2, 8);
    }
    for (int y = 0; y < HEIGHT; y++) {
        const lum_rgb c = lum_canvas_get(canvas, WIDTH / 2 - 35, y);
        ring += c.r > lum_panel.r && !is_green(c);
    }
    assert_in_range(ring, 3, 12); /* of 4, 6 and 8 m */
    free(raster);
    lum_canvas_free(canvas);
}

static void forward_is_up_in_the_view_from_above(void **state)
{
    lum_canvas *canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {0, 0, WIDTH, HEIGHT};
    const lum_box ahead = {WIDTH / 2 - 12, 10, 24, 40};
    const lum_depth depth = {1.0f, 100.0f};
    int coloured = 0;
    (void)state;
    for (float x = 5.0f; x < 10.0f; x += 0.01f) {
        add(raster, LUM_EYE_BLUE, 0.0f, 0.0f, x);
    }
    lum_draw_ground(canvas, box, raster, depth);
    coloured = count_painted(canvas, ahead);
    assert_true(coloured > 40);
    free(raster);
    lum_canvas_free(canvas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_lies_outside_of_the_canvas_does_nothing),
        cmocka_unit_test(pixels_and_boxes_have_exactly_their_colour),
        cmocka_unit_test(a_box_hides_the_pixels_below_it),
        cmocka_unit_test(a_circle_has_its_radius_and_stays_in_its_box),
        cmocka_unit_test(text_stands_where_it_was_asked_for),
        cmocka_unit_test(text_is_as_large_as_it_was_asked_for),
        cmocka_unit_test(each_character_is_drawn),
        cmocka_unit_test(upper_and_lower_case_and_digits_differ),
        cmocka_unit_test(threads_draw_the_same_at_the_same_time),
        cmocka_unit_test(text_is_smooth_and_nothing_but_grey),
        cmocka_unit_test(a_text_can_cover_what_is_behind_it),
        cmocka_unit_test(the_colour_scale_goes_from_red_to_violet),
        cmocka_unit_test(steps_are_one_two_or_five),
        cmocka_unit_test(the_nearest_return_of_a_cell_wins),
        cmocka_unit_test(angles_outside_of_the_calibration_are_left_out),
        cmocka_unit_test(ranges_have_shares),
        cmocka_unit_test(left_is_drawn_on_the_left_and_up_at_the_top),
        cmocka_unit_test(sparse_lines_are_stretched_until_they_meet),
        cmocka_unit_test(holes_between_pixels_are_closed_and_larger_ones_stay),
        cmocka_unit_test(pictures_of_nothing_and_of_one_point_can_be_drawn),
        cmocka_unit_test(angles_stand_beside_a_range_image),
        cmocka_unit_test(a_short_scale_has_more_numbers_than_1_2_and_5),
        cmocka_unit_test(the_scale_is_red_below_and_violet_above),
        cmocka_unit_test(rings_stand_behind_the_points),
        cmocka_unit_test(forward_is_up_in_the_view_from_above),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
