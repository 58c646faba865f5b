/* The state of a framer's sensors, to go on from a place in the middle of a
 * capture. Points of frames under way are no part of it. */
#ifndef LUM_FRAME_FRAMER_STATE_H
#define LUM_FRAME_FRAMER_STATE_H

#include "base/pack.h"
#include "lum/frame/framer.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Forget all sensors and what was under way; views and options stay. */
void lum_framer_restart(lum_framer *framer);

/* Its demultiplexer, to be changed. */
lum_demux *lum_framer_sensors(lum_framer *framer);

/* Whether it hands out frames, of a sensor by its index. */
bool lum_framer_gives(const lum_framer *framer, size_t sensor);

/* Whether lum_framer_skip_to() was called. */
bool lum_framer_is_skipping(const lum_framer *framer);

/* What decides which frames there are and what is known of them, but for their
 * points: only to be compared. */
void lum_framer_pack_options(const lum_framer *framer, lum_pack *pack);

/* The clocks that it was given, before it has taken a record, in either
 * direction. False: something failed. */
bool lum_framer_pack_clocks(lum_framer *framer, lum_pack *pack);

/* All of one sensor, in either direction, where no event is under way.
 * from: no line of this frame or one behind it has been handed out. Frames
 * before it lose their points so far.
 * False: it has handed out no line yet, or something failed; then what was read
 * is of no use. */
bool lum_framer_pack_sensor(lum_framer *framer, size_t sensor, uint32_t from,
                            lum_pack *pack);

/* Have samples of lines without these numbers: LUM_LEAVE_DEGREES and
 * LUM_LEAVE_RETURNS of points/columns.h. */
void lum_framer_leave(lum_framer *framer, unsigned leaves);

/* The lines of the frame that was handed out last, by eye, which show what the
 * next one lacks; 0 before the first. */
void lum_framer_get_lines(const lum_framer *framer, size_t sensor,
                          uint32_t out[LUM_EYES]);

/* The same for the first frame that is not before this one, in place of what
 * will be known then. */
void lum_framer_set_lines(lum_framer *framer, size_t sensor, int64_t frame,
                          const uint32_t lines[LUM_EYES]);

#endif
