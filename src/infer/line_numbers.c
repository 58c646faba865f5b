/* Line numbers: fields that rise by 1 from line to line. */
#include "fields.h"
#include "starts.h"

#include <stdlib.h>

/* The lowest bit of a line number changes with most lines of an eye. */
#define TOGGLE_MIN 0.6

/* A line number has this many bits at least: with fewer, any two bits count. */
#define BITS_MIN 3u

/* Bits that are no use to a number of bits of a field: zeros above are rather
 * of nobody. */
#define MORE_BITS 16u

/* A bit that is 1 but in this share of lines is none of a number. */
#define ALWAYS 0.03

/* A line number is rather a field of its own than the upper bits of one. */
#define LIKES_WHOLE 0.04

/* Elevations begin again this often at least, for a number to be judged by. */
#define OVER_MIN 2u

/* Numbers of one lowest bit count as often, but for corruption. */
#define NEAR 0.004

/* What a trial of fields knows. */
typedef struct trial {
    const lum_infer_starts *starts;
    const lum_infer_bits *eye_bits;
    const lum_infer_bits *clock; /* bits that are no part of a line number */
    unsigned eye_bit;
    unsigned lowest;
    lum_infer_line best;
} trial;

/* --- Steps from line to line --- */

static lum_infer_steps walk(const lum_infer_starts *starts, unsigned eye_bit,
                            lum_field line)
{
    const lum_infer_packet *last[2] = {NULL, NULL};
    uint64_t number[2] = {0, 0};
    lum_infer_steps s = {0, 0, 0, 0};
    for (size_t i = 0; i < starts->count; i++) {
        const lum_infer_packet *p = starts->at[i];
        const unsigned eye = lum_infer_bit_of(p, eye_bit);
        const uint64_t now = lum_infer_value(p->bytes, line);
        if (last[eye] != NULL && last[eye]->sensor == p->sensor) {
            s.all++;
            s.one += now == number[eye] + 1u;
            const bool is_over =
                abs(p->calm - last[eye]->calm) * 2 > starts->height;
            s.down += is_over && now < number[eye];
            s.over += is_over;
        }
        last[eye] = p;
        number[eye] = now;
    }
    return s;
}

double lum_infer_share_of_steps(lum_infer_steps s)
{
    return s.all == 0 ? 0.0 : (double)(s.one + s.down) / (double)s.all;
}

bool lum_infer_begins_again(lum_infer_steps steps)
{
    return steps.over < OVER_MIN || steps.down * 2 >= steps.over;
}

/* The share of lines of an eye in which a bit differs from the line before. */
static double share_of_changes(const lum_infer_starts *starts, unsigned eye_bit,
                               unsigned bit)
{
    const lum_infer_packet *last[2] = {NULL, NULL};
    size_t n = 0;
    size_t changed = 0;
    for (size_t i = 0; i < starts->count; i++) {
        const lum_infer_packet *p = starts->at[i];
        const unsigned eye = lum_infer_bit_of(p, eye_bit);
        if (last[eye] != NULL && last[eye]->sensor == p->sensor) {
            n++;
            changed +=
                lum_infer_bit_of(last[eye], bit) != lum_infer_bit_of(p, bit);
        }
        last[eye] = p;
    }
    return n == 0 ? 0.0 : (double)changed / (double)n;
}

/* --- Bits of a line number --- */

lum_infer_bits lum_infer_eye_bits(const lum_infer_starts *starts,
                                  unsigned eye_bit)
{
    lum_infer_bits out = {{0}};
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         eye_bit < LUM_INFER_HEAD_BITS && bit < 8u * starts->state->samples.at;
         bit++) {
        const double ones = lum_infer_share_of_ones(starts, bit);
        if (ones > 0.02 && ones < 0.98 &&
            lum_infer_is_same_split(starts, eye_bit, bit)) {
            out.byte[bit / 8u] |= (uint8_t)(1u << bit % 8u);
        }
    }
    return out;
}

bool lum_infer_is_lowest(const lum_infer_starts *starts, unsigned bit,
                         unsigned eye_bit, const lum_infer_bits *eye_bits)
{
    return !lum_infer_has_bit(&starts->state->used, bit) &&
           !lum_infer_has_bit(eye_bits, bit) &&
           share_of_changes(starts, eye_bit, bit) >= TOGGLE_MIN;
}

/* A bit that is always 1, in a byte that never changes, is none of a number. */
static bool is_constant_one(const trial *t, unsigned bit)
{
    return lum_infer_share_of_ones(t->starts, bit) > 1.0 - ALWAYS &&
           lum_infer_changing(t->starts, bit / 8u, t->eye_bit, NULL) == 0;
}

/* Whether a bit of no other field changes from line to line. A number does not
 * end below one, nor does it begin above one. */
static bool is_of_number(const trial *t, lum_field base, unsigned bit)
{
    const unsigned at = lum_infer_bit_at(base, bit);
    return !lum_infer_has_bit(&t->starts->state->used, at) &&
           lum_infer_is_changing(t->starts, at, t->eye_bit);
}

/* A clock that ticks once a line may be the line number as a whole, and not in
 * part. */
static bool is_part_of_clock(const trial *t, lum_field line)
{
    const lum_infer_bits bits = lum_infer_bits_of(line);
    bool is_whole = true;
    for (unsigned i = 0; i < LUM_INFER_HEAD_BYTES; i++) {
        is_whole = is_whole && (t->clock->byte[i] & ~bits.byte[i]) == 0;
    }
    return !is_whole && lum_infer_overlap(&bits, t->clock);
}

/* --- The best field --- */

/* What is for a field among those that count alike: whole fields of two bytes
 * are the usual ones. */
static unsigned plainness(const trial *t, lum_field field)
{
    const unsigned width = lum_infer_width(field);
    const unsigned bits = width < MORE_BITS ? width : MORE_BITS;
    unsigned p = bits >= LUM_INFER_LINE_BITS ? 256u : 0u;
    p += field.bits == 0 ? 128u : field.low == 0 ? 64u + bits : bits;
    p += field.bytes == 2 ? 6u : field.bytes == 4 ? 4u : 2u;
    p += field.order == t->starts->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX]
                            .field.order
             ? 96u
             : 0u;
    /* Zeros of what may be a clock are rather the clock's. */
    const lum_infer_bits own = lum_infer_bits_of(field);
    p += lum_infer_overlap(&own, &t->starts->state->clock.whole) ? 0u : 100u;
    /* The eye as the highest bit above the number is a usual thing. */
    p += field.bits != 0 && field.low + width + 1u == 8u * field.bytes &&
                 lum_infer_has_bit(t->eye_bits,
                                   lum_infer_bit_at(field, field.low + width))
             ? 192u
             : 0u;
    return p;
}

static void offer(trial *t, const lum_infer_line *line)
{
    lum_infer_line *best = &t->best;
    const double more = (lum_infer_share_of_steps(line->steps) - line->weight) -
                        (lum_infer_share_of_steps(best->steps) - best->weight);
    if (best->field.bytes == 0 || more > NEAR ||
        line->steps.one > best->steps.one ||
        (line->steps.one == best->steps.one &&
         plainness(t, line->field) > plainness(t, best->field))) {
        *best = *line;
    }
}

static void try_field(trial *t, lum_field field)
{
    if (!is_part_of_clock(t, field)) {
        const lum_infer_line line = {
            .field = field,
            .lowest = t->lowest,
            .weight = field.low != 0 ? LIKES_WHOLE : 0.0,
            .steps = walk(t->starts, t->eye_bit, field)};
        offer(t, &line);
    }
}

/* All fields of a base whose lowest bit is this one. */
static void try_base(trial *t, lum_field base, unsigned low)
{
    const unsigned all = 8u * base.bytes;
    if (low > 0 && is_of_number(t, base, low - 1u)) {
        return;
    }
    for (unsigned bits = 1; low + bits <= all; bits++) {
        const unsigned top = lum_infer_bit_at(base, low + bits - 1u);
        if (lum_infer_has_bit(&t->starts->state->used, top) ||
            lum_infer_has_bit(t->eye_bits, top) || is_constant_one(t, top)) {
            break;
        }
        if (bits < BITS_MIN ||
            (low + bits < all && is_of_number(t, base, low + bits))) {
            continue;
        }
        lum_field field = base;
        field.low = (uint8_t)low;
        field.bits = bits == all ? 0 : (uint8_t)bits;
        try_field(t, field);
    }
}

lum_infer_line lum_infer_try_lowest(const lum_infer_starts *starts,
                                    unsigned lowest, unsigned eye_bit,
                                    const lum_infer_bits *eye_bits,
                                    const lum_infer_bits *clock)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(starts->state, whole);
    trial t = {.starts = starts,
               .eye_bits = eye_bits,
               .clock = clock,
               .eye_bit = eye_bit,
               .lowest = lowest};
    for (size_t i = 0; i < n; i++) {
        for (unsigned low = lowest % 8u; low < 8u * whole[i].bytes; low += 8) {
            if (lum_infer_bit_at(whole[i], low) == lowest) {
                try_base(&t, whole[i], low);
            }
        }
    }
    return t.best;
}
