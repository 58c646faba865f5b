#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/clock_sync.h"
#include "support.h"

#include <string.h>

#define US INT64_C(1000)
#define MS INT64_C(1000000)
#define S  INT64_C(1000000000)
#define H  (3600 * S)

#define WRAP_US INT64_C(0x100000000)

/* A sensor whose clock stood at begin_ns at host time 0; the host's runs faster
 * by ppb. */
struct sensor {
    int64_t begin_ns;
    int64_t ppb;
};

static int64_t sensor_at(const struct sensor *s, int64_t host_ns)
{
    const int64_t rate = S + s->ppb;
    return s->begin_ns + host_ns / rate * S + host_ns % rate * S / rate;
}

static uint32_t stamp(const struct sensor *s, int64_t host_ns)
{
    return (uint32_t)(uint64_t)(sensor_at(s, host_ns) / US);
}

/* An exchange whose request takes `there` and whose answer `back`. */
static void exchange(lum_clock_sync *sync, const struct sensor *s,
                     int64_t sent_ns, int64_t there, int64_t back)
{
    assert_int_equal(lum_clock_sync_add(sync, sent_ns, sent_ns + there + back,
                                        stamp(s, sent_ns + there)),
                     LUM_OK);
}

static lum_clock_estimate estimate(const lum_clock_sync *sync)
{
    lum_clock_estimate e;
    memset(&e, 0x5a, sizeof e);
    assert_int_equal(lum_clock_sync_estimate(sync, &e), LUM_OK);
    return e;
}

static int64_t distance(int64_t a, int64_t b)
{
    return a < b ? b - a : a - b;
}

static void before_the_first_exchange_nothing_is_known(void **state)
{
    lum_clock_sync sync;
    lum_clock_estimate e;
    memset(&e, 0x5a, sizeof e);
    const lum_clock_estimate before = e;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_estimate(&sync, &e), LUM_END);
    assert_memory_equal(&e, &before, sizeof e);
}

static void one_exchange_gives_the_offset_within_half_its_round_trip(
    void **state)
{
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, 10 * S, 10 * S + 2 * MS, 7),
                     LUM_OK);
    const lum_clock_estimate e = estimate(&sync);
    assert_true(e.clock_us == 7);
    assert_true(e.offset_ns == 10 * S + MS - 7 * US);
    assert_in_range(e.error_ns, MS + US, MS + US + 2 * US);
    assert_false(e.has_drift);
    assert_int_equal(e.exchanges, 1);
    assert_int_equal(e.resets, 0);
}

static void times_that_cannot_be_are_refused_and_change_nothing(void **state)
{
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, 5, 6, 7), LUM_OK);
    const lum_clock_sync before = sync;
    assert_int_equal(lum_clock_sync_add(&sync, 100, 99, 7), LUM_E_VALUE);
    assert_int_equal(lum_clock_sync_add(&sync, 100, 101 + H, 7), LUM_E_VALUE);
    assert_int_equal(
        lum_clock_sync_add(&sync, -(INT64_MAX / 2), INT64_MAX / 2, 7),
        LUM_E_VALUE);
    assert_memory_equal(&sync, &before, sizeof sync);
    assert_int_equal(lum_clock_sync_add(&sync, 100, 100 + H, 7), LUM_OK);
}

static void a_better_exchange_is_kept_over_a_worse_later_one(void **state)
{
    const struct sensor s = {5 * S, 0};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    exchange(&sync, &s, 10 * S, 0, 200 * US);
    exchange(&sync, &s, 11 * S, 80 * MS, 0);
    const lum_clock_estimate e = estimate(&sync);
    assert_in_range(e.error_ns, 100 * US, 100 * US + 550 * US);
    assert_true(distance(e.offset_ns, -5 * S) <= e.error_ns);
}

static void the_drift_is_found(void **state)
{
    const struct sensor s = {0, 123456};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    exchange(&sync, &s, S, 100 * US, 100 * US);
    assert_false(estimate(&sync).has_drift);
    exchange(&sync, &s, 1001 * S, 100 * US, 100 * US);
    const lum_clock_estimate e = estimate(&sync);
    assert_true(e.has_drift);
    assert_in_range(e.drift_ppb, 123454, 123458);
    assert_in_range(e.drift_error_ppb, 200, 210);
}

static void any_number_of_wraps_may_pass_between_two_exchanges(void **state)
{
    lum_clock_sync sync;
    (void)state;
    for (int64_t ppb = -500000; ppb <= 500000; ppb += 250000) {
        const struct sensor s = {(WRAP_US - 2000) * US, ppb};
        int64_t now = 0;
        lum_clock_sync_init(&sync);
        for (int64_t gap = S; gap < 400 * H; gap = gap * 3 + 7 * MS) {
            exchange(&sync, &s, now, MS, 0);
            assert_true(estimate(&sync).clock_us ==
                        sensor_at(&s, now + MS) / US);
            now += gap;
        }
        assert_int_equal(estimate(&sync).resets, 0);
        assert_true(estimate(&sync).clock_us > 10 * WRAP_US);
    }
}

static void a_clock_that_begins_anew_begins_the_estimate_anew(void **state)
{
    const struct sensor before = {3000 * S, 100000};
    const struct sensor after = {-500 * S, -100000};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    for (int64_t t = 0; t < 500; t += 10) {
        exchange(&sync, &before, t * S, MS, MS);
    }
    assert_true(estimate(&sync).has_drift);
    exchange(&sync, &after, 510 * S, MS, MS);
    lum_clock_estimate e = estimate(&sync);
    assert_int_equal(e.resets, 1);
    assert_int_equal(e.exchanges, 1);
    assert_false(e.has_drift);
    assert_true(e.clock_us == sensor_at(&after, 510 * S + MS) / US);
    assert_true(distance(e.offset_ns, 500 * S) < 100 * MS);
    exchange(&sync, &after, 1000 * S, MS, MS);
    e = estimate(&sync);
    assert_int_equal(e.resets, 1);
    assert_int_equal(e.exchanges, 2);
    assert_in_range(e.drift_ppb + 200000, 90000, 110000);
}

/* The clock advances by one second, and a little less or more. */
static uint32_t resets_after(int64_t jump_ns)
{
    struct sensor s = {100 * S, 0};
    lum_clock_sync sync;
    lum_clock_sync_init(&sync);
    exchange(&sync, &s, S, 0, 0);
    s.begin_ns += jump_ns;
    exchange(&sync, &s, 2 * S, 0, 0);
    return estimate(&sync).resets;
}

static void a_reset_is_a_second_from_where_the_clock_should_be(void **state)
{
    (void)state;
    assert_int_equal(resets_after(S), 0);
    assert_int_equal(resets_after(-S), 0);
    assert_int_equal(resets_after(S + 2 * MS), 1);
    assert_int_equal(resets_after(-S - 2 * MS), 1);
}

static void a_wrap_is_no_reset_but_half_of_one_is(void **state)
{
    (void)state;
    assert_int_equal(resets_after(WRAP_US * US), 0);
    assert_int_equal(resets_after(WRAP_US / 2 * US), 1);
}

static void a_small_jump_makes_what_was_known_worthless(void **state)
{
    struct sensor s = {100 * S, 0};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    for (int64_t t = 1; t < 30; t++) {
        exchange(&sync, &s, t * S, 0, 0);
    }
    s.begin_ns += 400 * MS;
    exchange(&sync, &s, 30 * S, 3 * MS, 0);
    const lum_clock_estimate e = estimate(&sync);
    assert_false(e.has_drift);
    assert_int_equal(e.resets, 0);
    assert_int_equal(e.exchanges, 30);
    assert_true(distance(e.offset_ns, -100 * S - 400 * MS) <= e.error_ns);
    assert_true(e.error_ns < 2 * MS);
}

static void the_ends_of_time_do_not_overflow(void **state)
{
    const int64_t end = INT64_C(1) << 62;
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, -end, -end, 0xffffffffu),
                     LUM_OK);
    assert_int_equal(lum_clock_sync_add(&sync, end, end, 0), LUM_OK);
    (void)estimate(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, -end, -end + H, 5), LUM_OK);
    (void)estimate(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, end, end, 0), LUM_OK);
    assert_int_equal(lum_clock_sync_add(&sync, -end, -end, 5), LUM_OK);
    (void)estimate(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, 0, 0, 9), LUM_OK);
    (void)estimate(&sync);
}

/* A host clock that goes back is against the rules, and does no more harm than
 * to the estimate. */
static void no_two_times_overflow(void **state)
{
    static const int64_t times[] = {INT64_MIN, INT64_MIN + 1, -1,       0,
                                    1,         INT64_MAX - 1, INT64_MAX};
    (void)state;
    for (size_t i = 0; i < 7; i++) {
        for (size_t k = 0; k < 7; k++) {
            lum_clock_sync sync;
            lum_clock_sync_init(&sync);
            assert_int_equal(lum_clock_sync_add(&sync, times[i], times[i], 0),
                             LUM_OK);
            assert_int_equal(lum_clock_sync_add(&sync, times[k], times[k], 0),
                             LUM_OK);
            (void)estimate(&sync);
            const double apart = (double)times[k] - (double)times[i];
            const bool is_good = k >= i && apart < 10.0;
            lum_clock_sync_init(&sync);
            assert_int_equal(lum_clock_sync_add(&sync, times[i], times[k], 0),
                             is_good ? LUM_OK : LUM_E_VALUE);
        }
    }
}

static void a_clock_may_go_back_for_ever(void **state)
{
    const int64_t end = INT64_C(1) << 62;
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, end, end, 0), LUM_OK);
    assert_int_equal(lum_clock_sync_add(&sync, -end, -end, 0), LUM_OK);
    assert_true(estimate(&sync).clock_us < 0);
}

/* Exchanges 40 days apart, so that none forgets the one before. What lies more
 * than 146 years back says nothing of the drift. */
static void a_drift_is_of_the_last_hundred_years(void **state)
{
    const struct sensor s = {100 * S, 20000};
    const int64_t begin = -200 * 365 * 24 * H;
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    exchange(&sync, &s, begin, MS, MS);
    for (int64_t days = 40; days < 150 * 365; days += 40) {
        exchange(&sync, &s, begin + days * 24 * H, MS, MS);
        const lum_clock_estimate e = estimate(&sync);
        if (days < 146 * 365) {
            assert_true(e.has_drift);
            assert_in_range(e.drift_ppb, 20000 - 4, 20000 + 4);
            assert_in_range(e.drift_error_ppb, 1, 5);
        } else if (days > 149 * 365) {
            assert_false(e.has_drift);
        }
        assert_int_equal(e.resets, 0);
    }
}

/* An exchange with an error of half an hour cannot show that the clock
 * jumped. */
static void a_leap_that_a_slow_exchange_hid_is_no_drift(void **state)
{
    const struct sensor before = {100 * S, 0};
    const struct sensor after = {600 * S, 0};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    exchange(&sync, &before, 0, MS, MS);
    exchange(&sync, &after, 10 * S, 1800 * S, 1800 * S);
    exchange(&sync, &after, 4000 * S, MS, MS);
    const lum_clock_estimate e = estimate(&sync);
    assert_int_equal(e.resets, 0);
    assert_int_equal(e.exchanges, 3);
    assert_false(e.has_drift);
}

/* More exchanges than can be counted: the ring continues where it was. */
static void the_count_ends_without_harm(void **state)
{
    const struct sensor s = {100 * S, 1000};
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    /* farther apart than half a wrap, so that it matters which is the last */
    for (int64_t t = 0; t < 15; t++) {
        exchange(&sync, &s, t * 3000 * S, 0, 0);
    }
    sync.count = UINT32_MAX;
    for (int64_t t = 15; t < 40; t++) {
        exchange(&sync, &s, t * 3000 * S, 0, 0);
        assert_int_equal(estimate(&sync).resets, 0);
        assert_true(distance(estimate(&sync).drift_ppb, 1000) <=
                    estimate(&sync).drift_error_ppb);
    }
    assert_true(estimate(&sync).exchanges > UINT32_MAX - 20u);
}

/* Exact figures. Of an exchange: half way between its times, half its round
 * trip, and the sensor's clock over all wraps. */

static void put(lum_clock_sync *sync, int64_t middle_ns, int64_t half_ns,
                int64_t clock_us)
{
    assert_int_equal(lum_clock_sync_add(sync, middle_ns - half_ns,
                                        middle_ns + half_ns,
                                        (uint32_t)(uint64_t)clock_us),
                     LUM_OK);
}

/* Half the round trip, a nanosecond for its other half, the sensor's
 * microsecond, and 500 ppm of the half. */
static void the_error_of_one_exchange_is_of_four_parts(void **state)
{
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    assert_int_equal(lum_clock_sync_add(&sync, 0, 3, 7), LUM_OK);
    assert_true(estimate(&sync).offset_ns == 1 - 7000);
    assert_true(estimate(&sync).error_ns == 1 + 1 + 1000);
    lum_clock_sync_init(&sync);
    put(&sync, 0, 1800 * S, 7);
    assert_true(estimate(&sync).error_ns == 1800 * S + 1 + 1000 + 900 * MS);
}

/* Two exchanges whose errors are 1002 ns each, in_ns apart, between which the
 * offset changes by so much. */
static lum_clock_estimate estimate_of_two(int64_t in_ns, int64_t change)
{
    lum_clock_sync sync;
    lum_clock_sync_init(&sync);
    assert_int_equal((in_ns - change) % 1000, 0);
    put(&sync, -S, 1, 5);
    put(&sync, in_ns - S, 1, 5 + (in_ns - change) / 1000);
    return estimate(&sync);
}

/* What may be between two exchanges: their errors and 500 ppm of the time. */
static void a_change_beyond_errors_and_rate_is_a_jump(void **state)
{
    const int64_t limit = 2 * 1002 + 5 * S;
    (void)state;
    assert_true(estimate_of_two(10000 * S + 4, limit).has_drift);
    assert_true(estimate_of_two(10000 * S + 996, -limit).has_drift);
    assert_false(estimate_of_two(10000 * S + 5, limit + 1).has_drift);
    assert_int_equal(estimate_of_two(10000 * S + 4, limit + S).resets, 0);
    assert_int_equal(estimate_of_two(10000 * S + 5, limit + S + 1).resets, 1);
}

/* With the limit at half a wrap its number is no longer known. */
static void half_a_wrap_of_doubt_makes_what_was_known_worthless(void **state)
{
    const int64_t half = INT64_C(0x80000000) * US;
    const int64_t in_ns = (half - 2 * 1002) * 2000;
    (void)state;
    assert_false(estimate_of_two(in_ns, 0).has_drift);
    assert_true(estimate_of_two(in_ns - 2000, 0).has_drift);
}

static void a_drift_is_told_where_it_is_below_500_ppm(void **state)
{
    (void)state;
    /* of its error */
    assert_false(estimate_of_two(4009000, 0).has_drift);
    assert_true(estimate_of_two(4010000, 0).has_drift);
    assert_false(estimate_of_two(4010000, 1000).has_drift);
    assert_true(estimate_of_two(4009000, -1000).has_drift);
    /* and, of the change, where it is below 1000 ppm */
    assert_true(estimate_of_two(4010000 + 4009, 4009).has_drift);
    assert_false(estimate_of_two(4010000 + 4010, 4010).has_drift);
}

static void a_drift_and_its_error_are_shares_of_the_sensors_time(void **state)
{
    lum_clock_sync sync;
    (void)state;
    lum_clock_sync_init(&sync);
    put(&sync, 0, 2 * S, 5);
    put(&sync, 10000 * S, 2 * S, 5 + (10000 * S - S) / 1000);
    const lum_clock_estimate e = estimate(&sync);
    assert_int_equal(e.drift_ppb, 100010); /* 1 s of 9999 s */
    /* 2 x 2001001001 ns of 9999 s less as much: 400402; a 500th more, and 3 */
    assert_int_equal(e.drift_error_ppb, 400402 - 1 + 800 + 2);
}

/* Also over spans that are halved before they are multiplied; the exchanges
 * between are bad ones. */
static int32_t drift_over_months(int64_t sensor_ns, int64_t change)
{
    lum_clock_sync sync;
    lum_clock_sync_init(&sync);
    for (int64_t i = 0; i <= 4; i++) {
        put(&sync, (sensor_ns + change) / 4 * i + (i == 4 ? change % 4 : 0),
            i % 4 == 0 ? 1 : S, sensor_ns / 4000 * i);
    }
    return estimate(&sync).drift_ppb;
}

static void a_drift_over_months_is_told_to_the_last_figure(void **state)
{
    const int64_t sensor_ns = INT64_C(9230300000000000);
    const int64_t change = INT64_C(1006095773000);
    (void)state;
    assert_int_equal(drift_over_months(sensor_ns, change), 108999);
    assert_int_equal(drift_over_months(sensor_ns, -change), -108999);
}

/* Two good exchanges far apart, then a bad one: the offset is the second one's,
 * brought forward. */
static lum_clock_estimate estimate_after(int64_t change, int64_t age)
{
    lum_clock_sync sync;
    lum_clock_sync_init(&sync);
    put(&sync, 0, 5 * MS, 0);
    put(&sync, 10000 * S, 5 * MS, (10000 * S - change) / 1000);
    put(&sync, 10000 * S + age, S, (10000 * S - change + age) / 1000);
    return estimate(&sync);
}

static void an_offset_is_brought_forward_by_the_drift(void **state)
{
    lum_clock_estimate e = estimate_after(S, 1000 * S + 500 * MS);
    (void)state;
    assert_int_equal(e.drift_ppb, 100010);
    assert_int_equal(e.drift_error_ppb, 1005);
    /* what the sensor's clock counted meanwhile, 100010 ppb of it */
    assert_true(e.offset_ns == S + 100049997);
    /* half, 1 ns, 1 us, 500 ppm; 1005 + 1000 ppb of the age; 4 ns */
    assert_true(e.error_ns == 5003501 + 2006002 + 4);
    e = estimate_after(S, 1001 * S - 1);
    assert_true(e.offset_ns == S + 100099997);
    assert_true(e.error_ns == 5003501 + 2007004 + 4);
    e = estimate_after(-S, 1000 * S + 500 * MS);
    assert_int_equal(e.drift_ppb, -99990);
    assert_int_equal(e.drift_error_ppb, 1005);
    assert_true(e.offset_ns == -S - 100049997);
    assert_true(e.error_ns == 5003501 + 2006002 + 4);
}

/* Rounding is paid for by any age; the drift of an unknown rate is 500 ppm. */
static void an_error_grows_with_age(void **state)
{
    static const int64_t ages[] = {-1, 0, 1, 10, 1000 * S};
    (void)state;
    for (size_t i = 0; i < sizeof ages / sizeof ages[0]; i++) {
        const int64_t age = ages[i];
        lum_clock_sync sync;
        lum_clock_sync_init(&sync);
        put(&sync, 0, MS, 0);
        put(&sync, age, 2 * S, age / 1000);
        assert_false(estimate(&sync).has_drift);
        assert_true(estimate(&sync).error_ns ==
                    1001501 + (age > 10 ? age / 2000 : 0) + (age != 0 ? 4 : 0));
    }
}

/* The best of the first 16 exchanges, here the one of that number, is what the
 * drift is measured from. */
static int32_t drift_error_from(unsigned good)
{
    lum_clock_sync sync;
    lum_clock_sync_init(&sync);
    for (unsigned i = 1; i <= 17; i++) {
        put(&sync, i * S, i == good ? 1 : 10 * MS, i * (S / US));
    }
    put(&sync, 1000 * S, 1, 1000 * (S / US));
    return estimate(&sync).drift_error_ppb;
}

static void a_drift_is_measured_from_the_best_of_16(void **state)
{
    (void)state;
    for (unsigned good = 1; good <= 16; good++) {
        assert_in_range(drift_error_from(good), 3, 10);
    }
    assert_in_range(drift_error_from(17), 10000, 11000);
}

/* n exchanges of which only the first and the last are good. */
static void a_drift_is_found_wherever_in_the_ring(void **state)
{
    (void)state;
    for (unsigned n = 2; n <= 2 * LUM_CLOCK_EXCHANGES; n++) {
        lum_clock_sync sync;
        lum_clock_sync_init(&sync);
        for (unsigned i = 1; i <= n; i++) {
            const bool is_good = i == 1 || i == n;
            put(&sync, i * 100 * S, is_good ? MS : 100 * S, i * 100 * (S / US));
            assert_int_equal(estimate(&sync).has_drift, i == n);
        }
    }
}

static int64_t below(uint64_t *random, int64_t limit)
{
    return (int64_t)(next_random(random) % (uint64_t)limit);
}

/* One time in eight something takes much longer. */
static int64_t seldom_long(uint64_t *random, int64_t usual, int64_t longer)
{
    const int64_t limit = next_random(random) % 8u == 0 ? longer : usual;
    return below(random, 1000) * (limit / 1000) + below(random, 1000);
}

static void follow_a_sensor(uint64_t *random)
{
    const struct sensor s = {below(random, 4000000) * MS,
                             below(random, 400001) - 200000};
    lum_clock_sync sync;
    int64_t now = 0;
    int64_t best_drift_error = INT64_MAX;
    lum_clock_sync_init(&sync);
    for (unsigned i = 0; i < 120; i++) {
        const int64_t there = seldom_long(random, 2 * MS, 300 * MS);
        const int64_t back = seldom_long(random, 2 * MS, 300 * MS);
        exchange(&sync, &s, now, there, back);
        const int64_t middle = now + (there + back) / 2;
        const lum_clock_estimate e = estimate(&sync);
        assert_true(e.clock_us == sensor_at(&s, now + there) / US);
        assert_true(distance(e.offset_ns, middle - sensor_at(&s, middle)) <=
                    e.error_ns);
        assert_true(e.error_ns <= (there + back) * 501 / 1000 + 2 * US);
        if (e.has_drift) {
            assert_true(distance(e.drift_ppb, s.ppb) <= e.drift_error_ppb);
            best_drift_error = e.drift_error_ppb;
        }
        now += there + back + seldom_long(random, 10 * S, 3 * H);
    }
    assert_int_equal(estimate(&sync).resets, 0);
    assert_int_equal(estimate(&sync).exchanges, 120);
    assert_true(best_drift_error < 5000);
}

static void offset_and_drift_are_always_within_their_bounds(void **state)
{
    uint64_t random = 3;
    (void)state;
    for (unsigned i = 0; i < 200; i++) {
        follow_a_sensor(&random);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(before_the_first_exchange_nothing_is_known),
        cmocka_unit_test(
            one_exchange_gives_the_offset_within_half_its_round_trip),
        cmocka_unit_test(times_that_cannot_be_are_refused_and_change_nothing),
        cmocka_unit_test(a_better_exchange_is_kept_over_a_worse_later_one),
        cmocka_unit_test(the_drift_is_found),
        cmocka_unit_test(any_number_of_wraps_may_pass_between_two_exchanges),
        cmocka_unit_test(a_clock_that_begins_anew_begins_the_estimate_anew),
        cmocka_unit_test(a_reset_is_a_second_from_where_the_clock_should_be),
        cmocka_unit_test(a_wrap_is_no_reset_but_half_of_one_is),
        cmocka_unit_test(a_small_jump_makes_what_was_known_worthless),
        cmocka_unit_test(the_ends_of_time_do_not_overflow),
        cmocka_unit_test(no_two_times_overflow),
        cmocka_unit_test(a_clock_may_go_back_for_ever),
        cmocka_unit_test(a_drift_is_of_the_last_hundred_years),
        cmocka_unit_test(a_leap_that_a_slow_exchange_hid_is_no_drift),
        cmocka_unit_test(the_count_ends_without_harm),
        cmocka_unit_test(the_error_of_one_exchange_is_of_four_parts),
        cmocka_unit_test(a_change_beyond_errors_and_rate_is_a_jump),
        cmocka_unit_test(half_a_wrap_of_doubt_makes_what_was_known_worthless),
        cmocka_unit_test(a_drift_is_told_where_it_is_below_500_ppm),
        cmocka_unit_test(a_drift_and_its_error_are_shares_of_the_sensors_time),
        cmocka_unit_test(a_drift_over_months_is_told_to_the_last_figure),
        cmocka_unit_test(an_offset_is_brought_forward_by_the_drift),
        cmocka_unit_test(an_error_grows_with_age),
        cmocka_unit_test(a_drift_is_measured_from_the_best_of_16),
        cmocka_unit_test(a_drift_is_found_wherever_in_the_ring),
        cmocka_unit_test(offset_and_drift_are_always_within_their_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
