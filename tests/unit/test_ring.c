#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/ring.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#define ITEM_MAX 1500u

static struct ring *new_ring(size_t size)
{
    struct ring *ring = ring_new(size);
    assert_non_null(ring);
    return ring;
}

/* Bytes that tell the number of their item. */
static void fill(uint8_t *bytes, size_t len, uint64_t number)
{
    memset(bytes, (int)(number % 251u), len);
    memcpy(bytes, &number, sizeof number);
}

static size_t length_of(uint64_t number)
{
    return sizeof number + (size_t)(number * 7919u % (ITEM_MAX - 8u));
}

static bool put(struct ring *ring, uint64_t number)
{
    uint8_t bytes[ITEM_MAX];
    const size_t len = length_of(number);
    fill(bytes, len, number);
    return ring_put(ring, &(struct ring_item){.bytes = bytes,
                                              .len = len,
                                              .time_ns = (int64_t)number,
                                              .is_cut_short = number % 3 == 0});
}

/* Whether an item is whole; which it is comes out. */
static bool is_whole(const struct ring_item *item, uint64_t *number)
{
    uint8_t want[ITEM_MAX];
    if (item->len < sizeof *number || item->len > sizeof want) {
        return false;
    }
    memcpy(number, item->bytes, sizeof *number);
    fill(want, item->len, *number);
    return item->len == length_of(*number) &&
           item->time_ns == (int64_t)*number &&
           item->is_cut_short == (*number % 3 == 0) &&
           memcmp(item->bytes, want, item->len) == 0;
}

static uint64_t expect_next(struct ring *ring)
{
    struct ring_item item;
    uint64_t number = 0;
    assert_true(ring_next(ring, &item));
    assert_true(is_whole(&item, &number));
    return number;
}

static void expect_none(struct ring *ring)
{
    struct ring_item item;
    assert_false(ring_next(ring, &item));
}

static void items_come_out_as_they_went_in(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    (void)state;
    for (uint64_t i = 0; i < 20; i++) {
        assert_true(put(ring, i));
    }
    ring_publish(ring);
    assert_true(ring_take(ring));
    for (uint64_t i = 0; i < 20; i++) {
        assert_int_equal(expect_next(ring), i);
    }
    expect_none(ring);
    ring_free(ring);
}

static void an_empty_item_is_an_item(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    struct ring_item item = {.time_ns = -5};
    (void)state;
    assert_true(ring_put(ring, &item));
    ring_publish(ring);
    assert_true(ring_take(ring));
    assert_true(ring_next(ring, &item));
    assert_int_equal(item.len, 0);
    assert_int_equal(item.time_ns, -5);
    expect_none(ring);
    ring_free(ring);
}

static void what_was_not_published_is_not_seen(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    (void)state;
    assert_true(put(ring, 1));
    ring_wake(ring);
    assert_true(ring_take(ring));
    expect_none(ring);
    assert_int_equal(ring_level(ring), 0);
    ring_publish(ring);
    assert_true(ring_level(ring) > 0);
    assert_true(ring_take(ring));
    assert_int_equal(expect_next(ring), 1);
    ring_free(ring);
}

static void a_full_ring_refuses_and_keeps_what_it_has(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    uint64_t n = 0;
    (void)state;
    while (put(ring, n)) {
        n++;
        ring_publish(ring);
    }
    assert_true(n > 50);
    assert_true(ring_level(ring) <= ring_size(ring));
    assert_true(ring_level(ring) > ring_size(ring) - 2 * ITEM_MAX);
    assert_true(ring_take(ring));
    for (uint64_t i = 0; i < n; i++) {
        assert_int_equal(expect_next(ring), i);
    }
    expect_none(ring);
    ring_free(ring);
}

static void what_is_being_read_is_not_overwritten(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    uint64_t n = 0;
    (void)state;
    while (put(ring, n)) {
        n++;
    }
    ring_publish(ring);
    assert_true(ring_take(ring));
    assert_false(put(ring, 1000));
    ring_publish(ring);
    assert_int_equal(expect_next(ring), 0);
    for (uint64_t i = 1; i < n; i++) {
        assert_int_equal(expect_next(ring), i);
    }
    ring_wake(ring);
    assert_true(ring_take(ring));
    assert_true(put(ring, 1000));
    ring_free(ring);
}

/* Batches of every size, so that the wrap falls everywhere. */
static void many_rounds_lose_nothing(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    uint64_t given = 0;
    uint64_t taken = 0;
    (void)state;
    for (unsigned round = 0; round < 5000; round++) {
        for (unsigned i = 0; i < round % 70u; i++) {
            given += put(ring, given) ? 1u : 0u;
        }
        ring_publish(ring);
        if (round % 3u == 2u) {
            continue;
        }
        ring_wake(ring);
        assert_true(ring_take(ring));
        for (; taken < given; taken++) {
            assert_int_equal(expect_next(ring), taken);
        }
        expect_none(ring);
    }
    ring_free(ring);
}

static void an_emptied_ring_begins_at_its_first_byte_again(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    struct ring_item first;
    struct ring_item item;
    (void)state;
    assert_true(put(ring, 1));
    ring_publish(ring);
    assert_true(ring_take(ring));
    assert_true(ring_next(ring, &first));
    ring_wake(ring);
    assert_true(ring_take(ring));
    assert_true(put(ring, 2));
    ring_publish(ring);
    assert_true(ring_take(ring));
    assert_true(ring_level(ring) < 2 * ITEM_MAX);
    assert_true(ring_next(ring, &item));
    assert_ptr_equal(item.bytes, first.bytes);
    ring_free(ring);
}

static void a_closed_ring_gives_what_it_has_and_ends(void **state)
{
    struct ring *ring = new_ring(RING_BYTES_MIN);
    (void)state;
    assert_true(put(ring, 7));
    ring_publish(ring);
    ring_close(ring);
    assert_true(ring_take(ring));
    assert_int_equal(expect_next(ring), 7);
    assert_false(ring_take(ring));
    ring_free(ring);
}

#define NUMBERS 200000u

struct taker {
    struct ring *ring;
    uint64_t count;
    uint64_t last;
    bool is_fine;
};

static void *take_all(void *argument)
{
    struct taker *taker = argument;
    struct ring_item item;
    while (ring_take(taker->ring)) {
        while (ring_next(taker->ring, &item)) {
            uint64_t number = 0;
            taker->is_fine = taker->is_fine && is_whole(&item, &number) &&
                             (taker->count == 0 || number > taker->last);
            taker->last = number;
            taker->count++;
        }
    }
    return NULL;
}

static void two_threads_lose_only_what_was_refused(void **state)
{
    struct taker taker = {.ring = new_ring(RING_BYTES_MIN), .is_fine = true};
    pthread_t thread;
    uint64_t refused = 0;
    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, take_all, &taker), 0);
    for (uint64_t i = 0; i < NUMBERS; i++) {
        const bool is_in = put(taker.ring, i);
        refused += is_in ? 0u : 1u;
        if (!is_in || i % 17u == 0) {
            ring_publish(taker.ring);
        }
        if (!is_in) {
            (void)sched_yield();
        }
        if (i % 1000u == 0) {
            ring_wake(taker.ring);
        }
    }
    ring_publish(taker.ring);
    ring_close(taker.ring);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_true(taker.is_fine);
    assert_int_equal(taker.count + refused, NUMBERS);
    ring_free(taker.ring);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(items_come_out_as_they_went_in),
        cmocka_unit_test(an_empty_item_is_an_item),
        cmocka_unit_test(what_was_not_published_is_not_seen),
        cmocka_unit_test(a_full_ring_refuses_and_keeps_what_it_has),
        cmocka_unit_test(what_is_being_read_is_not_overwritten),
        cmocka_unit_test(many_rounds_lose_nothing),
        cmocka_unit_test(an_emptied_ring_begins_at_its_first_byte_again),
        cmocka_unit_test(a_closed_ring_gives_what_it_has_and_ends),
        cmocka_unit_test(two_threads_lose_only_what_was_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
