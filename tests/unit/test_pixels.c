#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/image.h"

#include <math.h>

static const lum_image_view ahead = {60.0f, -60.0f, 3.0f, -17.0f, 64, 1600};

static lum_image_scale scale_of(const lum_image_view *view)
{
    lum_image_scale scale;
    assert_int_equal(lum_image_scale_init(&scale, view), LUM_OK);
    return scale;
}

static uint32_t pixel_of(const lum_image_view *view, float x, float y, float z)
{
    const lum_image_scale scale = scale_of(view);
    uint32_t pixel = 0;
    lum_image_pixels(&scale, &x, &y, &z, 1, &pixel);
    return pixel;
}

static void each_bound_of_a_view_is_checked(void **state)
{
    static const lum_image_view wrong[] = {
        {360.5f, 10.0f, 3.0f, -17.0f, 64, 64},
        {-10.0f, -360.5f, 3.0f, -17.0f, 64, 64},
        {-60.0f, 60.0f, 3.0f, -17.0f, 64, 64},
        {200.0f, -200.0f, 3.0f, -17.0f, 64, 64},
        {60.0f, -60.0f, 90.5f, -17.0f, 64, 64},
        {60.0f, -60.0f, 3.0f, -90.5f, 64, 64},
        {60.0f, -60.0f, -17.0f, 3.0f, 64, 64},
        {60.0f, -60.0f, 3.0f, -17.0f, 0, 64},
        {60.0f, -60.0f, 3.0f, -17.0f, 64, 0},
        {60.0f, -60.0f, 3.0f, -17.0f, 65536, 65536},
        {NAN, -60.0f, 3.0f, -17.0f, 64, 64}};
    lum_image_scale scale = {.width = 7};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(lum_image_scale_init(&scale, &wrong[i]), LUM_E_VALUE);
        assert_int_equal(scale.width, 7);
    }
}

static void views_that_reach_around_are_computed_apart(void **state)
{
    static const lum_image_view around[] = {
        {95.0f, -60.0f, 3.0f, -17.0f, 64, 64},
        {60.0f, -95.0f, 3.0f, -17.0f, 64, 64},
        {60.0f, -60.0f, 50.0f, -17.0f, 64, 64},
        {60.0f, -60.0f, 3.0f, -50.0f, 64, 64}};
    (void)state;
    assert_true(scale_of(&ahead).is_before);
    for (size_t i = 0; i < sizeof around / sizeof around[0]; i++) {
        assert_false(scale_of(&around[i]).is_before);
    }
}

static void the_usual_view_is_that_of_the_eyes(void **state)
{
    lum_image_view v;
    (void)state;
    lum_image_view_default(&v, LUM_IMAGE_BLUE, 65);
    assert_true(v.left_deg == 0.0f && v.right_deg == -60.0f);
    assert_true(v.rows == 128 && v.columns == 800);
    lum_image_view_default(&v, LUM_IMAGE_GREEN, 0);
    assert_true(v.left_deg == 60.0f && v.right_deg == 0.0f);
    assert_true(v.rows == 64 && v.columns == 800);
    lum_image_view_default(&v, LUM_IMAGE_BOTH, UINT32_MAX);
    assert_true(v.left_deg == 60.0f && v.right_deg == -60.0f);
    assert_true(v.columns == 1600);
    assert_true((uint64_t)v.rows * v.columns <= LUM_IMAGE_PIXELS_MAX);
}

static void left_is_the_first_column_and_up_the_first_row(void **state)
{
    (void)state;
    assert_int_equal(pixel_of(&ahead, 1.0f, tanf(1.047f), 0.1f), 0);
    assert_int_equal(pixel_of(&ahead, 1.0f, -tanf(1.047f), -0.61f),
                     64 * 1600 - 1);
    assert_int_equal(pixel_of(&ahead, -1.0f, 0.0f, 0.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&ahead, 1.0f, 0.0f, 1.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&ahead, 1.0f, 0.0f, -1.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&ahead, NAN, 0.0f, 0.0f), LUM_IMAGE_NONE);
}

static void a_view_all_around_has_every_direction_once(void **state)
{
    const lum_image_view all = {180.0f, -180.0f, 90.0f, -90.0f, 180, 360};
    (void)state;
    assert_int_equal(pixel_of(&all, 1.0f, -1e-3f, 1e-3f), 89 * 360 + 180);
    assert_int_equal(pixel_of(&all, -1.0f, 1e-3f, 1e-3f), 89 * 360);
    assert_int_equal(pixel_of(&all, -1.0f, -0.02f, -0.02f), 91 * 360 + 358);
    assert_int_equal(pixel_of(&all, 0.0f, 0.0f, 1.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&all, NAN, 0.0f, 1.0f), LUM_IMAGE_NONE);
}

static void a_view_to_the_back_has_what_is_there(void **state)
{
    const lum_image_view back = {225.0f, 135.0f, 10.0f, -10.0f, 20, 90};
    const lum_image_view right = {-100.0f, -190.0f, 10.0f, -10.0f, 20, 90};
    (void)state;
    assert_int_equal(pixel_of(&back, -1.0f, -1e-4f, -1e-3f), 10 * 90 + 44);
    assert_int_equal(pixel_of(&back, 1.0f, 0.0f, 0.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&back, -1.0f, 0.0f, 1.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&right, -1.0f, 1e-3f, -1e-3f), 10 * 90 + 80);
    /* Half a pixel beyond both ends belongs to them, and no more. */
    assert_int_equal(pixel_of(&back, -1.0f, -1.0122f, 0.0f) % 90, 0);
    assert_int_equal(pixel_of(&back, -1.0f, 1.0122f, 0.0f) % 90, 89);
    assert_int_equal(pixel_of(&back, -1.0f, -1.05f, 0.0f), LUM_IMAGE_NONE);
    assert_int_equal(pixel_of(&back, -1.0f, 1.05f, 0.0f), LUM_IMAGE_NONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_bound_of_a_view_is_checked),
        cmocka_unit_test(views_that_reach_around_are_computed_apart),
        cmocka_unit_test(the_usual_view_is_that_of_the_eyes),
        cmocka_unit_test(left_is_the_first_column_and_up_the_first_row),
        cmocka_unit_test(a_view_all_around_has_every_direction_once),
        cmocka_unit_test(a_view_to_the_back_has_what_is_there)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
