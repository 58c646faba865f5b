#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame/pause.h"

#include <stdlib.h>
#include <string.h>

#define LINES     64u
#define PERIOD_US 1500
#define GAP_US    100000u
#define SECOND_NS INT64_C(1000000000)

/* Lines as an assembler hands them out, where both eyes send all. */
struct stream {
    lum_pause pause;
    int64_t clock_us;
    int64_t arrival_ns;
    int64_t turn_us; /* behind each sweep */
    uint32_t period_us;
    int64_t frame;
    uint32_t number; /* of the next line */
    uint32_t lines;
    int64_t tick_us;
};

static void begin_with(struct stream *s, const lum_profile *profile)
{
    *s = (struct stream){.clock_us = 5000000,
                         .arrival_ns = 1000 * SECOND_NS,
                         .period_us = PERIOD_US,
                         .frame = 1,
                         .lines = LINES,
                         .tick_us = 1};
    lum_pause_init(&s->pause, GAP_US, profile);
}

static void begin(struct stream *s)
{
    lum_profile profile;
    lum_profile_default(&profile);
    begin_with(s, &profile);
}

static void take(struct stream *s, unsigned eye, int64_t frame, uint32_t number,
                 int64_t clock_us)
{
    const lum_line line = {.eye = (uint8_t)eye,
                           .frame = frame,
                           .number = number,
                           .clock_us = clock_us - clock_us % s->tick_us,
                           .arrival = s->arrival_ns};
    lum_pause_take(&s->pause, &line, true);
}

static void pass(struct stream *s, int64_t us)
{
    s->clock_us += us;
    s->arrival_ns += 1000 * us;
}

static void step(struct stream *s)
{
    pass(s, s->period_us);
    if (++s->number >= s->lines) {
        s->number = 0;
        s->frame++;
        pass(s, s->turn_us);
    }
}

/* Lines of both eyes. */
static void go(struct stream *s, uint32_t lines)
{
    for (uint32_t i = 0; i < lines; i++) {
        take(s, LUM_EYE_BLUE, s->frame, s->number, s->clock_us);
        take(s, LUM_EYE_GREEN, s->frame, s->number, s->clock_us);
        step(s);
    }
}

/* Lines that do not come, and whether the frames of the others show it. */
static void miss(struct stream *s, uint32_t lines, bool is_shown)
{
    const int64_t frame = s->frame;
    for (uint32_t i = 0; i < lines; i++) {
        step(s);
    }
    s->frame = is_shown ? s->frame : frame;
}

static void expect(struct stream *s, uint64_t pauses, int64_t us,
                   uint64_t lines)
{
    lum_pause_end(&s->pause);
    assert_int_equal(s->pause.counts.pauses, pauses);
    assert_int_equal(s->pause.counts.paused_us, us);
    assert_int_equal(s->pause.counts.lines, lines);
}

static void expect_none(struct stream *s)
{
    expect(s, 0, 0, 0);
}

static void a_steady_stream_has_none(void **state)
{
    (void)state;
    struct stream s;
    for (uint32_t first = 0; first < LINES; first += 9u) {
        begin(&s);
        s.number = first;
        go(&s, 5u * LINES);
        expect_none(&s);
    }
}

static void a_mirror_that_takes_long_to_turn_is_no_pause(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    s.turn_us = 20 * PERIOD_US;
    go(&s, LINES + 10u);
    assert_int_equal(s.pause.counts.pauses, 1); /* as far as is known */
    go(&s, 4u * LINES);
    expect_none(&s);
    miss(&s, 2u * LINES + 30u, true);
    go(&s, LINES);
    assert_int_equal(s.pause.counts.pauses, 1);
    assert_in_range(s.pause.counts.lines, 4u * LINES, 4u * LINES + 60u);
}

static bool can_keep(lum_pause *p)
{
    lum_pack written = {.written = NULL};
    const lum_pause_clock clock = p->clock;
    lum_pause_pack(p, &written);
    lum_pack read = lum_pack_of(written.written, written.len);
    *p = (lum_pause){.clock = clock};
    lum_pause_pack(p, &read);
    lum_pack_reset(&written);
    return !read.has_failed;
}

/* A first turn with a pause; the clock is not exact in the second. */
static void a_turn_that_takes_less_than_a_period_is_none(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    go(&s, LINES);
    pass(&s, 20 * PERIOD_US);
    go(&s, LINES);
    pass(&s, -PERIOD_US / 2);
    go(&s, LINES);
    expect(&s, 1, 20 * PERIOD_US, 40);
    assert_true(can_keep(&s.pause));
}

/* Now and then one bit of a number or of a clock is wrong. */
static void go_corrupt(struct stream *s, unsigned bit, int sign)
{
    for (uint32_t i = 0; i < 6u * LINES; i++) {
        const bool is_bad = i % 20u == 7u || i % LINES == LINES - 1u;
        const uint32_t flip = is_bad && bit < 6u ? 1u << bit : 0;
        const int64_t off = is_bad && bit >= 6u ? INT64_C(1) << bit : 0;
        take(s, LUM_EYE_BLUE, s->frame, s->number ^ flip,
             s->clock_us + sign * off);
        step(s);
    }
}

static void one_corrupt_line_tells_nothing(void **state)
{
    (void)state;
    struct stream s;
    for (unsigned bit = 0; bit < 17; bit++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            begin(&s);
            go_corrupt(&s, bit, sign);
            expect_none(&s);
        }
    }
}

static void sweeps_that_vanished_are_counted(void **state)
{
    (void)state;
    struct stream s;
    for (uint32_t first = 4; first < 2u * LINES; first++) {
        for (uint32_t sweeps = 1; sweeps < 10; sweeps += 4) {
            begin(&s);
            go(&s, first);
            miss(&s, sweeps * LINES, false);
            go(&s, 2u * LINES);
            expect(&s, 1, sweeps * LINES * PERIOD_US, 2u * sweeps * LINES);
        }
    }
}

static void what_numbers_show_is_in_no_pause(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    go(&s, LINES + 20u);
    miss(&s, 30, true); /* of one sweep */
    go(&s, LINES);
    expect_none(&s);
    go(&s, LINES - 18u);
    assert_int_equal(s.number, LINES - 12u + 44u - LINES);
    go(&s, 10);
    assert_int_equal(s.number, 42);
    miss(&s, 32, true); /* 22 up to the end, and 10 that numbers show */
    go(&s, LINES);
    expect(&s, 1, 32 * PERIOD_US, 2u * 22u);
}

static void an_eye_pauses_alone(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    go(&s, LINES + 30u);
    for (uint32_t i = 0; i < LINES; i++) {
        take(&s, LUM_EYE_BLUE, s.frame, s.number, s.clock_us);
        step(&s);
    }
    go(&s, LINES);
    /* the 30 up to the line are shown by numbers */
    expect(&s, 1, LINES * PERIOD_US, LINES - 30u);
}

/* Behind the jump of its clock green begins a frame, and blue follows in the
 * middle of a sweep: its numbers show 43 lines that it has sent. */
static void numbers_of_the_other_eye_may_show_more_than_is_missing(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    s.period_us = GAP_US / 32u;
    go(&s, LINES + 10u);
    for (uint32_t i = 0; i < 33u; i++) {
        take(&s, LUM_EYE_BLUE, s.frame, s.number, s.clock_us);
        step(&s);
    }
    s.frame++;
    go(&s, LINES);
    expect(&s, 1, 33u * s.period_us, 0);
}

static bool has_pause_of(unsigned eyes)
{
    struct stream s;
    uint64_t lines = 0;
    begin(&s);
    go(&s, LINES + 20u);
    for (uint32_t i = 0; i < 20u; i++) {
        take(&s, LUM_EYE_BLUE, s.frame, s.number, s.clock_us);
        step(&s);
    }
    s.number -= 20u; /* as many lines later, and no number says so */
    for (uint32_t i = 0; i < LINES - 20u; i++) {
        take(&s, LUM_EYE_GREEN, s.frame, s.number, s.clock_us);
        step(&s);
    }
    return lum_pause_frame_ends(&s.pause, 2, eyes, true, &lines);
}

static void a_frame_without_the_eye_that_paused_is_whole(void **state)
{
    (void)state;
    assert_true(has_pause_of(1u << LUM_EYE_BLUE | 1u << LUM_EYE_GREEN));
    assert_true(has_pause_of(1u << LUM_EYE_GREEN));
    assert_false(has_pause_of(1u << LUM_EYE_BLUE));
}

/* After a jump of the clock the assembler counts no line as skipped. */
static void a_jump_of_the_clock_is_a_pause(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    go(&s, LINES + 30u);
    miss(&s, 100, true);
    go(&s, LINES);
    expect(&s, 1, 100 * PERIOD_US, 200);
    assert_int_equal(s.pause.counts.breaks, 2);
}

/* Then only the host's clock tells how long it was: after a restart, also where
 * 32 bits went round; and nothing where clocks do not tell. */
static void a_clock_that_started_again_tells_no_time(void **state)
{
    (void)state;
    static const int64_t jumps_us[] = {-4000000, INT64_C(1) << 30};
    struct stream s;
    for (size_t i = 0; i < 2; i++) {
        begin(&s);
        go(&s, LINES + 30u);
        s.clock_us += jumps_us[i];
        s.arrival_ns += 2 * SECOND_NS;
        s.number = 5;
        s.frame++;
        go(&s, LINES);
        expect(&s, 1, 2000000, 2u * (2000000u / PERIOD_US));
    }
    begin(&s);
    go(&s, LINES + 30u);
    s.clock_us -= 4000000;
    s.frame++;
    go(&s, LINES);
    expect(&s, 1, 0, 0);
}

static void a_coarse_clock_tells_as_much_as_it_can(void **state)
{
    (void)state;
    struct stream s;
    lum_profile profile;
    lum_profile_default(&profile);
    profile.clock_unit_ns = 10000000;
    begin_with(&s, &profile);
    s.tick_us = 10000;
    go(&s, 4u * LINES);
    expect_none(&s);
    miss(&s, LINES, false);
    go(&s, 2u * LINES);
    lum_pause_end(&s.pause);
    assert_int_equal(s.pause.counts.pauses, 1);
    assert_in_range(s.pause.counts.lines, 2u * LINES - 20u, 2u * LINES + 20u);
}

static void without_a_clock_arrivals_tell_a_second(void **state)
{
    (void)state;
    struct stream s;
    lum_profile profile;
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_TIMESTAMP].bytes = 0;
    begin_with(&s, &profile);
    go(&s, 2u * LINES);
    s.arrival_ns += SECOND_NS / 2;
    go(&s, LINES);
    expect_none(&s);
    s.arrival_ns += 3 * SECOND_NS;
    go(&s, LINES);
    lum_pause_end(&s.pause);
    assert_int_equal(s.pause.counts.pauses, 1);
    assert_in_range(s.pause.counts.paused_us, 3000000, 3000000 + PERIOD_US);
    s.arrival_ns -= 3600 * SECOND_NS; /* the host's clock was set */
    go(&s, LINES);
    s.arrival_ns += 3 * SECOND_NS;
    go(&s, LINES);
    lum_pause_end(&s.pause);
    assert_int_equal(s.pause.counts.pauses, 2);
}

static void another_scan_is_no_pause(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    for (unsigned i = 0; i < 6; i++) {
        s.lines = i % 2u == 0 ? LINES : 10u * LINES;
        s.period_us = i % 4u < 2u ? PERIOD_US : PERIOD_US / 10u;
        go(&s, 3u * s.lines);
        expect_none(&s);
    }
    miss(&s, s.lines, false);
    go(&s, s.lines);
    expect(&s, 1, s.lines * PERIOD_US, 2u * s.lines);
}

/* A frame of it whose end is there is whole where a pause follows. */
static void a_scan_of_fewer_lines_ends_earlier(void **state)
{
    (void)state;
    struct stream s;
    uint64_t lines = 0;
    begin(&s);
    s.lines = 10u * LINES;
    go(&s, 2u * s.lines);
    s.lines = LINES;
    go(&s, 3u * LINES);
    miss(&s, 20, true);
    go(&s, LINES);
    assert_false(lum_pause_frame_ends(&s.pause, 5, 3, false, &lines));
    expect(&s, 0, 0, 0); /* their numbers show all 20 */
}

/* The period is not exact. */
static void a_sweep_that_takes_a_little_longer_is_no_pause(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    s.lines = 10u * LINES;
    s.period_us = PERIOD_US / 10u;
    go(&s, s.lines + 30u);
    miss(&s, 9u * LINES, true);
    pass(&s, 12 * s.period_us);
    go(&s, s.lines);
    expect_none(&s);
}

/* Frames in which one lies, or whose end it took. */
static void a_frame_knows_its_pauses(void **state)
{
    (void)state;
    struct stream s;
    uint64_t lines = 0;
    begin(&s);
    go(&s, LINES + 30u);
    assert_false(lum_pause_frame_ends(&s.pause, 1, 3, false, &lines));
    miss(&s, LINES, false);
    go(&s, LINES);
    assert_true(lum_pause_frame_ends(&s.pause, 2, 3, false, &lines));
    assert_int_equal(lines, 2u * LINES);
    miss(&s, LINES, true); /* 34 of frame 3, 30 of frame 4 */
    go(&s, LINES);
    assert_true(
        lum_pause_frame_ends(&s.pause, 3, LUM_EYE_BLUE + 1u, false, &lines));
    assert_int_equal(lines, LINES - 30u);
    assert_false(lum_pause_frame_ends(&s.pause, 4, 3, false, &lines));
    /* an eye that has stopped has not all of a frame, but at the end */
    assert_true(lum_pause_frame_ends(&s.pause, 5, 3, false, &lines));
    assert_false(lum_pause_frame_ends(&s.pause, 5, 3, true, &lines));
}

/* By the rules of frames. The frame ends before others confirm the pause. */
static void a_line_behind_a_pause_can_be_a_straggler_of_the_frame_before(
    void **state)
{
    (void)state;
    struct stream s;
    uint64_t lines = 0;
    for (unsigned eyes = 1; eyes < 4; eyes++) {
        begin(&s);
        go(&s, LINES + 7u);
        miss(&s, LINES - 8u, true);
        take(&s, LUM_EYE_BLUE, s.frame - 1, s.number, s.clock_us);
        assert_int_equal(lum_pause_frame_ends(&s.pause, 1, eyes, true, &lines),
                         eyes != 1u << LUM_EYE_GREEN);
        expect_none(&s);
    }
}

/* Pauses of all kinds. The state is written and read before line `at`. Returns
 * what each frame lacks by them. */
static void go_with_state(uint32_t at, uint64_t *frames)
{
    struct stream s;
    begin(&s);
    for (uint32_t i = 0; i < 4u * LINES; i++) {
        if (i == 30u || i == 80u || i == 120u) {
            miss(&s, i, i != 80u);
        }
        if (i == at) {
            assert_true(can_keep(&s.pause));
        }
        if (s.number == 12u) {
            lum_pause_frame_ends(&s.pause, (uint32_t)s.frame - 1u, 3, false,
                                 &frames[s.frame]);
        }
        go(&s, 1);
    }
}

/* It goes on as if nothing had been. */
static void its_state_can_be_kept_at_any_line(void **state)
{
    (void)state;
    uint64_t all[16] = {0};
    uint64_t sum = 0;
    go_with_state(UINT32_MAX, all);
    for (size_t i = 0; i < 16; i++) {
        sum += all[i];
    }
    assert_int_equal(sum, 2u * LINES);
    for (uint32_t at = 1; at < 3u * LINES; at++) {
        uint64_t frames[16] = {0};
        go_with_state(at, frames);
        assert_memory_equal(frames, all, sizeof all);
    }
}

/* As many lines as it takes, and no step from which to learn. */
static void a_state_without_a_period_can_be_kept(void **state)
{
    (void)state;
    struct stream s;
    begin(&s);
    for (uint32_t i = 0; i < 2u * LUM_PAUSE_SAMPLES; i++) {
        take(&s, LUM_EYE_BLUE, 1, 100u - i, s.clock_us);
        s.clock_us += PERIOD_US;
    }
    assert_true(can_keep(&s.pause));
}

static void a_damaged_state_is_refused(void **state)
{
    (void)state;
    struct stream s;
    lum_pack written = {.written = NULL};
    begin(&s);
    go(&s, 2u * LINES);
    lum_pause_pack(&s.pause, &written);
    for (size_t len = 0; len < written.len; len++) {
        lum_pack read = lum_pack_of(written.written, len);
        lum_pause_pack(&s.pause, &read);
        assert_true(read.has_failed);
    }
    for (size_t i = 0; i < 8u * written.len; i++) {
        lum_pack read = lum_pack_of(written.written, written.len);
        written.written[i / 8u] ^= (uint8_t)(1u << i % 8u);
        lum_pause_pack(&s.pause, &read);
        go(&s, LINES); /* whatever it was, it is of use */
        written.written[i / 8u] ^= (uint8_t)(1u << i % 8u);
    }
    lum_pack_reset(&written);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_steady_stream_has_none),
        cmocka_unit_test(a_mirror_that_takes_long_to_turn_is_no_pause),
        cmocka_unit_test(a_turn_that_takes_less_than_a_period_is_none),
        cmocka_unit_test(one_corrupt_line_tells_nothing),
        cmocka_unit_test(sweeps_that_vanished_are_counted),
        cmocka_unit_test(what_numbers_show_is_in_no_pause),
        cmocka_unit_test(an_eye_pauses_alone),
        cmocka_unit_test(
            numbers_of_the_other_eye_may_show_more_than_is_missing),
        cmocka_unit_test(a_frame_without_the_eye_that_paused_is_whole),
        cmocka_unit_test(a_jump_of_the_clock_is_a_pause),
        cmocka_unit_test(a_clock_that_started_again_tells_no_time),
        cmocka_unit_test(a_coarse_clock_tells_as_much_as_it_can),
        cmocka_unit_test(without_a_clock_arrivals_tell_a_second),
        cmocka_unit_test(another_scan_is_no_pause),
        cmocka_unit_test(a_scan_of_fewer_lines_ends_earlier),
        cmocka_unit_test(a_sweep_that_takes_a_little_longer_is_no_pause),
        cmocka_unit_test(a_frame_knows_its_pauses),
        cmocka_unit_test(
            a_line_behind_a_pause_can_be_a_straggler_of_the_frame_before),
        cmocka_unit_test(its_state_can_be_kept_at_any_line),
        cmocka_unit_test(a_state_without_a_period_can_be_kept),
        cmocka_unit_test(a_damaged_state_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
