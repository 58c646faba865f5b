#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cloud/part.h"
#include "lum/picture/picture.h"
#include "lum/version.h"
#include "points/columns.h"

#include <errno.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[] = "/tmp/lum-writer-XXXXXX";
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

static bool exists(void)
{
    struct stat status;
    return lstat(path, &status) == 0;
}

/* How many files begin with the output's name: itself, or what becomes it. */
static size_t count_files(void)
{
    size_t n = 0;
    glob_t found;
    char pattern[96];
    snprintf(pattern, sizeof pattern, "%s*", path);
    if (glob(pattern, 0, NULL, &found) == 0) {
        n = found.gl_pathc;
        globfree(&found);
    }
    return n;
}

/* The whole output, a NUL behind it; removes the file. */
static char *take_file(size_t *size)
{
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    *size = (size_t)status.st_size;
    char *bytes = malloc(*size + 1u);
    FILE *file = fopen(path, "r");
    assert_non_null(bytes);
    assert_non_null(file);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    bytes[*size] = '\0';
    fclose(file);
    assert_int_equal(unlink(path), 0);
    return bytes;
}

static const lum_sample two[] = {
    {.x = 1.5f,
     .y = -2.25f,
     .z = -0.00001f,
     .range = 12.34567f,
     .azimuth = -29.99268f,
     .elevation = 2.5f,
     .pulse_width = 4.797f,
     .pixel = 7,
     .return_number = 1,
     .number_of_returns = 2,
     .edge = 1},
    {.x = -100.0f,
     .y = 1000.0f,
     .z = 3.0f,
     .range = 1004.0f,
     .azimuth = -29.99268f,
     .elevation = 2.5f,
     .pulse_width = 700.0f,
     .pixel = 7,
     .return_number = 20,
     .number_of_returns = 21,
     .edge = 0},
};

static const lum_line_samples line = {.struct_size = sizeof line,
                                      .samples = two,
                                      .count = 2,
                                      .frame = -3,
                                      .timestamp_us = 1234567,
                                      .line = 639,
                                      .eye = LUM_EYE_GREEN};

static lum_writer *open_writer(lum_format format, bool ascii, bool utc)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .ascii = ascii,
                                        .utc = utc,
                                        .picture = lum_picture_format()};
    lum_writer *writer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), 0);
    assert_string_equal(error.text, "");
    return writer;
}

static char *write_lines(lum_format format, bool ascii, size_t lines,
                         size_t *size)
{
    lum_writer *writer = open_writer(format, ascii, false);
    for (size_t i = 0; i < lines; i++) {
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    }
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    return take_file(size);
}

static void expect_text(lum_format format, bool ascii, const char *want)
{
    size_t size;
    char *got = write_lines(format, ascii, 1, &size);
    assert_string_equal(got, want);
    free(got);
}

static char *write_comment(lum_format format, const char *comment,
                           bool is_ascii, size_t *size)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .ascii = is_ascii,
                                        .comment = comment};
    lum_writer *writer = NULL;
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    for (int i = 0; i < 5000; i++) {
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
    }
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    return take_file(size);
}

static void expect_comment(lum_format format, bool is_ascii, const char *lines)
{
    size_t size;
    char text[] = "# one\na: 1\n  b: 2";
    const size_t added = strlen(lines);
    char *got = write_comment(format, text, is_ascii, &size);
    char *at = strstr(got, lines);
    assert_non_null(at);
    memmove(at, at + added, size - added - (size_t)(at - got));
    size_t bare_size;
    char *bare = write_lines(format, is_ascii, 5000, &bare_size);
    assert_int_equal(size, bare_size + added);
    assert_memory_equal(got, bare, bare_size);
    free(got);
    free(bare);
}

static void comments_stand_where_a_format_has_them(void **state)
{
    (void)state;
    for (int is_ascii = 0; is_ascii < 2; is_ascii++) {
        expect_comment(LUM_FORMAT_PLY, is_ascii != 0,
                       "comment # one\ncomment a: 1\ncomment   b: 2\n");
        expect_comment(LUM_FORMAT_PCD, is_ascii != 0,
                       "# # one\n# a: 1\n#   b: 2\n");
    }
    expect_comment(LUM_FORMAT_CSV, false, "# # one\n# a: 1\n#   b: 2\n");
    expect_comment(LUM_FORMAT_XYZ, false, "# # one\n# a: 1\n#   b: 2\n");
}

static void the_longest_comment_is_written(void **state)
{
    static char text[LUM_WRITER_COMMENT_BYTES_MAX + 2u];
    size_t size;
    (void)state;
    for (size_t i = 0; i < LUM_WRITER_COMMENT_BYTES_MAX; i++) {
        text[i] = i % 2u != 0 ? '\n' : 'x'; /* as many lines as there can be */
    }
    for (int f = 0; f < LUM_FORMATS; f++) {
        if (f != LUM_FORMAT_PNG) { /* it needs more than the writer's options */
            free(write_comment((lum_format)f, text, false, &size));
            assert_true(size > LUM_WRITER_COMMENT_BYTES_MAX);
        }
    }
    text[LUM_WRITER_COMMENT_BYTES_MAX] = 'x';
    lum_writer *writer = NULL;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .comment = text};
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), -1);
    assert_int_equal(errno, EINVAL);
}

static void what_is_no_comment_is_refused(void **state)
{
    static char longer[LUM_WRITER_COMMENT_LINE_MAX + 2u];
    static const char *const wrong[] = {"a\rend_header", "a\n\nb",   "\n",
                                        "t\tab",         "\xc3\xa4", longer};
    (void)state;
    memset(longer, 'x', sizeof longer - 1u);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        lum_writer *writer = NULL;
        lum_error error = {""};
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .comment = wrong[i]};
        assert_int_equal(lum_writer_open(path, &options, &writer, &error), -1);
        assert_int_equal(errno, EINVAL);
        assert_non_null(strstr(error.text, "printable"));
        assert_int_equal(count_files(), 0);
    }
}

#define CSV_HEADER                                                             \
    "x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,line,"      \
    "pixel,return_number,number_of_returns,edge\n"

static void csv_rows_have_all_columns(void **state)
{
    (void)state;
    expect_text(LUM_FORMAT_CSV, false,
                CSV_HEADER "1.5000,-2.2500,0.0000,12.3457,-29.99268,2.50000,"
                           "4.797,1234567,-3,1,639,7,1,2,1\n"
                           "-100.0000,1000.0000,3.0000,1004.0000,-29.99268,"
                           "2.50000,700.000,1234567,-3,1,639,7,20,21,0\n");
}

static void xyz_rows_are_bare(void **state)
{
    (void)state;
    expect_text(LUM_FORMAT_XYZ, false,
                "1.5000 -2.2500 0.0000\n-100.0000 1000.0000 3.0000\n");
}

#define PLY_PROPERTIES                                                         \
    "property float x\nproperty float y\nproperty float z\n"                   \
    "property float intensity\nproperty float scalar_range\n"                  \
    "property float scalar_azimuth\nproperty float scalar_elevation\n"         \
    "property double scalar_timestamp\nproperty int scalar_frame\n"            \
    "property uchar scalar_eye\nproperty int scalar_line\n"                    \
    "property uint16 scalar_pixel\nproperty uint16 scalar_return_number\n"     \
    "property uint16 scalar_number_of_returns\n"                               \
    "property uchar scalar_edge\nend_header\n"

#define ASCII_ROWS                                                             \
    "1.5000 -2.2500 0.0000 4.797 12.3457 -29.99268 2.50000 1234567 -3 1 639 "  \
    "7 1 2 1\n"                                                                \
    "-100.0000 1000.0000 3.0000 700.000 1004.0000 -29.99268 2.50000 1234567 "  \
    "-3 1 639 7 20 21 0\n"

static void ply_in_ascii_is_as_written_here(void **state)
{
    (void)state;
    expect_text(LUM_FORMAT_PLY, true,
                "ply\nformat ascii 1.0\ncomment lumsdk " LUM_VERSION "\n"
                "comment metres, degrees; intensity is the pulse width in ns; "
                "timestamp in us of the sensor's clock\n"
                "comment ...................\n"
                "element vertex 2\n" PLY_PROPERTIES ASCII_ROWS);
}

#define PCD_NAMES                                                              \
    "x y z intensity range azimuth elevation timestamp frame eye line pixel "  \
    "return_number number_of_returns edge\n"

static void pcd_in_ascii_is_as_written_here(void **state)
{
    (void)state;
    expect_text(LUM_FORMAT_PCD, true,
                "# .PCD v0.7 - Point Cloud Data file format\n"
                "# lumsdk " LUM_VERSION "; metres, degrees; intensity is the "
                "pulse width in ns; timestamp in us of the sensor's clock\n"
                "# ......................................\n"
                "VERSION 0.7\nFIELDS " PCD_NAMES
                "SIZE 4 4 4 4 4 4 4 8 4 1 4 2 2 2 1\n"
                "TYPE F F F F F F F F I U U U U U U\n"
                "COUNT 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n"
                "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
                "POINTS 2\nDATA ascii\n" ASCII_ROWS);
}

static uint64_t get(const char *bytes, size_t at, size_t n)
{
    uint64_t v = 0;
    for (size_t i = n; i-- > 0;) {
        v = v << 8 | (uint8_t)bytes[at + i];
    }
    return v;
}

static double get_float(const char *bytes, size_t at)
{
    const uint32_t bits = (uint32_t)get(bytes, at, 4);
    float v;
    memcpy(&v, &bits, sizeof v);
    return (double)v;
}

static double get_double(const char *bytes, size_t at)
{
    const uint64_t bits = get(bytes, at, 8);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* A row of PLY and PCD, all columns. */
static void expect_row(const char *row, const lum_sample *s)
{
    const float floats[] = {s->x,     s->y,       s->z,        s->pulse_width,
                            s->range, s->azimuth, s->elevation};
    for (size_t i = 0; i < 7; i++) {
        assert_true(get_float(row, 4u * i) == (double)floats[i]);
    }
    assert_true(get_double(row, 28) == 1234567.0);
    assert_int_equal(get(row, 36, 4), UINT32_MAX - 2u);
    assert_int_equal(get(row, 40, 1), 1);
    assert_int_equal(get(row, 41, 4), 639);
    assert_int_equal(get(row, 45, 2), s->pixel);
    assert_int_equal(get(row, 47, 2), s->return_number);
    assert_int_equal(get(row, 49, 2), s->number_of_returns);
    assert_int_equal(get(row, 51, 1), s->edge);
}

static void expect_binary(lum_format format, const char *header_end,
                          const char *count)
{
    size_t size;
    char *bytes = write_lines(format, false, 1, &size);
    const char *rows = strstr(bytes, header_end);
    assert_non_null(rows);
    assert_non_null(strstr(bytes, count));
    rows += strlen(header_end);
    assert_int_equal(size - (size_t)(rows - bytes), 2 * 52);
    expect_row(rows, &two[0]);
    expect_row(rows + 52, &two[1]);
    free(bytes);
}

static void ply_in_binary_holds_every_value(void **state)
{
    (void)state;
    expect_binary(LUM_FORMAT_PLY, "end_header\n", "element vertex 2\n");
}

static void pcd_in_binary_holds_every_value(void **state)
{
    (void)state;
    expect_binary(LUM_FORMAT_PCD, "DATA binary\n", "POINTS 2\n");
}

static void a_longer_count_leaves_the_header_as_long(void **state)
{
    size_t few;
    size_t many;
    (void)state;
    free(write_lines(LUM_FORMAT_PLY, false, 1, &few));
    char *bytes = write_lines(LUM_FORMAT_PLY, false, 5000, &many);
    assert_int_equal(many - few, 4999 * 2 * 52);
    assert_non_null(strstr(bytes, "comment ...............\n"
                                  "element vertex 10000\n"));
    free(bytes);
}

#define LAS_POINT 62u

static void las_header_tells_bounds_and_counts(void **state)
{
    size_t size;
    (void)state;
    char *b = write_lines(LUM_FORMAT_LAS, false, 1, &size);
    const size_t points = (size_t)get(b, 96, 4);
    assert_memory_equal(b, "LASF", 4);
    assert_int_equal(get(b, 6, 2), 0x10);
    assert_int_equal(get(b, 24, 2), 0x0401);
    assert_int_equal(get(b, 94, 2), 375);
    assert_int_equal(get(b, 104, 1), 6);
    assert_int_equal(get(b, 105, 2), LAS_POINT);
    assert_int_equal(size, points + 2 * LAS_POINT);
    assert_true(get_double(b, 131) == (double)0.0001);
    assert_true(fabs(get_double(b, 179) - 1.5) < 1e-9);    /* max x */
    assert_true(fabs(get_double(b, 187) + 100.0) < 1e-9);  /* min x */
    assert_true(fabs(get_double(b, 195) - 1000.0) < 1e-9); /* max y */
    assert_true(fabs(get_double(b, 203) + 2.25) < 1e-9);   /* min y */
    assert_true(fabs(get_double(b, 211) - 3.0) < 1e-9);    /* max z */
    assert_true(fabs(get_double(b, 219)) < 1e-9);          /* min z */
    assert_int_equal(get(b, 247, 8), 2);
    assert_int_equal(get(b, 255, 8), 1);       /* first returns */
    assert_int_equal(get(b, 255 + 112, 8), 1); /* fifteenth and later */
    free(b);
}

static void las_points_hold_every_value(void **state)
{
    size_t size;
    (void)state;
    char *b = write_lines(LUM_FORMAT_LAS, false, 1, &size);
    const char *p = b + get(b, 96, 4);
    assert_int_equal(get(p, 0, 4), 15000);
    assert_int_equal((int32_t)get(p, 4, 4), -22500);
    assert_int_equal(get(p, 8, 4), 0);
    assert_int_equal(get(p, 12, 2), 480); /* 4.797 ns */
    assert_int_equal(get(p, 14, 1), 0x21);
    assert_int_equal(get(p, 15, 1), 0x10); /* green */
    assert_int_equal((int16_t)get(p, 18, 2), -4999);
    assert_true(fabs(get_double(p, 22) - 1.234567) < 1e-12);
    assert_true(get_float(p, 30) == (double)two[0].range);
    assert_true(get_float(p, 42) == (double)two[0].pulse_width);
    assert_int_equal((int32_t)get(p, 46, 4), -3);
    assert_int_equal(get(p, 50, 4), 639);
    assert_int_equal(get(p, 54, 2), 7);
    assert_int_equal(get(p, 60, 2), 0x0101);
    p += LAS_POINT;
    assert_int_equal(get(p, 12, 2), 65535); /* 700 ns is too wide */
    assert_int_equal(get(p, 14, 1), 0xff);  /* 20 of 21, clipped */
    assert_int_equal(get(p, 56, 2), 20);
    assert_int_equal(get(p, 58, 2), 21);
    assert_int_equal(get(p, 60, 2), 0x0001);
    free(b);
}

static void las_has_a_record_for_the_comment(void **state)
{
    static const char text[] = "# one\na: 1\n";
    enum {
        HEAD = 54
    };
    size_t size;
    size_t bare_size;
    (void)state;
    char *bare = write_lines(LUM_FORMAT_LAS, false, 5000, &bare_size);
    char *b = write_comment(LUM_FORMAT_LAS, text, false, &size);
    const size_t points = (size_t)get(b, 96, 4);
    const size_t bare_points = (size_t)get(bare, 96, 4);
    assert_int_equal(get(bare, 100, 4), 2);
    assert_int_equal(get(b, 100, 4), 3);
    assert_int_equal(points, bare_points + HEAD + sizeof text - 1u);
    const char *record = b + bare_points;
    assert_string_equal(record + 2, "lumsdk");
    assert_int_equal(get(record, 18, 2), 1);
    assert_int_equal(get(record, 20, 2), sizeof text - 1u);
    assert_memory_equal(record + HEAD, text, sizeof text - 1u);
    assert_memory_equal(b + points, bare + bare_points, size - points);
    free(b);
    free(bare);
}

static void las_in_utc_has_adjusted_gps_time(void **state)
{
    size_t size;
    (void)state;
    lum_line_samples at = line;
    at.timestamp_us = INT64_C(1700000000250000); /* 2023-11-14 22:13:20.25 */
    lum_writer *writer = open_writer(LUM_FORMAT_LAS, false, true);
    assert_int_equal(lum_writer_add(writer, &at, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    char *b = take_file(&size);
    assert_int_equal(get(b, 6, 2), 0x11);
    /* 1384035218 s since the GPS epoch, leap seconds included, less 1e9. */
    assert_true(fabs(get_double(b, (size_t)get(b, 96, 4) + 22) - 384035218.25) <
                1e-6);
    free(b);
}

static void las_refuses_points_that_it_cannot_hold(void **state)
{
    static const float wrong[] = {214749.0f, -3e9f, INFINITY, NAN};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        lum_error error = {""};
        lum_sample far[2] = {two[0], two[0]};
        lum_line_samples lines = line;
        far[1].y = wrong[i];
        lines.samples = far;
        lum_writer *writer = open_writer(LUM_FORMAT_LAS, false, false);
        assert_int_equal(lum_writer_add(writer, &lines, &error), -1);
        assert_int_equal(errno, ERANGE);
        assert_non_null(strstr(error.text, "line 639, frame -3"));
        assert_non_null(strstr(error.text, "; PLY and PCD can"));
        assert_int_equal(lum_writer_close(writer, &error), -1);
        assert_non_null(strstr(error.text, "line 639, frame -3"));
        assert_int_equal(count_files(), 0);
    }
}

static void every_format_writes_an_empty_cloud(void **state)
{
    (void)state;
    for (int i = 0; i < LUM_FORMATS * 2; i++) {
        size_t size;
        free(write_lines((lum_format)(i / 2), i % 2 != 0, 0, &size));
        assert_true(size > 0 || i / 2 == LUM_FORMAT_XYZ);
    }
}

static void a_line_without_samples_adds_nothing(void **state)
{
    const lum_line_samples none = {
        .struct_size = sizeof none, .samples = NULL, .count = 0};
    size_t size;
    (void)state;
    lum_writer *writer = open_writer(LUM_FORMAT_CSV, false, false);
    assert_int_equal(lum_writer_add(writer, &none, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    char *got = take_file(&size);
    assert_string_equal(got, CSV_HEADER);
    free(got);
}

static void every_format_takes_the_longest_line(void **state)
{
    enum {
        WORDS = 16384
    };
    lum_sample *samples = calloc(WORDS, sizeof *samples);
    lum_line_samples full = line;
    (void)state;
    assert_non_null(samples);
    for (size_t i = 0; i < WORDS; i++) {
        samples[i] = two[i % 2u];
        samples[i].pixel = (uint16_t)(i / 17u);
    }
    full.samples = samples;
    full.count = WORDS;
    for (int i = 0; i < LUM_FORMATS * 2; i++) {
        size_t size;
        lum_writer *writer =
            open_writer((lum_format)(i / 2), i % 2 != 0, false);
        for (int j = 0; j < 3; j++) {
            assert_int_equal(lum_writer_add(writer, &full, NULL), 0);
        }
        assert_int_equal(lum_writer_close(writer, NULL), 0);
        free(take_file(&size));
        /* The same two points again and again are little once compressed. */
        assert_true(size > WORDS || i / 2 == LUM_FORMAT_MCAP);
    }
    free(samples);
}

static void extreme_values_fit_every_format(void **state)
{
    (void)state;
    for (int i = 0; i < LUM_FORMATS * 2; i++) {
        size_t size;
        lum_sample s[200];
        lum_line_samples l = {.struct_size = sizeof l,
                              .samples = s,
                              .count = 200,
                              .frame = i % 2 != 0 ? INT64_MIN : INT64_MAX,
                              .timestamp_us = INT64_MIN,
                              .line = UINT32_MAX,
                              .eye = UINT8_MAX};
        for (size_t j = 0; j < 200; j++) {
            const float big = j % 2u != 0 ? -3.4e38f : NAN;
            const float far = i / 2 == LUM_FORMAT_LAS ? -214747.0f : -3.4e38f;
            s[j] = (lum_sample){far,        far,        far,       big,
                                big,        big,        big,       UINT16_MAX,
                                UINT16_MAX, UINT16_MAX, UINT8_MAX, 0};
        }
        lum_writer *writer =
            open_writer((lum_format)(i / 2), i % 2 != 0, i % 2 != 0);
        assert_int_equal(lum_writer_add(writer, &l, NULL), 0);
        assert_int_equal(lum_writer_close(writer, NULL), 0);
        free(take_file(&size));
    }
}

static void frames_beyond_32_bits_become_the_nearest(void **state)
{
    size_t size;
    lum_line_samples late = line;
    (void)state;
    late.frame = INT64_C(1) << 40;
    late.line = UINT32_MAX;
    lum_writer *writer = open_writer(LUM_FORMAT_PLY, false, false);
    assert_int_equal(lum_writer_add(writer, &late, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    char *bytes = take_file(&size);
    const char *row = bytes + size - 52;
    assert_int_equal(get(row, 36, 4), INT32_MAX);
    assert_int_equal(get(row, 41, 4), INT32_MAX);
    free(bytes);
}

/* --- Chosen columns --- */

#define CSV_NAMES                                                              \
    "x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,line,"      \
    "pixel,return_number,number_of_returns,edge"
#define CLOUD_NAMES                                                            \
    "x,y,z,pulse_width,range,azimuth,elevation,timestamp,frame,eye,line,"      \
    "pixel,return_number,number_of_returns,edge"

static const float two_times[] = {0.0625f, -1.0f};

/* A file of one line with such columns. */
static char *write_columns(lum_format format, bool ascii, const char *columns,
                           size_t *size)
{
    char names[256];
    lum_line_samples timed = line;
    lum_writer *writer = NULL;
    lum_error error = {""};
    timed.times = two_times;
    snprintf(names, sizeof names, "%s", columns);
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .ascii = ascii,
                                        .columns = names};
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), 0);
    memset(names, 'x', sizeof names); /* it was read */
    assert_int_equal(lum_writer_add(writer, &timed, &error), 0);
    assert_int_equal(lum_writer_close(writer, &error), 0);
    return take_file(size);
}

static void columns_that_a_format_has_anyway_change_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < 5; i++) {
        static const lum_format formats[] = {LUM_FORMAT_CSV, LUM_FORMAT_PLY,
                                             LUM_FORMAT_PCD};
        size_t want_size;
        size_t size;
        const lum_format format = formats[(i + 1) / 2];
        char *want = write_lines(format, i % 2 != 0, 1, &want_size);
        char *got = write_columns(format, i % 2 != 0,
                                  i == 0 ? CSV_NAMES : CLOUD_NAMES, &size);
        assert_int_equal(size, want_size);
        assert_memory_equal(got, want, size);
        free(got);
        free(want);
    }
}

static void expect_columns(lum_format format, bool ascii, const char *columns,
                           const char *says)
{
    size_t size;
    char *got = write_columns(format, ascii, columns, &size);
    assert_non_null(strstr(got, says));
    free(got);
}

static void columns_stand_in_the_order_that_is_asked_for(void **state)
{
    (void)state;
    expect_columns(LUM_FORMAT_CSV, false, "edge,time,eye,x,line,timestamp",
                   "edge,time,eye,x,line,timestamp\n"
                   "1,0.062500000,1,1.5000,639,1234567\n"
                   "0,-1.000000000,1,-100.0000,639,1234567\n");
    expect_columns(LUM_FORMAT_CSV, false, "time",
                   "time\n0.062500000\n-1.000000000\n");
    expect_columns(LUM_FORMAT_PLY, true, "time,pulse_width,z",
                   "comment time in s from the beginning of the frame\n");
    expect_columns(LUM_FORMAT_PLY, true, "time,pulse_width,z",
                   "property float scalar_time\nproperty float intensity\n"
                   "property float z\nend_header\n0.062500000 4.797 0.0000\n");
    expect_columns(LUM_FORMAT_PCD, true, "z,frame,time",
                   "# time in s from the beginning of the frame\n");
    expect_columns(LUM_FORMAT_PCD, true, "z,frame,time",
                   "FIELDS z frame time\nSIZE 4 4 4\nTYPE F I F\n"
                   "COUNT 1 1 1\nWIDTH 2\n");
}

static void chosen_columns_are_exact_in_binary(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        size_t size;
        char *bytes =
            write_columns(i == 0 ? LUM_FORMAT_PLY : LUM_FORMAT_PCD, false,
                          "time,edge,pixel,timestamp,frame", &size);
        const char *row = bytes + size - 19;
        assert_true(get_float(row, 0) == -1.0);
        assert_int_equal(get(row, 4, 1), 0);
        assert_int_equal(get(row, 5, 2), 7);
        assert_true(get_double(row, 7) == 1234567.0);
        assert_int_equal(get(row, 15, 4), UINT32_MAX - 2u);
        assert_true(get_float(row - 19, 0) == 0.0625);
        free(bytes);
    }
}

static void any_time_is_written(void **state)
{
    const float times[] = {3.4e38f, NAN};
    lum_line_samples timed = line;
    lum_writer *writer = NULL;
    size_t size;
    (void)state;
    timed.times = times;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .columns = "time"};
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_add(writer, &timed, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    char *text = take_file(&size);
    assert_non_null(strstr(text, "\nnan\n"));
    const float largest = strtof(text + 5, NULL);
    assert_true(largest == times[0]); /* a literal may be more exact than it */
    free(text);
}

static void refuse_options(const lum_writer_options *options, const char *says)
{
    lum_writer *writer = NULL;
    lum_error error = {""};
    errno = 0;
    assert_int_equal(lum_writer_open(path, options, &writer, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, says));
    assert_int_equal(count_files(), 0);
}

static void columns_that_cannot_be_are_refused(void **state)
{
    static const struct {
        const char *names;
        const char *says;
    } wrong[] = {{"", "'' is not a column"},
                 {"x,", "'' is not a column; columns are x, y, z, range"},
                 {"x,,y", "'' is not a column"},
                 {"x y", "'x y' is not a column"},
                 {"tim", "'tim' is not a column"},
                 {"times", "edge, time"},
                 {"x,time,x", "x is named twice"}};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        lum_error error = {""};
        refuse_options(
            &(lum_writer_options){.struct_size = sizeof(lum_writer_options),
                                  .columns = wrong[i].names},
            wrong[i].says);
        assert_int_equal(lum_writer_check_columns(wrong[i].names, &error), -1);
        assert_int_equal(errno, EINVAL);
        assert_non_null(strstr(error.text, wrong[i].says));
    }
    assert_int_equal(lum_writer_check_columns(CSV_NAMES ",time", NULL), 0);
    for (int i = 0; i < LUM_FORMATS; i++) {
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = (lum_format)i,
                                            .picture = lum_picture_format(),
                                            .columns = "x"};
        assert_int_equal(lum_format_has_columns((lum_format)i),
                         i <= LUM_FORMAT_PCD);
        if (i > LUM_FORMAT_PCD) {
            refuse_options(&options, "cannot be chosen");
        }
    }
    assert_false(lum_format_has_columns(LUM_FORMATS));
}

static void what_no_column_reads_need_not_be_made(void **state)
{
    const unsigned degrees = LUM_LEAVE_DEGREES;
    const unsigned returns = LUM_LEAVE_RETURNS;
    (void)state;
    assert_int_equal(lum_format_leaves(LUM_FORMAT_PLY, NULL), 0);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_LAS, "x"), 0);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_MCAP, NULL), 0);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_XYZ, NULL), LUM_LEAVE_ALL);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_PLY, "x,y,z"), LUM_LEAVE_ALL);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_CSV, "range,own_azimuth"),
                     LUM_LEAVE_ALL);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_CSV, "azimuth,x"), returns);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_PCD, "x,elevation"), returns);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_PLY, "pulse_width"), degrees);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_PLY, "x,return_number,y"),
                     degrees);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_CSV, "number_of_returns"),
                     degrees);
    assert_int_equal(lum_format_leaves(LUM_FORMAT_CSV, CSV_NAMES), 0);
}

static void a_line_without_times_fails_where_they_are_asked_for(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .columns = "x,time"};
    lum_writer *writer = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_add(writer, &line, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, "without times"));
    lum_writer_abort(writer);
}

/* --- Organised clouds --- */

static lum_sample pixels[LUM_LINE_PIXELS];
static float pixel_times[LUM_LINE_PIXELS];
static const lum_line_samples row = {.struct_size = sizeof row,
                                     .samples = pixels,
                                     .count = LUM_LINE_PIXELS,
                                     .frame = 5,
                                     .timestamp_us = LUM_TIMESTAMP_NONE,
                                     .times = pixel_times};

static lum_writer *open_rows(const char *name, bool ascii, uint32_t rows)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_PCD,
                                        .ascii = ascii,
                                        .columns = "z,timestamp,pixel,time",
                                        .organized = true};
    lum_writer *writer = NULL;
    lum_error error = {""};
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        pixels[i] = (lum_sample){.z = NAN, .pixel = (uint16_t)i};
        pixel_times[i] = NAN;
    }
    pixels[7].z = 1.5f;
    pixel_times[7] = 0.25f;
    assert_int_equal(lum_writer_open(name, &options, &writer, &error), 0);
    assert_int_equal(lum_writer_set_rows(writer, rows, &error), 0);
    return writer;
}

static void an_organised_cloud_is_rows_of_pixels(void **state)
{
    (void)state;
    for (int ascii = 0; ascii < 2; ascii++) {
        size_t size;
        lum_writer *writer = open_rows(path, ascii != 0, 3);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(lum_writer_add(writer, &row, NULL), 0);
        }
        assert_int_equal(lum_writer_close(writer, NULL), 0);
        char *bytes = take_file(&size);
        assert_non_null(strstr(bytes, "\nWIDTH 1000\nHEIGHT 3\nVIEWPOINT 0 0 0 "
                                      "1 0 0 0\nPOINTS 3000\nDATA "));
        assert_non_null(strstr(bytes, "\n# organised: "));
        if (ascii != 0) {
            assert_non_null(strstr(bytes, "ascii\nnan nan 0 nan\n"));
            assert_non_null(strstr(bytes, "\n1.5000 nan 7 0.250000000\n"));
        } else {
            const char *last = bytes + size - 18000;
            assert_true(isnan(get_float(last, 0)));
            assert_true(isnan(get_double(last, 4)));
            assert_int_equal(get(last, 12, 2), 0);
            assert_true(isnan(get_float(last, 14)));
            assert_true(get_float(last, 7 * 18) == 1.5);
            assert_true(get_float(last, 7 * 18 + 14) == 0.25);
        }
        free(bytes);
    }
}

static void an_organised_cloud_needs_no_output_that_can_seek(void **state)
{
    (void)state;
    lum_writer *writer = open_rows("/dev/null", false, 1);
    assert_int_equal(lum_writer_add(writer, &row, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
}

static void an_organised_cloud_without_a_frame_has_no_rows(void **state)
{
    size_t size;
    lum_writer *writer = NULL;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_PCD,
                                        .organized = true};
    (void)state;
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    char *bytes = take_file(&size);
    assert_non_null(strstr(bytes, "\nWIDTH 1000\nHEIGHT 0\n"));
    assert_non_null(strstr(bytes, "\nPOINTS 0\nDATA binary\n"));
    assert_string_equal(bytes + size - 12, "DATA binary\n");
    free(bytes);
}

/* Adds so many rows, and one line of so many points if that is not 0. */
static void expect_bad_rows(int rows, size_t points, const char *says)
{
    lum_error error = {""};
    lum_line_samples other = row;
    lum_writer *writer = open_rows(path, false, 2);
    other.count = points;
    for (int i = 0; i < rows; i++) {
        assert_int_equal(lum_writer_add(writer, &row, NULL), 0);
    }
    errno = 0;
    if (points != 0) {
        assert_int_equal(lum_writer_add(writer, &other, &error), -1);
        lum_writer_abort(writer);
    } else {
        assert_int_equal(lum_writer_close(writer, &error), -1);
    }
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, says));
    assert_int_equal(count_files(), 0);
}

static void rows_that_do_not_fit_are_an_error(void **state)
{
    (void)state;
    expect_bad_rows(0, 0, "0 points of an organised file of 2000");
    expect_bad_rows(1, 0, "1000 points of an organised file of 2000");
    expect_bad_rows(1, 999, "a line of 999 points");
    expect_bad_rows(2, LUM_LINE_PIXELS, "of 2 rows of 1000");
}

static void expect_bad_begin(bool organized, uint32_t first, uint32_t rows,
                             const char *says)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_PCD,
                                        .organized = organized};
    lum_writer *writer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    if (first != 0) {
        assert_int_equal(lum_writer_set_rows(writer, first, NULL), 0);
    }
    errno = 0;
    assert_int_equal(lum_writer_set_rows(writer, rows, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_non_null(strstr(error.text, says));
    lum_writer_abort(writer);
}

static void rows_are_told_once_and_of_organised_files_alone(void **state)
{
    lum_writer *writer = NULL;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_PCD,
                                        .organized = true};
    (void)state;
    expect_bad_begin(false, 0, 1, "not organised");
    expect_bad_begin(true, 1, 1, "one frame");
    expect_bad_begin(true, 0, LUM_WRITER_ROWS_MAX + 1u, "too many");
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_add(writer, &row, NULL), -1);
    lum_writer_abort(writer);
    for (int i = 0; i < LUM_FORMATS; i++) {
        if (i != LUM_FORMAT_PCD) {
            refuse_options(
                &(lum_writer_options){.struct_size = sizeof(lum_writer_options),
                                      .format = (lum_format)i,
                                      .picture = lum_picture_format(),
                                      .organized = true},
                "no rows of pixels");
        }
    }
}

/* --- Rehearsals, failures --- */

/* A rehearsal of `lines` times the same line. */
static lum_writer *rehearsal_of(lum_format format, unsigned lines)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .picture = lum_picture_format()};
    lum_writer *rehearsal = NULL;
    assert_int_equal(lum_writer_rehearse(&options, &rehearsal, NULL), 0);
    for (unsigned i = 0; i < lines; i++) {
        assert_int_equal(lum_writer_add(rehearsal, &line, NULL), 0);
    }
    return rehearsal;
}

static void other_points_than_rehearsed_are_an_error_and_leave_nothing(
    void **state)
{
    (void)state;
    for (unsigned lines = 0; lines <= 2; lines++) {
        lum_writer *rehearsal = rehearsal_of(LUM_FORMAT_PLY, lines);
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = LUM_FORMAT_PLY,
                                            .rehearsal = rehearsal};
        lum_writer *writer = NULL;
        lum_error error = {""};
        assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
        lum_writer_abort(rehearsal);
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
        const int result = lum_writer_close(writer, &error);
        assert_int_equal(result, lines == 1 ? 0 : -1);
        assert_int_equal(exists(), lines == 1);
        assert_int_equal(count_files(), lines == 1);
        if (lines == 1) {
            assert_int_equal(unlink(path), 0);
        } else {
            assert_non_null(strstr(error.text, "2 came"));
        }
    }
}

/* Any device that cannot seek will do. */
static void open_null(lum_format format, bool rehearses, bool opens,
                      const char *says)
{
    lum_writer *rehearsal = rehearses ? rehearsal_of(format, 1) : NULL;
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = format,
                                        .rehearsal = rehearsal,
                                        .picture = lum_picture_format()};
    lum_writer *writer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_writer_open("/dev/null", &options, &writer, &error),
                     opens ? 0 : -1);
    assert_non_null(strstr(error.text, says));
    if (opens) {
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
        assert_int_equal(lum_writer_close(writer, NULL), 0);
    }
    lum_writer_abort(rehearsal);
}

static void what_cannot_seek_needs_a_rehearsal(void **state)
{
    (void)state;
    open_null(LUM_FORMAT_CSV, false, true, "");
    open_null(LUM_FORMAT_XYZ, false, true, "");
    open_null(LUM_FORMAT_PNG, false, true, "");
    open_null(LUM_FORMAT_PLY, false, false, "number of points");
    open_null(LUM_FORMAT_PLY, true, true, "");
    open_null(LUM_FORMAT_PCD, false, false, "number of points");
    open_null(LUM_FORMAT_PCD, true, true, "");
    open_null(LUM_FORMAT_LAS, false, false, "number of points");
    open_null(LUM_FORMAT_LAS, true, true, "");
}

static void a_rehearsed_header_and_a_patched_one_give_equal_files(void **state)
{
    static const lum_format formats[] = {LUM_FORMAT_PLY, LUM_FORMAT_PCD,
                                         LUM_FORMAT_LAS};
    (void)state;
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        lum_writer *rehearsal = rehearsal_of(formats[i], 1);
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = formats[i],
                                            .rehearsal = rehearsal};
        lum_writer *writer = NULL;
        size_t patched_size;
        size_t size;
        char *patched = write_lines(formats[i], false, 1, &patched_size);
        assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
        assert_int_equal(lum_writer_close(writer, NULL), 0);
        lum_writer_abort(rehearsal);
        char *announced = take_file(&size);
        assert_int_equal(size, patched_size);
        assert_memory_equal(announced, patched, size);
        free(announced);
        free(patched);
    }
}

static void a_full_disk_fails_every_format(void **state)
{
    (void)state;
    for (int i = 0; i < LUM_FORMATS; i++) {
        lum_writer *rehearsal = rehearsal_of((lum_format)i, 1);
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = (lum_format)i,
                                            .rehearsal = rehearsal,
                                            .picture = lum_picture_format()};
        lum_writer *writer = NULL;
        lum_error error = {""};
        assert_int_equal(
            lum_writer_open("/dev/full", &options, &writer, &error), 0);
        lum_writer_abort(rehearsal);
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
        assert_int_equal(lum_writer_close(writer, &error), -1);
        assert_int_equal(errno, ENOSPC);
        assert_non_null(strstr(error.text, "No space left"));
    }
}

/* Lines by parts of so many each: small ones are copied into a block, large
 * ones written at once. Takes the file. */
static char *write_parts(const lum_writer_options *options, size_t lines,
                         size_t each, size_t *size)
{
    lum_writer *writer = NULL;
    lum_writer *part = NULL;
    lum_error error = {""};
    assert_int_equal(lum_writer_open(path, options, &writer, &error), 0);
    assert_int_equal(lum_writer_open_part(path, options, &part, &error), 0);
    for (size_t i = 0; i < lines; i++) {
        assert_int_equal(lum_writer_add(part, &line, &error), 0);
        if ((i + 1u) % each == 0 || i + 1u == lines) {
            assert_int_equal(lum_writer_part_points(part),
                             2u * (i % each + 1u));
            assert_int_equal(lum_writer_add_part(writer, part, &error), 0);
            assert_int_equal(lum_writer_part_points(part), 0);
        }
    }
    assert_int_equal(lum_writer_add_part(writer, part, &error), 0);
    lum_writer_abort(part);
    assert_int_equal(lum_writer_close(writer, &error), 0);
    return take_file(size);
}

static void parts_make_the_same_file(void **state)
{
    static const size_t each[] = {1, 15000, 59000};
    static const size_t lines = 60000; /* the largest part is above 1 MiB */
    (void)state;
    for (int i = 0; i < 2 * LUM_FORMATS; i++) {
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = (lum_format)(i / 2),
                                            .ascii = i % 2 != 0,
                                            .comment = "of a test",
                                            .columns =
                                                i == 1 ? "frame,x,edge" : NULL};
        if (!lum_format_has_parts(options.format)) {
            continue;
        }
        for (size_t k = 0; k < sizeof each / sizeof each[0]; k++) {
            size_t size = 0;
            size_t want_size = 0;
            lum_writer *writer = NULL;
            assert_int_equal(lum_writer_open(path, &options, &writer, NULL), 0);
            for (size_t n = 0; n < lines; n++) {
                assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
            }
            assert_int_equal(lum_writer_close(writer, NULL), 0);
            char *want = take_file(&want_size);
            char *bytes = write_parts(&options, lines, each[k], &size);
            assert_true(want_size > (1u << 20));
            assert_int_equal(size, want_size);
            assert_memory_equal(bytes, want, size);
            free(bytes);
            free(want);
        }
    }
}

static void a_part_that_is_emptied_adds_nothing(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_XYZ};
    lum_writer *part = NULL;
    size_t size = 0;
    (void)state;
    lum_writer *writer = open_writer(LUM_FORMAT_XYZ, false, false);
    assert_int_equal(lum_writer_open_part("-", &options, &part, NULL), 0);
    assert_int_equal(lum_writer_add(part, &line, NULL), 0);
    lum_writer_clear_part(part);
    assert_int_equal(lum_writer_part_points(part), 0);
    assert_int_equal(lum_writer_bytes(part), 0);
    assert_int_equal(lum_writer_add_part(writer, part, NULL), 0);
    lum_writer_abort(part);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    free(take_file(&size));
    assert_int_equal(size, 0);
}

static void formats_that_know_more_than_a_line_have_no_parts(void **state)
{
    (void)state;
    for (int i = 0; i < LUM_FORMATS; i++) {
        const lum_writer_options options = {.struct_size = sizeof options,
                                            .format = (lum_format)i};
        lum_writer *part = NULL;
        lum_error error = {""};
        const bool has = options.format == LUM_FORMAT_CSV ||
                         options.format == LUM_FORMAT_PLY ||
                         options.format == LUM_FORMAT_PCD ||
                         options.format == LUM_FORMAT_XYZ;
        assert_int_equal(lum_format_has_parts(options.format), has);
        assert_int_equal(lum_writer_open_part(path, &options, &part, &error),
                         has ? 0 : -1);
        if (!has) {
            assert_int_equal(errno, EINVAL);
            assert_non_null(strstr(error.text, "cannot be made of parts"));
        }
        lum_writer_abort(part);
    }
    const lum_writer_options organized = {.struct_size = sizeof organized,
                                          .format = LUM_FORMAT_PCD,
                                          .organized = true};
    lum_writer *part = NULL;
    assert_int_equal(lum_writer_open_part(path, &organized, &part, NULL), -1);
    assert_false(lum_format_has_parts(LUM_FORMATS));
    assert_int_equal(count_files(), 0);
}

static void a_part_that_cannot_be_written_is_an_error_that_stays(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_CSV};
    lum_writer *writer = NULL;
    lum_writer *part = NULL;
    lum_error error = {""};
    int result = 0;
    (void)state;
    assert_int_equal(lum_writer_open("/dev/full", &options, &writer, NULL), 0);
    assert_int_equal(lum_writer_open_part("/dev/full", &options, &part, NULL),
                     0);
    for (int i = 0; i < 1000 && result == 0; i++) {
        for (int n = 0; n < 500; n++) {
            assert_int_equal(lum_writer_add(part, &line, NULL), 0);
        }
        result = lum_writer_add_part(writer, part, &error);
        assert_int_equal(lum_writer_part_points(part), 0);
    }
    assert_int_equal(result, -1);
    assert_int_equal(errno, ENOSPC);
    assert_non_null(strstr(error.text, "No space left"));
    assert_int_equal(lum_writer_add(writer, &line, NULL), -1);
    assert_int_equal(errno, ENOSPC);
    lum_writer_abort(part);
    lum_writer_abort(writer);
}

static void a_failure_is_repeated_by_what_follows(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_CSV};
    lum_writer *writer = NULL;
    lum_error error = {""};
    int result = 0;
    (void)state;
    assert_int_equal(lum_writer_open("/dev/full", &options, &writer, NULL), 0);
    for (int i = 0; i < 200000 && result == 0; i++) {
        result = lum_writer_add(writer, &line, NULL);
    }
    assert_int_equal(result, -1);
    errno = 0;
    assert_int_equal(lum_writer_add(writer, &line, &error), -1);
    assert_int_equal(errno, ENOSPC);
    assert_non_null(strstr(error.text, "No space left"));
    assert_int_equal(lum_writer_close(writer, NULL), -1);
    assert_int_equal(errno, ENOSPC);
}

static void an_abort_leaves_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < LUM_FORMATS; i++) {
        lum_writer *writer = open_writer((lum_format)i, false, false);
        assert_int_equal(lum_writer_add(writer, &line, NULL), 0);
        assert_false(exists());
        assert_int_equal(count_files(), 1);
        lum_writer_abort(writer);
        assert_int_equal(count_files(), 0);
    }
    lum_writer_abort(NULL);
}

static void a_format_that_is_none_is_refused(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMATS};
    lum_writer *writer = NULL;
    (void)state;
    assert_int_equal(lum_writer_open(path, &options, &writer, NULL), -1);
    assert_false(lum_format_needs_count(LUM_FORMATS));
    assert_int_equal(count_files(), 0);
}

static void a_picture_that_nothing_draws_is_refused(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_PNG};
    lum_writer *writer = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), -1);
    assert_int_equal(errno, ENOTSUP);
    assert_non_null(strstr(error.text, "cannot draw pictures"));
    assert_int_equal(count_files(), 0);
    assert_int_equal(lum_writer_rehearse(&options, &writer, NULL), -1);
}

static void endings_tell_formats(void **state)
{
    static const struct {
        const char *name;
        int result;
        lum_format format;
    } cases[] = {
        {"a.csv", 0, LUM_FORMAT_CSV},    {"b/a.PLY", 0, LUM_FORMAT_PLY},
        {"a.b.pcd", 0, LUM_FORMAT_PCD},  {".las", 0, LUM_FORMAT_LAS},
        {"%04d.xyz", 0, LUM_FORMAT_XYZ}, {"a.pNg", 0, LUM_FORMAT_PNG},
        {"a.mcap", 0, LUM_FORMAT_MCAP},  {"a.mca", -1, LUM_FORMATS},
        {"a.pcap", -1, LUM_FORMATS},     {"csv", -1, LUM_FORMATS},
        {"", -1, LUM_FORMATS},           {"a.csv/b", -1, LUM_FORMATS},
        {"a.csv.", -1, LUM_FORMATS},     {"-", -1, LUM_FORMATS},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lum_format format = LUM_FORMATS;
        assert_int_equal(lum_format_from_name(cases[i].name, &format),
                         cases[i].result);
        assert_int_equal(format, cases[i].format);
    }
}

static void headers_with_counts_are_known(void **state)
{
    (void)state;
    assert_false(lum_format_needs_count(LUM_FORMAT_CSV));
    assert_true(lum_format_needs_count(LUM_FORMAT_PLY));
    assert_true(lum_format_needs_count(LUM_FORMAT_PCD));
    assert_true(lum_format_needs_count(LUM_FORMAT_LAS));
    assert_false(lum_format_needs_count(LUM_FORMAT_XYZ));
    assert_false(lum_format_needs_count(LUM_FORMAT_PNG));
    assert_false(lum_format_needs_count(LUM_FORMAT_MCAP));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(csv_rows_have_all_columns),
        cmocka_unit_test(xyz_rows_are_bare),
        cmocka_unit_test(ply_in_ascii_is_as_written_here),
        cmocka_unit_test(pcd_in_ascii_is_as_written_here),
        cmocka_unit_test(ply_in_binary_holds_every_value),
        cmocka_unit_test(pcd_in_binary_holds_every_value),
        cmocka_unit_test(a_longer_count_leaves_the_header_as_long),
        cmocka_unit_test(las_header_tells_bounds_and_counts),
        cmocka_unit_test(las_points_hold_every_value),
        cmocka_unit_test(comments_stand_where_a_format_has_them),
        cmocka_unit_test(the_longest_comment_is_written),
        cmocka_unit_test(what_is_no_comment_is_refused),
        cmocka_unit_test(las_has_a_record_for_the_comment),
        cmocka_unit_test(las_in_utc_has_adjusted_gps_time),
        cmocka_unit_test(las_refuses_points_that_it_cannot_hold),
        cmocka_unit_test(every_format_writes_an_empty_cloud),
        cmocka_unit_test(a_line_without_samples_adds_nothing),
        cmocka_unit_test(every_format_takes_the_longest_line),
        cmocka_unit_test(extreme_values_fit_every_format),
        cmocka_unit_test(frames_beyond_32_bits_become_the_nearest),
        cmocka_unit_test(columns_that_a_format_has_anyway_change_nothing),
        cmocka_unit_test(columns_stand_in_the_order_that_is_asked_for),
        cmocka_unit_test(chosen_columns_are_exact_in_binary),
        cmocka_unit_test(any_time_is_written),
        cmocka_unit_test(columns_that_cannot_be_are_refused),
        cmocka_unit_test(what_no_column_reads_need_not_be_made),
        cmocka_unit_test(a_line_without_times_fails_where_they_are_asked_for),
        cmocka_unit_test(an_organised_cloud_is_rows_of_pixels),
        cmocka_unit_test(an_organised_cloud_needs_no_output_that_can_seek),
        cmocka_unit_test(an_organised_cloud_without_a_frame_has_no_rows),
        cmocka_unit_test(rows_that_do_not_fit_are_an_error),
        cmocka_unit_test(rows_are_told_once_and_of_organised_files_alone),
        cmocka_unit_test(
            other_points_than_rehearsed_are_an_error_and_leave_nothing),
        cmocka_unit_test(what_cannot_seek_needs_a_rehearsal),
        cmocka_unit_test(a_rehearsed_header_and_a_patched_one_give_equal_files),
        cmocka_unit_test(a_full_disk_fails_every_format),
        cmocka_unit_test(parts_make_the_same_file),
        cmocka_unit_test(a_part_that_is_emptied_adds_nothing),
        cmocka_unit_test(formats_that_know_more_than_a_line_have_no_parts),
        cmocka_unit_test(a_part_that_cannot_be_written_is_an_error_that_stays),
        cmocka_unit_test(a_failure_is_repeated_by_what_follows),
        cmocka_unit_test(an_abort_leaves_nothing),
        cmocka_unit_test(a_format_that_is_none_is_refused),
        cmocka_unit_test(a_picture_that_nothing_draws_is_refused),
        cmocka_unit_test(endings_tell_formats),
        cmocka_unit_test(headers_with_counts_are_known),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
