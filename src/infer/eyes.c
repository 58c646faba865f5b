/* Bits that tell the eyes apart, and the field around them. */
#include "fields.h"
#include "starts.h"

/* A bit that tells two eyes apart is set in this share of lines at least. */
#define EYE_MIN 0.1

/* Where the default layout has the eye. */
#define USUAL_AT 13u

/* A byte of the eye has none of the clock's bits, if any other will do, and
 * none that changes. */
#define NO_CLOCK   64u
#define NO_CHANGES 32u

/* --- Bits that may tell eyes apart --- */

static unsigned count_bits(unsigned mask)
{
    unsigned n = 0;
    for (; mask != 0; mask &= mask - 1u) {
        n++;
    }
    return n;
}

/* Bits of a bit's byte that change within the eyes that it tells. */
static unsigned changing_beside(const lum_infer_starts *starts, unsigned bit)
{
    return count_bits(lum_infer_changing(starts, bit / 8u, bit, NULL));
}

/* Where a bit is among those that are known, as itself or as one that tells the
 * same; count: nowhere. */
static size_t find_known(const lum_infer_starts *starts, const unsigned *known,
                         size_t count, unsigned bit)
{
    size_t k = 1;
    while (k < count && !lum_infer_is_same_split(starts, known[k], bit)) {
        k++;
    }
    return k;
}

/* Of bits that tell the same, the one with the fewest others beside it that
 * change stands for all. */
size_t lum_infer_find_splits(const lum_infer_starts *starts,
                             const lum_infer_bits *time,
                             unsigned out[LUM_INFER_SPLITS_MAX])
{
    size_t count = 1;
    out[0] = LUM_INFER_HEAD_BITS;
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         bit < 8u * starts->state->samples.at; bit++) {
        const double ones = lum_infer_share_of_ones(starts, bit);
        if (ones < EYE_MIN || ones > 1.0 - EYE_MIN ||
            lum_infer_has_bit(&starts->state->used, bit) ||
            lum_infer_has_bit(time, bit)) {
            continue;
        }
        const size_t k = find_known(starts, out, count, bit);
        if (k == count && k < LUM_INFER_SPLITS_MAX) {
            out[k] = bit;
            count++;
        } else if (k < count && changing_beside(starts, bit) <
                                    changing_beside(starts, out[k])) {
            out[k] = bit;
        }
    }
    return count;
}

double lum_infer_share_of_turns(const lum_infer_starts *starts,
                                unsigned eye_bit)
{
    size_t n = 0;
    size_t turns = 0;
    for (size_t i = 1; i < starts->count; i++) {
        const lum_infer_packet *const *p = &starts->at[i - 1];
        if (p[0]->sensor == p[1]->sensor) {
            n++;
            turns += lum_infer_bit_of(p[0], eye_bit) !=
                     lum_infer_bit_of(p[1], eye_bit);
        }
    }
    return n == 0 ? 0.0 : (double)turns / (double)n;
}

/* --- The field of the eye --- */

static unsigned length_of_run(unsigned mask, unsigned low)
{
    unsigned n = 0;
    while (low + n < 8 && (mask >> (low + n) & 1u) != 0) {
        n++;
    }
    return n;
}

/* The field around the bits by which eyes differ, in one byte.
 * @param taken bits of the byte that are not the eye's. */
static lum_field field_in_byte(unsigned at, unsigned taken, unsigned differing)
{
    lum_field out = {.at = (uint8_t)at};
    if (differing == 0) {
        return out;
    }
    out.bytes = 1;
    if (taken != 0) {
        const unsigned free = ~taken & 0xffu;
        unsigned low = 0;
        while ((differing >> low & 1u) == 0) {
            low++;
        }
        while (low > 0 && (free >> (low - 1u) & 1u) != 0 && low != 4) {
            low--;
        }
        out.low = (uint8_t)low;
        out.bits = (uint8_t)length_of_run(free, low);
    }
    return out;
}

/* A byte that may bear the eye. */
typedef struct candidate {
    lum_field field; /* bytes 0: it does not */
    unsigned weight; /* what is for it */
} candidate;

static candidate try_byte(const lum_infer_starts *starts,
                          const lum_infer_bits *used,
                          const lum_infer_bits *clock, unsigned eye_bit,
                          unsigned at)
{
    candidate out = {.weight = 0};
    unsigned differing = 0;
    const unsigned changing =
        lum_infer_changing(starts, at, eye_bit, &differing);
    const unsigned taken = changing | used->byte[at];
    out.field = field_in_byte(at, taken, differing & ~taken);
    if (out.field.bytes > 0) {
        out.weight =
            2u * count_bits(differing) + (out.field.bits == 0 ? 1u : 0u) +
            ((changing & ~(unsigned)used->byte[at]) == 0 ? NO_CHANGES : 0u) +
            (clock->byte[at] == 0 ? NO_CLOCK : 0u);
    }
    return out;
}

lum_field lum_infer_eye_field(const lum_infer_starts *starts,
                              const lum_infer_bits *used,
                              const lum_infer_bits *clock, unsigned eye_bit,
                              lum_field *equal)
{
    candidate best = {.weight = 0};
    candidate other = {.weight = NO_CLOCK};
    for (unsigned at = LUM_INFER_FIELDS_AT; at < starts->state->samples.at;
         at++) {
        candidate next = try_byte(starts, used, clock, eye_bit, at);
        if (next.weight > best.weight) {
            const candidate before = best;
            best = next;
            next = before;
        }
        other = next.weight > other.weight ? next : other;
    }
    *equal = other.field;
    return best.field;
}

/* The value that most packets of an eye have. */
static uint32_t usual_value(const lum_infer_starts *starts, lum_field field,
                            unsigned eye_bit, unsigned eye)
{
    size_t n[256] = {0};
    uint32_t best = 0;
    for (size_t i = 0; i < starts->count; i++) {
        const lum_infer_packet *p = starts->at[i];
        if (lum_infer_bit_of(p, eye_bit) == eye) {
            n[lum_infer_value(p->bytes, field) & 0xffu]++;
        }
    }
    for (uint32_t v = 1; v < 256; v++) {
        best = n[v] > n[best] ? v : best;
    }
    return best;
}

void lum_infer_eye_values(const lum_infer_starts *starts, lum_field field,
                          unsigned eye_bit, uint32_t out[LUM_EYES])
{
    const uint32_t a = usual_value(starts, field, eye_bit, 0);
    const uint32_t b = usual_value(starts, field, eye_bit, 1);
    out[LUM_EYE_BLUE] = a < b ? a : b;
    out[LUM_EYE_GREEN] = a < b ? b : a;
}

/* --- One eye alone --- */

static bool is_free_constant(const lum_infer_starts *starts, unsigned at)
{
    return at >= LUM_INFER_FIELDS_AT && at < starts->state->samples.at &&
           starts->state->used.byte[at] == 0 &&
           lum_infer_changing(starts, at, LUM_INFER_HEAD_BITS, NULL) == 0;
}

static lum_field find_constant(const lum_infer_starts *starts)
{
    unsigned at = LUM_INFER_FIELDS_AT;
    if (is_free_constant(starts, USUAL_AT)) {
        at = USUAL_AT;
    }
    while (at < starts->state->samples.at && !is_free_constant(starts, at)) {
        at++;
    }
    return (lum_field){.at = (uint8_t)at,
                       .bytes = at < starts->state->samples.at ? 1 : 0};
}

/* Take the highest bit of a line number that needs fewer. */
static lum_field take_top_bit(const lum_infer_starts *starts, lum_field *line)
{
    const unsigned bits = lum_infer_width(*line);
    lum_field eye = *line;
    eye.low = (uint8_t)(line->low + bits - 1u);
    eye.bits = 1;
    if (bits <= LUM_INFER_LINE_BITS ||
        lum_infer_is_changing(starts, lum_infer_bit_at(eye, eye.low),
                              LUM_INFER_HEAD_BITS)) {
        return (lum_field){.bytes = 0};
    }
    line->bits = (uint8_t)(bits - 1u);
    return eye;
}

void lum_infer_take_one_eye(lum_infer_state *state,
                            const lum_infer_starts *starts)
{
    lum_field *eye = &state->field[LUM_FIELD_EYE].field;
    *eye = find_constant(starts);
    if (eye->bytes == 0) {
        *eye = take_top_bit(starts, &state->field[LUM_FIELD_LINE].field);
    }
    if (eye->bytes > 0) {
        const uint32_t value =
            usual_value(starts, *eye, LUM_INFER_HEAD_BITS, 0);
        uint32_t *values = state->readings.best.eye_value;
        values[LUM_EYE_BLUE] = value == 1 ? 0 : value;
        values[LUM_EYE_GREEN] = value == 0 || value == 1 ? 1 : value ^ 1u;
        lum_infer_add_bits(&state->used, *eye);
    }
}
