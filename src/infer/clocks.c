#include "clocks.h"

#include "fields.h"
#include "spans.h"
#include "ticks.h"

#include <stdlib.h>
#include <string.h>

/* Fewer packets tell no clock. */
#define CLOCK_MIN 16u

/* Fewer lines lie on too many lines. */
#define STARTS_MIN 5u

/* How far from a line a clock's packets may lie, as a share of the time that
 * they span. Packets that are sent in batches are late by some of that; what
 * is no clock does not follow a line at all. */
#define STRAY 0.2

/* Disorder and corruption turn fewer lines back than this. */
#define BACK 0.25

/* A field that rises by 1 in this share of packets counts them. */
#define COUNTS 0.75

/* How much worse a clock is whose byte order is not that of the counts. */
#define OTHER_ORDER 0.05

/* What is as good as the best. */
#define NEAR 0.1

/* A unit this near to a round one is that. */
#define ROUND 0.02

/* If half of what was measured differs by more, the unit is not told, and the
 * round one that is so near is the likeliest. */
#define SPREAD 0.02
#define ROUGH  0.1

/* A clock of one byte wraps between lines, and then any unit can fit. */
#define BYTE_BITS 8u

/* Clocks of fewer bits may wrap between two lines, unseen. */
#define NARROW_BITS 17u

/* A clock's bits that change are more than a line number's, even in a short
 * recording. */
#define CLOCK_BITS 11u

/* Another clock is about as fine with this many bits fewer that change. */
#define FINE_BITS 3u

/* Two clocks whose times differ by less, as a share of what they span, are
 * the same. */
#define SAME 0.001

/* How a candidate follows the time of capture. */
typedef struct trial {
    lum_field field;
    double badness;   /* of the line, and of steps back */
    double unit_ns;   /* length of a tick */
    double spread;    /* share of it by which half of the measures differ */
    unsigned varying; /* bits that change */
    bool is_counter;  /* it counts packets */
} trial;

typedef struct watch {
    const lum_infer_state *state;
    lum_infer_ticks t;
    bool is_first; /* other fields are not known yet */
    double ones[8 * LUM_INFER_HEAD_BYTES];
    lum_infer_bits counts; /* bits of numbers that count packets */
    trial best;
    trial *trials; /* all that follow time */
    size_t count;
} watch;

/* --- Following the time of capture --- */

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
static bool measure_slope(lum_infer_ticks *t, trial *out)
{
    const size_t half = t->start_count / 2;
    size_t n = 0;
    for (size_t i = 0; i + half < t->start_count; i++) {
        const size_t a = t->starts[i];
        const size_t b = t->starts[i + half];
        const int64_t ticks = t->ticks[b] - t->ticks[a];
        if (ticks != 0) {
            t->sorted[n] = (double)(t->times[b] - t->times[a]) / (double)ticks;
            n++;
        }
    }
    if (n == 0 || n * 2 < t->start_count - half) {
        return false;
    }
    out->unit_ns = lum_infer_quantile(t->sorted, n, 0.5);
    out->spread = (lum_infer_quantile(t->sorted, n, 0.75) -
                   lum_infer_quantile(t->sorted, n, 0.25)) /
                  out->unit_ns;
    const double step = step_of_times(t);
    out->spread = step > out->spread ? step : out->spread;
    return out->unit_ns > 0.0;
}

/* The median of how far numbers lie from their median. */
static double deviation(double *values, size_t n)
{
    const double middle = lum_infer_quantile(values, n, 0.5);
    for (size_t i = 0; i < n; i++) {
        values[i] =
            values[i] < middle ? middle - values[i] : values[i] - middle;
    }
    return lum_infer_quantile(values, n, 0.5);
}

/* How far lines lie from the time of capture, as a share of the span. */
static double stray(lum_infer_ticks *t, double unit_ns)
{
    for (size_t i = 0; i < t->start_count; i++) {
        const size_t at = t->starts[i];
        t->sorted[i] = (double)(t->times[at] - t->times[0]) -
                       unit_ns * (double)t->ticks[at];
    }
    return t->span_ns <= 0.0
               ? 1.0
               : deviation(t->sorted, t->start_count) / t->span_ns;
}

/* --- Bits of a clock --- */

static void count_ones(watch *w)
{
    for (unsigned bit = 0; bit < 8u * LUM_INFER_HEAD_BYTES; bit++) {
        size_t n = 0;
        for (size_t i = 0; i < w->t.count; i++) {
            n += w->t.packets[i]->bytes[bit / 8u] >> bit % 8u & 1u;
        }
        w->ones[bit] = (double)n / (double)w->t.count;
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
    const unsigned bits = lum_infer_width(field);
    unsigned n = 0;
    unsigned lowest = 0;
    for (unsigned i = 0; i < bits; i++) {
        const bool changes =
            is_varying(w, lum_infer_bit_at(field, field.low + i));
        n += changes;
        lowest += changes && i < 8;
    }
    return lowest == 0 ? 0 : n;
}

/* The highest bit that is ever 1. */
static unsigned top_bit(const watch *w, lum_field field)
{
    unsigned bits = lum_infer_width(field);
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
    const unsigned bits = lum_infer_width(field);
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
    unsigned bits = lum_infer_width(field);
    while (bits > 0) {
        const unsigned at = lum_infer_bit_at(field, field.low + bits - 1u);
        if (is_varying(w, at)) {
            return true;
        }
        if (w->ones[at] >= 0.5) {
            return !is_filler(w, field) &&
                   (bits <= 32 || (lum_infer_width(field) == 64 && bits <= 48));
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

/* Without times of capture, no length of a tick is rounder than others. */
static bool is_round(const watch *w, const trial *t)
{
    return w->t.has_times && round_unit(t->unit_ns, ROUND) > 0.0;
}

/* Of two clocks that follow time alike: round ticks, then the one with more
 * bits that change, then the plainer. While the line number is not known, which
 * may follow time too, more bits than it has come first. */
static bool is_more(const watch *w, const trial *a, const trial *b)
{
    const bool is_fine = w->is_first && a->varying >= CLOCK_BITS;
    if (w->is_first && is_fine != (b->varying >= CLOCK_BITS)) {
        return is_fine;
    }
    if (is_round(w, a) != is_round(w, b)) {
        return is_round(w, a);
    }
    return a->varying != b->varying ? a->varying > b->varying
                                    : plainness(w, a) > plainness(w, b);
}

static void offer(watch *w, const trial *t)
{
    const double less = w->best.badness - t->badness;
    w->trials[w->count] = *t;
    w->count++;
    if (w->best.field.bytes == 0 || less >= NEAR ||
        (less > -NEAR && is_more(w, t, &w->best))) {
        w->best = *t;
    }
}

static bool is_usual_order(const watch *w, lum_field field)
{
    return field.bytes == 1 ||
           field.order ==
               w->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.order;
}

/* Mark a number that counts packets. */
static void mark_count(watch *w, lum_field field)
{
    const lum_infer_course course = lum_infer_extend(&w->t, field);
    if ((double)course.one <= COUNTS * (double)w->t.count) {
        return;
    }
    for (unsigned i = 0; i < 8u * field.bytes; i++) {
        const unsigned bit = lum_infer_bit_at(field, i);
        if (is_varying(w, bit)) {
            w->counts.byte[bit / 8u] |= (uint8_t)(1u << bit % 8u);
        }
    }
}

/* Whether a clock is, or has part of, a number that counts packets. With round
 * ticks, one that rises by 1 from packet to packet may be a clock. */
static bool is_of_count(const watch *w, const trial *t)
{
    const lum_infer_bits bits = lum_infer_bits_of(t->field);
    return lum_infer_overlap(&bits, &w->counts) &&
           !(t->is_counter && is_round(w, t));
}

/* The share of steps back: from line to line any, and from packet to packet
 * those that are longer than lines are apart. Clocks of the eyes, whose packets
 * take turns, may be some us apart. */
static double share_back(const lum_infer_ticks *t, lum_infer_course course,
                         double unit_ns)
{
    const double line_ns = t->span_ns / (double)t->start_count;
    size_t back = 0;
    for (size_t i = 1; i < t->count; i++) {
        back += (double)(t->ticks[i - 1] - t->ticks[i]) * unit_ns > line_ns;
    }
    const double of_lines = (double)course.back / (double)t->start_count;
    const double of_packets = (double)back / (double)t->count;
    return of_lines > of_packets ? of_lines : of_packets;
}

static void try_field(watch *w, lum_field field)
{
    trial t = {.field = field};
    t.varying = count_varying(w, field);
    if (t.varying < 2 || !is_clean_above(w, field)) {
        return;
    }
    const lum_infer_course course = lum_infer_extend(&w->t, field);
    if (!measure_slope(&w->t, &t)) {
        return;
    }
    t.badness = stray(&w->t, t.unit_ns);
    t.is_counter = (double)course.one > COUNTS * (double)w->t.count;
    const double turned = share_back(&w->t, course, t.unit_ns);
    if (t.badness < STRAY && turned < BACK && !is_of_count(w, &t)) {
        t.badness += turned + (is_usual_order(w, field) ? 0.0 : OTHER_ORDER);
        offer(w, &t);
    }
}

static void try_all(watch *w)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(w->state, whole);
    count_ones(w);
    if (w->t.start_count < STARTS_MIN) {
        return;
    }
    for (size_t i = 0; i < n; i++) {
        if (lum_infer_is_free(w->state, whole[i])) {
            mark_count(w, whole[i]);
        }
    }
    for (size_t i = 0; i < n; i++) {
        if (lum_infer_is_free(w->state, whole[i])) {
            try_field(w, whole[i]);
        }
    }
}

/* --- The length of a tick --- */

static uint32_t nearest_unit(double unit_ns)
{
    return unit_ns < 1.0   ? 1u
           : unit_ns > 1e9 ? 1000000000u
                           : (uint32_t)(unit_ns + 0.5);
}

/* What is taken for a clock's unit.
 * @param is_told gets whether it was measured, or is the likeliest alone. */
static uint32_t unit_of(const watch *w, const trial *t, bool *is_told)
{
    const unsigned bits = lum_infer_width(t->field);
    const double rounded = round_unit(t->unit_ns, ROUND);
    *is_told = false;
    if (!w->t.has_times) {
        return 1000;
    }
    if (rounded > 0.0) {
        *is_told = bits > BYTE_BITS;
        return (uint32_t)rounded;
    }
    if (bits >= NARROW_BITS && t->spread <= SPREAD) {
        *is_told = t->unit_ns >= 1.0 && t->unit_ns <= 1e9;
        return nearest_unit(t->unit_ns);
    }
    const double guess = round_unit(t->unit_ns, ROUGH);
    if (guess > 0.0) {
        return (uint32_t)guess;
    }
    return bits > BYTE_BITS ? nearest_unit(t->unit_ns) : 1000u;
}

/* --- Other clocks --- */

/* Times of a field's ticks at the beginnings of lines. */
static void get_times(watch *w, const trial *t, double *out)
{
    bool is_told = false;
    const double unit_ns = unit_of(w, t, &is_told);
    (void)lum_infer_extend(&w->t, t->field);
    for (size_t i = 0; i < w->t.start_count; i++) {
        out[i] = unit_ns * (double)w->t.ticks[w->t.starts[i]];
    }
}

/* Whether another clock gives the same times.
 * @param times of the best. */
static bool is_same_time(watch *w, const trial *t, const double *times)
{
    const size_t n = w->t.start_count;
    get_times(w, t, w->t.sorted);
    for (size_t i = 0; i < n; i++) {
        w->t.sorted[i] -= times[i];
    }
    return deviation(w->t.sorted, n) < SAME * w->t.span_ns;
}

/* Whether a clock is none that the best one has bits of, and about as good a
 * clock by itself. */
static bool is_rival(const watch *w, const trial *t)
{
    const lum_infer_bits a = lum_infer_bits_of(t->field);
    const lum_infer_bits b = lum_infer_bits_of(w->best.field);
    return !lum_infer_overlap(&a, &b) &&
           t->varying + FINE_BITS >= w->best.varying &&
           (is_round(w, t) || !is_round(w, &w->best)) &&
           (!t->is_counter || w->best.is_counter);
}

/* @param times of the best. */
static void find_rival(watch *w, lum_infer_state *state, const double *times)
{
    lum_infer_choice *clock = &state->field[LUM_FIELD_TIMESTAMP];
    bool is_told = false;
    for (size_t i = 0; i < w->count; i++) {
        const trial *t = &w->trials[i];
        if (!is_rival(w, t)) {
            continue;
        }
        if (is_same_time(w, t, times)) {
            state->equal_clock = t->field;
        } else if (1.0 - t->badness > clock->second) {
            clock->second = 1.0 - t->badness;
            clock->rival = t->field;
            state->unit_rival = unit_of(w, t, &is_told);
        }
    }
}

/* The clock's eight bytes of four, or its lower four of eight. */
static lum_field resized(lum_field clock)
{
    const bool is_big = clock.order == LUM_ORDER_BIG;
    lum_field out = clock;
    if (clock.bytes == 8) {
        out.bytes = 4;
        out.at = (uint8_t)(clock.at + (is_big ? 4u : 0u));
    } else {
        out.bytes = 8;
        out.at = (uint8_t)(clock.at - (is_big ? 4u : 0u));
    }
    return out;
}

/* The first byte of those of eight that are above four. */
static unsigned above_of(lum_field eight)
{
    return eight.at + (eight.order == LUM_ORDER_BIG ? 0u : 4u);
}

/* Whether eight bytes stand in the header, those above four being of no other
 * field. */
static bool has_room(const watch *w, lum_field eight)
{
    const lum_infer_state *state = w->state;
    const unsigned above = above_of(eight);
    if (eight.at < LUM_INFER_FIELDS_AT || eight.at + 8u > state->samples.at) {
        return false;
    }
    for (unsigned at = above; at < above + 4u; at++) {
        if (state->used.byte[at] != 0) {
            return false;
        }
    }
    return true;
}

/* Whether those above four do not change. */
static bool is_steady(const watch *w, lum_field eight)
{
    const unsigned first = 8u * above_of(eight);
    for (unsigned bit = first; bit < first + 32u; bit++) {
        if (is_varying(w, bit)) {
            return false;
        }
    }
    return true;
}

/* Whether a field gives the times of the best at all lines, but for corrupt
 * ones. Bytes that count on as the lower ones wrap do; others, which change
 * when they like, do not. */
static bool is_always_same(watch *w, lum_field field, const double *times)
{
    const size_t n = w->t.start_count;
    trial t = w->best;
    size_t off = 0;
    t.field = field;
    get_times(w, &t, w->t.sorted);
    for (size_t i = 0; i < n; i++) {
        const double apart = w->t.sorted[i] - times[i];
        off += apart > SAME * w->t.span_ns || apart < -SAME * w->t.span_ns;
    }
    return off * 100 < n;
}

/* Four bytes that count on in four more, which bear anything: a clock of eight.
 * @param times room for those of the best. */
static void take_upper(watch *w, double *times)
{
    const lum_field clock = w->best.field;
    const lum_field eight = resized(clock);
    if (clock.bytes != 4 || clock.bits != 0 || !has_room(w, eight) ||
        is_steady(w, eight)) {
        return;
    }
    get_times(w, &w->best, times);
    if (is_always_same(w, eight, times)) {
        w->best.field = eight;
    }
}

/* While what is above four bytes does not change, four and eight are the same
 * clock.
 * @param times of the best. */
static void find_resized(watch *w, lum_infer_state *state, const double *times)
{
    const lum_field clock = w->best.field;
    const lum_field other = resized(clock);
    const bool is_four = clock.bytes == 4;
    if (state->equal_clock.bytes > 0 || clock.bits != 0 ||
        (is_four ? !has_room(w, other) : clock.bytes != 8)) {
        return;
    }
    if (is_steady(w, is_four ? other : clock) &&
        is_always_same(w, other, times)) {
        state->equal_clock = other;
    }
}

/* --- Without a clock --- */

/* Whether a byte differs at most lines from the line before of its eye. */
static bool is_changing(const watch *w, unsigned at)
{
    const lum_infer_state *state = w->state;
    const lum_field eye = state->field[LUM_FIELD_EYE].field;
    int last[2] = {-1, -1};
    size_t changed = 0;
    for (size_t i = 0; i < w->t.start_count; i++) {
        const uint8_t *bytes = w->t.packets[w->t.starts[i]]->bytes;
        const unsigned which =
            eye.bytes > 0 && lum_infer_value(bytes, eye) == state->eye_value[1];
        changed += last[which] >= 0 && last[which] != bytes[at];
        last[which] = bytes[at];
    }
    return changed * 2 > w->t.start_count;
}

/* A byte that may be a clock which wraps between lines: it is of no field,
 * numbers no lines and counts no packets. */
static void find_unread(const watch *w, lum_infer_state *state)
{
    const lum_infer_bits lines = lum_infer_bits_of(state->equal_line);
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        const unsigned known =
            state->used.byte[at] | lines.byte[at] | w->counts.byte[at];
        if (known == 0 && is_changing(w, at)) {
            state->unread_at = at;
            return;
        }
    }
}

/* --- Both passes --- */

/* The bits of the clock that change, and those of its lowest byte below them:
 * a clock of round steps leaves its lowest bits as they are. */
static void mark_bits(const watch *w, lum_infer_state *state)
{
    const lum_field field = w->best.field;
    bool is_below = true;
    state->clock_whole = lum_infer_bits_of(field);
    for (unsigned i = 0; i < 8u * field.bytes; i++) {
        const unsigned bit = lum_infer_bit_at(field, i);
        is_below = is_below && i < 8 && !is_varying(w, bit);
        state->clock_bits.byte[bit / 8u] |=
            (uint8_t)(is_below || is_varying(w, bit) ? 1u << bit % 8u : 0u);
    }
}

static void take_clock(watch *w, lum_infer_state *state)
{
    lum_infer_choice *clock = &state->field[LUM_FIELD_TIMESTAMP];
    state->has_times = w->t.has_times;
    state->time_ns = w->t.has_times ? w->t.span_ns : 0.0;
    state->unit_taken = 1000;
    if (w->best.field.bytes > 0) {
        clock->field = w->best.field;
        clock->share = 1.0 - w->best.badness;
        lum_infer_take(state, clock->field);
        state->unit_ns = w->best.unit_ns;
        state->unit_spread = w->best.spread;
        state->unit_taken = unit_of(w, &w->best, &state->is_unit_told);
    }
}

static void look(watch *w, lum_infer_state *state, double *times)
{
    if (w->t.count >= CLOCK_MIN) {
        try_all(w);
    }
    if (w->is_first) {
        if (w->best.field.bytes > 0) {
            mark_bits(w, state);
        }
        return;
    }
    take_upper(w, times);
    take_clock(w, state);
    if (w->best.field.bytes > 0) {
        get_times(w, &w->best, times);
        find_rival(w, state, times);
        find_resized(w, state, times);
    } else if (w->t.has_times) {
        find_unread(w, state);
    }
    lum_infer_measure_lines(state, &w->t);
}

static int run(lum_infer_state *state, bool is_first)
{
    watch w = {.state = state, .is_first = is_first, .best = {.badness = 1.0}};
    w.trials = malloc(LUM_INFER_WHOLE_MAX * sizeof *w.trials);
    const bool has_ticks = lum_infer_find_ticks(state, &w.t) == 0;
    double *times = malloc((w.t.count + 1u) * sizeof *times);
    const bool failed = !has_ticks || w.trials == NULL || times == NULL;
    if (!failed) {
        look(&w, state, times);
    }
    lum_infer_free_ticks(&w.t);
    free(w.trials);
    free(times);
    return failed ? -1 : 0;
}

int lum_infer_follow_time(lum_infer_state *state)
{
    return run(state, true);
}

int lum_infer_find_clock(lum_infer_state *state)
{
    return run(state, false);
}
