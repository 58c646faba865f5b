/* Tries all fields that follow the time of capture, decides the length of
 * each one's ticks, and picks the best as clock. */
#include "fields.h"
#include "ticks.h"

/* Fewer lines lie on too many lines. */
#define STARTS_MIN 5u

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

/* --- Bits of a clock --- */

static void count_ones(lum_infer_search *s)
{
    for (unsigned bit = 0; bit < 8u * LUM_INFER_HEAD_BYTES; bit++) {
        size_t n = 0;
        for (size_t i = 0; i < s->ticks.count; i++) {
            n += s->ticks.packets[i]->bytes[bit / 8u] >> bit % 8u & 1u;
        }
        s->ones[bit] = (double)n / (double)s->ticks.count;
    }
}

/* Bits that change; 0 where the lowest byte does not, since the clock then
 * begins above it. */
static unsigned count_varying(const lum_infer_search *s, lum_field field)
{
    const unsigned bits = lum_infer_width(field);
    unsigned n = 0;
    unsigned lowest = 0;
    for (unsigned i = 0; i < bits; i++) {
        const bool changes =
            lum_infer_is_varying(s, lum_infer_bit_at(field, field.low + i));
        n += changes;
        lowest += changes && i < 8;
    }
    return lowest == 0 ? 0 : n;
}

/* The highest bit that is ever 1. */
static unsigned top_bit(const lum_infer_search *s, lum_field field)
{
    unsigned bits = lum_infer_width(field);
    while (bits > 1 &&
           s->ones[lum_infer_bit_at(field, field.low + bits - 1u)] < 0.03) {
        bits--;
    }
    return bits - 1u;
}

/* Whether a byte has the bits of another in all packets. */
static bool is_same_byte(const lum_infer_search *s, unsigned a, unsigned b)
{
    for (unsigned i = 0; i < 8; i++) {
        if (lum_infer_is_varying(s, 8u * a + i) ||
            lum_infer_is_varying(s, 8u * b + i) ||
            (s->ones[8u * a + i] >= 0.5) != (s->ones[8u * b + i] >= 0.5)) {
            return false;
        }
    }
    return true;
}

/* The highest two bytes bear what stands between other fields too, and that is
 * not 0. */
static bool is_filler(const lum_infer_search *s, lum_field field)
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
        is_zero = is_zero && s->ones[8u * one + i] < 0.5;
    }
    for (unsigned at = LUM_INFER_FIELDS_AT; at < s->ticks.state->samples.at;
         at++) {
        is_elsewhere =
            is_elsewhere ||
            ((at < field.at || at >= (unsigned)field.at + field.bytes) &&
             s->ticks.state->used.byte[at] == 0 && is_same_byte(s, at, one));
    }
    return !is_zero && is_elsewhere && is_same_byte(s, one, two);
}

/* What stands above the highest bit that changes can be part of a clock: of
 * eight bytes, the highest two are 0 for days. */
static bool is_clean_above(const lum_infer_search *s, lum_field field)
{
    unsigned bits = lum_infer_width(field);
    while (bits > 0) {
        const unsigned at = lum_infer_bit_at(field, field.low + bits - 1u);
        if (lum_infer_is_varying(s, at)) {
            return true;
        }
        if (s->ones[at] >= 0.5) {
            return !is_filler(s, field) &&
                   (bits <= 32 || (lum_infer_width(field) == 64 && bits <= 48));
        }
        bits--;
    }
    return false;
}

/* --- The length of a tick --- */

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

static uint32_t nearest_unit(double unit_ns)
{
    return unit_ns < 1.0   ? 1u
           : unit_ns > 1e9 ? 1000000000u
                           : (uint32_t)(unit_ns + 0.5);
}

/* Without times of capture, no length of a tick is rounder than others. */
static void set_unit(const lum_infer_search *s, lum_infer_candidate *c)
{
    const unsigned bits = lum_infer_width(c->field);
    const double tick_ns = c->fit.tick_ns;
    const double rounded =
        s->ticks.has_times ? round_unit(tick_ns, ROUND) : 0.0;
    const double guess = round_unit(tick_ns, ROUGH);
    c->is_round = rounded > 0.0;
    c->unit_ns = bits > BYTE_BITS ? nearest_unit(tick_ns) : 1000u;
    if (!s->ticks.has_times) {
        c->unit_ns = 1000;
    } else if (c->is_round) {
        c->unit_ns = (uint32_t)rounded;
        c->is_unit_told = bits > BYTE_BITS;
    } else if (bits >= NARROW_BITS && c->fit.spread <= SPREAD) {
        c->is_unit_told = tick_ns >= 1.0 && tick_ns <= 1e9;
    } else if (guess > 0.0) {
        c->unit_ns = (uint32_t)guess;
    }
}

/* --- The best clock --- */

/* Four bytes, as the manual's clock has; eight of ticks so short that four
 * would wrap every few seconds, where something stands above four. */
static unsigned plainness(const lum_infer_search *s,
                          const lum_infer_candidate *c)
{
    if (c->field.bytes == 8) {
        return c->fit.tick_ns < LUM_INFER_SHORT_TICK_NS &&
                       top_bit(s, c->field) >= 32
                   ? 2u
                   : 0u;
    }
    return c->field.bytes == 4 ? 1u : 0u;
}

/* Of two clocks that follow time alike: round ticks, then the one with more
 * bits that change, then the plainer. While the line number is not known, which
 * may follow time too, more bits than it has come first. */
static bool is_more(const lum_infer_search *s, const lum_infer_candidate *a,
                    const lum_infer_candidate *b)
{
    const bool is_fine = s->is_first && a->varying >= CLOCK_BITS;
    if (s->is_first && is_fine != (b->varying >= CLOCK_BITS)) {
        return is_fine;
    }
    if (a->is_round != b->is_round) {
        return a->is_round;
    }
    return a->varying != b->varying ? a->varying > b->varying
                                    : plainness(s, a) > plainness(s, b);
}

static void offer(lum_infer_search *s, const lum_infer_candidate *c)
{
    const double less = s->best.badness - c->badness;
    s->all[s->count++] = *c;
    if (s->best.field.bytes == 0 || less >= NEAR ||
        (less > -NEAR && is_more(s, c, &s->best))) {
        s->best = *c;
    }
}

static bool is_usual_order(const lum_infer_search *s, lum_field field)
{
    return field.bytes == 1 ||
           field.order ==
               s->ticks.state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.order;
}

/* --- All fields --- */

/* Mark a number that counts packets. */
static void mark_count(lum_infer_search *s, lum_field field)
{
    const lum_infer_course course = lum_infer_extend(&s->ticks, field);
    for (unsigned i = 0; course.is_counter && i < 8u * field.bytes; i++) {
        const unsigned bit = lum_infer_bit_at(field, i);
        if (lum_infer_is_varying(s, bit)) {
            s->counts.byte[bit / 8u] |= (uint8_t)(1u << bit % 8u);
        }
    }
}

/* Whether a clock is, or has part of, a number that counts packets. With round
 * ticks, one that rises by 1 from packet to packet may be a clock. */
static bool is_of_count(const lum_infer_search *s, const lum_infer_candidate *c)
{
    const lum_infer_bits bits = lum_infer_bits_of(c->field);
    return lum_infer_overlap(&bits, &s->counts) &&
           !(c->fit.is_counter && c->is_round);
}

static void try_field(lum_infer_search *s, lum_field field)
{
    lum_infer_candidate c = {.field = field};
    c.varying = count_varying(s, field);
    if (c.varying < 2 || !is_clean_above(s, field) ||
        !lum_infer_fit_time(&s->ticks, field, &c.fit)) {
        return;
    }
    set_unit(s, &c);
    if (!is_of_count(s, &c)) {
        c.badness =
            c.fit.off +
            (c.fit.back + (is_usual_order(s, field) ? 0.0 : OTHER_ORDER));
        offer(s, &c);
    }
}

void lum_infer_search_clocks(lum_infer_search *s)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(s->ticks.state, whole);
    count_ones(s);
    if (s->ticks.start_count < STARTS_MIN) {
        return;
    }
    for (size_t i = 0; i < n; i++) {
        if (lum_infer_is_free(s->ticks.state, whole[i])) {
            mark_count(s, whole[i]);
        }
    }
    for (size_t i = 0; i < n; i++) {
        if (lum_infer_is_free(s->ticks.state, whole[i])) {
            try_field(s, whole[i]);
        }
    }
}
