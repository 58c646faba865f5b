#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include <stdlib.h>
#include <string.h>

#define BLUE  LUM_EYE_BLUE
#define GREEN LUM_EYE_GREEN
#define GAP   100000u
#define SPAN  2000u

#define UP(tof, pixel)   lum_word_make(tof, true, pixel)
#define DOWN(tof, pixel) lum_word_make(tof, false, pixel)
#define BAD              (LUM_WORD_ZERO | 5u)

#define WORDS(...)                                                             \
    (const uint32_t[])                                                         \
    {                                                                          \
        __VA_ARGS__                                                            \
    }

/* Clocks of 1 or 2 bytes, or none at all. */
static struct stream *open_with_clock(uint8_t bytes, uint32_t gap_us)
{
    struct stream *s = stream_new();
    s->layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = bytes;
    s->layout.profile.line_span_us = 10;
    s->config.gap_us = gap_us;
    stream_begin(s);
    return s;
}

static struct stream *open_with_words(uint32_t words_per_line)
{
    struct stream *s = stream_new();
    s->config.words_per_line = words_per_line;
    stream_begin(s);
    return s;
}

/* One packet, of an angle nobody else sends. */
static lum_result one(struct stream *s, unsigned eye, uint32_t line,
                      uint32_t clock)
{
    return send_angles(s, eye, line, clock, (uint32_t)s->arrival % 1000u, 1);
}

/* Two packets of one clock. */
static void two(struct stream *s, unsigned eye, uint32_t line, uint32_t clock)
{
    assert_int_equal(one(s, eye, line, clock), LUM_OK);
    assert_int_equal(one(s, eye, line, clock), LUM_OK);
}

static int64_t clock_of(const struct stream *s, size_t n)
{
    return nth_line(s, n)->clock_us;
}

static void assert_words(const lum_line *line, const uint32_t *words, size_t n)
{
    assert_int_equal(line->word_count, n);
    assert_memory_equal(line->words, words, n * sizeof *words);
}

/* Constants */

static void constants_are_the_documents(void **state)
{
    lum_assembler_config c;
    (void)state;
    lum_assembler_config_default(&c);
    assert_int_equal(c.open_lines, 4);
    assert_int_equal(c.reorder_lines, 8);
    assert_int_equal(c.words_per_line, 16384);
    assert_int_equal(c.gap_us, 100000);
}

static lum_result init_with(const lum_assembler_config *c)
{
    static lum_assembler a;
    static lum_line_slot slots[2 * LUM_OPEN_LINES_MAX];
    static uint32_t words[8 * LUM_LINE_WORDS_MAX];
    static lum_reach reach[2 * LUM_REORDER_MAX];
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    lum_layout layout;
    lum_layout_default(&layout);
    return lum_assembler_init(&a, c, &layout, &storage);
}

static void constants_have_limits(void **state)
{
    lum_assembler_config good;
    (void)state;
    lum_assembler_config_default(&good);
    for (unsigned v = 0; v < 256; v++) {
        lum_assembler_config c = good;
        c.words_per_line = 1;
        c.open_lines = (uint8_t)v;
        assert_int_equal(init_with(&c),
                         v >= 1 && v <= 16 ? LUM_OK : LUM_E_VALUE);
        c.open_lines = 1;
        c.reorder_lines = (uint8_t)v;
        assert_int_equal(init_with(&c),
                         v >= 1 && v <= 32 ? LUM_OK : LUM_E_VALUE);
    }
    lum_assembler_config c = good;
    c.words_per_line = 0;
    assert_int_equal(init_with(&c), LUM_E_VALUE);
    c.words_per_line = LUM_LINE_WORDS_MAX + 1u;
    assert_int_equal(init_with(&c), LUM_E_VALUE);
    c.words_per_line = LUM_LINE_WORDS_MAX;
    assert_int_equal(init_with(&c), LUM_OK);
    c.gap_us = UINT32_C(1) << 30;
    assert_int_equal(init_with(&c), LUM_E_VALUE);
    c.gap_us = (UINT32_C(1) << 30) - 1u;
    assert_int_equal(init_with(&c), LUM_OK);
}

/* 1. Clock */

static void the_clock_begins_at_the_first_packets_value(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 0xfffffff0u);
    stream_end(s);
    assert_true(clock_of(s, 0) == INT64_C(0xfffffff0));
    stream_free(s);
}

static void the_clock_goes_on_over_its_wrap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 0xffffff00u);
    one(s, BLUE, 2, 0x100u);
    stream_end(s);
    assert_true(clock_of(s, 1) == INT64_C(0x100000100));
    stream_free(s);
}

static void the_clock_may_go_below_zero(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 0x10u);
    one(s, BLUE, 2, 0xfffffff0u);
    stream_end(s);
    assert_true(clock_of(s, 1) == -0x10);
    stream_free(s);
}

static void half_a_wrap_of_the_clock_is_backwards(void **state)
{
    struct stream *s = open_with_clock(1, 1000);
    (void)state;
    one(s, BLUE, 1, 50);
    one(s, GREEN, 1, 178); /* 128 before 50 */
    one(s, BLUE, 2, 49);   /* 127 after that */
    stream_end(s);
    assert_true(find_line(s, GREEN, 1, 0)->clock_us == 50 - 128);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == 49);
    stream_free(s);
}

static void the_clock_follows_packets_of_either_eye(void **state)
{
    struct stream *s = open_with_clock(1, 1000);
    (void)state;
    one(s, BLUE, 1, 0);
    one(s, GREEN, 1, 100);
    one(s, BLUE, 2, 200); /* 200 after 100, not 56 before 0 */
    stream_end(s);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == 200);
    stream_free(s);
}

static void the_clock_follows_late_packets(void **state)
{
    struct stream *s = open_with_clock(1, 1000);
    (void)state;
    one(s, BLUE, 1, 100);
    assert_int_equal(one(s, BLUE, 1, 0), LUM_E_LATE);
    one(s, BLUE, 2, 160); /* 96 before 0, not 60 after 100 */
    stream_end(s);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == -96);
    stream_free(s);
}

static void the_clock_follows_repeats(void **state)
{
    struct stream *s = open_with_clock(1, 1000);
    (void)state;
    s->layout.profile.line_span_us = 10;
    one(s, BLUE, 1, 100);
    send_angles(s, BLUE, 1, 95, 500, 1);
    assert_int_equal(send_angles(s, BLUE, 1, 105, 500, 1), LUM_E_DUPLICATE);
    one(s, BLUE, 2, 230); /* 125 after 105; from 95 it would be 121 before */
    stream_end(s);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == 230);
    stream_free(s);
}

static void the_clock_does_not_follow_strays(void **state)
{
    struct stream *s = open_with_clock(1, 50);
    (void)state;
    one(s, BLUE, 1, 150);
    assert_int_equal(one(s, BLUE, 1, 50), LUM_E_STRAY);
    one(s, BLUE, 2, 190); /* 40 after 150, not 116 before 50 */
    stream_end(s);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == 190);
    stream_free(s);
}

static void the_clock_follows_a_break(void **state)
{
    struct stream *s = open_with_clock(1, 50);
    (void)state;
    one(s, BLUE, 1, 150);
    assert_int_equal(one(s, BLUE, 2, 50), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 50), LUM_OK);
    one(s, GREEN, 3, 190); /* 116 before 50, not 40 after 150 */
    stream_end(s);
    assert_true(find_line(s, GREEN, 3, 0)->clock_us == 50 - 116);
    stream_free(s);
}

static void a_clock_of_two_bytes_is_extended_at_its_width(void **state)
{
    struct stream *s = open_with_clock(2, 1000);
    (void)state;
    one(s, BLUE, 1, 0xfff0);
    one(s, BLUE, 2, 0x0010);
    stream_end(s);
    assert_true(clock_of(s, 0) == 0xfff0);
    assert_true(clock_of(s, 1) == 0x10010);
    stream_free(s);
}

static void without_a_timestamp_every_clock_is_0(void **state)
{
    struct stream *s = open_with_clock(0, GAP);
    (void)state;
    for (uint32_t line = 0; line < 20; line++) {
        two(s, BLUE, line, 1000000u * line);
    }
    stream_end(s);
    assert_int_equal(counters(s)->lines, 20);
    for (size_t i = 0; i < 20; i++) {
        assert_true(clock_of(s, i) == 0);
    }
    stream_free(s);
}

/* 2. Stray and break */

static void a_packet_at_gap_us_belongs_to_the_stream(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 500000 + GAP), LUM_OK);
    assert_int_equal(one(s, BLUE, 3, 500000 + 2 * GAP), LUM_OK);
    assert_int_equal(one(s, BLUE, 4, 500000 + GAP), LUM_OK);
    assert_int_equal(counters(s)->stray, 0);
    stream_free(s);
}

static void a_packet_past_gap_us_is_a_stray(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 500000 + GAP + 1), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 500000 - GAP - 1), LUM_E_STRAY);
    assert_int_equal(counters(s)->stray, 2);
    stream_end(s);
    ASSERT_LINES(s, 1);
    stream_free(s);
}

static void newest_is_the_largest_clock_not_the_last(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, BLUE, 2, 450000);
    assert_int_equal(one(s, BLUE, 3, 500000 + GAP), LUM_OK);
    assert_int_equal(one(s, BLUE, 4, 500000 - 1), LUM_E_STRAY);
    stream_free(s);
}

static void a_microsecond_is_enough_to_be_newest(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 1, 499999), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 500001), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 500001 + GAP), LUM_OK);
    stream_free(s);
    s = stream_open();
    one(s, BLUE, 1, 500000);
    one(s, BLUE, 1, 499999);
    assert_int_equal(one(s, BLUE, 2, 500000 + GAP), LUM_OK);
    stream_free(s);
}

static void a_packet_half_a_wrap_away_is_a_stray(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 500000 + 0x80000000u), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 1, 500000), LUM_OK);
    stream_free(s);
}

/* As if forged jumps had led it there. */
static void move_clock(struct stream *s, int64_t by_us)
{
    s->assembler.stream.clock.lowest += (uint64_t)by_us;
    s->assembler.eye[BLUE].stream.newest_us += by_us;
}

static void a_clock_beyond_the_far_ends_is_a_stray_for_good(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 0xffffff00u);
    move_clock(s, (INT64_C(1) << 61) - (INT64_C(1) << 32));
    assert_int_equal(one(s, BLUE, 2, 0xffffffffu), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 0), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 0), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 0xffffffffu), LUM_OK);
    stream_free(s);
    s = stream_open();
    one(s, BLUE, 1, 0x100);
    move_clock(s, -(INT64_C(1) << 61));
    assert_int_equal(one(s, BLUE, 2, 0), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 0xffffffffu), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 0xffffffffu), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 0), LUM_OK);
    stream_free(s);
}

static void the_first_stray_has_no_candidate_wherever_it_is(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 0), LUM_E_STRAY);
    stream_free(s);
}

static void a_late_packet_may_be_the_newest(void **state)
{
    struct stream *s = open_with_clock(4, GAP);
    (void)state;
    for (uint32_t line = 0; line < 5; line++) {
        one(s, BLUE, line, 1000000);
    }
    assert_int_equal(one(s, BLUE, 0, 1000010), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 9, 1000010 + GAP), LUM_OK);
    stream_free(s);
}

static void each_eye_has_its_own_newest(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, GREEN, 1, 900000), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, GREEN, 2, 500000), LUM_E_STRAY);
    stream_free(s);
}

static void jump(struct stream *s, uint32_t line, uint32_t clock)
{
    assert_int_equal(one(s, BLUE, line, clock), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, line, clock), LUM_OK);
}

static void half_a_wrap_of_four_bytes_is_backwards(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 0x80000007u);
    jump(s, 2, 7);
    jump(s, 3, 0x80000006u); /* one less is forwards */
    stream_end(s);
    assert_true(find_line(s, BLUE, 2, 0)->clock_us == 7);
    assert_true(find_line(s, BLUE, 3, 0)->clock_us == 0x80000006);
    stream_free(s);
}

static void an_eye_goes_on_where_it_was_when_the_other_has_jumped(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, GREEN, 1, 500000);
    jump(s, 2, 900000);
    assert_int_equal(one(s, GREEN, 2, 500000 + GAP), LUM_OK);
    assert_int_equal(one(s, GREEN, 3, 500000 + 2 * GAP), LUM_OK);
    stream_free(s);
}

static void a_second_packet_there_proves_the_jump(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, BLUE, 2, 500000);
    jump(s, 3, 900000);
    ASSERT_LINES(s, 1, 2); /* all open lines closed in order */
    assert_int_equal(counters(s)->stray, 1);
    stream_end(s);
    ASSERT_LINES(s, 1, 2, 3); /* and the packet went on to its line */
    assert_true(clock_of(s, 2) == 900000);
    stream_free(s);
}

static void a_jump_behind_a_line_of_two_packets_opens_its_own(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    two(s, BLUE, 1, 500000);
    jump(s, 2, 900000);
    stream_end(s);
    ASSERT_LINES(s, 1, 2);
    assert_int_equal(nth_line(s, 0)->angle_count, 2);
    assert_int_equal(nth_line(s, 1)->angle_count, 1);
    stream_free(s);
}

static void a_jump_back_makes_newest_lower(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 900000);
    jump(s, 2, 500000);
    assert_int_equal(one(s, BLUE, 3, 500000 + GAP), LUM_OK);
    assert_int_equal(one(s, BLUE, 4, 900000), LUM_E_STRAY);
    stream_free(s);
}

static void the_candidate_reaches_gap_us(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 900000 + GAP + 1), LUM_E_STRAY);
    /* the second stray became the candidate */
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 900000 + GAP), LUM_OK);
    assert_int_equal(counters(s)->stray, 3);
    stream_free(s);
}

static void a_packet_of_the_stream_between_forgets_the_candidate(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 1, 500000), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_OK);
    stream_free(s);
}

static void the_other_eyes_packets_do_not_come_between(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, GREEN, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, GREEN, 1, 500000), LUM_OK);
    assert_int_equal(one(s, GREEN, 1, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_OK);
    stream_free(s);
}

static void the_candidate_is_spent_by_the_break(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_E_STRAY);
    assert_int_equal(one(s, BLUE, 2, 950000), LUM_OK);
    /* past gap_us from the newest, and within it of what was the candidate */
    assert_int_equal(one(s, BLUE, 3, 950000 - GAP - 1), LUM_E_STRAY);
    stream_free(s);
}

static void a_break_empties_the_list_of_closed_lines(void **state)
{
    struct stream *s = stream_new();
    s->config.gap_us = 100; /* closed lines within the span, yet far */
    stream_begin(s);
    (void)state;
    one(s, BLUE, 7, 10000);
    jump(s, 7, 10101);
    stream_end(s);
    ASSERT_LINES(s, 7, 7);
    assert_int_equal(counters(s)->late, 0);
    stream_free(s);
}

/* Far by the gap, and yet within the span of what was closed before. */
static void assert_forgotten(uint32_t first, uint32_t second)
{
    struct stream *s = stream_new();
    s->config.gap_us = 100;
    s->config.open_lines = 1;
    stream_begin(s);
    for (uint32_t line = 1; line < 5; line++) {
        one(s, BLUE, line, 10000);
    }
    jump(s, 11, 10101);
    assert_int_equal(one(s, BLUE, first, 10101), LUM_OK);
    assert_int_equal(one(s, BLUE, second, 10101), LUM_OK);
    assert_int_equal(one(s, BLUE, 11, 10101), LUM_E_LATE);
    assert_int_equal(counters(s)->late, 1);
    stream_free(s);
}

static void no_line_closed_before_a_break_is_known_after_it(void **state)
{
    (void)state;
    assert_forgotten(1, 2);
    assert_forgotten(2, 1);
    assert_forgotten(3, 4);
}

static void the_list_of_closed_lines_begins_again_after_a_break(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    for (uint32_t line = 1; line < 4; line++) {
        one(s, BLUE, line, 500000);
    }
    jump(s, 11, 900000);
    one(s, BLUE, 12, 900000);
    assert_int_equal(one(s, BLUE, 11, 900000), LUM_E_LATE);
    stream_free(s);
}

static void assert_restart(uint8_t r)
{
    struct stream *s = stream_new();
    s->config.reorder_lines = r;
    stream_begin(s);
    two(s, BLUE, 1, 500000);
    jump(s, 7, 0);
    assert_int_equal(one(s, BLUE, 7, 0), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 3), LUM_OK);
    assert_int_equal(counters(s)->late, 0);
    stream_free(s);
}

/* Where the clock is as small as the numbers of frames. */
static void no_line_is_known_after_a_restart(void **state)
{
    (void)state;
    assert_restart(1);
    assert_restart(8);
    assert_restart(LUM_REORDER_MAX);
}

static void numbers_of_before_a_break_may_come_again(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 1; line < 5; line++) {
        two(s, BLUE, line, 500000);
    }
    jump(s, 5, 900000);
    assert_int_equal(one(s, BLUE, 2, 900000), LUM_OK);
    ASSERT_LINES(s, 1, 2, 3, 4);
    stream_end(s);
    ASSERT_LINES(s, 1, 2, 3, 4, 5, 2);
    stream_free(s);
}

static void a_break_forgets_the_low_clock(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 0; line < 9; line++) {
        two(s, BLUE, line, 900000 + 3000 * line);
    }
    jump(s, 9, 500000);
    assert_int_equal(one(s, BLUE, 10, 460000), LUM_OK);
    assert_int_equal(counters(s)->late, 0);
    stream_free(s);
}

static void a_break_is_the_eyes_own(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, GREEN, 1, 500000);
    jump(s, 2, 900000);
    ASSERT_LINES(s, 1);
    assert_int_equal(nth_line(s, 0)->eye, BLUE);
    assert_int_equal(one(s, GREEN, 2, 500000), LUM_OK);
    stream_free(s);
}

/* 3. Its line */

static void a_packet_within_the_span_is_of_the_line(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 1, 500000 + SPAN), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 500000 - SPAN), LUM_OK);
    stream_end(s);
    ASSERT_LINES(s, 1);
    assert_int_equal(nth_line(s, 0)->angle_count, 3);
    assert_true(clock_of(s, 0) == 500000);
    stream_free(s);
}

static void a_newer_packet_closes_the_lines_through_its_number(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, BLUE, 2, 500000);
    one(s, BLUE, 3, 500000);
    assert_int_equal(one(s, BLUE, 2, 500000 + SPAN + 1), LUM_OK);
    ASSERT_LINES(s, 1, 2);
    stream_end(s);
    ASSERT_LINES(s, 1, 2, 3, 2);
    assert_true(clock_of(s, 3) == 500000 + SPAN + 1);
    stream_free(s);
}

static void an_older_packet_of_an_open_line_is_late(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 1, 500000 - SPAN - 1), LUM_E_LATE);
    assert_int_equal(counters(s)->late, 1);
    stream_end(s);
    ASSERT_LINES(s, 1);
    stream_free(s);
}

static void the_span_is_the_profiles(void **state)
{
    struct stream *s = stream_new();
    s->layout.profile.line_span_us = 5;
    stream_begin(s);
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 1, 500005), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 500006), LUM_OK);
    stream_end(s);
    ASSERT_LINES(s, 1, 1);
    stream_free(s);
}

static void the_span_may_be_0(void **state)
{
    struct stream *s = stream_new();
    s->layout.profile.line_span_us = 0;
    stream_begin(s);
    (void)state;
    one(s, BLUE, 1, 500000);
    assert_int_equal(one(s, BLUE, 1, 500000), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 499999), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 1, 500001), LUM_OK);
    stream_end(s);
    ASSERT_LINES(s, 1, 1);
    stream_free(s);
}

static void a_fifth_line_closes_the_one_opened_first(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, BLUE, 5, 500000);
    one(s, BLUE, 3, 500000);
    one(s, BLUE, 9, 500000);
    one(s, BLUE, 1, 500000);
    assert_int_equal(s->event_count, 0);
    one(s, BLUE, 7, 500000);
    ASSERT_LINES(s, 5);
    one(s, GREEN, 2, 500000);
    ASSERT_LINES(s, 5); /* each eye has its own four */
    stream_free(s);
}

static void a_caller_may_choose_one_open_line(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    one(s, BLUE, 1, 500000);
    one(s, GREEN, 1, 500000);
    one(s, BLUE, 2, 500000);
    one(s, BLUE, 3, 500000);
    ASSERT_LINES(s, 1, 2);
    stream_end(s);
    assert_int_equal(counters(s)->lines, 4);
    stream_free(s);
}

/* Without a clock no packet is older than any: only the list decides. */
static void one_of_the_last_r_closed_is_late(void **state)
{
    struct stream *s = open_with_clock(0, GAP);
    (void)state;
    for (uint32_t line = 0; line < 4 + 8; line++) {
        one(s, BLUE, line, 0);
    }
    for (uint32_t line = 0; line < 8; line++) {
        assert_int_equal(one(s, BLUE, line, 0), LUM_E_LATE);
    }
    assert_int_equal(one(s, BLUE, 12, 0), LUM_OK);
    assert_int_equal(one(s, BLUE, 1, 0), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 0, 0), LUM_OK); /* closed R + 1 lines ago */
    assert_int_equal(counters(s)->late, 9);
    stream_free(s);
}

static void of_fewer_than_r_closed_each_is_late(void **state)
{
    struct stream *s = open_with_clock(0, GAP);
    (void)state;
    for (uint32_t line = 0; line < 4 + 3; line++) {
        one(s, BLUE, line, 0);
    }
    for (uint32_t line = 0; line < 3; line++) {
        assert_int_equal(one(s, BLUE, line, 0), LUM_E_LATE);
    }
    stream_free(s);
}

static void nothing_is_closed_before_the_first_line(void **state)
{
    (void)state;
    for (uint8_t r = 1; r <= LUM_REORDER_MAX; r++) {
        struct stream *s = stream_new();
        s->config.reorder_lines = r;
        stream_begin(s);
        assert_int_equal(one(s, BLUE, 0, 0), LUM_OK);
        stream_free(s);
    }
}

static void r_may_be_chosen(void **state)
{
    struct stream *s = stream_new();
    s->config.reorder_lines = 1;
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    for (uint32_t line = 0; line < 3; line++) {
        one(s, BLUE, line, 0);
    }
    assert_int_equal(one(s, BLUE, 1, 0), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 0, 0), LUM_OK);
    stream_free(s);
}

/* Lines with one packet have no low clock, so this is the list's doing. */
static void a_closed_line_is_known_within_the_span(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 0; line < 5; line++) {
        one(s, BLUE, line, 500000);
    }
    assert_int_equal(one(s, BLUE, 0, 500000 + SPAN), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 0, 500000 - SPAN), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 0, 500000 + SPAN + 1), LUM_OK);
    stream_free(s);
}

static void a_closed_line_is_not_known_before_the_span(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 0; line < 5; line++) {
        one(s, BLUE, line, 500000);
    }
    assert_int_equal(one(s, BLUE, 0, 500000 - SPAN - 1), LUM_OK);
    stream_free(s);
}

/* Closes line 0, whose two packets have the clocks a and b. */
static struct stream *with_low_clock(uint32_t a, uint32_t b)
{
    struct stream *s = stream_open();
    one(s, BLUE, 0, a);
    one(s, BLUE, 0, b);
    for (uint32_t line = 1; line < 5; line++) {
        assert_int_equal(one(s, BLUE, line, 510000), LUM_OK);
    }
    assert_int_equal(count_events(s, LUM_LINE_READY), 1);
    return s;
}

static void older_than_the_low_clock_is_late(void **state)
{
    struct stream *s = with_low_clock(500000, 500000);
    (void)state;
    assert_int_equal(one(s, BLUE, 77, 499999), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 77, 500000), LUM_OK);
    stream_free(s);
}

static void the_low_clock_is_the_lines_smallest(void **state)
{
    struct stream *s = with_low_clock(500000, 498500);
    (void)state;
    assert_int_equal(one(s, BLUE, 77, 498499), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 77, 498500), LUM_OK);
    stream_free(s);
    s = with_low_clock(500000, 501500);
    assert_int_equal(one(s, BLUE, 77, 499999), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 77, 500000), LUM_OK);
    stream_free(s);
}

/* Closes two lines of these low clocks. */
static void assert_largest_low_clock(uint32_t first, uint32_t second)
{
    struct stream *s = stream_open();
    two(s, BLUE, 0, first);
    two(s, BLUE, 1, second);
    for (uint32_t line = 2; line < 6; line++) {
        one(s, BLUE, line, 510000);
    }
    ASSERT_LINES(s, 0, 1);
    assert_int_equal(one(s, BLUE, 77, 499999), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 77, 500000), LUM_OK);
    stream_free(s);
}

static void the_largest_low_clock_counts(void **state)
{
    (void)state;
    assert_largest_low_clock(500000, 450000);
    assert_largest_low_clock(450000, 500000);
}

static void a_low_clock_may_be_below_zero(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, GREEN, 0, 0);
    two(s, BLUE, 0, 0u - 5000u);
    for (uint32_t line = 1; line < 5; line++) {
        one(s, BLUE, line, 0);
    }
    ASSERT_LINES(s, 0);
    assert_int_equal(one(s, BLUE, 77, 0u - 5001u), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 77, 0u - 5000u), LUM_OK);
    stream_free(s);
}

static void a_dropped_packet_has_no_say_in_the_low_clock(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    two(s, BLUE, 0, 500000);
    send_angles(s, BLUE, 0, 500000, 900, 10);
    assert_int_equal(send_angles(s, BLUE, 0, 498500, 900, 10), LUM_E_DUPLICATE);
    for (uint32_t line = 1; line < 5; line++) {
        one(s, BLUE, line, 510000);
    }
    assert_int_equal(one(s, BLUE, 77, 499999), LUM_E_LATE);
    stream_free(s);
}

static void one_packet_ahead_of_its_time_deafens_nobody(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    two(s, BLUE, 0, 500000);
    assert_int_equal(one(s, BLUE, 40, 500000 + 90000), LUM_OK);
    for (uint32_t line = 1; line < 20; line++) {
        two(s, BLUE, line, 500000 + 1000 * line);
    }
    stream_end(s);
    assert_int_equal(counters(s)->late, 0);
    assert_int_equal(counters(s)->lines, 21);
    stream_free(s);
}

static void a_repeat_of_that_packet_deafens_nobody_either(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    two(s, BLUE, 0, 500000);
    assert_int_equal(send_angles(s, BLUE, 40, 590000, 3, 1), LUM_OK);
    assert_int_equal(send_angles(s, BLUE, 40, 590000, 3, 1), LUM_E_DUPLICATE);
    for (uint32_t line = 1; line < 20; line++) {
        two(s, BLUE, line, 500000 + 1000 * line);
    }
    assert_int_equal(counters(s)->late, 0);
    stream_free(s);
}

static void late_is_judged_for_each_eye(void **state)
{
    struct stream *s = with_low_clock(500000, 500000);
    (void)state;
    assert_int_equal(one(s, GREEN, 0, 499000), LUM_OK);
    assert_int_equal(one(s, GREEN, 77, 498000), LUM_OK);
    stream_free(s);
}

static void a_packet_is_judged_before_a_line_closes_for_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 1; line < 5; line++) {
        two(s, BLUE, line, 510000);
    }
    assert_int_equal(one(s, BLUE, 5, 505000), LUM_OK); /* and closes line 1 */
    ASSERT_LINES(s, 1);
    assert_int_equal(one(s, BLUE, 6, 505000), LUM_E_LATE);
    stream_free(s);
}

static void a_late_packet_closes_no_line(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (uint32_t line = 0; line < 5; line++) {
        one(s, BLUE, line, 500000);
    }
    ASSERT_LINES(s, 0);
    assert_int_equal(one(s, BLUE, 0, 500000), LUM_E_LATE);
    assert_int_equal(one(s, BLUE, 3, 500000), LUM_OK);
    ASSERT_LINES(s, 0);
    stream_free(s);
}

/* 4. Duplicate, conflict, no room */

static void angles_that_are_all_there_are_a_duplicate(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_angles(s, BLUE, 1, 0, 100, 334);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 100, 334), LUM_E_DUPLICATE);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 433, 1), LUM_E_DUPLICATE);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 100, 1), LUM_E_DUPLICATE);
    assert_int_equal(counters(s)->duplicate, 3);
    stream_free(s);
}

static void angles_of_which_some_are_there_are_a_conflict(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_angles(s, BLUE, 1, 0, 100, 100);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 199, 2), LUM_E_CONFLICT);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 99, 2), LUM_E_CONFLICT);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 0, 1000), LUM_E_CONFLICT);
    assert_int_equal(counters(s)->conflict, 3);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 200, 1), LUM_OK);
    assert_int_equal(send_angles(s, BLUE, 1, 0, 99, 1), LUM_OK);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->angle_count, 102);
    stream_free(s);
}

/* Every cut of the marks' words. */
static void a_conflict_leaves_the_marks_as_they_were(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 0, 40), LUM_OK);
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 20, 60), LUM_E_CONFLICT);
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 0, 40), LUM_E_DUPLICATE);
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 40, 40), LUM_OK);
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 60, 60), LUM_E_CONFLICT);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->angle_count, 80);
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        assert_int_equal(lum_line_has_angles(nth_line(s, 0), p), p < 80);
    }
    stream_free(s);
}

static void angles_of_every_cut_are_told_apart(void **state)
{
    (void)state;
    for (uint32_t first = 0; first < 70; first++) {
        for (uint32_t n = 1; n < 70; n++) {
            struct stream *s = open_with_words(1);
            assert_int_equal(send_angles(s, BLUE, 1, 0, first, n), LUM_OK);
            if (first > 0) {
                assert_int_equal(send_angles(s, BLUE, 1, 0, 0, first), LUM_OK);
            }
            assert_int_equal(
                send_angles(s, BLUE, 1, 0, first + n, 1000 - first - n),
                LUM_OK);
            stream_end(s);
            assert_int_equal(nth_line(s, 0)->angle_count, 1000);
            for (uint32_t w = 0; w < LUM_PIXEL_MARK_WORDS; w++) {
                assert_int_equal(nth_line(s, 0)->angle_marks[w],
                                 w < 31 ? 0xffffffffu : 0xffu);
            }
            stream_free(s);
        }
    }
}

static void ranges_that_are_all_there_are_a_duplicate(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_pixels(s, BLUE, 1, 0, 100, 50);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 100, 50), LUM_E_DUPLICATE);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, WORDS(DOWN(9, 149)), 1),
                     LUM_E_DUPLICATE);
    assert_int_equal(counters(s)->duplicate, 2);
    stream_end(s);
    assert_int_equal(counters(s)->words, 50);
    stream_free(s);
}

static void a_duplicate_is_told_by_pixels_however_many_words_they_have(
    void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 5), DOWN(2, 5), UP(1, 6)), 3);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 5)), 1),
                     LUM_E_DUPLICATE);
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 6), DOWN(2, 6)), 2),
        LUM_E_DUPLICATE);
    stream_free(s);
}

static void a_word_of_any_pixel_that_is_there_is_a_duplicate(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(send_pixels(s, BLUE, 1, 5000, 0, 40), LUM_OK);
    for (uint32_t pixel = 0; pixel < 40; pixel++) {
        assert_int_equal(send_pixels(s, BLUE, 1, 5000, pixel, 1),
                         LUM_E_DUPLICATE);
    }
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->word_count, 40);
    stream_free(s);
}

static void ranges_of_which_some_are_there_are_a_conflict(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_pixels(s, BLUE, 1, 0, 100, 50);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 149, 2), LUM_E_CONFLICT);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 99, 2), LUM_E_CONFLICT);
    assert_int_equal(counters(s)->conflict, 2);
    stream_end(s);
    assert_int_equal(counters(s)->words, 50);
    stream_free(s);
}

static void only_good_words_tell_a_duplicate(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_pixels(s, BLUE, 1, 0, 5, 1);
    /* the bad word's pixel 5 is no word of pixel 5 */
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, WORDS(BAD, UP(1, 6)), 2),
                     LUM_OK);
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 6), LUM_WORD_ZERO | 7u), 2),
        LUM_E_DUPLICATE);
    stream_end(s);
    assert_int_equal(counters(s)->words, 2);
    stream_free(s);
}

static void the_last_pixel_of_one_line_is_no_word_of_the_next(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_pixels(s, BLUE, 1, 0, 999, 1);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 5, 1), LUM_OK);
    send_pixels(s, GREEN, 1, 0, 6, 1);
    assert_int_equal(
        send_words(s, GREEN, 1, 0, 0, WORDS(UP(1, 999), UP(2, 5)), 2), LUM_OK);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(UP(1000, 5), UP(1000, 999)), 2);
    assert_words(nth_line(s, 1), WORDS(UP(2, 5), UP(1000, 6), UP(1, 999)), 3);
    stream_free(s);
}

static void bad_words_of_a_dropped_packet_are_not_counted(void **state)
{
    struct stream *s = open_with_words(4);
    (void)state;
    send_pixels(s, BLUE, 1, 0, 5, 2);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, WORDS(BAD, UP(1, 5)), 2),
                     LUM_E_DUPLICATE);
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0, WORDS(BAD, UP(1, 5), UP(1, 9)), 3),
        LUM_E_CONFLICT);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0,
                                WORDS(BAD, UP(1, 7), UP(1, 8), UP(1, 9)), 4),
                     LUM_E_NO_ROOM);
    assert_int_equal(counters(s)->bad_words, 0);
    stream_free(s);
}

static void bad_words_are_skipped_alone(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(send_words(s, BLUE, 1, 0, 0,
                                WORDS(UP(1, 0), BAD, UP(2, 1), UP(3, 1000),
                                      UP(4, 999), UP(5, 1023)),
                                6),
                     LUM_OK);
    assert_int_equal(counters(s)->bad_words, 3);
    stream_end(s);
    const lum_line *line = nth_line(s, 0);
    assert_int_equal(line->word_count, 3);
    assert_int_equal(line->words[0], UP(1, 0));
    assert_int_equal(line->words[1], UP(2, 1));
    assert_int_equal(line->words[2], UP(4, 999));
    assert_int_equal(line->lost_words, 0);
    stream_free(s);
}

static void good_words_behind_many_bad_ones_keep_their_pixels(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0,
                   WORDS(BAD, BAD, BAD, BAD, UP(1, 1), UP(2, 2), UP(3, 2)), 7),
        LUM_OK);
    stream_end(s);
    const lum_line *line = nth_line(s, 0);
    assert_int_equal(line->word_count, 3);
    assert_int_equal(line->words[0], UP(1, 1));
    assert_int_equal(line->words[1], UP(2, 2));
    assert_int_equal(line->words[2], UP(3, 2));
    stream_free(s);
}

static void a_packet_of_bad_words_alone_is_accepted(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(send_words(s, BLUE, 30, 500000, 0, WORDS(BAD, BAD), 2),
                     LUM_OK);
    assert_int_equal(send_words(s, BLUE, 30, 500000, 0, WORDS(BAD, BAD), 2),
                     LUM_OK);
    assert_int_equal(counters(s)->bad_words, 4);
    /* being accepted, two of them make a line that counts */
    for (uint32_t line = 31; line < 35; line++) {
        one(s, BLUE, line, 510000);
    }
    assert_int_equal(one(s, BLUE, 77, 499999), LUM_E_LATE);
    stream_free(s);
}

static void bad_words_alone_find_room_in_a_full_line(void **state)
{
    struct stream *s = open_with_words(2);
    (void)state;
    send_pixels(s, BLUE, 1, 0, 5, 2);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, WORDS(BAD), 1), LUM_OK);
    assert_int_equal(counters(s)->no_room, 0);
    stream_free(s);
}

static void words_that_do_not_all_fit_are_dropped_whole(void **state)
{
    struct stream *s = open_with_words(10);
    (void)state;
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 500, 7), LUM_OK);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 600, 4), LUM_E_NO_ROOM);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 100, 4), LUM_E_NO_ROOM);
    assert_int_equal(counters(s)->no_room, 2);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 600, 3), LUM_OK);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 700, 1), LUM_E_NO_ROOM);
    stream_end(s);
    assert_int_equal(counters(s)->words, 10);
    stream_free(s);
}

/* One more than any line can hold, of one pixel. */
static void a_packet_of_more_words_than_a_line_has_no_room(void **state)
{
    const uint32_t n = LUM_LINE_WORDS_MAX + 1u;
    uint32_t *words = malloc(n * sizeof *words);
    (void)state;
    assert_non_null(words);
    for (uint32_t i = 0; i < n; i++) {
        words[i] = UP(1, 5);
    }
    struct stream *s = open_with_words(LUM_LINE_WORDS_MAX);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n), LUM_E_NO_ROOM);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n - 1u), LUM_OK);
    stream_free(s);
    free(words);
}

static void only_good_words_need_room(void **state)
{
    struct stream *s = open_with_words(3);
    (void)state;
    send_pixels(s, BLUE, 1, 0, 5, 2);
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0, WORDS(BAD, UP(1, 9), BAD, BAD), 4),
        LUM_OK);
    stream_end(s);
    assert_int_equal(counters(s)->words, 3);
    stream_free(s);
}

static void a_duplicate_is_told_before_the_room(void **state)
{
    struct stream *s = open_with_words(3);
    (void)state;
    send_pixels(s, BLUE, 1, 0, 5, 3);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 5, 3), LUM_E_DUPLICATE);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 5, 4), LUM_E_CONFLICT);
    assert_int_equal(counters(s)->no_room, 0);
    stream_free(s);
}

static void words_of_a_pixel_are_counted_beyond_16_bits(void **state)
{
    const uint32_t n = 65536;
    struct stream *s = stream_new();
    uint32_t *words = malloc((n + 1u) * sizeof *words);
    (void)state;
    assert_non_null(words);
    s->layout.profile.group[LUM_FIELD_NUM_SAMPLES] =
        (lum_field){.at = 24, .bytes = 4};
    s->layout.profile.samples_at = 28;
    stream_begin(s);
    for (uint32_t i = 0; i < n; i++) {
        words[i] = UP(1, 7);
    }
    words[n] = UP(1, 8);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n), LUM_E_NO_ROOM);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words + n - 1u, 1), LUM_OK);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n), LUM_E_DUPLICATE);
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n + 1u),
                     LUM_E_CONFLICT);
    free(words);
    stream_free(s);
}

static void what_is_dropped_leaves_its_line_open(void **state)
{
    struct stream *s = open_with_words(3);
    (void)state;
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 5, 4), LUM_E_NO_ROOM);
    assert_int_equal(send_pixels(s, BLUE, 1, 0, 5, 3), LUM_OK);
    stream_end(s);
    ASSERT_LINES(s, 1);
    assert_int_equal(nth_line(s, 0)->word_count, 3);
    stream_free(s);
}

/* 5. A closed line */

static void an_arrival_may_be_0(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    s->arrival = -1;
    assert_int_equal(send_angles(s, BLUE, 1, 5000, 0, 1), LUM_OK);
    assert_int_equal(send_angles(s, BLUE, 2, 10000, 0, 1), LUM_OK);
    assert_int_equal(one(s, BLUE, 2, 10000), LUM_OK);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->arrival, -1);
    assert_int_equal(nth_line(s, 1)->arrival, 0);
    stream_free(s);
}

static void a_line_bears_what_its_packets_brought(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    s->arrival = 4711;
    send_angles(s, GREEN, 40, 500000, 0, 334);
    send_angles(s, GREEN, 40, 500000, 668, 332);
    send_pixels(s, GREEN, 40, 500000, 10, 2);
    stream_end(s);
    const lum_line *line = nth_line(s, 0);
    assert_true(line->frame == 1);
    assert_true(line->clock_us == 500000);
    assert_true(line->arrival == 4711);
    assert_int_equal(line->number, 40);
    assert_int_equal(line->eye, GREEN);
    assert_int_equal(line->angle_count, 666);
    assert_int_equal(line->word_count, 2);
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        const int marked = pixel < 334 || pixel >= 668;
        assert_int_equal(lum_line_has_angles(line, pixel), marked);
        assert_int_equal(line->angles[pixel].azimuth,
                         marked ? 3 * (int)pixel + 40 : 0);
        assert_int_equal(line->angles[pixel].elevation,
                         marked ? -(int)pixel : 0);
    }
    assert_int_equal(line->angle_marks[31] >> 8, 0);
    stream_free(s);
}

static void angles_may_come_elevation_first(void **state)
{
    struct stream *s = stream_new();
    s->layout.profile.angle_order = LUM_ELEVATION_AZIMUTH;
    stream_begin(s);
    (void)state;
    send_angles(s, BLUE, 40, 500000, 7, 2);
    stream_end(s);
    for (int pixel = 7; pixel < 9; pixel++) {
        const lum_angle angle = nth_line(s, 0)->angles[pixel];
        assert_int_equal(angle.azimuth, 3 * pixel + 40);
        assert_int_equal(angle.elevation, -pixel);
    }
    stream_free(s);
}

static void a_slot_used_again_is_empty(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    send_angles(s, BLUE, 1, 500000, 0, 1000);
    send_pixels(s, BLUE, 1, 500000, 0, 1000);
    send_angles(s, BLUE, 2, 500000, 500, 1);
    stream_end(s);
    const lum_line *line = nth_line(s, 1);
    assert_int_equal(line->angle_count, 1);
    assert_int_equal(line->word_count, 0);
    assert_int_equal(line->lost_words, 0);
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        assert_int_equal(lum_line_has_angles(line, pixel), pixel == 500);
        assert_true(pixel == 500 || (line->angles[pixel].azimuth == 0 &&
                                     line->angles[pixel].elevation == 0));
    }
    stream_free(s);
}

static void the_one_pixel_that_is_missing_is_empty_too(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    send_angles(s, BLUE, 1, 500000, 0, 1000);
    send_angles(s, BLUE, 2, 500000, 0, 999);
    stream_end(s);
    const lum_angle last = nth_line(s, 1)->angles[999];
    assert_true(last.azimuth == 0 && last.elevation == 0);
    stream_free(s);
}

/* As many as can be open, of both eyes. */
static void open_lines_share_no_storage(void **state)
{
    struct stream *s = open_with_words(4);
    (void)state;
    for (uint32_t line = 0; line < 4; line++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            send_angles(s, eye, line, 500000, 10 * line + eye, 1);
            send_words(s, eye, line, 500000, 0,
                       WORDS(UP((int32_t)(10 * line + eye), 3), UP(0, 4),
                             UP(0, 5), UP(0, 6)),
                       4);
        }
    }
    stream_end(s);
    for (uint32_t line = 0; line < 4; line++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            const lum_line *out = find_line(s, eye, line, 0);
            assert_int_equal(out->words[0], UP((int32_t)(10 * line + eye), 3));
            assert_int_equal(out->angle_count, 1);
            assert_true(lum_line_has_angles(out, 10 * line + eye));
        }
    }
    stream_free(s);
}

static void a_pixel_past_the_last_is_skipped_behind_those_in_order(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(
        send_words(s, BLUE, 1, 0, 0,
                   WORDS(UP(1, 998), UP(2, 999), UP(3, 1000), UP(4, 1023)), 4),
        LUM_OK);
    stream_end(s);
    assert_int_equal(counters(s)->bad_words, 2);
    assert_words(nth_line(s, 0), WORDS(UP(1, 998), UP(2, 999)), 2);
    stream_free(s);
}

static void words_of_an_earlier_line_do_not_tell_the_order(void **state)
{
    struct stream *s = stream_new();
    (void)state;
    s->config.open_lines = 1;
    stream_begin(s);
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), UP(2, 1), UP(3, 2), UP(4, 3)),
               4);
    send_words(s, BLUE, 2, 0, 0, WORDS(UP(5, 5), UP(6, 9)), 2);
    send_words(s, BLUE, 2, 0, 2, WORDS(UP(7, 7)), 1);
    stream_end(s);
    assert_words(nth_line(s, 1), WORDS(UP(5, 5), UP(7, 7), UP(6, 9)), 3);
    stream_free(s);
}

static void pixel_1000_is_past_the_last(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 999), UP(2, 1000)), 2);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(UP(1, 999)), 1);
    assert_int_equal(counters(s)->bad_words, 1);
    stream_free(s);
}

/* Out of order, so that pixels are counted; what stands behind the assembler is
 * known. */
static void pixel_1000_is_not_counted_either(void **state)
{
    static struct {
        lum_assembler assembler;
        uint32_t behind[4];
    } x;
    static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(1)];
    static uint32_t words[LUM_ASSEMBLER_WORDS(1, 8)];
    static lum_reach reach[LUM_ASSEMBLER_REACH(1)];
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    const lum_assembler_config config = {
        .open_lines = 1, .reorder_lines = 1, .words_per_line = 8};
    const uint32_t sent[] = {UP(1, 5), UP(2, 1000), UP(3, 4)};
    uint8_t samples[sizeof sent];
    const lum_group group = {
        .samples = samples, .num_samples = 3, .tag = LUM_TAG_RANGES};
    lum_layout layout;
    (void)state;
    lum_layout_default(&layout);
    for (size_t i = 0; i < 3; i++) {
        lum_word_encode(sent[i], samples + LUM_SAMPLE_BYTES * i);
    }
    assert_int_equal(
        lum_assembler_init(&x.assembler, &config, &layout, &storage), LUM_OK);
    assert_int_equal(lum_assembler_push(&x.assembler, &group, 0), LUM_OK);
    assert_int_equal(lum_assembler_flush(&x.assembler), LUM_LINE_READY);
    assert_int_equal(lum_assembler_counters(&x.assembler)->bad_words, 1);
    assert_words(lum_assembler_line(&x.assembler), WORDS(UP(3, 4), UP(1, 5)),
                 2);
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(x.behind[i], 0);
    }
}

static void words_stand_by_pixel_then_as_in_their_packet(void **state)
{
    struct stream *s = stream_open();
    const uint32_t sent[] = {UP(9, 7),   UP(1, 3), DOWN(8, 7), UP(7, 7),
                             UP(5, 999), UP(2, 0), DOWN(1, 3)};
    const uint32_t kept[] = {UP(2, 0),   UP(1, 3), DOWN(1, 3), UP(9, 7),
                             DOWN(8, 7), UP(7, 7), UP(5, 999)};
    (void)state;
    send_words(s, BLUE, 1, 0, 0, sent, 7);
    stream_end(s);
    assert_words(nth_line(s, 0), kept, 7);
    stream_free(s);
}

/* Three words in one packet, the last of which is in its place. */
static void assert_sorted(uint32_t a, uint32_t b, uint32_t c)
{
    struct stream *s = stream_open();
    send_words(s, BLUE, 1, 0, 0, WORDS(a, b, c), 3);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(b, a, c), 3);
    stream_free(s);
}

static void words_of_any_bits_above_are_sorted_by_pixel(void **state)
{
    (void)state;
    assert_sorted(UP(1, 5), UP(1, 4), UP(1, 9));
    assert_sorted(UP(1, 512), UP(1, 511), UP(1, 999));
    assert_sorted(DOWN(1, 5), DOWN(1, 4), DOWN(1, 9));
    assert_sorted(UP(-1, 5), UP(-1, 4), UP(-1, 9));
    assert_sorted(UP(-1, 5), UP(1, 4), UP(-1, 9));
    assert_sorted(UP(1, 5), UP(-1, 4), UP(1, 9));
    assert_sorted(DOWN(LUM_TOF_MIN, 999), DOWN(LUM_TOF_MAX, 0), UP(0, 999));
}

/* One bad word between good ones, all in order. */
static void assert_skipped(uint32_t a, uint32_t bad, uint32_t c)
{
    struct stream *s = stream_open();
    send_words(s, BLUE, 1, 0, 0, WORDS(a, bad, c), 3);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(a, c), 2);
    assert_int_equal(counters(s)->bad_words, 1);
    stream_free(s);
}

static void a_bad_word_is_skipped_between_words_in_order(void **state)
{
    (void)state;
    assert_skipped(UP(1, 4), LUM_WORD_ZERO | 5u, UP(1, 6));
    assert_skipped(DOWN(1, 0), LUM_WORD_ZERO, DOWN(2, 0));
}

static void a_bad_word_is_skipped_before_words_in_order(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(BAD, UP(1, 6)), 2);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(UP(1, 6)), 1);
    assert_int_equal(counters(s)->bad_words, 1);
    stream_free(s);
}

static void a_packet_behind_a_line_of_one_word_is_sorted_too(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 9)), 1);
    assert_int_equal(send_words(s, BLUE, 1, 0, 1, WORDS(UP(2, 9)), 1),
                     LUM_E_DUPLICATE);
    send_words(s, BLUE, 1, 0, 1, WORDS(UP(2, 5)), 1);
    stream_end(s);
    assert_words(nth_line(s, 0), WORDS(UP(2, 5), UP(1, 9)), 2);
    stream_free(s);
}

static void packets_interleave_by_pixel(void **state)
{
    struct stream *s = stream_open();
    const uint32_t kept[] = {UP(1, 2), UP(2, 4), UP(3, 4), UP(4, 6),
                             UP(5, 8), UP(6, 8), UP(7, 10)};
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(2, 4), UP(3, 4), UP(5, 8), UP(6, 8)),
               4);
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 2), UP(4, 6), UP(7, 10)), 3);
    stream_end(s);
    assert_words(nth_line(s, 0), kept, 7);
    stream_free(s);
}

/* Stable insertion into a list, one word at a time. */
static size_t insert_stable(uint32_t *words, size_t n, uint32_t word)
{
    size_t at = n;
    while (at > 0 && lum_word_pixel(words[at - 1]) > lum_word_pixel(word)) {
        words[at] = words[at - 1];
        at--;
    }
    words[at] = word;
    return n + 1;
}

/* Packets of every third pixel, each pixel's words scattered over one. */
static void random_orders_end_sorted_and_stable(void **state)
{
    uint64_t seed = 7;
    (void)state;
    for (unsigned round = 0; round < 200; round++) {
        struct stream *s = open_with_words(200);
        uint32_t kept[200];
        size_t n = 0;
        for (uint32_t part = 0; part < 3; part++) {
            uint32_t words[60];
            const uint32_t count = 1 + next_random(&seed) % 60;
            for (uint32_t i = 0; i < count; i++) {
                const uint32_t pixel = 3 * (next_random(&seed) % 30) + part;
                words[i] = UP((int32_t)(1000 * part + i), pixel);
                n = insert_stable(kept, n, words[i]);
            }
            assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, count),
                             LUM_OK);
        }
        stream_end(s);
        assert_words(nth_line(s, 0), kept, n);
        stream_free(s);
    }
}

static void the_end_closes_blue_in_order_then_green(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    one(s, GREEN, 9, 500000);
    one(s, BLUE, 5, 500000);
    one(s, GREEN, 8, 500000);
    one(s, BLUE, 3, 500000);
    stream_end(s);
    ASSERT_LINES(s, 5, 3, 9, 8);
    assert_int_equal(nth_line(s, 1)->eye, BLUE);
    assert_int_equal(nth_line(s, 2)->eye, GREEN);
    stream_free(s);
}

static void a_stream_of_nothing_ends_at_once(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    stream_end(s);
    stream_end(s);
    assert_int_equal(s->event_count, 0);
    assert_int_equal(counters(s)->lines, 0);
    assert_int_equal(counters(s)->frames, 0);
    stream_free(s);
}

static void the_end_may_be_asked_for_twice(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    two(s, BLUE, 3, 500000);
    two(s, BLUE, 9, 500000);
    stream_end(s);
    const size_t events = s->event_count;
    const uint64_t skipped = counters(s)->lines_skipped;
    stream_end(s);
    assert_int_equal(s->event_count, events);
    assert_int_equal(counters(s)->lines_skipped, skipped);
    assert_int_equal(skipped, 5);
    stream_free(s);
}

/* 6. Counters */

static uint64_t lost_by(const struct stream *s)
{
    return counters(s)->lost_words;
}

static void lost_words_are_what_the_index_says_is_missing(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), UP(1, 1)), 2);
    send_words(s, BLUE, 1, 0, 7, WORDS(UP(1, 7), UP(1, 8)), 2);
    send_words(s, BLUE, 2, 0, 3, WORDS(UP(1, 7)), 1);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->lost_words, 5);
    assert_int_equal(nth_line(s, 1)->lost_words, 3);
    assert_int_equal(lost_by(s), 5 + 3);
    assert_int_equal(counters(s)->words, 4 + 1);
    stream_free(s);
}

static void lost_words_are_those_of_the_largest_sum(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 7, WORDS(UP(1, 7), UP(1, 8)), 2);
    send_words(s, BLUE, 1, 0, 4, WORDS(UP(1, 4), UP(1, 5)), 2);
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), UP(1, 1)), 2);
    send_words(s, BLUE, 2, 0, 7, WORDS(UP(1, 7), UP(1, 8)), 2);
    send_words(s, BLUE, 2, 0, 1, WORDS(UP(1, 1), UP(1, 2)), 2);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->lost_words, 3);
    assert_int_equal(nth_line(s, 1)->lost_words, 5);
    assert_int_equal(lost_by(s), 3 + 5);
    stream_free(s);
}

static void assert_put_in_order(const uint32_t *words, uint32_t n)
{
    struct stream *s = stream_open();
    assert_int_equal(send_words(s, BLUE, 1, 0, 0, words, n), LUM_OK);
    stream_end(s);
    const lum_line *line = nth_line(s, 0);
    assert_int_equal(line->word_count, n);
    for (uint32_t i = 1; i < n; i++) {
        assert_true(lum_word_pixel(line->words[i - 1u]) <=
                    lum_word_pixel(line->words[i]));
    }
    stream_free(s);
}

/* Wherever in the packet, and whatever the ranges. */
static void one_word_out_of_order_is_seen(void **state)
{
    (void)state;
    assert_put_in_order(
        WORDS(UP(1, 0), UP(2, 0), UP(3, 0), UP(4, 0), UP(5, 1), UP(6, 0)), 6);
    assert_put_in_order(
        WORDS(UP(1, 1), UP(2, 5), UP(3, 6), UP(4, 7), UP(5, 8), UP(6, 7)), 6);
    assert_put_in_order(WORDS(UP(-1, 5), lum_word_make(0, false, 3)), 2);
}

static void bad_words_are_not_lost(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), BAD, BAD), 3);
    send_words(s, BLUE, 1, 0, 3, WORDS(BAD), 1);
    stream_end(s);
    assert_int_equal(lost_by(s), 0);
    stream_free(s);
}

static void a_packet_of_bad_words_alone_shows_what_is_lost(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 9, WORDS(BAD), 1);
    stream_end(s);
    assert_int_equal(lost_by(s), 9);
    stream_free(s);
}

static void lost_words_are_never_below_0(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), UP(1, 1), UP(1, 2)), 3);
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 3), UP(1, 4), UP(1, 5)), 3);
    stream_end(s);
    assert_int_equal(lost_by(s), 0);
    stream_free(s);
}

static void words_past_the_lines_are_not_lost(void **state)
{
    struct stream *s = open_with_words(4);
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(BAD, BAD, BAD), 3);
    send_words(s, BLUE, 1, 0, 2, WORDS(BAD, BAD), 2);
    send_words(s, BLUE, 2, 0, 0, WORDS(BAD, BAD, BAD), 3);
    send_words(s, BLUE, 2, 0, 0, WORDS(BAD, BAD), 2);
    stream_end(s);
    assert_int_equal(lost_by(s), 0);
    stream_free(s);
}

static void sums_beyond_a_lines_words_are_not_believed(void **state)
{
    struct stream *s = open_with_words(100);
    (void)state;
    send_words(s, BLUE, 1, 0, 99, WORDS(UP(1, 0)), 1);
    send_words(s, BLUE, 2, 0, 100, WORDS(UP(1, 0)), 1);
    send_words(s, BLUE, 3, 0, 65535, WORDS(UP(1, 0)), 1);
    send_words(s, BLUE, 3, 0, 4, WORDS(UP(1, 1)), 1);
    stream_end(s);
    assert_int_equal(find_line(s, BLUE, 1, 0)->lost_words, 99);
    assert_int_equal(find_line(s, BLUE, 2, 0)->lost_words, 0);
    assert_int_equal(find_line(s, BLUE, 3, 0)->lost_words, 3);
    stream_free(s);
}

static void an_index_at_the_end_of_32_bits_is_not_believed(void **state)
{
    struct stream *s = stream_new();
    s->layout.profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 24, .bytes = 4};
    s->layout.profile.samples_at = 28;
    stream_begin(s);
    (void)state;
    send_words(s, BLUE, 1, 0, 0xffffffffu, WORDS(UP(1, 0), UP(1, 1)), 2);
    stream_end(s);
    assert_int_equal(lost_by(s), 0);
    stream_free(s);
}

static void dropped_packets_show_nothing_lost(void **state)
{
    struct stream *s = open_with_words(16);
    (void)state;
    send_words(s, BLUE, 1, 0, 0, WORDS(UP(1, 0), UP(1, 1)), 2);
    assert_int_equal(send_words(s, BLUE, 1, 0, 9, WORDS(UP(1, 0)), 1),
                     LUM_E_DUPLICATE);
    stream_end(s);
    assert_int_equal(lost_by(s), 0);
    stream_free(s);
}

static void lines_with_fewer_than_all_angles_are_counted(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_angles(s, BLUE, 1, 0, 0, 1000);
    send_angles(s, BLUE, 2, 0, 0, 999);
    send_pixels(s, BLUE, 3, 0, 0, 5);
    assert_int_equal(counters(s)->lines, 0); /* of lines handed out */
    stream_end(s);
    assert_int_equal(counters(s)->lines, 3);
    assert_int_equal(counters(s)->lines_missing_angles, 2);
    assert_int_equal(counters(s)->words, 5);
    stream_free(s);
}

/* What holds of the whole */

struct packet {
    unsigned eye;
    uint32_t line;
    uint32_t clock;
    uint32_t first;
    uint32_t n;
};

static struct packet random_packet(uint64_t *seed, uint32_t step)
{
    const uint32_t r = next_random(seed);
    return (struct packet){.eye = r % 2,
                           .line = (step / 6 + r / 2 % 4) % 30,
                           .clock = 500000 + 100 * step + r / 8 % 900,
                           .first = r / 8192 % 40,
                           .n = 1 + r / 524288 % 8};
}

static void send_packet(struct stream *s, const struct packet *p)
{
    lum_result r = LUM_OK;
    if (p->n % 2 == 0) {
        r = send_angles(s, p->eye, p->line, p->clock, p->first, p->n);
    } else {
        r = send_pixels(s, p->eye, p->line, p->clock, p->first, p->n);
    }
    assert_true(r <= LUM_OK);
}

static void assert_same_events(const struct stream *a, const struct stream *b)
{
    assert_int_equal(a->event_count, b->event_count);
    for (size_t i = 0; i < a->event_count; i++) {
        const struct event *x = a->events[i];
        const struct event *y = b->events[i];
        assert_int_equal(x->what, y->what);
        assert_true(x->frame == y->frame);
        assert_int_equal(x->line.number, y->line.number);
        assert_int_equal(x->line.word_count, y->line.word_count);
        assert_memory_equal(x->words, y->words,
                            x->line.word_count * sizeof *x->words);
        assert_memory_equal(x->marks, y->marks, sizeof x->marks);
    }
    assert_memory_equal(counters(a), counters(b), sizeof *counters(a));
}

static void two_assemblers_know_nothing_of_each_other(void **state)
{
    struct stream *alone[2];
    struct stream *mixed[2] = {stream_open(), stream_open()};
    uint64_t seeds[2] = {3, 4};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        uint64_t seed = seeds[i];
        alone[i] = stream_open();
        for (uint32_t step = 0; step < 800; step++) {
            const struct packet p = random_packet(&seed, step);
            send_packet(alone[i], &p);
        }
        stream_end(alone[i]);
    }
    for (uint32_t step = 0; step < 800; step++) {
        for (unsigned i = 0; i < 2; i++) {
            const struct packet p = random_packet(&seeds[i], step);
            send_packet(mixed[i], &p);
        }
    }
    for (unsigned i = 0; i < 2; i++) {
        stream_end(mixed[i]);
        assert_same_events(alone[i], mixed[i]);
        stream_free(alone[i]);
        stream_free(mixed[i]);
    }
}

static void every_packet_is_counted_once(void **state)
{
    struct stream *s = open_with_words(12);
    uint64_t seed = 9;
    uint64_t accepted = 0;
    const uint32_t sent = 3000;
    (void)state;
    for (uint32_t step = 0; step < sent; step++) {
        const struct packet p = random_packet(&seed, step);
        accepted +=
            send_pixels(s, p.eye, p.line, p.clock, p.first, p.n) == LUM_OK ? 1u
                                                                           : 0u;
    }
    const lum_assembly_counters *c = counters(s);
    assert_int_equal(accepted + c->stray + c->late + c->duplicate +
                         c->conflict + c->no_room,
                     sent);
    assert_true(c->late > 0 && c->duplicate > 0 && c->conflict > 0 &&
                c->no_room > 0);
    stream_free(s);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(constants_are_the_documents),
    cmocka_unit_test(constants_have_limits),
    cmocka_unit_test(the_clock_begins_at_the_first_packets_value),
    cmocka_unit_test(the_clock_goes_on_over_its_wrap),
    cmocka_unit_test(the_clock_may_go_below_zero),
    ANY_LAYOUT_TEST(half_a_wrap_of_the_clock_is_backwards),
    cmocka_unit_test(half_a_wrap_of_four_bytes_is_backwards),
    ANY_LAYOUT_TEST(the_clock_follows_packets_of_either_eye),
    ANY_LAYOUT_TEST(the_clock_follows_late_packets),
    ANY_LAYOUT_TEST(the_clock_follows_repeats),
    ANY_LAYOUT_TEST(the_clock_does_not_follow_strays),
    ANY_LAYOUT_TEST(the_clock_follows_a_break),
    ANY_LAYOUT_TEST(a_clock_of_two_bytes_is_extended_at_its_width),
    ANY_LAYOUT_TEST(without_a_timestamp_every_clock_is_0),
    cmocka_unit_test(a_packet_at_gap_us_belongs_to_the_stream),
    cmocka_unit_test(a_packet_past_gap_us_is_a_stray),
    cmocka_unit_test(newest_is_the_largest_clock_not_the_last),
    cmocka_unit_test(a_microsecond_is_enough_to_be_newest),
    cmocka_unit_test(a_packet_half_a_wrap_away_is_a_stray),
    cmocka_unit_test(a_clock_beyond_the_far_ends_is_a_stray_for_good),
    cmocka_unit_test(the_first_stray_has_no_candidate_wherever_it_is),
    cmocka_unit_test(a_late_packet_may_be_the_newest),
    cmocka_unit_test(each_eye_has_its_own_newest),
    cmocka_unit_test(an_eye_goes_on_where_it_was_when_the_other_has_jumped),
    cmocka_unit_test(a_second_packet_there_proves_the_jump),
    cmocka_unit_test(a_jump_behind_a_line_of_two_packets_opens_its_own),
    cmocka_unit_test(a_jump_back_makes_newest_lower),
    cmocka_unit_test(the_candidate_reaches_gap_us),
    cmocka_unit_test(a_packet_of_the_stream_between_forgets_the_candidate),
    cmocka_unit_test(the_other_eyes_packets_do_not_come_between),
    cmocka_unit_test(the_candidate_is_spent_by_the_break),
    cmocka_unit_test(a_break_empties_the_list_of_closed_lines),
    cmocka_unit_test(no_line_closed_before_a_break_is_known_after_it),
    cmocka_unit_test(the_list_of_closed_lines_begins_again_after_a_break),
    cmocka_unit_test(no_line_is_known_after_a_restart),
    cmocka_unit_test(numbers_of_before_a_break_may_come_again),
    cmocka_unit_test(a_break_forgets_the_low_clock),
    cmocka_unit_test(a_break_is_the_eyes_own),
    cmocka_unit_test(a_packet_within_the_span_is_of_the_line),
    cmocka_unit_test(a_newer_packet_closes_the_lines_through_its_number),
    cmocka_unit_test(an_older_packet_of_an_open_line_is_late),
    cmocka_unit_test(the_span_is_the_profiles),
    cmocka_unit_test(the_span_may_be_0),
    cmocka_unit_test(a_fifth_line_closes_the_one_opened_first),
    cmocka_unit_test(a_caller_may_choose_one_open_line),
    ANY_LAYOUT_TEST(one_of_the_last_r_closed_is_late),
    ANY_LAYOUT_TEST(of_fewer_than_r_closed_each_is_late),
    cmocka_unit_test(nothing_is_closed_before_the_first_line),
    cmocka_unit_test(r_may_be_chosen),
    cmocka_unit_test(a_closed_line_is_known_within_the_span),
    cmocka_unit_test(a_closed_line_is_not_known_before_the_span),
    cmocka_unit_test(older_than_the_low_clock_is_late),
    cmocka_unit_test(the_low_clock_is_the_lines_smallest),
    cmocka_unit_test(the_largest_low_clock_counts),
    cmocka_unit_test(a_low_clock_may_be_below_zero),
    cmocka_unit_test(a_dropped_packet_has_no_say_in_the_low_clock),
    cmocka_unit_test(one_packet_ahead_of_its_time_deafens_nobody),
    cmocka_unit_test(a_repeat_of_that_packet_deafens_nobody_either),
    cmocka_unit_test(late_is_judged_for_each_eye),
    cmocka_unit_test(a_packet_is_judged_before_a_line_closes_for_it),
    cmocka_unit_test(a_late_packet_closes_no_line),
    cmocka_unit_test(angles_that_are_all_there_are_a_duplicate),
    cmocka_unit_test(angles_of_which_some_are_there_are_a_conflict),
    cmocka_unit_test(a_conflict_leaves_the_marks_as_they_were),
    cmocka_unit_test(angles_of_every_cut_are_told_apart),
    cmocka_unit_test(ranges_that_are_all_there_are_a_duplicate),
    cmocka_unit_test(
        a_duplicate_is_told_by_pixels_however_many_words_they_have),
    cmocka_unit_test(a_word_of_any_pixel_that_is_there_is_a_duplicate),
    cmocka_unit_test(ranges_of_which_some_are_there_are_a_conflict),
    cmocka_unit_test(only_good_words_tell_a_duplicate),
    cmocka_unit_test(the_last_pixel_of_one_line_is_no_word_of_the_next),
    cmocka_unit_test(bad_words_of_a_dropped_packet_are_not_counted),
    cmocka_unit_test(bad_words_are_skipped_alone),
    cmocka_unit_test(good_words_behind_many_bad_ones_keep_their_pixels),
    cmocka_unit_test(a_packet_of_bad_words_alone_is_accepted),
    cmocka_unit_test(bad_words_alone_find_room_in_a_full_line),
    cmocka_unit_test(words_that_do_not_all_fit_are_dropped_whole),
    cmocka_unit_test(a_packet_of_more_words_than_a_line_has_no_room),
    cmocka_unit_test(only_good_words_need_room),
    cmocka_unit_test(a_duplicate_is_told_before_the_room),
    ANY_LAYOUT_TEST(words_of_a_pixel_are_counted_beyond_16_bits),
    cmocka_unit_test(what_is_dropped_leaves_its_line_open),
    cmocka_unit_test(an_arrival_may_be_0),
    FRAMES_TEST(a_line_bears_what_its_packets_brought),
    ANY_LAYOUT_TEST(angles_may_come_elevation_first),
    cmocka_unit_test(a_slot_used_again_is_empty),
    cmocka_unit_test(the_one_pixel_that_is_missing_is_empty_too),
    cmocka_unit_test(open_lines_share_no_storage),
    cmocka_unit_test(a_pixel_past_the_last_is_skipped_behind_those_in_order),
    cmocka_unit_test(words_of_an_earlier_line_do_not_tell_the_order),
    cmocka_unit_test(pixel_1000_is_past_the_last),
    cmocka_unit_test(pixel_1000_is_not_counted_either),
    cmocka_unit_test(words_stand_by_pixel_then_as_in_their_packet),
    cmocka_unit_test(words_of_any_bits_above_are_sorted_by_pixel),
    cmocka_unit_test(a_bad_word_is_skipped_between_words_in_order),
    cmocka_unit_test(a_bad_word_is_skipped_before_words_in_order),
    cmocka_unit_test(a_packet_behind_a_line_of_one_word_is_sorted_too),
    cmocka_unit_test(packets_interleave_by_pixel),
    cmocka_unit_test(random_orders_end_sorted_and_stable),
    cmocka_unit_test(the_end_closes_blue_in_order_then_green),
    cmocka_unit_test(a_stream_of_nothing_ends_at_once),
    FRAMES_TEST(the_end_may_be_asked_for_twice),
    cmocka_unit_test(lost_words_are_what_the_index_says_is_missing),
    cmocka_unit_test(lost_words_are_those_of_the_largest_sum),
    cmocka_unit_test(one_word_out_of_order_is_seen),
    cmocka_unit_test(bad_words_are_not_lost),
    cmocka_unit_test(a_packet_of_bad_words_alone_shows_what_is_lost),
    cmocka_unit_test(lost_words_are_never_below_0),
    cmocka_unit_test(words_past_the_lines_are_not_lost),
    cmocka_unit_test(sums_beyond_a_lines_words_are_not_believed),
    ANY_LAYOUT_TEST(an_index_at_the_end_of_32_bits_is_not_believed),
    cmocka_unit_test(dropped_packets_show_nothing_lost),
    cmocka_unit_test(lines_with_fewer_than_all_angles_are_counted),
    cmocka_unit_test(two_assemblers_know_nothing_of_each_other),
    cmocka_unit_test(every_packet_is_counted_once),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
