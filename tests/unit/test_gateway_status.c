#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"

#include "lum/laser.h"
#include "lum/wire.h"

static void tell_status(struct rig *r, uint16_t type, uint16_t status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now), LUM_OK);
    assert_int_equal(lum_tlv_add(&w, 3, "text", 4), LUM_OK);
    assert_int_equal(lum_tlv_add_u16(&w, type, status), LUM_OK);
    assert_true(receive(r, packet, w.len));
    (void)gateway_receive(&r->gateway, r->now);
}

static void every_bit_that_takes_the_laser_down_stops(void **state)
{
    struct rig *const r = rig_going(0);
    const uint16_t type = r->layout.profile.tlv[LUM_TLV_STATUS];
    (void)state;
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const uint16_t status = (uint16_t)(1u << bit);
        tell_status(r, type, status);
        assert_int_equal(
            reasons(r), (status & LUM_LASER_ALL_DOWN) != 0 ? GATEWAY_LASER : 0);
        pass(r, 2000, BOTH);
        assert_int_equal(
            reasons(r), (status & LUM_LASER_ALL_DOWN) != 0 ? GATEWAY_LASER : 0);
        tell_status(r, type, LUM_LASER_TLV_CMD_ON);
        pass(r, HOLD, BOTH);
        assert_int_equal(reasons(r), 0);
    }
    rig_free(r);
}

static void all_reasons_can_stand_together(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    hang(r, 2000);
    (void)gateway_receive(&r->gateway, r->now);
    for (unsigned i = 0; i < 2u + GATEWAY_OPEN_LINES; i++) {
        show(r, BLUE, NEAR_TOF, HITS); /* the first proves a jump */
    }
    tell_status(r, r->layout.profile.tlv[LUM_TLV_STATUS],
                LUM_LASER_FAN_PWM_BAD);
    hang(r, 30);
    assert_int_equal(reasons(r), GATEWAY_OBJECT | GATEWAY_SILENT |
                                     GATEWAY_LASER | GATEWAY_STALLED);
    rig_free(r);
}

static void add_status(struct rig *r, lum_tlv_writer *w, uint16_t status)
{
    assert_int_equal(
        lum_tlv_add_u16(w, r->layout.profile.tlv[LUM_TLV_STATUS], status),
        LUM_OK);
}

static void a_hazard_beside_a_clean_status_of_its_packet_stops(void **state)
{
    (void)state;
    for (unsigned first = 0; first < 2; first++) {
        struct rig *const r = rig_going(0);
        uint8_t packet[64];
        lum_tlv_writer w;
        assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, 1), LUM_OK);
        add_status(r, &w, first == 0 ? LUM_LASER_FAN_PWM_BAD : 0);
        add_status(r, &w, first == 0 ? 0 : LUM_LASER_FAN_PWM_BAD);
        assert_true(receive(r, packet, w.len));
        pass(r, 2000, BOTH);
        assert_int_equal(reasons(r), GATEWAY_LASER);
        rig_free(r);
    }
}

static void a_hazard_that_ends_before_the_round_does_stops(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        uint8_t packet[64];
        lum_tlv_writer w;
        assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now),
                         LUM_OK);
        add_status(r, &w, i == 0 ? LUM_LASER_FAN_PWM_BAD : 0);
        assert_true(receive(r, packet, w.len));
    }
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_LASER);
    pass(r, HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void what_is_no_status_changes_nothing(void **state)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    struct rig *const r = rig_going(0);
    const uint16_t type = r->layout.profile.tlv[LUM_TLV_STATUS];
    (void)state;
    tell_status(r, (uint16_t)(type + 1u), LUM_LASER_FAN_PWM_BAD);
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, 1), LUM_OK);
    assert_int_equal(lum_tlv_add(&w, type, "\x40", 1), LUM_OK);
    assert_true(receive(r, packet, w.len));
    assert_int_equal(lum_tlv_add_u16(&w, type, LUM_LASER_FAN_PWM_BAD), LUM_OK);
    assert_true(receive(r, packet, w.len - 1u)); /* its status is cut */
    assert_true(receive(r, packet, LUM_TLV_PACKET_BYTES - 1u));
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), 0);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_TLV], 3);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_MALFORMED], 1);
    rig_free(r);
}

static void tell_as(struct rig *r, uint32_t sequence, uint16_t status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                     LUM_OK);
    add_status(r, &w, status);
    assert_true(receive(r, packet, w.len));
    (void)gateway_receive(&r->gateway, r->now);
}

/* An alert is believed. Only an answer to a recent poll, whose sequence number
 * is the time, can show that all is well. */
static void an_old_status_says_nothing_good(void **state)
{
    struct rig *const r = rig_going(0);
    uint8_t packet[64];
    lum_tlv_writer w;
    (void)state;
    tell_as(r, r->now - 100000u, LUM_LASER_FAN_PWM_BAD);
    assert_int_equal(reasons(r), GATEWAY_LASER);
    for (unsigned i = 0; i < 3; i++) {
        if (i < 2) {
            tell_as(r, i == 0 ? r->now - SILENCE : r->now + 1u, 0);
        } else {
            assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now),
                             LUM_OK);
            assert_true(receive(r, packet, w.len)); /* no status */
        }
        pass(r, HOLD + STEP, BOTH);
        assert_int_equal(reasons(r), GATEWAY_LASER);
    }
    tell_as(r, r->now - SILENCE + 1u, 0);
    pass(r, HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_bit_that_takes_the_laser_down_stops),
        cmocka_unit_test(all_reasons_can_stand_together),
        cmocka_unit_test(a_hazard_beside_a_clean_status_of_its_packet_stops),
        cmocka_unit_test(a_hazard_that_ends_before_the_round_does_stops),
        cmocka_unit_test(what_is_no_status_changes_nothing),
        cmocka_unit_test(an_old_status_says_nothing_good),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
