/** @file
 * Fields of headers: their values, and the bits that they take. Internal. */
#ifndef LUM_INFER_FIELDS_H
#define LUM_INFER_FIELDS_H

#include "infer/state.h"

/** The field's value. */
uint64_t lum_infer_value(const uint8_t *head, lum_field field);

/** How many bits a field has. */
unsigned lum_infer_width(lum_field field);

/** The packet behind one, of every stride-th on average. Steps differ, since
 * packets come in an order that repeats. */
size_t lum_infer_next(size_t i, size_t stride);

/** The bits of a field, in the order of the header. */
lum_infer_bits lum_infer_bits_of(lum_field field);

/** Whether two sets have a bit in common. */
bool lum_infer_overlap(const lum_infer_bits *a, const lum_infer_bits *b);

/** Whether two fields have. */
bool lum_infer_share_bits(lum_field a, lum_field b);

/** Add the bits of a field to a set. */
void lum_infer_add_bits(lum_infer_bits *set, lum_field field);

/** Whether all bits of a field are free. */
bool lum_infer_is_free(const lum_infer_state *state, lum_field field);

/** Most fields of whole bytes: 52 offsets, four widths, two orders of all but
 * the narrowest. */
#define LUM_INFER_WHOLE_MAX 364u

/** All fields of whole bytes in front of the samples.
 * @return how many. */
size_t lum_infer_whole(const lum_infer_state *state,
                       lum_field out[LUM_INFER_WHOLE_MAX]);

/** Where a bit of a field stands in the header: 8 times the byte, and the bit.
 * @param bit from the field's lowest bit of its bytes. */
unsigned lum_infer_bit_at(lum_field field, unsigned bit);

/** Whether one field is the lowest bits of the other, at the same places; of
 * fields of one width, whether they are the same bits. */
bool lum_infer_is_nested(lum_field a, lum_field b);

#endif
