#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"

#include <string.h>

static void break_zone(struct rig *r, unsigned i)
{
    zone *const z = &r->config.zone;
    if (i < 3) {
        z->min[i] = z->max[i] + 1;
    } else if (i == 3) {
        z->range = -1;
    } else {
        z->right = z->left + 1;
    }
}

static void break_times(struct rig *r, unsigned i)
{
    if (i == 0) {
        r->config.frame_ms = 0;
    } else if (i == 1) { /* two frames and no open lines */
        r->config.hold_ms = 2u * FRAME + GATEWAY_OPEN_LINES * STEP;
    } else if (i == 2) {
        r->config.hold_ms = 0;
    } else if (i == 3) {
        r->config.silence_ms = FRAME;
    } else if (i == 4) {
        r->config.silence_ms = AGE_MAX_MS + 1u;
    } else {
        r->config.lines = 0;
    }
}

static void break_config(struct rig *r, unsigned i)
{
    if (i == 0) {
        r->config.hits = 0;
    } else if (i < 3) {
        r->config.eyes = i == 1 ? 0 : BOTH + 1u;
    } else if (i == 3) {
        r->output.send = NULL;
    } else if (i < 6) {
        r->layout.profile.group[LUM_FIELD_TIMESTAMP].bytes =
            (uint8_t)(i == 4 ? 0 : 2);
    } else if (i < 8) {
        r->layout.profile.group[LUM_FIELD_TIMESTAMP].bits =
            (uint8_t)(i == 6 ? 31 : 1);
    } else if (i == 8) {
        r->layout.profile.clock_unit_ns = 100;
    } else {
        r->calibration.tof_lsb_fs = 0;
    }
}

static void times_may_be_as_short_as_two_frames_allow(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.hits = 1;
    r->config.lines = 1;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.lines = LINES;
    r->config.hold_ms = 2u * FRAME + GATEWAY_OPEN_LINES * STEP + 1u;
    r->config.silence_ms = FRAME + 1u;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.lines = UINT32_MAX; /* 2 x UINT32_MAX + 2 by 1 is just below */
    r->config.frame_ms = 1;
    r->config.hold_ms = 2;
    assert_int_equal(rig_init(r), LUM_E_VALUE);
    r->config.hold_ms = 3;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.hold_ms = UINT32_MAX;
    r->config.silence_ms = AGE_MAX_MS;
    r->config.frame_ms = AGE_MAX_MS - 1u;
    assert_int_equal(rig_init(r), LUM_OK);
    rig_free(r);
}

/* It is used as if nobody had looked at the result. */
static void expect_dead(struct rig *r)
{
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    for (unsigned i = 0; i < 600; i++) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
        gateway_datagram(&r->gateway, (const uint8_t *)"", 0, r->now);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
        assert_false(gateway_may_kick(&r->gateway));
        assert_int_equal(reasons(r), GATEWAY_SILENT);
    }
    gateway_finish(&r->gateway);
    assert_int_equal(r->sent_count, 0);
}

static void a_gateway_that_was_not_begun_stops(void **state)
{
    struct rig *const r = rig_new(); /* its memory is no zeros */
    (void)state;
    expect_dead(r);
    memset(&r->gateway, 0, sizeof r->gateway);
    expect_dead(r);
    rig_free(r);
}

static void a_zone_may_be_a_point(void **state)
{
    struct rig *const r = rig_new();
    zone *const z = &r->config.zone;
    (void)state;
    memcpy(z->min, z->max, sizeof z->min);
    z->left = 5;
    z->right = 5; /* of a box, they do not matter */
    assert_int_equal(rig_init(r), LUM_OK);
    rig_free(r);
}

static void a_configuration_out_of_range_is_refused_and_stops(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 21; i++) {
        struct rig *const r = rig_new();
        assert_int_equal(rig_init(r), LUM_OK);
        if (i < 5) {
            break_zone(r, i);
        } else if (i < 11) {
            break_times(r, i - 5u);
        } else {
            break_config(r, i - 11u);
        }
        assert_int_equal(rig_init(r), LUM_E_VALUE);
        expect_dead(r);
        rig_free(r);
    }
}

static void a_clock_may_be_32_bits_of_a_wider_field(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->layout.profile.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){24, 8, LUM_ORDER_BIG, 3, 32};
    r->layout.profile.samples_at = 32;
    assert_int_equal(rig_init(r), LUM_OK);
    rig_free(r);
}

/* The state with which a gateway begins, with any content of its memory. */
static void a_gateway_begins_with_nothing_seen(void **state)
{
    struct rig *const r = rig_at(77);
    const gateway *const g = &r->gateway;
    (void)state;
    assert_int_equal(g->reasons, GATEWAY_SILENT);
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        assert_int_equal(g->frames[i].sight.hits, 0);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_true(g->looks[eye].point_ms < -(INT64_C(1) << 60));
        assert_true(g->looks[eye].whole_ms < -(INT64_C(1) << 60));
    }
    assert_int_equal(g->assembler.config.open_lines, GATEWAY_OPEN_LINES);
    assert_int_equal(g->assembler.config.reorder_lines, GATEWAY_REORDER_LINES);
    assert_int_equal(g->assembler.config.words_per_line, GATEWAY_LINE_WORDS);
    assert_int_equal(g->assembler.config.gap_us, SILENCE * 1000u);
    rig_free(r);
}

static void the_first_stop_is_of_blindness_and_no_object(void **state)
{
    struct rig *const r = rig_at(77);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    assert_int_equal(r->gateway.heart.lasts_ms, SILENCE);
    rig_free(r);
}

static void one_line_and_one_hit_are_enough_to_ask_for(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.hits = 1;
    r->config.lines = 1;
    r->config.hold_ms = 5u * FRAME;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.zone.range = 10;
    r->config.zone.left = 3;
    r->config.zone.right = 5;
    assert_int_equal(rig_init(r), LUM_E_VALUE);
    rig_free(r);
}

/* A fresh packet is not a stray, after any silence. */
static void the_gap_of_the_clock_is_no_less_than_the_silence(void **state)
{
    static const struct {
        uint32_t silence_ms, gap_us;
    } rows[] = {{60, 100000},
                {100, 100000},
                {101, 101000},
                {AGE_MAX_MS, AGE_MAX_MS * 1000u}};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct rig *const r = rig_new();
        r->config.frame_ms = 50;
        r->config.silence_ms = rows[i].silence_ms;
        assert_int_equal(rig_init(r), LUM_OK);
        assert_int_equal(r->gateway.assembler.config.gap_us, rows[i].gap_us);
        rig_free(r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(times_may_be_as_short_as_two_frames_allow),
        cmocka_unit_test(a_gateway_that_was_not_begun_stops),
        cmocka_unit_test(a_zone_may_be_a_point),
        cmocka_unit_test(a_configuration_out_of_range_is_refused_and_stops),
        cmocka_unit_test(a_clock_may_be_32_bits_of_a_wider_field),
        cmocka_unit_test(a_gateway_begins_with_nothing_seen),
        cmocka_unit_test(the_first_stop_is_of_blindness_and_no_object),
        cmocka_unit_test(one_line_and_one_hit_are_enough_to_ask_for),
        cmocka_unit_test(the_gap_of_the_clock_is_no_less_than_the_silence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
