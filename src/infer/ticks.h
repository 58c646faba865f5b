/** @file
 * Packets of one sensor with their times, what a field counts from packet to
 * packet, and how that follows the time; the search for the clock, and how long
 * lines last by it. Internal. */
#ifndef LUM_INFER_TICKS_H
#define LUM_INFER_TICKS_H

#include "infer/state.h"

#include "lum/assembler.h"

/** A row of packets. */
typedef struct lum_infer_ticks {
    const lum_infer_state *state;
    lum_infer_packet *const *packets; /**< of one sensor */
    size_t count;
    int64_t *times; /**< of capture, in ns; without any, the order */
    int64_t *ticks; /**< of a field, extended beyond its width; the first
                         is 0 */
    double *sorted; /**< room to sort in */
    size_t *starts; /**< which of the packets begin lines */
    size_t start_count;
    bool has_times; /**< times of capture rise */
    double span_ns; /**< that times of the lines' beginnings span, but for a
                         few */
} lum_infer_ticks;

/** How a field goes on from packet to packet. */
typedef struct lum_infer_course {
    size_t back;     /**< lines that begin with a lower number than the line
                          before */
    bool is_counter; /**< it counts packets */
} lum_infer_course;

/** The packets of the sensor that sent most, not more than are needed.
 * @param out to be freed with lum_infer_free_ticks(), also after a failure.
 * @return 0, or -1 without memory. */
int lum_infer_find_ticks(const lum_infer_state *state, lum_infer_ticks *out);

/** Free it. */
void lum_infer_free_ticks(lum_infer_ticks *ticks);

/** Set the ticks to those of a field. */
lum_infer_course lum_infer_extend(lum_infer_ticks *ticks, lum_field field);

/** How a field follows the time of capture. */
typedef struct lum_infer_fit {
    double off;      /**< how far off it lies, as a share of the time */
    double back;     /**< share of its steps that are back */
    double tick_ns;  /**< length of a tick */
    double spread;   /**< share of it by which half of the measures differ */
    bool is_counter; /**< it counts packets */
} lum_infer_fit;

/** Measure that, with the ticks set to those of the field.
 * @return false: it does not follow the time. */
bool lum_infer_fit_time(lum_infer_ticks *ticks, lum_field field,
                        lum_infer_fit *out);

/** The median of how far numbers lie from their median; sorts them. */
double lum_infer_deviation(double *values, size_t n);

/** The value below which a share of numbers lies, 0..1; sorts them. */
double lum_infer_quantile(double *values, size_t n, double share);

/* --- All fields that follow the time, and the best: clock_search.c --- */

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

/* --- Lengths of lines: spans.c --- */

/** A line must last less than this (docs/protocol.md, "Reassembly"). */
#define LUM_INFER_GAP_US ((double)LUM_GAP_US)

/** Measure lines, and set line_span_us. The line, the eye and the clock are
 * known. */
void lum_infer_measure_lines(lum_infer_state *state, lum_infer_ticks *ticks);

#endif
