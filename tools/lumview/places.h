/* Where frames are in a capture: noted while it is read once, so that playing
 * goes there at once. Of one file that is not compressed, with one sensor shown
 * by one profile; all else is read from the start. */
#ifndef LUMVIEW_PLACES_H
#define LUMVIEW_PLACES_H

#include "decoder.h"

#include "lum/capture/capture.h"

#include <stdbool.h>
#include <stdint.h>

struct places;

/* To note them: before the first record is pushed. capture and decoder: kept,
 * until places_end(). NULL: they cannot be noted. */
struct places *places_new(lum_capture *capture, struct decoder *decoder);

/* All was read, or no more will be: they are known from here on. */
void places_end(struct places *places);
void places_free(struct places *places); /* NULL is allowed */

/* A record is pushed next; a frame came of it; it was pushed. All of them, up
 * to places_end(), or none. NULL is allowed. */
void places_begin_record(struct places *places);
void places_note_frame(struct places *places);
void places_note_record(struct places *places);

/* They are of no use: nothing leads anywhere from here on. NULL is allowed. */
void places_drop(struct places *places);

/* The frame with which reading would begin to get to a frame. False: all must
 * be read. NULL is allowed. */
bool places_find(const struct places *places, int64_t frame, int64_t *begin);

/* Go to where a reading gives a frame and all behind it, with a capture and a
 * decoder that were just opened, with the options of those that they were
 * noted with. False: they are at their start, as before. */
bool places_go(struct places *places, lum_capture *capture,
               struct decoder *decoder, int64_t frame);

#endif
