#include "fields.h"

static uint64_t whole(const uint8_t *head, lum_field field)
{
    uint64_t value = 0;
    for (unsigned i = 0; i < field.bytes; i++) {
        const unsigned k =
            field.order == LUM_ORDER_BIG ? i : field.bytes - 1u - i;
        value = value << 8 | head[field.at + k];
    }
    return value;
}

uint64_t lum_infer_value(const uint8_t *head, lum_field field)
{
    const uint64_t value = whole(head, field) >> field.low;
    return field.bits == 0 || field.bits >= 64
               ? value
               : value & ((UINT64_C(1) << field.bits) - 1u);
}

unsigned lum_infer_width(lum_field field)
{
    return field.bits != 0 ? field.bits : 8u * field.bytes;
}

size_t lum_infer_next(size_t i, size_t stride)
{
    const uint32_t mixed = (uint32_t)i * UINT32_C(2654435761) >> 16;
    return i + 1u + mixed % (2u * stride - 1u);
}

unsigned lum_infer_bit_at(lum_field field, unsigned bit)
{
    const unsigned byte = bit / 8u;
    const unsigned at = field.order == LUM_ORDER_BIG
                            ? field.at + field.bytes - 1u - byte
                            : field.at + byte;
    return 8u * at + bit % 8u;
}

bool lum_infer_is_nested(lum_field a, lum_field b)
{
    const unsigned one = lum_infer_width(a);
    const unsigned two = lum_infer_width(b);
    const unsigned bits = one < two ? one : two;
    for (unsigned i = 0; i < bits; i++) {
        if (lum_infer_bit_at(a, a.low + i) != lum_infer_bit_at(b, b.low + i)) {
            return false;
        }
    }
    return true;
}

lum_infer_bits lum_infer_bits_of(lum_field field)
{
    lum_infer_bits out = {{0}};
    const unsigned bits = lum_infer_width(field);
    for (unsigned i = 0; i < bits && field.bytes > 0; i++) {
        const unsigned at = lum_infer_bit_at(field, field.low + i);
        out.byte[at / 8u] |= (uint8_t)(1u << at % 8u);
    }
    return out;
}

bool lum_infer_overlap(const lum_infer_bits *a, const lum_infer_bits *b)
{
    for (unsigned i = 0; i < LUM_INFER_HEAD_BYTES; i++) {
        if ((a->byte[i] & b->byte[i]) != 0) {
            return true;
        }
    }
    return false;
}

bool lum_infer_share_bits(lum_field a, lum_field b)
{
    const lum_infer_bits x = lum_infer_bits_of(a);
    const lum_infer_bits y = lum_infer_bits_of(b);
    return lum_infer_overlap(&x, &y);
}

void lum_infer_add_bits(lum_infer_bits *set, lum_field field)
{
    const lum_infer_bits bits = lum_infer_bits_of(field);
    for (unsigned i = 0; i < LUM_INFER_HEAD_BYTES; i++) {
        set->byte[i] |= bits.byte[i];
    }
}

bool lum_infer_is_free(const lum_infer_state *state, lum_field field)
{
    const lum_infer_bits bits = lum_infer_bits_of(field);
    return !lum_infer_overlap(&bits, &state->used);
}

size_t lum_infer_whole(const lum_infer_state *state,
                       lum_field out[LUM_INFER_WHOLE_MAX])
{
    size_t n = 0;
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        for (unsigned bytes = 1; at + bytes <= state->samples.at && bytes <= 8;
             bytes *= 2) {
            lum_field field = {.at = (uint8_t)at, .bytes = (uint8_t)bytes};
            out[n++] = field;
            if (bytes > 1) {
                field.order = LUM_ORDER_BIG;
                out[n++] = field;
            }
        }
    }
    return n;
}
