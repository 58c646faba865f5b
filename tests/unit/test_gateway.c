#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"

static void it_is_stopped_until_both_eyes_were_heard(void **state)
{
    struct rig *const r = rig_informed(0);
    (void)state;
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    pass(r, 10u * FRAME, BLUE);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, FRAME + 2u * STEP, BOTH); /* then green's first frame is out */
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, HOLD - STEP, BOTH);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void a_hold_of_a_moment_does_not_end_the_first_silence(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->now = 77;
    r->config.frame_ms = 1;
    r->config.hold_ms = 3;
    assert_int_equal(rig_init(r), LUM_OK);
    for (unsigned i = 0; i < 3; i++) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
    }
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

/* Of its newest lines two are open. */
static void an_eye_that_falls_silent_stops(void **state)
{
    static const unsigned alone[] = {BLUE, GREEN};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct rig *const r = rig_going(0);
        pass(r, SILENCE - 3u * STEP, alone[i]);
        assert_int_equal(reasons(r), 0);
        pass(r, STEP, alone[i]);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        pass(r, 2u * FRAME, BOTH);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        pass(r, HOLD + 2u * STEP, BOTH);
        assert_int_equal(reasons(r), 0);
        rig_free(r);
    }
}

static void an_eye_that_is_not_wanted_may_be_silent(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.eyes = GREEN;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 10u * FRAME, GREEN);
    assert_int_equal(reasons(r), 0);
    pass(r, 1000, BLUE);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

static void lines_without_points_are_silence(void **state)
{
    (void)state;
    for (unsigned with_angles = 0; with_angles < 2; with_angles++) {
        struct rig *const r = rig_going(0);
        for (unsigned i = 0; i < SILENCE / STEP; i++) {
            r->now += STEP;
            gateway_tick(&r->gateway, r->now);
            if (with_angles != 0) {
                put_angles(r, LUM_EYE_GREEN);
            } else {
                put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, NEAR_TOF, true, 0, 10);
            }
            show(r, BLUE, FAR_TOF, 1);
        }
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        rig_free(r);
    }
}

static void silence_lasts_beyond_a_wrap_of_the_clock(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    pass(r, 1000, 0);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    r->now += UINT32_MAX - 900u; /* as long ago as a moment, by the clock */
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

static void as_many_hits_as_wanted_stop_at_once(void **state)
{
    (void)state;
    for (uint32_t n = HITS - 1u; n <= HITS; n++) {
        struct rig *const r = rig_going(0);
        show(r, GREEN, NEAR_TOF, n);
        show_out(r);
        assert_int_equal(reasons(r), n < HITS ? 0 : GATEWAY_OBJECT);
        rig_free(r);
    }
}

static void hits_of_both_eyes_and_many_lines_add_up_within_a_frame(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    show(r, BLUE, NEAR_TOF, 2);
    show(r, GREEN, NEAR_TOF, 2);
    show_out(r);
    assert_int_equal(reasons(r), 0);
    show(r, BLUE, NEAR_TOF, 1);
    show_out(r);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    rig_free(r);
}

static void hits_of_two_frames_do_not_add_up(void **state)
{
    struct rig *const r = rig_going(0);
    const size_t frames = r->frames;
    (void)state;
    for (unsigned frame = 0; frame < 6; frame++) {
        next_frame(r);
        show(r, BOTH, NEAR_TOF, HITS / 2u);
    }
    show_out(r);
    assert_int_equal(reasons(r), 0);
    assert_true(r->frames >= frames + 4u);
    rig_free(r);
}

static void falling_edges_are_no_hits(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    put_angles(r, LUM_EYE_BLUE);
    put(r, LUM_EYE_BLUE, LUM_TAG_RANGES, NEAR_TOF, false, 0, 20);
    (void)gateway_receive(&r->gateway, r->now);
    next_line(r);
    show_out(r);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void a_stop_outlives_its_cause_by_the_hold(void **state)
{
    struct rig *const r = rig_going(UINT32_MAX - 4400u); /* wraps meanwhile */
    (void)state;
    show(r, BLUE, NEAR_TOF, HITS);
    show_out(r);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    pass(r, HOLD - STEP, BOTH);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

/* Whether an object in the way shows first in odd frames, and last in even
 * ones: two frames minus a line apart. */
static bool is_in_sight(unsigned frame, uint32_t line)
{
    return line == (frame % 2u != 0 ? 0 : LINES - 1u);
}

static void what_two_frames_show_far_apart_is_one_stop(void **state)
{
    struct rig *const r = rig_new();
    bool seen = false;
    (void)state;
    r->config.hold_ms = 2u * FRAME + (GATEWAY_OPEN_LINES + 1u) * STEP;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 4000, BOTH);
    next_frame(r);
    assert_int_equal(reasons(r), 0);
    for (unsigned frame = 1; frame < 9; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            r->now += STEP;
            gateway_tick(&r->gateway, r->now);
            if (is_in_sight(frame, line)) {
                show(r, BOTH, NEAR_TOF, HITS);
            } else {
                show(r, BOTH, FAR_TOF, 1);
            }
            seen = seen || reasons(r) != 0;
            assert_int_equal(reasons(r), seen ? GATEWAY_OBJECT : 0);
        }
    }
    assert_true(seen);
    rig_free(r);
}

static void what_stays_in_the_zone_keeps_the_machine_stopped(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    for (unsigned frame = 0; frame < 8; frame++) {
        next_frame(r);
        show(r, BLUE, NEAR_TOF, HITS);
        show_out(r);
        assert_int_equal(reasons(r), GATEWAY_OBJECT);
        pass(r, 500, BOTH);
        assert_int_equal(reasons(r), GATEWAY_OBJECT);
    }
    rig_free(r);
}

static void a_frame_tells_its_hits_and_the_nearest(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    next_frame(r);
    show(r, GREEN, NEAR_TOF + 100, 2);
    show(r, BLUE, NEAR_TOF, 2);
    show(r, BLUE, NEAR_TOF + 200, 3);
    for (unsigned i = 0; i < 2u * LINES && r->sight.hits == 0; i++) {
        pass(r, STEP, BOTH);
    }
    const int64_t frame = r->frame;
    assert_int_equal(r->sight.hits, 7);
    assert_int_equal(zone_nearest_mm(&r->sight), 4999); /* 4999.8 */
    pass(r, FRAME, BOTH);
    assert_int_equal(r->frame, frame + 1);
    assert_int_equal(r->sight.hits, 0);
    assert_int_equal(zone_nearest_mm(&r->sight), 0);
    rig_free(r);
}

static void a_line_too_late_for_its_frame_counts_for_the_newer_one(void **state)
{
    struct rig *const r = rig_informed(0);
    const gateway_frame *const frame = &r->gateway.frames[1];
    (void)state;
    pass(r, 3u * STEP, BOTH);
    assert_int_equal(frame->number, 1);
    r->gateway.frames[1].number = 1 + GATEWAY_FRAMES; /* its place */
    show(r, BLUE, NEAR_TOF, HITS);
    show_out(r);
    assert_true(r->points > 0);
    assert_int_equal(frame->sight.hits, HITS);
    assert_int_equal(frame->number, 1 + GATEWAY_FRAMES);
    assert_true((reasons(r) & GATEWAY_OBJECT) != 0);
    while (r->frames == 0) {
        pass(r, STEP, BOTH);
    }
    assert_int_equal(r->frame, 1); /* of which nothing is known any more */
    assert_int_equal(r->sight.hits, 0);
    rig_free(r);
}

/* As if there had been this many frames. */
static void count_frames_to(struct rig *r, uint32_t frame)
{
    lum_assembler *const a = &r->gateway.assembler;
    gateway_finish(&r->gateway);
    a->frames.highest = frame;
    a->frames.next = frame + 1u;
    for (unsigned e = 0; e < LUM_EYES; e++) {
        a->eye[e].frames.frame = frame;
        for (unsigned i = 0; i < GATEWAY_REORDER_LINES; i++) {
            a->eye[e].reach[i].frame = frame + 1u;
        }
        r->gateway.looks[e].frame = frame;
    }
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        r->gateway.frames[(frame - i) % GATEWAY_FRAMES].number = frame - i;
    }
}

static void a_wrap_of_frame_numbers_changes_nothing(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    next_frame(r);
    count_frames_to(r, UINT32_MAX - 2u);
    for (unsigned frame = 0; frame < 12; frame++) {
        show(r, BOTH, NEAR_TOF, HITS / 2u);
        pass(r, STEP, BOTH);
        next_frame(r);
        assert_int_equal(reasons(r), 0);
    }
    assert_int_equal(r->frame, 8);
    assert_int_equal(r->sight.hits, HITS / 2u * 2u);
    rig_free(r);
}

static void a_frame_before_the_first_is_a_frame_too(void **state)
{
    struct rig *const r = rig_informed(0);
    (void)state;
    show(r, BLUE, FAR_TOF, 1);
    show(r, BLUE, FAR_TOF, 1);
    r->line = 50; /* far ahead of the other eye: of its last frame */
    show(r, GREEN, NEAR_TOF, 2);
    for (unsigned i = 0; i < GATEWAY_OPEN_LINES; i++) {
        r->line = 51 + i;
        show(r, GREEN, FAR_TOF, 1);
    }
    assert_int_equal(r->gateway.frames[0].number, 0);
    assert_int_equal(r->gateway.frames[0].sight.hits, 2);
    assert_int_equal(zone_nearest_mm(&r->gateway.frames[0].sight), 4999);
    rig_free(r);
}

static void the_end_hands_out_what_is_open(void **state)
{
    struct rig *const r = rig_going(0);
    size_t lines;
    (void)state;
    next_frame(r);
    lines = r->lines;
    show(r, BOTH, NEAR_TOF, HITS);
    gateway_finish(&r->gateway);
    assert_int_equal(r->lines, lines + 2u + 2u * GATEWAY_OPEN_LINES);
    assert_int_equal(r->sight.hits, 2u * HITS);
    rig_free(r);
}

static void observers_may_be_missing(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->output.line = NULL;
    r->output.points = NULL;
    r->output.frame = NULL;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 4000, BOTH);
    gateway_finish(&r->gateway);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void every_point_is_handed_out_once(void **state)
{
    static const uint32_t counts[] = {1, 15, 16, 17, 31, 32, 33, 48, 100};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        struct rig *const r = rig_informed(0);
        show(r, BLUE, NEAR_TOF, counts[i]);
        gateway_finish(&r->gateway);
        assert_int_equal(r->lines, 1);
        assert_int_equal(r->points, counts[i]);
        assert_int_equal(
            lum_assembler_counters(&r->gateway.assembler)->duplicate, 0);
        rig_free(r);
    }
}

/* As many as may be under way have places of their own. */
static void frames_take_turns_with_their_places(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    pass(r, 6u * FRAME, BOTH);
    uint32_t least = UINT32_MAX;
    uint32_t most = 0;
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        const uint32_t number = r->gateway.frames[i].number;
        assert_int_equal(number % GATEWAY_FRAMES, i);
        least = number < least ? number : least;
        most = number > most ? number : most;
    }
    assert_true(least > GATEWAY_FRAMES);
    assert_int_equal(most - least, GATEWAY_FRAMES - 1u);
    rig_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_stopped_until_both_eyes_were_heard),
        cmocka_unit_test(a_hold_of_a_moment_does_not_end_the_first_silence),
        cmocka_unit_test(an_eye_that_falls_silent_stops),
        cmocka_unit_test(an_eye_that_is_not_wanted_may_be_silent),
        cmocka_unit_test(lines_without_points_are_silence),
        cmocka_unit_test(silence_lasts_beyond_a_wrap_of_the_clock),
        cmocka_unit_test(as_many_hits_as_wanted_stop_at_once),
        cmocka_unit_test(
            hits_of_both_eyes_and_many_lines_add_up_within_a_frame),
        cmocka_unit_test(hits_of_two_frames_do_not_add_up),
        cmocka_unit_test(falling_edges_are_no_hits),
        cmocka_unit_test(a_stop_outlives_its_cause_by_the_hold),
        cmocka_unit_test(what_two_frames_show_far_apart_is_one_stop),
        cmocka_unit_test(what_stays_in_the_zone_keeps_the_machine_stopped),
        cmocka_unit_test(a_frame_tells_its_hits_and_the_nearest),
        cmocka_unit_test(
            a_line_too_late_for_its_frame_counts_for_the_newer_one),
        cmocka_unit_test(a_wrap_of_frame_numbers_changes_nothing),
        cmocka_unit_test(a_frame_before_the_first_is_a_frame_too),
        cmocka_unit_test(the_end_hands_out_what_is_open),
        cmocka_unit_test(observers_may_be_missing),
        cmocka_unit_test(every_point_is_handed_out_once),
        cmocka_unit_test(frames_take_turns_with_their_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
