/* How far a field counts between packets of one sensor, and how well that
 * follows the time of capture. */
#include "ticks.h"
#include "fields.h"
#include "starts.h"

#include <math.h>
#include <stdlib.h>

/* Packets that a clock is looked for in; one after the other, since a narrow
 * one wraps. */
#define TRIAL 4000u

/* Where times of capture are of no use, packets are taken to come this far
 * apart. */
#define STEP_NS 1000

/* Times are compared over this part of the lines. */
#define PART 16u

/* Fewer times than one in this many, at either end, are wrong. */
#define SPOILED 50u

/* A field that rises by 1 in this share of packets counts them. */
#define COUNTS 0.75

/* How far from a line a clock's packets may lie, as a share of the time that
 * they span. Packets that are sent in batches are late by some of that; what
 * is no clock does not follow a line at all. */
#define STRAY 0.2

/* Disorder and corruption turn fewer lines back than this. */
#define BACK 0.25

/* --- The packets --- */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

double lum_infer_quantile(double *values, size_t n, double share)
{
    qsort(values, n, sizeof *values, compare);
    return values[(size_t)(share * (double)(n - 1) + 0.5)];
}

static void choose(lum_infer_ticks *t)
{
    const lum_infer_packets *good = &t->state->good;
    size_t from = 0;
    for (size_t i = 0, begin = 0; i <= good->count; i++) {
        if (i == good->count ||
            good->at[i]->sensor != good->at[begin]->sensor) {
            if (i - begin > t->count) {
                t->count = i - begin;
                from = begin;
            }
            begin = i;
        }
    }
    t->packets = good->at + from;
    t->count = t->count < TRIAL ? t->count : TRIAL;
}

static void find_starts(lum_infer_ticks *t)
{
    for (size_t i = 0; i < t->count; i++) {
        t->times[i] = t->packets[i]->time_ns;
        if (lum_infer_is_start(t->state, t->packets[i])) {
            t->starts[t->start_count++] = i;
        }
    }
}

/* What the beginnings of lines span in time, but for a few times that are
 * wrong. */
static void measure_span(lum_infer_ticks *t)
{
    const size_t n = t->start_count;
    for (size_t i = 0; i < n; i++) {
        t->sorted[i] = (double)(t->times[t->starts[i]] - t->times[0]);
    }
    if (n > 0) {
        qsort(t->sorted, n, sizeof *t->sorted, compare);
        t->span_ns = t->sorted[n - 1 - n / SPOILED] - t->sorted[n / SPOILED];
    }
}

/* Times are of no use if they are all the same, or fall as often as they
 * rise. */
static void check_times(lum_infer_ticks *t)
{
    const size_t far = t->start_count / PART + 1;
    size_t rising = 0;
    size_t falling = 0;
    for (size_t i = 0; i + far < t->start_count; i++) {
        const int64_t a = t->times[t->starts[i]];
        const int64_t b = t->times[t->starts[i + far]];
        rising += b > a;
        falling += b < a;
    }
    measure_span(t);
    t->has_times = rising > 2 * falling && t->span_ns > 0.0;
    if (!t->has_times) {
        for (size_t i = 0; i < t->count; i++) {
            t->times[i] = STEP_NS * (int64_t)i;
        }
        measure_span(t);
    }
}

int lum_infer_find_ticks(const lum_infer_state *state, lum_infer_ticks *out)
{
    *out = (lum_infer_ticks){.state = state};
    choose(out);
    const size_t room = out->count + 1u;
    out->times = calloc(room, sizeof *out->times);
    out->ticks = calloc(room, sizeof *out->ticks);
    out->sorted = calloc(room, sizeof *out->sorted);
    out->starts = calloc(room, sizeof *out->starts);
    if (out->times == NULL || out->ticks == NULL || out->sorted == NULL ||
        out->starts == NULL) {
        return -1;
    }
    find_starts(out);
    check_times(out);
    return 0;
}

void lum_infer_free_ticks(lum_infer_ticks *ticks)
{
    free(ticks->times);
    free(ticks->ticks);
    free(ticks->sorted);
    free(ticks->starts);
}

/* --- What a field counts --- */

lum_infer_course lum_infer_extend(lum_infer_ticks *t, lum_field field)
{
    const unsigned unused = 64u - lum_infer_width(field);
    uint64_t last = lum_infer_value(t->packets[0]->bytes, field);
    lum_infer_course course = {0, false};
    size_t one = 0;
    t->ticks[0] = 0;
    for (size_t i = 1; i < t->count; i++) {
        const uint64_t now = lum_infer_value(t->packets[i]->bytes, field);
        const uint64_t up = (now - last) << unused;
        const int64_t step = up < UINT64_C(1) << 63
                                 ? (int64_t)(up >> unused)
                                 : -(int64_t)(~up >> unused) - 1;
        one += step == 1;
        /* No sum of steps leaves 64 bits. */
        t->ticks[i] = step > INT64_MAX / (int64_t)TRIAL ||
                              step < -INT64_MAX / (int64_t)TRIAL
                          ? t->ticks[i - 1]
                          : t->ticks[i - 1] + step;
        last = now;
    }
    for (size_t i = 1; i < t->start_count; i++) {
        course.back += t->ticks[t->starts[i]] < t->ticks[t->starts[i - 1]];
    }
    course.is_counter = (double)one > COUNTS * (double)t->count;
    return course;
}

/* --- Following the time of capture --- */

double lum_infer_deviation(double *values, size_t n)
{
    const double middle = lum_infer_quantile(values, n, 0.5);
    for (size_t i = 0; i < n; i++) {
        values[i] = fabs(values[i] - middle);
    }
    return lum_infer_quantile(values, n, 0.5);
}

/* How much of half of the time the steps between times are, where packets are
 * handed over in batches: most lines then begin at one time with the next of
 * their eye. */
static double step_of_times(const lum_infer_ticks *t)
{
    size_t equal = 0;
    size_t steps = 0;
    const double mean = 2.0 * t->span_ns / (double)t->start_count;
    for (size_t i = 2; i < t->start_count; i++) {
        const double gap =
            (double)(t->times[t->starts[i]] - t->times[t->starts[i - 2]]);
        equal += gap < 0.25 * mean;
        steps += gap >= mean;
    }
    return equal * 2 < t->start_count || steps == 0 ? 0.0 : 4.0 / (double)steps;
}

/* The length of a tick: the median of what pairs of lines half of the capture
 * apart say.
 * @return false where they say nothing. */
static bool measure_slope(lum_infer_ticks *t, lum_infer_fit *out)
{
    const size_t half = t->start_count / 2;
    size_t n = 0;
    for (size_t i = 0; i + half < t->start_count; i++) {
        const size_t a = t->starts[i];
        const size_t b = t->starts[i + half];
        const int64_t ticks = t->ticks[b] - t->ticks[a];
        if (ticks != 0) {
            t->sorted[n++] =
                (double)(t->times[b] - t->times[a]) / (double)ticks;
        }
    }
    if (n == 0 || n * 2 < t->start_count - half) {
        return false;
    }
    out->tick_ns = lum_infer_quantile(t->sorted, n, 0.5);
    out->spread = (lum_infer_quantile(t->sorted, n, 0.75) -
                   lum_infer_quantile(t->sorted, n, 0.25)) /
                  out->tick_ns;
    const double step = step_of_times(t);
    out->spread = step > out->spread ? step : out->spread;
    return out->tick_ns > 0.0;
}

/* How far lines lie from the time of capture, as a share of the span. */
static double stray(lum_infer_ticks *t, double tick_ns)
{
    for (size_t i = 0; i < t->start_count; i++) {
        const size_t at = t->starts[i];
        t->sorted[i] = (double)(t->times[at] - t->times[0]) -
                       tick_ns * (double)t->ticks[at];
    }
    return t->span_ns <= 0.0
               ? 1.0
               : lum_infer_deviation(t->sorted, t->start_count) / t->span_ns;
}

/* The share of steps back: from line to line any, and from packet to packet
 * those that are longer than lines are apart. Clocks of the eyes, whose packets
 * take turns, may be some us apart. */
static double share_back(const lum_infer_ticks *t, lum_infer_course course,
                         double tick_ns)
{
    const double line_ns = t->span_ns / (double)t->start_count;
    size_t back = 0;
    for (size_t i = 1; i < t->count; i++) {
        back += (double)(t->ticks[i - 1] - t->ticks[i]) * tick_ns > line_ns;
    }
    const double of_lines = (double)course.back / (double)t->start_count;
    const double of_packets = (double)back / (double)t->count;
    return of_lines > of_packets ? of_lines : of_packets;
}

bool lum_infer_fit_time(lum_infer_ticks *t, lum_field field, lum_infer_fit *out)
{
    const lum_infer_course course = lum_infer_extend(t, field);
    if (!measure_slope(t, out)) {
        return false;
    }
    out->off = stray(t, out->tick_ns);
    out->back = share_back(t, course, out->tick_ns);
    out->is_counter = course.is_counter;
    return out->off < STRAY && out->back < BACK;
}
