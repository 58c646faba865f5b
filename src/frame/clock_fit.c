#include "lum/frame/clock_fit.h"

#include <stdlib.h>
#include <string.h>

#define MS_NS INT64_C(1000000)
#define PPM   INT64_C(1000)

/* The window: the earliest arrivals of so many spans of the sensor's clock. */
#define BUCKETS   128
#define BUCKET_US 125000

/* The last second, which tells whether arrivals have left the line. */
#define RECENT 8

/* Clocks differ by no more than this; what is measured above it is none. */
#define DRIFT_KNOWN_PPB (500 * PPM)
#define DRIFT_MAX_PPB   (1000 * PPM)

/* How the drift changes: within the window, and over a break. */
#define WANDER_PPB PPM
#define CHANGE_PPB (50 * PPM)

/* How late the first arrival may be. */
#define SPREAD_NS (40 * MS_NS)

/* So many steps of the lateness show that batches have shifted. */
#define SHIFTS_MIN 3u
#define SHIFT_US   250000

/* No error is told above this: arrivals come nearer, or contradict. */
#define ERROR_MAX_NS (1000 * MS_NS)

/* Arrivals are as late as one another where they differ by less. */
#define SAME_NS 5000

/* The reading's own unit. */
#define STEP_NS 1000

/* A line is left as it is for less. */
#define SLACK_NS 1000

/* An arrival contradicts the line if it lies this far below what it allows, or
 * above. Before there is much to go by, a batch may still turn out longer. */
#define LOW_NS       MS_NS
#define LOW_EARLY_NS (10 * MS_NS)
#define EARLY_US     2000000
#define HIGH_NS      (250 * MS_NS)

/* Contradictions that agree are a break: so many, and where they only come late
 * for so long. */
#define RUN_MIN  4u
#define RUN_US   1000000
#define AGREE_NS (250 * MS_NS)

/* Readings come in about their order. */
#define BACK_US 1000000

/* Of a span; what comes more often is not counted. */
#define BATCHES_MAX 100000u

#define NOTHING INT64_MAX

struct reading {
    int64_t clock_us;
    int64_t arrival_ns;
};

/* The earliest arrival of a span. */
struct bucket {
    int64_t index; /* of the span; NOTHING: unused */
    struct reading best;
    int64_t next_ns; /* by how much the next that is not the same is later;
                        NOTHING: there is none */
    uint32_t batches;    /* that ended in it; without batches, readings */
    int64_t late_sum_ns; /* of their last readings, against the best */
};

struct line {
    struct reading at;
    int64_t drift_ppb;
    int64_t drift_error_ppb;
    int64_t from_us; /* readings that it rests on */
    int64_t to_us;
    int64_t error_ns;  /* between them */
    int64_t recent_ns; /* the least by which a recent arrival is later */
};

/* Arrivals that contradict the line and agree among themselves. */
struct run {
    unsigned count;
    bool is_sensor; /* its clock jumped; else the host's */
    int64_t first_us;
    struct reading best;
};

struct lum_clock_fit {
    bool has_begun;
    bool has_drift;  /* measured */
    bool is_carried; /* the line is of before a gap in the stream */
    struct bucket buckets[BUCKETS];
    int64_t begin_us;
    struct reading newest;
    struct reading last; /* in order of arrival */
    struct line line;
    int64_t prior_ppb; /* the drift, where it is not measured */
    int64_t prior_error_ppb;
    struct run run;
    uint64_t taken;
    uint64_t aside;
    uint64_t sensor_breaks;
    uint64_t host_steps;
};

/* The used buckets in their order. */
struct window {
    const struct bucket *list[BUCKETS];
    size_t count;
    int64_t batches;
    int64_t late_ns[2 * BUCKETS]; /* what find_error() sorts */
};

static int64_t magnitude(int64_t x)
{
    return x < 0 ? -x : x;
}

/* us x ppb, in ns. */
static int64_t scale(int64_t us, int64_t ppb)
{
    return us / 1000000 * ppb + us % 1000000 * ppb / 1000000;
}

static int64_t index_of(int64_t clock_us)
{
    const int64_t towards_0 = clock_us / BUCKET_US;
    return clock_us % BUCKET_US < 0 ? towards_0 - 1 : towards_0;
}

static struct bucket *slot_of(lum_clock_fit *fit, int64_t index)
{
    return &fit->buckets[(uint64_t)index % BUCKETS];
}

/* By how much b arrived later than a, if a took the usual time. */
static int64_t lateness(const struct reading *a, const struct reading *b,
                        int64_t drift_ppb)
{
    const int64_t us = b->clock_us - a->clock_us;
    return b->arrival_ns - a->arrival_ns - us * 1000 - scale(us, drift_ppb);
}

static int64_t above(const struct line *line, const struct reading *r)
{
    return lateness(&line->at, r, line->drift_ppb);
}

/* Of the line's time; grows away from what it rests on. */
static int64_t error_at(const struct line *line, int64_t clock_us)
{
    int64_t away_us = 0;
    if (clock_us < line->from_us) {
        away_us = line->from_us - clock_us;
    } else if (clock_us > line->to_us) {
        away_us = clock_us - line->to_us;
    }
    const int64_t error =
        line->error_ns + STEP_NS + scale(away_us, line->drift_error_ppb);
    return error > line->recent_ns ? error : line->recent_ns;
}

static void look(const lum_clock_fit *fit, struct window *out)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    out->count = 0;
    out->batches = 1;
    for (int64_t i = newest - BUCKETS + 1; i <= newest; i++) {
        const struct bucket *b = &fit->buckets[(uint64_t)i % BUCKETS];
        if (b->index == i) {
            out->list[out->count++] = b;
            out->batches += b->batches;
        }
    }
}

/* The earliest arrival of readings from one to another, by a drift. */
static const struct reading *find_best(const struct window *w, int64_t from_us,
                                       int64_t to_us, int64_t drift_ppb)
{
    const struct reading *best = NULL;
    for (size_t i = 0; i < w->count; i++) {
        const struct reading *r = &w->list[i]->best;
        if (r->clock_us >= from_us && r->clock_us <= to_us &&
            (best == NULL || lateness(best, r, drift_ppb) < 0)) {
            best = r;
        }
    }
    return best;
}

/* The drift between the best of the first third of the window and of the last,
 * which depends on the drift. */
static bool measure_drift(const struct window *w, struct line *line)
{
    const int64_t first_us = w->list[0]->best.clock_us;
    const int64_t last_us = w->list[w->count - 1u]->best.clock_us;
    const int64_t third_us = (last_us - first_us) / 3;
    for (unsigned i = 0; i < 3u; i++) {
        const struct reading *a =
            find_best(w, first_us, first_us + third_us, line->drift_ppb);
        const struct reading *b =
            find_best(w, last_us - third_us, last_us, line->drift_ppb);
        const int64_t us = b->clock_us - a->clock_us;
        if (us < BUCKET_US) {
            return false;
        }
        const int64_t late_ns = lateness(a, b, 0);
        if (magnitude(late_ns) > scale(us, DRIFT_MAX_PPB)) {
            return false;
        }
        line->drift_ppb = late_ns * 1000000 / us;
        line->from_us = a->clock_us;
        line->to_us = b->clock_us;
    }
    return true;
}

static int by_value(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a;
    const int64_t y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/* The widest gap between neighbours of the lower half. */
static int64_t find_gap(int64_t *late_ns, size_t n)
{
    int64_t gap = 0;
    qsort(late_ns, n, sizeof late_ns[0], by_value);
    for (size_t i = 1; i <= n / 2u && i < n; i++) {
        gap = larger(gap, late_ns[i] - late_ns[i - 1u]);
    }
    return gap;
}

/* How late the best of n spans may be, by the usual one of a span: the n-th
 * part if all delays are as likely, more if short ones are rare. */
static int64_t by_usual(int64_t usual_ns, size_t n)
{
    int64_t root = 1;
    while ((root + 1) * (root + 1) <= (int64_t)n) {
        root++;
    }
    return 4 * usual_ns / root;
}

/* How late the best batch may be, by the usual one. */
static int64_t by_chance(const struct window *w, const struct line *line)
{
    int64_t mean_ns = 0;
    for (size_t i = 0; i < w->count; i++) {
        const struct bucket *b = w->list[i];
        mean_ns += (b->late_sum_ns + above(line, &b->best) * b->batches) /
                   w->batches;
    }
    return SPREAD_NS / w->batches / w->batches + 4 * mean_ns / w->batches;
}

/* How often the lateness of the best stepped by more than this. */
static unsigned count_shifts(const struct window *w, const struct line *line,
                             int64_t step_ns)
{
    unsigned shifts = 0;
    int64_t before_ns = NOTHING;
    for (size_t i = 0; i < w->count;) {
        const int64_t from_us = w->list[i]->best.clock_us;
        int64_t best_ns = NOTHING;
        for (; i < w->count && w->list[i]->best.clock_us < from_us + SHIFT_US;
             i++) {
            const int64_t late_ns = above(line, &w->list[i]->best);
            best_ns = late_ns < best_ns ? late_ns : best_ns;
        }
        shifts += before_ns != NOTHING &&
                          magnitude(best_ns - before_ns) > step_ns
                      ? 1u
                      : 0u;
        before_ns = best_ns;
    }
    return shifts;
}

/* In batches the lateness of the best takes few values, until the clocks'
 * difference has shifted lines against batches: till then all may be as late as
 * lies between two of these. */
static int64_t by_batches(struct window *w, const struct line *line)
{
    size_t n = 0;
    for (size_t i = 0; i < w->count; i++) {
        if (w->list[i]->next_ns != NOTHING) {
            w->late_ns[n++] = w->list[i]->next_ns;
        }
    }
    if (n == 0) {
        return 0;
    }
    qsort(w->late_ns, n, sizeof w->late_ns[0], by_value);
    const int64_t step_ns = w->late_ns[n / 2u];
    return count_shifts(w, line, step_ns / 3) < SHIFTS_MIN ? step_ns : 0;
}

/* How late the arrivals that the line lies under may be. */
static int64_t find_error(struct window *w, const struct line *line)
{
    int64_t error = by_chance(w, line);
    size_t n = 0;
    for (size_t i = 0; i < w->count; i++) {
        w->late_ns[n++] = above(line, &w->list[i]->best);
    }
    error = larger(error, find_gap(w->late_ns, n));
    error = larger(error, by_usual(w->late_ns[n / 2u], n));
    error = larger(error, by_batches(w, line));
    return error < ERROR_MAX_NS ? error : ERROR_MAX_NS;
}

static int64_t find_recent(const struct window *w, const struct line *line,
                           int64_t newest)
{
    int64_t least = NOTHING;
    for (size_t i = 0; i < w->count; i++) {
        const int64_t late_ns = above(line, &w->list[i]->best);
        if (w->list[i]->index > newest - RECENT && late_ns < least) {
            least = late_ns;
        }
    }
    return least != NOTHING ? least : 0;
}

/* The line of a drift, under all arrivals. */
static void lay(struct window *w, struct line *line)
{
    line->at = *find_best(w, INT64_MIN, INT64_MAX, line->drift_ppb);
    line->error_ns = find_error(w, line);
}

/* Whether the drift is told better by the window than by what was known. */
static bool fit_drift(struct window *w, const lum_clock_fit *fit,
                      struct line *line)
{
    if (!measure_drift(w, line)) {
        return false;
    }
    lay(w, line);
    /* Both thirds have fewer arrivals than all. */
    const int64_t end_ns = 2 * line->error_ns + STEP_NS;
    line->drift_error_ppb =
        end_ns * 1000000 / (line->to_us - line->from_us) + WANDER_PPB;
    return line->drift_error_ppb < fit->prior_error_ppb;
}

static bool holds(const struct window *w, const struct line *line)
{
    for (size_t i = 0; i < w->count; i++) {
        if (above(line, &w->list[i]->best) < -SLACK_NS) {
            return false;
        }
    }
    return true;
}

static void refit(lum_clock_fit *fit)
{
    const int64_t now_us = fit->newest.clock_us;
    struct line line = fit->line;
    struct window w;
    look(fit, &w);
    const bool has_drift = fit_drift(&w, fit, &line);
    if (!has_drift) {
        line.drift_ppb = fit->prior_ppb;
        line.drift_error_ppb = fit->prior_error_ppb;
        lay(&w, &line);
        line.from_us = line.at.clock_us;
        line.to_us = line.at.clock_us;
    }
    line.recent_ns = find_recent(&w, &line, index_of(now_us));
    if (fit->is_carried && holds(&w, &fit->line) &&
        error_at(&fit->line, now_us) <= error_at(&line, now_us)) {
        return;
    }
    fit->is_carried = false;
    fit->has_drift = has_drift;
    fit->line = line;
}

/* A reading that does not come with the one before ends a batch. */
static void note_batch(struct bucket *b, const struct reading *last,
                       const struct reading *r, int64_t drift_ppb)
{
    const int64_t us = r->clock_us - last->clock_us;
    if (us > 0 && r->arrival_ns - last->arrival_ns >= us * 500 &&
        b->batches < BATCHES_MAX) {
        b->batches++;
        b->late_sum_ns += larger(0, lateness(&b->best, last, drift_ppb));
    }
}

static void put_best(struct bucket *b, const struct reading *r, int64_t late_ns)
{
    if (late_ns <= -SAME_NS) {
        b->next_ns = -late_ns;
    } else if (b->next_ns != NOTHING) {
        b->next_ns -= late_ns;
    }
    b->late_sum_ns -= late_ns * b->batches;
    b->best = *r;
}

static void put(lum_clock_fit *fit, const struct reading *r)
{
    const int64_t index = index_of(r->clock_us);
    const int64_t drift_ppb = fit->line.drift_ppb;
    struct bucket *b = slot_of(fit, index);
    if (b->index != index) {
        *b = (struct bucket){.index = index, .best = *r, .next_ns = NOTHING};
    }
    const int64_t late_ns = lateness(&b->best, r, drift_ppb);
    if (late_ns < 0) {
        put_best(b, r, late_ns);
    } else if (late_ns >= SAME_NS && late_ns < b->next_ns &&
               r->clock_us != fit->last.clock_us) {
        /* The eyes' lines have one clock, and one comes after the other. */
        b->next_ns = late_ns;
    }
    note_batch(b, &fit->last, r, drift_ppb);
}

static void know_drift_of_before(lum_clock_fit *fit)
{
    const int64_t error = fit->line.drift_error_ppb + CHANGE_PPB;
    if (fit->has_drift && error < DRIFT_KNOWN_PPB) {
        fit->prior_ppb = fit->line.drift_ppb;
        fit->prior_error_ppb = error;
    }
}

/* The first of a new fit; the drift of before is a begin. */
static void begin(lum_clock_fit *fit, const struct reading *r, unsigned count)
{
    for (size_t i = 0; i < BUCKETS; i++) {
        fit->buckets[i].index = NOTHING;
    }
    know_drift_of_before(fit);
    fit->has_begun = true;
    fit->has_drift = false;
    fit->is_carried = false;
    fit->run.count = 0;
    fit->begin_us = r->clock_us;
    fit->newest = *r;
    fit->last = *r;
    fit->taken += count;
    put(fit, r);
    refit(fit);
}

static void take(lum_clock_fit *fit, const struct reading *r)
{
    const int64_t newest = index_of(fit->newest.clock_us);
    const int64_t index = index_of(r->clock_us);
    fit->run.count = 0;
    fit->taken++;
    if (index <= newest - BUCKETS) {
        return;
    }
    if (index >= newest + BUCKETS) {
        know_drift_of_before(fit);
        fit->is_carried = true;
        fit->begin_us = r->clock_us;
    }
    put(fit, r);
    fit->last = *r;
    if (r->clock_us > fit->newest.clock_us) {
        fit->newest = *r;
    }
    if (index > newest || above(&fit->line, r) < -SLACK_NS) {
        refit(fit);
    }
}

/* By how much a reading contradicts the line, below 0 if it is too early; 0: it
 * does not. */
static int64_t contradiction(const lum_clock_fit *fit, const struct reading *r)
{
    const int64_t late_ns = above(&fit->line, r);
    const int64_t error_ns = error_at(&fit->line, r->clock_us);
    const bool is_early = fit->newest.clock_us - fit->begin_us < EARLY_US;
    if (late_ns < -error_ns - (is_early ? LOW_EARLY_NS : LOW_NS) ||
        late_ns > error_ns + HIGH_NS) {
        return late_ns;
    }
    return 0;
}

static bool is_sensor(const lum_clock_fit *fit, const struct reading *r)
{
    const int64_t us = r->clock_us - fit->last.clock_us;
    return us < -BACK_US ||
           magnitude(us) * 1000 >
               magnitude(r->arrival_ns - fit->last.arrival_ns);
}

static bool agrees(const lum_clock_fit *fit, const struct reading *r)
{
    return fit->run.count > 0 &&
           magnitude(lateness(&fit->run.best, r, fit->line.drift_ppb)) <=
               AGREE_NS;
}

/* A reading that contradicts the line. Breaks are told by several; a single one
 * is a damaged packet. */
static lum_clock_fit_event set_aside(lum_clock_fit *fit,
                                     const struct reading *r, int64_t late_ns)
{
    struct run *run = &fit->run;
    if (!agrees(fit, r)) {
        *run = (struct run){.is_sensor = is_sensor(fit, r),
                            .first_us = r->clock_us,
                            .best = *r};
    }
    run->count++;
    if (lateness(&run->best, r, fit->line.drift_ppb) < 0) {
        run->best = *r;
    }
    if (run->count < RUN_MIN || (!run->is_sensor && late_ns > 0 &&
                                 r->clock_us - run->first_us < RUN_US)) {
        fit->aside++;
        return LUM_CLOCK_FIT_ASIDE;
    }
    const bool is_of_sensor = run->is_sensor;
    const struct reading first = run->best;
    fit->sensor_breaks += is_of_sensor ? 1u : 0u;
    fit->host_steps += is_of_sensor ? 0u : 1u;
    fit->aside -= run->count - 1u;
    begin(fit, &first, run->count);
    fit->last = *r;
    return is_of_sensor ? LUM_CLOCK_FIT_SENSOR_BREAK : LUM_CLOCK_FIT_HOST_STEP;
}

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

void lum_clock_fit_copy(lum_clock_fit *to, const lum_clock_fit *from)
{
    *to = *from;
}

lum_clock_fit_event lum_clock_fit_add(lum_clock_fit *fit, int64_t clock_us,
                                      int64_t arrival_ns)
{
    const struct reading r = {clock_us, arrival_ns};
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

lum_result lum_clock_fit_utc(const lum_clock_fit *fit, int64_t clock_us,
                             lum_clock_time *out)
{
    const struct run *run = &fit->run;
    struct line line = fit->line;
    int64_t near_us = fit->newest.clock_us;
    if (!fit->has_begun) {
        return LUM_END;
    }
    if (clock_us > LUM_CLOCK_FIT_CLOCK_MAX_US ||
        clock_us < -LUM_CLOCK_FIT_CLOCK_MAX_US) {
        return LUM_E_VALUE;
    }
    if (run->count > 0 && run->is_sensor &&
        magnitude(clock_us - run->first_us) < magnitude(clock_us - near_us)) {
        near_us = run->first_us;
        line.at = run->best;
        line.from_us = near_us;
        line.to_us = near_us;
        line.error_ns = SPREAD_NS;
    }
    if (magnitude(clock_us - near_us) > LUM_CLOCK_FIT_NEAR_US) {
        return LUM_E_VALUE;
    }
    const int64_t us = clock_us - line.at.clock_us;
    out->utc_ns =
        line.at.arrival_ns + us * 1000 + scale(us, line.drift_ppb);
    out->error_ns = error_at(&line, clock_us);
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
        info.error_ns = error_at(&fit->line, info.newest_us);
        info.has_drift = fit->has_drift;
        info.drift_ppb = (int32_t)fit->line.drift_ppb;
        info.drift_error_ppb = (int32_t)fit->line.drift_error_ppb;
    }
    const size_t asked = out->struct_size;
    memcpy(out, &info, asked < sizeof info ? asked : sizeof info);
    out->struct_size = asked;
    return fit->has_begun ? LUM_OK : LUM_END;
}
