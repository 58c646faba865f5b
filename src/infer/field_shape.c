/* The shape of fields: zeros beside them, and bytes that they share. */
#include "fields.h"

#include <string.h>

/* Corruption spoils fewer packets than this share. */
#define RARE 0.03

/* Bytes that no field needs are filler when so many bear one value that is not
 * 0. One alone can be anything. */
#define FILLER_MIN 2u

/* The value that a byte has in most packets, and in how many. */
static unsigned usual(const lum_infer_state *state, unsigned at, size_t *most)
{
    size_t n[256] = {0};
    unsigned best = 0;
    for (size_t i = 0; i < state->good.count; i++) {
        n[state->good.at[i]->bytes[at]]++;
    }
    for (unsigned value = 1; value < 256; value++) {
        best = n[value] > n[best] ? value : best;
    }
    *most = n[best];
    return best;
}

/* Whether a byte has a value in all packets but a few. */
static bool is_constant(const lum_infer_state *state, unsigned at,
                        unsigned value)
{
    size_t most = 0;
    return usual(state, at, &most) == value &&
           (double)(state->good.count - most) <=
               RARE * (double)state->good.count;
}

static bool has_filler(const lum_infer_state *state)
{
    bool is_filled = false;
    unsigned n[256] = {0};
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        size_t most = 0;
        const unsigned value = usual(state, at, &most);
        if (state->used.byte[at] == 0 && value != 0 &&
            is_constant(state, at, value)) {
            n[value]++;
            is_filled = is_filled || n[value] >= FILLER_MIN;
        }
    }
    return is_filled;
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

/* A clock of four bytes, which may be followed by zeros, wraps as it should,
 * and one that is taken for eight does not. Only ticks so short that four wrap
 * within minutes are rather of eight. */
static bool may_grow(const lum_infer_state *state, unsigned field,
                     lum_field wide, bool is_filled)
{
    if (field == LUM_FIELD_TIMESTAMP &&
        state->clock.unit_ns >= LUM_INFER_SHORT_TICK_NS) {
        return false;
    }
    return is_filled || (is_count(field) && is_tight(state, wide));
}

/* Where filler stands between fields, bytes that are 0 are of a field; where
 * none does, of a count if they leave nothing over. */
static void take_zeros(lum_infer_state *state, bool is_filled)
{
    static const unsigned order[] = {
        LUM_FIELD_TIMESTAMP, LUM_FIELD_LINE, LUM_FIELD_NUM_SAMPLES,
        LUM_FIELD_FIRST_SAMPLE_INDEX, LUM_FIELD_EYE};
    for (unsigned i = 0; i < sizeof order / sizeof order[0]; i++) {
        lum_field *field = &state->field[order[i]].field;
        lum_field *narrow = &state->narrow[order[i]];
        lum_field wide;
        while (lum_infer_wider(state, *field, &wide) &&
               may_grow(state, order[i], wide, is_filled)) {
            *narrow = narrow->bytes == 0 ? *field : *narrow;
            *field = wide;
            lum_infer_add_bits(&state->used, wide);
        }
    }
}

/* The same bits in the bytes of another field.
 * @return false where they are not beside each other there. */
static bool move_into(lum_field *field, lum_field base)
{
    const unsigned bits = lum_infer_width(*field);
    for (unsigned low = 0; low + bits <= 8u * base.bytes; low++) {
        lum_field moved = base;
        moved.low = (uint8_t)low;
        moved.bits = bits == 8u * base.bytes ? 0 : (uint8_t)bits;
        if (lum_infer_is_nested(*field, moved)) {
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

static bool is_apart(lum_field a, lum_field b)
{
    return !share_bytes(a, b) || is_same_base(a, b);
}

/* Move all fields that share bytes with a base into it.
 * @return false: they are too many, or one cannot be moved; none was. */
static bool move_all(lum_infer_state *state, lum_field base, unsigned most)
{
    lum_field moved[LUM_GROUP_FIELDS];
    unsigned n = 0;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        moved[f] = state->field[f].field;
        if (share_bytes(moved[f], base)) {
            n++;
            if (n > most || !move_into(&moved[f], base)) {
                return false;
            }
        }
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        state->field[f].field = moved[f];
    }
    return true;
}

/* Move a field into the fewest bytes that hold it, if they are fewer. */
static void shrink(lum_field *field)
{
    for (unsigned bytes = 1; bytes < field->bytes; bytes *= 2) {
        for (unsigned at = field->at;
             at + bytes <= (unsigned)field->at + field->bytes; at++) {
            const lum_field base = {
                .at = (uint8_t)at,
                .bytes = (uint8_t)bytes,
                .order = bytes == 1 ? (uint8_t)LUM_ORDER_LITTLE : field->order};
            if (move_into(field, base)) {
                return;
            }
        }
    }
}

/* Whether a base holds the bytes of a field. */
static bool holds(lum_field base, lum_field field)
{
    return base.at <= field.at &&
           field.at + field.bytes <= base.at + base.bytes;
}

static bool join_in(lum_infer_state *state, unsigned f, unsigned g,
                    unsigned bytes, unsigned most)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(state, whole);
    for (size_t i = 0; i < n; i++) {
        if (whole[i].bytes == bytes && holds(whole[i], state->field[f].field) &&
            holds(whole[i], state->field[g].field) &&
            move_all(state, whole[i], most)) {
            return true;
        }
    }
    return false;
}

/* Fields that share bytes name bits of the same ones: of the fewest that hold
 * them both, in either byte order, and as few others as can be.
 * @return false: there are none. */
static bool join(lum_infer_state *state, unsigned f, unsigned g)
{
    for (unsigned bytes = 1; bytes <= 8; bytes *= 2) {
        for (unsigned most = 2; most <= LUM_GROUP_FIELDS; most++) {
            if (join_in(state, f, g, bytes, most)) {
                return true;
            }
        }
    }
    return false;
}

static void join_all(lum_infer_state *state)
{
    for (unsigned f = 1; f < LUM_GROUP_FIELDS; f++) {
        for (unsigned g = 0; g < f; g++) {
            lum_field *a = &state->field[f].field;
            lum_field *b = &state->field[g].field;
            if (!is_apart(*a, *b)) {
                shrink(a);
                shrink(b);
            }
            if (!is_apart(*a, *b)) {
                (void)join(state, f, g);
            }
        }
    }
}

void lum_infer_shape(lum_infer_state *state)
{
    take_zeros(state, has_filler(state));
    join_all(state);
}

bool lum_infer_clash(const lum_infer_state *state, unsigned *one, unsigned *two)
{
    for (unsigned f = 1; f < LUM_GROUP_FIELDS; f++) {
        for (unsigned g = 0; g < f; g++) {
            if (!is_apart(state->field[f].field, state->field[g].field)) {
                *one = g;
                *two = f;
                return true;
            }
        }
    }
    return false;
}
