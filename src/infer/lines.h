/** @file
 * Line numbers: fields that rise by 1 from line to line of an eye. Internal. */
#ifndef LUM_INFER_LINES_H
#define LUM_INFER_LINES_H

#include "infer/starts.h"

/** Bits that a number of 640 lines needs. */
#define LUM_INFER_LINE_BITS 10u

/** How a line number goes on, for both eyes. */
typedef struct lum_infer_steps {
    size_t all;  /**< steps from a line to the next */
    size_t one;  /**< by 1 */
    size_t down; /**< to a lower number, where elevations begin again */
    size_t over; /**< where elevations begin again, whatever the number does */
} lum_infer_steps;

/** A line number that was tried. */
typedef struct lum_infer_line {
    lum_field field;       /**< bytes 0: none */
    unsigned lowest;       /**< the header's bit where its lowest one stands */
    lum_infer_steps steps; /**< of it */
    double weight;         /**< what custom has against it; not measured */
} lum_infer_line;

/** The share of steps that a line number takes: by 1, or down. */
double lum_infer_share_of_steps(lum_infer_steps steps);

/** Whether numbers mostly fall where elevations begin again, or that is not
 * seen. */
bool lum_infer_begins_again(lum_infer_steps steps);

/** Bits that differ by eye, and by nothing else.
 * @param eye_bit of the header; ::LUM_INFER_HEAD_BITS: one eye, no bits. */
lum_infer_bits lum_infer_eye_bits(const lum_infer_starts *starts,
                                  unsigned eye_bit);

/** Whether a bit can be the lowest of a line number: no field has it, and it
 * changes with most lines of an eye. */
bool lum_infer_is_lowest(const lum_infer_starts *starts, unsigned bit,
                         unsigned eye_bit, const lum_infer_bits *eye_bits);

/** The best line number whose lowest bit is this one.
 * @param eye_bits from lum_infer_eye_bits().
 * @param clock bits that are no part of it. */
lum_infer_line lum_infer_try_lowest(const lum_infer_starts *starts,
                                    unsigned lowest, unsigned eye_bit,
                                    const lum_infer_bits *eye_bits,
                                    const lum_infer_bits *clock);

#endif
