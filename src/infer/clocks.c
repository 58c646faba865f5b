#include "clocks.h"

#include "fields.h"

#include <stdlib.h>
#include <string.h>

/* Packets that a clock is looked for in; one after the other, since a narrow
 * one wraps. */
#define TRIAL 4000u

/* Fewer packets tell no clock. */
#define CLOCK_MIN 16u

/* Fewer lines lie on too many lines. */
#define STARTS_MIN 5u

/* Times of capture are late by milliseconds, so a unit that is not round is
 * believed of a capture this long. */
#define LONG_NS INT64_C(100000000)

/* How far from a line a clock's packets may lie, as a share of the time that
 * they span. Packets that are sent in batches are late by some of that; what
 * is no clock does not follow a line at all. */
#define STRAY 0.2

/* Disorder and corruption turn fewer steps back than this. */
#define BACK 0.25

/* How much worse a clock is whose byte order is not that of the counts. */
#define OTHER_ORDER 0.05

/* What is as good as the best. */
#define NEAR 0.1

/* A unit this near to a round one is that. */
#define ROUND 0.02

/* In a short capture it is the likeliest so near to what was measured. */
#define ROUGH 0.1

/* A clock of one byte wraps between lines, and then any unit can fit. */
#define BYTE_BITS 8u

/* Clocks of fewer bits may wrap between two lines, unseen. */
#define NARROW_BITS 17u

/* How a candidate follows the time of capture. */
typedef struct trial {
    lum_field field;
    double badness;   /* of the line, and of steps back */
    double unit_ns;   /* length of a tick */
    unsigned varying; /* bits that change */
    unsigned bits;    /* of the field */
} trial;

typedef struct watch {
    const lum_infer_state *state;
    lum_infer_packet *const *packets;
    size_t count;
    int64_t *ticks; /* extended, of each */
    double *sorted; /* room to sort in */
    size_t *starts; /* which of them begin lines */
    size_t start_count;
    double ones[8 * LUM_INFER_HEAD_BYTES];
} watch;

/* --- Following the time of capture --- */

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, size_t n)
{
    qsort(values, n, sizeof *values, compare);
    return values[n / 2];
}

static unsigned bits_of(lum_field field)
{
    return field.bits != 0 ? field.bits : 8u * field.bytes;
}

/* @return steps back. */
static size_t extend(const watch *w, lum_field field)
{
    const unsigned bits = bits_of(field);
    uint64_t last = lum_infer_value(w->packets[0]->bytes, field);
    size_t back = 0;
    w->ticks[0] = 0;
    for (size_t i = 1; i < w->count; i++) {
        const uint64_t now = lum_infer_value(w->packets[i]->bytes, field);
        const uint64_t up = (now - last) << (64u - bits);
        const int64_t step = up < UINT64_C(1) << 63
                                 ? (int64_t)(up >> (64u - bits))
                                 : -(int64_t)(~up >> (64u - bits)) - 1;
        back += step < 0;
        /* No sum of steps leaves 64 bits. */
        w->ticks[i] = step > INT64_MAX / (int64_t)TRIAL ||
                              step < -INT64_MAX / (int64_t)TRIAL
                          ? w->ticks[i - 1]
                          : w->ticks[i - 1] + step;
        last = now;
    }
    return back;
}

/* The length of a tick: the median of what pairs of lines half of the capture
 * apart say. */
static double slope(const watch *w)
{
    const size_t half = w->start_count / 2;
    size_t n = 0;
    for (size_t i = 0; i + half < w->start_count; i++) {
        const size_t a = w->starts[i];
        const size_t b = w->starts[i + half];
        const int64_t ticks = w->ticks[b] - w->ticks[a];
        if (ticks != 0) {
            w->sorted[n] =
                (double)(w->packets[b]->time_ns - w->packets[a]->time_ns) /
                (double)ticks;
            n++;
        }
    }
    return n * 2 < w->start_count - half ? 0.0 : median(w->sorted, n);
}

/* How far lines lie from it, as a share of the span. */
static double stray(const watch *w, double unit_ns)
{
    const int64_t zero = w->packets[0]->time_ns;
    const double span = (double)(w->packets[w->count - 1]->time_ns - zero);
    const size_t n = w->start_count;
    for (size_t i = 0; i < n; i++) {
        w->sorted[i] = (double)(w->packets[w->starts[i]]->time_ns - zero) -
                       unit_ns * (double)w->ticks[w->starts[i]];
    }
    const double middle = median(w->sorted, n);
    for (size_t i = 0; i < n; i++) {
        const double off = w->sorted[i] - middle;
        w->sorted[i] = off < 0 ? -off : off;
    }
    return span <= 0.0 ? 1.0 : median(w->sorted, n) / span;
}

/* --- Bits of a clock --- */

static void count_ones(watch *w)
{
    for (unsigned bit = 0; bit < 8u * LUM_INFER_HEAD_BYTES; bit++) {
        size_t n = 0;
        for (size_t i = 0; i < w->count; i++) {
            n += w->packets[i]->bytes[bit / 8u] >> bit % 8u & 1u;
        }
        w->ones[bit] = (double)n / (double)w->count;
    }
}

static bool is_varying(const watch *w, unsigned bit)
{
    return w->ones[bit] > 0.01 && w->ones[bit] < 0.99;
}

/* Bits that change; 0 where the lowest byte does not, since the clock then
 * begins above it. */
static unsigned count_varying(const watch *w, lum_field field)
{
    const unsigned bits = bits_of(field);
    unsigned n = 0;
    unsigned lowest = 0;
    for (unsigned i = 0; i < bits; i++) {
        const bool is = is_varying(w, lum_infer_bit_at(field, field.low + i));
        n += is;
        lowest += is && i < 8;
    }
    return lowest == 0 ? 0 : n;
}

/* The highest bit that is ever 1. */
static unsigned top_bit(const watch *w, lum_field field)
{
    unsigned bits = bits_of(field);
    while (bits > 1 &&
           w->ones[lum_infer_bit_at(field, field.low + bits - 1u)] < 0.03) {
        bits--;
    }
    return bits - 1u;
}

/* Whether a byte has the bits of another in all packets. */
static bool is_same_byte(const watch *w, unsigned a, unsigned b)
{
    for (unsigned i = 0; i < 8; i++) {
        if (is_varying(w, 8u * a + i) || is_varying(w, 8u * b + i) ||
            (w->ones[8u * a + i] >= 0.5) != (w->ones[8u * b + i] >= 0.5)) {
            return false;
        }
    }
    return true;
}

/* The highest two bytes bear what stands between other fields too, and that is
 * not 0. */
static bool is_filler(const watch *w, lum_field field)
{
    const unsigned bits = bits_of(field);
    if (bits < 24) {
        return false;
    }
    const unsigned one = lum_infer_bit_at(field, field.low + bits - 8u) / 8u;
    const unsigned two = lum_infer_bit_at(field, field.low + bits - 16u) / 8u;
    bool is_zero = true;
    bool is_elsewhere = false;
    for (unsigned i = 0; i < 8; i++) {
        is_zero = is_zero && w->ones[8u * one + i] < 0.5;
    }
    for (unsigned at = LUM_INFER_FIELDS_AT; at < w->state->samples.at; at++) {
        is_elsewhere =
            is_elsewhere ||
            ((at < field.at || at >= (unsigned)field.at + field.bytes) &&
             w->state->used.byte[at] == 0 && is_same_byte(w, at, one));
    }
    return !is_zero && is_elsewhere && is_same_byte(w, one, two);
}

/* What stands above the highest bit that changes can be part of a clock: of
 * eight bytes, the highest two are 0 for days. */
static bool is_clean_above(const watch *w, lum_field field)
{
    unsigned bits = bits_of(field);
    while (bits > 0) {
        const unsigned at = lum_infer_bit_at(field, field.low + bits - 1u);
        if (is_varying(w, at)) {
            return true;
        }
        if (w->ones[at] >= 0.5) {
            return !is_filler(w, field) &&
                   (bits <= 32 || (bits_of(field) == 64 && bits <= 48));
        }
        bits--;
    }
    return false;
}

/* Four bytes, as the manual's clock has; eight of ticks so short that four
 * would wrap every few seconds, where something stands above four. */
static unsigned plainness(const watch *w, const trial *t)
{
    if (t->field.bytes == 8) {
        return t->unit_ns < LUM_INFER_SHORT_TICK_NS &&
                       top_bit(w, t->field) >= 32
                   ? 2u
                   : 0u;
    }
    return t->field.bytes == 4 ? 1u : 0u;
}

/* --- The best clock --- */

static double round_unit(double unit_ns, double tolerance)
{
    static const unsigned digits[] = {1, 2, 5};
    uint64_t ten = 1;
    for (unsigned i = 0; i < 28; i++) {
        const double unit = (double)(digits[i % 3] * ten);
        if (unit_ns > unit * (1.0 - tolerance) &&
            unit_ns < unit * (1.0 + tolerance)) {
            return unit;
        }
        ten = i % 3 == 2 ? 10 * ten : ten;
    }
    return 0.0;
}

/* Of two clocks that follow time alike: round ticks, then the one with more
 * bits that change, then the plainer. */
static bool is_more(const watch *w, const trial *a, const trial *b)
{
    const bool is_round = round_unit(a->unit_ns, ROUND) > 0.0;
    if (is_round != (round_unit(b->unit_ns, ROUND) > 0.0)) {
        return is_round;
    }
    return a->varying != b->varying ? a->varying > b->varying
                                    : plainness(w, a) > plainness(w, b);
}

static void offer(const watch *w, trial *best, const trial *t)
{
    const double less = best->badness - t->badness;
    if (best->field.bytes == 0 || less >= NEAR ||
        (less > -NEAR && is_more(w, t, best))) {
        *best = *t;
    }
}

static bool is_usual_order(const watch *w, lum_field field)
{
    return field.bytes == 1 ||
           field.order ==
               w->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.order;
}

static void try_field(const watch *w, lum_field field, trial *best)
{
    trial t = {.field = field, .bits = bits_of(field)};
    t.varying = count_varying(w, field);
    if (t.varying < 2 || !is_clean_above(w, field)) {
        return;
    }
    const size_t back = extend(w, field);
    t.unit_ns = slope(w);
    if (t.unit_ns <= 0.0) {
        return;
    }
    t.badness = stray(w, t.unit_ns);
    const double turned = (double)back / (double)w->count;
    if (t.badness < STRAY && turned < BACK) {
        t.badness += turned + (is_usual_order(w, field) ? 0.0 : OTHER_ORDER);
        offer(w, best, &t);
    }
}

/* The whole field, or the bits above those that others have taken. */
static void try_base(const watch *w, lum_field base, trial *best)
{
    if (lum_infer_is_free(w->state, base)) {
        try_field(w, base, best);
    }
}

static void take_unit(lum_infer_state *state, const trial *best)
{
    const double rounded = round_unit(best->unit_ns, ROUND);
    state->unit_ns = best->unit_ns;
    state->unit_taken = 1000;
    state->is_unit_told = best->bits > BYTE_BITS;
    if (rounded > 0.0) {
        state->unit_taken = (uint32_t)rounded;
    } else if (best->bits >= NARROW_BITS && state->time_ns >= LONG_NS &&
               best->unit_ns >= 1.0 && best->unit_ns <= 1e9) {
        state->unit_taken = (uint32_t)(best->unit_ns + 0.5);
    } else {
        const double guess = round_unit(best->unit_ns, ROUGH);
        state->is_unit_told = false;
        state->unit_taken = guess > 0.0 ? (uint32_t)guess : 1000u;
    }
}

/* The packets of the sensor that sent most, not more than are needed. */
static void choose(watch *w)
{
    const lum_infer_packets *good = &w->state->good;
    size_t from = 0;
    for (size_t i = 0, begin = 0; i <= good->count; i++) {
        if (i == good->count ||
            good->at[i]->sensor != good->at[begin]->sensor) {
            if (i - begin > w->count) {
                w->count = i - begin;
                from = begin;
            }
            begin = i;
        }
    }
    w->packets = good->at + from;
    w->count = w->count < TRIAL ? w->count : TRIAL;
}

static void find_starts(watch *w)
{
    const lum_field first = w->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field;
    for (size_t i = 0; i < w->count; i++) {
        const lum_infer_packet *p = w->packets[i];
        if (p->kind == LUM_INFER_ANGLES &&
            lum_infer_value(p->bytes, first) == 0) {
            w->starts[w->start_count] = i;
            w->start_count++;
        }
    }
}

/* --- Lines by the clock --- */

/* How long lines last by the clock: from the first to the last packet of each
 * run of one line. All but a tenth of the lines, which may have a packet whose
 * clock is corrupt. */
static void measure_lines(lum_infer_state *state, const watch *w)
{
    const lum_field line = state->field[LUM_FIELD_LINE].field;
    const lum_field eye = state->field[LUM_FIELD_EYE].field;
    size_t n = 0;
    size_t begin = 0;
    (void)extend(w, state->field[LUM_FIELD_TIMESTAMP].field);
    for (size_t i = 1; i < w->count; i++) {
        const uint8_t *a = w->packets[begin]->bytes;
        const uint8_t *b = w->packets[i]->bytes;
        if (lum_infer_value(a, line) != lum_infer_value(b, line) ||
            lum_infer_value(a, eye) != lum_infer_value(b, eye)) {
            w->sorted[n] = (double)(w->ticks[i - 1] - w->ticks[begin]) *
                           state->unit_taken / 1000.0;
            n++;
            begin = i;
        }
    }
    if (n > 0) {
        qsort(w->sorted, n, sizeof *w->sorted, compare);
        state->line_us = w->sorted[n - n / 10 - 1];
    }
}

static void look(lum_infer_state *state, watch *w)
{
    lum_infer_choice *clock = &state->field[LUM_FIELD_TIMESTAMP];
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(state, whole);
    trial best = {.badness = 1.0};
    count_ones(w);
    state->time_ns = w->packets[w->count - 1]->time_ns - w->packets[0]->time_ns;
    if (w->start_count < STARTS_MIN) {
        return;
    }
    for (size_t i = 0; i < n; i++) {
        try_base(w, whole[i], &best);
    }
    if (best.field.bytes > 0) {
        clock->field = best.field;
        clock->share = 1.0 - best.badness;
        lum_infer_take(state, best.field);
        take_unit(state, &best);
        measure_lines(state, w);
    }
}

/* A line lasts less than this (docs/protocol.md, "Reassembly"). */
#define GAP_US 100000.0

static uint32_t span_of(double line_us)
{
    const double twice = 2.0 * line_us;
    return twice <= 2000.0 || twice >= GAP_US
               ? 2000u
               : (uint32_t)(twice / 100.0 + 1.0) * 100u;
}

int lum_infer_find_clock(lum_infer_state *state)
{
    watch w = {.state = state};
    state->unit_taken = 1000;
    choose(&w);
    if (w.count >= CLOCK_MIN) {
        w.ticks = malloc(w.count * sizeof *w.ticks);
        w.sorted = malloc(w.count * sizeof *w.sorted);
        w.starts = malloc(w.count * sizeof *w.starts);
        const bool failed =
            w.ticks == NULL || w.sorted == NULL || w.starts == NULL;
        if (!failed) {
            find_starts(&w);
            look(state, &w);
        }
        free(w.ticks);
        free(w.sorted);
        free(w.starts);
        if (failed) {
            return -1;
        }
    }
    state->line_span_us = span_of(state->line_us);
    return 0;
}
