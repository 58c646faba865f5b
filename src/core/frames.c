#include "frames.h"

#include "counter.h"

/* As if a reach of lines of the next frame had been decided: none of this one
 * is expected. */
void lum_frames_break(lum_eye_state *eye)
{
    if (!eye->begun) {
        return;
    }
    eye->after_break = true;
    for (unsigned i = 0; i < LUM_REORDER_MAX; i++) {
        eye->highest[i] = eye->frame + 1;
    }
}

void lum_frames_count_gap(lum_assembler *a, lum_eye_state *eye)
{
    lum_counter_add(&a->counters.lines_skipped, eye->gap);
    eye->gap = 0;
}

static bool is_far_above(uint32_t a, uint32_t b, unsigned reach)
{
    return a > b && a - b > reach;
}

static bool is_beside(const lum_eye_state *other, uint32_t l, unsigned r)
{
    return other->begun && !is_far_above(l, other->top, r) &&
           !is_far_above(other->top, l, r);
}

static void begin(lum_eye_state *eye, const lum_eye_state *other, uint32_t l,
                  bool beside)
{
    eye->begun = true;
    eye->top = l;
    if (other->begun) {
        eye->frame = other->frame;
        if (!beside) {
            eye->frame += l > other->top ? -1 : 1;
        }
    }
}

/* Behind a break no line is missed, and none straggles. */
static void begin_frame(lum_eye_state *eye, int64_t frame, uint32_t l,
                        unsigned r)
{
    eye->frame = frame;
    eye->previous_top = eye->top;
    eye->top = l;
    eye->gap = eye->after_break ? 0 : l;
    eye->straggling = (uint8_t)(eye->after_break ? 0 : r);
    eye->after_break = false;
}

static bool is_straggler(lum_eye_state *eye, uint32_t l, unsigned r)
{
    if (eye->straggling > 0) {
        eye->straggling--;
    }
    return eye->straggling > 0 && is_far_above(l, eye->top, r) &&
           !is_far_above(eye->previous_top, l, r);
}

static void advance(lum_eye_state *eye, uint32_t l)
{
    if (l > eye->top) {
        eye->gap += l - eye->top - 1u;
        eye->top = l;
    } else if (l < eye->top && eye->gap > 0) {
        eye->gap--;
    }
}

/* Keeps the r highest frame numbers of lines, the highest first. */
static void note_highest(lum_eye_state *eye, int64_t frame, unsigned r)
{
    for (unsigned i = 0; i < r; i++) {
        const int64_t there = eye->highest[i];
        if (there < frame) {
            eye->highest[i] = frame;
            frame = there;
        }
    }
}

void lum_frames_note(lum_assembler *a, int64_t frame)
{
    if (frame < a->next_frame && !a->announced) {
        a->next_frame = frame;
    }
    if (frame > a->highest_frame) {
        a->highest_frame = frame;
    }
}

int64_t lum_frames_decide(lum_assembler *a, lum_eye_state *eye,
                          const lum_eye_state *other, uint32_t line)
{
    const unsigned r = a->config.reorder_lines;
    const bool beside = is_beside(other, line, r);
    const bool behind = beside && other->frame > eye->frame;
    uint32_t back = 0;
    if (!eye->begun) {
        begin(eye, other, line, beside);
    } else if (eye->after_break || behind || is_far_above(eye->top, line, r)) {
        lum_frames_count_gap(a, eye);
        begin_frame(eye, behind ? other->frame : eye->frame + 1, line, r);
    } else if (is_straggler(eye, line, r)) {
        back = 1;
    } else {
        advance(eye, line);
    }
    const int64_t frame = eye->frame - back;
    note_highest(eye, frame, r);
    return frame;
}
