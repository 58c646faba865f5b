/* In place of frames.c, for firmware that wants lines alone: their frame is 0,
 * none is announced, and lines that did not come are not counted. */
#include "frames.h"

void lum_frames_init(lum_assembler *a)
{
    (void)a;
}

uint32_t lum_frames_decide(lum_assembler *a, lum_eye_state *eye, uint32_t line)
{
    (void)a;
    (void)eye;
    (void)line;
    return 0;
}

void lum_frames_break(lum_assembler *a, lum_eye_state *eye)
{
    (void)a;
    (void)eye;
}

void lum_frames_note(lum_assembler *a, uint32_t frame)
{
    (void)a;
    (void)frame;
}

bool lum_frames_are_due(const lum_assembler *a)
{
    (void)a;
    return false;
}

bool lum_frames_remain(const lum_assembler *a)
{
    (void)a;
    return false;
}

void lum_frames_announce(lum_assembler *a)
{
    (void)a;
}

void lum_frames_count_gaps(lum_assembler *a)
{
    (void)a;
}

void lum_frames_end(lum_assembler *a)
{
    (void)a;
}
