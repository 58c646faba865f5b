#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/calibration.h"
#include "lum/points_fixed.h"
#include "lum/receiver.h"
#include "lum/returns.h"

#include <stdlib.h>
#include <string.h>

#define BLUE  LUM_EYE_BLUE
#define GREEN LUM_EYE_GREEN
#define GAP   LUM_RECEIVER_GAP_US
#define SPAN  2000u
#define ROOM  400u

static lum_layout layout;
static lum_fixed_projector projector;
static lum_receiver receiver;
static uint32_t room[ROOM];

static void begin_with(uint32_t gap_us, uint32_t word_count)
{
    lum_calibration calibration;
    lum_calibration_default(&calibration);
    assert_int_equal(
        lum_fixed_projector_init(&projector, &calibration, &layout), LUM_OK);
    memset(&receiver, 0xa5, sizeof receiver);
    memset(room, 0xa5, sizeof room);
    assert_int_equal(
        lum_receiver_init(&receiver, &layout, gap_us, room, word_count),
        LUM_OK);
}

static void begin(void)
{
    lum_layout_default(&layout);
    begin_with(GAP, ROOM);
}

static lum_result push(unsigned eye, unsigned tag, uint32_t line,
                       uint32_t clock, uint32_t first, const uint8_t *samples,
                       uint32_t n)
{
    uint8_t *exact = exact_copy(samples, (size_t)n * LUM_SAMPLE_BYTES);
    const lum_group g = {.samples = exact,
                         .line = line,
                         .num_samples = n,
                         .first_sample_index = first,
                         .clock_raw = clock,
                         .eye = (uint8_t)eye,
                         .tag = (uint8_t)tag};
    const lum_result r = lum_receiver_push(&receiver, &g);
    free(exact);
    return r;
}

static lum_result push_angles(unsigned eye, uint32_t line, uint32_t clock,
                              uint32_t first, uint32_t n)
{
    uint8_t samples[LUM_LINE_PIXELS * LUM_SAMPLE_BYTES];
    for (uint32_t i = 0; i < n; i++) {
        const lum_angle angle = {(int16_t)(3 * (first + i) + line),
                                 (int16_t)(first + i)};
        lum_angle_encode(&layout, angle, samples + 4 * i);
    }
    return push(eye, LUM_TAG_ANGLES, line, clock, first, samples, n);
}

static lum_result push_words(unsigned eye, uint32_t line, uint32_t clock,
                             uint32_t first, const uint32_t *words, uint32_t n)
{
    uint8_t samples[ROOM * LUM_SAMPLE_BYTES];
    for (uint32_t i = 0; i < n; i++) {
        lum_word_encode(words[i], samples + 4 * i);
    }
    return push(eye, LUM_TAG_RANGES, line, clock, first, samples, n);
}

/* A rising word of each pixel. */
static lum_result push_pixels(unsigned eye, uint32_t line, uint32_t clock,
                              uint32_t pixel, uint32_t n)
{
    uint32_t words[ROOM];
    for (uint32_t i = 0; i < n; i++) {
        words[i] = lum_word_make(5000, true, pixel + i);
    }
    return push_words(eye, line, clock, pixel, words, n);
}

/* Two packets, so that the line counts. */
static void push_line(unsigned eye, uint32_t line, uint32_t clock)
{
    assert_int_equal(push_angles(eye, line, clock, 0, 10), LUM_OK);
    assert_int_equal(push_pixels(eye, line, clock, 0, 5), LUM_OK);
}

static size_t count_points(void)
{
    lum_fixed_point points[ROOM];
    lum_point_losses losses = {0, 0};
    return lum_points_fixed_compute(&projector, lum_receiver_line(&receiver), 0,
                                    ROOM, points, &losses);
}

static const lum_receiver_counters *counted(void)
{
    return lum_receiver_counted(&receiver);
}

/* Beginning */

static void what_cannot_be_is_refused_and_writes_nothing(void **state)
{
    lum_receiver before;
    (void)state;
    lum_layout_default(&layout);
    memset(&receiver, 0x5a, sizeof receiver);
    before = receiver;
    assert_int_equal(
        lum_receiver_init(&receiver, &layout, UINT32_C(1) << 30, room, 1),
        LUM_E_VALUE);
    assert_int_equal(lum_receiver_init(&receiver, &layout, GAP, room, 0),
                     LUM_E_SPACE);
    assert_memory_equal(&receiver, &before, sizeof before);
    assert_int_equal(
        lum_receiver_init(&receiver, &layout, (UINT32_C(1) << 30) - 1, room, 1),
        LUM_OK);
}

static void all_zero_refuses_all_packets(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    memset(&receiver, 0, sizeof receiver);
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 10), LUM_E_ORDER);
    lum_receiver_forget(&receiver);
    assert_null(lum_receiver_line(&receiver));
}

static void a_line_without_words_stands_before_the_first_packet(void **state)
{
    (void)state;
    begin();
    const lum_line *line = lum_receiver_line(&receiver);
    assert_int_equal(line->word_count, 0);
    assert_int_equal(line->eye, BLUE);
    assert_false(lum_line_has_angles(line, 0));
    assert_ptr_equal(line->angles, receiver.eye[BLUE].slot.angles);
    assert_ptr_equal(line->words, room);
    assert_int_equal(count_points(), 0);
}

static void what_no_decoder_gives_is_refused(void **state)
{
    lum_receiver before;
    (void)state;
    begin();
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 10), LUM_OK);
    before = receiver;
    assert_int_equal(push_pixels(2, 1, 0, 0, 1), LUM_E_VALUE);
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 0), LUM_E_VALUE);
    assert_int_equal(push_angles(BLUE, 1, 0, 991, 10), LUM_E_VALUE);
    assert_memory_equal(&receiver, &before, sizeof before);
}

static void a_gap_and_a_span_of_0_are_taken(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    begin_with(0, ROOM);
    push_line(BLUE, 1, 7);
    assert_int_equal(push_pixels(BLUE, 2, 8, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 2, 8, 0, 1), LUM_OK);
    layout.profile.line_span_us = 0;
    begin_with(GAP, ROOM);
    push_line(BLUE, 1, 7);
    assert_int_equal(push_pixels(BLUE, 1, 6, 5, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 1, 8, 0, 1), LUM_OK);
    assert_int_equal(counted()->lines, 1);
}

/* Words and their angles */

static void words_are_handed_out_with_the_angles_of_their_line(void **state)
{
    const lum_line *line = NULL;
    (void)state;
    begin();
    assert_int_equal(push_angles(GREEN, 7, 500, 20, 10), LUM_OK);
    line = lum_receiver_line(&receiver);
    assert_int_equal(line->word_count, 0);
    assert_int_equal(line->angle_count, 10);
    assert_int_equal(push_pixels(GREEN, 7, 500, 18, 4), LUM_OK);
    line = lum_receiver_line(&receiver);
    assert_int_equal(line->eye, GREEN);
    assert_int_equal(line->number, 7);
    assert_int_equal(line->clock_us, 500);
    assert_int_equal(line->frame, 0);
    assert_int_equal(line->arrival, 0);
    assert_int_equal(line->word_count, 4);
    assert_int_equal(lum_word_pixel(line->words[3]), 21);
    assert_int_equal(line->angles[21].azimuth, 70);
    assert_int_equal(line->angles[21].elevation, 21);
    assert_false(lum_line_has_angles(line, 19));
    assert_true(lum_line_has_angles(line, 20));
}

static void words_before_their_angles_are_counted_and_lost(void **state)
{
    lum_fixed_point points[8];
    lum_point_losses losses = {0, 0};
    (void)state;
    begin();
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 8), LUM_OK);
    assert_int_equal(lum_points_fixed_compute(&projector,
                                              lum_receiver_line(&receiver), 0,
                                              8, points, &losses),
                     0);
    assert_int_equal(losses.no_angle, 8);
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 8), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 8), LUM_E_DUPLICATE);
    assert_int_equal(count_points(), 0);
    assert_int_equal(counted()->words, 8);
}

static void each_eye_has_its_own_line(void **state)
{
    (void)state;
    begin();
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 10), LUM_OK);
    assert_int_equal(push_angles(GREEN, 2, 0, 10, 10), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 20), LUM_OK);
    assert_int_equal(count_points(), 10);
    assert_int_equal(lum_receiver_line(&receiver)->angles[3].azimuth, 10);
    assert_int_equal(push_pixels(GREEN, 2, 0, 0, 20), LUM_OK);
    assert_int_equal(count_points(), 10);
    assert_int_equal(lum_receiver_line(&receiver)->angles[10].azimuth, 32);
}

static void angles_may_come_elevation_first(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    layout.profile.angle_order = LUM_ELEVATION_AZIMUTH;
    begin_with(GAP, ROOM);
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 10), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->angles[9].azimuth, 28);
    assert_int_equal(lum_receiver_line(&receiver)->angles[9].elevation, 9);
}

static void a_drop_leaves_no_words(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 0);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 5);
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 5), LUM_E_DUPLICATE);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 0);
    assert_int_equal(push_pixels(BLUE, 1, 0, 5, 5), LUM_OK);
    assert_int_equal(push_pixels(2, 1, 0, 5, 5), LUM_E_VALUE);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 0);
    assert_int_equal(push_pixels(GREEN, 1, 0, 5, 5), LUM_OK);
    lum_receiver_forget(&receiver);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 0);
}

static void a_packet_partly_there_is_a_conflict(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 0);
    assert_int_equal(push_pixels(BLUE, 1, 0, 4, 2), LUM_E_CONFLICT);
    assert_int_equal(push_pixels(BLUE, 1, 0, 5, 1), LUM_OK);
    assert_int_equal(push_angles(BLUE, 1, 0, 9, 2), LUM_E_CONFLICT);
    assert_int_equal(push_angles(BLUE, 1, 0, 8, 2), LUM_E_DUPLICATE);
    assert_int_equal(push_pixels(GREEN, 1, 0, 1, 1), LUM_OK);
    assert_int_equal(push_pixels(GREEN, 1, 0, 0, 2), LUM_E_CONFLICT);
    assert_int_equal(counted()->conflict, 3);
    assert_int_equal(counted()->duplicate, 1);
}

static void bad_words_are_skipped_alone(void **state)
{
    const uint32_t words[] = {lum_word_make(9, true, 3), 1000u,
                              lum_word_make(9, true, 4) | LUM_WORD_ZERO,
                              lum_word_make(9, false, 999)};
    (void)state;
    begin();
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 4), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 2);
    assert_true(lum_receiver_line(&receiver)->words[1] == words[3]);
    assert_int_equal(counted()->bad_words, 2);
    assert_int_equal(counted()->words, 2);
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 4), LUM_E_DUPLICATE);
    assert_int_equal(counted()->bad_words, 2);
    assert_int_equal(push_words(BLUE, 1, 0, 0, &words[1], 2), LUM_OK);
    assert_int_equal(counted()->bad_words, 4);
}

static void more_words_than_room_are_dropped_whole(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    begin_with(GAP, 7);
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 8), LUM_E_NO_ROOM);
    assert_int_equal(counted()->no_room, 1);
    assert_int_equal(room[7], 0xa5a5a5a5u);
    assert_int_equal(push_pixels(BLUE, 1, 0, 1, 7), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 7);
}

static void bad_words_take_no_room(void **state)
{
    uint32_t words[9] = {1000u, 1001u};
    (void)state;
    lum_layout_default(&layout);
    begin_with(GAP, 7);
    for (uint32_t i = 0; i < 7; i++) {
        words[2 + i] = lum_word_make(9, true, i);
    }
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 9), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->word_count, 7);
    assert_memory_equal(room, &words[2], 7 * sizeof room[0]);
    assert_int_equal(counted()->bad_words, 2);
}

static void words_out_of_order_are_told(void **state)
{
    const uint32_t words[] = {
        lum_word_make(9, true, 5), lum_word_make(9, false, 5),
        lum_word_make(9, true, 4), lum_word_make(9, true, 5)};
    (void)state;
    begin();
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 10), LUM_OK);
    assert_true(lum_receiver_is_sorted(&receiver));
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 4), LUM_OK);
    assert_false(lum_receiver_is_sorted(&receiver));
    assert_int_equal(count_points(), 4);
    assert_memory_equal(lum_receiver_line(&receiver)->words, words,
                        sizeof words);
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 4), LUM_E_DUPLICATE);
    assert_true(lum_receiver_is_sorted(&receiver));
    assert_int_equal(push_pixels(BLUE, 1, 0, 6, 2), LUM_OK);
    assert_true(lum_receiver_is_sorted(&receiver));
    assert_int_equal(push_words(BLUE, 2, 300, 0, words, 2), LUM_OK);
    assert_true(lum_receiver_is_sorted(&receiver));
    assert_int_equal(push_pixels(BLUE, 2, 300, 0, 2), LUM_OK);
    assert_true(lum_receiver_is_sorted(&receiver));
}

static void words_above_the_first_may_be_out_of_order(void **state)
{
    const uint32_t words[] = {lum_word_make(9, true, 5),
                              lum_word_make(9, true, 9),
                              lum_word_make(9, true, 8)};
    (void)state;
    begin();
    assert_int_equal(push_words(BLUE, 1, 0, 0, words, 3), LUM_OK);
    assert_false(lum_receiver_is_sorted(&receiver));
}

/* Lines */

static void a_newer_line_ends_the_one_before(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 9000);
    assert_int_equal(push_angles(BLUE, 2, 9300, 0, 3), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 9000, 5, 5), LUM_E_LATE);
    assert_int_equal(push_angles(BLUE, 1, 9000 + SPAN, 10, 5), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 2, 9300, 0, 5), LUM_OK);
    assert_int_equal(count_points(), 3);
    assert_int_equal(push_pixels(BLUE, 1, 9000, 5, 5), LUM_E_LATE);
    assert_int_equal(counted()->late, 3);
    assert_int_equal(counted()->lines, 1);
}

static void a_number_comes_again_once_its_line_is_over(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 9000);
    assert_int_equal(push_angles(BLUE, 2, 9300, 0, 3), LUM_OK);
    assert_int_equal(push_angles(BLUE, 1, 9001 + SPAN, 10, 5), LUM_OK);
    assert_int_equal(counted()->lines, 2);
}

static void a_line_lasts_as_long_as_the_profile_says(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 5000);
    assert_int_equal(push_pixels(BLUE, 1, 5000 + SPAN, 5, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 5000 - SPAN, 6, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 5000 - SPAN - 1, 7, 1), LUM_E_LATE);
    assert_int_equal(counted()->lines, 0);
    assert_int_equal(push_pixels(BLUE, 1, 5000 + SPAN + 1, 7, 1), LUM_OK);
    assert_int_equal(counted()->lines, 1);
    assert_int_equal(count_points(), 0);
}

static void one_packet_ahead_deafens_nobody(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 0);
    assert_int_equal(push_pixels(BLUE, 9, 90000, 0, 1), LUM_OK);
    push_line(BLUE, 2, 300);
    assert_int_equal(count_points(), 5);
    push_line(BLUE, 9, 90000);
    assert_int_equal(push_pixels(BLUE, 3, 90000 - 1, 0, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 3, 90001, 0, 1), LUM_OK);
}

static void what_is_older_than_two_packets_of_a_line_is_late(void **state)
{
    (void)state;
    begin();
    assert_int_equal(push_angles(BLUE, 20, 1000, 0, 5), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 20, 900, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 20, 800, 1, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 30, 899, 0, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 31, 900, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 31, 950, 1, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 50, 5000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 32, 899, 0, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 32, 901, 0, 1), LUM_OK);
    push_line(BLUE, 42, 70000);
    assert_int_equal(push_pixels(BLUE, 50, 80000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 43, 69999, 0, 1), LUM_E_LATE);
    /* a smaller number is of an older line only at the same time */
    assert_int_equal(push_pixels(BLUE, 41, 70000, 0, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 34, 70000, 0, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 33, 70000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 41, 70001, 0, 1), LUM_OK);
}

static void one_packet_of_a_line_makes_nothing_late(void **state)
{
    (void)state;
    begin();
    assert_int_equal(push_pixels(BLUE, 5, 100, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 0, 100, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 5, 50, 0, 1), LUM_OK);
    assert_int_equal(counted()->lines, 2);
}

/* Of more than half a wrap ago, where a clock that is later looks earlier. */
static void what_ended_long_ago_makes_nothing_late(void **state)
{
    uint32_t clock = 1000;
    (void)state;
    begin();
    push_line(BLUE, 1, clock);
    for (uint32_t line = 2; line < 24000; line++) {
        clock += GAP;
        assert_int_equal(push_pixels(BLUE, line, clock, 0, 1), LUM_OK);
    }
    assert_int_equal(counted()->late + counted()->stray, 0);
}

/* With one clock for all packets, or none, the numbers show which is older. */
static void without_a_clock_numbers_tell(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = 0;
    begin_with(GAP, ROOM);
    for (uint32_t line = 0; line < 12; line++) {
        push_line(BLUE, line, 77 * line);
        assert_int_equal(lum_receiver_line(&receiver)->clock_us, 0);
    }
    assert_int_equal(push_pixels(BLUE, 10, 0, 9, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 3, 0, 9, 1), LUM_E_LATE);
    assert_int_equal(push_pixels(BLUE, 11, 0, 9, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 2, 0, 9, 1), LUM_OK);
}

static void a_short_frame_is_not_late(void **state)
{
    (void)state;
    begin();
    for (uint32_t i = 0; i < 40; i++) {
        push_line(BLUE, i % 8, i * 300);
        assert_int_equal(count_points(), 5);
    }
    assert_int_equal(counted()->late, 0);
}

/* Clocks */

static void one_far_clock_is_a_stray_and_two_are_a_jump(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 1000);
    assert_int_equal(push_pixels(BLUE, 2, 1001 + GAP, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 1, 1000, 5, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 2, 1001 + GAP, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 2, 1002 + 2 * GAP, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 2, 1002 + 3 * GAP, 0, 1), LUM_OK);
    assert_int_equal(counted()->stray, 3);
    assert_int_equal(counted()->lines, 1);
    /* all before is forgotten: the clock may go back */
    assert_int_equal(push_pixels(BLUE, 1, 1000, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 1, 1000, 0, 1), LUM_OK);
    assert_int_equal(counted()->lines_skipped, 0);
}

static void a_step_of_the_gap_is_none(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 1000);
    assert_int_equal(push_pixels(BLUE, 2, 1000 + GAP, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 4, 1000 + 2 * GAP, 0, 1), LUM_OK);
    /* late, and newest all the same */
    assert_int_equal(push_pixels(BLUE, 3, 1000 + GAP, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 5, 1000 + 3 * GAP, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 5, 999 + 2 * GAP, 0, 1), LUM_E_STRAY);
}

static void one_packet_tells_what_is_newest(void **state)
{
    (void)state;
    begin();
    assert_int_equal(push_pixels(BLUE, 2, 1000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 1001 + GAP, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 1, 400, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 3, 1000 + GAP, 0, 1), LUM_OK);
}

static void a_candidate_is_spent(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 1000);
    assert_int_equal(push_pixels(BLUE, 2, 500000, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 2, 500000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 3, 1000, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 3, 500000, 0, 1), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 3, 1000, 0, 1), LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 3, 500001, 1, 1), LUM_OK);
}

static void the_clock_wraps(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 1, 0xffffff00u);
    assert_int_equal(push_pixels(BLUE, 1, 0x100, 5, 1), LUM_OK);
    assert_int_equal(count_points(), 1);
    push_line(BLUE, 2, 0x200);
    assert_int_equal(push_pixels(BLUE, 3, 0xffffffffu, 0, 1), LUM_E_LATE);
    assert_int_equal(counted()->stray, 0);
}

static void a_narrow_clock_goes_on(void **state)
{
    (void)state;
    lum_layout_default(&layout);
    layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = 1;
    begin_with(GAP, ROOM);
    for (uint32_t i = 0; i < 100; i++) {
        const uint32_t clock = 50 + i * 100;
        assert_int_equal(push_pixels(BLUE, i, clock % 256, 0, 1), LUM_OK);
        assert_int_equal(lum_receiver_line(&receiver)->clock_us, clock);
    }
    assert_int_equal(push_pixels(BLUE, 98, (50 + 99 * 100 - 100) % 256, 2, 1),
                     LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->clock_us, 50 + 98 * 100);
}

/* Its clocks are compared as they go on, not as they come. */
static void a_narrow_clock_that_has_wrapped_may_jump(void **state)
{
    uint32_t clock = 0;
    (void)state;
    lum_layout_default(&layout);
    layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = 1;
    begin_with(20, ROOM);
    for (uint32_t line = 0; line < 50; line++) {
        clock = 20 * line;
        assert_int_equal(push_pixels(BLUE, line, clock % 256, 0, 1), LUM_OK);
    }
    assert_int_equal(push_pixels(BLUE, 50, (clock + 60) % 256, 0, 1),
                     LUM_E_STRAY);
    assert_int_equal(push_pixels(BLUE, 50, (clock + 80) % 256, 0, 1), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->clock_us, clock + 80);
}

static void any_clock_may_come_after_forgetting(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 5, 1000000);
    push_line(GREEN, 5, 1000000);
    lum_receiver_forget(&receiver);
    assert_int_equal(counted()->lines, 2);
    assert_int_equal(push_pixels(BLUE, 5, 1000000, 0, 5), LUM_OK);
    assert_int_equal(count_points(), 0);
    lum_receiver_forget(&receiver);
    push_line(BLUE, 9, 4);
    push_line(GREEN, 9, 4);
    assert_int_equal(counted()->lines_skipped, 0);
    assert_int_equal(counted()->late + counted()->stray, 0);
}

/* Counters */

static void lines_that_did_not_come_are_counted(void **state)
{
    (void)state;
    begin();
    push_line(BLUE, 3, 0); /* the first tells nothing */
    push_line(BLUE, 4, 300);
    push_line(BLUE, 7, 900);    /* 5 and 6 */
    push_line(BLUE, 30, 5000);  /* 22 */
    push_line(BLUE, 22, 9000);  /* not fallen far enough */
    push_line(BLUE, 13, 13000); /* a frame that lacks 13 */
    push_line(BLUE, 13, 20000); /* the mirror stands still */
    lum_receiver_forget(&receiver);
    assert_int_equal(counted()->lines_skipped, 2 + 22 + 13);
    assert_int_equal(counted()->lines, 7);
}

static void lost_words_are_counted(void **state)
{
    uint32_t word = lum_word_make(5, true, 50);
    (void)state;
    begin();
    assert_int_equal(push_pixels(BLUE, 1, 0, 0, 5), LUM_OK);
    assert_int_equal(push_pixels(BLUE, 1, 0, 20, 5), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->lost_words, 15);
    assert_int_equal(push_pixels(BLUE, 1, 0, 10, 5), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->lost_words, 10);
    /* past what a line can have: not believed */
    assert_int_equal(push_words(BLUE, 1, 0, LUM_LINE_WORDS_MAX, &word, 1),
                     LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->lost_words, 9);
    assert_int_equal(counted()->lost_words, 0);
    assert_int_equal(push_pixels(BLUE, 2, 300, 0, 5), LUM_OK);
    assert_int_equal(counted()->lost_words, 9);
    word = lum_word_make(5, true, 51);
    assert_int_equal(push_words(BLUE, 2, 300, 0, &word, 1), LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->lost_words, 0);
    word = lum_word_make(5, true, 52);
    assert_int_equal(push_words(BLUE, 2, 300, LUM_LINE_WORDS_MAX - 1, &word, 1),
                     LUM_OK);
    assert_int_equal(lum_receiver_line(&receiver)->lost_words,
                     LUM_LINE_WORDS_MAX - 7);
}

static void lines_without_all_angles_are_counted(void **state)
{
    (void)state;
    begin();
    assert_int_equal(push_angles(BLUE, 1, 0, 0, 1000), LUM_OK);
    assert_int_equal(push_angles(BLUE, 2, 300, 0, 999), LUM_OK);
    assert_int_equal(push_angles(GREEN, 2, 300, 1, 999), LUM_OK);
    lum_receiver_forget(&receiver);
    assert_int_equal(counted()->lines, 3);
    assert_int_equal(counted()->lines_missing_angles, 2);
}

/* By chance: streams, and what is done to them */

#define LINES    24u
#define PIXELS   60u
#define PACKETS  4000u
#define SAMPLES  128u
#define POINTS   40000u
#define SEGMENTS 3u

struct packet {
    lum_group group;
    uint8_t samples[SAMPLES * LUM_SAMPLE_BYTES];
    unsigned segment;
};

struct point {
    lum_fixed_point at;
    uint32_t line;
    uint32_t eye;
    bool is_given;
};

struct points {
    struct point all[POINTS];
    size_t count;
};

static struct packet packets[PACKETS];
static size_t packet_count;
static const struct packet *order[2 * PACKETS];
static struct points expected;
static struct points given;
static uint64_t chance;

static uint32_t below(uint32_t n)
{
    return next_random(&chance) % n;
}

static struct packet *add_packet(unsigned eye, uint32_t line, uint32_t clock)
{
    struct packet *p = &packets[packet_count++];
    assert_true(packet_count <= PACKETS);
    p->group = (lum_group){.line = line,
                           .clock_raw = clock,
                           .eye = (uint8_t)eye,
                           .samples = p->samples};
    return p;
}

static void make_angles(unsigned eye, uint32_t line, uint32_t clock)
{
    for (uint32_t first = 0; first < PIXELS;) {
        const uint32_t left = PIXELS - first;
        const uint32_t n = below(3) == 0 ? left : 1 + below(left);
        struct packet *p = add_packet(eye, line, clock);
        p->group.tag = LUM_TAG_ANGLES;
        p->group.first_sample_index = first;
        p->group.num_samples = n;
        for (uint32_t i = 0; i < n; i++) {
            const lum_angle angle = {(int16_t)(below(65535) - 32767),
                                     (int16_t)(below(65535) - 32767)};
            lum_angle_encode(&layout, angle, p->samples + 4 * i);
        }
        first += n;
    }
}

/* Up to three words of a pixel, all in one packet. */
static void make_words(unsigned eye, uint32_t line, uint32_t clock,
                       uint32_t step)
{
    struct packet *p = NULL;
    uint32_t sent = 0;
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        const uint32_t n = below(4);
        if (p == NULL || p->group.num_samples + n > SAMPLES || below(20) == 0) {
            clock += step;
            p = add_packet(eye, line, clock);
            p->group.tag = LUM_TAG_RANGES;
            p->group.first_sample_index = sent;
        }
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t word =
                lum_word_make((int32_t)below(500000), below(2) == 0, pixel);
            lum_word_encode(word, p->samples + 4 * p->group.num_samples++);
            sent++;
        }
    }
}

/* A packet needs a sample. */
static void remove_empty(size_t from)
{
    size_t kept = from;
    for (size_t i = from; i < packet_count; i++) {
        if (packets[i].group.num_samples > 0) {
            packets[kept] = packets[i];
            packets[kept].group.samples = packets[kept].samples;
            kept++;
        }
    }
    packet_count = kept;
}

/* Frames of both eyes, eye by eye within a line's time. */
static void make_segment(unsigned segment, uint32_t clock, uint32_t height)
{
    const size_t from = packet_count;
    const uint32_t step = below(2) == 0 ? 0 : 1 + below(20);
    uint32_t line = below(height);
    for (uint32_t i = 0; i < LINES; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            make_angles(eye, line, clock);
            make_words(eye, line, clock, step);
        }
        line = (line + 1) % height;
        clock += 600;
    }
    remove_empty(from);
    for (size_t i = from; i < packet_count; i++) {
        packets[i].segment = segment;
    }
}

static void make_stream(unsigned segments)
{
    uint32_t clock = next_random(&chance);
    const uint32_t height = 9 + below(40);
    packet_count = 0;
    for (unsigned s = 0; s < segments; s++) {
        make_segment(s, clock, height);
        clock += 1000000u + below(1000000000u);
    }
}

static void keep_points(struct points *to, const lum_line *line)
{
    lum_fixed_point block[SAMPLES];
    lum_point_losses losses = {0, 0};
    for (uint32_t i = 0; i < line->word_count; i += SAMPLES) {
        const size_t n = lum_points_fixed_compute(&projector, line, i, SAMPLES,
                                                  block, &losses);
        for (size_t k = 0; k < n; k++) {
            assert_true(to->count < POINTS);
            to->all[to->count++] =
                (struct point){block[k], line->number, line->eye, false};
        }
    }
}

/* By an assembler, of the packets of a segment, or of all. */
static void assemble(int segment)
{
    struct stream *s = stream_open();
    for (size_t i = 0; i < packet_count; i++) {
        if (segment < 0 || packets[i].segment == (unsigned)segment) {
            (void)send_group(s, &packets[i].group, packets[i].samples);
        }
    }
    stream_end(s);
    for (size_t i = 0; i < count_events(s, LUM_LINE_READY); i++) {
        keep_points(&expected, nth_line(s, i));
    }
    stream_free(s);
}

static void receive(const struct packet *p)
{
    if (lum_receiver_push(&receiver, &p->group) == LUM_OK) {
        keep_points(&given, lum_receiver_line(&receiver));
    } else {
        assert_int_equal(lum_receiver_line(&receiver)->word_count, 0);
    }
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, offsetof(struct point, is_given));
}

static void sort(struct points *p)
{
    qsort(p->all, p->count, sizeof p->all[0], compare);
}

static void assert_all_given(void)
{
    assert_int_equal(given.count, expected.count);
    for (size_t i = 0; i < given.count; i++) {
        assert_int_equal(compare(&given.all[i], &expected.all[i]), 0);
    }
}

static struct point *find_point(const struct point *wanted)
{
    struct point *found =
        bsearch(wanted, expected.all, expected.count, sizeof *wanted, compare);
    assert_non_null(found);
    while (found > expected.all && compare(found - 1, wanted) == 0) {
        found--;
    }
    return found;
}

/* Every point is one of those expected; where once is meant, as often. */
static void assert_some_given(bool once)
{
    for (size_t i = 0; i < given.count; i++) {
        struct point *p = find_point(&given.all[i]);
        while (once && p->is_given) {
            p++;
            assert_true(p < expected.all + expected.count);
            assert_int_equal(compare(p, &given.all[i]), 0);
        }
        p->is_given = true;
    }
}

static void begin_chance(unsigned seed)
{
    chance = 1000u + seed;
    begin();
    expected.count = 0;
    given.count = 0;
}

static void in_order_it_gives_what_an_assembler_gives(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 30; seed++) {
        begin_chance(seed);
        make_stream(1 + seed % SEGMENTS);
        for (size_t i = 0; i < packet_count; i++) {
            receive(&packets[i]);
        }
        assemble(-1);
        assert_true(given.count > 1000);
        sort(&given);
        sort(&expected);
        assert_all_given();
    }
}

/* Loses, repeats and delays packets. */
static size_t disturb(uint32_t reach)
{
    const uint32_t lost = below(4) * 10;
    const uint32_t repeated = below(4) * 10;
    const uint32_t moved = below(4) * 15;
    size_t n = 0;
    for (size_t i = 0; i < packet_count; i++) {
        if (below(100) >= lost) {
            order[n++] = &packets[i];
        }
        if (below(100) < repeated) {
            order[n++] = &packets[i];
        }
    }
    for (size_t i = 0; i < n; i++) {
        const size_t to = i + below(reach);
        if (below(100) < moved && to < n) {
            const struct packet *p = order[i];
            order[i] = order[to];
            order[to] = p;
        }
    }
    return n;
}

/* Each segment separately: losses of an assembler by a jump of the clock do not
 * come from the disorder. */
static void in_disorder(unsigned seed, unsigned segments, uint32_t reach,
                        bool once)
{
    begin_chance(seed);
    make_stream(segments);
    for (unsigned s = 0; s < segments; s++) {
        assemble((int)s);
    }
    const size_t n = disturb(reach);
    for (size_t i = 0; i < n; i++) {
        receive(order[i]);
    }
    assert_true(given.count > 0);
    sort(&expected);
    assert_some_given(once);
}

static void in_disorder_no_point_is_wrong_or_comes_twice(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 60; seed++) {
        in_disorder(seed, 1, 1 + seed * 3, true);
    }
}

/* A packet that is delayed over a jump may prove one back. */
static void over_jumps_of_the_clock_no_point_is_wrong(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 60; seed++) {
        in_disorder(seed, SEGMENTS, 1 + seed * 3, false);
    }
}

static const lum_line *nth_of_eye(const struct stream *s, unsigned eye,
                                  unsigned n)
{
    size_t i = 0;
    while (nth_line(s, i)->eye != eye || n-- > 0) {
        i++;
    }
    return nth_line(s, i);
}

/* Words of a pixel are in one packet: their returns are those of the line. */
static void returns_of_a_packet_are_those_of_its_line(void **state)
{
    static lum_return whole[LUM_EYES][LINES * PIXELS * 3];
    static lum_return part[ROOM];
    uint32_t at[LUM_EYES] = {0, 0};
    (void)state;
    begin_chance(1);
    make_stream(1);
    struct stream *s = stream_open();
    for (size_t i = 0; i < packet_count; i++) {
        (void)send_group(s, &packets[i].group, packets[i].samples);
    }
    stream_end(s);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_return *out = whole[eye];
        for (unsigned i = 0; i < LINES; i++) {
            const lum_line *line = nth_of_eye(s, eye, i);
            lum_returns_compute(line->words, line->word_count, out);
            out += line->word_count;
        }
    }
    for (size_t i = 0; i < packet_count; i++) {
        receive(&packets[i]);
        const lum_line *line = lum_receiver_line(&receiver);
        lum_returns_compute(line->words, line->word_count, part);
        assert_memory_equal(part, &whole[line->eye][at[line->eye]],
                            line->word_count * sizeof part[0]);
        at[line->eye] += line->word_count;
    }
    assert_true(at[BLUE] > LINES * PIXELS);
    stream_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_cannot_be_is_refused_and_writes_nothing),
        cmocka_unit_test(all_zero_refuses_all_packets),
        cmocka_unit_test(a_line_without_words_stands_before_the_first_packet),
        cmocka_unit_test(what_no_decoder_gives_is_refused),
        cmocka_unit_test(a_gap_and_a_span_of_0_are_taken),
        cmocka_unit_test(words_are_handed_out_with_the_angles_of_their_line),
        cmocka_unit_test(words_before_their_angles_are_counted_and_lost),
        cmocka_unit_test(each_eye_has_its_own_line),
        ANY_LAYOUT_TEST(angles_may_come_elevation_first),
        cmocka_unit_test(a_drop_leaves_no_words),
        cmocka_unit_test(a_packet_partly_there_is_a_conflict),
        cmocka_unit_test(bad_words_are_skipped_alone),
        cmocka_unit_test(more_words_than_room_are_dropped_whole),
        cmocka_unit_test(bad_words_take_no_room),
        cmocka_unit_test(words_out_of_order_are_told),
        cmocka_unit_test(words_above_the_first_may_be_out_of_order),
        cmocka_unit_test(a_newer_line_ends_the_one_before),
        cmocka_unit_test(a_number_comes_again_once_its_line_is_over),
        cmocka_unit_test(a_line_lasts_as_long_as_the_profile_says),
        cmocka_unit_test(one_packet_ahead_deafens_nobody),
        cmocka_unit_test(what_is_older_than_two_packets_of_a_line_is_late),
        cmocka_unit_test(one_packet_of_a_line_makes_nothing_late),
        cmocka_unit_test(what_ended_long_ago_makes_nothing_late),
        ANY_LAYOUT_TEST(without_a_clock_numbers_tell),
        cmocka_unit_test(a_short_frame_is_not_late),
        cmocka_unit_test(one_far_clock_is_a_stray_and_two_are_a_jump),
        cmocka_unit_test(a_step_of_the_gap_is_none),
        cmocka_unit_test(one_packet_tells_what_is_newest),
        cmocka_unit_test(a_candidate_is_spent),
        cmocka_unit_test(the_clock_wraps),
        ANY_LAYOUT_TEST(a_narrow_clock_goes_on),
        ANY_LAYOUT_TEST(a_narrow_clock_that_has_wrapped_may_jump),
        cmocka_unit_test(any_clock_may_come_after_forgetting),
        cmocka_unit_test(lines_that_did_not_come_are_counted),
        cmocka_unit_test(lost_words_are_counted),
        cmocka_unit_test(lines_without_all_angles_are_counted),
        cmocka_unit_test(in_order_it_gives_what_an_assembler_gives),
        cmocka_unit_test(in_disorder_no_point_is_wrong_or_comes_twice),
        cmocka_unit_test(over_jumps_of_the_clock_no_point_is_wrong),
        cmocka_unit_test(returns_of_a_packet_are_those_of_its_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
