/* Runs of points of a packed frame, and the order in which they are sent. */
#include "packed_internal.h"

#include "base/grow.h"

#include <math.h>
#include <stdlib.h>

#define RUN_MAX 4096u /* points; with all their pixels less than a piece */
#define FINEST  12u   /* step */
#define FAR     1073741824.0 /* steps from the origin that a run can begin */

#define KINDS_SEEN 16u

/* --- Where they end --- */

/* What follows a point in its line. */
static uint32_t count_line(const lum_packed_part *part, size_t begin)
{
    const size_t left = part->count - begin;
    const uint32_t most = left < RUN_MAX ? (uint32_t)left : RUN_MAX;
    const uint32_t *line = part->line + begin;
    const uint16_t *pixel = part->pixel + begin;
    const uint8_t *eye = part->eye + begin;
    uint32_t n = 1;
    while (n < most && line[n] == line[0] && eye[n] == eye[0] &&
           pixel[n] >= pixel[n - 1u]) {
        n++;
    }
    return n;
}

struct bounds {
    float low[LUM_PACKED_AXES];
    float high[LUM_PACKED_AXES];
};

static void bound(const lum_packed_run *run, struct bounds *out)
{
    for (unsigned axis = 0; axis < LUM_PACKED_AXES; axis++) {
        const float *at = lum_packed_axis(run->part, axis) + run->begin;
        float low = INFINITY;
        float high = -INFINITY;
        for (uint32_t i = 0; i < run->count; i++) {
            low = at[i] < low ? at[i] : low;
            high = at[i] > high ? at[i] : high;
        }
        out->low[axis] = low <= high ? low : 0.0f;
        out->high[axis] = low <= high ? high : 0.0f;
    }
}

static double steps_of(float at, unsigned exponent)
{
    const double steps = floor((double)at * (double)(1u << exponent) + 0.5);
    const double low = steps > -FAR ? steps : -FAR;
    return low < FAR ? low : FAR;
}

/* Whether 18 bits reach over the run. */
static bool fits(lum_packed_run *run, const struct bounds *bounds,
                 unsigned exponent)
{
    bool does_fit = true;
    for (unsigned axis = 0; axis < LUM_PACKED_AXES; axis++) {
        const double low = steps_of(bounds->low[axis], exponent);
        const double high = steps_of(bounds->high[axis], exponent);
        run->origin[axis] = (int32_t)low;
        does_fit = does_fit && high - low <= LUM_PACKED_STEPS_MAX &&
                   low > -FAR && high < FAR;
    }
    run->exponent = (uint8_t)exponent;
    return does_fit;
}

/* A point alone always has an origin. */
static void place(lum_packed_run *run)
{
    struct bounds bounds;
    bool does_fit = false;
    for (;;) {
        bound(run, &bounds);
        for (unsigned e = FINEST; e >= LUM_PACKED_COARSEST && !does_fit; e--) {
            does_fit = fits(run, &bounds, e);
        }
        if (does_fit || run->count == 1) {
            return;
        }
        run->count /= 2u;
    }
}

/* --- Kinds and pixels --- */

struct seen {
    uint16_t kind[KINDS_SEEN];
    uint32_t times[KINDS_SEEN];
    size_t count;
};

/* Those beyond the first few kinds of a run are not among its most frequent
 * ones. */
static void see(struct seen *seen, const lum_packed_run *run)
{
    size_t at = 0;
    for (uint32_t i = 0; i < run->count; i++) {
        const uint16_t kind = lum_packed_kind(run->part, run->begin + i);
        if (at >= seen->count || seen->kind[at] != kind) {
            at = 0;
            while (at < seen->count && seen->kind[at] != kind) {
                at++;
            }
        }
        if (at == seen->count && at < KINDS_SEEN) {
            seen->kind[at] = kind;
            seen->count++;
        }
        if (at < seen->count) {
            seen->times[at]++;
        }
    }
}

static void choose_kinds(lum_packed_run *run)
{
    struct seen seen = {.count = 0};
    uint32_t covered = 0;
    see(&seen, run);
    for (size_t k = 0; k < LUM_PACKED_KINDS; k++) {
        size_t best = 0;
        for (size_t i = 1; i < seen.count; i++) {
            best = seen.times[i] > seen.times[best] ? i : best;
        }
        run->kinds[k] = seen.kind[best];
        covered += seen.times[best];
        seen.times[best] = 0;
    }
    run->others = run->count - covered;
}

static void measure_pixels(lum_packed_run *run)
{
    const uint16_t *pixel = run->part->pixel + run->begin;
    const uint32_t bits = run->count + pixel[run->count - 1u] - pixel[0];
    run->pixel_bytes = (bits + 7u) / 8u;
}

static lum_result add_run(lum_packed_runs *runs, const lum_packed_run *run)
{
    lum_packed_run *at =
        lum_grown(runs->at, runs->count, 1, sizeof *at, &runs->room);
    if (at == NULL) {
        return LUM_E_SPACE;
    }
    runs->at = at;
    runs->at[runs->count++] = *run;
    return LUM_OK;
}

/* --- Their order --- */

static uint32_t reverse(uint32_t bits)
{
    uint32_t out = 0;
    for (unsigned i = 0; i < 32u; i++) {
        out |= (bits >> i & 1u) << (31u - i);
    }
    return out;
}

/* Of each eye the first line, then that in the middle, then those in the middle
 * of the halves, and so on. */
lum_result lum_packed_runs_add(lum_packed_runs *runs,
                               const lum_packed_part *part, uint32_t first)
{
    uint32_t ranks[2] = {0, 0};
    lum_result result = LUM_OK;
    for (size_t i = 0; i < part->count && result == LUM_OK;) {
        lum_packed_run run = {.part = part,
                              .begin = (uint32_t)i,
                              .first = first + (uint32_t)i,
                              .count = count_line(part, i)};
        place(&run);
        choose_kinds(&run);
        measure_pixels(&run);
        run.order = reverse(ranks[part->eye[i] & 1u]++);
        result = add_run(runs, &run);
        i += run.count;
    }
    return result;
}

static int compare(const void *a, const void *b)
{
    const lum_packed_run *one = a;
    const lum_packed_run *other = b;
    if (one->order != other->order) {
        return one->order < other->order ? -1 : 1;
    }
    return one->first < other->first ? -1 : 1;
}

void lum_packed_runs_sort(lum_packed_runs *runs)
{
    if (runs->count > 0) {
        qsort(runs->at, runs->count, sizeof *runs->at, compare);
    }
}
