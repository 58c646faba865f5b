#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"
#include "support.h"

#include "lum/wire.h"

#include <string.h>

static void a_driver_without_a_ring_hands_over_datagrams(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 4u * HOLD / STEP; i++) {
        const ring_slot *slot;
        r->now += STEP;
        gateway_tick(&r->gateway, r->now);
        tell_clock(r, r->now, sensor_clock(r));
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            put_angles(r, eye);
            put(r, eye, LUM_TAG_RANGES, FAR_TOF, true, 0, 1);
            while ((slot = ring_front(&r->gateway.ring)) != NULL) {
                gateway_datagram(&r->gateway, slot->bytes, slot->len, r->now);
                ring_release(&r->gateway.ring);
            }
        }
        next_line(r);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
    }
    assert_int_equal(reasons(r), 0);
    r->now += SILENCE; /* time goes on with a datagram too */
    gateway_datagram(&r->gateway, (const uint8_t *)"", 0, r->now);
    assert_int_equal(r->gateway.now_ms, r->now);
    rig_free(r);
}

/* Else a flood would keep it from deciding. */
static void a_round_takes_as_many_datagrams_as_there_are_slots(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    r->gateway.ring.committed += RING_SLOTS + 3u; /* meanwhile, as it were */
    assert_int_equal(gateway_receive(&r->gateway, 0), RING_SLOTS);
    assert_int_equal(gateway_receive(&r->gateway, 0), 3);
    rig_free(r);
}

/* By the driver, from what the network says. */
static void a_slot_with_impossible_lengths_is_malformed(void **state)
{
    static const struct {
        uint32_t begin, len;
        bool is_bad;
    } rows[] = {
        {0, RING_SLOT_BYTES, false},
        {0, RING_SLOT_BYTES + 1u, true},
        {42, RING_SLOT_BYTES - 42u, false},
        {42, RING_SLOT_BYTES - 41u, true},
        {RING_SLOT_BYTES, 0, false},
        {RING_SLOT_BYTES + 1u, 0, true},
        {UINT32_MAX, 2, true},
        {2, UINT32_MAX, true},
    };
    struct rig *const r = rig_at(0);
    uint32_t bad = 0;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ring_slot *const slot = ring_claim(&r->gateway.ring);
        memset(slot->bytes, 0, sizeof slot->bytes);
        slot->begin = rows[i].begin;
        slot->len = rows[i].len;
        ring_commit(&r->gateway.ring);
        assert_int_equal(gateway_receive(&r->gateway, 0), 1);
        bad += rows[i].is_bad;
        assert_int_equal(r->gateway.kinds[LUM_PACKET_MALFORMED], bad);
    }
    rig_free(r);
}

static void garbage_is_counted_and_is_no_sign_of_life(void **state)
{
    struct rig *const r = rig_going(0);
    uint64_t seed = 5;
    uint8_t bytes[RING_SLOT_BYTES];
    uint32_t counted = 0;
    (void)state;
    memset(r->gateway.kinds, 0, sizeof r->gateway.kinds);
    for (unsigned i = 0; i < 4000; i++) {
        const size_t len = next_random(&seed) % sizeof bytes;
        for (size_t k = 0; k < sizeof bytes; k++) {
            bytes[k] = (uint8_t)next_random(&seed);
        }
        if (i % 2u == 0) { /* so that it is looked at further */
            lum_header_encode(bytes, (uint8_t)(5u + i / 2u % 4u));
        }
        assert_true(receive(r, bytes, len));
        r->now++;
        (void)gateway_receive(&r->gateway, r->now);
    }
    for (unsigned kind = 0; kind < LUM_PACKET_KINDS; kind++) {
        counted += r->gateway.kinds[kind];
    }
    assert_int_equal(counted, 4000);
    assert_true((reasons(r) & GATEWAY_SILENT) != 0);
    rig_free(r);
}

static void a_full_ring_drops_and_counts(void **state)
{
    static const uint8_t byte[1] = {0};
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        assert_true(receive(r, byte, 1));
    }
    assert_int_equal(ring_dropped(&r->gateway.ring), 0);
    assert_false(receive(r, byte, 1));
    assert_false(receive(r, byte, 1));
    assert_int_equal(ring_dropped(&r->gateway.ring), 2);
    assert_int_equal(gateway_receive(&r->gateway, 0), RING_SLOTS);
    assert_int_equal(gateway_receive(&r->gateway, 0), 0);
    assert_true(receive(r, byte, 1));
    assert_int_equal(ring_dropped(&r->gateway.ring), 2);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_FOREIGN], RING_SLOTS);
    rig_free(r);
}

/* Behind the headers of a frame, as a bare MAC writes it. */
static void a_datagram_may_begin_within_its_slot(void **state)
{
    struct rig *const r = rig_at(0);
    ring_slot *slot;
    (void)state;
    for (uint32_t begin = 0; begin <= 46; begin += 23) {
        slot = ring_claim(&r->gateway.ring);
        assert_non_null(slot);
        assert_int_equal(slot->begin, 0);
        memset(slot->bytes, 0, sizeof slot->bytes);
        lum_heartbeat_encode(slot->bytes + begin);
        slot->begin = begin;
        slot->len = LUM_HEARTBEAT_BYTES;
        ring_commit(&r->gateway.ring);
    }
    assert_int_equal(gateway_receive(&r->gateway, 0), 3);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_FOREIGN], 0);
    for (unsigned i = 0; i < RING_SLOTS; i++) { /* nor does it stay */
        assert_int_equal(ring_claim(&r->gateway.ring)->begin, 0);
        ring_commit(&r->gateway.ring);
    }
    rig_free(r);
}

/* A cache line that the driver invalidates holds nothing but its bytes. */
static void bytes_of_slots_fill_lines_of_a_cache(void **state)
{
    struct rig *const r = rig_at(0);
    const ring *const ring_ = &r->gateway.ring;
    (void)state;
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        const uint8_t *const bytes = ring_->slots[i].bytes;
        assert_int_equal((uintptr_t)bytes % RING_LINE_BYTES, 0);
        assert_int_equal(sizeof ring_->slots[i].bytes % RING_LINE_BYTES, 0);
    }
    rig_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_driver_without_a_ring_hands_over_datagrams),
        cmocka_unit_test(a_round_takes_as_many_datagrams_as_there_are_slots),
        cmocka_unit_test(a_slot_with_impossible_lengths_is_malformed),
        cmocka_unit_test(garbage_is_counted_and_is_no_sign_of_life),
        cmocka_unit_test(a_full_ring_drops_and_counts),
        cmocka_unit_test(a_datagram_may_begin_within_its_slot),
        cmocka_unit_test(bytes_of_slots_fill_lines_of_a_cache),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
