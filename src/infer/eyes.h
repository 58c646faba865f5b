/** @file
 * Which bit tells the two eyes apart, and the field around it. Internal. */
#ifndef LUM_INFER_EYES_H
#define LUM_INFER_EYES_H

#include "infer/starts.h"

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
