#include "lum/frame/clock_fit.h"

#include "base/sized.h"
#include "clock_line.h"

#include <stdlib.h>
#include <string.h>

#define MS_NS INT64_C(1000000)
#define PPM   INT64_C(1000)

/* The largest difference of rates that is assumed before any measurement. */
#define DRIFT_KNOWN_PPB (500 * PPM)

/* How much the drift may change over a break. */
#define CHANGE_PPB (50 * PPM)

/* Arrivals that differ by less than this count as equally late. */
#define SAME_NS 5000

/* An arrival contradicts the line if it lies this far below its lowest possible
 * place, or this far above. */
#define LOW_NS  MS_NS
#define HIGH_NS (250 * MS_NS)

/* This many contradictions that agree are a break; if they are only late, they
 * also have to last this long. */
#define RUN_MIN  4u
#define RUN_US   1000000
#define AGREE_NS (250 * MS_NS)

/* Readings come in about their order; packets arrive nearly in it. */
#define BACK_US  1000000
#define ORDER_US 20000

/* Arrivals that contradict the line and agree among themselves. */
struct run {
    unsigned count;
    bool is_sensor; /* its clock jumped; else the host's */
    int64_t first_us;
    struct lum_clock_reading best;
};

struct lum_clock_fit {
    bool has_begun;
    bool has_drift; /* measured */
    struct lum_clock_bucket buckets[LUM_CLOCK_BUCKETS];
    struct lum_clock_reading newest;
    struct lum_clock_reading last; /* in order of arrival */
    struct lum_clock_line line;
    int64_t prior_ppb; /* the drift, where it is not measured */
    int64_t prior_error_ppb;
    struct run run;
    bool has_stepped;             /* the host's clock, since the last restart */
    int64_t step_us;              /* the first reading after that */
    struct lum_clock_line before; /* of readings before it */
    uint64_t taken;
    uint64_t aside;
    uint64_t sensor_breaks;
    uint64_t host_steps;
};

/* --- The window of readings --- */

static int64_t magnitude(int64_t x)
{
    return x < 0 ? -x : x;
}

static int64_t index_of(int64_t clock_us)
{
    const int64_t towards_0 = clock_us / LUM_CLOCK_BUCKET_US;
    return clock_us % LUM_CLOCK_BUCKET_US < 0 ? towards_0 - 1 : towards_0;
}

static struct lum_clock_bucket *slot_of(lum_clock_fit *fit, int64_t index)
{
    return &fit->buckets[(uint64_t)index % LUM_CLOCK_BUCKETS];
}

static void look(const lum_clock_fit *fit, struct lum_clock_window *out)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    out->count = 0;
    out->batches = 1;
    for (int64_t i = newest - LUM_CLOCK_BUCKETS + 1; i <= newest; i++) {
        const struct lum_clock_bucket *b =
            &fit->buckets[(uint64_t)i % LUM_CLOCK_BUCKETS];
        if (b->index == i) {
            out->list[out->count++] = b;
            out->batches += b->batches;
        }
    }
}

static void refit(lum_clock_fit *fit)
{
    const int64_t now_us = fit->newest.clock_us;
    struct lum_clock_line line = fit->line;
    struct lum_clock_window w;
    look(fit, &w);
    const bool has_drift =
        lum_clock_lay(&w, fit->prior_ppb, fit->prior_error_ppb, &line);
    /* What was known before a gap, or before arrivals became uncertain. */
    if (fit->has_drift && !has_drift && lum_clock_holds(&w, &fit->line)) {
        lum_clock_look_back(&w, &fit->line);
        if (lum_clock_error(&fit->line, now_us) <=
            lum_clock_error(&line, now_us)) {
            return;
        }
    }
    fit->has_drift = has_drift;
    fit->line = line;
}

/* A reading that does not arrive together with the one before ends a batch. */
static bool ends_batch(const struct lum_clock_reading *last,
                       const struct lum_clock_reading *r)
{
    const int64_t us = r->clock_us - last->clock_us;
    return us > 0 && r->arrival_ns - last->arrival_ns >= us * 500;
}

static void put(lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    const int64_t index = index_of(r->clock_us);
    const int64_t drift_ppb = fit->line.drift_ppb;
    struct lum_clock_bucket *b = slot_of(fit, index);
    if (b->index != index) {
        *b = (struct lum_clock_bucket){
            .index = index, .best = *r, .next_ns = LUM_CLOCK_NOTHING};
    }
    const int64_t late_ns = lum_clock_lateness(&b->best, r, drift_ppb);
    if (late_ns < 0) {
        b->next_ns = late_ns <= -SAME_NS ? -late_ns : b->next_ns;
        b->best = *r;
    } else if (late_ns >= SAME_NS && late_ns < b->next_ns &&
               r->clock_us != fit->last.clock_us) {
        /* The eyes' lines have one clock, and one comes after the other. */
        b->next_ns = late_ns;
    }
    b->batches += ends_batch(&fit->last, r) ? 1u : 0u;
}

static void know_drift_of_before(lum_clock_fit *fit)
{
    const int64_t error = fit->line.drift_error_ppb + CHANGE_PPB;
    if (fit->has_drift && error < DRIFT_KNOWN_PPB) {
        fit->prior_ppb = fit->line.drift_ppb;
        fit->prior_error_ppb = error;
    }
}

/* The first reading of a new fit; the earlier drift is the starting value. */
static void begin(lum_clock_fit *fit, const struct lum_clock_reading *r,
                  unsigned count)
{
    for (size_t i = 0; i < LUM_CLOCK_BUCKETS; i++) {
        fit->buckets[i].index = LUM_CLOCK_NOTHING;
    }
    know_drift_of_before(fit);
    fit->has_begun = true;
    fit->has_drift = false;
    fit->run.count = 0;
    fit->newest = *r;
    fit->last = *r;
    fit->taken += count;
    put(fit, r);
    refit(fit);
}

static void take(lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    const int64_t index = index_of(r->clock_us);
    fit->run.count = 0;
    fit->taken++;
    if (index <= newest - LUM_CLOCK_BUCKETS) {
        return;
    }
    put(fit, r);
    fit->last = *r;
    if (r->clock_us > fit->newest.clock_us) {
        fit->newest = *r;
    }
    if (index > newest ||
        lum_clock_above(&fit->line, r) < -LUM_CLOCK_SLACK_NS) {
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
    const int64_t error_ns = lum_clock_error(&fit->line, r->clock_us);
    if (late_ns < -error_ns - LOW_NS || late_ns > error_ns + HIGH_NS) {
        return late_ns;
    }
    return 0;
}

/* Whose clock jumped: the one that moved further, but the sensor's where it
 * went back while arrivals went on. A sensor that restarts soon after its start
 * goes back by less than it is off. */
static bool is_sensor(const lum_clock_fit *fit,
                      const struct lum_clock_reading *r)
{
    const int64_t us = r->clock_us - fit->last.clock_us;
    const int64_t ns = r->arrival_ns - fit->last.arrival_ns;
    return us < -BACK_US || (us < -ORDER_US && ns > 0) ||
           magnitude(us) * 1000 > magnitude(ns);
}

static bool agrees(const lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    return fit->run.count > 0 &&
           magnitude(lum_clock_lateness(&fit->run.best, r,
                                        fit->line.drift_ppb)) <= AGREE_NS;
}

/* Readings from before a restart look like later ones. Those from before a step
 * do not, and callers may still ask for them. */
static void note_break(lum_clock_fit *fit, const struct run *run)
{
    fit->sensor_breaks += run->is_sensor ? 1u : 0u;
    fit->host_steps += run->is_sensor ? 0u : 1u;
    fit->has_stepped = !run->is_sensor;
    fit->step_us = run->first_us;
    fit->before = fit->line;
}

/* A reading that contradicts the line. Several of them show a break; a single
 * one is a damaged packet. */
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

/* --- Its life --- */

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
    }
}

lum_clock_fit_event lum_clock_fit_add(lum_clock_fit *fit, int64_t clock_us,
                                      int64_t arrival_ns)
{
    const struct lum_clock_reading r = {clock_us, arrival_ns};
    if (clock_us > LUM_CLOCK_FIT_CLOCK_MAX_US ||
        clock_us < -LUM_CLOCK_FIT_CLOCK_MAX_US ||
        arrival_ns > LUM_CLOCK_FIT_ARRIVAL_MAX_NS ||
        arrival_ns < -LUM_CLOCK_FIT_ARRIVAL_MAX_NS) {
        return LUM_CLOCK_FIT_REFUSED;
    }
    if (!fit->has_begun) {
        begin(fit, &r, 1);
        return LUM_CLOCK_FIT_TAKEN;
    }
    const int64_t late_ns = contradiction(fit, &r);
    if (late_ns != 0) {
        return set_aside(fit, &r, late_ns);
    }
    take(fit, &r);
    return LUM_CLOCK_FIT_TAKEN;
}

/* --- As bytes --- */

/* Far above all that is measured, and sums of them fit. */
#define NS_MAX  (INT64_C(1) << 61)
#define PPB_MAX INT64_C(1000000000)

static bool is_within(int64_t x, int64_t most)
{
    return x >= -most && x <= most;
}

static void pack_reading(lum_pack *p, struct lum_clock_reading *r,
                         const struct lum_clock_reading *near)
{
    lum_pack_near(p, &r->clock_us, near->clock_us);
    lum_pack_near(p, &r->arrival_ns, near->arrival_ns);
    (void)lum_pack_check(
        p, is_within(r->clock_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
               is_within(r->arrival_ns, LUM_CLOCK_FIT_ARRIVAL_MAX_NS));
}

static void pack_limited(lum_pack *p, int64_t *value, int64_t most)
{
    lum_pack_i64(p, value);
    (void)lum_pack_check(p, is_within(*value, most));
}

static void pack_line(lum_pack *p, struct lum_clock_line *line,
                      const struct lum_clock_reading *near)
{
    pack_reading(p, &line->at, near);
    pack_limited(p, &line->drift_ppb, PPB_MAX);
    pack_limited(p, &line->drift_error_ppb, PPB_MAX);
    lum_pack_near(p, &line->from_us, line->at.clock_us);
    lum_pack_near(p, &line->to_us, line->at.clock_us);
    pack_limited(p, &line->error_ns, NS_MAX);
    pack_limited(p, &line->recent_ns, NS_MAX);
    (void)lum_pack_check(
        p, is_within(line->from_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
               is_within(line->to_us, LUM_CLOCK_FIT_CLOCK_MAX_US));
}

/* Its place follows from its reading. */
static void pack_bucket(lum_pack *p, struct lum_clock_bucket *b,
                        const struct lum_clock_reading *near)
{
    bool is_used = b->index != LUM_CLOCK_NOTHING;
    bool has_next = b->next_ns != LUM_CLOCK_NOTHING;
    lum_pack_bool(p, &is_used);
    if (!is_used) {
        b->index = LUM_CLOCK_NOTHING;
        return;
    }
    pack_reading(p, &b->best, near);
    b->index = index_of(b->best.clock_us);
    lum_pack_bool(p, &has_next);
    if (has_next) {
        pack_limited(p, &b->next_ns, NS_MAX);
    } else {
        b->next_ns = LUM_CLOCK_NOTHING;
    }
    lum_pack_u32(p, &b->batches);
}

static void pack_run(lum_pack *p, struct run *run,
                     const struct lum_clock_reading *near)
{
    uint32_t count = run->count;
    lum_pack_u32(p, &count);
    run->count = count;
    lum_pack_bool(p, &run->is_sensor);
    lum_pack_i64(p, &run->first_us);
    (void)lum_pack_check(p,
                         is_within(run->first_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
                             count < RUN_MIN * (uint32_t)RUN_US);
    pack_reading(p, &run->best, near);
}

static void pack_window(lum_clock_fit *fit, lum_pack *p)
{
    for (size_t i = 0; i < LUM_CLOCK_BUCKETS && !p->has_failed; i++) {
        pack_bucket(p, &fit->buckets[i], &fit->newest);
    }
    /* The bucket of the newest reading is in use. */
    const int64_t newest = index_of(fit->newest.clock_us);
    (void)lum_pack_check(p, slot_of(fit, newest)->index == newest);
}

bool lum_clock_fit_pack(lum_clock_fit *fit, lum_pack *pack)
{
    static const struct lum_clock_reading zero = {0, 0};
    lum_pack *p = pack;
    lum_pack_bool(p, &fit->has_begun);
    if (!fit->has_begun) {
        return !p->has_failed;
    }
    lum_pack_bool(p, &fit->has_drift);
    lum_pack_bool(p, &fit->has_stepped);
    pack_reading(p, &fit->newest, &zero);
    pack_reading(p, &fit->last, &fit->newest);
    pack_line(p, &fit->line, &fit->newest);
    pack_limited(p, &fit->prior_ppb, PPB_MAX);
    pack_limited(p, &fit->prior_error_ppb, PPB_MAX);
    pack_run(p, &fit->run, &fit->newest);
    pack_limited(p, &fit->step_us, LUM_CLOCK_FIT_CLOCK_MAX_US);
    pack_line(p, &fit->before, &fit->newest);
    lum_pack_u64(p, &fit->taken);
    lum_pack_u64(p, &fit->aside);
    lum_pack_u64(p, &fit->sensor_breaks);
    lum_pack_u64(p, &fit->host_steps);
    pack_window(fit, p);
    return !p->has_failed;
}

/* --- What it tells --- */

/* The line that applies to a reading, and a reading nearby. */
static struct lum_clock_line line_of(const lum_clock_fit *fit, int64_t clock_us,
                                     int64_t *near_us)
{
    const struct run *run = &fit->run;
    struct lum_clock_line line = fit->line;
    *near_us = fit->newest.clock_us;
    if (run->count > 0 && run->is_sensor &&
        magnitude(clock_us - run->first_us) < magnitude(clock_us - *near_us)) {
        *near_us = run->first_us;
        line.at = run->best;
        line.from_us = run->first_us;
        line.to_us = run->first_us;
        line.error_ns = LUM_CLOCK_SPREAD_NS;
    } else if (fit->has_stepped && clock_us < fit->step_us) {
        line = fit->before;
    }
    return line;
}

lum_result lum_clock_fit_utc(const lum_clock_fit *fit, int64_t clock_us,
                             lum_clock_time *out)
{
    int64_t near_us = 0;
    if (!fit->has_begun) {
        return LUM_END;
    }
    if (clock_us > LUM_CLOCK_FIT_CLOCK_MAX_US ||
        clock_us < -LUM_CLOCK_FIT_CLOCK_MAX_US) {
        return LUM_E_VALUE;
    }
    const struct lum_clock_line line = line_of(fit, clock_us, &near_us);
    if (magnitude(clock_us - near_us) > LUM_CLOCK_FIT_NEAR_US) {
        return LUM_E_VALUE;
    }
    const int64_t us = clock_us - line.at.clock_us;
    out->utc_ns =
        line.at.arrival_ns + us * 1000 + lum_clock_scale(us, line.drift_ppb);
    out->error_ns = lum_clock_error(&line, clock_us);
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
        info.newest_us = fit->newest.clock_us;
        info.error_ns = lum_clock_error(&fit->line, info.newest_us);
        info.has_drift = fit->has_drift;
        info.drift_ppb = (int32_t)fit->line.drift_ppb;
        info.drift_error_ppb = (int32_t)fit->line.drift_error_ppb;
    }
    if (!lum_sized_fill(out, &info, sizeof info)) {
        return LUM_E_VALUE;
    }
    return fit->has_begun ? LUM_OK : LUM_END;
}
