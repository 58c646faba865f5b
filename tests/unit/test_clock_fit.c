#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "frame/clock_line.h"
#include "lum/frame/clock_fit.h"
#include "sim/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define US    1000
#define MS    INT64_C(1000000)
#define S     INT64_C(1000000000)
#define EPOCH (INT64_C(1767225600) * S)

#define LINE_64_US  1562.5 /* 64 lines, 10 Hz */
#define LINE_640_US 156.25

/* A sensor, its way to the host, and a fit of what arrives. */
struct stream {
    lum_clock_fit *fit;
    double line_us;
    double ppm;      /* the host's clock is faster by this */
    double slew_ppm; /* and by this from 6 s to 11 s */
    double wander_ppm;
    int64_t batch_ns; /* 0: each packet has its own stamp */
    double jitter_us; /* mean of a random delay */
    int64_t resolution_ns;
    int64_t eye_ns;   /* the green line comes so much later */
    int64_t clock_us; /* at the begin */
    int64_t host_ns;  /* of that */
    lum_random random;
    double line;         /* lines so far */
    lum_clock_time time; /* of the last reading */
    int64_t truth_ns;
    lum_clock_fit_event event; /* the last one that is not TAKEN */
};

/* What a while of a stream has shown. */
struct seen {
    int64_t worst_ns; /* the largest error */
    int64_t told_ns;  /* the largest error reported */
    double beyond;    /* share of the readings with a larger error than that */
};

static struct stream stream_of(double line_us, double ppm, int64_t batch_ns)
{
    struct stream s = {.fit = lum_clock_fit_new(),
                       .line_us = line_us,
                       .ppm = ppm,
                       .batch_ns = batch_ns,
                       .clock_us = 1234567,
                       .host_ns = EPOCH};
    assert_non_null(s.fit);
    lum_random_init(&s.random, 7, 1);
    return s;
}

/* What the host's clock has gained by then, in us, with a period of 8 s. */
static double gain_of(const struct stream *s, double seconds)
{
    const double turns = seconds / 8.0;
    return s->slew_ppm * (fmin(fmax(seconds, 6.0), 11.0) - 6.0) +
           s->wander_ppm * 8.0 * sin(turns * 6.2831853) / 6.2831853;
}

static int64_t truth_of(const struct stream *s, int64_t clock_us)
{
    const double us = (double)(clock_us - s->clock_us);
    return s->host_ns +
           (int64_t)(us * (1e3 + s->ppm * 1e-3) + gain_of(s, us * 1e-6) * 1e3);
}

static int64_t clock_of(const struct stream *s)
{
    return s->clock_us + (int64_t)(s->line * s->line_us);
}

static int64_t arrival_of(struct stream *s, int64_t truth_ns)
{
    int64_t ns = truth_ns;
    if (s->jitter_us > 0.0) {
        const double u = (double)lum_random_unit(&s->random);
        ns -= (int64_t)(s->jitter_us * 1e3 * log(1.0 - u));
    }
    if (s->batch_ns > 0) {
        /* Nobody is woken to the microsecond. */
        const int64_t batch = (ns + s->batch_ns - 1) / s->batch_ns;
        ns = batch * s->batch_ns + batch * 7919 % 9973;
    }
    return s->resolution_ns > 0 ? ns / s->resolution_ns * s->resolution_ns : ns;
}

/* One line of both eyes; its clock. */
static int64_t add_line(struct stream *s)
{
    const int64_t clock_us = clock_of(s);
    s->truth_ns = truth_of(s, clock_us);
    for (unsigned eye = 0; eye < 2u; eye++) {
        const lum_clock_fit_event event = lum_clock_fit_add(
            s->fit, clock_us, arrival_of(s, s->truth_ns + eye * s->eye_ns));
        s->event = event != LUM_CLOCK_FIT_TAKEN ? event : s->event;
    }
    s->line += 1.0;
    return clock_us;
}

static void one_line(struct stream *s)
{
    const int64_t clock_us = add_line(s);
    assert_int_equal(lum_clock_fit_utc(s->fit, clock_us, &s->time), LUM_OK);
}

static struct seen pass(struct stream *s, double seconds)
{
    struct seen seen = {0, 0, 0.0};
    const double end = s->line + seconds * 1e6 / s->line_us;
    double beyond = 0.0;
    double count = 0.0;
    while (s->line < end) {
        one_line(s);
        const int64_t error = llabs(s->time.utc_ns - s->truth_ns);
        seen.worst_ns = error > seen.worst_ns ? error : seen.worst_ns;
        seen.told_ns =
            s->time.error_ns > seen.told_ns ? s->time.error_ns : seen.told_ns;
        beyond += error > s->time.error_ns ? 1.0 : 0.0;
        count += 1.0;
    }
    seen.beyond = beyond / count;
    return seen;
}

static lum_clock_fit_info info_of(const lum_clock_fit *fit)
{
    lum_clock_fit_info info = {.struct_size = sizeof info};
    assert_int_equal(lum_clock_fit_get_info(fit, &info), LUM_OK);
    return info;
}

static void before_the_first_reading_nothing_is_known(void **state)
{
    (void)state;
    lum_clock_fit *fit = lum_clock_fit_new();
    lum_clock_time time = {1, 2};
    lum_clock_fit_info info = {.struct_size = sizeof info, .error_ns = 9};
    assert_int_equal(lum_clock_fit_utc(fit, 0, &time), LUM_END);
    assert_true(time.utc_ns == 1 && time.error_ns == 2);
    assert_int_equal(lum_clock_fit_get_info(fit, &info), LUM_END);
    assert_true(info.taken == 0 && info.error_ns == 0 && !info.has_drift);
    lum_clock_fit_free(fit);
    lum_clock_fit_free(NULL);
}

static void the_first_reading_is_its_arrival_and_uncertain(void **state)
{
    (void)state;
    lum_clock_fit *fit = lum_clock_fit_new();
    lum_clock_time time;
    assert_int_equal(lum_clock_fit_add(fit, 5000, EPOCH), LUM_CLOCK_FIT_TAKEN);
    assert_int_equal(lum_clock_fit_utc(fit, 5000, &time), LUM_OK);
    assert_int_equal(time.utc_ns, EPOCH);
    assert_true(time.error_ns == LUM_CLOCK_ERROR_UNKNOWN);
    assert_int_equal(lum_clock_fit_utc(fit, 6000, &time), LUM_OK);
    assert_int_equal(time.utc_ns, EPOCH + MS);
    lum_clock_fit_free(fit);
}

static void an_even_stream_is_known_within_a_millisecond_of_its_begin(
    void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 0.0, 0);
    (void)pass(&s, 1.0);
    const struct seen seen = pass(&s, 5.0);
    assert_true(seen.worst_ns <= US);
    assert_true(seen.told_ns <= 20 * US);
    lum_clock_fit_free(s.fit);
}

/* The bar: 50 us, for stamps in batches of 8 ms and a drift of 50 ppm. */
static void batches_and_drift_leave_less_than_50_us(void **state)
{
    (void)state;
    const double lines[] = {LINE_64_US, LINE_640_US};
    const double drifts[] = {50.0, -50.0, 100.0, -100.0, 300.0};
    for (size_t i = 0; i < 2u; i++) {
        for (size_t k = 0; k < sizeof drifts / sizeof drifts[0]; k++) {
            struct stream s = stream_of(lines[i], drifts[k], 8 * MS);
            const struct seen first = pass(&s, 2.0);
            const struct seen later = pass(&s, i == 0 ? 18.0 : 8.0);
            const lum_clock_fit_info info = info_of(s.fit);
            assert_true(first.beyond == 0.0);
            assert_true(later.worst_ns < 50 * US);
            assert_true(later.beyond == 0.0);
            assert_true(info.error_ns < 400 * US);
            assert_true(info.has_drift);
            assert_true(abs(info.drift_ppb - (int32_t)(drifts[k] * 1000.0)) <=
                        info.drift_error_ppb);
            assert_true(info.drift_error_ppb < 40000);
            assert_true(s.event == LUM_CLOCK_FIT_TAKEN);
            lum_clock_fit_free(s.fit);
        }
    }
}

/* If lines do not shift against batches, the error is hard to detect. */
static void the_error_that_is_told_is_honest(void **state)
{
    (void)state;
    const struct {
        double ppm;
        int64_t batch_ns;
        double jitter_us;
    } ways[] = {
        {3.0, 8 * MS, 0.0},        {10.0, 8 * MS, 0.0},     {3.0, MS, 0.0},
        {-50.0, 8300 * US, 0.0},   {50.0, 0, 20.0},         {50.0, 0, 200.0},
        {-100.0, 0, 2000.0},       {50.0, 8 * MS, 20.0},    {-100.0, MS, 200.0},
        {50.0, MS, 2000.0},        {-100.0, 8 * MS, 200.0}, {0.0, 0, 0.0},
        {-100.0, 8300 * US, 200.0}};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        for (unsigned k = 0; k < 2u; k++) {
            struct stream s = stream_of(k == 0 ? LINE_64_US : LINE_640_US,
                                        ways[i].ppm, ways[i].batch_ns);
            s.jitter_us = ways[i].jitter_us;
            s.clock_us = 99991;
            const struct seen seen = pass(&s, k == 0 ? 16.0 : 8.0);
            if (seen.beyond > 0.03) {
                fail_msg("%zu/%u: %.1f %% beyond", i, k, seen.beyond * 100.0);
            }
            lum_clock_fit_free(s.fit);
        }
    }
}

/* The begin of each frame of 100 ms, once it is complete. */
static struct seen see_frames(struct stream *s, double seconds)
{
    struct seen seen = {0, 0, 0.0};
    const unsigned frames = (unsigned)(seconds * 10.0);
    const unsigned lines = (unsigned)(1e5 / s->line_us);
    for (unsigned i = 0; i < frames; i++) {
        const int64_t clock_us = clock_of(s);
        lum_clock_time time;
        for (unsigned k = 0; k < lines + 8u; k++) {
            (void)add_line(s);
        }
        s->line -= 8.0; /* they come once more, which is no news */
        assert_int_equal(lum_clock_fit_utc(s->fit, clock_us, &time), LUM_OK);
        const int64_t error = llabs(time.utc_ns - truth_of(s, clock_us));
        seen.told_ns =
            time.error_ns > seen.told_ns ? time.error_ns : seen.told_ns;
        seen.beyond += error > time.error_ns ? 1.0 / frames : 0.0;
    }
    return seen;
}

/* Slews, wander, batches and coarse stamps, any three of them in all
 * combinations; drifts and delays. */
static void the_error_holds_for_99_of_100_frames(void **state)
{
    (void)state;
    const double slews[] = {0.0, 50.0, -200.0, 500.0, -500.0};
    const double wanders[] = {0.0, 10.0, 80.0};
    const int64_t batches[] = {0, MS, 8 * MS, 20 * MS};
    const int64_t resolutions[] = {US, 100 * US, MS, 10 * MS};
    for (unsigned i = 0; i < 5u * 3u * 4u * 4u; i++) {
        if ((i + i / 4u + i / 16u) % 2u != 0) {
            continue;
        }
        struct stream s = stream_of(i % 13u == 0 ? LINE_640_US : LINE_64_US,
                                    50.0 * (i % 3u) - 50.0, batches[i % 4u]);
        s.resolution_ns = resolutions[i / 4u % 4u];
        s.wander_ppm = wanders[i / 16u % 3u];
        s.slew_ppm = slews[i / 48u];
        s.jitter_us = i % 5u == 0 ? 200.0 : 0.0;
        s.host_ns += 123456789;
        (void)see_frames(&s, 0.5);
        const struct seen seen = see_frames(&s, 14.0);
        if (seen.beyond > 0.01) {
            fail_msg("%u: %.1f %% beyond", i, seen.beyond * 100.0);
        }
        assert_true(seen.told_ns < 100 * MS);
        assert_true(info_of(s.fit).resolution_ns % s.resolution_ns == 0);
        assert_int_equal(info_of(s.fit).host_steps, 0);
        lum_clock_fit_free(s.fit);
    }
}

/* Rounded to the nearest, up, or to parts of a second. */
static void the_resolution_is_seen_in_the_stamps(void **state)
{
    (void)state;
    const int64_t parts[] = {1000000, 100, 125, 1024, 64, 8, 1};
    for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        struct stream s = stream_of(LINE_640_US, 50.0, 0);
        const int64_t offset_ns = (int64_t)(i % 3u) * S / parts[i] / 2;
        for (int64_t ns = 0; ns < 8 * S; ns += 1562700) {
            const int64_t part = (ns + offset_ns) / (S / parts[i]);
            (void)lum_clock_fit_add(s.fit, ns / 1000,
                                    EPOCH + part / parts[i] * S +
                                        part % parts[i] * S / parts[i]);
        }
        const int64_t seen_ns = info_of(s.fit).resolution_ns;
        assert_true(llabs(seen_ns - S / parts[i]) <= 1);
        assert_true(info_of(s.fit).error_ns > seen_ns);
        lum_clock_fit_free(s.fit);
    }
}

static void an_eye_that_is_always_later_is_no_batch(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 0);
    s.eye_ns = 60 * US;
    (void)pass(&s, 3.0);
    assert_true(pass(&s, 3.0).told_ns < 20 * US);
    lum_clock_fit_free(s.fit);
}

static void arrivals_that_leave_the_line_make_it_uncertain(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_640_US, 50.0, 0);
    (void)pass(&s, 5.0);
    assert_true(s.time.error_ns < 20 * US);
    s.host_ns += 5 * MS;
    (void)pass(&s, 1.5);
    assert_true(s.time.error_ns > 4900 * US);
    s.host_ns -= 5 * MS;
    const struct seen seen = pass(&s, 1.0);
    assert_true(seen.worst_ns < 20 * US);
    assert_int_equal(info_of(s.fit).host_steps, 0);
    lum_clock_fit_free(s.fit);
}

/* The crystal warms up: by 0.2 ppm each second. */
static void a_drift_that_changes_slowly_is_followed(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 20.0, 0);
    struct seen seen = {0, 0, 0.0};
    for (unsigned i = 0; i < 600u; i++) {
        s.host_ns = truth_of(&s, clock_of(&s));
        s.clock_us = clock_of(&s);
        s.line = 0.0;
        s.ppm += 0.02;
        seen = pass(&s, 0.1);
        assert_true(i < 50u || seen.worst_ns < 50 * US);
        assert_true(i < 50u || seen.beyond == 0.0);
    }
    lum_clock_fit_free(s.fit);
}

static void a_delay_that_all_have_cannot_be_seen(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_640_US, 50.0, 0);
    s.host_ns += 300 * US;
    (void)pass(&s, 5.0);
    s.host_ns -= 300 * US;
    const int64_t late = s.time.utc_ns - truth_of(&s, clock_of(&s) - 156);
    assert_true(late > 298 * US && late < 302 * US);
    lum_clock_fit_free(s.fit);
}

static void a_restart_of_the_sensor_begins_anew(void **state)
{
    (void)state;
    const int64_t jumps_us[] = {-60000000, -2000000, 2000000, 900000000};
    for (size_t i = 0; i < sizeof jumps_us / sizeof jumps_us[0]; i++) {
        struct stream s = stream_of(LINE_64_US, 50.0, 8 * MS);
        s.clock_us = 70000000;
        (void)pass(&s, 10.0);
        s.host_ns = truth_of(&s, clock_of(&s)) + MS;
        s.clock_us = clock_of(&s) + jumps_us[i];
        s.line = 0.0;
        const struct seen first = pass(&s, 1.0);
        const struct seen later = pass(&s, 8.0);
        const lum_clock_fit_info info = info_of(s.fit);
        assert_int_equal(info.sensor_breaks, 1);
        assert_int_equal(info.host_steps, 0);
        assert_true(first.worst_ns < 10 * MS);
        assert_true(first.beyond == 0.0);
        assert_true(later.worst_ns < 50 * US);
        lum_clock_fit_free(s.fit);
    }
}

static void a_step_of_the_hosts_clock_begins_anew(void **state)
{
    (void)state;
    const int64_t steps_ns[] = {3 * S,     -3 * S,   3600 * S,
                                -3600 * S, 500 * MS, -200 * MS};
    for (size_t i = 0; i < sizeof steps_ns / sizeof steps_ns[0]; i++) {
        struct stream s = stream_of(LINE_64_US, -50.0, 8 * MS);
        (void)pass(&s, 10.0);
        s.host_ns += steps_ns[i];
        (void)pass(&s, 3.0);
        const struct seen later = pass(&s, 8.0);
        const lum_clock_fit_info info = info_of(s.fit);
        assert_int_equal(info.host_steps, 1);
        assert_int_equal(info.sensor_breaks, 0);
        assert_true(later.worst_ns < 60 * US);
        assert_true(later.beyond == 0.0);
        lum_clock_fit_free(s.fit);
    }
}

/* Frames before it were handed out; those from it on say that nobody knows. */
static void around_a_step_the_error_is_not_known(void **state)
{
    (void)state;
    const int64_t steps_ns[] = {S, -S, 3600 * S, -3600 * S, 300 * MS, -20 * MS};
    for (size_t i = 0; i < sizeof steps_ns / sizeof steps_ns[0]; i++) {
        struct stream s = stream_of(LINE_64_US, 50.0, 0);
        assert_true(see_frames(&s, 8.0).told_ns < 50 * MS);
        s.host_ns += steps_ns[i];
        for (unsigned k = 0; k < 9u; k++) {
            assert_true(see_frames(&s, 0.1).told_ns == LUM_CLOCK_ERROR_UNKNOWN);
        }
        (void)see_frames(&s, 0.5);
        const struct seen later = see_frames(&s, 8.0);
        assert_true(later.beyond == 0.0 && later.told_ns < 50 * MS);
        assert_int_equal(info_of(s.fit).host_steps, 1);
        lum_clock_fit_free(s.fit);
    }
}

/* Too short to be told from a slow network, and yet they show. */
static void a_small_step_is_in_the_error_soon(void **state)
{
    (void)state;
    const int64_t steps_ns[] = {2 * MS, 20 * MS, 200 * MS};
    for (size_t i = 0; i < sizeof steps_ns / sizeof steps_ns[0]; i++) {
        struct stream s = stream_of(LINE_64_US, 50.0, 0);
        (void)see_frames(&s, 8.0);
        s.host_ns += steps_ns[i];
        (void)see_frames(&s, 0.1);
        assert_true(see_frames(&s, 12.0).beyond == 0.0);
        lum_clock_fit_free(s.fit);
    }
}

static void a_network_that_is_slow_for_a_moment_is_no_step(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 8 * MS);
    (void)pass(&s, 5.0);
    for (unsigned i = 0; i < 20u; i++) {
        s.host_ns += 400 * MS;
        (void)pass(&s, 0.7);
        s.host_ns -= 400 * MS;
        const struct seen seen = pass(&s, 0.1);
        assert_true(seen.worst_ns < 60 * US);
    }
    assert_int_equal(info_of(s.fit).host_steps, 0);
    lum_clock_fit_free(s.fit);
}

static void random_delays_are_no_steps(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 20u; seed++) {
        struct stream s = stream_of(LINE_64_US, 50.0, 0);
        lum_random_init(&s.random, seed, 1);
        s.jitter_us = 10000.0;
        (void)pass(&s, 3.0);
        assert_int_equal(info_of(s.fit).host_steps, 0);
        assert_int_equal(info_of(s.fit).sensor_breaks, 0);
        lum_clock_fit_free(s.fit);
    }
}

/* It was off for longer than it had been on. */
static void a_restart_after_a_pause_is_one_of_the_sensor(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 0);
    s.clock_us = 0;
    (void)pass(&s, 20.0);
    s.host_ns = truth_of(&s, clock_of(&s)) + 60 * S;
    s.clock_us = 0;
    s.line = 0.0;
    (void)pass(&s, 1.0);
    const lum_clock_fit_info info = info_of(s.fit);
    assert_int_equal(info.sensor_breaks, 1);
    assert_int_equal(info.host_steps, 0);
    assert_int_equal(info.aside, 0);
    lum_clock_fit_free(s.fit);
}

/* A sensor that ran for on_us, was off for off_ns and begins anew; its clock
 * stands at a few milliseconds by its first line. */
static lum_clock_fit_info restart(int64_t on_us, int64_t off_ns,
                                  int64_t batch_ns)
{
    struct stream s = stream_of(LINE_64_US, 50.0, batch_ns);
    s.clock_us = 2000;
    (void)pass(&s, (double)on_us * 1e-6);
    s.host_ns = truth_of(&s, clock_of(&s)) + off_ns;
    s.clock_us = 2000;
    s.line = 0.0;
    const struct seen first = pass(&s, 1.5);
    const lum_clock_fit_info info = info_of(s.fit);
    assert_true(first.worst_ns < 10 * MS);
    lum_clock_fit_free(s.fit);
    return info;
}

static void a_restart_within_the_first_second_is_one_of_the_sensor(void **state)
{
    (void)state;
    const int64_t on_us[] = {50000, 200000, 600000, 950000};
    const int64_t off_ns[] = {300 * MS, 700 * MS, 3 * S, 60 * S, 3600 * S};
    for (size_t i = 0; i < sizeof on_us / sizeof on_us[0]; i++) {
        for (size_t k = 0; k < sizeof off_ns / sizeof off_ns[0]; k++) {
            for (unsigned is_batch = 0; is_batch < 2u; is_batch++) {
                const lum_clock_fit_info info =
                    restart(on_us[i], off_ns[k], is_batch * 8 * MS);
                assert_int_equal(info.sensor_breaks, 1);
                assert_int_equal(info.host_steps, 0);
                assert_int_equal(info.aside, 0);
            }
        }
    }
}

/* The reading after the step is of a line before the last one. */
static void a_step_between_lines_out_of_order_is_one_of_the_host(void **state)
{
    (void)state;
    const int64_t steps_ns[] = {3 * S, 3600 * S, -3 * S};
    const int64_t back_us[] = {1, 5000, 20000};
    for (size_t i = 0; i < sizeof steps_ns / sizeof steps_ns[0]; i++) {
        for (size_t k = 0; k < sizeof back_us / sizeof back_us[0]; k++) {
            struct stream s = stream_of(LINE_64_US, 50.0, 0);
            (void)pass(&s, 0.7);
            const int64_t last_us = clock_of(&s) - (int64_t)LINE_64_US;
            s.host_ns += steps_ns[i];
            (void)lum_clock_fit_add(
                s.fit, last_us - back_us[k],
                arrival_of(&s, truth_of(&s, last_us - back_us[k])));
            (void)pass(&s, 3.0);
            const lum_clock_fit_info info = info_of(s.fit);
            assert_int_equal(info.host_steps, 1);
            assert_int_equal(info.sensor_breaks, 0);
            lum_clock_fit_free(s.fit);
        }
    }
}

static void the_drift_is_known_over_a_break(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 300.0, 8 * MS);
    (void)pass(&s, 18.0);
    s.host_ns += 10 * S;
    s.event = LUM_CLOCK_FIT_TAKEN;
    while (s.event != LUM_CLOCK_FIT_HOST_STEP) {
        one_line(&s);
    }
    for (unsigned i = 0; i < 6u; i++) {
        const lum_clock_fit_info info = info_of(s.fit);
        assert_true(!info.has_drift);
        assert_true(abs(info.drift_ppb - 300000) < 3000);
        assert_true(info.drift_error_ppb < 80000);
        (void)pass(&s, 0.1);
    }
    lum_clock_fit_free(s.fit);
}

static void a_clock_that_is_slewed_is_followed_and_the_error_grows(void **state)
{
    (void)state;
    const double rates[] = {200.0, -200.0};
    for (size_t i = 0; i < 2u; i++) {
        struct stream s = stream_of(LINE_64_US, 0.0, 0);
        (void)pass(&s, 16.0);
        s.host_ns = truth_of(&s, clock_of(&s));
        s.clock_us = clock_of(&s);
        s.line = 0.0;
        s.ppm = rates[i];
        const struct seen during = pass(&s, 16.0);
        const struct seen after = pass(&s, 10.0);
        assert_true(during.told_ns > 100 * US);
        assert_true(after.worst_ns < 100 * US);
        assert_int_equal(info_of(s.fit).host_steps, 0);
        lum_clock_fit_free(s.fit);
    }
}

static void a_late_arrival_after_a_pause_is_no_break(void **state)
{
    (void)state;
    for (int64_t late_ms = 1; late_ms <= 128; late_ms *= 2) {
        struct stream s = stream_of(7812.5, 20.0, 0);
        (void)pass(&s, 0.5);
        s.line += 5e6 / s.line_us;
        const int64_t clock_us = clock_of(&s);
        (void)lum_clock_fit_add(s.fit, clock_us,
                                truth_of(&s, clock_us) + late_ms * MS);
        s.line += 1.0;
        (void)pass(&s, 2.0);
        const lum_clock_fit_info info = info_of(s.fit);
        assert_int_equal(info.sensor_breaks, 0);
        assert_int_equal(info.host_steps, 0);
        assert_int_equal(info.aside, 0);
        assert_true(llabs(s.time.utc_ns - s.truth_ns) <= s.time.error_ns);
        lum_clock_fit_free(s.fit);
    }
}

static void a_pause_is_bridged_by_the_drift(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 8 * MS);
    (void)pass(&s, 20.0);
    s.line += 30e6 / LINE_64_US;
    const struct seen seen = pass(&s, 3.0);
    assert_true(seen.worst_ns < 50 * US);
    assert_true(seen.beyond == 0.0);
    assert_int_equal(info_of(s.fit).sensor_breaks, 0);
    assert_int_equal(info_of(s.fit).host_steps, 0);
    lum_clock_fit_free(s.fit);
}

static void strays_are_set_aside(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 8 * MS);
    (void)pass(&s, 5.0);
    for (unsigned i = 0; i < 1000u; i++) {
        const int64_t off_us =
            (INT64_C(1) << (14u + i % 17u)) * (i % 2u == 0 ? 1 : -1);
        (void)lum_clock_fit_add(s.fit, clock_of(&s) + off_us,
                                arrival_of(&s, truth_of(&s, clock_of(&s))));
        const struct seen seen = pass(&s, 0.01);
        assert_true(seen.worst_ns < 60 * US);
    }
    const lum_clock_fit_info info = info_of(s.fit);
    assert_int_equal(info.sensor_breaks + info.host_steps, 0);
    assert_true(info.aside > 800);
    lum_clock_fit_free(s.fit);
}

/* Also where it comes again and again, or differs each time. */
static void strays_among_others_are_no_break(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 0.0, 0);
    (void)pass(&s, 5.0);
    for (int64_t i = 0; i < 100; i++) {
        (void)lum_clock_fit_add(s.fit, clock_of(&s) - 5000000,
                                arrival_of(&s, s.truth_ns));
        (void)pass(&s, 0.01);
    }
    for (int64_t i = 0; i < 100; i++) {
        (void)lum_clock_fit_add(s.fit,
                                clock_of(&s) + (i * i * 7919 + 5000) * 1000,
                                arrival_of(&s, s.truth_ns));
    }
    (void)pass(&s, 0.01);
    const lum_clock_fit_info info = info_of(s.fit);
    assert_int_equal(info.sensor_breaks + info.host_steps, 0);
    assert_int_equal(info.aside, 200);
    lum_clock_fit_free(s.fit);
}

static void a_longest_drive_goes_on_beyond_32_bits(void **state)
{
    (void)state;
    struct stream s = stream_of(300000.0, 50.0, 0);
    (void)pass(&s, 5000.0); /* the wire's clock wraps at 4,295 s */
    const struct seen seen = pass(&s, 100.0);
    assert_true(seen.worst_ns < 50 * US);
    assert_int_equal(info_of(s.fit).sensor_breaks, 0);
    lum_clock_fit_free(s.fit);
}

static void what_another_learned_holds_from_the_first_line(void **state)
{
    (void)state;
    struct stream ahead = stream_of(LINE_64_US, 50.0, 8 * MS);
    struct stream s = stream_of(LINE_64_US, 50.0, 8 * MS);
    (void)pass(&ahead, 4.0);
    lum_clock_fit_learn(s.fit, ahead.fit);
    (void)pass(&s, 4.0);
    assert_true(info_of(s.fit).error_ns >= info_of(ahead.fit).error_ns);
    assert_int_equal(info_of(s.fit).drift_ppb, info_of(ahead.fit).drift_ppb);
    lum_clock_fit_reset(s.fit);
    s.line = 0.0;
    lum_clock_fit_learn(s.fit, ahead.fit);
    const struct seen seen = pass(&s, 16.0);
    assert_true(seen.worst_ns < 50 * US);
    assert_true(seen.beyond == 0.0);
    assert_int_equal(info_of(s.fit).taken, 2 * (uint64_t)s.line);
    lum_clock_fit_reset(s.fit);
    assert_int_equal(lum_clock_fit_utc(s.fit, 0, &s.time), LUM_END);
    lum_clock_fit_free(s.fit);
    lum_clock_fit_free(ahead.fit);
}

static void nothing_is_learned_over_a_break(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 0.0, 0);
    lum_clock_fit *fit = lum_clock_fit_new();
    lum_clock_time time;
    (void)pass(&s, 1.0);
    s.host_ns += 5 * S;
    (void)pass(&s, 2.0);
    assert_int_equal(s.event, LUM_CLOCK_FIT_HOST_STEP);
    lum_clock_fit_learn(fit, s.fit);
    assert_int_equal(lum_clock_fit_utc(fit, 0, &time), LUM_END);
    lum_clock_fit_free(fit);
    lum_clock_fit_free(s.fit);
}

static void what_is_far_from_all_readings_is_not_answered(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 0.0, 0);
    lum_clock_time time = {1, 2};
    (void)pass(&s, 1.0);
    const int64_t newest = info_of(s.fit).newest_us;
    assert_int_equal(
        lum_clock_fit_utc(s.fit, newest + LUM_CLOCK_FIT_NEAR_US + 1, &time),
        LUM_E_VALUE);
    assert_int_equal(lum_clock_fit_utc(s.fit, INT64_MAX, &time), LUM_E_VALUE);
    assert_int_equal(lum_clock_fit_utc(s.fit, INT64_MIN, &time), LUM_E_VALUE);
    assert_true(time.utc_ns == 1 && time.error_ns == 2);
    assert_int_equal(
        lum_clock_fit_utc(s.fit, newest + LUM_CLOCK_FIT_NEAR_US, &time),
        LUM_OK);
    assert_int_equal(
        lum_clock_fit_utc(s.fit, newest - LUM_CLOCK_FIT_NEAR_US, &time),
        LUM_OK);
    lum_clock_fit_free(s.fit);
}

static void values_out_of_range_are_refused(void **state)
{
    (void)state;
    const int64_t c = LUM_CLOCK_FIT_CLOCK_MAX_US;
    const int64_t a = LUM_CLOCK_FIT_ARRIVAL_MAX_NS;
    const int64_t bad[][2] = {{c + 1, 0},     {-c - 1, 0},    {0, a + 1},
                              {0, -a - 1},    {INT64_MAX, 0}, {INT64_MIN, 0},
                              {0, INT64_MAX}, {0, INT64_MIN}};
    lum_clock_fit *fit = lum_clock_fit_new();
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(lum_clock_fit_add(fit, bad[i][0], bad[i][1]),
                         LUM_CLOCK_FIT_REFUSED);
    }
    assert_int_equal(lum_clock_fit_add(fit, c, -a), LUM_CLOCK_FIT_TAKEN);
    assert_int_equal(lum_clock_fit_add(fit, -c, a), LUM_CLOCK_FIT_ASIDE);
    lum_clock_fit_free(fit);
}

/* The sanitizers look on. */
static void any_readings_are_taken(void **state)
{
    (void)state;
    lum_clock_fit *fit = lum_clock_fit_new();
    lum_random random;
    lum_random_init(&random, 3, 9);
    int64_t clock_us = 0;
    int64_t arrival_ns = 0;
    for (unsigned i = 0; i < 300000u; i++) {
        const unsigned how = lum_random_below(&random, 8);
        const unsigned shift = lum_random_below(&random, 50);
        const int64_t us = (int64_t)(lum_random_next(&random) >> (63u - shift));
        clock_us = how == 0 ? us - (INT64_C(1) << 48) : clock_us + us % 300000;
        clock_us = how == 1 ? clock_us - us : clock_us;
        arrival_ns = how == 2 ? us * 4096 - (INT64_C(1) << 60)
                              : arrival_ns + us % 300000000;
        arrival_ns = how == 3 ? arrival_ns - us : arrival_ns;
        lum_clock_time time = {0, 0};
        (void)lum_clock_fit_add(fit, clock_us, arrival_ns);
        if (lum_clock_fit_utc(fit, clock_us, &time) == LUM_OK) {
            assert_true(time.error_ns >= 0);
        }
    }
    lum_clock_fit_free(fit);
}

static void stamps_that_never_change_do_no_harm(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_640_US, 0.0, 0);
    for (unsigned i = 0; i < 100000u; i++) {
        (void)lum_clock_fit_add(s.fit, 5, EPOCH + i * MS);
    }
    lum_clock_fit_reset(s.fit);
    for (unsigned i = 0; i < 100000u; i++) {
        lum_clock_time time;
        const int64_t clock_us = i * INT64_C(1000);
        (void)lum_clock_fit_add(s.fit, clock_us, EPOCH + 1234567);
        assert_int_equal(lum_clock_fit_utc(s.fit, clock_us, &time), LUM_OK);
        assert_true(time.error_ns == LUM_CLOCK_ERROR_UNKNOWN);
    }
    assert_true(info_of(s.fit).still > 99900u);
    assert_true(info_of(s.fit).error_ns == LUM_CLOCK_ERROR_UNKNOWN);
    assert_int_equal(info_of(s.fit).sensor_breaks + info_of(s.fit).host_steps,
                     0);
    lum_clock_fit_free(s.fit);
}

/* The last stamp may be right for as long as its error; then nobody knows. */
static void while_stamps_stand_still_the_error_is_not_known(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_64_US, 50.0, 0);
    (void)pass(&s, 5.0);
    const int64_t stamp_ns = truth_of(&s, clock_of(&s));
    for (unsigned i = 0; i < 640u; i++) {
        const int64_t clock_us = clock_of(&s);
        (void)lum_clock_fit_add(s.fit, clock_us, stamp_ns);
        assert_int_equal(lum_clock_fit_utc(s.fit, clock_us, &s.time), LUM_OK);
        assert_true(s.time.error_ns == LUM_CLOCK_ERROR_UNKNOWN ||
                    llabs(s.time.utc_ns - truth_of(&s, clock_us)) <=
                        s.time.error_ns);
        s.line += 1.0;
    }
    assert_true(s.time.error_ns == LUM_CLOCK_ERROR_UNKNOWN);
    assert_true(info_of(s.fit).still > 600u);
    const struct seen later = pass(&s, 2.0);
    assert_true(later.told_ns < MS && later.beyond == 0.0);
    lum_clock_fit_free(s.fit);
}

static void a_shorter_info_of_an_older_program_is_filled(void **state)
{
    (void)state;
    struct stream s = stream_of(LINE_640_US, 0.0, 0);
    (void)pass(&s, 1.0);
    lum_clock_fit_info info;
    memset(&info, 0x5a, sizeof info);
    info.struct_size = offsetof(lum_clock_fit_info, error_ns);
    const int64_t before = info.error_ns;
    assert_int_equal(lum_clock_fit_get_info(s.fit, &info), LUM_OK);
    assert_int_equal(info.struct_size, offsetof(lum_clock_fit_info, error_ns));
    assert_true(info.taken > 0 && info.error_ns == before);
    info.struct_size = 0;
    info.taken = 0;
    assert_int_equal(lum_clock_fit_get_info(s.fit, &info), LUM_E_VALUE);
    assert_true(info.taken == 0);
    lum_clock_fit_free(s.fit);
}

/* --- The line's error --- */

static int by_value(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a;
    const int64_t y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/* The error, said plainly: all in their order. */
static int64_t error_of_sorted(const struct lum_clock_window *w,
                               const struct lum_clock_line *line)
{
    int64_t late[LUM_CLOCK_BUCKETS];
    int64_t gap[LUM_CLOCK_BUCKETS];
    const size_t half = w->count / 2u;
    int64_t error = LUM_CLOCK_SPREAD_NS / w->batches / w->batches;
    for (size_t i = 0; i < w->count; i++) {
        late[i] = lum_clock_above(line, &w->list[i]->best);
        gap[i] = w->list[i]->gap_ns;
    }
    qsort(late, w->count, sizeof late[0], by_value);
    qsort(gap, w->count, sizeof gap[0], by_value);
    assert_int_equal(late[0], 0);
    for (size_t i = 1; i <= half && i < w->count; i++) {
        const int64_t wide = late[i] - late[i - 1u];
        error = wide > error ? wide : error;
    }
    const int64_t usual =
        6 * late[half] / (int64_t)(sqrt((double)w->count) + 1e-9);
    error = usual > error ? usual : error;
    error = gap[half] > error ? gap[half] : error;
    return error < 1000000000 ? error : 1000000000;
}

static void draw_window(lum_random *random, struct lum_clock_bucket *buckets,
                        struct lum_clock_window *out)
{
    static const uint32_t noises_ns[] = {1, 3, 20, 1000, 100000, 300000000};
    const uint32_t noise_ns = noises_ns[lum_random_below(random, 6)];
    const uint32_t most_ns = noises_ns[lum_random_below(random, 6)];
    const uint32_t spans = 1u + lum_random_below(random, LUM_CLOCK_BUCKETS);
    const uint32_t some = 1u + lum_random_below(random, 4);
    *out = (struct lum_clock_window){.batches = 1, .resolution_ns = 1000};
    for (uint32_t i = 0; i < spans; i++) {
        struct lum_clock_bucket *b = &buckets[i];
        const int64_t us = (int64_t)i * LUM_CLOCK_BUCKET_US +
                           lum_random_below(random, LUM_CLOCK_BUCKET_US);
        b->index = i;
        b->best = (struct lum_clock_reading){
            us, us * 1000 + us / 25000 + lum_random_below(random, noise_ns)};
        b->gap_ns = lum_random_below(random, most_ns);
        b->batches = lum_random_below(random, 3);
        if (lum_random_below(random, some) == 0 || i + 1u == spans) {
            out->list[out->count++] = b;
            out->batches += b->batches;
        }
    }
}

static void the_error_is_that_of_all_in_their_order(void **state)
{
    (void)state;
    lum_random random;
    lum_random_init(&random, 5, 1);
    for (int i = 0; i < 20000; i++) {
        struct lum_clock_bucket buckets[LUM_CLOCK_BUCKETS];
        struct lum_clock_window w;
        struct lum_clock_line line = {.drift_ppb = 0};
        draw_window(&random, buckets, &w);
        (void)lum_clock_lay(&w, -20000 * (i % 3), 500000, &line);
        assert_int_equal(line.error_ns, error_of_sorted(&w, &line));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(before_the_first_reading_nothing_is_known),
        cmocka_unit_test(the_first_reading_is_its_arrival_and_uncertain),
        cmocka_unit_test(
            an_even_stream_is_known_within_a_millisecond_of_its_begin),
        cmocka_unit_test(batches_and_drift_leave_less_than_50_us),
        cmocka_unit_test(the_error_that_is_told_is_honest),
        cmocka_unit_test(the_error_holds_for_99_of_100_frames),
        cmocka_unit_test(the_resolution_is_seen_in_the_stamps),
        cmocka_unit_test(around_a_step_the_error_is_not_known),
        cmocka_unit_test(a_small_step_is_in_the_error_soon),
        cmocka_unit_test(an_eye_that_is_always_later_is_no_batch),
        cmocka_unit_test(arrivals_that_leave_the_line_make_it_uncertain),
        cmocka_unit_test(a_drift_that_changes_slowly_is_followed),
        cmocka_unit_test(a_delay_that_all_have_cannot_be_seen),
        cmocka_unit_test(a_restart_of_the_sensor_begins_anew),
        cmocka_unit_test(a_step_of_the_hosts_clock_begins_anew),
        cmocka_unit_test(a_network_that_is_slow_for_a_moment_is_no_step),
        cmocka_unit_test(random_delays_are_no_steps),
        cmocka_unit_test(a_restart_after_a_pause_is_one_of_the_sensor),
        cmocka_unit_test(
            a_restart_within_the_first_second_is_one_of_the_sensor),
        cmocka_unit_test(a_step_between_lines_out_of_order_is_one_of_the_host),
        cmocka_unit_test(the_drift_is_known_over_a_break),
        cmocka_unit_test(
            a_clock_that_is_slewed_is_followed_and_the_error_grows),
        cmocka_unit_test(a_late_arrival_after_a_pause_is_no_break),
        cmocka_unit_test(a_pause_is_bridged_by_the_drift),
        cmocka_unit_test(strays_are_set_aside),
        cmocka_unit_test(strays_among_others_are_no_break),
        cmocka_unit_test(a_longest_drive_goes_on_beyond_32_bits),
        cmocka_unit_test(what_another_learned_holds_from_the_first_line),
        cmocka_unit_test(nothing_is_learned_over_a_break),
        cmocka_unit_test(what_is_far_from_all_readings_is_not_answered),
        cmocka_unit_test(values_out_of_range_are_refused),
        cmocka_unit_test(any_readings_are_taken),
        cmocka_unit_test(stamps_that_never_change_do_no_harm),
        cmocka_unit_test(while_stamps_stand_still_the_error_is_not_known),
        cmocka_unit_test(a_shorter_info_of_an_older_program_is_filled),
        cmocka_unit_test(the_error_is_that_of_all_in_their_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
