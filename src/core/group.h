/* What is asked of a data packet that is read, written or pushed. */
#ifndef LUM_CORE_GROUP_H
#define LUM_CORE_GROUP_H

#include "bytes.h"
#include "lum/group.h"
#include "product.h"

/* As lum_group_word(), which is shorter where it takes many instructions. */
static inline uint32_t group_word(const lum_group *group, uint32_t i)
{
#if LUM_BY_PARTS
    return lum_group_word(group, i);
#else
    return load_sample(&group->samples[(size_t)LUM_SAMPLE_BYTES * i],
                       group->sample_order);
#endif
}

/* Where a word belongs: a good one at its pixel, a bad one behind them all. Bit
 * 11 (LUM_WORD_ZERO) must be 0; where it is set, the result is above every
 * pixel. */
static inline uint32_t place_of(uint32_t word)
{
    return word & (LUM_WORD_ZERO | LUM_WORD_PIXEL);
}

/* n: num_samples; first: first_sample_index.
 * LUM_OK, LUM_E_MALFORMED or LUM_E_UNKNOWN_TAG. */
lum_result lum_group_check(uint32_t tag, uint32_t n, uint32_t first);

#endif
