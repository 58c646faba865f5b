/** @file
 * Beginnings of lines: the first packet of angles of each line, and what bits
 * do among them. Internal. */
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

#endif
