#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "picture/picture_internal.h"

#include <stdlib.h>
#include <string.h>

enum {
    WIDTH = 200,
    HEIGHT = 100
};

static lum_canvas make_canvas(void)
{
    lum_canvas canvas = {WIDTH, HEIGHT, NULL};
    canvas.rgb = calloc(WIDTH * HEIGHT, sizeof *canvas.rgb);
    assert_non_null(canvas.rgb);
    return canvas;
}

static bool is_black(const lum_canvas *canvas, int x, int y)
{
    const lum_rgb c = canvas->rgb[y * canvas->width + x];
    return c.r == 0 && c.g == 0 && c.b == 0;
}

/* Pixels in a box that are neither the panel nor black. */
static int count_painted(const lum_canvas *canvas, lum_box box)
{
    int n = 0;
    for (int y = box.y; y < box.y + box.height; y++) {
        for (int x = box.x; x < box.x + box.width; x++) {
            const lum_rgb *c = &canvas->rgb[y * canvas->width + x];
            n += !is_black(canvas, x, y) &&
                 memcmp(c, &lum_panel, sizeof *c) != 0;
        }
    }
    return n;
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
    const lum_sample sample = {
        .x = range, .range = range, .azimuth = azimuth, .elevation = elevation};
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &sample, .count = 1, .eye = eye};
    lum_raster_add(raster, &line);
}

static void pixels_outside_of_the_canvas_do_nothing(void **state)
{
    lum_canvas canvas = make_canvas();
    const lum_box around = {-5, -5, 5, HEIGHT + 10};
    (void)state;
    lum_canvas_set(&canvas, -1, 0, lum_ink);
    lum_canvas_set(&canvas, 0, HEIGHT, lum_ink);
    lum_canvas_set(&canvas, WIDTH, 0, lum_ink);
    lum_canvas_fill(&canvas, around, lum_ink);
    lum_canvas_text(&canvas, -50, -50, 2, lum_ink, "OUT");
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_true(is_black(&canvas, i % WIDTH, i / WIDTH));
    }
    free(canvas.rgb);
}

static void letters_are_drawn_where_they_belong(void **state)
{
    lum_canvas canvas = make_canvas();
    (void)state;
    lum_canvas_text(&canvas, 10, 20, 1, lum_ink, "-1");
    assert_int_equal(lum_canvas_text_width("-1", 1), 12);
    for (int x = 10; x < 15; x++) {
        assert_false(is_black(&canvas, x, 23)); /* the stroke of the minus */
        assert_true(is_black(&canvas, x, 22));
    }
    assert_false(is_black(&canvas, 18, 20)); /* top of the one */
    assert_true(is_black(&canvas, 16, 20));
    free(canvas.rgb);
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
    assert_true(blue->nearest[LUM_PANORAMA_CELLS / 2][LUM_PANORAMA_CELLS / 2] ==
                10.0f);
    assert_true(raster->eye[LUM_EYE_GREEN]
                    .nearest[LUM_PANORAMA_CELLS / 2][LUM_PANORAMA_CELLS / 2] ==
                0.0f);
    free(raster);
}

static void angles_outside_of_the_calibration_are_left_out(void **state)
{
    lum_raster *raster = make_raster();
    (void)state;
    add(raster, LUM_EYE_BLUE, 31.0f, -7.0f, 20.0f);
    add(raster, LUM_EYE_BLUE, 0.0f, 90.0f, 20.0f);
    add(raster, UINT8_MAX, -1e30f, -1e30f, 1e30f);
    for (int i = 0; i < LUM_PANORAMA_CELLS * LUM_PANORAMA_CELLS; i++) {
        assert_true(raster->eye[0].nearest[i / LUM_PANORAMA_CELLS]
                                          [i % LUM_PANORAMA_CELLS] == 0.0f);
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
    lum_canvas canvas = make_canvas();
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
    lum_draw_panorama(&canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_true(count_painted(&canvas, top_left) >= 10);
    assert_true(count_painted(&canvas, bottom_right) >= 1);
    assert_int_equal(count_painted(&canvas, bottom_left), 0);
    free(raster);
    free(canvas.rgb);
}

static void sparse_lines_are_stretched_until_they_meet(void **state)
{
    lum_canvas canvas = make_canvas();
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
    lum_draw_panorama(&canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
    assert_int_equal(count_painted(&canvas, inside), 90 * 50);
    free(raster);
    free(canvas.rgb);
}

static void pictures_of_nothing_and_of_one_point_can_be_drawn(void **state)
{
    const lum_box box = {30, 10, 140, 60};
    const lum_depth depth = {0.5f, 1.0f};
    (void)state;
    for (int points = 0; points < 2; points++) {
        lum_canvas canvas = make_canvas();
        lum_raster *raster = make_raster();
        for (int i = 0; i < points; i++) {
            add(raster, LUM_EYE_BLUE, 0.0f, 0.0f, 1e5f);
        }
        lum_draw_panorama(&canvas, box, &raster->eye[LUM_EYE_BLUE], depth);
        lum_draw_ground(&canvas, box, raster, depth);
        lum_draw_scale(&canvas, box, depth);
        free(raster);
        free(canvas.rgb);
    }
}

static void forward_is_up_in_the_view_from_above(void **state)
{
    lum_canvas canvas = make_canvas();
    lum_raster *raster = make_raster();
    const lum_box box = {0, 0, WIDTH, HEIGHT};
    const lum_box ahead = {WIDTH / 2 - 12, 10, 24, 40};
    const lum_depth depth = {1.0f, 100.0f};
    int coloured = 0;
    (void)state;
    for (float x = 5.0f; x < 10.0f; x += 0.01f) {
        add(raster, LUM_EYE_BLUE, 0.0f, 0.0f, x);
    }
    lum_draw_ground(&canvas, box, raster, depth);
    coloured = count_painted(&canvas, ahead);
    assert_true(coloured > 40);
    free(raster);
    free(canvas.rgb);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_outside_of_the_canvas_do_nothing),
        cmocka_unit_test(letters_are_drawn_where_they_belong),
        cmocka_unit_test(the_colour_scale_goes_from_red_to_violet),
        cmocka_unit_test(steps_are_one_two_or_five),
        cmocka_unit_test(the_nearest_return_of_a_cell_wins),
        cmocka_unit_test(angles_outside_of_the_calibration_are_left_out),
        cmocka_unit_test(ranges_have_shares),
        cmocka_unit_test(left_is_drawn_on_the_left_and_up_at_the_top),
        cmocka_unit_test(sparse_lines_are_stretched_until_they_meet),
        cmocka_unit_test(pictures_of_nothing_and_of_one_point_can_be_drawn),
        cmocka_unit_test(forward_is_up_in_the_view_from_above),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
