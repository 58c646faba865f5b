/* Frame numbers of lines (docs/protocol.md, section 6, Frames). */
#ifndef LUM_CORE_FRAMES_H
#define LUM_CORE_FRAMES_H

#include "lum/assembler.h"

/* Numbers of frames are compared as they go round 32 bits. */
static inline bool frame_is_before(uint32_t frame, uint32_t other)
{
    return (frame - other) >> 31 != 0;
}

/* Both eyes begin at frame 1, and there is none yet. All else is 0, their reach
 * too. */
void lum_frames_init(lum_assembler *a);

/* The frame of a line of an eye that has just got its second packet. */
uint32_t lum_frames_decide(lum_assembler *a, lum_eye_state *eye, uint32_t line);

/* The clock has jumped and no line of the eye is open: the next line begins a
 * frame. */
void lum_frames_break(lum_assembler *a, lum_eye_state *eye);

/* There is a line of this frame, so it will be announced. */
void lum_frames_note(lum_assembler *a, uint32_t frame);

/* Whether the next frame to announce is complete. */
bool lum_frames_are_due(const lum_assembler *a);

/* Whether frames are left that the end of the stream completes. */
bool lum_frames_remain(const lum_assembler *a);

/* Announces the next frame: it is the one before a->frames.next then. */
void lum_frames_announce(lum_assembler *a);

/* Counts the lines that the current frames lack; no line is open. */
void lum_frames_count_gaps(lum_assembler *a);

/* What comes next begins a frame behind all that were announced. */
void lum_frames_end(lum_assembler *a);

#endif
