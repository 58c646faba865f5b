/* The sensor's clock to UTC: readings with their arrivals come in; each is
 * taken, set aside, or shows that a clock jumped; times with errors go out. */
#include "lum/frame/clock_fit.h"

#include "base/sized.h"
#include "clock_line.h"

#include <stdlib.h>
#include <string.h>

/* The largest difference of rates that is assumed before any measurement. */
#define DRIFT_KNOWN_PPB INT64_C(500000)

/* How much the drift may change over a break. */
#define CHANGE_PPB INT64_C(50000)

/* An arrival contradicts the line if it lies this far above its highest
 * possible place, or LUM_CLOCK_LOW_NS below its lowest. */
#define HIGH_NS INT64_C(250000000)

/* Contradictions agree if one is at most so much later than another. */
#define AGREE_NS INT64_C(250000000)

/* Readings this near to a step of the host's clock have no known time. */
#define STEP_NEAR_US 1000000

/* Readings come in about their order; packets arrive nearly in it. */
#define BACK_US  1000000
#define ORDER_US 20000

/* This many contradictions that agree are a break; if they are only late, they
 * also have to last this long. */
#define RUN_MIN 4u
#define RUN_US  1000000

/* Arrivals that contradict the line and agree among themselves. */
struct run {
    uint32_t count;
    bool is_sensor; /* its clock jumped; else the host's */
    int64_t first_us;
    struct lum_clock_reading best;
};

/* Whether the stamps go on. */
struct standstill {
    bool has_stamps; /* more than one */
    bool is_there;   /* the clock goes on, and stamps do not change */
    int64_t from_us; /* from here on that is so, with the last one's stamp */
};

/* The latest step of the host's clock. */
struct step {
    bool is_there;                /* since the last restart */
    int64_t at_us;                /* the first reading after it */
    struct lum_clock_line before; /* of readings before it */
};

struct lum_clock_fit {
    bool has_begun;
    bool has_drift; /* measured */
    struct lum_clock_arrivals arrivals;
    struct lum_clock_line line; /* under them */
    int64_t prior_ppb;          /* the drift, where it is not measured */
    int64_t prior_error_ppb;
    struct standstill standstill;
    struct run run;
    struct step step;
    uint64_t taken;
    uint64_t aside;
    uint64_t still;
    uint64_t sensor_breaks;
    uint64_t host_steps;
};

/* --- The line --- */

static int64_t find_error(const lum_clock_fit *fit,
                          const struct lum_clock_line *line, int64_t clock_us)
{
    return lum_clock_arrivals_error(&fit->arrivals, line, clock_us);
}

/* The line is laid anew, unless the one before is better: its drift was
 * measured before a gap, or before arrivals became uncertain, it still lies
 * under all arrivals, and its error now is no larger. */
static void refit(lum_clock_fit *fit)
{
    const int64_t now_us = fit->arrivals.newest.clock_us;
    struct lum_clock_line line = fit->line;
    struct lum_clock_window w;
    lum_clock_arrivals_look(&fit->arrivals, &w);
    const bool has_drift =
        lum_clock_lay(&w, fit->prior_ppb, fit->prior_error_ppb, &line);
    if (fit->has_drift && !has_drift && lum_clock_holds(&w, &fit->line) &&
        find_error(fit, &fit->line, now_us) <= find_error(fit, &line, now_us)) {
        return;
    }
    fit->has_drift = has_drift;
    fit->line = line;
}

static void know_drift_of_before(lum_clock_fit *fit)
{
    const int64_t error = fit->line.drift_error_ppb + CHANGE_PPB;
    if (fit->has_drift && error < DRIFT_KNOWN_PPB) {
        fit->prior_ppb = fit->line.drift_ppb;
        fit->prior_error_ppb = error;
    }
}

/* How long the stamp of a reading may stay: if this one came late, others with
 * it may come up to the line, and as much below it as that may be off. */
static void note_new_stamp(lum_clock_fit *fit,
                           const struct lum_clock_reading *r)
{
    const int64_t late_ns = lum_clock_above(&fit->line, r);
    fit->standstill.from_us =
        r->clock_us + (find_error(fit, &fit->line, r->clock_us) +
                       LUM_CLOCK_LOW_NS + (late_ns > 0 ? late_ns : 0)) /
                          1000;
}

/* The first reading of a new fit; the earlier drift is the starting value. */
static void begin(lum_clock_fit *fit, const struct lum_clock_reading *r,
                  unsigned count)
{
    know_drift_of_before(fit);
    lum_clock_arrivals_begin(&fit->arrivals, &fit->line, r);
    fit->has_begun = true;
    fit->has_drift = false;
    fit->run.count = 0;
    fit->taken += count;
    refit(fit);
    note_new_stamp(fit, r);
}

static void take(lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    if (r->arrival_ns != fit->arrivals.last.arrival_ns) {
        note_new_stamp(fit, r);
    }
    fit->run.count = 0;
    fit->taken++;
    if (lum_clock_arrivals_take(&fit->arrivals, &fit->line, r)) {
        refit(fit);
    }
}

/* --- Breaks of the sensor's clock and steps of the host's --- */

/* By how much a reading contradicts the line, below 0 if it is too early; 0: it
 * does not. */
static int64_t contradiction(const lum_clock_fit *fit,
                             const struct lum_clock_reading *r)
{
    const int64_t late_ns = lum_clock_above(&fit->line, r);
    const int64_t error_ns = find_error(fit, &fit->line, r->clock_us);
    if (late_ns < -error_ns - LUM_CLOCK_LOW_NS ||
        late_ns > error_ns + HIGH_NS) {
        return late_ns;
    }
    return 0;
}

/* Whose clock jumped.
 * 1. The sensor's, if it went back by more than packets are out of order.
 * 2. The sensor's, if it went back by less, and arrivals went on: it restarted
 *    soon after its start, and shows less than it was off.
 * 3. Else the one that moved further. */
static bool is_sensor(const lum_clock_fit *fit,
                      const struct lum_clock_reading *r)
{
    const int64_t us = r->clock_us - fit->arrivals.last.clock_us;
    const int64_t ns = r->arrival_ns - fit->arrivals.last.arrival_ns;
    return us < -BACK_US || (us < -ORDER_US && ns > 0) ||
           lum_clock_magnitude(us) * 1000 > lum_clock_magnitude(ns);
}

static bool agrees(const lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    return fit->run.count > 0 &&
           lum_clock_magnitude(lum_clock_lateness(
               &fit->run.best, r, fit->line.drift_ppb)) <= AGREE_NS;
}

/* Readings from before a restart look like later ones. Those from before a step
 * do not, and callers may still ask for them. */
static void note_break(lum_clock_fit *fit, const struct run *run)
{
    const int64_t newest_us = fit->arrivals.newest.clock_us;
    fit->sensor_breaks += run->is_sensor ? 1u : 0u;
    fit->host_steps += run->is_sensor ? 0u : 1u;
    fit->step = (struct step){!run->is_sensor, run->first_us, fit->line};
    fit->step.before.error_ns = lum_clock_smaller(
        fit->line.error_ns +
            lum_clock_arrivals_later(&fit->arrivals, &fit->line, newest_us),
        LUM_CLOCK_NS_MAX);
}

/* A reading contradicts the line.
 * 1. If it does not agree with the contradictions before it, they were damaged
 *    packets, and it is the first of others.
 * 2. Few of them are set aside; so are those that are only late, for a second:
 *    the network may be slow for a moment.
 * 3. Else a clock jumped: a new fit begins with the earliest of them. */
static lum_clock_fit_event set_aside(lum_clock_fit *fit,
                                     const struct lum_clock_reading *r,
                                     int64_t late_ns)
{
    struct run *run = &fit->run;
    if (!agrees(fit, r)) {
        *run = (struct run){.is_sensor = is_sensor(fit, r),
                            .first_us = r->clock_us,
                            .best = *r};
    }
    run->count++;
    if (lum_clock_lateness(&run->best, r, fit->line.drift_ppb) < 0) {
        run->best = *r;
    }
    if (run->count < RUN_MIN || (!run->is_sensor && late_ns > 0 &&
                                 r->clock_us - run->first_us < RUN_US)) {
        fit->aside++;
        return LUM_CLOCK_FIT_ASIDE;
    }
    const bool is_of_sensor = run->is_sensor;
    const struct lum_clock_reading first = run->best;
    note_break(fit, run);
    fit->aside -= run->count - 1u;
    begin(fit, &first, run->count);
    return is_of_sensor ? LUM_CLOCK_FIT_SENSOR_BREAK : LUM_CLOCK_FIT_HOST_STEP;
}

/* --- Readings come --- */

lum_clock_fit *lum_clock_fit_new(void)
{
    lum_clock_fit *fit = malloc(sizeof *fit);
    if (fit != NULL) {
        lum_clock_fit_reset(fit);
    }
    return fit;
}

void lum_clock_fit_free(lum_clock_fit *fit)
{
    free(fit);
}

void lum_clock_fit_reset(lum_clock_fit *fit)
{
    memset(fit, 0, sizeof *fit);
    fit->prior_error_ppb = DRIFT_KNOWN_PPB;
}

void lum_clock_fit_learn(lum_clock_fit *to, const lum_clock_fit *from)
{
    if (from->sensor_breaks == 0 && from->host_steps == 0) {
        *to = *from;
        to->taken = 0;
        to->aside = 0;
        to->still = 0;
    }
}

void lum_clock_fit_note_stamp(lum_clock_fit *fit, int64_t arrival_ns)
{
    lum_clock_arrivals_note_stamp(&fit->arrivals, arrival_ns);
}

/* Whether the clock has gone on for longer than a stamp may stay. */
static bool note_standstill(struct standstill *s, bool is_same_stamp,
                            int64_t clock_us)
{
    s->has_stamps |= !is_same_stamp;
    s->is_there = is_same_stamp && (s->is_there || clock_us > s->from_us);
    return s->is_there;
}

lum_clock_fit_event lum_clock_fit_add(lum_clock_fit *fit, int64_t clock_us,
                                      int64_t arrival_ns)
{
    const struct lum_clock_reading r = {clock_us, arrival_ns};
    if (!lum_clock_is_possible(&r)) {
        return LUM_CLOCK_FIT_REFUSED;
    }
    lum_clock_fit_note_stamp(fit, arrival_ns);
    if (!fit->has_begun) {
        begin(fit, &r, 1);
        return LUM_CLOCK_FIT_TAKEN;
    }
    if (note_standstill(&fit->standstill,
                        arrival_ns == fit->arrivals.last.arrival_ns,
                        clock_us)) {
        fit->still++;
        fit->aside++;
        return LUM_CLOCK_FIT_ASIDE;
    }
    const int64_t late_ns = contradiction(fit, &r);
    if (late_ns != 0) {
        return set_aside(fit, &r, late_ns);
    }
    take(fit, &r);
    return LUM_CLOCK_FIT_TAKEN;
}

/* --- As bytes --- */

static void pack_run(lum_pack *p, struct run *run,
                     const struct lum_clock_reading *near)
{
    lum_pack_u32(p, &run->count);
    lum_pack_bool(p, &run->is_sensor);
    lum_pack_i64(p, &run->first_us);
    (void)lum_pack_check(
        p, lum_clock_is_within(run->first_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
               run->count < RUN_MIN * (uint32_t)RUN_US);
    lum_clock_reading_pack(p, &run->best, near);
}

bool lum_clock_fit_pack(lum_clock_fit *fit, lum_pack *pack)
{
    const struct lum_clock_reading *near = &fit->arrivals.newest;
    lum_pack_bool(pack, &fit->has_begun);
    if (!fit->has_begun) {
        return !pack->has_failed;
    }
    lum_pack_bool(pack, &fit->has_drift);
    lum_pack_bool(pack, &fit->step.is_there);
    lum_clock_arrivals_pack(&fit->arrivals, pack);
    lum_pack_bool(pack, &fit->standstill.has_stamps);
    lum_pack_bool(pack, &fit->standstill.is_there);
    lum_pack_i64(pack, &fit->standstill.from_us);
    lum_clock_line_pack(pack, &fit->line, near);
    lum_clock_pack_limited(pack, &fit->prior_ppb, LUM_CLOCK_PPB_MAX);
    lum_clock_pack_limited(pack, &fit->prior_error_ppb, LUM_CLOCK_PPB_MAX);
    pack_run(pack, &fit->run, near);
    lum_clock_pack_limited(pack, &fit->step.at_us, LUM_CLOCK_FIT_CLOCK_MAX_US);
    lum_clock_line_pack(pack, &fit->step.before, near);
    lum_pack_u64(pack, &fit->taken);
    lum_pack_u64(pack, &fit->aside);
    lum_pack_u64(pack, &fit->still);
    lum_pack_u64(pack, &fit->sensor_breaks);
    lum_pack_u64(pack, &fit->host_steps);
    lum_clock_arrivals_pack_buckets(&fit->arrivals, pack);
    return !pack->has_failed;
}

/* --- What it tells --- */

/* How a reading becomes a time. */
struct answer {
    struct lum_clock_line line;
    int64_t near_us;  /* a reading nearby */
    int64_t later_ns; /* by which the truth may be later than the line */
};

static struct answer answer_of(const lum_clock_fit *fit, int64_t clock_us)
{
    const struct run *run = &fit->run;
    struct answer a = {.line = fit->line,
                       .near_us = fit->standstill.is_there
                                      ? clock_us
                                      : fit->arrivals.newest.clock_us};
    if (run->count > 0 && run->is_sensor &&
        lum_clock_magnitude(clock_us - run->first_us) <
            lum_clock_magnitude(clock_us - a.near_us)) {
        a.near_us = run->first_us;
        a.line.at = run->best;
        a.line.from_us = run->first_us;
        a.line.to_us = run->first_us;
        a.line.error_ns = LUM_CLOCK_SPREAD_NS;
    } else if (fit->step.is_there && clock_us < fit->step.at_us) {
        a.line = fit->step.before;
    } else {
        a.later_ns =
            lum_clock_arrivals_later(&fit->arrivals, &fit->line, clock_us);
    }
    return a;
}

static bool is_near(int64_t clock_us, int64_t other_us)
{
    return lum_clock_magnitude(clock_us - other_us) <= STEP_NEAR_US;
}

/* Whether the time nearby is not known: stamps stand still, or only one has
 * come, or the host's clock was stepped, or that seems so; a single reading
 * that contradicts the line is no step. */
static bool is_unknown(const lum_clock_fit *fit, int64_t clock_us)
{
    const struct run *run = &fit->run;
    return fit->standstill.is_there || !fit->standstill.has_stamps ||
           (fit->step.is_there && is_near(clock_us, fit->step.at_us)) ||
           (run->count > 1 && !run->is_sensor &&
            clock_us > run->first_us - STEP_NEAR_US);
}

static int64_t error_of(const lum_clock_fit *fit, const struct answer *a,
                        int64_t clock_us)
{
    return is_unknown(fit, clock_us)
               ? LUM_CLOCK_ERROR_UNKNOWN
               : lum_clock_error(&a->line, clock_us) +
                     lum_clock_arrivals_resolution(&fit->arrivals) +
                     a->later_ns;
}

lum_result lum_clock_fit_utc(const lum_clock_fit *fit, int64_t clock_us,
                             lum_clock_time *out)
{
    if (!fit->has_begun) {
        return LUM_END;
    }
    if (!lum_clock_is_within(clock_us, LUM_CLOCK_FIT_CLOCK_MAX_US)) {
        return LUM_E_VALUE;
    }
    const struct answer a = answer_of(fit, clock_us);
    if (lum_clock_magnitude(clock_us - a.near_us) > LUM_CLOCK_FIT_NEAR_US) {
        return LUM_E_VALUE;
    }
    const int64_t us = clock_us - a.line.at.clock_us;
    out->utc_ns = a.line.at.arrival_ns + us * 1000 +
                  lum_clock_scale(us, a.line.drift_ppb);
    out->error_ns = error_of(fit, &a, clock_us);
    return LUM_OK;
}

lum_result lum_clock_fit_get_info(const lum_clock_fit *fit,
                                  lum_clock_fit_info *out)
{
    lum_clock_fit_info info = {.struct_size = sizeof info,
                               .taken = fit->taken,
                               .aside = fit->aside,
                               .sensor_breaks = fit->sensor_breaks,
                               .host_steps = fit->host_steps};
    if (fit->has_begun) {
        info.newest_us = fit->arrivals.newest.clock_us;
        info.error_ns = is_unknown(fit, info.newest_us)
                            ? LUM_CLOCK_ERROR_UNKNOWN
                            : find_error(fit, &fit->line, info.newest_us);
        info.has_drift = fit->has_drift;
        info.drift_ppb = (int32_t)fit->line.drift_ppb;
        info.drift_error_ppb = (int32_t)fit->line.drift_error_ppb;
        info.resolution_ns = lum_clock_arrivals_resolution(&fit->arrivals);
        info.still = fit->still;
    }
    if (!lum_sized_fill(out, &info, sizeof info)) {
        return LUM_E_VALUE;
    }
    return fit->has_begun ? LUM_OK : LUM_END;
}
