#include "shape.h"

#include "fields.h"

#include <string.h>

/* Corruption spoils fewer packets than this share. */
#define RARE 0.03

/* Bytes that no field needs are filler when so many bear one value that is not
 * 0. */
#define FILLER_MIN 1u

/* Whether a byte has a value in all packets but a few. */
static bool is_constant(const lum_infer_state *state, unsigned at,
                        unsigned value)
{
    size_t other = 0;
    for (size_t i = 0; i < state->good.count; i++) {
        other += state->good.at[i]->bytes[at] != value;
    }
    return (double)other <= RARE * (double)state->good.count;
}

static void find_filler(lum_infer_state *state)
{
    unsigned n[256] = {0};
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        const unsigned value = state->good.at[state->good.count / 2]->bytes[at];
        if (state->used.byte[at] == 0 && value != 0 &&
            is_constant(state, at, value)) {
            n[value]++;
        }
    }
    for (unsigned value = 1; value < 256; value++) {
        if (n[value] >= FILLER_MIN && n[value] > n[state->filler]) {
            state->is_filled = true;
            state->filler = (uint8_t)value;
        }
    }
}

/* Whether all bytes of a wider field that are not of the narrower one are 0
 * and free. */
static bool is_padding(const lum_infer_state *state, lum_field wide,
                       lum_field field)
{
    for (unsigned at = wide.at; at < (unsigned)wide.at + wide.bytes; at++) {
        const bool is_of_field =
            at >= field.at && at < (unsigned)field.at + field.bytes;
        if (!is_of_field &&
            (state->used.byte[at] != 0 || !is_constant(state, at, 0))) {
            return false;
        }
    }
    return true;
}

static bool widen(const lum_infer_state *state, lum_field field, lum_field *out,
                  unsigned order)
{
    for (unsigned bytes = 2u * field.bytes; bytes <= 8; bytes *= 2) {
        const int at = order == LUM_ORDER_BIG
                           ? (int)field.at + field.bytes - (int)bytes
                           : (int)field.at;
        if (at < (int)LUM_INFER_FIELDS_AT ||
            (unsigned)at + bytes > state->samples.at) {
            return false;
        }
        const lum_field wide = {.at = (uint8_t)at,
                                .bytes = (uint8_t)bytes,
                                .order = (uint8_t)order};
        if (is_padding(state, wide, field)) {
            *out = wide;
            return true;
        }
    }
    return false;
}

bool lum_infer_wider(const lum_infer_state *state, lum_field field,
                     lum_field *out)
{
    const unsigned usual =
        state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.order;
    if (field.bytes == 0 || field.bits != 0) {
        return false;
    }
    if (field.bytes > 1) {
        return widen(state, field, out, field.order);
    }
    return widen(state, field, out, usual) ||
           widen(state, field, out, LUM_ORDER_BIG - usual);
}

/* Whether a wider field ends where another one begins, so that nothing is left
 * between them. */
static bool is_tight(const lum_infer_state *state, lum_field wide)
{
    const unsigned behind = (unsigned)wide.at + wide.bytes;
    return wide.order == LUM_ORDER_BIG
               ? wide.at == LUM_INFER_FIELDS_AT ||
                     state->used.byte[wide.at - 1u] != 0
               : behind == state->samples.at || state->used.byte[behind] != 0;
}

static bool is_count(unsigned field)
{
    return field == LUM_FIELD_LINE || field == LUM_FIELD_NUM_SAMPLES ||
           field == LUM_FIELD_FIRST_SAMPLE_INDEX;
}

/* Where filler stands between fields, bytes that are 0 are of a field; where
 * none does, of a count if they leave nothing over. A clock of four bytes,
 * which may be followed by zeros, wraps as it should, and one that is taken for
 * eight does not. */
static void take_zeros(lum_infer_state *state)
{
    static const unsigned order[] = {
        LUM_FIELD_TIMESTAMP, LUM_FIELD_LINE, LUM_FIELD_NUM_SAMPLES,
        LUM_FIELD_FIRST_SAMPLE_INDEX, LUM_FIELD_EYE};
    for (unsigned i = 0; i < sizeof order / sizeof order[0]; i++) {
        lum_field *field = &state->field[order[i]].field;
        lum_field wide;
        while (lum_infer_wider(state, *field, &wide) &&
               (state->is_filled ||
                (is_count(order[i]) && is_tight(state, wide)))) {
            *field = wide;
            lum_infer_take(state, wide);
        }
    }
}

/* Whether all bits of two fields stand at the same places. */
static bool is_same_bits(lum_field a, lum_field b, unsigned bits)
{
    for (unsigned i = 0; i < bits; i++) {
        if (lum_infer_bit_at(a, a.low + i) != lum_infer_bit_at(b, b.low + i)) {
            return false;
        }
    }
    return true;
}

/* The same bits in the bytes of another field.
 * @return false where they are not beside each other there. */
static bool move_into(lum_field *field, lum_field base)
{
    const unsigned bits =
        field->bits == 0 ? 8u * field->bytes : (unsigned)field->bits;
    for (unsigned low = 0; low + bits <= 8u * base.bytes; low++) {
        lum_field moved = base;
        moved.low = (uint8_t)low;
        moved.bits = (uint8_t)bits;
        if (is_same_bits(*field, moved, bits)) {
            *field = moved;
            return true;
        }
    }
    return false;
}

static bool share_bytes(lum_field a, lum_field b)
{
    return a.bytes > 0 && b.bytes > 0 && a.at < b.at + b.bytes &&
           b.at < a.at + a.bytes;
}

static bool is_same_base(lum_field a, lum_field b)
{
    return a.at == b.at && a.bytes == b.bytes && a.order == b.order;
}

/* Fields that share bytes name bits of the same ones. */
static void join(lum_field *a, lum_field *b)
{
    if (!share_bytes(*a, *b) || is_same_base(*a, *b)) {
        return;
    }
    lum_field *wide = a->bytes >= b->bytes ? a : b;
    lum_field *narrow = wide == a ? b : a;
    (void)move_into(narrow, *wide);
}

void lum_infer_shape(lum_infer_state *state)
{
    find_filler(state);
    take_zeros(state);
    for (unsigned pass = 0; pass < 2; pass++) {
        for (unsigned f = 1; f < LUM_GROUP_FIELDS; f++) {
            for (unsigned g = 0; g < f; g++) {
                join(&state->field[f].field, &state->field[g].field);
            }
        }
    }
}
