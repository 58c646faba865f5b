#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/fragments.h"

#include <stdlib.h>
#include <string.h>

#define PART    16u            /* bytes of each part */
#define PARTS   3u             /* of the datagram in most tests */
#define WHOLE   (PART * PARTS) /* its bytes, UDP header included */
#define LARGEST (65535u - 20u) /* that IPv4 can carry */

typedef struct fixture {
    lum_fragments *fragments;
    lum_record record;
    uint8_t udp[LARGEST];
} fixture;

static void set_udp_len(fixture *f, size_t len)
{
    f->udp[4] = (uint8_t)(len >> 8);
    f->udp[5] = (uint8_t)len;
}

static int begin(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->fragments = lum_fragments_new();
    assert_non_null(f->fragments);
    for (size_t i = 0; i < sizeof f->udp; i++) {
        f->udp[i] = (uint8_t)(i * 7u + i / 256u);
    }
    f->udp[0] = 0x15;
    f->udp[1] = 0x8d;
    set_udp_len(f, WHOLE);
    f->record.source = 1;
    f->record.destination = 2;
    *state = f;
    return 0;
}

static int end(void **state)
{
    fixture *f = *state;
    lum_fragments_free(f->fragments);
    free(f);
    return 0;
}

static lum_record_kind add(fixture *f, uint16_t id, uint32_t from, size_t len,
                           bool more)
{
    uint8_t *exact = malloc(len);
    assert_non_null(exact);
    memcpy(exact, f->udp + from, len);
    const lum_fragment fragment = {{exact, len}, from, id, more};
    f->record.dropped_fragments = 0;
    lum_fragments_add(f->fragments, &fragment, &f->record);
    free(exact);
    return f->record.kind;
}

static lum_record_kind add_part(fixture *f, uint16_t id, uint32_t part)
{
    return add(f, id, part * PART, PART, part + 1u < PARTS);
}

static void expect_whole(const fixture *f, size_t len)
{
    assert_int_equal(f->record.kind, LUM_RECORD_DATAGRAM);
    assert_int_equal(f->record.source_port, 5517);
    assert_int_equal(f->record.len, len - 8u);
    assert_memory_equal(f->record.payload, f->udp + 8, len - 8u);
}

static void every_order_gives_the_datagram(void **state)
{
    static const uint8_t orders[6][PARTS] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                             {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    fixture *f = *state;
    for (uint16_t id = 0; id < 6; id++) {
        assert_int_equal(add_part(f, id, orders[id][0]), LUM_RECORD_FRAGMENT);
        assert_int_equal(add_part(f, id, orders[id][1]), LUM_RECORD_FRAGMENT);
        assert_int_equal(add_part(f, id, orders[id][2]), LUM_RECORD_DATAGRAM);
        assert_int_equal(f->record.dropped_fragments, 0);
        expect_whole(f, WHOLE);
    }
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
}

static void hosts_and_ids_do_not_mix(void **state)
{
    fixture *f = *state;
    static const struct {
        uint32_t source, destination;
        uint16_t id;
    } keys[] = {{1, 2, 5}, {3, 2, 5}, {1, 3, 5}, {1, 2, 6}};
    for (uint32_t part = 0; part < PARTS; part++) {
        for (size_t k = 0; k < 4; k++) {
            f->record.source = keys[k].source;
            f->record.destination = keys[k].destination;
            assert_int_equal(add_part(f, keys[k].id, part),
                             part + 1u < PARTS ? LUM_RECORD_FRAGMENT
                                               : LUM_RECORD_DATAGRAM);
            assert_int_equal(f->record.dropped_fragments, 0);
        }
    }
}

static void a_repeat_is_ignored(void **state)
{
    fixture *f = *state;
    (void)add_part(f, 5, 1);
    assert_int_equal(add_part(f, 5, 1), LUM_RECORD_FRAGMENT);
    (void)add_part(f, 5, 0);
    /* cut in another way */
    assert_int_equal(add(f, 5, 8, 16, true), LUM_RECORD_FRAGMENT);
    assert_int_equal(add_part(f, 5, 2), LUM_RECORD_DATAGRAM);
    expect_whole(f, WHOLE);
    assert_int_equal(f->record.dropped_fragments, 0);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
}

static void a_repeat_of_what_is_complete_is_ignored(void **state)
{
    fixture *f = *state;
    for (uint16_t id = 0; id < 2u * LUM_FRAGMENTS_DATAGRAMS; id++) {
        for (uint32_t part = 0; part < 2u * PARTS; part++) {
            assert_int_equal(add_part(f, id, part % PARTS),
                             part + 1u == PARTS ? LUM_RECORD_DATAGRAM
                                                : LUM_RECORD_FRAGMENT);
            assert_int_equal(f->record.dropped_fragments, 0);
        }
    }
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
    f->record.time_ns = LUM_FRAGMENTS_WAIT_NS;
    assert_int_equal(add_part(f, LUM_FRAGMENTS_DATAGRAMS, 2),
                     LUM_RECORD_FRAGMENT);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
    /* no longer known: too many came after it, or it is too long ago */
    assert_int_equal(add_part(f, LUM_FRAGMENTS_DATAGRAMS - 1u, 2),
                     LUM_RECORD_FRAGMENT);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 1);
    f->record.time_ns++;
    (void)add_part(f, 2u * LUM_FRAGMENTS_DATAGRAMS - 1u, 2);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 1);
}

static void what_waits_has_room_before_what_is_complete(void **state)
{
    fixture *f = *state;
    for (uint16_t id = 0; id < 2u * LUM_FRAGMENTS_DATAGRAMS; id++) {
        (void)add_part(f, id, 0);
        (void)add_part(f, id, 1);
        if (id < LUM_FRAGMENTS_DATAGRAMS) {
            assert_int_equal(add_part(f, id, 2), LUM_RECORD_DATAGRAM);
        }
        assert_int_equal(f->record.dropped_fragments, 0);
    }
    for (uint16_t id = LUM_FRAGMENTS_DATAGRAMS;
         id < 2u * LUM_FRAGMENTS_DATAGRAMS; id++) {
        assert_int_equal(add_part(f, id, 2), LUM_RECORD_DATAGRAM);
        expect_whole(f, WHOLE);
    }
}

static void other_bytes_begin_another_datagram(void **state)
{
    fixture *f = *state;
    for (uint8_t of = 0; of < 3; of++) {
        /* its end is that of the one before */
        f->udp[8] = of;
        (void)add_part(f, 5, 0);
        (void)add_part(f, 5, 1);
        assert_int_equal(add_part(f, 5, 2), LUM_RECORD_DATAGRAM);
        expect_whole(f, WHOLE);
    }
}

static void a_repeat_that_differs_discards_all(void **state)
{
    fixture *f = *state;
    for (uint32_t at = 0; at < 2u * PART; at++) {
        (void)add_part(f, 5, 0);
        (void)add_part(f, 5, 1);
        f->udp[at] ^= 1u;
        assert_int_equal(add_part(f, 5, at / PART), LUM_RECORD_OTHER);
        f->udp[at] ^= 1u;
        assert_int_equal(f->record.dropped_fragments, 2);
        assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
    }
    /* as does one that holds more than is there, or is an end */
    (void)add_part(f, 5, 0);
    assert_int_equal(add(f, 5, 0, PART + 8u, true), LUM_RECORD_OTHER);
    (void)add_part(f, 5, 0);
    assert_int_equal(add(f, 5, 0, PART, false), LUM_RECORD_OTHER);
    (void)add_part(f, 5, 2);
    assert_int_equal(add(f, 5, 2u * PART, PART, true), LUM_RECORD_OTHER);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
}

static void an_overlap_by_one_unit_discards_all(void **state)
{
    fixture *f = *state;
    (void)add(f, 5, 0, 24, true);
    assert_int_equal(add(f, 5, 16, 16, true), LUM_RECORD_OTHER);
    assert_int_equal(f->record.dropped_fragments, 1);
    (void)add(f, 5, 16, 16, true);
    assert_int_equal(add(f, 5, 0, 24, true), LUM_RECORD_OTHER);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 0);
}

static void two_ends_discard_all(void **state)
{
    fixture *f = *state;
    (void)add(f, 5, 16, 4, false);
    assert_int_equal(add(f, 5, 32, 4, false), LUM_RECORD_OTHER);
    assert_int_equal(f->record.dropped_fragments, 1);
    (void)add(f, 5, 32, 4, false);
    assert_int_equal(add(f, 5, 16, 4, false), LUM_RECORD_OTHER);
    assert_int_equal(f->record.dropped_fragments, 1);
}

static void a_fragment_past_the_end_discards_all(void **state)
{
    fixture *f = *state;
    (void)add(f, 5, 16, 4, false);
    assert_int_equal(add(f, 5, 32, 8, true), LUM_RECORD_OTHER);
    assert_int_equal(f->record.dropped_fragments, 1);
    (void)add(f, 5, 32, 8, true);
    assert_int_equal(add(f, 5, 16, 4, false), LUM_RECORD_OTHER);
    assert_int_equal(f->record.dropped_fragments, 1);
}

static void fragments_wait_half_a_second_and_no_longer(void **state)
{
    fixture *f = *state;
    f->record.time_ns = 1000;
    (void)add_part(f, 5, 0);
    f->record.time_ns = 400000000; /* the first one's time counts */
    (void)add_part(f, 5, 1);
    (void)add_part(f, 6, 0);
    assert_int_equal(lum_fragments_expire(f->fragments, 500001000), 0);
    assert_int_equal(lum_fragments_expire(f->fragments, 500001001), 2);
    assert_int_equal(lum_fragments_expire(f->fragments, 900000000), 0);
    assert_int_equal(lum_fragments_expire(f->fragments, 900000001), 1);
}

static void time_that_runs_backwards_drops_nothing(void **state)
{
    fixture *f = *state;
    f->record.time_ns = INT64_C(4500000000) * 1000000000;
    (void)add_part(f, 5, 0);
    assert_int_equal(lum_fragments_expire(f->fragments, 0), 0);
    assert_int_equal(
        lum_fragments_expire(f->fragments, -INT64_C(4500000000) * 1000000000),
        0);
    assert_int_equal(lum_fragments_drop_all(f->fragments), 1);
}

static void one_datagram_too_many_drops_the_oldest(void **state)
{
    fixture *f = *state;
    for (uint16_t id = 0; id < LUM_FRAGMENTS_DATAGRAMS; id++) {
        assert_int_equal(add_part(f, id, 0), LUM_RECORD_FRAGMENT);
        assert_int_equal(add_part(f, id, 1), LUM_RECORD_FRAGMENT);
        assert_int_equal(f->record.dropped_fragments, 0);
    }
    assert_int_equal(add_part(f, 1000, 0), LUM_RECORD_FRAGMENT);
    assert_int_equal(f->record.dropped_fragments, 2);
    assert_int_equal(add_part(f, 1, 2), LUM_RECORD_DATAGRAM);
    assert_int_equal(add_part(f, 0, 2), LUM_RECORD_FRAGMENT);
    assert_int_equal(f->record.dropped_fragments, 0);
    assert_int_equal(add_part(f, 1001, 0), LUM_RECORD_FRAGMENT);
    assert_int_equal(f->record.dropped_fragments, 2);
    assert_int_equal(add_part(f, 2, 2), LUM_RECORD_FRAGMENT);
    assert_int_equal(add_part(f, 4, 2), LUM_RECORD_DATAGRAM);
    expect_whole(f, WHOLE);
}

static void the_largest_datagram_fits(void **state)
{
    fixture *f = *state;
    set_udp_len(f, LARGEST);
    for (uint32_t from = 8; from < LARGEST; from += 1480) {
        const size_t left = LARGEST - from;
        const size_t len = left < 1480 ? left : 1480;
        assert_int_equal(add(f, 5, from, len, len < left), LUM_RECORD_FRAGMENT);
    }
    assert_int_equal(add(f, 5, 0, 8, true), LUM_RECORD_DATAGRAM);
    expect_whole(f, LARGEST);
}

static void a_whole_with_an_impossible_udp_length_is_other(void **state)
{
    static const size_t lens[] = {0, 7, WHOLE + 1u};
    fixture *f = *state;
    for (size_t i = 0; i < 3; i++) {
        set_udp_len(f, lens[i]);
        (void)add_part(f, 5, 0);
        (void)add_part(f, 5, 1);
        assert_int_equal(add_part(f, 5, 2), LUM_RECORD_OTHER);
        assert_int_equal(f->record.dropped_fragments, 0);
    }
    (void)add(f, 5, 8, 1, false);
    set_udp_len(f, 8);
    assert_int_equal(add(f, 5, 0, 8, true), LUM_RECORD_DATAGRAM);
    assert_int_equal(f->record.len, 0);
}

/* Dropped, other, or a third of a datagram: nothing is lost or counted twice.
 */
static void every_fragment_is_counted_once(void **state)
{
    fixture *f = *state;
    uint32_t seed = 1;
    uint32_t taken = 0;
    uint32_t accounted = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        seed = seed * 1664525u + 1013904223u;
        const uint32_t part = (seed >> 8) % PARTS;
        f->record.time_ns += 1000000;
        memcpy(f->udp + part * PART + 8u, &i, sizeof i); /* no repeat */
        accounted += lum_fragments_expire(f->fragments, f->record.time_ns);
        const lum_record_kind kind =
            add_part(f, (uint16_t)((seed >> 16) % 100u), part);
        taken++;
        accounted += f->record.dropped_fragments;
        accounted += kind == LUM_RECORD_OTHER ? 1u : 0u;
        accounted += kind == LUM_RECORD_DATAGRAM ? PARTS : 0u;
    }
    accounted += lum_fragments_drop_all(f->fragments);
    assert_int_equal(accounted, taken);
}

#define FACT(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FACT(every_order_gives_the_datagram),
        FACT(hosts_and_ids_do_not_mix),
        FACT(a_repeat_is_ignored),
        FACT(a_repeat_of_what_is_complete_is_ignored),
        FACT(what_waits_has_room_before_what_is_complete),
        FACT(other_bytes_begin_another_datagram),
        FACT(a_repeat_that_differs_discards_all),
        FACT(an_overlap_by_one_unit_discards_all),
        FACT(two_ends_discard_all),
        FACT(a_fragment_past_the_end_discards_all),
        FACT(fragments_wait_half_a_second_and_no_longer),
        FACT(time_that_runs_backwards_drops_nothing),
        FACT(one_datagram_too_many_drops_the_oldest),
        FACT(the_largest_datagram_fits),
        FACT(a_whole_with_an_impossible_udp_length_is_other),
        FACT(every_fragment_is_counted_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
