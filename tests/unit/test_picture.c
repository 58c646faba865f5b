#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "picture/picture_internal.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

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

/* Points of a test, and what draws them. */
typedef struct scene {
    lum_canvas *canvas;
    lum_dots dots;
    lum_scale scale;
} scene;

static scene make_scene(void)
{
    return (scene){.canvas = make_canvas(),
                   .dots = {.step = 1},
                   .scale = {LUM_PICTURE_RANGE, 1.0f, 100.0f}};
}

static lum_drawing drawing_of(const scene *s)
{
    return (lum_drawing){s->canvas, &s->dots, s->scale, 1.0f};
}

static void free_scene(scene *s)
{
    lum_canvas_free(s->canvas);
    lum_dots_free(&s->dots);
}

static void add(scene *s, float azimuth, float elevation, float range)
{
    const float radians = 3.14159265f / 180.0f;
    const float level = range * cosf(elevation * radians);
    const lum_dot dot = {.x = level * cosf(azimuth * radians),
                         .y = level * sinf(azimuth * radians),
                         .z = range * sinf(elevation * radians),
                         .range = range,
                         .value = range};
    assert_int_equal(lum_dots_add(&s->dots, &dot), 0);
}

static void draw_panorama(const scene *s, lum_box box)
{
    const lum_drawing d = drawing_of(s);
    const lum_image_view view = lum_panorama_view(&s->dots);
    lum_draw_panorama(&d, box, &view);
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

static float brightness(lum_rgb c)
{
    return 0.2126f * (float)c.r + 0.7152f * (float)c.g + 0.0722f * (float)c.b;
}

static void the_colour_scale_rises_in_brightness(void **state)
{
    float last = brightness(lum_colour(0.0f));
    (void)state;
    for (int i = 1; i <= 100; i++) {
        const float now = brightness(lum_colour((float)i / 100.0f));
        assert_true(now > last && now - last < 4.0f);
        last = now;
    }
    assert_int_equal(lum_colour(-7.0f).b, lum_colour(0.0f).b);
    assert_int_equal(lum_colour(NAN).b, lum_colour(0.0f).b);
    assert_int_equal(lum_colour(99.0f).r, 253);
    assert_int_equal(lum_colour(1.0f).g, 231);
    assert_int_equal(lum_colour(1.0f).b, 37);
}

static void labels_have_eight_colours(void **state)
{
    (void)state;
    for (int i = 0; i < 8; i++) {
        const lum_rgb one = lum_label_colour((float)i);
        const lum_rgb again = lum_label_colour((float)(i - 8));
        assert_memory_equal(&one, &again, sizeof one);
        for (int k = 0; k < i; k++) {
            const lum_rgb other = lum_label_colour((float)k);
            assert_memory_not_equal(&one, &other, sizeof one);
        }
    }
}

static void steps_are_one_two_or_five(void **state)
{
    (void)state;
    assert_true(lum_nice_step(100.0f, 5) == 20.0f);
    assert_true(lum_nice_step(60.0f, 6) == 10.0f);
    assert_true(lum_nice_step(26.0f, 5) == 5.0f);
    assert_true(lum_nice_step(3.0f, 3) == 1.0f);
}

static bool is_like(lum_rgb a, lum_rgb b)
{
    return abs(a.r - b.r) <= 1 && abs(a.g - b.g) <= 1 && abs(a.b - b.b) <= 1;
}

static void of_many_points_every_second_is_kept(void **state)
{
    lum_dots dots = {.step = 1};
    const lum_dot nowhere = {NAN, 0.0f, 0.0f, 1.0f, 1.0f};
    (void)state;
    assert_int_equal(lum_dots_add(&dots, &nowhere), 0);
    assert_true(dots.all == 1 && dots.count == 0);
    dots.all = 0;
    for (size_t i = 0; i < 2u * LUM_DOTS_MAX; i++) {
        const lum_dot dot = {(float)i, 0.0f, 0.0f, 1.0f, 1.0f};
        assert_int_equal(lum_dots_add(&dots, &dot), 0);
    }
    assert_true(dots.all == 2u * LUM_DOTS_MAX);
    assert_true(dots.step == 4 && dots.count == LUM_DOTS_MAX / 2u);
    for (size_t i = 0; i < dots.count; i++) {
        assert_true(dots.at[i].x == (float)(4u * i));
    }
    lum_dots_free(&dots);
}

static void points_are_brought_into_another_frame(void **state)
{
    const double at[3] = {1.0, 2.0, 3.0};
    const lum_pose pose = lum_pose_of_angles(at, 0.0, 0.0, 90.0);
    const lum_dot dot = {10.0f, 0.0f, 0.0f, 10.0f, 7.0f};
    lum_dots dots = {.step = 1};
    (void)state;
    assert_int_equal(lum_dots_add(&dots, &dot), 0);
    lum_dots_move(&dots, &pose);
    assert_float_equal(dots.at[0].x, 1.0f, 1e-5f);
    assert_float_equal(dots.at[0].y, 12.0f, 1e-5f);
    assert_float_equal(dots.at[0].z, 3.0f, 1e-5f);
    assert_float_equal(dots.at[0].value, 7.0f, 0.0f);
    lum_dots_free(&dots);
}

static void the_nearest_point_of_a_pixel_wins(void **state)
{
    scene s = make_scene();
    const lum_box box = {60, 0, 120, 20};
    (void)state;
    add(&s, 30.2f, -6.5f, 20.0f);
    add(&s, 30.2f, -6.5f, 10.0f);
    add(&s, 30.2f, -6.5f, 30.0f);
    draw_panorama(&s, box);
    assert_int_equal(count_painted(s.canvas, box), 1);
    assert_true(is_like(lum_canvas_get(s.canvas, 60 + 29, 9),
                        lum_scale_colour(&s.scale, 10.0f)));
    free_scene(&s);
}

static void scales_leave_out_two_of_a_hundred_at_each_end(void **state)
{
    scene s = make_scene();
    const lum_scale none = lum_scale_of(LUM_PICTURE_RANGE, &s.dots);
    (void)state;
    assert_true(none.low == 0.5f && none.high == 1.0f);
    for (int i = 100; i > 0; i--) {
        add(&s, 0.0f, 0.0f, (float)i);
    }
    const lum_scale range = lum_scale_of(LUM_PICTURE_RANGE, &s.dots);
    assert_true(range.low == 3.0f && range.high == 98.0f);
    const lum_rgb middle = lum_scale_colour(&range, sqrtf(3.0f * 98.0f));
    const lum_rgb half = lum_colour(0.5f);
    assert_true(is_like(middle, half));
    const lum_scale height = lum_scale_of(LUM_PICTURE_HEIGHT, &s.dots);
    assert_true(is_like(lum_scale_colour(&height, 50.5f), half));
    free_scene(&s);
}

static void the_view_is_the_usual_one_of_both_eyes(void **state)
{
    scene s = make_scene();
    (void)state;
    for (int i = -590; i < 590; i++) {
        add(&s, 0.1f * (float)i, -16.0f + (float)(i & 15), 10.0f);
    }
    add(&s, 170.0f, 80.0f, 10.0f);
    const lum_image_view v = lum_panorama_view(&s.dots);
    assert_true(v.left_deg == 60.0f && v.right_deg == -60.0f);
    assert_true(v.top_deg == 3.0f && v.bottom_deg == -17.0f);
    free_scene(&s);
}

static void a_sensor_that_looks_elsewhere_is_followed(void **state)
{
    scene s = make_scene();
    (void)state;
    for (int i = -300; i <= 300; i++) {
        add(&s, 180.0f + 0.1f * (float)i, 20.0f + (float)(i % 3), 10.0f);
    }
    const lum_image_view v = lum_panorama_view(&s.dots);
    assert_true(v.left_deg > 211.0f && v.left_deg < 213.0f);
    assert_true(v.right_deg > 147.0f && v.right_deg < 149.0f);
    assert_true(v.top_deg > 23.0f && v.top_deg < 25.0f);
    assert_true(v.bottom_deg > 15.0f && v.bottom_deg < 17.0f);
    free_scene(&s);
}

static void left_is_drawn_on_the_left_and_up_at_the_top(void **state)
{
    scene s = make_scene();
    const lum_box box = {30, 10, 140, 60};
    const lum_box top_left = {30, 10, 50, 30};
    const lum_box bottom_right = {120, 40, 50, 30};
    const lum_box bottom_left = {30, 40, 50, 30};
    (void)state;
    add(&s, 59.0f, 2.0f, 10.0f);
    add(&s, -59.0f, -16.0f, 10.0f);
    for (float azimuth = 30.0f; azimuth < 50.0f; azimuth += 0.05f) {
        add(&s, azimuth, 1.0f, 10.0f);
    }
    draw_panorama(&s, box);
    assert_true(count_painted(s.canvas, top_left) >= 10);
    assert_true(count_painted(s.canvas, bottom_right) >= 1);
    assert_int_equal(count_painted(s.canvas, bottom_left), 0);
    free_scene(&s);
}

static void sparse_lines_are_stretched_until_they_meet(void **state)
{
    scene s = make_scene();
    const lum_box box = {30, 10, 140, 60};
    const lum_box inside = {40, 20, 120, 45};
    (void)state;
    for (int line = 0; line < 8; line++) {
        for (float azimuth = -59.9f; azimuth < 60.0f; azimuth += 0.06f) {
            add(&s, azimuth, -16.0f + 2.5f * (float)line, 10.0f);
        }
    }
    draw_panorama(&s, box);
    assert_int_equal(count_painted(s.canvas, inside), 120 * 45);
    free_scene(&s);
}

/* Lines 2 degrees apart, points as wide as a pixel; holes of three pixels. */
static void holes_between_pixels_are_closed_and_larger_ones_stay(void **state)
{
    scene s = make_scene();
    const lum_box box = {0, 0, 100, 50};
    const lum_box small = {20, 0, 20, 50};
    const lum_box large = {60, 0, 12, 50};
    (void)state;
    for (int line = 0; line < 10; line++) {
        for (int x = 0; x < 100; x++) {
            if ((x < 24 || x > 25) && (x < 62 || x > 69)) {
                add(&s, 59.4f - 1.2f * (float)x, -16.0f + 2.0f * (float)line,
                    10.0f);
            }
        }
    }
    draw_panorama(&s, box);
    assert_int_equal(count_painted(s.canvas, small), 20 * 50);
    assert_in_range(count_painted(s.canvas, large), 3 * 50, 6 * 50);
    free_scene(&s);
}

static void pictures_of_nothing_and_of_one_point_can_be_drawn(void **state)
{
    const lum_box box = {30, 10, 140, 60};
    (void)state;
    for (int points = 0; points < 2; points++) {
        for (int colour = 0; colour <= (int)LUM_PICTURE_LABEL; colour++) {
            scene s = make_scene();
            for (int i = 0; i < points; i++) {
                add(&s, 0.0f, 0.0f, 1e5f);
            }
            s.scale = lum_scale_of((lum_picture_colour)colour, &s.dots);
            const lum_drawing d = drawing_of(&s);
            draw_panorama(&s, box);
            lum_draw_ground(&d, box);
            lum_draw_scale(&d, box);
            free_scene(&s);
        }
    }
}

static void angles_stand_beside_the_image(void **state)
{
    scene s = make_scene();
    const lum_box box = {60, 10, 120, 60};
    const lum_box left = {0, 0, 54, HEIGHT};
    const lum_box below = {54, 76, WIDTH - 54, HEIGHT - 76};
    const lum_box on_top = {0, 0, WIDTH, 8};
    (void)state;
    draw_panorama(&s, box);
    assert_true(count_painted(s.canvas, left) > 50);
    assert_true(count_painted(s.canvas, below) > 50);
    assert_int_equal(count_painted(s.canvas, on_top), 0);
    assert_int_equal(count_painted(s.canvas, box), 0);
    free_scene(&s);
}

/* Of a scale that is TALL pixels high. */
enum {
    TALL = 1000
};

static int count_numbers(lum_picture_colour colour, float low, float high)
{
    const lum_box bar = {10, 0, 20, TALL};
    lum_canvas *canvas = lum_canvas_new(WIDTH, TALL);
    const lum_dots dots = {.step = 1};
    const lum_drawing d = {canvas, &dots, {colour, low, high}, 1.0f};
    int n = 0;
    assert_non_null(canvas);
    lum_draw_scale(&d, bar);
    for (int y = 0; y < TALL; y++) {
        n += is_colour(canvas, 30, y, lum_ink);
    }
    lum_canvas_free(canvas);
    return n;
}

static void a_scale_has_its_ends_and_numbers_between(void **state)
{
    (void)state;
    assert_int_equal(count_numbers(LUM_PICTURE_RANGE, 0.9f, 110.0f),
                     9 - 2); /* 1 and 100 are too near to the ends */
    assert_int_equal(count_numbers(LUM_PICTURE_RANGE, 3.5f, 8.5f), 2 + 5);
    assert_int_equal(count_numbers(LUM_PICTURE_RANGE, 8.1f, 16.2f), 2 + 2);
    assert_int_equal(count_numbers(LUM_PICTURE_HEIGHT, -2.1f, 3.9f), 2 + 5);
    assert_int_equal(count_numbers(LUM_PICTURE_PULSE_WIDTH, 0.0f, 12.0f),
                     2 + 5);
}

static void the_scale_rises(void **state)
{
    const lum_box bar = {10, 0, 20, HEIGHT};
    scene s = make_scene();
    const lum_drawing d = drawing_of(&s);
    (void)state;
    lum_draw_scale(&d, bar);
    assert_true(is_colour(s.canvas, 10, HEIGHT - 1, lum_colour(0.0f)));
    assert_true(is_colour(s.canvas, 29, 0, lum_colour(1.0f)));
    assert_true(is_black(s.canvas, 9, HEIGHT / 2));
    free_scene(&s);
}

static void labels_have_a_legend_of_those_that_are_there(void **state)
{
    const lum_box bar = {10, 0, 20, HEIGHT};
    scene s = make_scene();
    (void)state;
    s.scale = lum_scale_of(LUM_PICTURE_LABEL, &s.dots);
    for (int i = 0; i < 6; i++) {
        const lum_dot dot = {1.0f, 0.0f, 0.0f, 1.0f, i % 2 == 0 ? 7.0f : 2.0f};
        assert_int_equal(lum_dots_add(&s.dots, &dot), 0);
    }
    const lum_drawing d = drawing_of(&s);
    lum_draw_scale(&d, bar);
    assert_true(is_colour(s.canvas, 15, 5, lum_label_colour(2.0f)));
    assert_true(is_colour(s.canvas, 15, 28 + 5, lum_label_colour(7.0f)));
    assert_true(is_black(s.canvas, 15, 2 * 28 + 5));
    free_scene(&s);
}

static bool is_point(const lum_canvas *canvas, int x, int y)
{
    const lum_rgb c = lum_canvas_get(canvas, x, y);
    return c.g > c.r + 40;
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
        assert_true(is_point(canvas, x, y));
    }
    return n;
}

static void rings_stand_behind_the_points(void **state)
{
    scene s = make_scene();
    int ring = 0;
    (void)state;
    for (int i = -500; i <= 500; i++) { /* on the ring of 10 m */
        add(&s, 0.06f * (float)i, 0.0f, 10.0f);
    }
    const lum_drawing d = drawing_of(&s);
    lum_draw_ground(&d, all);
    for (int x = WIDTH / 2 - 40; x < WIDTH / 2 - 30; x++) {
        assert_in_range(count_top_band(s.canvas, x), 2, 8);
    }
    for (int y = 0; y < HEIGHT; y++) {
        const lum_rgb c = lum_canvas_get(s.canvas, WIDTH / 2 - 35, y);
        ring += c.r > lum_panel.r && !is_point(s.canvas, WIDTH / 2 - 35, y);
    }
    assert_in_range(ring, 3, 12); /* of 4, 6 and 8 m */
    free_scene(&s);
}

static void forward_is_up_in_the_view_from_above(void **state)
{
    scene s = make_scene();
    const lum_box ahead = {WIDTH / 2 - 12, 10, 24, 40};
    (void)state;
    for (float x = 5.0f; x < 10.0f; x += 0.01f) {
        add(&s, 0.0f, 0.0f, x);
    }
    const lum_drawing d = drawing_of(&s);
    lum_draw_ground(&d, all);
    assert_true(count_painted(s.canvas, ahead) > 40);
    free_scene(&s);
}

static void from_above_one_sees_the_highest_point(void **state)
{
    scene s = make_scene();
    const lum_rgb roof = lum_scale_colour(&s.scale, 20.0f);
    int seen = 0;
    (void)state;
    for (int i = 0; i < 3; i++) {
        const lum_dot dot = {10.0f, 0.0f, i == 1 ? 3.0f : -2.0f, 10.0f,
                             i == 1 ? 20.0f : 10.0f};
        assert_int_equal(lum_dots_add(&s.dots, &dot), 0);
    }
    const lum_drawing d = drawing_of(&s);
    lum_draw_ground(&d, all);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        seen += is_colour(s.canvas, i % WIDTH, i / WIDTH, roof);
        assert_false(is_colour(s.canvas, i % WIDTH, i / WIDTH,
                               lum_scale_colour(&s.scale, 10.0f)));
    }
    assert_true(seen > 0);
    free_scene(&s);
}

/* --- The format --- */

static const char *refusal_of(const lum_picture_options *drawing)
{
    static lum_error error;
    const lum_writer_options o = {.struct_size = sizeof o,
                                  .format = LUM_FORMAT_PNG,
                                  .picture = lum_picture_format(),
                                  .drawing = drawing};
    lum_writer *writer = NULL;
    assert_int_equal(lum_writer_open("/dev/null", &o, &writer, &error), -1);
    assert_int_equal(errno, EINVAL);
    return error.text;
}

static void options_that_cannot_be_are_refused(void **state)
{
    lum_picture_options o = {.struct_size = 0};
    (void)state;
    assert_non_null(strstr(refusal_of(&o), "struct_size"));
    o = (lum_picture_options){.struct_size = sizeof o, .width = 639};
    assert_non_null(strstr(refusal_of(&o), "640 to 8000 pixels"));
    o = (lum_picture_options){.struct_size = sizeof o, .height = 8001};
    assert_non_null(strstr(refusal_of(&o), "640 to 8000 pixels"));
    o = (lum_picture_options){.struct_size = sizeof o,
                              .colour = (lum_picture_colour)4};
    assert_non_null(strstr(refusal_of(&o), "no such colours"));
    o.colour = LUM_PICTURE_LABEL;
    assert_non_null(strstr(refusal_of(&o), "need a column label"));
}

static void labels_are_a_column_of_ones_own(void **state)
{
    const lum_writer_extra extra[2] = {{"other", LUM_NUMBER_F64},
                                       {"label", LUM_NUMBER_U16}};
    const lum_picture_options drawing = {.struct_size = sizeof drawing,
                                         .colour = LUM_PICTURE_LABEL};
    const lum_writer_options o = {.struct_size = sizeof o,
                                  .format = LUM_FORMAT_PNG,
                                  .picture = lum_picture_format(),
                                  .drawing = &drawing,
                                  .extra = extra,
                                  .extra_count = 2};
    const double others[1] = {0.5};
    const uint16_t labels[1] = {7};
    const void *values[2] = {others, labels};
    const lum_sample sample = {.x = 1.0f, .range = 1.0f};
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = &sample,
                                   .count = 1,
                                   .extra = values};
    lum_writer *writer = NULL;
    (void)state;
    assert_int_equal(lum_writer_open("/dev/null", &o, &writer, NULL), 0);
    assert_int_equal(lum_writer_begin_frame(writer, 1, NULL), 0);
    assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
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
        cmocka_unit_test(the_colour_scale_rises_in_brightness),
        cmocka_unit_test(labels_have_eight_colours),
        cmocka_unit_test(steps_are_one_two_or_five),
        cmocka_unit_test(of_many_points_every_second_is_kept),
        cmocka_unit_test(points_are_brought_into_another_frame),
        cmocka_unit_test(the_nearest_point_of_a_pixel_wins),
        cmocka_unit_test(scales_leave_out_two_of_a_hundred_at_each_end),
        cmocka_unit_test(the_view_is_the_usual_one_of_both_eyes),
        cmocka_unit_test(a_sensor_that_looks_elsewhere_is_followed),
        cmocka_unit_test(left_is_drawn_on_the_left_and_up_at_the_top),
        cmocka_unit_test(sparse_lines_are_stretched_until_they_meet),
        cmocka_unit_test(holes_between_pixels_are_closed_and_larger_ones_stay),
        cmocka_unit_test(pictures_of_nothing_and_of_one_point_can_be_drawn),
        cmocka_unit_test(angles_stand_beside_the_image),
        cmocka_unit_test(a_scale_has_its_ends_and_numbers_between),
        cmocka_unit_test(the_scale_rises),
        cmocka_unit_test(labels_have_a_legend_of_those_that_are_there),
        cmocka_unit_test(rings_stand_behind_the_points),
        cmocka_unit_test(forward_is_up_in_the_view_from_above),
        cmocka_unit_test(from_above_one_sees_the_highest_point),
        cmocka_unit_test(options_that_cannot_be_are_refused),
        cmocka_unit_test(labels_are_a_column_of_ones_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
