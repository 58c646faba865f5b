/* Which bits tell the eye and which the line number: all ways to read them,
 * and the one that explains most lines. */
#include "fields.h"
#include "starts.h"
#include "ticks.h"

#include <stdlib.h>

/* What custom has against a reading. It decides between readings that explain
 * about as much, and is no part of what they explain: an eye is rather told by
 * bits that nothing else changes beside, a sensor has two eyes, and line
 * numbers begin again with each frame. */
#define BUSY_EYE 0.1
#define ONE_EYE  0.1
#define ONWARD   0.06

/* Eyes that take turns less often are not looked at. */
#define TURNS_MIN 0.4

/* Most readings that are kept. */
#define READINGS_MAX 256u

/* Readings are equal if they give this share of lines the same eyes, up to a
 * swap, and the same numbers. */
#define EQUAL 0.95

/* A reading that explains less is none: rather one of the clock's bits tells
 * the eye. */
#define ENOUGH 0.8

/* Of two elevations, in percent, the smaller change against the larger one, if
 * only every second line changes it. */
#define PAIRED 20

/* A line number and the bit that tells the eye. */
typedef struct reading {
    lum_infer_line line;
    unsigned eye_bit;
    double turns;  /* share of lines at which the eye changes */
    double share;  /* what it explains, as measured */
    double weight; /* what custom has against it */
} reading;

typedef struct finder {
    lum_infer_state *state;
    lum_infer_starts starts;
    const lum_infer_bits *clock; /* bits that are neither eye nor line */
    bool is_paired;              /* there cannot be one eye alone */
    reading *readings;
    size_t count;
    double *steps; /* room for twice as many as starts */
} finder;

/* --- One eye that was dealt to two --- */

/* How far apart in elevation lines of one number of both eyes are, against the
 * next lines of an eye: about half, if there is only one eye, whose lines were
 * dealt to two. */
static bool is_interleaved(const finder *f, const lum_infer_line *line,
                           unsigned eye_bit)
{
    const size_t count = f->starts.count;
    double *near = f->steps;
    double *next = f->steps + count;
    size_t n = 0;
    for (size_t i = 2; i < count; i++) {
        const lum_infer_packet *const *p = &f->starts.at[i - 2];
        const unsigned eye = lum_infer_bit_of(p[0], eye_bit);
        if (eye != lum_infer_bit_of(p[1], eye_bit) &&
            eye == lum_infer_bit_of(p[2], eye_bit) &&
            lum_infer_value(p[0]->bytes, line->field) ==
                lum_infer_value(p[1]->bytes, line->field)) {
            near[n] = abs(p[1]->calm - p[0]->calm);
            next[n] = abs(p[2]->calm - p[0]->calm);
            n++;
        }
    }
    if (n == 0) {
        return false;
    }
    const double one = lum_infer_quantile(near, n, 0.5);
    const double two = lum_infer_quantile(next, n, 0.5);
    return one * 100 > two * 35 && one * 100 < two * 65;
}

/* Whether elevations change at every second line alone: both eyes' lines are
 * taken for those of one. */
static bool is_paired(const finder *f)
{
    size_t n = 0;
    for (size_t i = 2; i < f->starts.count; i++) {
        const lum_infer_packet *const *p = &f->starts.at[i - 2];
        const int one = abs(p[1]->calm - p[0]->calm);
        const int two = abs(p[2]->calm - p[1]->calm);
        const int more = one > two ? one : two;
        if (more > 0) {
            const int percent = 100 * (one < two ? one : two) / more;
            f->steps[n++] = percent;
        }
    }
    return n > 0 && lum_infer_quantile(f->steps, n, 0.5) < PAIRED;
}

/* --- All readings --- */

/* Whether the byte of an eye's bit has others that change from line to line,
 * and are no part of a field that is known. */
static bool is_busy(const finder *f, const reading *r)
{
    const lum_infer_bits line = lum_infer_bits_of(r->line.field);
    const unsigned at = r->eye_bit / 8u;
    const unsigned known = line.byte[at] | f->state->used.byte[at];
    return (lum_infer_changing(&f->starts, at, r->eye_bit, NULL) & ~known) != 0;
}

static double weight_of(const finder *f, const reading *r)
{
    const double line =
        r->line.weight + (lum_infer_begins_again(r->line.steps) ? 0.0 : ONWARD);
    if (r->eye_bit == LUM_INFER_HEAD_BITS) {
        return line + ONE_EYE;
    }
    return line + (is_busy(f, r) ? BUSY_EYE : 0.0);
}

static double rank_of(const reading *r)
{
    return r->share - r->weight;
}

/* Keep a reading, in place of the worst one if there are too many. */
static void keep(finder *f, const reading *r)
{
    if (f->count < READINGS_MAX) {
        f->readings[f->count++] = *r;
        return;
    }
    size_t worst = 0;
    for (size_t i = 1; i < f->count; i++) {
        if (rank_of(&f->readings[i]) < rank_of(&f->readings[worst])) {
            worst = i;
        }
    }
    if (rank_of(r) > rank_of(&f->readings[worst])) {
        f->readings[worst] = *r;
    }
}

static bool is_possible(const finder *f, const lum_infer_line *line,
                        unsigned eye_bit)
{
    if (line->field.bytes == 0) {
        return false;
    }
    return eye_bit == LUM_INFER_HEAD_BITS ? !f->is_paired
                                          : !is_interleaved(f, line, eye_bit);
}

static void try_split(finder *f, unsigned eye_bit, double turns)
{
    const lum_infer_starts *starts = &f->starts;
    const lum_infer_bits eye_bits = lum_infer_eye_bits(starts, eye_bit);
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         bit < 8u * f->state->samples.at; bit++) {
        if (!lum_infer_is_lowest(starts, bit, eye_bit, &eye_bits)) {
            continue;
        }
        reading r = {.eye_bit = eye_bit, .turns = turns};
        r.line =
            lum_infer_try_lowest(starts, bit, eye_bit, &eye_bits, f->clock);
        if (!is_possible(f, &r.line, eye_bit)) {
            continue;
        }
        const double share = lum_infer_share_of_steps(r.line.steps);
        r.share = share < turns ? share : turns;
        r.weight = weight_of(f, &r);
        keep(f, &r);
    }
}

/* @param clock bits that are neither the eye nor part of a line number. */
static void try_all(finder *f, const lum_infer_bits *clock)
{
    unsigned splits[LUM_INFER_SPLITS_MAX];
    const size_t n = lum_infer_find_splits(&f->starts, clock, splits);
    f->clock = clock;
    f->count = 0;
    for (size_t i = 0; i < n; i++) {
        const double turns =
            splits[i] == LUM_INFER_HEAD_BITS
                ? 1.0
                : lum_infer_share_of_turns(&f->starts, splits[i]);
        if (turns >= TURNS_MIN) {
            try_split(f, splits[i], turns);
        }
    }
}

/* --- The best, and what competes with it --- */

/* Of two that explain the same, that of the lower numbers: a clock that ticks
 * once a line rises as a line number does, from any number on. */
static bool is_lower(const finder *f, const reading *a, const reading *b)
{
    const uint8_t *bytes = f->starts.at[f->starts.count / 2]->bytes;
    return lum_infer_value(bytes, a->line.field) <
           lum_infer_value(bytes, b->line.field);
}

static const reading *find_best(const finder *f)
{
    const reading *best = f->readings;
    for (size_t i = 1; i < f->count; i++) {
        const reading *r = &f->readings[i];
        const double more = rank_of(r) - rank_of(best);
        if (more > 1e-9 || (more > -1e-9 && is_lower(f, r, best))) {
            best = r;
        }
    }
    return f->count == 0 ? NULL : best;
}

static bool is_same_eyes(const finder *f, const reading *a, const reading *b)
{
    return a->eye_bit == b->eye_bit ||
           lum_infer_is_same_split(&f->starts, a->eye_bit, b->eye_bit);
}

static bool is_same_lines(const finder *f, const reading *a, const reading *b)
{
    size_t same = 0;
    for (size_t i = 0; i < f->starts.count; i++) {
        const uint8_t *bytes = f->starts.at[i]->bytes;
        same += lum_infer_value(bytes, a->line.field) ==
                lum_infer_value(bytes, b->line.field);
    }
    return (double)same >= EQUAL * (double)f->starts.count;
}

static void describe(const finder *f, const reading *r, lum_infer_reading *out)
{
    lum_infer_bits used = f->state->used;
    lum_infer_add_bits(&used, r->line.field);
    out->line = r->line.field;
    out->share = r->share;
    out->is_one_eye = r->eye_bit == LUM_INFER_HEAD_BITS;
    if (!out->is_one_eye) {
        out->eye = lum_infer_eye_field(&f->starts, &used, f->clock, r->eye_bit,
                                       &out->equal_eye);
        lum_infer_eye_values(&f->starts, out->eye, r->eye_bit, out->eye_value);
    }
}

/* A number that goes on rising where elevations begin again does not compete
 * with one that falls there. */
static bool is_rival(const reading *r, const reading *best)
{
    return lum_infer_begins_again(r->line.steps) ||
           !lum_infer_begins_again(best->line.steps);
}

/* Remember a reading of other eyes or other lines. */
static void compete(const finder *f, const reading *r, lum_infer_reading *rival)
{
    if (r->share > rival->share) {
        *rival = (lum_infer_reading){.share = 0.0};
        describe(f, r, rival);
    }
}

static void find_rivals(const finder *f, const reading *best,
                        lum_infer_readings *out)
{
    for (size_t i = 0; i < f->count; i++) {
        const reading *r = &f->readings[i];
        const bool is_same_eye = is_same_eyes(f, r, best);
        const bool is_same_line = is_same_lines(f, r, best);
        if (!is_same_eye && is_rival(r, best)) {
            compete(f, r, &out->other_eye);
        }
        if (!is_same_line && is_rival(r, best)) {
            compete(f, r, &out->other_line);
        } else if (is_same_line && is_same_eye &&
                   r->line.lowest != best->line.lowest) {
            out->equal_line = r->line.field;
        }
    }
}

/* --- The fields --- */

static void settle(finder *f, const reading *best)
{
    lum_infer_state *state = f->state;
    lum_infer_readings *all = &state->readings;
    lum_infer_choice *line = &state->field[LUM_FIELD_LINE];
    lum_infer_choice *eye = &state->field[LUM_FIELD_EYE];
    find_rivals(f, best, all);
    describe(f, best, &all->best);
    line->field = best->line.field;
    line->share = lum_infer_share_of_steps(best->line.steps);
    line->second = all->other_line.share;
    line->rival = all->other_line.line;
    eye->share = best->turns;
    eye->second = all->other_eye.share;
    eye->rival = all->other_eye.eye;
    all->steps = best->line.steps.all;
    lum_infer_add_bits(&state->used, line->field);
    if (!all->best.is_one_eye) {
        eye->field = all->best.eye;
        lum_infer_add_bits(&state->used, eye->field);
    }
}

static void find(finder *f)
{
    static const lum_infer_bits none = {{0}};
    f->state->readings.lines = f->starts.count;
    f->is_paired = is_paired(f);
    try_all(f, &f->state->clock.varying);
    const reading *best = find_best(f);
    if (best == NULL || best->share < ENOUGH) {
        try_all(f, &none);
        best = find_best(f);
    }
    if (best != NULL) {
        settle(f, best);
    }
}

int lum_infer_find_lines(lum_infer_state *state)
{
    finder f = {.state = state};
    f.readings = malloc(READINGS_MAX * sizeof *f.readings);
    f.steps = malloc(2u * LUM_INFER_STARTS_MAX * sizeof *f.steps);
    const bool failed = lum_infer_find_starts(state, &f.starts) != 0 ||
                        f.readings == NULL || f.steps == NULL;
    if (!failed) {
        find(&f);
    }
    lum_infer_free_starts(&f.starts);
    free(f.readings);
    free(f.steps);
    return failed ? -1 : 0;
}

int lum_infer_place_one_eye(lum_infer_state *state)
{
    lum_infer_starts starts;
    if (!state->readings.best.is_one_eye) {
        return 0;
    }
    const int r = lum_infer_find_starts(state, &starts);
    if (r == 0) {
        lum_infer_take_one_eye(state, &starts);
    }
    lum_infer_free_starts(&starts);
    return r;
}
