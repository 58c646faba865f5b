#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "ring.h"

#include <string.h>

static ring r;

static ring_slot *commit(uint8_t mark)
{
    ring_slot *slot = ring_claim(&r);
    assert_non_null(slot);
    slot->bytes[0] = mark;
    slot->len = 1;
    ring_commit(&r);
    return slot;
}

static uint8_t take(void)
{
    const ring_slot *slot = ring_front(&r);
    assert_non_null(slot);
    const uint8_t mark = slot->bytes[0];
    ring_release(&r);
    return mark;
}

static void begin(void)
{
    memset(&r, 0xa5, sizeof r);
    ring_init(&r);
}

static void a_ring_begins_empty_whatever_was_there(void **state)
{
    (void)state;
    begin();
    assert_null(ring_front(&r));
    assert_int_equal(ring_dropped(&r), 0);
}

static void datagrams_come_out_in_order(void **state)
{
    (void)state;
    begin();
    for (unsigned i = 0; i < 3 * RING_SLOTS; i++) {
        commit((uint8_t)i);
        commit((uint8_t)(i + 100u));
        assert_int_equal(take(), i);
        assert_int_equal(take(), i + 100u);
        assert_null(ring_front(&r));
    }
}

static void a_full_ring_drops_and_counts(void **state)
{
    (void)state;
    begin();
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        commit((uint8_t)i);
    }
    for (unsigned i = 1; i < 4; i++) {
        assert_null(ring_claim(&r));
        assert_int_equal(ring_dropped(&r), i);
    }
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        assert_int_equal(take(), i);
    }
    assert_null(ring_front(&r));
    commit(7);
    assert_int_equal(take(), 7);
    assert_int_equal(ring_dropped(&r), 3);
}

static void a_claimed_slot_is_none_until_it_is_committed(void **state)
{
    (void)state;
    begin();
    ring_slot *slot = ring_claim(&r);
    assert_non_null(slot);
    assert_int_equal(slot->begin, 0);
    assert_null(ring_front(&r));
    slot->begin = 42;
    assert_ptr_equal(ring_claim(&r), slot);
    assert_int_equal(slot->begin, 0);
    ring_commit(&r);
    assert_ptr_equal(ring_front(&r), slot);
    assert_ptr_not_equal(ring_claim(&r), slot);
}

/* The counts go on beyond 2^32. */
static void the_counts_wrap_without_harm(void **state)
{
    (void)state;
    begin();
    r.committed = r.released = UINT32_MAX - RING_SLOTS / 2u;
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        commit((uint8_t)i);
    }
    assert_null(ring_claim(&r));
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        assert_int_equal(take(), i);
    }
    assert_null(ring_front(&r));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ring_begins_empty_whatever_was_there),
        cmocka_unit_test(datagrams_come_out_in_order),
        cmocka_unit_test(a_full_ring_drops_and_counts),
        cmocka_unit_test(a_claimed_slot_is_none_until_it_is_committed),
        cmocka_unit_test(the_counts_wrap_without_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
