/** @file
 * Beginnings of lines: the first packet of angles of each line, what bits do
 * among them, and the line numbers and eyes that this tells. Internal. */
#ifndef LUM_INFER_STARTS_H
#define LUM_INFER_STARTS_H

#include "infer/state.h"

/** Most beginnings of lines that are looked at. */
#define LUM_INFER_STARTS_MAX 6000u

/** Bits of a header. As the bit that tells the eye: there is one eye. */
#define LUM_INFER_HEAD_BITS (8u * LUM_INFER_HEAD_BYTES)

/** Beginnings of lines, in the order of arrival, sensor by sensor. */
typedef struct lum_infer_starts {
    const lum_infer_state *state;
    const lum_infer_packet **at;
    size_t count;
    int height; /**< by which elevations differ */
} lum_infer_starts;

/** Whether a packet begins a line. */
bool lum_infer_is_start(const lum_infer_state *state,
                        const lum_infer_packet *packet);

/** Find them.
 * @param out to be freed with lum_infer_free_starts(), also after a failure.
 * @return 0, or -1 without memory. */
int lum_infer_find_starts(const lum_infer_state *state, lum_infer_starts *out);

/** Free them. */
void lum_infer_free_starts(lum_infer_starts *starts);

/** A bit of a packet's header; 0 for one behind it. */
unsigned lum_infer_bit_of(const lum_infer_packet *packet, unsigned bit);

/** Whether a bit of the header is in a set. */
bool lum_infer_has_bit(const lum_infer_bits *bits, unsigned bit);

/** The share of beginnings in which a bit is 1. */
double lum_infer_share_of_ones(const lum_infer_starts *starts, unsigned bit);

/** Whether two bits tell the same packets apart, or the other way round. */
bool lum_infer_is_same_split(const lum_infer_starts *starts, unsigned a,
                             unsigned b);

/** Bits of a byte that change among the lines of an eye.
 * @param differs may be NULL; gets the bits that differ by eye alone. */
unsigned lum_infer_changing(const lum_infer_starts *starts, unsigned at,
                            unsigned eye_bit, unsigned *differs);

/** Whether a bit changes among the lines of an eye. */
bool lum_infer_is_changing(const lum_infer_starts *starts, unsigned bit,
                           unsigned eye_bit);

/* --- Fields that rise by 1 from line to line of an eye: line_numbers.c --- */

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

/* --- Bits that tell the eyes apart, and the field around: eyes.c --- */

/** Most ways of telling eyes apart. */
#define LUM_INFER_SPLITS_MAX 48u

/** Bits that may tell the eyes apart, one of those that tell the same.
 * @param time bits that are none of them: the clock's.
 * @return how many; the first is ::LUM_INFER_HEAD_BITS, one eye. */
size_t lum_infer_find_splits(const lum_infer_starts *starts,
                             const lum_infer_bits *time,
                             unsigned out[LUM_INFER_SPLITS_MAX]);

/** The share of lines whose eye is not that of the line before. */
double lum_infer_share_of_turns(const lum_infer_starts *starts,
                                unsigned eye_bit);

/** The field of the eye: of all bytes in which eyes differ, the one with most
 * of such bits.
 * @param used bits of other fields.
 * @param clock bits of the clock, beside which an eye is not looked for if
 *              any other byte will do.
 * @param equal gets another one that tells the same; bytes 0: there is none.
 * @return bytes 0: none. */
lum_field lum_infer_eye_field(const lum_infer_starts *starts,
                              const lum_infer_bits *used,
                              const lum_infer_bits *clock, unsigned eye_bit,
                              lum_field *equal);

/** The values that most packets of each eye have, the lower one first. */
void lum_infer_eye_values(const lum_infer_starts *starts, lum_field field,
                          unsigned eye_bit, uint32_t out[LUM_EYES]);

/** With one eye alone: a byte that no field has and that is always the same,
 * the usual one or else the first; where there is none, the highest bit above
 * the line number. */
void lum_infer_take_one_eye(lum_infer_state *state,
                            const lum_infer_starts *starts);

#endif
