#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"
#include "support.h"

#include "lum/frame/framer.h"
#include "lum/smooth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FRAMES_MAX 64u
#define LINES      20u /* of a frame and eye */
#define PERIOD_US  1000u
#define ALL_POINTS (LINES * LUM_EYES * LUM_LINE_PIXELS)

/* A framer, and all that came out of it. */
struct run {
    lum_framer *framer;
    struct drive_line line;
    uint32_t clock;
    int64_t time_ns;
    lum_frame *frames[FRAMES_MAX]; /* of the first view, kept */
    size_t count;
    int64_t numbers[FRAMES_MAX];
    size_t lines;
    uint64_t line_points; /* of these lines' samples */
    int64_t ends[FRAMES_MAX];
    size_t end_count;
};

static struct run *run_new(const lum_framer_options *options)
{
    struct run *r = calloc(1, sizeof *r);
    lum_error error = {""};
    assert_non_null(r);
    if (lum_framer_new(options, &r->framer, &error) != 0) {
        fail_msg("%s", error.text);
    }
    r->clock = 1000000;
    r->time_ns = INT64_C(1700000000000000000);
    return r;
}

static struct run *run_default(void)
{
    const lum_framer_options options = {.struct_size = sizeof options};
    return run_new(&options);
}

static struct run *run_with(lum_columns columns, lum_edges edges)
{
    lum_view view;
    lum_view_default(&view);
    view.columns = columns;
    view.selection.edges = edges;
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = &view, .view_count = 1};
    return run_new(&options);
}

static void release_all(struct run *r)
{
    while (r->count > 0) {
        lum_frame_release(r->frames[--r->count]);
    }
}

static void run_free(struct run *r)
{
    release_all(r);
    lum_framer_free(r->framer);
    free(r);
}

static void take(struct run *r, lum_framer_event event)
{
    const lum_sample *samples = NULL;
    size_t counted = 0;
    switch (event) {
    case LUM_FRAMER_LINE:
        assert_int_equal(lum_framer_frame_number(r->framer),
                         lum_framer_line(r->framer)->frame);
        r->lines++;
        counted = lum_framer_line_samples(r->framer, 0, NULL);
        assert_int_equal(lum_framer_line_samples(r->framer, 0, &samples),
                         counted);
        r->line_points += counted;
        break;
    case LUM_FRAMER_FRAME:
        assert_true(r->count < FRAMES_MAX);
        r->numbers[r->count] = lum_framer_frame_number(r->framer);
        r->frames[r->count++] = lum_frame_keep(lum_framer_frame(r->framer, 0));
        break;
    case LUM_FRAMER_FRAME_END:
        assert_true(r->end_count < FRAMES_MAX);
        r->ends[r->end_count++] = lum_framer_frame_number(r->framer);
        break;
    case LUM_FRAMER_NONE:
    case LUM_FRAMER_FAILED:
        fail_msg("event %d", (int)event);
        break;
    }
}

static void push(struct run *r, const lum_record *record)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_push(r->framer, record, NULL)) !=
           LUM_FRAMER_NONE) {
        take(r, event);
    }
}

static void end(struct run *r)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(r->framer)) != LUM_FRAMER_NONE) {
        take(r, event);
    }
}

static void push_line(struct run *r, uint32_t sensor)
{
    for (size_t i = 0; i < r->line.count; i++) {
        const lum_record record = drive_record(&r->line, i, sensor, r->time_ns);
        push(r, &record);
        r->time_ns += 1000;
    }
}

static void send(struct run *r, unsigned eye, uint32_t line)
{
    drive_pixels(&r->line, eye, line, r->clock, 0, LUM_LINE_PIXELS);
    push_line(r, DRIVE_SENSOR);
}

/* Lines of both eyes, `first` to the last. */
static void send_rest(struct run *r, uint32_t first)
{
    for (uint32_t line = first; line < LINES; line++) {
        send(r, LUM_EYE_BLUE, line);
        send(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
        r->time_ns += PERIOD_US * 1000;
    }
}

static void send_frame(struct run *r)
{
    send_rest(r, 0);
}

static lum_frame_info info_of(const lum_frame *frame)
{
    lum_frame_info info = {.struct_size = sizeof info};
    assert_int_equal(lum_frame_get_info(frame, &info), LUM_OK);
    return info;
}

static lum_framer_counters counters_of(const struct run *r, size_t sensor)
{
    lum_framer_counters c = {.struct_size = sizeof c};
    assert_int_equal(lum_framer_count(r->framer, sensor, &c), LUM_OK);
    return c;
}

static void the_last_frame_comes_with_the_flush(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (unsigned i = 0; i < 3; i++) {
        send_frame(r);
    }
    assert_int_equal(r->count, 2);
    end(r);
    assert_int_equal(r->count, 3);
    for (size_t i = 0; i < 3; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_int_equal(lum_frame_count(r->frames[i]), ALL_POINTS);
        assert_int_equal(info.points, ALL_POINTS);
        assert_int_equal(info.number, i + 1u);
        assert_int_equal(r->numbers[i], i + 1u);
        assert_int_equal(info.sensor, DRIVE_SENSOR);
        assert_true(info.is_complete);
        assert_int_equal(info.is_first, i == 0);
        assert_int_equal(info.is_last, i == 2);
    }
    run_free(r);
}

static void after_a_flush_frames_come_again(void **state)
{
    (void)state;
    struct run *r = run_default();
    send_frame(r);
    end(r);
    send_frame(r);
    send_frame(r);
    end(r);
    end(r);
    assert_int_equal(r->count, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(info_of(r->frames[i]).number, i + 1u);
        assert_int_equal(lum_frame_count(r->frames[i]), ALL_POINTS);
    }
    run_free(r);
}

/* The samples of a line, as the library computes them by itself. */
static size_t compute(const lum_line *line, lum_edges edges, lum_sample *out)
{
    static lum_return returns[LUM_LINE_WORDS_MAX];
    static lum_sample_workspace workspace = {.returns = returns};
    lum_projector projector;
    lum_calibration calibration;
    lum_layout layout;
    lum_selection selection;
    lum_point_losses losses = {0, 0};
    lum_calibration_default(&calibration);
    lum_layout_default(&layout);
    lum_selection_default(&selection);
    selection.edges = edges;
    assert_int_equal(lum_projector_init(&projector, &calibration, &layout),
                     LUM_OK);
    return lum_samples_compute(&projector, line, &selection, &workspace, out,
                               &losses);
}

static void assert_point(const lum_frame *f, size_t at, const lum_sample *s,
                         const lum_line *line)
{
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_X)[at], s->x, 1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_Y)[at], s->y, 1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_Z)[at], s->z, 1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_RANGE)[at], s->range,
                       1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_AZIMUTH)[at], s->azimuth,
                       1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_ELEVATION)[at],
                       s->elevation, 1e-4);
    assert_float_equal(lum_frame_floats(f, LUM_COLUMN_PULSE_WIDTH)[at],
                       s->pulse_width, 1e-4);
    assert_int_equal(lum_frame_uint32s(f, LUM_COLUMN_LINE)[at], line->number);
    assert_int_equal(lum_frame_uint16s(f, LUM_COLUMN_PIXEL)[at], s->pixel);
    assert_int_equal(lum_frame_uint16s(f, LUM_COLUMN_RETURN_NUMBER)[at],
                     s->return_number);
    assert_int_equal(lum_frame_uint16s(f, LUM_COLUMN_NUMBER_OF_RETURNS)[at],
                     s->number_of_returns);
    assert_int_equal(lum_frame_uint8s(f, LUM_COLUMN_EYE)[at], line->eye);
    assert_int_equal(lum_frame_uint8s(f, LUM_COLUMN_EDGE)[at], s->edge);
}

/* Words of a pixel: rise, fall, rise, fall. */
static void send_returns(struct run *r, unsigned eye, uint32_t line)
{
    uint32_t words[4u * LUM_LINE_PIXELS];
    for (uint32_t i = 0; i < 4u * LUM_LINE_PIXELS; i++) {
        words[i] =
            lum_word_make((int32_t)(3000u + 100u * (i % 4u) + i + 11u * line),
                          i % 2u == 0, i / 4u);
    }
    drive_make(&r->line, eye, line, r->clock, words, 4u * LUM_LINE_PIXELS);
    push_line(r, DRIVE_SENSOR);
}

/* Every column of every point, against samples of the lines that the same
 * framer hands out. */
static void a_frame_has_the_points_of_its_lines_in_their_order(void **state)
{
    (void)state;
    static lum_sample samples[LUM_EYES * LINES][4u * LUM_LINE_PIXELS];
    static size_t counts[LUM_EYES * LINES];
    static lum_line lines[LUM_EYES * LINES];
    size_t n = 0;
    size_t at = 0;
    lum_view view;
    lum_view_default(&view);
    view.columns = LUM_COLUMNS_ALL;
    view.selection.edges = LUM_EDGES_BOTH;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .views = &view,
                                        .view_count = 1,
                                        .wants =
                                            LUM_WANT_FRAMES | LUM_WANT_LINES};
    struct run *r = run_new(&options);
    for (uint32_t line = 0; line < LINES; line++) {
        send_returns(r, LUM_EYE_BLUE, line);
        send_returns(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
    }
    /* what was handed out so far is in the frame; take the lines of the flush
     */
    lum_framer_event event = LUM_FRAMER_NONE;
    const size_t before = r->lines;
    while ((event = lum_framer_flush(r->framer)) != LUM_FRAMER_NONE) {
        if (event == LUM_FRAMER_LINE) {
            lines[n] = *lum_framer_line(r->framer);
            counts[n] = compute(&lines[n], LUM_EDGES_BOTH, samples[n]);
            n++;
        } else {
            take(r, event);
        }
    }
    assert_int_equal(r->count, 1);
    const lum_frame *f = r->frames[0];
    assert_int_equal(before + n, LUM_EYES * LINES);
    assert_int_equal(lum_frame_line_count(f), LUM_EYES * LINES);
    assert_int_equal(lum_frame_count(f), LUM_EYES * LINES * 4000u);
    assert_true(n >= 4);
    at = lum_frame_count(f) - n * 4000u;
    for (size_t i = 0; i < n; i++) {
        lum_frame_line row = {.struct_size = sizeof row};
        assert_true(lum_frame_get_line(f, before + i, &row));
        assert_int_equal(row.first_point, at);
        assert_int_equal(row.point_count, counts[i]);
        assert_int_equal(row.number, lines[i].number);
        assert_int_equal(row.eye, lines[i].eye);
        assert_int_equal(row.clock_us, lines[i].clock_us);
        assert_int_equal(row.arrival_ns, lines[i].arrival);
        assert_int_equal(row.angle_count, LUM_LINE_PIXELS);
        for (size_t k = 0; k < counts[i]; k++) {
            assert_point(f, at++, &samples[i][k], &lines[i]);
        }
    }
    run_free(r);
}

static void columns_are_aligned_and_only_those_that_were_asked_for(void **state)
{
    (void)state;
    const lum_columns mask =
        LUM_COLUMN_BIT(LUM_COLUMN_RANGE) | LUM_COLUMN_BIT(LUM_COLUMN_EYE) |
        LUM_COLUMN_BIT(LUM_COLUMN_PIXEL) | LUM_COLUMN_BIT(LUM_COLUMN_LINE);
    struct run *r = run_with(mask, LUM_EDGES_RISING);
    send_frame(r);
    end(r);
    const lum_frame *f = r->frames[0];
    assert_int_equal(lum_frame_columns(f), mask);
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        const void *at = lum_frame_column(f, (lum_column)c);
        assert_int_equal(at != NULL, mask >> c & 1u);
        assert_int_equal((uintptr_t)at % 64u, 0);
        assert_non_null(lum_column_name((lum_column)c));
    }
    assert_null(lum_column_name(LUM_COLUMN_COUNT));
    assert_null(lum_frame_column(f, LUM_COLUMN_COUNT));
    /* of another type */
    assert_null(lum_frame_uint32s(f, LUM_COLUMN_RANGE));
    assert_null(lum_frame_floats(f, LUM_COLUMN_LINE));
    assert_null(lum_frame_uint8s(f, LUM_COLUMN_PIXEL));
    assert_null(lum_frame_uint16s(f, LUM_COLUMN_EYE));
    assert_non_null(lum_frame_floats(f, LUM_COLUMN_RANGE));
    assert_non_null(lum_frame_uint32s(f, LUM_COLUMN_LINE));
    assert_non_null(lum_frame_uint16s(f, LUM_COLUMN_PIXEL));
    assert_non_null(lum_frame_uint8s(f, LUM_COLUMN_EYE));
    run_free(r);
}

/* Enough lines for the columns to grow several times. */
#define MANY_LINES 60u

static void send_large_frame(struct run *r)
{
    for (uint32_t line = 0; line < MANY_LINES; line++) {
        send_returns(r, LUM_EYE_BLUE, line);
        send_returns(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
    }
}

static void assert_rows(const lum_frame *f, const lum_frame *x_z,
                        const lum_frame *y)
{
    const size_t bytes = lum_frame_count(f) * sizeof(float);
    size_t spacing = 0;
    const float *xyz = lum_frame_xyz(f, &spacing);
    assert_non_null(xyz);
    assert_true(spacing >= lum_frame_count(f));
    assert_int_equal(spacing * sizeof *xyz % 64u, 0);
    assert_ptr_equal(xyz, lum_frame_floats(f, LUM_COLUMN_X));
    assert_ptr_equal(xyz + spacing, lum_frame_floats(f, LUM_COLUMN_Y));
    assert_ptr_equal(xyz + 2u * spacing, lum_frame_floats(f, LUM_COLUMN_Z));
    for (unsigned c = 0; c < 3; c++) {
        assert_int_equal((uintptr_t)(xyz + c * spacing) % 64u, 0);
    }
    assert_memory_equal(xyz, lum_frame_floats(x_z, LUM_COLUMN_X), bytes);
    assert_memory_equal(xyz + spacing, lum_frame_floats(y, LUM_COLUMN_Y),
                        bytes);
    assert_memory_equal(xyz + 2u * spacing, lum_frame_floats(x_z, LUM_COLUMN_Z),
                        bytes);
}

/* However they grow and move, and whatever columns their memory had before. */
static void x_y_and_z_are_rows_of_one_block(void **state)
{
    (void)state;
    const lum_columns xyz = LUM_COLUMNS_XYZ | LUM_COLUMN_BIT(LUM_COLUMN_EYE);
    const lum_columns x_z =
        LUM_COLUMN_BIT(LUM_COLUMN_X) | LUM_COLUMN_BIT(LUM_COLUMN_Z);
    const lum_columns y = LUM_COLUMN_BIT(LUM_COLUMN_Y);
    const lum_columns turns[] = {y, xyz, x_z, xyz, xyz};
    struct run *r = run_default();
    struct run *with_x_z = run_with(x_z, LUM_EDGES_BOTH);
    struct run *with_y = run_with(y, LUM_EDGES_BOTH);
    for (size_t i = 0; i < sizeof turns / sizeof turns[0]; i++) {
        size_t spacing = 7;
        lum_view view;
        lum_view_default(&view);
        view.columns = turns[i];
        view.selection.edges = LUM_EDGES_BOTH;
        assert_int_equal(lum_framer_set_views(r->framer, &view, 1, NULL), 0);
        send_large_frame(r);
        end(r);
        send_large_frame(with_x_z);
        end(with_x_z);
        send_large_frame(with_y);
        end(with_y);
        const lum_frame *f = r->frames[r->count - 1u];
        if (turns[i] == xyz) {
            assert_rows(f, with_x_z->frames[0], with_y->frames[0]);
        } else {
            assert_null(lum_frame_xyz(f, &spacing));
            assert_int_equal(spacing, 7);
        }
        release_all(with_x_z);
        release_all(with_y);
        if (i != 3) {
            release_all(r);
        }
    }
    run_free(r);
    run_free(with_x_z);
    run_free(with_y);
}

static void a_frame_without_points_has_rows_too(void **state)
{
    (void)state;
    struct run *r = run_default();
    size_t spacing = 7;
    for (uint32_t line = 0; line < LINES; line++) {
        drive_make(&r->line, LUM_EYE_GREEN, line, r->clock, NULL, 0);
        push_line(r, DRIVE_SENSOR);
        r->clock += PERIOD_US;
    }
    end(r);
    assert_int_equal(r->count, 1);
    assert_int_equal(lum_frame_count(r->frames[0]), 0);
    assert_non_null(lum_frame_xyz(r->frames[0], &spacing));
    assert_int_equal(spacing, 0);
    run_free(r);
}

/* Seconds from the earliest line, a pixel a thousandth of a line. */
#define POISON 0xee /* as a float, a line, a pixel, a mark: none has it */

static const size_t column_bytes[] = {[LUM_TYPE_FLOAT] = sizeof(float),
                                      [LUM_TYPE_UINT32] = sizeof(uint32_t),
                                      [LUM_TYPE_UINT16] = sizeof(uint16_t),
                                      [LUM_TYPE_UINT8] = sizeof(uint8_t)};

/* The bytes of a column, to be written over. */
static uint8_t *bytes_of(const lum_frame *f, unsigned column, size_t *size)
{
    *size = lum_frame_count(f) *
            column_bytes[lum_column_get_type((lum_column)column)];
    return (uint8_t *)(uintptr_t)lum_frame_column(f, (lum_column)column);
}

static size_t count_poisoned(const lum_frame *f, unsigned column)
{
    const size_t one = column_bytes[lum_column_get_type((lum_column)column)];
    uint8_t poison[sizeof(uint64_t)];
    size_t size = 0;
    size_t count = 0;
    const uint8_t *bytes = bytes_of(f, column, &size);
    memset(poison, POISON, sizeof poison);
    for (size_t at = 0; at < size; at += one) {
        count += memcmp(bytes + at, poison, one) == 0 ? 1u : 0u;
    }
    return count;
}

/* What one frame leaves in memory, the next one may have. */
static void poison_and_release(struct run *r, uint8_t *memory[LUM_COLUMN_COUNT])
{
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        size_t size = 0;
        memory[c] = bytes_of(r->frames[0], c, &size);
        memset(memory[c], POISON, size);
    }
    lum_frame_release(r->frames[0]);
    r->count = 0;
}

/* Each is one of the enumeration, so that a new one is asked for too; in both
 * ways of computing them. */
static void every_column_is_filled_for_every_point(void **state)
{
    (void)state;
    for (unsigned by_samples = 0; by_samples < 2; by_samples++) {
        uint8_t *memory[LUM_COLUMN_COUNT];
        lum_view view;
        lum_view_default(&view);
        view.columns = LUM_COLUMNS_ALL;
        view.selection.has_range = by_samples != 0;
        view.selection.range_max = 1e9f;
        const lum_framer_options options = {
            .struct_size = sizeof options, .views = &view, .view_count = 1};
        struct run *r = run_new(&options);
        send_frame(r);
        end(r);
        assert_int_equal(r->count, 1);
        poison_and_release(r, memory);
        send_frame(r);
        end(r);
        assert_int_equal(lum_frame_count(r->frames[0]), ALL_POINTS);
        for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
            size_t size = 0;
            assert_ptr_equal(bytes_of(r->frames[0], c, &size), memory[c]);
            assert_int_equal(count_poisoned(r->frames[0], c), 0);
        }
        run_free(r);
    }
}

static void times_run_through_lines_and_frames(void **state)
{
    (void)state;
    struct run *r = run_with(LUM_COLUMN_BIT(LUM_COLUMN_TIME) |
                                 LUM_COLUMN_BIT(LUM_COLUMN_PIXEL),
                             LUM_EDGES_RISING);
    struct run *alone =
        run_with(LUM_COLUMN_BIT(LUM_COLUMN_TIME), LUM_EDGES_RISING);
    send_frame(r);
    send_frame(r);
    end(r);
    send_frame(alone);
    send_frame(alone);
    end(alone);
    for (size_t k = 0; k < 2; k++) {
        const lum_frame *f = r->frames[k];
        const float *times = lum_frame_floats(f, LUM_COLUMN_TIME);
        const uint16_t *pixels = lum_frame_uint16s(f, LUM_COLUMN_PIXEL);
        for (size_t i = 0; i < lum_frame_line_count(f); i++) {
            lum_frame_line row = {.struct_size = sizeof row};
            assert_true(lum_frame_get_line(f, i, &row));
            for (uint32_t j = 0; j < row.point_count; j++) {
                const size_t at = row.first_point + j;
                const double s = (double)row.number * PERIOD_US * 1e-6 +
                                 pixels[at] * PERIOD_US * 1e-9;
                assert_float_equal(times[at], s, 1e-8);
            }
        }
    }
    assert_memory_equal(lum_frame_floats(alone->frames[0], LUM_COLUMN_TIME),
                        lum_frame_floats(r->frames[0], LUM_COLUMN_TIME),
                        ALL_POINTS * sizeof(float));
    run_free(r);
    run_free(alone);
}

static void a_line_that_lacks_is_missing_by_eye(void **state)
{
    (void)state;
    struct run *r = run_default();
    send_frame(r);
    for (uint32_t line = 0; line < LINES; line++) {
        if (line != 5 && line != LINES - 1u) {
            send(r, LUM_EYE_BLUE, line);
        }
        send(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
    }
    send_frame(r);
    end(r);
    const lum_frame_info info = info_of(r->frames[1]);
    assert_false(info.is_complete);
    assert_int_equal(info.lines[LUM_EYE_BLUE], LINES - 2u);
    assert_int_equal(info.lines[LUM_EYE_GREEN], LINES);
    assert_int_equal(info.lines_missing[LUM_EYE_BLUE], 2);
    assert_int_equal(info.lines_missing[LUM_EYE_GREEN], 0);
    assert_int_equal(info.lost_words, 0);
    assert_true(info_of(r->frames[0]).is_complete);
    assert_true(info_of(r->frames[2]).is_complete);
    run_free(r);
}

/* Lines of both eyes, one after another, of any sweeps. */
static void send_sweeps(struct run *r, uint32_t first, uint32_t end)
{
    for (uint32_t line = first; line < end; line++) {
        send(r, LUM_EYE_BLUE, line % LINES);
        send(r, LUM_EYE_GREEN, line % LINES);
        r->clock += PERIOD_US;
    }
}

static void pause_lines(struct run *r, uint32_t lines)
{
    r->clock += lines * PERIOD_US;
    r->time_ns += (int64_t)lines * PERIOD_US * 1000;
}

static void two_sweeps_that_became_one_frame_are_not_complete(void **state)
{
    (void)state;
    for (unsigned wants = LUM_WANT_FRAMES; wants <= LUM_WANT_LINES; wants++) {
        const lum_framer_options options = {.struct_size = sizeof options,
                                            .wants = wants};
        struct run *r = run_new(&options);
        send_frame(r);
        send_sweeps(r, 0, 10);
        pause_lines(r, LINES - 1u);
        send_sweeps(r, 9, LINES);
        send_frame(r);
        end(r);
        const lum_framer_counters c = counters_of(r, 0);
        assert_int_equal(c.pauses, 1);
        assert_int_equal(c.paused_us, (LINES - 1u) * PERIOD_US);
        assert_int_equal(c.lines_in_pauses, 2u * (LINES - 1u));
        assert_int_equal(c.lines_missing, 0);
        for (size_t i = 0; i < r->count; i++) {
            const lum_frame_info info = info_of(r->frames[i]);
            assert_int_equal(info.is_complete, i != 1);
            assert_int_equal(info.has_pause, i == 1);
            assert_int_equal(info.lines_in_pauses,
                             i == 1 ? 2u * (LINES - 1u) : 0);
        }
        run_free(r);
    }
}

/* Nobody knows how many lines a sweep has before one has ended. */
static void a_first_frame_whose_end_a_pause_took_is_not_complete(void **state)
{
    (void)state;
    const uint32_t longest = 150; /* more than the assembler's gap_us */
    for (uint32_t lines = 6; lines <= longest; lines += longest - 6u) {
        struct run *r = run_default();
        send_sweeps(r, 0, 14);
        pause_lines(r, lines);
        send_frame(r);
        send_frame(r);
        end(r);
        const lum_framer_counters c = counters_of(r, 0);
        assert_false(info_of(r->frames[0]).is_complete);
        /* a break takes the first packet behind it */
        assert_int_equal(info_of(r->frames[1]).is_complete, lines != longest);
        assert_int_equal(c.pauses, 1);
        assert_int_equal(c.lines_in_pauses, 2u * lines);
        assert_int_equal(c.stray_at_breaks, lines == longest ? 2 : 0);
        run_free(r);
    }
}

/* A frame that one eye has nothing of, because it paused, is not complete. */
static void an_eye_that_pauses_makes_its_frames_incomplete(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (uint32_t line = 0; line < 6u * LINES; line++) {
        send(r, LUM_EYE_BLUE, line % LINES);
        if (line < 2u * LINES || line >= 4u * LINES) {
            send(r, LUM_EYE_GREEN, line % LINES);
        }
        r->clock += PERIOD_US;
    }
    end(r);
    const lum_framer_counters c = counters_of(r, 0);
    assert_int_equal(r->count, 6);
    for (size_t i = 0; i < 6; i++) {
        assert_int_equal(info_of(r->frames[i]).is_complete, i < 2 || i > 3);
    }
    assert_int_equal(c.pauses, 1);
    assert_int_equal(c.lines_in_pauses, 2u * LINES);
    run_free(r);
}

static void lines_before_the_first_word_are_dark(void **state)
{
    (void)state;
    static const uint32_t lit_from[] = {0, 7, LINES, LINES - 1u};
    struct run *r = run_default();
    for (size_t i = 0; i < 4; i++) {
        for (uint32_t line = 0; line < LINES; line++) {
            for (unsigned eye = 0; eye < LUM_EYES; eye++) {
                drive_make(&r->line, eye, line, r->clock, NULL, 0);
                if (line >= lit_from[i]) {
                    drive_pixels(&r->line, eye, line, r->clock, 0, 1);
                }
                push_line(r, DRIVE_SENSOR);
            }
            r->clock += PERIOD_US;
        }
    }
    end(r);
    assert_int_equal(r->count, 4);
    for (size_t i = 0; i < 4; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_true(info.is_complete);
        /* eyes close their lines a few apart */
        assert_in_range(info.lines_dark + 4u, 2u * lit_from[i],
                        2u * lit_from[i] + 4u);
        assert_int_equal(info.lines_dark == 0, lit_from[i] == 0);
        assert_int_equal(info.lines_dark == 2u * LINES, lit_from[i] == LINES);
    }
    run_free(r);
}

static void what_frames_lack_is_counted_also_where_none_is_made(void **state)
{
    (void)state;
    uint64_t missing[2] = {0, 0};
    for (unsigned wants = LUM_WANT_FRAMES; wants <= LUM_WANT_LINES; wants++) {
        const lum_framer_options options = {.struct_size = sizeof options,
                                            .wants = wants};
        struct run *r = run_new(&options);
        send_rest(r, 7);
        send_frame(r);
        send_sweeps(r, 0, LINES - 3u);
        send_frame(r);
        send_sweeps(r, 0, 5);
        end(r);
        for (size_t i = 0; i < r->count; i++) {
            const lum_frame_info info = info_of(r->frames[i]);
            missing[0] += (uint64_t)info.lines_missing[0];
            missing[1] += (uint64_t)info.lines_missing[1];
        }
        const lum_framer_counters c = counters_of(r, 0);
        assert_int_equal(c.lines_missing, missing[0] + missing[1]);
        assert_int_equal(c.lines_missing - c.missing_under_way, 2u * 3u);
        assert_int_equal(c.frames, 5);
        run_free(r);
    }
}

static void a_frame_that_was_joined_or_left_in_the_middle_is_not_complete(
    void **state)
{
    (void)state;
    struct run *r = run_default();
    send_rest(r, 7);
    send_frame(r);
    for (uint32_t line = 0; line < 9; line++) {
        send(r, LUM_EYE_BLUE, line);
        send(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
    }
    end(r);
    assert_int_equal(r->count, 3);
    const lum_frame_info first = info_of(r->frames[0]);
    const lum_frame_info whole = info_of(r->frames[1]);
    const lum_frame_info last = info_of(r->frames[2]);
    assert_true(first.is_first && !first.is_complete);
    assert_int_equal(first.lines_missing[LUM_EYE_BLUE], 7);
    assert_true(!whole.is_first && !whole.is_last && whole.is_complete);
    assert_true(last.is_last && !last.is_complete);
    assert_int_equal(last.lines_missing[LUM_EYE_GREEN], LINES - 9u);
    run_free(r);
}

/* Drop packet `lost` of the line. */
static void send_without(struct run *r, unsigned eye, uint32_t line,
                         size_t lost)
{
    drive_pixels(&r->line, eye, line, r->clock, 0, LUM_LINE_PIXELS);
    for (size_t i = 0; i < r->line.count; i++) {
        const lum_record record =
            drive_record(&r->line, i, DRIVE_SENSOR, r->time_ns++);
        if (i != lost) {
            push(r, &record);
        }
    }
}

/* A line beyond the last whole one is not taken for one that is missing. */
static void a_last_line_in_part_is_no_missing_one(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (uint32_t line = 0; line < LINES; line++) {
        send_without(r, LUM_EYE_BLUE, line, line == LINES - 1u ? 1 : SIZE_MAX);
        r->clock += PERIOD_US;
    }
    end(r);
    assert_int_equal(info_of(r->frames[0]).lines_missing[LUM_EYE_BLUE], 0);
    assert_int_equal(info_of(r->frames[0]).lines_missing_angles, 1);
    run_free(r);
}

static void losses_are_told_by_cause(void **state)
{
    (void)state;
    struct run *r = run_default();
    send_frame(r);
    for (uint32_t line = 0; line < LINES; line++) {
        send_without(r, LUM_EYE_BLUE, line, line == 3 ? 1 : SIZE_MAX);
        send_without(r, LUM_EYE_GREEN, line, line == 4 ? 4 : SIZE_MAX);
        r->clock += PERIOD_US;
    }
    end(r);
    const lum_frame_info info = info_of(r->frames[1]);
    assert_int_equal(info.lines_missing_angles, 1);
    assert_int_equal(info.losses.no_angle, 334);
    assert_int_equal(info.losses.no_range, 0);
    assert_int_equal(info.lost_words, 360);
    assert_int_equal(info.points, ALL_POINTS - 334u - 360u);
    assert_false(info.is_complete);
    const lum_framer_counters c = counters_of(r, 0);
    assert_int_equal(c.losses.no_angle, 334);
    assert_int_equal(c.points, 2u * ALL_POINTS - 334u - 360u);
    assert_int_equal(c.rising, c.points);
    assert_int_equal(c.falling, 0);
    assert_int_equal(c.lines[LUM_EYE_BLUE], 2u * LINES);
    run_free(r);
}

/* Cell by cell, against the columns. */
static void assert_grid(const lum_frame *f, unsigned eye, uint32_t rows,
                        uint32_t returns)
{
    const size_t cells = (size_t)rows * LUM_LINE_PIXELS * returns;
    uint32_t *index = malloc(cells * sizeof *index);
    float *x = malloc(cells * sizeof *x);
    float *line = malloc(cells * sizeof *line);
    size_t found = 0;
    assert_true(index != NULL && x != NULL && line != NULL);
    assert_true(lum_frame_grid_index(f, eye, rows, returns, index));
    assert_true(lum_frame_grid_floats(f, LUM_COLUMN_X, eye, rows, returns, x));
    assert_true(
        lum_frame_grid_floats(f, LUM_COLUMN_LINE, eye, rows, returns, line));
    for (size_t i = 0; i < cells; i++) {
        const uint32_t at = index[i];
        if (at == LUM_FRAME_MISSING) {
            assert_true(isnan(x[i]) && isnan(line[i]));
            continue;
        }
        const size_t k = i % returns;
        found++;
        assert_true(at < lum_frame_count(f));
        assert_true(x[i] >= lum_frame_floats(f, LUM_COLUMN_X)[at] &&
                    x[i] <= lum_frame_floats(f, LUM_COLUMN_X)[at]);
        assert_int_equal(lum_frame_uint8s(f, LUM_COLUMN_EYE)[at], eye);
        assert_int_equal(lum_frame_uint16s(f, LUM_COLUMN_PIXEL)[at],
                         i / returns % LUM_LINE_PIXELS);
        assert_int_equal(lum_frame_uint32s(f, LUM_COLUMN_LINE)[at],
                         i / returns / LUM_LINE_PIXELS);
        assert_int_equal((size_t)line[i], i / returns / LUM_LINE_PIXELS);
        assert_true(k == 0 || index[i - 1u] == at - 1u);
    }
    size_t expected = 0;
    uint32_t pixel = LUM_LINE_PIXELS;
    uint32_t nth = 0;
    for (size_t i = 0; i < lum_frame_count(f); i++) {
        const bool is_in = lum_frame_uint8s(f, LUM_COLUMN_EYE)[i] == eye &&
                           lum_frame_uint32s(f, LUM_COLUMN_LINE)[i] < rows;
        nth = lum_frame_uint16s(f, LUM_COLUMN_PIXEL)[i] == pixel ? nth + 1u : 0;
        pixel = lum_frame_uint16s(f, LUM_COLUMN_PIXEL)[i];
        expected += is_in && nth < returns ? 1u : 0u;
    }
    assert_int_equal(found, expected);
    free(index);
    free(x);
    free(line);
}

static void a_grid_has_each_point_at_its_place_and_marks_the_rest(void **state)
{
    (void)state;
    struct run *r = run_with(LUM_COLUMNS_ALL, LUM_EDGES_BOTH);
    uint32_t words[64];
    uint64_t random = 5;
    for (uint32_t line = 0; line < LINES; line++) {
        uint32_t n = 0;
        for (uint32_t pixel = 0; n + 4u < 64u; pixel += 17u) {
            for (uint32_t k = next_random(&random) % 4u; k > 0; k--) {
                words[n++] = lum_word_make(
                    (int32_t)(2000u + next_random(&random) % 9000u),
                    k % 2u != 0, pixel % LUM_LINE_PIXELS);
            }
        }
        drive_make(&r->line, LUM_EYE_GREEN, line, r->clock, words, n);
        if (line % 5u != 3u) {
            push_line(r, DRIVE_SENSOR);
        }
        send(r, LUM_EYE_BLUE, line);
        r->clock += PERIOD_US;
    }
    end(r);
    const lum_frame *f = r->frames[0];
    assert_int_equal(lum_frame_rows(f, LUM_EYE_BLUE), LINES);
    assert_int_equal(lum_frame_rows(f, LUM_EYE_GREEN), LINES);
    assert_grid(f, LUM_EYE_GREEN, LINES, 1);
    assert_grid(f, LUM_EYE_GREEN, LINES, 4);
    assert_grid(f, LUM_EYE_GREEN, LINES + 3u, 2);
    assert_grid(f, LUM_EYE_BLUE, LINES, 1);
    assert_grid(f, LUM_EYE_BLUE, LINES - 6u, 3);
    run_free(r);
}

static uint32_t rows_with(uint32_t number, bool is_whole)
{
    struct run *r = run_default();
    for (uint32_t line = 0; line < LINES; line++) {
        send(r, LUM_EYE_BLUE, line);
        r->clock += PERIOD_US;
    }
    send_without(r, LUM_EYE_BLUE, number, is_whole ? SIZE_MAX : 1);
    end(r);
    const uint32_t rows = lum_frame_rows(r->frames[0], LUM_EYE_BLUE);
    assert_int_equal(lum_frame_rows(r->frames[0], LUM_EYE_GREEN), 0);
    assert_int_equal(lum_frame_rows(r->frames[0], LUM_EYES), 0);
    run_free(r);
    return rows;
}

static void rows_are_those_that_can_be_believed(void **state)
{
    (void)state;
    const uint32_t limit = 2u * LINES + 64u;
    assert_int_equal(rows_with(LINES, false), LINES + 1u);
    assert_int_equal(rows_with(limit - 1u, false), limit);
    assert_int_equal(rows_with(limit, false), LINES);
    assert_int_equal(rows_with(UINT16_MAX, false), LINES);
    assert_int_equal(rows_with(limit, true), limit + 1u);
    assert_int_equal(rows_with(LUM_FRAME_ROWS_MAX - 1u, true),
                     LUM_FRAME_ROWS_MAX);
    assert_int_equal(rows_with(LUM_FRAME_ROWS_MAX, true), LINES);
}

static void a_grid_that_cannot_be_is_refused_and_writes_nothing(void **state)
{
    (void)state;
    struct run *r = run_default();
    struct run *pixels =
        run_with(LUM_COLUMN_BIT(LUM_COLUMN_PIXEL), LUM_EDGES_RISING);
    static uint32_t cells[LUM_LINE_PIXELS];
    static float floats[LUM_LINE_PIXELS];
    cells[0] = 7;
    floats[0] = 7.0f;
    send_frame(r);
    end(r);
    send_frame(pixels);
    end(pixels);
    assert_false(lum_frame_grid_index(r->frames[0], 0, 1, 1, cells));
    assert_false(lum_frame_grid_index(pixels->frames[0], 2, 1, 1, cells));
    assert_false(lum_frame_grid_index(pixels->frames[0], 0, 1, 0, cells));
    assert_false(lum_frame_grid_floats(pixels->frames[0], LUM_COLUMN_X, 0, 1, 1,
                                       floats));
    assert_false(lum_frame_grid_floats(pixels->frames[0], LUM_COLUMN_COUNT, 0,
                                       1, 1, floats));
    assert_int_equal(cells[0], 7);
    assert_true(floats[0] > 6.0f);
    assert_true(lum_frame_grid_index(pixels->frames[0], 0, 0, 1, cells));
    assert_int_equal(cells[0], 7);
    assert_true(lum_frame_grid_index(pixels->frames[0], 0, 1, 1, cells));
    assert_int_equal(cells[999], cells[0] + 999u);
    run_free(r);
    run_free(pixels);
}

static void points_beyond_the_maximum_are_cut_and_counted(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .points_max = 4500};
    struct run *r = run_new(&options);
    send_frame(r);
    send_frame(r);
    end(r);
    for (size_t i = 0; i < 2; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        lum_frame_line row = {.struct_size = sizeof row};
        assert_int_equal(lum_frame_count(r->frames[i]), 4500);
        assert_int_equal(info.points_cut, ALL_POINTS - 4500u);
        assert_false(info.is_complete);
        assert_true(lum_frame_get_line(r->frames[i], 4, &row));
        assert_int_equal(row.point_count, 500);
        assert_true(lum_frame_get_line(r->frames[i], 5, &row));
        assert_int_equal(row.first_point, 4500);
        assert_int_equal(row.point_count, 0);
        assert_false(lum_frame_get_line(r->frames[i], 2u * LINES, &row));
    }
    assert_int_equal(counters_of(r, 0).points_cut, 2u * (ALL_POINTS - 4500u));
    run_free(r);
}

/* As points are, and late ones. */
static void points_cut_are_counted_of_the_first_view(void **state)
{
    (void)state;
    lum_view views[2];
    lum_view_default(&views[0]);
    lum_view_default(&views[1]);
    views[1].selection.edges = LUM_EDGES_BOTH;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .views = views,
                                        .view_count = 2,
                                        .points_max = 4500};
    struct run *r = run_new(&options);
    send_frame(r);
    end(r);
    const lum_framer_counters c = counters_of(r, 0);
    assert_int_equal(c.points_cut, ALL_POINTS - 4500u);
    assert_int_equal(lum_frame_count(r->frames[0]) + c.points_cut, c.points);
    run_free(r);
}

/* With any line numbers of a stream, the table of lines stays small. */
static void lines_beyond_the_maximum_are_cut_and_counted(void **state)
{
    (void)state;
    struct run *r = run_with(LUM_COLUMN_BIT(LUM_COLUMN_X), LUM_EDGES_RISING);
    const uint32_t most = LUM_FRAME_LINES_MAX / 2u;
    for (uint32_t line = 0; line < most + 100u; line++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            const bool is_whole = line + 1u == most || line == most + 50u;
            drive_pixels(&r->line, eye, line, r->clock, 0, 3);
            r->line.count = is_whole ? r->line.count : 2; /* tell the frame */
            push_line(r, DRIVE_SENSOR);
        }
        r->clock += 10;
    }
    end(r);
    assert_int_equal(r->count, 1);
    assert_int_equal(lum_frame_count(r->frames[0]), 6);
    assert_int_equal(info_of(r->frames[0]).points_cut, 6);
    assert_int_equal(counters_of(r, 0).points_cut, 6);
    assert_int_equal(counters_of(r, 0).points, 12);
    assert_int_equal(lum_frame_line_count(r->frames[0]), LUM_FRAME_LINES_MAX);
    assert_int_equal(info_of(r->frames[0]).lines_cut, 200);
    assert_int_equal(counters_of(r, 0).lines_cut, 200);
    run_free(r);
}

static void a_damaged_line_number_makes_no_frame_large(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (unsigned i = 0; i < 3; i++) {
        if (i == 1) {
            drive_make(&r->line, LUM_EYE_BLUE, 60000, r->clock, NULL, 0);
            r->line.count = 1;
            push_line(r, DRIVE_SENSOR);
        }
        send_frame(r);
    }
    end(r);
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_int_equal(info.lines_missing[LUM_EYE_BLUE], 0);
        assert_int_equal(info.lines_missing[LUM_EYE_GREEN], 0);
    }
    run_free(r);
}

static void views_change_with_the_next_frame_that_begins(void **state)
{
    (void)state;
    struct run *r = run_default();
    lum_view views[2];
    lum_error error = {""};
    lum_view_default(&views[0]);
    lum_view_default(&views[1]);
    views[0].columns = LUM_COLUMN_BIT(LUM_COLUMN_RANGE);
    views[1].columns = LUM_COLUMN_BIT(LUM_COLUMN_EDGE);
    views[1].selection.edges = LUM_EDGES_FALLING;
    send_frame(r);
    assert_int_equal(lum_framer_set_views(r->framer, views, 2, &error), 0);
    send_frame(r);
    assert_int_equal(r->count, 1);
    assert_int_equal(lum_framer_set_views(r->framer, NULL, 0, &error), 0);
    send_frame(r);
    end(r);
    assert_int_equal(r->count, 3);
    assert_int_equal(lum_frame_columns(r->frames[0]), LUM_COLUMNS_XYZ);
    assert_int_equal(lum_frame_columns(r->frames[1]),
                     LUM_COLUMN_BIT(LUM_COLUMN_RANGE));
    assert_int_equal(lum_frame_columns(r->frames[2]), 0);
    assert_int_equal(lum_frame_count(r->frames[1]), ALL_POINTS);
    assert_int_equal(lum_frame_count(r->frames[2]), 0);
    assert_int_equal(lum_frame_line_count(r->frames[2]), 2u * LINES);
    assert_true(info_of(r->frames[2]).is_complete);
    run_free(r);
}

static void each_view_has_a_frame_of_its_own(void **state)
{
    (void)state;
    lum_view views[3];
    for (unsigned i = 0; i < 3; i++) {
        lum_view_default(&views[i]);
        views[i].columns = LUM_COLUMNS_ALL;
    }
    views[0].selection.edges = LUM_EDGES_BOTH;
    views[1].selection.edges = LUM_EDGES_FALLING;
    views[2].smooth_window = 31;
    views[2].smooth_order = LUM_SMOOTH_ORDER(31u);
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = views, .view_count = 3};
    struct run *r = run_new(&options);
    lum_framer_event event = LUM_FRAMER_NONE;
    for (uint32_t line = 0; line < LINES; line++) {
        send_returns(r, LUM_EYE_BLUE, line);
        r->clock += PERIOD_US;
    }
    while ((event = lum_framer_flush(r->framer)) != LUM_FRAMER_FRAME) {
        assert_int_not_equal(event, LUM_FRAMER_NONE);
    }
    const lum_frame *both = lum_framer_frame(r->framer, 0);
    const lum_frame *falling = lum_framer_frame(r->framer, 1);
    const lum_frame *smooth = lum_framer_frame(r->framer, 2);
    lum_view view = {.struct_size = sizeof view};
    assert_null(lum_framer_frame(r->framer, 3));
    assert_false(lum_framer_frame_view(r->framer, 3, &view));
    assert_true(lum_framer_frame_view(r->framer, 2, &view));
    assert_int_equal(view.smooth_window, 31);
    assert_true(lum_framer_frame_view(r->framer, 1, &view));
    assert_int_equal(view.selection.edges, LUM_EDGES_FALLING);
    assert_int_equal(lum_frame_count(both), LINES * 4000u);
    assert_int_equal(lum_frame_count(falling), LINES * 2000u);
    assert_int_equal(lum_frame_count(smooth), LINES * 2000u);
    for (size_t i = 0; i < lum_frame_count(falling); i++) {
        assert_int_equal(lum_frame_uint8s(falling, LUM_COLUMN_EDGE)[i], 0);
        /* a straight line stays one */
        assert_float_equal(lum_frame_floats(smooth, LUM_COLUMN_X)[i],
                           lum_frame_floats(both, LUM_COLUMN_X)[2u * i], 1e-3);
    }
    run_free(r);
}

static void frames_before_a_jump_are_passed_over_and_not_counted(void **state)
{
    (void)state;
    struct run *r = run_default();
    int64_t first = 0;
    int64_t last = 0;
    lum_framer_skip_to(r->framer, 3);
    for (unsigned i = 0; i < 4; i++) {
        send_frame(r);
    }
    end(r);
    assert_int_equal(r->count, 2);
    assert_int_equal(r->numbers[0], 3);
    assert_int_equal(r->numbers[1], 4);
    assert_int_equal(lum_frame_count(r->frames[0]), ALL_POINTS);
    assert_int_equal(counters_of(r, 0).points, 2u * ALL_POINTS);
    assert_int_equal(counters_of(r, 0).rising, 2u * ALL_POINTS);
    assert_true(lum_framer_range(r->framer, 0, &first, &last));
    assert_int_equal(first, 1);
    assert_int_equal(last, 4);
    assert_false(lum_framer_range(r->framer, 1, &first, &last));
    assert_false(lum_framer_range(r->framer, 99, &first, &last));
    run_free(r);
}

static void a_jump_drops_what_is_under_way(void **state)
{
    (void)state;
    struct run *r = run_default();
    send_rest(r, LINES / 2u);
    lum_framer_skip_to(r->framer, 2);
    send_frame(r);
    end(r);
    assert_int_equal(r->count, 1);
    assert_int_equal(r->numbers[0], 2);
    assert_int_equal(lum_frame_count(r->frames[0]), ALL_POINTS);
    run_free(r);
}

static void a_range_of_frames_and_one_eye_can_be_asked_for(void **state)
{
    (void)state;
    const lum_framer_options options = {
        .struct_size = sizeof options,
        .wants = LUM_WANT_FRAMES | LUM_WANT_LINES | LUM_WANT_FRAME_ENDS,
        .eyes = LUM_EYES_GREEN,
        .has_range = true,
        .frame_first = 2,
        .frame_last = 3};
    struct run *r = run_new(&options);
    for (unsigned i = 0; i < 4; i++) {
        send_frame(r);
    }
    end(r);
    assert_int_equal(r->count, 2);
    assert_int_equal(r->numbers[0], 2);
    assert_int_equal(lum_frame_count(r->frames[1]), ALL_POINTS / 2u);
    assert_int_equal(r->lines, 2u * LINES);
    assert_int_equal(r->line_points, ALL_POINTS);
    assert_int_equal(counters_of(r, 0).points, ALL_POINTS);
    assert_int_equal(counters_of(r, 0).rising, 4u * ALL_POINTS);
    assert_int_equal(counters_of(r, 0).lines[LUM_EYE_BLUE], 4u * LINES);
    assert_int_equal(counters_of(r, 0).frames, 2);
    assert_true(info_of(r->frames[0]).is_complete);
    assert_int_equal(r->end_count, 4);
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(r->ends[i], i + 1u);
    }
    run_free(r);
}

static void incomplete_lines_can_be_left_out(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .drop_incomplete = true};
    struct run *r = run_new(&options);
    for (uint32_t line = 0; line < LINES; line++) {
        send_without(r, LUM_EYE_BLUE, line, line == 3 ? 1 : SIZE_MAX);
        send_without(r, LUM_EYE_GREEN, line, line == 4 ? 4 : SIZE_MAX);
        r->clock += PERIOD_US;
    }
    end(r);
    assert_int_equal(lum_frame_count(r->frames[0]), ALL_POINTS - 2000u);
    assert_int_equal(info_of(r->frames[0]).lines_missing[LUM_EYE_BLUE], 1);
    assert_false(info_of(r->frames[0]).is_complete);
    run_free(r);
}

/* One eye runs through frames while the other holds the first one open. */
static void where_too_many_frames_are_open_the_lowest_comes_early(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .wants =
                                            LUM_WANT_FRAMES | LUM_WANT_LINES};
    struct run *r = run_new(&options);
    send(r, LUM_EYE_GREEN, 0);
    for (unsigned frame = 0; frame < 9; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            send(r, LUM_EYE_BLUE, line);
            r->clock += 100;
        }
        if (frame == 6) {
            send(r, LUM_EYE_GREEN, 1); /* of the first frame, which is out */
        }
    }
    end(r);
    uint64_t points = 0;
    uint64_t late = 0;
    assert_int_equal(r->count, 9);
    for (size_t i = 0; i < r->count; i++) {
        points += lum_frame_count(r->frames[i]);
        late += info_of(r->frames[i]).lines_late;
        assert_true(i == 0 || r->numbers[i] > r->numbers[i - 1u]);
    }
    const lum_framer_counters c = counters_of(r, 0);
    assert_true(c.lines_late > 0);
    assert_int_equal(c.points_late, 1000u * c.lines_late);
    assert_int_equal(late, c.lines_late);
    assert_int_equal(r->lines, 9u * LINES + 2u);
    assert_int_equal(points + c.points_late, r->line_points);
    run_free(r);
}

static void sixteen_sensors_have_frames_of_their_own(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (unsigned frame = 0; frame < 2; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            drive_pixels(&r->line, LUM_EYE_BLUE, line, r->clock, 0, 1000);
            for (uint32_t s = 0; s < LUM_DEMUX_SENSORS_MAX; s++) {
                push_line(r, DRIVE_SENSOR + s);
            }
            r->clock += PERIOD_US;
        }
    }
    end(r);
    unsigned seen[LUM_DEMUX_SENSORS_MAX] = {0};
    assert_int_equal(r->count, 2u * LUM_DEMUX_SENSORS_MAX);
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_int_equal(lum_frame_count(r->frames[i]), LINES * 1000u);
        assert_true(info.is_complete);
        seen[info.sensor - DRIVE_SENSOR]++;
    }
    for (size_t s = 0; s < LUM_DEMUX_SENSORS_MAX; s++) {
        assert_int_equal(seen[s], 2);
        assert_int_equal(counters_of(r, s).points, 2000u * LINES);
    }
    assert_int_equal(counters_of(r, 99).points, 0);
    run_free(r);
}

static void of_the_first_sensor_alone_frames_are_made(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .only_first = true};
    struct run *r = run_new(&options);
    lum_demux_counters total = {.struct_size = sizeof total};
    for (uint32_t line = 0; line < LINES; line++) {
        drive_pixels(&r->line, LUM_EYE_BLUE, line, r->clock, 0, 1000);
        push_line(r, DRIVE_SENSOR + 5u);
        push_line(r, DRIVE_SENSOR);
        r->clock += PERIOD_US;
    }
    end(r);
    lum_demux_total(lum_framer_demux(r->framer), &total);
    assert_int_equal(r->count, 1);
    assert_int_equal(info_of(r->frames[0]).sensor, DRIVE_SENSOR + 5u);
    assert_int_equal(total.assembly.lines, 2u * LINES);
    run_free(r);
}

/* One step of a stream that does all that a network can do to it. */
static void send_badly(struct run *r, unsigned eye, uint32_t line,
                       uint64_t *random)
{
    drive_pixels(&r->line, eye, line, r->clock, next_random(random) % 500u,
                 next_random(random) % 500u);
    for (size_t i = 0; i < r->line.count; i++) {
        const uint32_t chance = next_random(random) % 100u;
        const size_t packet =
            chance < 20u ? next_random(random) % r->line.count : i;
        const lum_record record =
            drive_record(&r->line, packet, DRIVE_SENSOR, r->time_ns++);
        if (chance >= 5u) {
            push(r, &record);
        }
        if (chance > 95u) {
            push(r, &record);
        }
    }
}

/* With any input: every line that the assembler hands out is in one frame, or
 * is counted as late; every point of it is in that frame. */
static void assert_all_counted(const struct run *r)
{
    const lum_framer_counters c = counters_of(r, 0);
    uint64_t points = 0;
    uint64_t lines = 0;
    uint64_t late = 0;
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        points += lum_frame_count(r->frames[i]);
        lines += lum_frame_line_count(r->frames[i]);
        late += info.lines_late;
        assert_int_equal(info.lines[0] + info.lines[1],
                         lum_frame_line_count(r->frames[i]));
        assert_true(i == 0 || r->numbers[i] > r->numbers[i - 1u]);
    }
    assert_int_equal(lines + c.lines_late, r->lines);
    assert_true(late <= c.lines_late);
    assert_int_equal(c.points, r->line_points);
    assert_int_equal(points + c.points_late, r->line_points);
}

static void nothing_is_lost_that_is_not_counted(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        uint64_t random = seed;
        const lum_framer_options options = {
            .struct_size = sizeof options,
            .wants = LUM_WANT_FRAMES | LUM_WANT_LINES | LUM_WANT_FRAME_ENDS};
        struct run *r = run_new(&options);
        for (unsigned i = 0; i < 400; i++) {
            const uint32_t chance = next_random(&random) % 200u;
            const uint32_t line =
                chance == 0 ? next_random(&random) % 60000u : i % LINES;
            r->clock += chance == 1 ? 3000000u : 0u;
            r->clock -= chance == 2 ? 2000000u : 0u;
            send_badly(r, i / 2u % LUM_EYES, line, &random);
            r->clock += PERIOD_US / 2u;
        }
        end(r);
        assert_all_counted(r);
        run_free(r);
    }
}

static void frames_that_are_kept_outlive_their_framer(void **state)
{
    (void)state;
    struct run *r = run_default();
    send_frame(r);
    send_frame(r);
    end(r);
    lum_frame *kept = lum_frame_keep(r->frames[0]);
    run_free(r);
    assert_int_equal(lum_frame_count(kept), ALL_POINTS);
    assert_true(lum_frame_floats(kept, LUM_COLUMN_X)[ALL_POINTS - 1u] > 1.0f);
    lum_frame_release(kept);
    lum_frame_release(NULL);
}

static void rates_and_what_was_under_way_are_told(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (unsigned i = 0; i < 5; i++) {
        for (uint32_t line = i == 0 ? 9 : 0; line < LINES; line++) {
            send_without(r, LUM_EYE_BLUE, line,
                         i == 0 && line == 9 ? 0 : SIZE_MAX);
            send(r, LUM_EYE_GREEN, line);
            r->clock += PERIOD_US;
            r->time_ns = INT64_C(1000) * r->clock;
        }
    }
    end(r);
    const lum_framer_counters c = counters_of(r, 0);
    assert_float_equal(c.frames_per_second, 50.0, 0.5);
    assert_int_equal(c.under_way.lines, 1);
    assert_int_equal(c.under_way.no_angle, 334);
    assert_int_equal(c.losses.no_angle, 334);
    run_free(r);
}

/* After a flush the stream is joined again. */
static void what_was_under_way_at_each_join_is_no_loss(void **state)
{
    (void)state;
    struct run *r = run_default();
    for (unsigned i = 0; i < 2; i++) {
        send_without(r, LUM_EYE_BLUE, 9, 0);
        r->clock += PERIOD_US;
        for (uint32_t line = 10; line < LINES; line++) {
            send_without(r, LUM_EYE_BLUE, line, line == 12 ? 1 : SIZE_MAX);
            r->clock += PERIOD_US;
        }
        end(r);
    }
    const lum_framer_counters c = counters_of(r, 0);
    assert_int_equal(r->count, 2);
    assert_true(info_of(r->frames[0]).is_first);
    assert_true(info_of(r->frames[1]).is_first);
    assert_int_equal(c.losses.no_angle, 4u * 334u);
    assert_int_equal(c.under_way.no_angle, 2u * 334u);
    assert_int_equal(c.under_way.lines, 2);
    run_free(r);
}

/* A caller of an older library knows less of the structs. */
static void smaller_structs_of_older_callers_are_filled_no_further(void **state)
{
    (void)state;
    struct run *r = run_default();
    lum_frame_info info;
    lum_frame_line row;
    lum_framer_counters counters;
    send_frame(r);
    end(r);
    memset(&info, 0x5a, sizeof info);
    memset(&row, 0x5a, sizeof row);
    memset(&counters, 0x5a, sizeof counters);
    info.struct_size = offsetof(lum_frame_info, sensor);
    row.struct_size = offsetof(lum_frame_line, arrival_ns);
    counters.struct_size = offsetof(lum_framer_counters, rising);
    assert_int_equal(lum_frame_get_info(r->frames[0], &info), LUM_OK);
    assert_true(lum_frame_get_line(r->frames[0], 0, &row));
    assert_int_equal(lum_framer_count(r->framer, 0, &counters), LUM_OK);
    assert_int_equal(info.struct_size, offsetof(lum_frame_info, sensor));
    assert_int_equal(info.number, 1);
    assert_int_equal(info.sensor, 0x5a5a5a5a);
    assert_int_equal(row.clock_us, 1000000);
    assert_int_equal(row.number, 0x5a5a5a5a);
    assert_int_equal(counters.lines[0], LINES);
    assert_int_equal(counters.rising, 0x5a5a5a5a5a5a5a5a);
    run_free(r);
}

/* A caller who forgot the size would go on with what was there before. */
static void a_struct_without_its_size_is_refused(void **state)
{
    (void)state;
    struct run *r = run_default();
    lum_frame_info info;
    lum_frame_line row;
    lum_framer_counters counters;
    lum_view view;
    send_frame(r);
    assert_int_equal(r->count, 0);
    end(r);
    for (size_t size = 0; size <= sizeof size; size += sizeof size) {
        memset(&info, 0x5a, sizeof info);
        memset(&row, 0x5a, sizeof row);
        memset(&counters, 0x5a, sizeof counters);
        memset(&view, 0x5a, sizeof view);
        info.struct_size = size;
        row.struct_size = size;
        counters.struct_size = size;
        view.struct_size = size;
        assert_int_equal(lum_frame_get_info(r->frames[0], &info), LUM_E_VALUE);
        assert_false(lum_frame_get_line(r->frames[0], 0, &row));
        assert_int_equal(lum_framer_count(r->framer, 0, &counters),
                         LUM_E_VALUE);
        assert_false(lum_framer_frame_view(r->framer, 0, &view));
        assert_int_equal(info.sensor, 0x5a5a5a5a);
        assert_int_equal(row.number, 0x5a5a5a5a);
        assert_int_equal(counters.points, 0x5a5a5a5a5a5a5a5a);
        assert_int_equal(view.smooth_window, 0x5a5a5a5a);
    }
    info.struct_size = sizeof info;
    counters.struct_size = sizeof counters;
    assert_int_equal(lum_frame_get_info(r->frames[0], &info), LUM_OK);
    assert_int_equal(lum_framer_count(r->framer, 0, &counters), LUM_OK);
    run_free(r);
}

static void assert_refused(const lum_framer_options *options, const char *part)
{
    lum_framer *framer = (lum_framer *)(uintptr_t)1;
    lum_error error = {""};
    assert_int_equal(lum_framer_new(options, &framer, &error), -1);
    assert_null(framer);
    if (strstr(error.text, part) == NULL) {
        fail_msg("'%s' is not in: %s", part, error.text);
    }
}

static void options_that_cannot_be_are_refused_with_their_reason(void **state)
{
    (void)state;
    lum_view views[LUM_VIEWS_MAX + 1u];
    lum_calibration calibration;
    lum_assembler_config config;
    lum_framer_options o = {.struct_size = 0};
    assert_refused(&o, "struct_size of the framer's options is not set; set it "
                       "to sizeof(lum_framer_options)");
    o.struct_size = sizeof o;
    for (unsigned i = 0; i <= LUM_VIEWS_MAX; i++) {
        lum_view_default(&views[i]);
    }
    o.views = views;
    o.view_count = LUM_VIEWS_MAX + 1u;
    assert_refused(&o, "at most 8");
    o.view_count = 2;
    views[1].smooth_window = 4;
    assert_refused(&o, "window 4");
    lum_view_default(&views[1]);
    views[1].columns = LUM_COLUMN_BIT(LUM_COLUMN_COUNT);
    assert_refused(&o, "columns");
    lum_view_default(&views[1]);
    views[1].selection.edges = (lum_edges)0;
    assert_refused(&o, "lum_view_default");
    lum_view_default(&views[1]);
    views[1].struct_size = 0;
    assert_refused(&o, "struct_size of a view is not set; set it to "
                       "sizeof(lum_view)");
    o.views = NULL;
    lum_calibration_default(&calibration);
    calibration.tof_lsb_fs = 0;
    o.calibration = &calibration;
    assert_refused(&o, "calibration");
    o.calibration = NULL;
    lum_assembler_config_default(&config);
    config.open_lines = 0;
    o.config = &config;
    assert_refused(&o, "reassembly");
}

/* Arrivals are 3 us a packet behind the clock, and sometimes a lot more. */
static void a_frame_tells_when_it_began_in_utc(void **state)
{
    (void)state;
    struct run *r = run_default();
    const int64_t zero_ns = r->time_ns - (int64_t)r->clock * 1000;
    for (uint32_t frame = 0; frame < 4; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            const int64_t late_ns = (line + 7 * frame) % 5 * 1000000;
            r->time_ns = zero_ns + (int64_t)r->clock * 1000 + late_ns;
            send(r, LUM_EYE_BLUE, line);
            send(r, LUM_EYE_GREEN, line);
            r->clock += PERIOD_US;
        }
    }
    end(r);
    assert_int_equal(r->count, 4);
    for (size_t i = 1; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        const int64_t truth_ns = zero_ns + info.times.begin_clock_us * 1000;
        assert_true(llabs(info.times.begin_utc_ns - truth_ns) < 20000);
        assert_true(info.times.utc_error_ns > 0);
    }
    lum_clock_time time;
    assert_non_null(lum_framer_clock(r->framer, 0));
    assert_int_equal(
        lum_clock_fit_utc(lum_framer_clock(r->framer, 0), r->clock, &time),
        LUM_OK);
    assert_null(lum_framer_clock(r->framer, 1));
    assert_null(lum_framer_clock(r->framer, SIZE_MAX));
    run_free(r);
}

static void a_frame_without_a_line_began_at_no_time(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .eyes = LUM_EYES_BLUE};
    struct run *r = run_new(&options);
    for (unsigned frame = 0; frame < 3; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            send(r, LUM_EYE_GREEN, line);
            r->clock += PERIOD_US;
            r->time_ns += PERIOD_US * 1000;
        }
    }
    end(r);
    assert_int_equal(r->count, 3);
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_int_equal(lum_frame_line_count(r->frames[i]), 0);
        assert_int_equal(info.times.begin_utc_ns, 0);
        assert_int_equal(info.times.utc_error_ns, 0);
    }
    run_free(r);
}

/* The first arrival is late, which one who knows the stream is not misled by.
 */
static void what_another_framer_learned_of_clocks_holds_at_once(void **state)
{
    (void)state;
    struct run *ahead = run_default();
    struct run *r = run_default();
    ahead->time_ns += 5000000;
    send(ahead, LUM_EYE_BLUE, 0);
    ahead->time_ns = r->time_ns;
    ahead->clock += PERIOD_US;
    ahead->time_ns += PERIOD_US * 1000;
    send_rest(ahead, 1);
    send_frame(ahead);
    assert_int_equal(lum_framer_learn_clocks(r->framer, ahead->framer), 0);
    const int64_t truth_ns = r->time_ns;
    r->time_ns += 5000000;
    send(r, LUM_EYE_BLUE, 0);
    end(r);
    assert_int_equal(r->count, 1);
    assert_true(llabs(info_of(r->frames[0]).times.begin_utc_ns - truth_ns) <
                100000);
    run_free(ahead);
    run_free(r);
}

/* Lines whose packets come when their clock says, which is 0 at zero_ns. */
static void send_frame_in_time(struct run *r, int64_t zero_ns)
{
    for (uint32_t line = 0; line < LINES; line++) {
        r->time_ns = zero_ns + (int64_t)r->clock * 1000;
        send(r, LUM_EYE_BLUE, line);
        send(r, LUM_EYE_GREEN, line);
        r->clock += PERIOD_US;
    }
}

/* A frame is complete only when lines of the next have come, and by then the
 * clock of a sensor that has restarted is another. */
static void a_frame_before_a_restart_keeps_its_utc(void **state)
{
    (void)state;
    struct run *r = run_default();
    r->clock = 500000000;
    const int64_t zero_ns = r->time_ns - (int64_t)r->clock * 1000;
    for (unsigned i = 0; i < 4; i++) {
        send_frame_in_time(r, zero_ns);
    }
    const int64_t zero_again_ns = r->time_ns + 2000000000;
    r->clock = 1000;
    for (unsigned i = 0; i < 4; i++) {
        send_frame_in_time(r, zero_again_ns);
    }
    end(r);
    assert_int_equal(r->count, 8);
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_true(llabs(info.times.begin_utc_ns -
                          info.times.begin_arrival_ns) < 20000);
    }
    run_free(r);
}

/* Likewise where the host's clock is stepped back. */
static void a_frame_before_a_step_keeps_its_utc(void **state)
{
    (void)state;
    struct run *r = run_default();
    const int64_t zero_ns = r->time_ns - (int64_t)r->clock * 1000;
    for (unsigned i = 0; i < 4; i++) {
        send_frame_in_time(r, zero_ns);
    }
    for (unsigned i = 0; i < 4; i++) {
        send_frame_in_time(r, zero_ns - 2000000000);
    }
    end(r);
    assert_int_equal(r->count, 8);
    for (size_t i = 0; i < r->count; i++) {
        const lum_frame_info info = info_of(r->frames[i]);
        assert_true(llabs(info.times.begin_utc_ns -
                          info.times.begin_arrival_ns) < 20000);
    }
    run_free(r);
}

static void views_that_cannot_be_change_nothing(void **state)
{
    (void)state;
    struct run *r = run_default();
    lum_view view;
    lum_error error = {""};
    lum_view_default(&view);
    view.columns = UINT32_MAX;
    assert_int_equal(lum_framer_set_views(r->framer, &view, 1, &error), -1);
    send_frame(r);
    end(r);
    assert_int_equal(lum_frame_columns(r->frames[0]), LUM_COLUMNS_XYZ);
    run_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_last_frame_comes_with_the_flush),
        cmocka_unit_test(after_a_flush_frames_come_again),
        cmocka_unit_test(a_frame_has_the_points_of_its_lines_in_their_order),
        cmocka_unit_test(
            columns_are_aligned_and_only_those_that_were_asked_for),
        cmocka_unit_test(x_y_and_z_are_rows_of_one_block),
        cmocka_unit_test(a_frame_without_points_has_rows_too),
        cmocka_unit_test(every_column_is_filled_for_every_point),
        cmocka_unit_test(times_run_through_lines_and_frames),
        cmocka_unit_test(a_line_that_lacks_is_missing_by_eye),
        cmocka_unit_test(two_sweeps_that_became_one_frame_are_not_complete),
        cmocka_unit_test(a_first_frame_whose_end_a_pause_took_is_not_complete),
        cmocka_unit_test(an_eye_that_pauses_makes_its_frames_incomplete),
        cmocka_unit_test(lines_before_the_first_word_are_dark),
        cmocka_unit_test(what_frames_lack_is_counted_also_where_none_is_made),
        cmocka_unit_test(
            a_frame_that_was_joined_or_left_in_the_middle_is_not_complete),
        cmocka_unit_test(a_last_line_in_part_is_no_missing_one),
        cmocka_unit_test(losses_are_told_by_cause),
        cmocka_unit_test(a_grid_has_each_point_at_its_place_and_marks_the_rest),
        cmocka_unit_test(rows_are_those_that_can_be_believed),
        cmocka_unit_test(a_grid_that_cannot_be_is_refused_and_writes_nothing),
        cmocka_unit_test(points_beyond_the_maximum_are_cut_and_counted),
        cmocka_unit_test(points_cut_are_counted_of_the_first_view),
        cmocka_unit_test(lines_beyond_the_maximum_are_cut_and_counted),
        cmocka_unit_test(a_damaged_line_number_makes_no_frame_large),
        cmocka_unit_test(views_change_with_the_next_frame_that_begins),
        cmocka_unit_test(each_view_has_a_frame_of_its_own),
        cmocka_unit_test(frames_before_a_jump_are_passed_over_and_not_counted),
        cmocka_unit_test(a_jump_drops_what_is_under_way),
        cmocka_unit_test(a_range_of_frames_and_one_eye_can_be_asked_for),
        cmocka_unit_test(incomplete_lines_can_be_left_out),
        cmocka_unit_test(where_too_many_frames_are_open_the_lowest_comes_early),
        cmocka_unit_test(sixteen_sensors_have_frames_of_their_own),
        cmocka_unit_test(of_the_first_sensor_alone_frames_are_made),
        cmocka_unit_test(nothing_is_lost_that_is_not_counted),
        cmocka_unit_test(frames_that_are_kept_outlive_their_framer),
        cmocka_unit_test(rates_and_what_was_under_way_are_told),
        cmocka_unit_test(what_was_under_way_at_each_join_is_no_loss),
        cmocka_unit_test(
            smaller_structs_of_older_callers_are_filled_no_further),
        cmocka_unit_test(a_struct_without_its_size_is_refused),
        cmocka_unit_test(options_that_cannot_be_are_refused_with_their_reason),
        cmocka_unit_test(a_frame_tells_when_it_began_in_utc),
        cmocka_unit_test(a_frame_without_a_line_began_at_no_time),
        cmocka_unit_test(a_frame_before_a_restart_keeps_its_utc),
        cmocka_unit_test(a_frame_before_a_step_keeps_its_utc),
        cmocka_unit_test(what_another_framer_learned_of_clocks_holds_at_once),
        cmocka_unit_test(views_that_cannot_be_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
