#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "points/columns.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WORDS  2600u
#define ROUNDS 40u

/* A line of any kind, its samples, and its columns. */
struct scene {
    lum_calibration calibration;
    lum_projector projector;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS + 1u];
    lum_return returns[WORDS + 1u];
    lum_sample_workspace workspace;
    lum_sample samples[WORDS];
    size_t count;
    lum_return work_returns[WORDS + 1u];
    lum_sample work_samples[WORDS];
    uint8_t work_strongest[WORDS + 1u];
    lum_column_work work;
    float floats[7][WORDS + 1u];
    uint16_t shorts[3][WORDS + 1u];
    uint8_t bytes[2][WORDS + 1u];
    uint8_t strongest[WORDS]; /* with all columns */
};

static struct scene *scene_new(void)
{
    struct scene *s = calloc(1, sizeof *s);
    lum_layout layout;
    assert_non_null(s);
    lum_layout_default(&layout);
    lum_calibration_default(&s->calibration);
    s->calibration.eye[1].tof_offset_fs = -12345678;
    s->calibration.eye[1].mount_um[0] = -7654321;
    s->calibration.eye[1].mount_um[1] = 2345678;
    s->calibration.eye[1].mount_um[2] = 1234567;
    s->calibration.eye[1].azimuth_width_udeg -= 7654321;
    s->calibration.eye[1].elevation_min_udeg += 1234567;
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    s->workspace.returns = s->returns;
    s->work.samples.returns = s->work_returns;
    s->work.sample = s->work_samples;
    s->work.strongest = s->work_strongest;
    return s;
}

enum losses {
    NONE,
    SOME
};

/* Up to six words a pixel; with losses some pixels have no angles and some
 * words no range. */
static void make_line(struct scene *s, unsigned eye, enum losses losses,
                      uint64_t *random)
{
    uint32_t n = 0;
    memset(s->marks, 0xff, sizeof s->marks);
    s->line = (lum_line){.angles = s->angles,
                         .angle_marks = s->marks,
                         .words = s->words,
                         .number = 7,
                         .angle_count = LUM_LINE_PIXELS,
                         .eye = (uint8_t)eye};
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        s->angles[pixel] = (lum_angle){(int16_t)(pixel * 60u - 30000u),
                                       (int16_t)(next_random(random) % 2000u)};
        if (losses == SOME && next_random(random) % 50u == 0) {
            s->marks[pixel / 32u] &= ~(UINT32_C(1) << pixel % 32u);
            s->line.angle_count--;
        }
        const uint32_t words = next_random(random) % 6u;
        for (uint32_t k = 0; k < words && n < WORDS; k++) {
            const uint32_t r = next_random(random);
            const int32_t least = lum_calibration_min_tof(&s->calibration, eye);
            const int32_t tof = losses == SOME && r % 20u == 0
                                    ? least - (int32_t)(r >> 8 & 1u)
                                    : (int32_t)(1000u + r % 300000u);
            s->words[n++] = lum_word_make(tof, r >> 20 & 1u, pixel);
        }
    }
    s->words[n] = s->words[n - 1u]; /* not of the line */
    s->line.word_count = n;
}

static void look_for(struct scene *s, const lum_selection *selection)
{
    lum_point_losses losses = {0, 0};
    s->count = lum_samples_compute(&s->projector, &s->line, selection,
                                   &s->workspace, s->samples, &losses);
}

/* Nothing of another line is left that could serve. */
static void begin(struct scene *s)
{
    memset(s->work_returns, 0x7f, sizeof s->work_returns);
    memset(s->work_samples, 0xff, sizeof s->work_samples);
    memset(s->work_strongest, 0xff, sizeof s->work_strongest);
    memset(s->work.samples.directions, 0xff, sizeof s->work.samples.directions);
    memset(s->work.azimuth, 0xff, sizeof s->work.azimuth);
    memset(s->work.elevation, 0xff, sizeof s->work.elevation);
    lum_column_work_begin(&s->work);
}

/* Every column that has its bit. */
static lum_column_places places_of(struct scene *s, unsigned mask)
{
    lum_column_places p = {.x = NULL};
    memset(s->floats, 0xee, sizeof s->floats);
    memset(s->shorts, 0xee, sizeof s->shorts);
    memset(s->bytes, 0xee, sizeof s->bytes);
    float **floats[] = {&p.x,       &p.y,         &p.z,          &p.range,
                        &p.azimuth, &p.elevation, &p.pulse_width};
    for (unsigned i = 0; i < 7; i++) {
        *floats[i] = (mask >> i & 1u) != 0 ? s->floats[i] : NULL;
    }
    p.pixel = (mask >> 7 & 1u) != 0 ? s->shorts[0] : NULL;
    p.return_number = (mask >> 8 & 1u) != 0 ? s->shorts[1] : NULL;
    p.number_of_returns = (mask >> 9 & 1u) != 0 ? s->shorts[2] : NULL;
    p.edge = (mask >> 10 & 1u) != 0 ? s->bytes[0] : NULL;
    p.strongest = (mask >> 11 & 1u) != 0 ? s->bytes[1] : NULL;
    return p;
}

#define MASK_ALL 0xfffu

/* Processors that compute floats more precisely may round twice. */
static void assert_same(float a, float b)
{
    if (FLT_EVAL_METHOD == 0) {
        assert_memory_equal(&a, &b, sizeof a);
    } else {
        assert_true(fabsf(a - b) <= 1e-5f * (1.0f + fabsf(b)));
    }
}

static void assert_floats(const struct scene *s, unsigned mask, size_t i)
{
    const lum_sample *p = &s->samples[i];
    const float wanted[] = {p->x,       p->y,         p->z,          p->range,
                            p->azimuth, p->elevation, p->pulse_width};
    for (unsigned c = 0; c < 7; c++) {
        if ((mask >> c & 1u) != 0) {
            assert_same(s->floats[c][i], wanted[c]);
        }
    }
}

static void assert_integers(const struct scene *s, unsigned mask, size_t i)
{
    const lum_sample *p = &s->samples[i];
    if ((mask >> 7 & 1u) != 0) {
        assert_int_equal(s->shorts[0][i], p->pixel);
    }
    if ((mask >> 8 & 1u) != 0) {
        assert_int_equal(s->shorts[1][i], p->return_number);
    }
    if ((mask >> 9 & 1u) != 0) {
        assert_int_equal(s->shorts[2][i], p->number_of_returns);
    }
    if ((mask >> 10 & 1u) != 0) {
        assert_int_equal(s->bytes[0][i], p->edge);
    }
    if ((mask >> 11 & 1u) != 0) {
        assert_int_equal(s->bytes[1][i], s->strongest[i]);
    }
}

static void compute(struct scene *s, const lum_selection *selection,
                    unsigned mask)
{
    const lum_column_places places = places_of(s, mask);
    lum_point_losses losses = {0, 0};
    lum_column_line line = {.projector = &s->projector, .line = &s->line};
    lum_points_count(&s->projector, &s->line, &line.rising, &line.falling,
                     &losses);
    assert_int_equal(lum_columns_compute(&line, selection, &s->work, &places),
                     s->count);
}

/* Behind the points of a line there may be those of another already. */
static void assert_end(const struct scene *s)
{
    const size_t end = s->count;
    uint32_t untouched;
    memset(&untouched, 0xee, sizeof untouched);
    for (unsigned c = 0; c < 7; c++) {
        assert_memory_equal(&s->floats[c][end], &untouched, sizeof(float));
    }
    for (unsigned c = 0; c < 3; c++) {
        assert_memory_equal(&s->shorts[c][end], &untouched, sizeof(uint16_t));
    }
    for (unsigned c = 0; c < 2; c++) {
        assert_memory_equal(&s->bytes[c][end], &untouched, 1);
    }
}

static void check(struct scene *s, const lum_selection *selection,
                  unsigned mask)
{
    compute(s, selection, mask);
    assert_end(s);
    for (size_t i = 0; i < s->count; i++) {
        assert_floats(s, mask, i);
        assert_integers(s, mask, i);
    }
}

/* Each column alone, several, all; also one after another for one line, where
 * results of one mask are used for the next. */
static void check_masks(struct scene *s, const lum_selection *selection,
                        uint64_t *random)
{
    look_for(s, selection);
    begin(s);
    compute(s, selection, MASK_ALL);
    memcpy(s->strongest, s->bytes[1], s->count);
    for (unsigned c = 0; c < 12; c++) {
        begin(s);
        check(s, selection, 1u << c);
    }
    begin(s);
    check(s, selection, MASK_ALL);
    check(s, selection, 0x7);
    begin(s);
    for (unsigned i = 0; i < 4; i++) {
        check(s, selection, next_random(random) & MASK_ALL);
    }
}

static void each_column_is_what_samples_say_in_any_company(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 1;
    for (unsigned round = 0; round < ROUNDS; round++) {
        make_line(s, round % 2u, round % 4u < 2 ? NONE : SOME, &random);
        for (unsigned edges = LUM_EDGES_RISING; edges <= LUM_EDGES_BOTH;
             edges++) {
            lum_selection selection;
            lum_selection_default(&selection);
            selection.edges = (lum_edges)edges;
            check_masks(s, &selection, &random);
        }
    }
    free(s);
}

static void choices_of_returns_and_limits_hold_in_columns(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 2;
    for (unsigned round = 0; round < ROUNDS; round++) {
        lum_selection selection = {
            .edges = (lum_edges)(1u + round % 3u),
            .returns = (lum_return_choice)(round % 5u),
            .return_number = 2,
            .has_range = round % 2u != 0,
            .range_min = 20.0f,
            .range_max = 300.0f,
            .has_box = round % 3u == 0,
            .box_min = {10.0f, -100.0f, -50.0f},
            .box_max = {400.0f, 100.0f, 50.0f},
        };
        make_line(s, round % 2u, SOME, &random);
        check_masks(s, &selection, &random);
    }
    free(s);
}

/* The column marks those points that a selection of the strongest keeps. */
static void assert_strongest(struct scene *s, const lum_selection *selection)
{
    lum_selection strongest = *selection;
    size_t at = 0;
    look_for(s, selection);
    begin(s);
    compute(s, selection, MASK_ALL);
    strongest.returns = LUM_RETURNS_STRONGEST;
    look_for(s, &strongest);
    for (size_t i = 0; i < s->count; i++) {
        const lum_sample *p = &s->samples[i];
        while (s->bytes[1][at] == 0) {
            at++;
        }
        assert_int_equal(s->bytes[1][at], 1);
        assert_int_equal(s->shorts[0][at], p->pixel);
        assert_int_equal(s->shorts[1][at], p->return_number);
        assert_int_equal(s->bytes[0][at], p->edge);
        at++;
    }
}

static void the_strongest_are_marked_as_a_selection_chooses_them(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 3;
    lum_selection selection;
    lum_selection_default(&selection);
    selection.edges = LUM_EDGES_BOTH;
    for (unsigned round = 0; round < ROUNDS; round++) {
        make_line(s, round % 2u, NONE, &random);
        selection.has_range = round % 2u != 0;
        selection.range_min = 100.0f;
        selection.range_max = 1000.0f;
        assert_strongest(s, &selection);
    }
    free(s);
}

static void the_widest_of_three_is_marked_wherever_it_is(void **state)
{
    static const int32_t widths[][3] = {{10, 30, 20}, {30, 20, 25},
                                        {10, 20, 30}, {20, 20, 10},
                                        {10, 30, 30}, {20, 10, 30}};
    static const unsigned widest[] = {1, 0, 2, 0, 1, 2};
    struct scene *s = scene_new();
    lum_selection selection;
    uint64_t random = 5;
    (void)state;
    lum_selection_default(&selection);
    make_line(s, 0, NONE, &random);
    for (unsigned i = 0; i < sizeof widest / sizeof widest[0]; i++) {
        uint32_t *w = &s->words[6u * i];
        for (unsigned k = 0; k < 3; k++) {
            const int32_t tof = 2000 + 100 * (int32_t)k;
            w[2u * k] = lum_word_make(tof, true, i);
            w[2u * k + 1u] = lum_word_make(tof + widths[i][k], false, i);
        }
    }
    s->line.word_count = 6u * sizeof widest / sizeof widest[0];
    look_for(s, &selection);
    begin(s);
    compute(s, &selection, MASK_ALL);
    for (size_t i = 0; i < s->count; i++) {
        assert_int_equal(s->bytes[1][i], widest[i / 3u] == i % 3u);
    }
    assert_int_equal(s->count, s->line.word_count / 2u);
    free(s);
}

/* Words that are left out of a block move the marks of those after them. */
static void marks_stay_with_their_points_where_others_are_lost(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 5;
    lum_selection selection;
    lum_selection_default(&selection);
    for (unsigned edges = LUM_EDGES_RISING; edges < LUM_EDGES_BOTH; edges++) {
        selection.edges = (lum_edges)edges;
        for (unsigned round = 0; round < ROUNDS; round++) {
            make_line(s, round % 2u, NONE, &random);
            assert_strongest(s, &selection);
        }
    }
    free(s);
}

/* Around the words that are worked on at a time, and their multiples. */
static void lines_of_any_length_hold_in_columns(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1,   2,   3,    4,    5,    511,
                                      512, 513, 1023, 1024, 1025, 1535};
    struct scene *s = scene_new();
    uint64_t random = 7;
    lum_selection selection;
    lum_selection_default(&selection);
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        for (unsigned edges = LUM_EDGES_RISING; edges <= LUM_EDGES_BOTH;
             edges++) {
            make_line(s, i % 2u, NONE, &random);
            assert_true(counts[i] < s->line.word_count);
            s->line.word_count = counts[i];
            selection.edges = (lum_edges)edges;
            check_masks(s, &selection, &random);
        }
    }
    free(s);
}

/* So that all but one word give a point, or as many as the line's number. */
static void a_single_word_that_gives_no_point_is_left_out(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 8;
    lum_selection selection;
    lum_selection_default(&selection);
    for (unsigned rising = 0; rising < 2; rising++) {
        make_line(s, 0, NONE, &random);
        for (uint32_t i = 0; i < s->line.word_count; i++) {
            const bool is_odd = i == s->line.word_count / 2u;
            s->words[i] = lum_word_make(lum_word_tof(s->words[i]),
                                        (rising != 0) != is_odd,
                                        lum_word_pixel(s->words[i]));
        }
        for (unsigned edges = LUM_EDGES_RISING; edges <= LUM_EDGES_FALLING;
             edges++) {
            selection.edges = (lum_edges)edges;
            look_for(s, &selection);
            s->line.number = (uint32_t)s->count;
            check_masks(s, &selection, &random);
        }
    }
    free(s);
}

static void a_line_that_lacks_one_pixel_s_angles_lacks_its_points(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 9;
    lum_selection selection;
    lum_selection_default(&selection);
    make_line(s, 0, NONE, &random);
    s->marks[500 / 32] &= ~(UINT32_C(1) << 500 % 32);
    s->line.angle_count--;
    for (unsigned edges = LUM_EDGES_RISING; edges <= LUM_EDGES_BOTH; edges++) {
        selection.edges = (lum_edges)edges;
        look_for(s, &selection);
        assert_true(s->count < s->line.word_count);
        check_masks(s, &selection, &random);
    }
    free(s);
}

/* With so large a limit, a word of the time before it is nearer to it, as a
 * number, than the limit's share of a word's lower 12 bits. */
static void a_range_below_zero_gives_no_point_whatever_its_pixel(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 10;
    lum_selection selection;
    lum_layout layout;
    lum_layout_default(&layout);
    lum_selection_default(&selection);
    selection.edges = LUM_EDGES_BOTH;
    s->calibration.eye[0].tof_offset_fs =
        -4000 * (int64_t)s->calibration.tof_lsb_fs;
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    const int32_t least = lum_calibration_min_tof(&s->calibration, 0);
    assert_int_equal(least, 4001);
    make_line(s, 0, NONE, &random);
    for (uint32_t i = 0; i < s->line.word_count; i++) {
        const uint32_t pixel = lum_word_pixel(s->words[i]);
        const int32_t tof = least - (pixel % 2u == 0 ? 1 : 0);
        s->words[i] = lum_word_make(tof, true, pixel);
    }
    look_for(s, &selection);
    assert_in_range(s->count, 1, s->line.word_count - 1u);
    check_masks(s, &selection, &random);
    free(s);
}

static void what_is_not_asked_for_is_not_worked_out(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 9;
    lum_selection selection;
    lum_selection_default(&selection);
    make_line(s, 0, NONE, &random);
    look_for(s, &selection);
    for (unsigned c = 0; c < 12; c++) {
        begin(s);
        compute(s, &selection, 1u << c);
        assert_int_equal(s->work.has_directions, c <= 2);
        assert_int_equal(s->work.has_degrees, c == 4 || c == 5);
        assert_int_equal(s->work.has_returns,
                         c == 6 || c == 8 || c == 9 || c == 11);
        assert_int_equal(s->work.has_strongest, c == 11);
    }
    free(s);
}

/* Of all that a line's columns are made of, as it was at first. */
static void assert_kept(struct scene *s, const lum_selection *selection,
                        uint64_t *random)
{
    struct scene *before = malloc(sizeof *before);
    assert_non_null(before);
    compute(s, selection, MASK_ALL);
    memcpy(before, s, sizeof *before);
    for (uint32_t i = 0; i < LUM_LINE_PIXELS; i++) {
        s->angles[i].azimuth = (int16_t)next_random(random);
        s->angles[i].elevation = (int16_t)next_random(random);
    }
    memset(s->work_returns, 0x11, sizeof s->work_returns);
    memset(s->work_strongest, 0x11, sizeof s->work_strongest);
    const unsigned mask = 0x37; /* all that angles are in */
    compute(s, selection, mask);
    for (unsigned c = 0; c < 6; c++) {
        if ((mask >> c & 1u) != 0) {
            assert_memory_equal(s->floats[c], before->floats[c],
                                s->count * sizeof(float));
        }
    }
    compute(s, selection, 0xb40);
    for (size_t i = 0; i < s->count; i++) {
        assert_int_equal(s->shorts[1][i], 0x1111);
        assert_int_equal(s->bytes[1][i], 0x11);
    }
    free(before);
}

/* Until lum_column_work_begin(): a frame asks for its columns in turns. */
static void what_was_worked_out_serves_until_the_next_line(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 10;
    lum_selection selection;
    lum_selection_default(&selection);
    make_line(s, 1, NONE, &random);
    look_for(s, &selection);
    begin(s);
    assert_kept(s, &selection, &random);
    check_masks(s, &selection, &random);
    free(s);
}

/* What samples needed is there for a choice that needs none. */
static void what_samples_needed_serves_columns_of_the_line(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 11;
    lum_selection strongest;
    lum_selection all;
    lum_selection_default(&all);
    lum_selection_default(&strongest);
    strongest.returns = LUM_RETURNS_STRONGEST;
    make_line(s, 1, NONE, &random);
    lum_selection limited = all;
    limited.has_range = true;
    limited.range_max = 1e9f;
    look_for(s, &limited);
    begin(s);
    compute(s, &limited, 0x7);
    assert_false(s->work.has_returns);
    look_for(s, &strongest);
    begin(s);
    compute(s, &strongest, 0x7);
    assert_true(s->work.has_directions);
    assert_true(s->work.has_returns);
    assert_false(s->work.has_degrees);
    assert_false(s->work.has_strongest);
    look_for(s, &all);
    check(s, &all, MASK_ALL & ~0x800u);
    memset(s->work_returns, 0x11, sizeof s->work_returns);
    compute(s, &all, 0x100);
    for (size_t i = 0; i < s->count; i++) {
        assert_int_equal(s->shorts[1][i], 0x1111);
    }
    free(s);
}

/* All words give points then, or none does. */
static void lines_of_one_edge_hold_in_columns(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 6;
    lum_selection selection;
    lum_selection_default(&selection);
    for (unsigned round = 0; round < 6; round++) {
        make_line(s, 0, NONE, &random);
        for (uint32_t i = 0; i < s->line.word_count; i++) {
            s->words[i] =
                lum_word_make(lum_word_tof(s->words[i]), round % 2u != 0,
                              lum_word_pixel(s->words[i]));
        }
        selection.edges = (lum_edges)(1u + round / 2u);
        check_masks(s, &selection, &random);
        assert_int_equal(
            s->count,
            ((unsigned)selection.edges >> (round % 2u != 0 ? 0 : 1) & 1u) != 0
                ? s->line.word_count
                : 0);
    }
    free(s);
}

/* Then the least time of flight is above all that a word can have. */
static void a_calibration_without_ranges_gives_no_point(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 12;
    lum_selection selection;
    lum_layout layout;
    lum_layout_default(&layout);
    lum_selection_default(&selection);
    s->calibration.tof_lsb_fs = 1;
    s->calibration.eye[0].tof_offset_fs = -INT64_C(10000000000);
    assert_int_equal(
        lum_projector_init(&s->projector, &s->calibration, &layout), LUM_OK);
    assert_int_equal(s->projector.eye[0].min_tof, LUM_TOF_MAX + 1);
    make_line(s, 0, SOME, &random);
    for (uint32_t i = 0; i < s->line.word_count; i++) {
        s->words[i] = lum_word_make(i % 2u != 0 ? LUM_TOF_MAX : LUM_TOF_MIN,
                                    i % 3u != 0, lum_word_pixel(s->words[i]));
    }
    for (unsigned edges = 1; edges <= LUM_EDGES_BOTH; edges++) {
        selection.edges = (lum_edges)edges;
        check_masks(s, &selection, &random);
        assert_int_equal(s->count, 0);
    }
    free(s);
}

static void a_line_without_words_gives_nothing(void **state)
{
    (void)state;
    struct scene *s = scene_new();
    uint64_t random = 4;
    lum_selection selection;
    lum_selection_default(&selection);
    make_line(s, 0, NONE, &random);
    s->line.word_count = 0;
    look_for(s, &selection);
    compute(s, &selection, MASK_ALL);
    assert_int_equal(s->count, 0);
    free(s);
}

/* The samples of a line without some numbers: those stay as they were, unless a
 * choice of returns needs them. */
static void assert_left(struct scene *s, const lum_selection *selection,
                        unsigned leaves)
{
    begin(s);
    assert_int_equal(lum_samples_make(&s->projector, &s->line, selection,
                                      leaves, &s->work.samples,
                                      s->work_samples),
                     s->count);
    for (size_t i = 0; i < s->count; i++) {
        lum_sample want = s->samples[i];
        const lum_sample *got = &s->work_samples[i];
        if ((leaves & LUM_LEAVE_DEGREES) != 0) {
            memset(&want.azimuth, 0xff, sizeof want.azimuth);
            memset(&want.elevation, 0xff, sizeof want.elevation);
        }
        if ((leaves & LUM_LEAVE_RETURNS) != 0 &&
            selection->returns == LUM_RETURNS_ALL) {
            memset(&want.pulse_width, 0xff, sizeof want.pulse_width);
            want.return_number = want.number_of_returns = 0xffff;
        }
        assert_memory_equal(got, &want, sizeof want);
    }
}

static void what_samples_leave_stays_as_it_was(void **state)
{
    static const lum_selection selections[] = {
        {.edges = LUM_EDGES_RISING},
        {.edges = LUM_EDGES_BOTH},
        {.edges = LUM_EDGES_FALLING, .returns = LUM_RETURNS_LAST},
        {.edges = LUM_EDGES_BOTH, .returns = LUM_RETURNS_STRONGEST},
        {.edges = LUM_EDGES_RISING,
         .has_range = true,
         .range_min = 10.0f,
         .range_max = 500.0f}};
    struct scene *s = scene_new();
    uint64_t random = 77;
    (void)state;
    for (unsigned round = 0; round < 2u * 5u; round++) {
        const lum_selection *selection = &selections[round / 2u];
        make_line(s, round % 2u, round % 2u == 0 ? SOME : NONE, &random);
        look_for(s, selection);
        assert_true(s->count > 0);
        for (unsigned leaves = 0; leaves <= LUM_LEAVE_ALL; leaves++) {
            assert_left(s, selection, leaves);
        }
    }
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_column_is_what_samples_say_in_any_company),
        cmocka_unit_test(choices_of_returns_and_limits_hold_in_columns),
        cmocka_unit_test(the_strongest_are_marked_as_a_selection_chooses_them),
        cmocka_unit_test(the_widest_of_three_is_marked_wherever_it_is),
        cmocka_unit_test(marks_stay_with_their_points_where_others_are_lost),
        cmocka_unit_test(lines_of_any_length_hold_in_columns),
        cmocka_unit_test(a_single_word_that_gives_no_point_is_left_out),
        cmocka_unit_test(a_line_that_lacks_one_pixel_s_angles_lacks_its_points),
        cmocka_unit_test(a_range_below_zero_gives_no_point_whatever_its_pixel),
        cmocka_unit_test(what_is_not_asked_for_is_not_worked_out),
        cmocka_unit_test(what_was_worked_out_serves_until_the_next_line),
        cmocka_unit_test(what_samples_needed_serves_columns_of_the_line),
        cmocka_unit_test(lines_of_one_edge_hold_in_columns),
        cmocka_unit_test(a_calibration_without_ranges_gives_no_point),
        cmocka_unit_test(a_line_without_words_gives_nothing),
        cmocka_unit_test(what_samples_leave_stays_as_it_was),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
