#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#define BLUE  LUM_EYE_BLUE
#define GREEN LUM_EYE_GREEN
#define R     8u

/* Ends the stream and returns the frame of a line. */
static int64_t frame_at_end(struct stream *s, unsigned eye, uint32_t line,
                            size_t n)
{
    stream_end(s);
    const int64_t frame = frame_of(s, eye, line, n);
    stream_free(s);
    return frame;
}

static uint64_t skipped_at_end(struct stream *s)
{
    stream_end(s);
    const uint64_t skipped = counters(s)->lines_skipped;
    stream_free(s);
    return skipped;
}

static lum_result single(struct stream *s, unsigned eye, uint32_t line)
{
    return send_angles(s, eye, line, s->clock, 0, 1);
}

/* The stream's clock has jumped for an eye, proved by two packets of a line,
 * which are accepted as one. */
static void jump(struct stream *s, unsigned eye, uint32_t line)
{
    s->clock += 1000000u;
    assert_int_equal(send_angles(s, eye, line, s->clock, 5, 1), LUM_E_STRAY);
    assert_int_equal(send_angles(s, eye, line, s->clock, 5, 1), LUM_OK);
}

/* Fast enough for one eye to send frames while the other is not yet silent. */
static struct stream *open_fast(void)
{
    struct stream *s = stream_open();
    s->step = 500;
    return s;
}

/* Whole frames of an eye, lines 0 to last. */
static void sweep(struct stream *s, unsigned eye, unsigned frames,
                  uint32_t last)
{
    for (unsigned i = 0; i < frames; i++) {
        send_lines(s, eye, 0, last);
    }
}

/* First of this eye */

static void the_first_eye_begins_with_frame_1(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, GREEN, 500);
    assert_int_equal(frame_at_end(s, GREEN, 500, 0), 1);
}

/* Blue stands at line 30 of frame 2 when green's first line comes. */
static int64_t first_beside(uint32_t first)
{
    struct stream *s = open_fast();
    send_line(s, BLUE, 40);
    sweep(s, BLUE, 1, 30);
    send_line(s, GREEN, first);
    return frame_at_end(s, GREEN, first, 0);
}

static void an_eye_beside_the_other_takes_its_frame(void **state)
{
    (void)state;
    assert_int_equal(first_beside(30), 2);
    assert_int_equal(first_beside(30 + R), 2);
    assert_int_equal(first_beside(30 - R), 2);
}

static void an_eye_ahead_is_still_in_the_frame_before(void **state)
{
    (void)state;
    assert_int_equal(first_beside(30 + R + 1), 1);
}

static void an_eye_behind_is_in_the_frame_after(void **state)
{
    (void)state;
    assert_int_equal(first_beside(30 - R - 1), 3);
}

static void frame_numbers_may_be_0(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 1);
    send_line(s, GREEN, 40);
    assert_int_equal(frame_at_end(s, GREEN, 40, 0), 0);
}

static void a_break_before_the_first_is_spent_by_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(single(s, BLUE, 3), LUM_OK);
    jump(s, BLUE, 4); /* and nothing is decided yet */
    send_line(s, BLUE, 5);
    send_line(s, BLUE, 6);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 5, 0), 1);
    assert_int_equal(frame_of(s, BLUE, 6, 0), 1);
    stream_free(s);
}

/* Lines that close with fewer than two packets */

static void a_line_of_one_packet_takes_frame_1_when_there_is_none(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, GREEN, 20, 20);
    send_line(s, GREEN, 5); /* green is in frame 2, blue in none */
    single(s, BLUE, 5);
    assert_int_equal(frame_at_end(s, BLUE, 5, 0), 1);
}

static void a_line_of_one_packet_takes_the_frame_when_it_closes(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 30);
    single(s, BLUE, 31);
    send_line(s, BLUE, 1); /* a new frame, while 31 is open */
    assert_int_equal(frame_at_end(s, BLUE, 31, 0), 2);
}

static void a_line_of_one_packet_changes_nothing(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 30);
    single(s, BLUE, 300);
    single(s, BLUE, 0);
    send_line(s, BLUE, 31);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 31, 0), 1);
    assert_int_equal(counters(s)->lines_skipped, 0);
    assert_int_equal(counters(s)->frames, 1);
    stream_free(s);
}

static void a_frame_is_decided_by_the_second_accepted_packet(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 30);
    single(s, BLUE, 1);
    assert_int_equal(single(s, BLUE, 1), LUM_E_DUPLICATE);
    send_line(s, BLUE, 31); /* before line 1's second packet */
    assert_int_equal(send_angles(s, BLUE, 1, s->clock - 5000, 1, 1), LUM_OK);
    send_line(s, BLUE, 2);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 31, 0), 1);
    assert_int_equal(frame_of(s, BLUE, 1, 0), 2);
    assert_int_equal(frame_of(s, BLUE, 2, 0), 2);
    stream_free(s);
}

/* After a break */

static void the_line_after_a_break_begins_a_frame(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 10, 12);
    jump(s, BLUE, 13);
    send_lines(s, BLUE, 14, 15);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 12, 0), 1);
    assert_int_equal(frame_of(s, BLUE, 14, 0), 2);
    assert_int_equal(frame_of(s, BLUE, 15, 0), 2);
    assert_int_equal(counters(s)->lines_skipped, 0); /* with gap 0 */
    stream_free(s);
}

/* As after a restart: the break is spent by line 0. */
static void a_break_may_be_followed_by_line_0(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 10, 12);
    jump(s, BLUE, 0);
    send_lines(s, BLUE, 0, 3);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 0, 0), 2);
    assert_int_equal(frame_of(s, BLUE, 1, 0), 2);
    assert_int_equal(frame_of(s, BLUE, 3, 0), 2);
    assert_int_equal(counters(s)->frames, 2);
    stream_free(s);
}

static void breaks_without_a_line_between_are_one(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 10, 12);
    jump(s, BLUE, 13);
    jump(s, BLUE, 14);
    send_lines(s, BLUE, 15, 50); /* green is silent now */
    send_lines(s, BLUE, 0, R - 1);
    assert_int_equal(count_events(s, LUM_FRAME_READY), 1);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 15, 0), 2);
    assert_int_equal(frame_of(s, BLUE, 0, 0), 3);
    assert_int_equal(count_events(s, LUM_FRAME_READY), 3);
    stream_free(s);
}

static void a_break_ends_the_gap_before_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 14);
    jump(s, BLUE, 20);
    send_line(s, BLUE, 20);
    assert_int_equal(counters(s)->lines_skipped, 3);
    assert_int_equal(skipped_at_end(s), 3);
}

static void no_line_straggles_between_a_break_and_the_next_wrap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 60);
    send_line(s, BLUE, 1); /* a wrap, whose straggler could still come */
    jump(s, BLUE, 2);
    send_line(s, BLUE, 2);
    send_line(s, BLUE, 61);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 2, 0), 3);
    assert_int_equal(frame_of(s, BLUE, 61, 0), 3);
    stream_free(s);
}

static void a_line_straggles_after_the_wrap_behind_a_break(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 60);
    jump(s, BLUE, 60);
    send_line(s, BLUE, 61);
    send_line(s, BLUE, 1);
    send_line(s, BLUE, 62);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 1, 0), 3);
    assert_int_equal(frame_of(s, BLUE, 62, 0), 2);
    stream_free(s);
}

/* Wrap */

static int64_t frame_after(uint32_t top, uint32_t line)
{
    struct stream *s = stream_open();
    send_line(s, BLUE, top);
    send_line(s, BLUE, line);
    return frame_at_end(s, BLUE, line, 0);
}

static void a_wrap_goes_back_by_more_than_r(void **state)
{
    (void)state;
    assert_int_equal(frame_after(40, 40 - R), 1);
    assert_int_equal(frame_after(40, 40 - R - 1), 2);
    assert_int_equal(frame_after(R, 0), 1);
    assert_int_equal(frame_after(R + 1, 0), 2);
    assert_int_equal(frame_after(0xffff, 0), 2);
}

static void a_wraps_line_is_its_gap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 60);
    send_line(s, BLUE, 5); /* 0 to 4 of the frame are missing */
    assert_int_equal(counters(s)->lines_skipped, 0);
    assert_int_equal(skipped_at_end(s), 5);
}

/* Blue has begun frame 2 at line 2; green stands at 20 of frame 1. */
static int64_t through_the_other(uint32_t line)
{
    struct stream *s = stream_open();
    send_lines(s, BLUE, 20, 20);
    send_lines(s, GREEN, 20, 20);
    send_line(s, BLUE, 2);
    send_lines(s, BLUE, 10, 24);
    send_line(s, GREEN, line);
    return frame_at_end(s, GREEN, line, 0);
}

static void an_eye_wraps_beside_the_other_that_has(void **state)
{
    (void)state;
    assert_int_equal(through_the_other(24), 2);
    assert_int_equal(through_the_other(24 + R), 2);
    assert_int_equal(through_the_other(24 - R), 2);
}

/* Frame 1, of an eye without a line, is ahead of the upper half of numbers. */
static void an_eye_does_not_wrap_beside_one_that_has_not_begun(void **state)
{
    const uint32_t frame = UINT32_C(0x80000002);
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct stream *s = stream_open();
        s->assembler.eye[eye].frames.frame = frame; /* after so many */
        s->assembler.frames.next = frame;
        s->assembler.frames.highest = frame - 1u;
        for (unsigned i = 0; i < R; i++) {
            s->assembler.eye[eye].reach[i].frame = frame - 1u;
        }
        send_lines(s, eye, 0, 1);
        assert_true(frame_at_end(s, eye, 1, 0) == (int64_t)frame);
    }
}

static void an_eye_does_not_wrap_far_from_the_other(void **state)
{
    (void)state;
    assert_int_equal(through_the_other(24 + R + 1), 1);
    assert_int_equal(through_the_other(24 - R - 1), 1);
}

static void an_eye_does_not_wrap_beside_one_of_its_frame(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 20);
    send_line(s, GREEN, 20);
    send_line(s, GREEN, 21);
    assert_int_equal(frame_at_end(s, GREEN, 21, 0), 1);
}

static void the_other_eyes_wrap_is_a_wrap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 20);
    send_line(s, GREEN, 20);
    send_line(s, BLUE, 2);
    send_lines(s, BLUE, 10, 24);
    send_line(s, GREEN, 24); /* gap 24 */
    assert_int_equal(counters(s)->lines_skipped, 0);
    stream_end(s);
    /* blue: 2, less none, and 7 between 2 and 10 */
    assert_int_equal(counters(s)->lines_skipped, 24 + 2 + 7);
    stream_free(s);
}

/* Green stands at line 40 of frame 1, blue at line 1 of frame 6. */
static struct stream *open_far_apart(void)
{
    struct stream *s = open_fast();
    send_line(s, GREEN, 40);
    send_line(s, BLUE, 40);
    sweep(s, BLUE, 4, 40);
    send_lines(s, BLUE, 0, 1);
    return s;
}

static void an_eye_that_missed_frames_catches_up(void **state)
{
    struct stream *s = open_far_apart();
    (void)state;
    send_line(s, GREEN, 1 + R);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 1, 4), 6);
    assert_int_equal(frame_of(s, GREEN, 1 + R, 0), 6);
    stream_free(s);
}

static void an_eye_far_from_the_other_does_not_catch_up(void **state)
{
    struct stream *s = open_far_apart();
    (void)state;
    send_line(s, GREEN, 1 + R + 1);
    assert_int_equal(frame_at_end(s, GREEN, 1 + R + 1, 0), 2);
}

static void an_eye_ahead_of_the_other_goes_on_by_one(void **state)
{
    struct stream *s = open_far_apart();
    (void)state;
    send_lines(s, BLUE, 2, 60);
    send_line(s, BLUE, 40); /* beside green's top of frame 1 */
    assert_int_equal(frame_at_end(s, BLUE, 40, 6), 7);
}

static void a_break_catches_up_too(void **state)
{
    struct stream *s = open_far_apart();
    (void)state;
    jump(s, GREEN, 1);
    send_line(s, GREEN, 1);
    assert_int_equal(frame_at_end(s, GREEN, 1, 0), 6);
}

/* Straggler */

/* Wraps at top, sends n lines of the new frame, then the straggler. */
static int64_t straggler(uint32_t top, uint32_t wrap, uint32_t n, uint32_t line)
{
    struct stream *s = stream_open();
    send_line(s, BLUE, top);
    send_line(s, BLUE, wrap);
    for (uint32_t i = 1; i <= n; i++) {
        send_line(s, BLUE, wrap + i);
    }
    send_line(s, BLUE, line);
    return frame_at_end(s, BLUE, line, 0);
}

static void a_straggler_is_of_the_frame_before(void **state)
{
    (void)state;
    assert_int_equal(straggler(60, 0, 0, 59), 1);
    assert_int_equal(straggler(60, 0, 0, 61), 1);
}

static void a_straggler_comes_within_r_lines_of_the_wrap(void **state)
{
    (void)state;
    /* itself counted, the wrapping one not: fewer than R */
    assert_int_equal(straggler(60, 0, R - 2, 59), 1);
    assert_int_equal(straggler(60, 0, R - 1, 59), 2);
}

static void a_straggler_is_more_than_r_above_the_top(void **state)
{
    (void)state;
    assert_int_equal(straggler(20, 11, 0, 11 + R + 1), 1);
    assert_int_equal(straggler(20, 11, 0, 11 + R), 2);
    /* which rises */
    assert_int_equal(straggler(20, 5, 3, 8 + R + 1), 1);
    assert_int_equal(straggler(20, 5, 3, 8 + R), 2);
}

static void a_straggler_is_no_more_than_r_below_the_top_before(void **state)
{
    (void)state;
    assert_int_equal(straggler(60, 0, 0, 60 - R), 1);
    assert_int_equal(straggler(60, 0, 0, 60 - R - 1), 2);
}

static void nothing_straggles_before_the_first_wrap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 0);
    send_line(s, BLUE, 60);
    assert_int_equal(frame_at_end(s, BLUE, 60, 0), 1);
}

static void a_straggler_changes_nothing_but_the_count(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 60);
    send_line(s, BLUE, 0);
    for (uint32_t i = 0; i < R - 1; i++) {
        send_line(s, BLUE, 59 - i);
    }
    send_line(s, BLUE, 61); /* the R-th: of the new frame, which goes on */
    stream_end(s);
    for (uint32_t i = 0; i < R - 1; i++) {
        assert_int_equal(frame_of(s, BLUE, 59 - i, 0), 1);
    }
    assert_int_equal(frame_of(s, BLUE, 61, 0), 2);
    assert_int_equal(counters(s)->lines_skipped, 60);
    stream_free(s);
}

static void stragglers_follow_the_other_eyes_wrap_too(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 60);
    send_line(s, GREEN, 5);
    send_line(s, BLUE, 0);
    send_line(s, GREEN, 6); /* wraps beside blue, from top 5 */
    send_line(s, GREEN, 60);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 0, 0), 2);
    assert_int_equal(frame_of(s, GREEN, 5, 0), 2);
    assert_int_equal(frame_of(s, GREEN, 6, 0), 2);
    stream_free(s);
}

/* Else: the gap */

static void lines_in_order_skip_none(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 0, 30);
    send_lines(s, BLUE, 0, 30);
    assert_int_equal(skipped_at_end(s), 0);
}

static void a_gap_grows_by_the_lines_between(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 3); /* what was before the first is not known */
    send_line(s, BLUE, 4);
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 12);
    assert_int_equal(skipped_at_end(s), 5 + 1);
}

static void a_gap_shrinks_by_each_line_that_comes_after_all(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 3);
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 7);
    send_line(s, BLUE, 5);
    assert_int_equal(skipped_at_end(s), 6 - 2);
}

static void the_one_line_that_lacks_may_come_after_all(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 12);
    send_line(s, BLUE, 11);
    assert_int_equal(skipped_at_end(s), 0);
}

static void a_gap_is_never_below_0(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 9);
    send_line(s, BLUE, 8);
    send_line(s, BLUE, 12);
    assert_int_equal(skipped_at_end(s), 1);
}

static void the_top_once_more_changes_no_gap(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 12);
    send_line(s, BLUE, 12);
    stream_end(s);
    assert_int_equal(counters(s)->lines, 3);
    assert_int_equal(counters(s)->lines_skipped, 1);
    stream_free(s);
}

static void a_line_below_does_not_lower_the_top(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 5);
    send_line(s, BLUE, 11);
    assert_int_equal(skipped_at_end(s), 0);
}

static void the_gaps_of_both_eyes_are_added_at_the_end(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, GREEN, 10);
    send_line(s, BLUE, 13);
    send_line(s, GREEN, 15);
    assert_int_equal(counters(s)->lines_skipped, 0);
    assert_int_equal(skipped_at_end(s), 2 + 4);
}

static void the_widest_gap_is_counted(void **state)
{
    struct stream *s = stream_new();
    s->layout.profile.group[LUM_FIELD_LINE] = (lum_field){.at = 24, .bytes = 4};
    s->layout.profile.samples_at = 28;
    stream_begin(s);
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        send_lines(s, BLUE, 0, R - 1);
        send_line(s, BLUE, 0xffffffffu);
    }
    stream_end(s);
    assert_int_equal(counters(s)->lines_skipped, 3 * UINT64_C(0xfffffff7));
    assert_int_equal(counters(s)->frames, 3);
    stream_free(s);
}

static void r_is_the_callers(void **state)
{
    struct stream *s = stream_new();
    s->config.reorder_lines = 2;
    stream_begin(s);
    (void)state;
    send_line(s, BLUE, 10);
    send_line(s, BLUE, 8);
    send_line(s, BLUE, 7);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 8, 0), 1);
    assert_int_equal(frame_of(s, BLUE, 7, 0), 2);
    stream_free(s);
}

static void frames_counts_distinct_numbers(void **state)
{
    struct stream *s = open_far_apart();
    (void)state;
    stream_end(s);
    assert_int_equal(counters(s)->frames, 6);
    stream_free(s);
}

static void frames_counts_from_the_first_line_on(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, GREEN, 40);
    send_line(s, GREEN, 1); /* frame 2 */
    stream_end(s);
    assert_int_equal(counters(s)->frames, 2);
    stream_free(s);
    s = stream_open();
    send_line(s, GREEN, 40);
    stream_end(s);
    assert_int_equal(counters(s)->frames, 1);
    stream_free(s);
    s = stream_open();
    send_line(s, BLUE, 1);
    send_line(s, GREEN, 40); /* frame 0 */
    stream_end(s);
    assert_int_equal(counters(s)->frames, 2);
    stream_free(s);
}

/* Complete */

/* Both eyes from line to last. */
static void both(struct stream *s, uint32_t line, uint32_t last)
{
    for (; line <= last; line++) {
        send_line(s, BLUE, line);
        send_line(s, GREEN, line);
    }
}

static size_t completions(const struct stream *s)
{
    return count_events(s, LUM_FRAME_READY);
}

static void assert_lines_before_frames(const struct stream *s)
{
    for (size_t i = 0; i < s->event_count; i++) {
        if (s->events[i]->what == LUM_LINE_READY) {
            assert_true(frame_event(s, s->events[i]->frame) > (long)i);
        }
    }
}

/* The event comes with the push after the line that makes it due. */
static void tick(struct stream *s)
{
    assert_true(send_angles(s, BLUE, 500, s->clock, 0, 1) <= LUM_OK);
}

static void a_frame_is_complete_after_r_lines_of_the_next(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 30);
    both(s, 0, R - 2);
    send_line(s, BLUE, R - 1);
    tick(s);
    assert_int_equal(completions(s), 0); /* green has one to go */
    send_line(s, GREEN, R - 1);
    tick(s);
    assert_int_equal(completions(s), 1);
    assert_true(frame_event(s, 1) >= 0);
    stream_free(s);
}

/* Both eyes send line; returns whether that completed a frame. */
static bool completes(struct stream *s, uint32_t line)
{
    const size_t before = completions(s);
    both(s, line, line);
    tick(s);
    assert_true(completions(s) <= before + 1u);
    return completions(s) > before;
}

static void every_frame_is_complete_after_r_lines_of_the_next(void **state)
{
    (void)state;
    for (uint8_t r = 1; r <= LUM_REORDER_MAX; r++) {
        struct stream *s = stream_new();
        s->config.reorder_lines = r;
        s->config.open_lines = 1;
        stream_begin(s);
        s->step = 500;
        for (unsigned frame = 0; frame < 5; frame++) {
            for (uint32_t line = 0; line <= 2u * r; line++) {
                const bool is_due = frame > 0 && line + 1u == r;
                assert_int_equal(completes(s, line), is_due);
            }
        }
        stream_free(s);
    }
}

static void stragglers_are_no_lines_of_a_later_frame(void **state)
{
    static const uint32_t lines[] = {0, 31, 1, 32, 2, 3, 4, 5, 6, 7};
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    s->step = 500;
    (void)state;
    both(s, 0, 30);
    for (unsigned i = 0; i < 10; i++) {
        assert_int_equal(completes(s, lines[i]), lines[i] == R - 1);
    }
    stream_free(s);
}

static void a_line_counts_once_however_many_packets_it_has(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    (void)state;
    both(s, 0, 30);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        for (uint32_t i = 0; i < 3 * R; i++) {
            assert_int_equal(send_angles(s, eye, 0, s->clock, i, 1), LUM_OK);
        }
    }
    tick(s);
    assert_int_equal(completions(s), 0);
    stream_free(s);
}

/* Frames of three lines; 11 is more than R below 20, and 20 no straggler. */
static void lines_of_any_later_frames_count_together(void **state)
{
    static const uint32_t lines[] = {11, 15, 20};
    struct stream *s = stream_new();
    s->config.open_lines = 1;
    stream_begin(s);
    s->step = 500;
    (void)state;
    for (unsigned i = 0; i < 8 * 3; i++) {
        /* frame f ends with line 3 f - 1, and is complete R lines later */
        assert_int_equal(completes(s, lines[i % 3]),
                         i + 1 >= 3 + R && (i + 1 - R) % 3 == 0);
    }
    stream_free(s);
}

static void a_frame_is_not_complete_while_a_line_of_it_is_open(void **state)
{
    struct stream *s = stream_new();
    s->config.open_lines = 16;
    stream_begin(s);
    (void)state;
    both(s, 20, 30);
    both(s, 0, R - 1);
    tick(s);
    assert_int_equal(completions(s), 0); /* 30 and more are open */
    both(s, R, 14);
    tick(s);
    assert_int_equal(completions(s), 0);
    both(s, 15, 16);
    tick(s);
    assert_int_equal(completions(s), 1);
    stream_free(s);
}

/* Line 31 of frame 1 opens behind line 6 of frame 2, and is decided before. */
static void nor_while_the_line_opened_last_is_of_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 30);
    both(s, 0, R - 3);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const uint32_t clock = s->clock + 2000;
        send_line(s, eye, R - 2);
        assert_int_equal(send_angles(s, eye, R - 1, clock, 0, 1), LUM_OK);
        assert_int_equal(send_angles(s, eye, 31, clock, 0, 1), LUM_OK);
        assert_int_equal(send_angles(s, eye, 31, clock, 1, 1), LUM_OK);
        assert_int_equal(send_angles(s, eye, R - 1, clock, 1, 1), LUM_OK);
    }
    tick(s);
    assert_int_equal(completions(s), 0);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 31, 0), 1);
    assert_int_equal(frame_of(s, GREEN, R - 1, 1), 2);
    assert_lines_before_frames(s);
    stream_free(s);
}

static void a_frame_before_that_of_an_open_line_may_be_complete(void **state)
{
    struct stream *s = stream_new();
    s->config.reorder_lines = 1;
    stream_begin(s);
    (void)state;
    both(s, 30, 30); /* frames 1, 2 and 3: a line each */
    both(s, 20, 20);
    both(s, 10, 10);
    tick(s);
    assert_int_equal(completions(s), 0); /* all are open */
    both(s, 11, 12);
    tick(s);
    assert_int_equal(completions(s), 1); /* and now 20 and more */
    assert_true(frame_event(s, 1) >= 0);
    stream_free(s);
}

static void a_line_of_one_packet_holds_no_frame_back(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 30);
    both(s, 0, R - 4);
    single(s, BLUE, R - 3);
    single(s, GREEN, R - 3);
    both(s, R - 2, R); /* the R-th decided: line 5 has one packet */
    tick(s);
    assert_int_equal(completions(s), 1);
    stream_free(s);
}

static void all_lines_of_a_frame_come_before_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (unsigned frame = 0; frame < 5; frame++) {
        both(s, 0, 30);
    }
    stream_end(s);
    assert_int_equal(completions(s), 5);
    assert_lines_before_frames(s);
    stream_free(s);
}

static void frames_are_complete_in_order_each_once(void **state)
{
    struct stream *s = stream_open();
    int64_t before = 0;
    (void)state;
    for (unsigned frame = 0; frame < 9; frame++) {
        both(s, 0, 20);
    }
    assert_int_equal(completions(s), 8);
    stream_end(s);
    assert_int_equal(completions(s), 9);
    for (size_t i = 0; i < s->event_count; i++) {
        if (s->events[i]->what == LUM_FRAME_READY) {
            assert_int_equal(s->events[i]->frame, before + 1);
            before = s->events[i]->frame;
        }
    }
    stream_free(s);
}

static void the_end_completes_the_last_frame_after_its_lines(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 3);
    assert_int_equal(completions(s), 0);
    stream_end(s);
    assert_int_equal(completions(s), 1);
    assert_int_equal(frame_event(s, 1), (long)s->event_count - 1);
    stream_free(s);
}

static void an_eye_alone_waits_for_the_other_for_gap_us(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct stream *s = stream_open();
        /* 5 ms a line, from 1 s on: the other is silent from the 22nd on */
        for (unsigned i = 0; i < 2; i++) {
            send_lines(s, eye, 0, 9);
        }
        assert_true(send_angles(s, eye, 500, s->clock, 0, 1) <= LUM_OK);
        assert_int_equal(completions(s), 0);
        send_lines(s, eye, 10, 16);
        assert_true(send_angles(s, eye, 500, s->clock, 1, 1) <= LUM_OK);
        assert_int_equal(completions(s), 1);
        stream_free(s);
    }
}

/* Green was heard at 1 s, and then a packet of so long before; how many frames
 * are complete when blue's low clock, that of the line closed last, is past
 * gap_us. */
static size_t complete_past_gap(uint32_t past_us, uint32_t older_us)
{
    struct stream *s = stream_open();
    s->step = 0;
    send_line(s, GREEN, 10);
    assert_int_equal(send_angles(s, GREEN, 9, s->clock - older_us, 0, 1),
                     LUM_OK);
    send_lines(s, BLUE, 10, 12);
    send_lines(s, BLUE, 0, R); /* 5 of which have closed */
    s->clock += 50000u;
    send_lines(s, BLUE, R + 1, R + 1);
    s->clock += 50000u + past_us;
    send_lines(s, BLUE, R + 2, R + 5); /* line R + 1 closes */
    send_line(s, BLUE, R + 6);         /* and one of the last clock */
    tick(s);
    const size_t complete = completions(s);
    stream_free(s);
    return complete;
}

static void an_eye_at_gap_us_is_not_silent_yet(void **state)
{
    (void)state;
    assert_int_equal(complete_past_gap(0, 0), 0);
    assert_int_equal(complete_past_gap(1, 0), 1);
}

/* Silence is counted from what the silent eye has sent. */
static void an_eye_that_begins_late_does_not_wake_the_other(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 0);
    s->clock += 2000000;
    s->step = 100;
    send_lines(s, GREEN, 0, 20);
    send_lines(s, GREEN, 0, 15);
    assert_true(frame_event(s, 1) >= 0);
    stream_free(s);
}

static void an_eye_was_heard_at_its_newest_clock_not_its_last(void **state)
{
    (void)state;
    assert_int_equal(complete_past_gap(0, 99999), 0);
    assert_int_equal(complete_past_gap(1, 99999), 1);
}

static void an_eye_that_falls_silent_is_waited_for_gap_us(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 30);
    /* green's last clock is 5 ms ago with blue's next line */
    send_lines(s, BLUE, 0, 18);
    tick(s);
    assert_int_equal(completions(s), 0);
    send_lines(s, BLUE, 19, 26);
    tick(s);
    assert_int_equal(completions(s), 1);
    stream_free(s);
}

static void a_break_completes_the_frames_before_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 10);
    jump(s, BLUE, 11);
    jump(s, GREEN, 11);
    tick(s);
    assert_int_equal(completions(s), 1);
    assert_int_equal(counters(s)->lines, 22);
    stream_free(s);
}

/* The sensor boots, or its clock is set: blue's packets show it first. */
static void after_a_jump_of(uint32_t offset)
{
    struct stream *s = stream_open();
    both(s, 0, 10);
    s->clock += offset;
    jump(s, BLUE, 11);
    send_lines(s, BLUE, 12, 13);
    tick(s);
    assert_int_equal(completions(s), 0); /* green has lines of frame 1 open */
    s->clock -= 1000000u;
    jump(s, GREEN, 11);
    send_lines(s, GREEN, 12, 13);
    tick(s);
    assert_int_equal(completions(s), 1);
    stream_end(s);
    assert_lines_before_frames(s);
    stream_free(s);
}

static void a_jump_of_one_eyes_clock_makes_the_other_not_silent(void **state)
{
    (void)state;
    after_a_jump_of(0);
    after_a_jump_of(0u - 2000000u);
}

static void an_eye_is_heard_when_the_others_clock_jumps(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 10);
    jump(s, BLUE, 11);
    send_lines(s, BLUE, 12, 20); /* 45 ms, and some of them have closed */
    tick(s);
    assert_int_equal(completions(s), 0);
    stream_free(s);
}

static void a_break_completes_its_frame_whatever_r_is(void **state)
{
    (void)state;
    for (uint8_t r = 1; r <= LUM_REORDER_MAX; r++) {
        struct stream *s = stream_new();
        s->config.reorder_lines = r;
        stream_begin(s);
        both(s, 0, 10);
        jump(s, BLUE, 11);
        assert_int_equal(completions(s), 0);
        jump(s, GREEN, 11);
        tick(s);
        assert_int_equal(completions(s), 1);
        stream_free(s);
    }
}

static void one_packet_ahead_of_its_time_makes_nobody_silent(void **state)
{
    struct stream *s = open_fast();
    (void)state;
    both(s, 0, 30);
    both(s, 0, R - 2);
    send_line(s, BLUE, R - 1);
    assert_int_equal(send_angles(s, BLUE, 50, s->clock + 99500u, 0, 1), LUM_OK);
    assert_int_equal(send_angles(s, GREEN, R - 1, s->clock - 2000u, 0, 1),
                     LUM_OK);
    tick(s);
    assert_int_equal(completions(s), 0);
    stream_free(s);
}

static void a_frame_that_the_other_eye_skips_is_complete_as_well(void **state)
{
    struct stream *s = open_fast();
    (void)state;
    both(s, 0, 30);
    send_lines(s, BLUE, 0, 30); /* frame 2, blue's alone */
    both(s, 0, 30);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 30, 1), 2);
    assert_int_equal(frame_of(s, GREEN, 30, 1), 3);
    assert_int_equal(completions(s), 3);
    stream_free(s);
}

static void a_straggler_comes_before_its_frame_is_complete(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    both(s, 0, 30);
    both(s, 0, R - 3);
    send_line(s, BLUE, 31);
    send_line(s, GREEN, 31);
    both(s, R - 2, 20);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 31, 0), 1);
    assert_int_equal(frame_of(s, GREEN, 31, 0), 1);
    assert_lines_before_frames(s);
    stream_free(s);
}

static void a_frame_before_the_first_is_complete_before_it(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 1);
    send_line(s, GREEN, 40); /* frame 0 */
    send_line(s, BLUE, 2);
    send_line(s, GREEN, 2);
    stream_end(s);
    assert_int_equal(frame_of(s, GREEN, 2, 0), 1);
    assert_int_equal(completions(s), 2);
    assert_true(frame_event(s, 0) >= 0);
    assert_true(frame_event(s, 1) > frame_event(s, 0));
    stream_free(s);
}

/* Green is silent with line 40 of frame 0 open. */
static void a_frame_of_a_silent_eye_is_complete_once_and_in_order(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_line(s, BLUE, 1);
    send_line(s, GREEN, 40);
    send_lines(s, BLUE, 2, 40);
    send_lines(s, BLUE, 0, 2 * R);
    tick(s);
    assert_int_equal(completions(s), 2);
    assert_true(frame_event(s, 0) >= 0);
    assert_true(frame_event(s, 1) > frame_event(s, 0));
    stream_end(s);
    assert_int_equal(frame_of(s, GREEN, 40, 0), 0);
    assert_int_equal(completions(s), 3);
    stream_free(s);
}

static void a_frame_of_undecided_lines_alone_is_complete_at_the_end(
    void **state)
{
    struct stream *s = stream_open();
    (void)state;
    single(s, BLUE, 3);
    single(s, GREEN, 3);
    stream_end(s);
    assert_int_equal(completions(s), 1);
    assert_int_equal(frame_event(s, 1), 2);
    assert_int_equal(counters(s)->frames, 1);
    stream_free(s);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_first_eye_begins_with_frame_1),
    cmocka_unit_test(an_eye_beside_the_other_takes_its_frame),
    cmocka_unit_test(an_eye_ahead_is_still_in_the_frame_before),
    cmocka_unit_test(an_eye_behind_is_in_the_frame_after),
    cmocka_unit_test(frame_numbers_may_be_0),
    cmocka_unit_test(a_break_before_the_first_is_spent_by_it),
    cmocka_unit_test(a_line_of_one_packet_takes_frame_1_when_there_is_none),
    cmocka_unit_test(a_line_of_one_packet_takes_the_frame_when_it_closes),
    cmocka_unit_test(a_line_of_one_packet_changes_nothing),
    cmocka_unit_test(a_frame_is_decided_by_the_second_accepted_packet),
    cmocka_unit_test(the_line_after_a_break_begins_a_frame),
    cmocka_unit_test(a_break_may_be_followed_by_line_0),
    cmocka_unit_test(breaks_without_a_line_between_are_one),
    cmocka_unit_test(a_break_ends_the_gap_before_it),
    cmocka_unit_test(no_line_straggles_between_a_break_and_the_next_wrap),
    cmocka_unit_test(a_line_straggles_after_the_wrap_behind_a_break),
    cmocka_unit_test(a_wrap_goes_back_by_more_than_r),
    cmocka_unit_test(a_wraps_line_is_its_gap),
    cmocka_unit_test(an_eye_wraps_beside_the_other_that_has),
    cmocka_unit_test(an_eye_does_not_wrap_beside_one_that_has_not_begun),
    cmocka_unit_test(an_eye_does_not_wrap_far_from_the_other),
    cmocka_unit_test(an_eye_does_not_wrap_beside_one_of_its_frame),
    cmocka_unit_test(the_other_eyes_wrap_is_a_wrap),
    cmocka_unit_test(an_eye_that_missed_frames_catches_up),
    cmocka_unit_test(an_eye_far_from_the_other_does_not_catch_up),
    cmocka_unit_test(an_eye_ahead_of_the_other_goes_on_by_one),
    cmocka_unit_test(a_break_catches_up_too),
    cmocka_unit_test(a_straggler_is_of_the_frame_before),
    cmocka_unit_test(a_straggler_comes_within_r_lines_of_the_wrap),
    cmocka_unit_test(a_straggler_is_more_than_r_above_the_top),
    cmocka_unit_test(a_straggler_is_no_more_than_r_below_the_top_before),
    cmocka_unit_test(nothing_straggles_before_the_first_wrap),
    cmocka_unit_test(a_straggler_changes_nothing_but_the_count),
    cmocka_unit_test(stragglers_follow_the_other_eyes_wrap_too),
    cmocka_unit_test(lines_in_order_skip_none),
    cmocka_unit_test(a_gap_grows_by_the_lines_between),
    cmocka_unit_test(a_gap_shrinks_by_each_line_that_comes_after_all),
    cmocka_unit_test(the_one_line_that_lacks_may_come_after_all),
    cmocka_unit_test(a_gap_is_never_below_0),
    cmocka_unit_test(the_top_once_more_changes_no_gap),
    cmocka_unit_test(a_line_below_does_not_lower_the_top),
    cmocka_unit_test(the_gaps_of_both_eyes_are_added_at_the_end),
    ANY_LAYOUT_TEST(the_widest_gap_is_counted),
    cmocka_unit_test(r_is_the_callers),
    cmocka_unit_test(frames_counts_distinct_numbers),
    cmocka_unit_test(frames_counts_from_the_first_line_on),
    cmocka_unit_test(a_frame_is_complete_after_r_lines_of_the_next),
    cmocka_unit_test(every_frame_is_complete_after_r_lines_of_the_next),
    cmocka_unit_test(stragglers_are_no_lines_of_a_later_frame),
    cmocka_unit_test(a_line_counts_once_however_many_packets_it_has),
    cmocka_unit_test(lines_of_any_later_frames_count_together),
    cmocka_unit_test(a_frame_is_not_complete_while_a_line_of_it_is_open),
    cmocka_unit_test(nor_while_the_line_opened_last_is_of_it),
    cmocka_unit_test(a_frame_before_that_of_an_open_line_may_be_complete),
    cmocka_unit_test(a_line_of_one_packet_holds_no_frame_back),
    cmocka_unit_test(all_lines_of_a_frame_come_before_it),
    cmocka_unit_test(frames_are_complete_in_order_each_once),
    cmocka_unit_test(the_end_completes_the_last_frame_after_its_lines),
    cmocka_unit_test(an_eye_alone_waits_for_the_other_for_gap_us),
    cmocka_unit_test(an_eye_at_gap_us_is_not_silent_yet),
    cmocka_unit_test(an_eye_that_begins_late_does_not_wake_the_other),
    cmocka_unit_test(an_eye_was_heard_at_its_newest_clock_not_its_last),
    cmocka_unit_test(an_eye_that_falls_silent_is_waited_for_gap_us),
    cmocka_unit_test(a_break_completes_the_frames_before_it),
    cmocka_unit_test(a_jump_of_one_eyes_clock_makes_the_other_not_silent),
    cmocka_unit_test(an_eye_is_heard_when_the_others_clock_jumps),
    cmocka_unit_test(a_break_completes_its_frame_whatever_r_is),
    cmocka_unit_test(one_packet_ahead_of_its_time_makes_nobody_silent),
    cmocka_unit_test(a_frame_that_the_other_eye_skips_is_complete_as_well),
    cmocka_unit_test(a_straggler_comes_before_its_frame_is_complete),
    cmocka_unit_test(a_frame_before_the_first_is_complete_before_it),
    cmocka_unit_test(a_frame_of_a_silent_eye_is_complete_once_and_in_order),
    cmocka_unit_test(a_frame_of_undecided_lines_alone_is_complete_at_the_end),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
