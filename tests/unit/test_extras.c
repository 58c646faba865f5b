/* Columns of the caller's own in every format that has them, and what is
 * refused. */
#define _XOPEN_SOURCE 700

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/cloud/writer.h"

#include <errno.h>
#include <locale.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[] = "/tmp/lum-extras-XXXXXX";
static char path[64];

static int make_directory(void **state)
{
    (void)state;
    if (mkdtemp(directory) == NULL) {
        return -1;
    }
    snprintf(path, sizeof path, "%s/out", directory);
    return 0;
}

static int remove_directory(void **state)
{
    (void)state;
    return rmdir(directory);
}

static const lum_writer_extra all[] = {
    {"a", LUM_NUMBER_U8},  {"b", LUM_NUMBER_U16}, {"c", LUM_NUMBER_U32},
    {"d", LUM_NUMBER_I8},  {"e", LUM_NUMBER_I16}, {"f", LUM_NUMBER_I32},
    {"g", LUM_NUMBER_F32}, {"h", LUM_NUMBER_F64}, {"i", LUM_NUMBER_U64},
    {"j", LUM_NUMBER_I64}};

#define OF_ALL     8u  /* types that every format has */
#define BYTES_ALL  26u /* of those */
#define BYTES_MORE 42u

static const uint8_t a[] = {0, 255};
static const uint16_t b[] = {1, 65535};
static const uint32_t c[] = {2, UINT32_MAX};
static const int8_t d[] = {-128, 127};
static const int16_t e[] = {-32768, 32767};
static const int32_t f[] = {INT32_MIN, INT32_MAX};
static const float g[] = {0.1f, -1e30f};
static const double h[] = {0.1, -1e300};
static const uint64_t i64[] = {3, UINT64_MAX};
static const int64_t j[] = {INT64_MIN, INT64_MAX};
static const void *const values[] = {a, b, c, d, e, f, g, h, i64, j};

/* As every format has them in binary, little-endian. */
static const uint8_t packed[2][BYTES_MORE] = {
    {0,    1,    0,    2,    0,    0,    0,    0x80, 0x00, 0x80, 0x00,
     0x00, 0x00, 0x80, 0xcd, 0xcc, 0xcc, 0x3d, 0x9a, 0x99, 0x99, 0x99,
     0x99, 0x99, 0xb9, 0x3f, 3,    0,    0,    0,    0,    0,    0,
     0,    0,    0,    0,    0,    0,    0,    0,    0x80},
    {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0xff, 0x7f, 0xff,
     0xff, 0xff, 0x7f, 0xca, 0xf2, 0x49, 0xf1, 0x9c, 0x75, 0x00, 0x88,
     0x3c, 0xe4, 0x37, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
     0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f}};

static const lum_sample two[] = {{.x = 1.0f, .pixel = 7, .return_number = 1},
                                 {.x = 2.0f, .pixel = 8, .return_number = 1}};

static const lum_line_samples line = {.struct_size = sizeof line,
                                      .samples = two,
                                      .count = 2,
                                      .frame = 5,
                                      .timestamp_us = 1000,
                                      .extra = values};

static lum_writer_options options_of(lum_format format, size_t count)
{
    return (lum_writer_options){.struct_size = sizeof(lum_writer_options),
                                .format = format,
                                .extra = all,
                                .extra_count = count};
}

/* The file, a NUL behind it; removed. */
static char *write_line(const lum_writer_options *options,
                        const lum_line_samples *samples, size_t *size)
{
    lum_writer *writer = NULL;
    lum_error error = {""};
    struct stat status;
    assert_int_equal(lum_writer_open(path, options, &writer, &error), 0);
    assert_int_equal(lum_writer_add(writer, samples, &error), 0);
    assert_int_equal(lum_writer_close(writer, &error), 0);
    assert_string_equal(error.text, "");
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fstat(fileno(file), &status), 0);
    *size = (size_t)status.st_size;
    char *bytes = malloc(*size + 1u);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    bytes[*size] = '\0';
    fclose(file);
    assert_int_equal(unlink(path), 0);
    return bytes;
}

static char *write_with(const lum_writer_options *options, size_t *size)
{
    return write_line(options, &line, size);
}

static void csv_has_the_fewest_digits_that_are_exact(void **state)
{
    (void)state;
    lum_writer_options o = options_of(LUM_FORMAT_CSV, 10);
    size_t size;
    o.columns = "x,j,a,b,c,d,e,f,g,h,i";
    char *got = write_with(&o, &size);
    assert_string_equal(
        got, "x,j,a,b,c,d,e,f,g,h,i\n"
             "1.0000,-9223372036854775808,0,1,2,-128,-32768,-2147483648,0.1,"
             "0.1,3\n"
             "2.0000,9223372036854775807,255,65535,4294967295,127,32767,"
             "2147483647,-1e+30,-1e+300,18446744073709551615\n");
    free(got);
}

static void without_columns_they_stand_behind_those_of_the_format(void **state)
{
    (void)state;
    const lum_writer_options o = options_of(LUM_FORMAT_CSV, 1);
    size_t size;
    char *got = write_with(&o, &size);
    assert_string_equal(
        got, "x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,"
             "line,pixel,return_number,number_of_returns,edge,a\n"
             "1.0000,0.0000,0.0000,0.0000,0.00000,0.00000,0.000,1000,5,0,0,7,"
             "1,0,0,0\n"
             "2.0000,0.0000,0.0000,0.0000,0.00000,0.00000,0.000,1000,5,0,0,8,"
             "1,0,0,255\n");
    free(got);
}

/* A program may have set one, and files are the same. */
static void the_locale_changes_nothing(void **state)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE",
                                        "fr_FR.UTF-8"};
    bool found = false;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && !found; i++) {
        found = setlocale(LC_ALL, names[i]) != NULL;
    }
    if (!found) {
        print_message("no locale with a decimal comma is installed\n");
    }
    csv_has_the_fewest_digits_that_are_exact(state);
    assert_non_null(setlocale(LC_ALL, "C"));
}

/* As text and as numbers; text of the same values goes another way. */
static void values_that_are_the_same_are_written_in_every_row(void **state)
{
    (void)state;
    static const struct {
        lum_format format;
        const char *end; /* of both rows */
    } formats[] = {
        {LUM_FORMAT_CSV,
         "2,0.1,7\n2.0000,0.0000,0.0000,0.0000,0.00000,0.00000,0.000,1000,5,0,"
         "0,8,1,0,0,2,0.1,7\n"},
        {LUM_FORMAT_PLY,
         "2 0.1 7\n2.0000 0.0000 0.0000 0.000 0.0000 0.00000 0.00000 1000 5 0 "
         "0 8 1 0 0 2 0.1 7\n"}};
    static const lum_writer_extra extra[] = {
        {"a", LUM_NUMBER_U8}, {"h", LUM_NUMBER_F64}, {"u", LUM_NUMBER_U16}};
    static const uint8_t twos[] = {2, 2};
    static const double tenths[] = {0.1, 0.1};
    static const uint16_t mixed[2][2] = {{7, 7}, {7, 8}};
    for (size_t i = 0; i < 4u; i++) {
        const void *const own[] = {twos, tenths, mixed[i / 2u]};
        const lum_writer_options o = {.struct_size = sizeof o,
                                      .format = formats[i % 2u].format,
                                      .ascii = true,
                                      .extra = extra,
                                      .extra_count = 3};
        lum_line_samples of = line;
        char want[160];
        size_t size;
        of.extra = own;
        snprintf(want, sizeof want, "%s", formats[i % 2u].end);
        want[strlen(want) - 2u] = i < 2u ? '7' : '8';
        char *got = write_line(&o, &of, &size);
        assert_true(size > strlen(want));
        assert_string_equal(got + size - strlen(want), want);
        free(got);
    }
}

/* Where values of the i-th point stand behind what the format has itself. */
static void expect_rows(const char *file, size_t size, size_t own, size_t more)
{
    const size_t row = own + more;
    const char *rows = file + size - 2u * row;
    assert_true(size >= 2u * row);
    for (size_t i = 0; i < 2u; i++) {
        assert_memory_equal(rows + i * row + own, packed[i], more);
    }
}

static void binary_clouds_have_every_value(void **state)
{
    (void)state;
    static const struct {
        lum_format format;
        const char *header;
        size_t own;
    } formats[] = {{LUM_FORMAT_PLY,
                    "property uchar scalar_edge\n"
                    "property uchar scalar_a\nproperty uint16 scalar_b\n"
                    "property uint scalar_c\nproperty char scalar_d\n"
                    "property short scalar_e\nproperty int scalar_f\n"
                    "property float scalar_g\nproperty double scalar_h\n"
                    "end_header\n",
                    52},
                   {LUM_FORMAT_PCD, " edge a b c d e f g h\nSIZE ", 52}};
    for (size_t i = 0; i < 2u; i++) {
        const lum_writer_options o = options_of(formats[i].format, OF_ALL);
        size_t size;
        char *got = write_with(&o, &size);
        assert_non_null(strstr(got, formats[i].header));
        expect_rows(got, size, formats[i].own, BYTES_ALL);
        free(got);
    }
}

static void las_has_them_as_extra_bytes(void **state)
{
    (void)state;
    const lum_writer_options o = options_of(LUM_FORMAT_LAS, 10);
    static const uint8_t types[] = {1, 3, 5, 2, 4, 6, 9, 10, 7, 8};
    size_t size;
    char *got = write_with(&o, &size);
    const size_t row = 30u + 32u + BYTES_MORE;
    const char *own = got + size - 2u * row - 10u * 192u;
    assert_int_equal((uint8_t)got[105] | (uint8_t)got[106] << 8, row);
    assert_int_equal((uint8_t)got[96] | (uint8_t)got[97] << 8, size - 2u * row);
    for (size_t i = 0; i < 10u; i++) {
        assert_int_equal((uint8_t)own[i * 192u + 2u], types[i]);
        assert_string_equal(own + i * 192u + 4u, all[i].name);
    }
    expect_rows(got, size, 30u + 32u, BYTES_MORE);
    free(got);
}

static const char *find_bytes(const char *in, size_t size, const void *what,
                              size_t n)
{
    for (size_t i = 0; i + n <= size; i++) {
        if (memcmp(in + i, what, n) == 0) {
            return in + i;
        }
    }
    return NULL;
}

/* Behind the 24 bytes of a point; the name, offset and type of the last. */
static void messages_have_fields_of_them(void **state)
{
    (void)state;
    const lum_mcap_options mcap = {.struct_size = sizeof mcap,
                                   .is_plain = true};
    lum_writer_options o = options_of(LUM_FORMAT_MCAP, OF_ALL);
    static const uint8_t field[] = {2, 0,       0, 0, 'h', 0, 0,
                                    0, 24 + 18, 0, 0, 0,   8};
    size_t size;
    o.mcap = &mcap;
    char *got = write_with(&o, &size);
    const char *first = find_bytes(got, size, packed[0], BYTES_ALL);
    assert_non_null(find_bytes(got, size, field, sizeof field));
    assert_non_null(first);
    assert_memory_equal(first + 24u + BYTES_ALL, packed[1], BYTES_ALL);
    free(got);
}

static void refuse(lum_format format, const char *columns,
                   const lum_writer_extra *extra, size_t count,
                   const char *want)
{
    lum_error error = {""};
    errno = 0;
    assert_int_equal(
        lum_writer_check_extra(format, columns, extra, count, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, want));
}

static void what_cannot_be_is_refused_with_what_can(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",    "2nd",         "a b",
        "a,b", "h\xc3\xb6he", "a2345678901234567890123456789012"};
    const lum_writer_extra twice[] = {all[0], all[1], all[0]};
    lum_writer_extra one = all[0];
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        one.name = bad[i];
        refuse(LUM_FORMATS, NULL, &one, 1, "use 1 to 31 ASCII letters");
    }
    one.name = "range";
    refuse(LUM_FORMATS, NULL, &one, 1, "give yours another name");
    one.name = "intensity";
    refuse(LUM_FORMAT_CSV, NULL, &one, 1, "give yours another name");
    one.name = "classification";
    refuse(LUM_FORMAT_LAS, NULL, &one, 1, "give yours another name");
    one.name = "return_num";
    refuse(LUM_FORMAT_LAS, NULL, &one, 1, "give yours another name");
    assert_int_equal(
        lum_writer_check_extra(LUM_FORMAT_CSV, NULL, &one, 1, NULL), 0);
    one.name = "ring";
    refuse(LUM_FORMAT_MCAP, NULL, &one, 1, "give yours another name");
    refuse(LUM_FORMATS, NULL, twice, 3, "two columns have the name a");
    refuse(LUM_FORMAT_XYZ, NULL, all, 1, "csv, ply, pcd, las and mcap do");
    refuse(LUM_FORMAT_PLY, NULL, all, 9, "32-bit integers or float64");
    refuse(LUM_FORMAT_PCD, NULL, all, 10, "32-bit integers or float64");
    refuse(LUM_FORMAT_MCAP, NULL, all, 9, "32-bit integers or float64");
    refuse(LUM_FORMAT_CSV, "x,q", all, 2, "edge, time, a, b");
    refuse(LUM_FORMATS, NULL, all, 33, "at most 32");
}

static void a_preset_and_voxels_have_none(void **state)
{
    (void)state;
    lum_writer_options o = options_of(LUM_FORMAT_PLY, 1);
    lum_writer *writer = NULL;
    lum_error error = {""};
    o.preset = "kitti";
    assert_int_equal(lum_writer_open(path, &o, &writer, &error), -1);
    assert_non_null(strstr(error.text, "leave out extra, or the preset"));
    o.preset = NULL;
    o.voxels = true;
    assert_int_equal(lum_writer_open(path, &o, &writer, &error), -1);
    assert_non_null(strstr(error.text, "leave out extra, or the preset"));
}

static void a_line_without_values_is_refused(void **state)
{
    (void)state;
    const lum_writer_options o = options_of(LUM_FORMAT_CSV, 1);
    lum_line_samples bare = line;
    lum_writer *writer = NULL;
    lum_error error = {""};
    bare.extra = NULL;
    assert_int_equal(lum_writer_open(path, &o, &writer, &error), 0);
    assert_int_equal(lum_writer_add(writer, &bare, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "the line's extra is NULL"));
    lum_writer_abort(writer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv_has_the_fewest_digits_that_are_exact),
        cmocka_unit_test(without_columns_they_stand_behind_those_of_the_format),
        cmocka_unit_test(the_locale_changes_nothing),
        cmocka_unit_test(values_that_are_the_same_are_written_in_every_row),
        cmocka_unit_test(binary_clouds_have_every_value),
        cmocka_unit_test(las_has_them_as_extra_bytes),
        cmocka_unit_test(messages_have_fields_of_them),
        cmocka_unit_test(what_cannot_be_is_refused_with_what_can),
        cmocka_unit_test(a_preset_and_voxels_have_none),
        cmocka_unit_test(a_line_without_values_is_refused)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
