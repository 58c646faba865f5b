/* Frame numbers of one eye's lines (docs/protocol.md, section 6, Frames). */
#ifndef LUM_CORE_FRAMES_H
#define LUM_CORE_FRAMES_H

#include "lum/assembler.h"

void frames_init(lum_frame_state *self);

/* The frame of a line that has just got its second packet. lines_skipped
 * grows when a frame ends here. */
int64_t frames_decide(lum_frame_state *self, const lum_frame_state *other,
                      uint32_t line, unsigned reorder_lines,
                      uint64_t *lines_skipped);

/* The frame of a line that closes undecided. */
int64_t frames_current(const lum_frame_state *self);

/* The clock has jumped and no line is open: the next line begins a frame. */
void frames_break(lum_frame_state *self);

/* Note how far this eye is past its frames.
 * open_frame: the lowest among its open, decided lines; INT64_MAX if none. */
void frames_update_past(lum_frame_state *self, unsigned reorder_lines,
                        int64_t open_frame);

#endif
