/** @file
 * All fields that follow the time of capture, and the best of them. Internal to
 * the search for the clock. */
#ifndef LUM_INFER_CLOCK_SEARCH_H
#define LUM_INFER_CLOCK_SEARCH_H

#include "fields.h"
#include "ticks.h"

/** A field that follows the time of capture. */
typedef struct lum_infer_candidate {
    lum_field field; /**< bytes 0: there is none */
    lum_infer_fit fit;
    double badness;    /**< of all that is against it */
    unsigned varying;  /**< bits that change */
    bool is_round;     /**< its ticks are of a round length */
    uint32_t unit_ns;  /**< what is taken for a tick's length */
    bool is_unit_told; /**< that was measured, and is not the likeliest alone */
} lum_infer_candidate;

/** A search. Its memory is the caller's. */
typedef struct lum_infer_search {
    lum_infer_ticks ticks;
    bool is_first; /**< other fields are not known yet */
    double ones[8 * LUM_INFER_HEAD_BYTES]; /**< share of packets in which a bit
                                                is 1 */
    lum_infer_bits counts; /**< bits of numbers that count packets */
    lum_infer_candidate best;
    lum_infer_candidate *all; /**< room for ::LUM_INFER_WHOLE_MAX */
    size_t count;
    double *times; /**< of the best; room for as many as ticks has packets */
} lum_infer_search;

/** Try all fields that are free. The best is set if any follows the time. */
void lum_infer_search_clocks(lum_infer_search *search);

/** Whether a bit of the header changes. */
static inline bool lum_infer_is_varying(const lum_infer_search *search,
                                        unsigned bit)
{
    return search->ones[bit] > 0.01 && search->ones[bit] < 0.99;
}

#endif
