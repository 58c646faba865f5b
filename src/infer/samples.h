/** @file
 * Samples by what they look like: angles sweep, words of ranges rise by pixel.
 * Internal. */
#ifndef LUM_INFER_SAMPLES_H
#define LUM_INFER_SAMPLES_H

#include "infer/state.h"

/** Find the order and the place of samples, and each packet's kind.
 * @param state its packets are marked; samples and their range are set.
 * @return whether samples of angles were found. */
bool lum_infer_find_samples(lum_infer_state *state);

/** Where samples begin, of the packets of the data's type. */
void lum_infer_place_samples(lum_infer_state *state);

/** Samples that fit behind the header.
 * @return how many; 0 where it is too short. */
uint32_t lum_infer_room(const lum_infer_packet *packet, unsigned samples_at);

#endif
