#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"
#include "support.h"

#include <stdlib.h>

/* All that is measured has the age of its clock. */
static void packets_as_old_as_the_silence_are_left_out(void **state)
{
    (void)state;
    for (uint32_t age_ms = SILENCE - 1u; age_ms <= SILENCE; age_ms++) {
        struct rig *const r = rig_going(0);
        const uint32_t old = r->gateway.old_packets;
        const size_t lines = r->lines;
        r->boot_us -= age_ms * 1000u;
        r->is_mute = true;
        show(r, BLUE, FAR_TOF, 1);
        if (age_ms < SILENCE) { /* late: newer lines have closed */
            assert_int_equal(r->gateway.old_packets, old);
            assert_int_equal(r->gateway.assembler.counters.late, 5);
        } else {
            assert_int_equal(r->gateway.old_packets, old + 5u);
            assert_int_equal(r->gateway.assembler.counters.late, 0);
        }
        assert_int_equal(r->lines, lines);
        rig_free(r);
    }
}

/* While the sensor is away, nothing comes out. */
static void lines_that_become_old_are_closed_and_left_out(void **state)
{
    struct rig *const r = rig_going(0);
    const lum_assembly_counters *const c =
        lum_assembler_counters(&r->gateway.assembler);
    const size_t lines = r->lines;
    (void)state;
    for (unsigned i = 0; i < SILENCE; i++) {
        r->now++;
        (void)gateway_receive(&r->gateway, r->now);
    }
    /* of the older two 525 ms have passed, of the others 500 */
    assert_int_equal(c->lines_idle, 2);
    r->now++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(c->lines_idle, 4);
    assert_int_equal(r->gateway.old_lines, 4);
    assert_int_equal(r->lines, lines);
    rig_free(r);
}

/* A line that has waited is one of its age. */
static void lines_are_taken_until_they_are_as_old_as_the_silence(void **state)
{
    (void)state;
    for (uint32_t age_ms = SILENCE - 1u; age_ms <= SILENCE; age_ms++) {
        struct rig *const r = rig_going(0);
        const size_t lines = r->lines;
        r->now += age_ms - STEP;
        show(r, BOTH, FAR_TOF, 1);
        assert_int_equal(r->lines, age_ms < SILENCE ? lines + 2u : lines);
        assert_int_equal(r->gateway.old_lines, age_ms < SILENCE ? 0 : 2);
        assert_int_equal(r->gateway.assembler.counters.duplicate, 0);
        rig_free(r);
    }
}

/* Asked for longer ago than silence_ms, an answer is none. */
static void an_answer_serves_that_was_asked_for_lately(void **state)
{
    struct rig *const r = rig_at(5000);
    (void)state;
    tell_clock(r, r->now - HOLD + 1u, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_false(r->gateway.age.answered);
    tell_clock(r, r->now - SILENCE, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_false(r->gateway.age.answered);
    tell_clock(r, r->now - SILENCE + 1u, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_true(r->gateway.age.answered);
    rig_free(r);
}

static void expect_recovery(struct rig *r)
{
    pass(r, 2u * HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
}

static void drop_one(struct rig *r)
{
    while (receive(r, "", 0)) {
    }
}

static void waste_words(struct rig *r)
{
    for (unsigned i = 0; i < 1u + GATEWAY_LINE_WORDS / PACKET_MAX; i++) {
        uint8_t samples[PACKET_MAX * LUM_SAMPLE_BYTES];
        const lum_group group = {.line = r->line,
                                 .num_samples = PACKET_MAX,
                                 .first_sample_index = i * PACKET_MAX,
                                 .clock_raw = sensor_clock(r),
                                 .eye = LUM_EYE_GREEN,
                                 .tag = LUM_TAG_RANGES};
        size_t len = 0;
        uint8_t *packet;
        for (uint32_t k = 0; k < PACKET_MAX; k++) {
            lum_word_encode(lum_word_make(FAR_TOF, true, 100u + i),
                            samples + (size_t)LUM_SAMPLE_BYTES * k);
        }
        packet = encode_packet(&r->layout, &group, samples, &len);
        assert_true(receive(r, packet, len));
        (void)gateway_receive(&r->gateway, r->now);
        free(packet);
    }
}

static void conflict(struct rig *r)
{
    put_angles(r, LUM_EYE_GREEN);
    put(r, LUM_EYE_GREEN, LUM_TAG_ANGLES, 0, false, 100, PACKET_MAX);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 0, 10);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 9, 10);
    (void)gateway_receive(&r->gateway, r->now);
}

static void leave_event(struct rig *r)
{
    lum_group group = {.num_samples = 1,
                       .clock_raw = sensor_clock(r) + 1000u,
                       .eye = LUM_EYE_GREEN,
                       .tag = LUM_TAG_ANGLES};
    const uint8_t sample[LUM_SAMPLE_BYTES] = {0};
    group.samples = sample;
    group.line = r->line + 1u;
    assert_true(lum_assembler_push(&r->gateway.assembler, &group,
                                   r->gateway.now_ms) > 0);
}

/* A machine whose times leave no room for a frame that is not whole. */
static struct rig *rig_tight(unsigned eyes)
{
    struct rig *const r = rig_new();
    r->config.eyes = (uint8_t)eyes;
    r->config.hold_ms = 2u * FRAME + (GATEWAY_OPEN_LINES + 1u) * STEP;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 5000, BOTH);
    next_frame(r);
    pass(r, 5u * STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    return r;
}

/* A loss that shows in no line, because it may have been the last packet of its
 * line. */
static void what_the_gateway_loses_makes_no_whole_look(void **state)
{
    static const struct {
        void (*lose)(struct rig *);
        unsigned eyes;
        bool is_blind;
    } rows[] = {
        {drop_one, BLUE, true},     {drop_one, GREEN, true},
        {waste_words, BLUE, false}, {waste_words, GREEN, true},
        {conflict, BLUE, false},    {conflict, GREEN, true},
        {leave_event, BLUE, true},  {leave_event, GREEN, true},
    };
    (void)state;
    for (unsigned i = 0; i < 8; i++) {
        struct rig *const r = rig_tight(rows[i].eyes);
        bool is_blind = false;
        rows[i].lose(r);
        for (uint32_t ms = 0; ms < 3u * FRAME; ms += STEP) {
            pass(r, STEP, BOTH);
            is_blind = is_blind || reasons(r) == GATEWAY_SILENT;
        }
        assert_true(is_blind == rows[i].is_blind);
        expect_recovery(r);
        rig_free(r);
    }
}

/* The packets that the last line of a frame still waited for come too late. */
static void lines_cut_by_an_event_that_waited_complete_no_look(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    int64_t whole_ms[LUM_EYES];
    (void)state;
    while (r->line != LINES - 1u) {
        pass(r, STEP, BOTH);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        put_angles(r, eye);
        (void)gateway_receive(&r->gateway, r->now);
        whole_ms[eye] = r->gateway.looks[eye].whole_ms;
    }
    leave_event(r);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(r->gateway.assembler.counters.refused, 2);
    assert_int_equal(r->gateway.assembler.eye[LUM_EYE_GREEN].lines.open_count,
                     1);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(r->gateway.looks[eye].whole_ms, whole_ms[eye]);
        assert_int_equal(r->gateway.looks[eye].count, LINES - 2u);
    }
    rig_free(r);
}

static void assert_spoilt(const struct rig *r, unsigned eyes)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(r->gateway.looks[eye].spoilt_ms == r->now,
                         eyes >> eye & 1u);
    }
}

static void a_conflict_spoils_the_look_of_its_eye(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct rig *const r = rig_informed(55);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 0, 10);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 0, 10); /* a duplicate */
        (void)gateway_receive(&r->gateway, r->now);
        assert_spoilt(r, 0);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 5, 10);
        (void)gateway_receive(&r->gateway, r->now);
        assert_spoilt(r, 1u << eye);
        rig_free(r);
    }
}

static void a_datagram_that_was_dropped_spoils_both_looks(void **state)
{
    struct rig *const r = rig_informed(55);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, 0);
    r->gateway.ring.dropped++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    r->now++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, 0);
    rig_free(r);
}

/* As an interrupt of the network does while the main loop is in its round. */
static void drop_during_a_line(void *context, const lum_line *line)
{
    struct rig *const r = context;
    (void)line;
    r->gateway.output.line = NULL;
    r->gateway.ring.dropped++;
}

static void what_is_dropped_during_a_round_spoils_the_lines_behind(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    const look *const eye = &r->gateway.looks[LUM_EYE_BLUE];
    const uint32_t before = eye->count;
    (void)state;
    r->gateway.output.line = drop_during_a_line;
    for (unsigned i = 0; i < 2; i++) { /* each closes a whole line */
        put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
        next_line(r);
    }
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(eye->count, before + 1u);
    assert_spoilt(r, BOTH);
    rig_free(r);
}

/* Behind the last datagram too. */
static void what_is_dropped_at_a_rounds_end_is_seen_by_that_round(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    (void)state;
    r->gateway.output.line = drop_during_a_line;
    put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    rig_free(r);
}

/* As of a flush by another. */
static void an_event_that_waits_spoils_both_looks_and_costs_no_packet(
    void **state)
{
    struct rig *const r = rig_informed(55);
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        put(r, LUM_EYE_GREEN, LUM_TAG_ANGLES, 0, false, 0, 1);
        next_line(r);
    }
    (void)gateway_receive(&r->gateway, r->now);
    const lum_group other = {.line = r->line,
                             .num_samples = 1,
                             .clock_raw = sensor_clock(r),
                             .eye = LUM_EYE_GREEN,
                             .tag = LUM_TAG_ANGLES,
                             .samples = (const uint8_t[4]){0}};
    assert_int_equal(lum_assembler_push(&r->gateway.assembler, &other, 0),
                     LUM_LINE_READY);
    r->line = 9;
    put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    const size_t before = r->lines;
    gateway_finish(&r->gateway);
    assert_int_equal(r->lines, before + 1u);
    rig_free(r);
}

/* A packet of an eye, whose sensor is ahead of now_ms by so much. */
static void show_ahead(struct rig *r, unsigned eye, uint32_t ahead_us)
{
    const uint32_t boot_us = r->boot_us;
    r->boot_us += ahead_us;
    put(r, eye, LUM_TAG_ANGLES, 0, false, 0, 1);
    r->boot_us = boot_us;
    (void)gateway_receive(&r->gateway, r->now);
}

/* A dead timer whose count is now_ms, or one that goes on but counts nothing.
 */
static void a_clock_that_stands_still_stops_the_machine(void **state)
{
    (void)state;
    for (unsigned has_ticks = 0; has_ticks < 2; has_ticks++) {
        struct rig *const r = rig_going(0);
        const uint32_t boot_us = r->boot_us;
        r->is_mute = true;
        for (unsigned i = 0; i < 2u * HOLD / STEP; i++) {
            const uint32_t ahead_us = r->boot_us - boot_us;
            if (has_ticks != 0) {
                gateway_tick(&r->gateway, r->now);
            }
            show(r, BOTH, FAR_TOF, 1);
            assert_int_equal(reasons(r), ahead_us > AGE_AHEAD_MS * 1000u
                                             ? GATEWAY_STALLED
                                             : 0);
            r->boot_us += STEP * 1000u;
        }
        r->is_mute = false;
        tell_clock(r, r->now, sensor_clock(r));
        pass(r, HOLD - STEP, BOTH);
        assert_true((reasons(r) & GATEWAY_STALLED) != 0);
        expect_recovery(r);
        rig_free(r);
    }
}

/* From before a restart is what is farther ahead; and nothing is ahead of a
 * clock that the sensor has not told. */
static void a_packet_of_either_eye_shows_that_the_clock_is_behind(void **state)
{
    static const struct {
        uint32_t hold_ms, ahead_us;
        bool stalls;
    } rows[] = {
        {HOLD, 100000, false},    {HOLD, 100001, true}, {HOLD, 600000000, true},
        {HOLD, 600000001, false}, {101, 100000, false}, {101, 100001, true},
        {100, 99000, false},      {100, 99001, true},   {60, 59000, false},
        {60, 59001, true},
    };
    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        struct rig *const r = rig_new();
        const unsigned row = i / 2u;
        r->config.frame_ms = 20;
        r->config.hold_ms = rows[row].hold_ms;
        assert_int_equal(rig_init(r), LUM_OK);
        run(r, HEART_SILENCE_MS + HOLD, STEP);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        show_ahead(r, i % 2u, rows[row].ahead_us);
        assert_int_equal((reasons(r) & GATEWAY_STALLED) != 0, rows[row].stalls);
        run(r, HOLD, STEP);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        age_init(&r->gateway.age);
        show_ahead(r, i % 2u, rows[row].ahead_us);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        rig_free(r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_as_old_as_the_silence_are_left_out),
        cmocka_unit_test(lines_that_become_old_are_closed_and_left_out),
        cmocka_unit_test(lines_are_taken_until_they_are_as_old_as_the_silence),
        cmocka_unit_test(an_answer_serves_that_was_asked_for_lately),
        cmocka_unit_test(a_clock_that_stands_still_stops_the_machine),
        cmocka_unit_test(a_packet_of_either_eye_shows_that_the_clock_is_behind),
        cmocka_unit_test(what_the_gateway_loses_makes_no_whole_look),
        cmocka_unit_test(lines_cut_by_an_event_that_waited_complete_no_look),
        cmocka_unit_test(a_conflict_spoils_the_look_of_its_eye),
        cmocka_unit_test(a_datagram_that_was_dropped_spoils_both_looks),
        cmocka_unit_test(
            what_is_dropped_during_a_round_spoils_the_lines_behind),
        cmocka_unit_test(what_is_dropped_at_a_rounds_end_is_seen_by_that_round),
        cmocka_unit_test(
            an_event_that_waits_spoils_both_looks_and_costs_no_packet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
