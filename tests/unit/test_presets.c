/* The table of presets, and rows and points made by it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cloud/presets.h"
#include "cloud/ros_points.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const lum_preset *preset_of(const char *name)
{
    lum_error error = {""};
    const lum_preset *p = lum_preset_find(name, &error);
    assert_non_null(p);
    return p;
}

static void sizes_are_those_that_consumers_have(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        size_t bytes;
        size_t offsets[LUM_PRESET_FIELDS_MAX + 1u];
    } known[LUM_PRESETS] = {
        {"autoware", 32, {0, 4, 8, 12, 13, 14, 16, 20, 24, 28, 32}},
        {"lio-sam", 22, {0, 4, 8, 12, 16, 18, 22}},
        {"fast-lio", 22, {0, 4, 8, 12, 16, 20, 22}},
        {"kitti", 16, {0, 4, 8, 12, 16}},
        {"argoverse2", 18, {0, 4, 8, 12, 13, 14, 18}},
        {"pdal", 25, {0, 4, 8, 12, 14, 15, 16, 17, 25}}};
    for (unsigned i = 0; i < LUM_PRESETS; i++) {
        const lum_preset *p = preset_of(known[i].name);
        assert_int_equal(lum_preset_bytes(p), known[i].bytes);
        for (unsigned k = 0; k <= p->count; k++) {
            assert_int_equal(lum_preset_offset(p, k), known[i].offsets[k]);
        }
    }
    assert_int_equal(lum_preset_bytes(&lum_preset_of_messages), 24);
}

static void an_unknown_name_is_refused_with_the_list(void **state)
{
    (void)state;
    lum_error error = {""};
    errno = 0;
    assert_null(lum_preset_find("auto", &error));
    assert_int_equal(errno, EINVAL);
    assert_string_equal(error.text, "'auto' is not a preset; presets are "
                                    "autoware, lio-sam, fast-lio, kitti, "
                                    "argoverse2, pdal");
}

static void times_are_needed_by_those_that_have_them(void **state)
{
    (void)state;
    assert_true(lum_preset_has_times(preset_of("autoware")));
    assert_true(lum_preset_has_times(preset_of("lio-sam")));
    assert_true(lum_preset_has_times(preset_of("argoverse2")));
    assert_false(lum_preset_has_times(preset_of("kitti")));
    assert_false(lum_preset_has_times(preset_of("pdal")));
}

/* --- Rows --- */

static const char *text_of(const char *preset, const lum_line_samples *line)
{
    static char text[1024];
    lum_preset_line l = {preset_of(preset), line, ','};
    *lum_preset_put_text(text, &l, line->samples, line->count) = '\0';
    return text;
}

static lum_sample sample(float x, float y, float z, float width, uint16_t i,
                         uint16_t n)
{
    return (lum_sample){.x = x,
                        .y = y,
                        .z = z,
                        .pulse_width = width,
                        .return_number = i,
                        .number_of_returns = n};
}

static void values_are_in_the_units_of_each_consumer(void **state)
{
    (void)state;
    const float time = 0.0125f;
    const lum_sample s = sample(3, 4, 5, 5.1f, 1, 2);
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = &s,
                                   .count = 1,
                                   .timestamp_us = 2500000,
                                   .line = 7,
                                   .eye = 1,
                                   .times = &time};
    assert_string_equal(text_of("autoware", &line),
                        "3.0000,4.0000,5.0000,51,2,15,0.927295218,"
                        "0.785398163,7.0711,12500000\n");
    assert_string_equal(text_of("lio-sam", &line),
                        "3.0000,4.0000,5.0000,5.100,15,0.012500000\n");
    assert_string_equal(text_of("fast-lio", &line),
                        "3.0000,4.0000,5.0000,5.100,0.012500000,15\n");
    assert_string_equal(text_of("kitti", &line),
                        "3.0000,4.0000,5.0000,0.199999996\n");
    assert_string_equal(text_of("argoverse2", &line),
                        "3.0000,4.0000,5.0000,51,15,12500000\n");
    assert_string_equal(text_of("pdal", &line),
                        "3.0000,4.0000,5.0000,510,1,2,1,2.500000000\n");
}

static void numbers_that_do_not_fit_become_the_nearest(void **state)
{
    (void)state;
    const float time = 10.0f;
    const lum_sample s = sample(1, 0, 0, 700.0f, 300, 400);
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = &s,
                                   .count = 1,
                                   .timestamp_us = LUM_TIMESTAMP_NONE,
                                   .line = 40000,
                                   .times = &time};
    assert_string_equal(text_of("autoware", &line),
                        "1.0000,0.0000,0.0000,255,0,65535,0.000000000,"
                        "0.000000000,1.0000,4294967295\n");
    assert_string_equal(text_of("argoverse2", &line),
                        "1.0000,0.0000,0.0000,255,255,2147483647\n");
    assert_string_equal(text_of("kitti", &line),
                        "1.0000,0.0000,0.0000,1.000000000\n");
    assert_string_equal(text_of("pdal", &line),
                        "1.0000,0.0000,0.0000,65535,255,255,0,nan\n");
}

static void integers_of_a_missing_point_are_0(void **state)
{
    (void)state;
    const float time = -1.0f;
    const lum_sample s = sample(NAN, NAN, NAN, NAN, 0, 0);
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = &s,
                                   .count = 1,
                                   .timestamp_us = 0,
                                   .times = &time};
    unsigned char row[32];
    lum_preset_line l = {preset_of("autoware"), &line, ','};
    assert_ptr_equal(lum_preset_put_binary((char *)row, &l, &s, 1), row + 32);
    for (unsigned i = 12; i < 16; i++) {
        assert_int_equal(row[i], 0);
    }
    for (unsigned i = 28; i < 32; i++) {
        assert_int_equal(row[i], 0); /* a time before the frame */
    }
}

static unsigned return_type(uint16_t i, uint16_t n)
{
    const lum_sample s = sample(1, 0, 0, 1, i, n);
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &s, .count = 1};
    unsigned char row[32];
    lum_preset_line l = {preset_of("autoware"), &line, ','};
    (void)lum_preset_put_binary((char *)row, &l, &s, 1);
    return row[13];
}

static void return_types_are_nebulas(void **state)
{
    (void)state;
    assert_int_equal(return_type(1, 1), 6);
    assert_int_equal(return_type(1, 3), 2);
    assert_int_equal(return_type(2, 3), 7);
    assert_int_equal(return_type(3, 3), 1);
    assert_int_equal(return_type(3, 4), 0);
    assert_int_equal(return_type(0, 0), 0);
}

/* --- Points of messages --- */

static void points_are_in_order_of_time_and_blue_is_first(void **state)
{
    (void)state;
    const lum_preset *preset = preset_of("autoware");
    static const float green_times[] = {0.2f, 0.4f};
    static const float blue_times[] = {0.1f, 0.2f, 0.3f};
    /* x, of a point: tenths of a second of blue, plus 10 of green */
    const lum_sample greens[] = {sample(12, 0, 0, 1, 1, 1),
                                 sample(14, 0, 0, 1, 1, 1)};
    const lum_sample blues[] = {sample(1, 0, 0, 1, 1, 1),
                                sample(2, 0, 0, 1, 1, 1),
                                sample(3, 0, 0, 1, 1, 1)};
    const lum_line_samples green = {.struct_size = sizeof green,
                                    .samples = greens,
                                    .count = 2,
                                    .eye = 1,
                                    .times = green_times};
    const lum_line_samples blue = {.struct_size = sizeof blue,
                                   .samples = blues,
                                   .count = 3,
                                   .times = blue_times};
    static const unsigned char order[] = {1, 2, 12, 3, 14};
    lum_ros_points points = {.preset = preset};
    unsigned char rows[5][32];
    for (unsigned again = 0; again < 2u; again++) {
        float first = 0.0f;
        assert_int_equal(lum_ros_points_add(&points, &green, 9), 0);
        assert_int_equal(lum_ros_points_add(&points, &blue, 9), 0);
        assert_int_equal(lum_ros_points_count(&points), 5);
        assert_int_equal(lum_ros_points_sort(&points, &first), 0);
        assert_true(first == blue_times[0]);
        lum_ros_points_take(&points, first, rows[0]);
        assert_int_equal(lum_ros_points_count(&points), 0);
        for (unsigned i = 0; i < 5u; i++) {
            const lum_sample s = sample(order[i], 0, 0, 1, 1, 1);
            const lum_line_samples line = {
                .struct_size = sizeof line, .samples = &s, .count = 1};
            unsigned char row[32];
            lum_preset_line l = {preset, &line, ','};
            (void)lum_preset_put_binary((char *)row, &l, &s, 1);
            assert_memory_equal(rows[i], row, 4);
        }
        const uint32_t ns = rows[4][28] | (uint32_t)rows[4][29] << 8 |
                            (uint32_t)rows[4][30] << 16 |
                            (uint32_t)rows[4][31] << 24;
        assert_in_range(ns, 299999900, 300000100);
    }
    lum_ros_points_free(&points);
}

static void a_line_without_times_has_that_of_its_begin(void **state)
{
    (void)state;
    const lum_sample s = sample(1, 0, 0, 1, 1, 1);
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &s, .count = 1};
    lum_ros_points points = {.preset = preset_of("fast-lio")};
    float first = 1.0f;
    assert_int_equal(lum_ros_points_sort(&points, &first), 0);
    assert_true(first == 0.0f);
    assert_int_equal(lum_ros_points_add(&points, &line, 0.5f), 0);
    assert_int_equal(lum_ros_points_sort(&points, &first), 0);
    assert_true(first == 0.5f);
    lum_ros_points_free(&points);
}

static void a_message_has_room_for_this_many(void **state)
{
    (void)state;
    const lum_ros_points points = {.preset = preset_of("autoware")};
    assert_int_equal(lum_ros_points_bytes(&points), 32);
    assert_int_equal(lum_ros_points_max(&points), UINT32_MAX / 2u / 32u);
}

/* --- The writer --- */

static int open_with(lum_format format, const char *preset, const char *columns,
                     lum_error *error)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .preset = preset,
                                        .columns = columns};
    lum_writer *writer = NULL;
    errno = 0;
    const int result = lum_writer_rehearse(&options, &writer, error);
    lum_writer_abort(writer);
    return result;
}

static void a_writer_refuses_what_does_not_go_together(void **state)
{
    (void)state;
    lum_error error = {""};
    assert_int_equal(open_with(LUM_FORMAT_PCD, "kitti", NULL, &error), 0);
    assert_int_equal(open_with(LUM_FORMAT_MCAP, "kitti", NULL, &error), 0);
    assert_int_equal(open_with(LUM_FORMAT_PCD, "none", NULL, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "'none' is not a preset"));
    assert_int_equal(open_with(LUM_FORMAT_LAS, "kitti", NULL, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "presets need CSV"));
    assert_int_equal(open_with(LUM_FORMAT_PCD, "kitti", "x,y", &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "exclude each other"));
}

static void a_line_without_times_is_refused_where_files_need_them(void **state)
{
    (void)state;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_CSV,
                                        .preset = "lio-sam"};
    const lum_sample s = sample(1, 0, 0, 1, 1, 1);
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &s, .count = 1};
    lum_error error = {""};
    lum_writer *writer = NULL;
    assert_int_equal(lum_writer_rehearse(&options, &writer, &error), 0);
    assert_int_equal(lum_writer_add(writer, &line, &error), -1);
    assert_non_null(strstr(error.text, "a line without times"));
    lum_writer_abort(writer);
}

static void voxels_have_columns_of_their_own(void **state)
{
    (void)state;
    static const lum_writer_options wrong[] = {
        {.format = LUM_FORMAT_PCD, .preset = "kitti"},
        {.format = LUM_FORMAT_PCD, .columns = "x,y"},
        {.format = LUM_FORMAT_PCD, .organized = true},
        {.format = LUM_FORMAT_XYZ}};
    const lum_sample s = sample(1, 0, 0, 1, 1, 1);
    const lum_line_samples line = {
        .struct_size = sizeof line, .samples = &s, .count = 1};
    lum_writer_options options = wrong[0];
    lum_error error = {""};
    lum_writer *writer = NULL;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        options = wrong[i];
        options.struct_size = sizeof options;
        options.voxels = true;
        assert_int_equal(lum_writer_rehearse(&options, &writer, &error), -1);
        assert_int_equal(errno, EINVAL);
        assert_non_null(strstr(error.text, "voxels"));
        assert_null(writer);
    }
    options.format = LUM_FORMAT_LAS;
    assert_int_equal(lum_writer_rehearse(&options, &writer, &error), 0);
    assert_int_equal(lum_writer_add(writer, &line, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "lack counts or times_ns"));
    lum_writer_abort(writer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_those_that_consumers_have),
        cmocka_unit_test(an_unknown_name_is_refused_with_the_list),
        cmocka_unit_test(times_are_needed_by_those_that_have_them),
        cmocka_unit_test(values_are_in_the_units_of_each_consumer),
        cmocka_unit_test(numbers_that_do_not_fit_become_the_nearest),
        cmocka_unit_test(integers_of_a_missing_point_are_0),
        cmocka_unit_test(return_types_are_nebulas),
        cmocka_unit_test(points_are_in_order_of_time_and_blue_is_first),
        cmocka_unit_test(a_line_without_times_has_that_of_its_begin),
        cmocka_unit_test(a_message_has_room_for_this_many),
        cmocka_unit_test(a_writer_refuses_what_does_not_go_together),
        cmocka_unit_test(a_line_without_times_is_refused_where_files_need_them),
        cmocka_unit_test(voxels_have_columns_of_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
