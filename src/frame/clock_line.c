/* The line under the earliest arrivals of a window: its drift, and how far off
 * it may be. */
#include "clock_line.h"

/* What is measured above this is no drift. */
#define DRIFT_MAX_PPB INT64_C(1000000)

/* How the drift changes within the window. */
#define WANDER_PPB INT64_C(1000)

/* The largest error reported: arrivals come closer than that, or contradict the
 * line. */
#define ERROR_MAX_NS INT64_C(1000000000)

/* After a second without readings, so many batches have to come before they
 * count for the drift: the first of them may be late. */
#define PAUSE_BUCKETS   8
#define BATCHES_SETTLED 8u

/* The reading's own unit. */
#define STEP_NS 1000

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/* --- A line and a reading --- */

int64_t lum_clock_error(const struct lum_clock_line *line, int64_t clock_us)
{
    int64_t away_us = 0;
    if (clock_us < line->from_us) {
        away_us = line->from_us - clock_us;
    } else if (clock_us > line->to_us) {
        away_us = clock_us - line->to_us;
    }
    return line->error_ns + STEP_NS +
           lum_clock_scale(away_us, line->drift_error_ppb);
}

/* As lum_clock_lateness(), for readings of one window: they are so near that
 * the product fits. */
static int64_t lateness(const struct lum_clock_reading *a,
                        const struct lum_clock_reading *b, int64_t drift_ppb)
{
    const int64_t us = b->clock_us - a->clock_us;
    return b->arrival_ns - a->arrival_ns - us * 1000 - us * drift_ppb / 1000000;
}

/* The span of the earliest arrival among some of the window, for a given drift.
 * late_ns has how much later those behind it are. */
static size_t find_best(struct lum_clock_window *w, size_t from, size_t end,
                        int64_t drift_ppb)
{
    size_t best = from;
    for (size_t i = from; i < end; i++) {
        w->late_ns[i] =
            lateness(&w->list[best]->best, &w->list[i]->best, drift_ppb);
        if (w->late_ns[i] < 0) {
            w->late_ns[i] = 0;
            best = i;
        }
    }
    return best;
}

/* How many spans have their earliest reading up to a time: they are in order.
 */
static size_t count_until(const struct lum_clock_window *w, int64_t to_us)
{
    size_t n = 0;
    while (n < w->count && w->list[n]->best.clock_us <= to_us) {
        n++;
    }
    return n;
}

static bool is_settled(const struct lum_clock_window *w)
{
    size_t i = w->count - 1u;
    size_t batches = w->list[i]->batches;
    while (i > 0 && batches < BATCHES_SETTLED &&
           w->list[i]->index - w->list[i - 1u]->index <= PAUSE_BUCKETS) {
        i--;
        batches += w->list[i]->batches;
    }
    return i == 0 || batches >= BATCHES_SETTLED;
}

/* The drift between the best readings of the first and the last third of the
 * window. The choice depends on the drift; the line's present one is good
 * enough. */
static bool measure_drift(struct lum_clock_window *w,
                          struct lum_clock_line *line)
{
    const int64_t first_us = w->list[0]->best.clock_us;
    const int64_t last_us = w->list[w->count - 1u]->best.clock_us;
    const int64_t third_us = (last_us - first_us) / 3;
    const size_t first =
        find_best(w, 0, count_until(w, first_us + third_us), line->drift_ppb);
    const size_t last = find_best(w, count_until(w, last_us - third_us - 1),
                                  w->count, line->drift_ppb);
    const struct lum_clock_reading *a = &w->list[first]->best;
    const struct lum_clock_reading *b = &w->list[last]->best;
    const int64_t us = b->clock_us - a->clock_us;
    const int64_t late_ns = lum_clock_lateness(a, b, 0);
    if (us < LUM_CLOCK_BUCKET_US ||
        lum_clock_magnitude(late_ns) > lum_clock_scale(us, DRIFT_MAX_PPB)) {
        return false;
    }
    line->drift_ppb = late_ns * 1000000 / us;
    line->from_us = a->clock_us;
    line->to_us = b->clock_us;
    return true;
}

/* Exchange numbers from *i to *j until those before *i are no larger than
 * middle, and those behind *j no smaller. */
static void split(int64_t *v, int64_t middle, int *i, int *j)
{
    while (*i <= *j) {
        while (v[*i] < middle) {
            ++*i;
        }
        while (v[*j] > middle) {
            --*j;
        }
        if (*i <= *j) {
            const int64_t x = v[*i];
            v[(*i)++] = v[*j];
            v[(*j)--] = x;
        }
    }
}

/* The k-th smallest of n, from 0; smaller ones are moved before it. By Hoare's
 * way of finding it. */
static int64_t select_from(int64_t *v, size_t n, int k)
{
    int first = 0;
    int last = (int)n - 1;
    while (first < last) {
        int i = first;
        int j = last;
        split(v, v[k], &i, &j);
        first = j < k ? i : first;
        last = i > k ? j : last;
    }
    return v[k];
}

/* The gap around the middle of n numbers from 0 on and the next one, usual_ns.
 * If any gap between them is wider than half of that, it is this one. */
static int64_t find_gap(const int64_t *late_ns, size_t n, int64_t usual_ns)
{
    int64_t from_ns = 0;
    int64_t to_ns = usual_ns;
    for (size_t i = 0; i < n; i++) {
        if (late_ns[i] <= usual_ns / 2) {
            from_ns = larger(from_ns, late_ns[i]);
        } else {
            to_ns = lum_clock_smaller(to_ns, late_ns[i]);
        }
    }
    return to_ns - from_ns;
}

/* How late the best of n spans may be, from the usual lateness of a span: the
 * n-th part if all delays are equally likely, more if short ones are rare. */
static int64_t by_usual(int64_t usual_ns, size_t n)
{
    int64_t root = 1;
    while ((root + 1) * (root + 1) <= (int64_t)n) {
        root++;
    }
    return 6 * usual_ns / root;
}

/* With batches the lateness of the best readings has few values, until the
 * drift has shifted lines against batches. All may be late by the distance of
 * two such values. It is looked for only if it is more than is known. */
static int64_t by_batches(struct lum_clock_window *w, int64_t known_ns)
{
    size_t more = 0;
    for (size_t i = 0; i < w->count; i++) {
        more += w->list[i]->gap_ns > known_ns ? 1u : 0u;
    }
    if (more < w->count - w->count / 2u) {
        return known_ns;
    }
    for (size_t i = 0; i < w->count; i++) {
        w->late_ns[i] = w->list[i]->gap_ns;
    }
    return select_from(w->late_ns, w->count, (int)(w->count / 2u));
}

/* How late the arrivals on the line may be, of the lateness of all. */
static int64_t find_error(struct lum_clock_window *w)
{
    /* With n batches the best is late by about the n-th part; that needs
     * several batches to be known. */
    int64_t error = LUM_CLOCK_SPREAD_NS / w->batches / w->batches;
    const size_t n = w->count;
    const int64_t usual_ns = select_from(w->late_ns, n, (int)(n / 2u));
    error = larger(error, by_usual(usual_ns, n));
    error = larger(error, find_gap(w->late_ns, n / 2u, usual_ns));
    error = by_batches(w, error);
    return error < ERROR_MAX_NS ? error : ERROR_MAX_NS;
}

/* The line of a drift, under all arrivals. */
static void lie_under(struct lum_clock_window *w, struct lum_clock_line *line)
{
    const size_t best = find_best(w, 0, w->count, line->drift_ppb);
    line->at = w->list[best]->best;
    for (size_t i = 0; i < best; i++) {
        w->late_ns[i] = lateness(&line->at, &w->list[i]->best, line->drift_ppb);
    }
    line->error_ns = find_error(w);
}

/* Whether the window gives a better drift than the known one. */
static bool fit_drift(struct lum_clock_window *w, int64_t known_error_ppb,
                      struct lum_clock_line *line)
{
    if (!is_settled(w) || !measure_drift(w, line)) {
        return false;
    }
    lie_under(w, line);
    const int64_t end_ns = line->error_ns + w->resolution_ns + STEP_NS;
    line->drift_error_ppb =
        end_ns * 1000000 / (line->to_us - line->from_us) + WANDER_PPB;
    return line->drift_error_ppb < known_error_ppb;
}

bool lum_clock_lay(struct lum_clock_window *window, int64_t known_ppb,
                   int64_t known_error_ppb, struct lum_clock_line *line)
{
    const bool is_measured = fit_drift(window, known_error_ppb, line);
    if (!is_measured) {
        line->drift_ppb = known_ppb;
        line->drift_error_ppb = known_error_ppb;
        lie_under(window, line);
        line->from_us = line->at.clock_us;
        line->to_us = line->at.clock_us;
    }
    return is_measured;
}

bool lum_clock_holds(const struct lum_clock_window *w,
                     const struct lum_clock_line *line)
{
    for (size_t i = 0; i < w->count; i++) {
        if (lum_clock_above(line, &w->list[i]->best) < -LUM_CLOCK_SLACK_NS) {
            return false;
        }
    }
    return true;
}

/* --- As bytes --- */

void lum_clock_reading_pack(lum_pack *p, struct lum_clock_reading *r,
                            const struct lum_clock_reading *near)
{
    lum_pack_near(p, &r->clock_us, near->clock_us);
    lum_pack_near(p, &r->arrival_ns, near->arrival_ns);
    (void)lum_pack_check(p, lum_clock_is_possible(r));
}

void lum_clock_pack_limited(lum_pack *p, int64_t *value, int64_t most)
{
    lum_pack_i64(p, value);
    (void)lum_pack_check(p, lum_clock_is_within(*value, most));
}

void lum_clock_line_pack(lum_pack *p, struct lum_clock_line *line,
                         const struct lum_clock_reading *near)
{
    lum_clock_reading_pack(p, &line->at, near);
    lum_clock_pack_limited(p, &line->drift_ppb, LUM_CLOCK_PPB_MAX);
    lum_clock_pack_limited(p, &line->drift_error_ppb, LUM_CLOCK_PPB_MAX);
    lum_pack_near(p, &line->from_us, line->at.clock_us);
    lum_pack_near(p, &line->to_us, line->at.clock_us);
    lum_clock_pack_limited(p, &line->error_ns, LUM_CLOCK_NS_MAX);
    (void)lum_pack_check(
        p, lum_clock_is_within(line->from_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
               lum_clock_is_within(line->to_us, LUM_CLOCK_FIT_CLOCK_MAX_US));
}
