#include "lum/host/clock_sync.h"

#include "lum/clock.h"

#define PPB            INT64_C(1000000000)
#define STEP_NS        INT64_C(1000) /* of the sensor's clock */
#define ROUND_TRIP_MAX INT64_C(3600000000000)
#define HALF_WRAP_NS   (INT64_C(0x80000000) * STEP_NS)

/* Clocks differ by 500 ppm at most; a crystal's rate wanders by 1 ppm. */
#define DRIFT_MAX_PPB INT64_C(500000)
#define WANDER_PPB    INT64_C(1000)

/* What four divisions lose. */
#define ROUNDING_NS 4

/* An entry of the ring that holds nothing. */
#define NOTHING INT64_MAX

static int64_t magnitude(int64_t x)
{
    return x < 0 ? -x : x;
}

/* a - b modulo 2^64, for differences that fit though their terms may not. */
static int64_t difference(uint64_t a, uint64_t b)
{
    const uint64_t d = a - b;
    return d <= (uint64_t)INT64_MAX ? (int64_t)d : -(int64_t)~d - 1;
}

/* later - earlier, at most INT64_MAX either way. */
static int64_t elapsed(int64_t earlier, int64_t later)
{
    if (earlier < 0 && later > INT64_MAX + earlier) {
        return INT64_MAX;
    }
    if (earlier >= 0 && later < earlier - INT64_MAX) {
        return -INT64_MAX;
    }
    return later - earlier;
}

/* ns x ppb / 10^9; |ppb| at most 10^6. */
static int64_t scale(int64_t ns, int64_t ppb)
{
    return ns / PPB * ppb + ns % PPB * ppb / PPB;
}

/* part / whole in ppb, towards 0; |part| < whole / 1000. */
static int64_t ratio(int64_t part, int64_t whole)
{
    int64_t ppb = 0;
    while (whole > INT64_MAX / 1000) {
        whole /= 2;
        part /= 2;
    }
    for (int digits = 0; digits < 3; digits++) {
        part *= 1000;
        ppb = ppb * 1000 + part / whole;
        part %= whole;
    }
    return ppb;
}

static void forget(lum_clock_sync *sync)
{
    for (unsigned i = 0; i < LUM_CLOCK_EXCHANGES; i++) {
        sync->recent[i] = (lum_clock_exchange){0, 0, NOTHING};
    }
    sync->anchor = sync->recent[0];
}

void lum_clock_sync_init(lum_clock_sync *out)
{
    forget(out);
    out->clock_us = 0;
    out->middle_ns = 0;
    out->count = 0;
    out->resets = 0;
}

static const lum_clock_exchange *last_of(const lum_clock_sync *sync)
{
    return &sync->recent[(sync->count - 1u) % LUM_CLOCK_EXCHANGES];
}

/* The place in the ring depends on the count, so the count grows by whole
 * rings. */
static void keep(lum_clock_sync *sync, const lum_clock_exchange *e)
{
    sync->recent[sync->count % LUM_CLOCK_EXCHANGES] = *e;
    sync->middle_ns = e->middle_ns;
    sync->count = sync->count == UINT32_MAX
                      ? UINT32_MAX - LUM_CLOCK_EXCHANGES + 1u
                      : sync->count + 1u;
    const bool is_early =
        sync->count <= LUM_CLOCK_EXCHANGES || sync->anchor.error_ns == NOTHING;
    if (is_early && e->error_ns < sync->anchor.error_ns) {
        sync->anchor = *e;
    }
}

static void set_offset(lum_clock_exchange *e, int64_t clock_us)
{
    e->offset_ns = difference((uint64_t)e->middle_ns,
                              (uint64_t)clock_us * (uint64_t)STEP_NS);
}

/* Takes a reading that may be any number of wraps after the last. */
static void follow(lum_clock_sync *sync, lum_clock_exchange *e, uint32_t raw)
{
    const lum_clock_exchange *last = last_of(sync);
    const int64_t passed = elapsed(last->middle_ns, e->middle_ns);
    const int64_t slack =
        last->error_ns + e->error_ns + scale(magnitude(passed), DRIFT_MAX_PPB);
    const uint64_t about_us = (uint64_t)(sync->clock_us + passed / STEP_NS);
    const int64_t clock_us =
        lum_clock_us(lum_clock_extend(about_us, raw, 32), STEP_NS);
    set_offset(e, clock_us);
    const int64_t jump = magnitude(elapsed(last->offset_ns, e->offset_ns));
    sync->clock_us = clock_us;
    if (jump > slack + LUM_CLOCK_RESET_NS) {
        sync->resets++;
        sync->count = 0;
        sync->clock_us = raw;
        set_offset(e, raw);
    }
    if (jump > slack || slack >= HALF_WRAP_NS) {
        forget(sync);
    }
}

lum_result lum_clock_sync_add(lum_clock_sync *sync, int64_t sent_ns,
                              int64_t received_ns, uint32_t clock_us)
{
    if (received_ns < sent_ns ||
        elapsed(sent_ns, received_ns) > ROUND_TRIP_MAX) {
        return LUM_E_VALUE;
    }
    const int64_t half = (received_ns - sent_ns) / 2;
    lum_clock_exchange e = {.middle_ns = sent_ns + half,
                            .error_ns = half + 1 + STEP_NS +
                                        scale(half, DRIFT_MAX_PPB)};
    if (sync->count > 0) {
        follow(sync, &e, clock_us);
    } else {
        sync->clock_us = clock_us;
        set_offset(&e, clock_us);
    }
    keep(sync, &e);
    return LUM_OK;
}

/* The drift between two exchanges; its bound is that of (change +- error) /
 * (sensor_ns -+ error). False if it is no better than what is known of any
 * clock. */
static bool drift_between(const lum_clock_exchange *from,
                          const lum_clock_exchange *to, int64_t *drift_ppb,
                          int64_t *error_ppb)
{
    const int64_t host_ns = elapsed(from->middle_ns, to->middle_ns);
    if (to->error_ns == NOTHING || host_ns > INT64_MAX / 2) {
        return false;
    }
    const int64_t error = from->error_ns + to->error_ns;
    const int64_t change = to->offset_ns - from->offset_ns;
    const int64_t sensor_ns = host_ns - change;
    if (sensor_ns / 2000 <= error || sensor_ns / 1000 <= magnitude(change)) {
        return false;
    }
    const int64_t bound = ratio(error, sensor_ns - error);
    *drift_ppb = ratio(change, sensor_ns);
    *error_ppb = bound + bound / 500 + 3;
    return true;
}

static void find_drift(const lum_clock_sync *sync, lum_clock_estimate *out)
{
    int64_t drift = 0;
    int64_t error = 0;
    for (unsigned i = 0; i < LUM_CLOCK_EXCHANGES; i++) {
        if (drift_between(&sync->anchor, &sync->recent[i], &drift, &error) &&
            (!out->has_drift || error < out->drift_error_ppb)) {
            out->has_drift = true;
            out->drift_ppb = (int32_t)drift;
            out->drift_error_ppb = (int32_t)error;
        }
    }
}

/* The exchange that gives the most exact time of the last one. */
static void find_offset(const lum_clock_sync *sync, lum_clock_estimate *out)
{
    const int64_t rate_error =
        out->has_drift ? out->drift_error_ppb + WANDER_PPB : DRIFT_MAX_PPB;
    out->error_ns = NOTHING;
    for (unsigned i = 0; i < LUM_CLOCK_EXCHANGES; i++) {
        const lum_clock_exchange *e = &sync->recent[i];
        if (e->error_ns == NOTHING) {
            continue;
        }
        const int64_t age = elapsed(e->middle_ns, sync->middle_ns);
        const int64_t error = e->error_ns + scale(magnitude(age), rate_error) +
                              (age != 0 ? ROUNDING_NS : 0);
        if (error < out->error_ns) {
            const int64_t sensor_age = age - scale(age, out->drift_ppb);
            out->error_ns = error;
            out->offset_ns = e->offset_ns + scale(sensor_age, out->drift_ppb);
        }
    }
}

lum_result lum_clock_sync_estimate(const lum_clock_sync *sync,
                                   lum_clock_estimate *out)
{
    if (sync->count == 0) {
        return LUM_END;
    }
    lum_clock_estimate estimate = {.clock_us = sync->clock_us,
                                   .exchanges = sync->count,
                                   .resets = sync->resets};
    find_drift(sync, &estimate);
    find_offset(sync, &estimate);
    *out = estimate;
    return LUM_OK;
}
