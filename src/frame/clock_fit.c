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

/* An arrival contradicts the line if it lies this far below its lowest possible
 * place, or this far above. */
#define LOW_NS  MS_NS
#define HIGH_NS (250 * MS_NS)

/* This many contradictions that agree are a break; if they are only late, they
 * also have to last this long. */
#define RUN_MIN  4u
#define RUN_US   1000000
#define AGREE_NS (250 * MS_NS)

/* What the host's clock may gain on a line: 500 ppm when it is slewed, and what
 * its crystal wanders. */
#define GAIN_PPB (600 * PPM)

/* So many batches do not all come late. */
#define BATCHES_MANY 8u

/* Readings this near to a step of the host's clock have no known time. */
#define STEP_NEAR_US 1000000

/* Readings come in about their order; packets arrive nearly in it. */
#define BACK_US  1000000
#define ORDER_US 20000

/* Far above all that is measured, and sums of them fit. */
#define NS_MAX  (INT64_C(1) << 61)
#define PPB_MAX INT64_C(1000000000)

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
    struct lum_clock_reading last;      /* in order of arrival */
    struct lum_clock_earliest earliest; /* of the newest bucket */
    struct lum_clock_line line;
    struct lum_clock_stamps stamps;
    struct lum_clock_reading latest; /* the truth is no later than this */
    bool has_stamps;                 /* more than one */
    bool is_still;     /* the clock goes on, and stamps do not change */
    int64_t still_us;  /* from here on that is so, with the last one's stamp */
    int64_t prior_ppb; /* the drift, where it is not measured */
    int64_t prior_error_ppb;
    struct run run;
    bool has_stepped;             /* the host's clock, since the last restart */
    int64_t step_us;              /* the first reading after that */
    struct lum_clock_line before; /* of readings before it */
    uint64_t taken;
    uint64_t aside;
    uint64_t still;
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

/* NULL: nothing of it has arrived, or it is long ago. */
static const struct lum_clock_bucket *find_bucket(const lum_clock_fit *fit,
                                                  int64_t index)
{
    const struct lum_clock_bucket *b =
        &fit->buckets[(uint64_t)index % LUM_CLOCK_BUCKETS];
    return b->index == index ? b : NULL;
}

static void look(const lum_clock_fit *fit, struct lum_clock_window *out)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    out->count = 0;
    out->batches = 1;
    out->resolution_ns = lum_clock_stamps_resolution(&fit->stamps);
    for (int64_t i = newest - LUM_CLOCK_BUCKETS + 1; i <= newest; i++) {
        const struct lum_clock_bucket *b = find_bucket(fit, i);
        if (b != NULL) {
            out->list[out->count++] = b;
            out->batches += b->batches;
        }
    }
}

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* By how much the truth may be later than the line in a bucket. No packet
 * arrives before it was sent: so by less than the earliest arrival, or than one
 * nearby and the most that the host's clock may gain until then. If all
 * arrivals of the bucket are far above that, perhaps that clock was stepped. */
static int64_t later_in(const lum_clock_fit *fit,
                        const struct lum_clock_line *line, int64_t index)
{
    const struct lum_clock_bucket *b = find_bucket(fit, index);
    const int64_t newest = index_of(fit->newest.clock_us);
    int64_t least_ns = index == newest ? lum_clock_above(line, &fit->latest)
                                       : LUM_CLOCK_NOTHING;
    if (b == NULL) {
        return 0;
    }
    for (int64_t i = index - 1; i <= index + 1 && i < newest; i++) {
        const struct lum_clock_bucket *near = find_bucket(fit, i);
        if (near != NULL) {
            const int64_t away_us =
                magnitude(near->best.clock_us - b->best.clock_us);
            least_ns =
                smaller(least_ns, lum_clock_above(line, &near->best) +
                                      lum_clock_scale(away_us, GAIN_PPB));
        }
    }
    const int64_t own_ns = lum_clock_above(line, &b->best);
    return b->batches >= BATCHES_MANY && own_ns > least_ns + LOW_NS ? own_ns
                                                                    : least_ns;
}

/* The same at a reading, by what arrived on both sides of it. */
static int64_t find_later(const lum_clock_fit *fit,
                          const struct lum_clock_line *line, int64_t clock_us)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    const int64_t index = smaller(index_of(clock_us), newest);
    int64_t later_ns = 0;
    for (int64_t i = index - 1; i <= index + 1; i++) {
        const int64_t ns = later_in(fit, line, i);
        later_ns = ns > later_ns ? ns : later_ns;
    }
    return later_ns;
}

/* The error of a line's time. */
static int64_t find_error(const lum_clock_fit *fit,
                          const struct lum_clock_line *line, int64_t clock_us)
{
    return lum_clock_error(line, clock_us) +
           lum_clock_stamps_resolution(&fit->stamps) +
           find_later(fit, line, clock_us);
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
    if (fit->has_drift && !has_drift && lum_clock_holds(&w, &fit->line) &&
        find_error(fit, &fit->line, now_us) <= find_error(fit, &line, now_us)) {
        return;
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
    struct lum_clock_earliest *e = &fit->earliest;
    if (b->index != index) {
        *b = (struct lum_clock_bucket){.index = index, .best = *r};
    }
    if (index > index_of(e->first.clock_us)) {
        *e = (struct lum_clock_earliest){.first = *r};
    }
    if (lum_clock_lateness(&b->best, r, drift_ppb) < 0) {
        b->best = *r;
    }
    /* The eyes' lines have one clock, and one comes after the other. */
    if (index == index_of(e->first.clock_us) &&
        (e->count == 0 || r->clock_us != fit->last.clock_us)) {
        b->gap_ns = lum_clock_earliest_note(
            e, lum_clock_lateness(&e->first, r, drift_ppb));
    }
    b->batches += ends_batch(&fit->last, r) ? 1u : 0u;
}

/* No later than its own arrival, or than an earlier one and the most that the
 * host's clock may gain since. */
static void note_latest(lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    struct lum_clock_reading *latest = &fit->latest;
    const int64_t us = r->clock_us - latest->clock_us;
    if (us >= 0) {
        const int64_t most_ns =
            us * 1000 + lum_clock_scale(us, fit->line.drift_ppb + GAIN_PPB);
        latest->clock_us = r->clock_us;
        latest->arrival_ns =
            smaller(r->arrival_ns, latest->arrival_ns + most_ns);
    }
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
    fit->still_us = r->clock_us + (find_error(fit, &fit->line, r->clock_us) +
                                   LOW_NS + (late_ns > 0 ? late_ns : 0)) /
                                      1000;
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
    fit->latest = *r;
    fit->earliest = (struct lum_clock_earliest){.first = *r};
    fit->taken += count;
    put(fit, r);
    refit(fit);
    note_new_stamp(fit, r);
}

static void take(lum_clock_fit *fit, const struct lum_clock_reading *r)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    const int64_t index = index_of(r->clock_us);
    if (r->arrival_ns != fit->last.arrival_ns) {
        note_new_stamp(fit, r);
    }
    fit->run.count = 0;
    fit->taken++;
    if (index <= newest - LUM_CLOCK_BUCKETS) {
        return;
    }
    lum_clock_stamps_note_reading(&fit->stamps,
                                  r->clock_us - fit->last.clock_us);
    put(fit, r);
    note_latest(fit, r);
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
    const int64_t error_ns = find_error(fit, &fit->line, r->clock_us);
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
    fit->before.error_ns = smaller(
        fit->line.error_ns + find_later(fit, &fit->line, fit->newest.clock_us),
        NS_MAX);
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
        to->still = 0;
    }
}

void lum_clock_fit_note_stamp(lum_clock_fit *fit, int64_t arrival_ns)
{
    lum_clock_stamps_note(&fit->stamps, arrival_ns);
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
    lum_clock_stamps_note(&fit->stamps, arrival_ns);
    if (!fit->has_begun) {
        begin(fit, &r, 1);
        return LUM_CLOCK_FIT_TAKEN;
    }
    fit->has_stamps = fit->has_stamps || arrival_ns != fit->last.arrival_ns;
    fit->is_still = arrival_ns == fit->last.arrival_ns &&
                    (fit->is_still || clock_us > fit->still_us);
    if (fit->is_still) {
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
    (void)lum_pack_check(
        p, is_within(line->from_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
               is_within(line->to_us, LUM_CLOCK_FIT_CLOCK_MAX_US));
}

/* Its place follows from its reading. */
static void pack_bucket(lum_pack *p, struct lum_clock_bucket *b,
                        const struct lum_clock_reading *near)
{
    bool is_used = b->index != LUM_CLOCK_NOTHING;
    lum_pack_bool(p, &is_used);
    if (!is_used) {
        b->index = LUM_CLOCK_NOTHING;
        return;
    }
    pack_reading(p, &b->best, near);
    b->index = index_of(b->best.clock_us);
    pack_limited(p, &b->gap_ns, NS_MAX);
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

static void pack_stamps(lum_pack *p, struct lum_clock_stamps *s)
{
    lum_pack_i64(p, &s->step_us);
    lum_pack_i64(p, &s->lines_us);
    lum_pack_u32(p, &s->halvings);
    (void)lum_pack_check(
        p, s->step_us > 0 && s->step_us <= LUM_CLOCK_STEP_MAX_US &&
               s->lines_us >= 0 && s->halvings <= LUM_CLOCK_HALVINGS);
}

static void pack_earliest(lum_pack *p, struct lum_clock_earliest *e,
                          const struct lum_clock_reading *near)
{
    pack_reading(p, &e->first, near);
    lum_pack_u32(p, &e->count);
    if (lum_pack_check(p, e->count <= LUM_CLOCK_EARLIEST)) {
        for (uint32_t i = 0; i < e->count; i++) {
            pack_limited(p, &e->late_ns[i], NS_MAX);
        }
    }
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
    pack_reading(p, &fit->latest, &fit->newest);
    pack_stamps(p, &fit->stamps);
    pack_earliest(p, &fit->earliest, &fit->newest);
    lum_pack_bool(p, &fit->has_stamps);
    lum_pack_bool(p, &fit->is_still);
    lum_pack_i64(p, &fit->still_us);
    pack_line(p, &fit->line, &fit->newest);
    pack_limited(p, &fit->prior_ppb, PPB_MAX);
    pack_limited(p, &fit->prior_error_ppb, PPB_MAX);
    pack_run(p, &fit->run, &fit->newest);
    pack_limited(p, &fit->step_us, LUM_CLOCK_FIT_CLOCK_MAX_US);
    pack_line(p, &fit->before, &fit->newest);
    lum_pack_u64(p, &fit->taken);
    lum_pack_u64(p, &fit->aside);
    lum_pack_u64(p, &fit->still);
    lum_pack_u64(p, &fit->sensor_breaks);
    lum_pack_u64(p, &fit->host_steps);
    pack_window(fit, p);
    return !p->has_failed;
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
                       .near_us =
                           fit->is_still ? clock_us : fit->newest.clock_us};
    if (run->count > 0 && run->is_sensor &&
        magnitude(clock_us - run->first_us) < magnitude(clock_us - a.near_us)) {
        a.near_us = run->first_us;
        a.line.at = run->best;
        a.line.from_us = run->first_us;
        a.line.to_us = run->first_us;
        a.line.error_ns = LUM_CLOCK_SPREAD_NS;
    } else if (fit->has_stepped && clock_us < fit->step_us) {
        a.line = fit->before;
    } else {
        a.later_ns = find_later(fit, &fit->line, clock_us);
    }
    return a;
}

static bool is_near(int64_t clock_us, int64_t other_us)
{
    return magnitude(clock_us - other_us) <= STEP_NEAR_US;
}

/* Whether the time nearby is not known: stamps stand still, or only one has
 * come, or the host's clock was stepped, or that seems so; a single reading
 * that contradicts the line is no step. */
static bool is_unknown(const lum_clock_fit *fit, int64_t clock_us)
{
    const struct run *run = &fit->run;
    return fit->is_still || !fit->has_stamps ||
           (fit->has_stepped && is_near(clock_us, fit->step_us)) ||
           (run->count > 1 && !run->is_sensor &&
            clock_us > run->first_us - STEP_NEAR_US);
}

static int64_t error_of(const lum_clock_fit *fit, const struct answer *a,
                        int64_t clock_us)
{
    return is_unknown(fit, clock_us)
               ? LUM_CLOCK_ERROR_UNKNOWN
               : lum_clock_error(&a->line, clock_us) +
                     lum_clock_stamps_resolution(&fit->stamps) + a->later_ns;
}

lum_result lum_clock_fit_utc(const lum_clock_fit *fit, int64_t clock_us,
                             lum_clock_time *out)
{
    if (!fit->has_begun) {
        return LUM_END;
    }
    if (clock_us > LUM_CLOCK_FIT_CLOCK_MAX_US ||
        clock_us < -LUM_CLOCK_FIT_CLOCK_MAX_US) {
        return LUM_E_VALUE;
    }
    const struct answer a = answer_of(fit, clock_us);
    if (magnitude(clock_us - a.near_us) > LUM_CLOCK_FIT_NEAR_US) {
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
        info.newest_us = fit->newest.clock_us;
        info.error_ns = is_unknown(fit, info.newest_us)
                            ? LUM_CLOCK_ERROR_UNKNOWN
                            : find_error(fit, &fit->line, info.newest_us);
        info.has_drift = fit->has_drift;
        info.drift_ppb = (int32_t)fit->line.drift_ppb;
        info.drift_error_ppb = (int32_t)fit->line.drift_error_ppb;
        info.resolution_ns = lum_clock_stamps_resolution(&fit->stamps);
        info.still = fit->still;
    }
    if (!lum_sized_fill(out, &info, sizeof info)) {
        return LUM_E_VALUE;
    }
    return fit->has_begun ? LUM_OK : LUM_END;
}
