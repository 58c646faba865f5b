/* Frame numbers of one eye's lines (docs/protocol.md, section 6, Frames). */
#ifndef LUM_CORE_FRAMES_H
#define LUM_CORE_FRAMES_H

#include "lum/assembler.h"

/* Numbers are never below 0, which the eyes' state begins with: the eye that
 * begins second is at most one behind the other, whose first frame is 1, and
 * a line is one behind its eye's frame only after that has grown. */

/* The frame of a line that has just got its second packet. */
int64_t lum_frames_decide(lum_assembler *a, lum_eye_state *eye,
                          const lum_eye_state *other, uint32_t line);

/* The clock has jumped and no line is open: the next line begins a frame. */
void lum_frames_break(lum_eye_state *eye);

/* Counts the lines that the frame lacks, once. */
void lum_frames_count_gap(lum_assembler *a, lum_eye_state *eye);

/* There is a line of this frame, so it will be announced. */
void lum_frames_note(lum_assembler *a, int64_t frame);

#endif
