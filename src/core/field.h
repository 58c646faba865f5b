/* How many bits a field of a data packet has. */
#ifndef LUM_CORE_FIELD_H
#define LUM_CORE_FIELD_H

#include "lum/profile.h"

static inline unsigned field_bits(const lum_field *field)
{
    return field->bits > 0 ? field->bits : 8u * field->bytes;
}

/* What to flip of a byte's place, counted from the lowest byte. */
static inline unsigned field_flip(const lum_field *field)
{
    return field->order == LUM_ORDER_LITTLE ? 0 : field->bytes - 1u;
}

/* Of a clock, the highest of 64 bits is ignored. */
static inline unsigned clock_bits(const lum_field *field)
{
    const unsigned bits = field_bits(field);
    return bits < 64u ? bits : 63u;
}

#endif
