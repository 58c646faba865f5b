/* From line numbers to frame numbers: where a sweep of an eye ends, and so
 * which frame a line belongs to. */
#include "frames.h"

#include "check.h"
#include "counter.h"
#include "stream.h"

/* The sensor does not say where a frame ends: its lines rise from 0 to the last
 * and begin again. Packets may be lost or overtake each other, but a line is at
 * most R lines late (reorder_lines, 8 by default). So:
 *
 * 1. Each eye keeps top, the highest line of its current frame. A line at most
 *    R below top is late, and of this frame.
 * 2. A line more than R below top can only be one of the next sweep: a new
 * frame begins, and its number is one more.
 * 3. Lines of the old frame may still come behind the first of the new one
 *    (stragglers). They are far above the new top, and are given the old
 * number.
 * 4. Both eyes sweep together. If the other eye has begun its next frame and
 *    stands beside this line, this eye has lost its own wrap, and begins too.
 * 5. A frame is complete when each eye has no open line of it and has decided R
 *    lines of later frames: then none of its lines can come any more. An eye
 *    that sends nothing (gap_us long) is not waited for.
 *
 * Numbers begin at 1 and only grow. Only two lines can be one below: those of
 * the eye that begins second, and stragglers. So 0 is the lowest number. */

void lum_frames_init(lum_assembler *a)
{
    a->eye[LUM_EYE_BLUE].frames.frame = 1;
    a->eye[LUM_EYE_GREEN].frames.frame = 1;
    a->frames.next = 1;
    a->frames.first = 1;
}

/* More than R lines above: reordering alone does not explain it. */
static bool is_far_above(uint32_t a, uint32_t b, unsigned reach)
{
    return a > b && a - b > reach;
}

/* Whether the other eye stands within a reach of the line. */
static bool is_beside(const lum_eye_frames *other, uint32_t line, unsigned r)
{
    return other->begun && !is_far_above(line, other->top, r) &&
           !is_far_above(other->top, line, r);
}

/* The first line of an eye: in the other's frame if it is beside its top; else
 * the other has just begun its next frame where this eye still is at the end of
 * one, or will begin it soon. */
static void begin(lum_eye_frames *f, const lum_eye_frames *other, uint32_t line,
                  bool beside)
{
    f->begun = true;
    f->top = line;
    if (other->begun) {
        f->frame = other->frame;
        if (!beside) {
            f->frame += line > other->top ? UINT32_MAX : 1u;
        }
    }
}

/* A frame ends: the lines below its top that never came are lost. gap is how
 * many these are. */
static void count_gap(lum_assembler *a, lum_eye_frames *f)
{
    lum_counter_add(&a->counters.lines_skipped, f->gap);
    f->gap = 0;
}

/* A new frame begins at a line: those below it are missing so far. After a
 * break none is known to be missing, and none comes late from the frame
 * before. */
static void begin_frame(lum_eye_frames *f, uint32_t frame, uint32_t line,
                        unsigned r)
{
    f->frame = frame;
    f->previous_top = f->top;
    f->top = line;
    f->gap = f->after_break ? 0 : line;
    f->straggling = (uint8_t)(f->after_break ? 0 : r);
    f->after_break = false;
}

/* A straggler is a line of the frame before that was overtaken by the first
 * lines of this one: far above this frame's top, not far below that frame's,
 * and fewer than R lines after the wrap. Each line here uses up one of them. */
static bool is_straggler(lum_eye_frames *f, uint32_t line, unsigned r)
{
    if (f->straggling > 0) {
        f->straggling--;
    }
    return f->straggling > 0 && is_far_above(line, f->top, r) &&
           !is_far_above(f->previous_top, line, r);
}

/* Lines that a rise of the top passes over are missing; each that comes below
 * the top is taken for one of them. */
static void advance(lum_eye_frames *f, uint32_t line)
{
    if (line > f->top) {
        f->gap += line - f->top - 1u;
        f->top = line;
    } else if (line < f->top && f->gap > 0) {
        f->gap--;
    }
}

/* Keeps the R highest frames of decided lines, the lowest first: when that one
 * is past a frame, R lines are. */
static void note_highest(lum_reach *reach, uint32_t frame, unsigned r)
{
    for (reach += r; r > 0; r--) {
        reach--;
        const uint32_t there = reach->frame;
        if (frame_is_before(there, frame)) {
            reach->frame = frame;
            frame = there;
        }
    }
}

/* Both eyes number without holes, so the span of the numbers counts them. The
 * first line of all is of frame 1; but one before it, of the eye that begins
 * second, none is below. Then that frame may have been passed over already. */
void lum_frames_note(lum_assembler *a, uint32_t frame)
{
    lum_frame_span *span = &a->frames;
    uint32_t more = 0;
    if (frame_is_before(span->highest, frame)) {
        more = frame - span->highest;
        span->highest = frame;
    } else if (frame < span->first) {
        more = span->first - frame;
        span->first = frame;
        if (span->announced == 0) {
            span->next = frame;
        }
    }
    lum_counter_add(&a->counters.frames, more);
}

uint32_t lum_frames_decide(lum_assembler *a, lum_eye_state *eye, uint32_t line)
{
    lum_eye_state *blue = &a->eye[LUM_EYE_BLUE];
    const lum_eye_frames *other =
        eye == blue ? &a->eye[LUM_EYE_GREEN].frames : &blue->frames;
    const unsigned r = a->config.reorder_lines;
    lum_eye_frames *f = &eye->frames;
    const bool beside = is_beside(other, line, r);
    /* step 4: the other eye wrapped, and this one's wrap was lost */
    const bool behind = beside && frame_is_before(f->frame, other->frame);
    uint32_t back = 0;
    if (!f->begun) {
        begin(f, other, line, beside);
    } else if (f->after_break || behind || is_far_above(f->top, line, r)) {
        /* steps 2 and 4, or the clock has jumped: a new frame */
        count_gap(a, f);
        begin_frame(f, behind ? other->frame : f->frame + 1u, line, r);
    } else if (is_straggler(f, line, r)) {
        back = 1; /* step 3 */
    } else {
        advance(f, line); /* step 1 */
    }
    const uint32_t frame = f->frame - back;
    note_highest(eye->reach, frame, r);
    lum_frames_note(a, frame);
    return frame;
}

/* As if a reach of lines of the next frame had been decided: none of this one
 * is expected. */
void lum_frames_break(lum_assembler *a, lum_eye_state *eye)
{
    LUM_CHECK(eye->lines.open_count == 0);
    if (!eye->frames.begun) {
        return;
    }
    eye->frames.after_break = true;
    for (unsigned i = 0; i < a->config.reorder_lines; i++) {
        eye->reach[i].frame = eye->frames.frame + 1u;
    }
}

/* Only lines of more than one packet of the other eye count as time, so that
 * one packet with a clock in the future makes no eye silent. */
static bool is_silent(const lum_assembler *a, const lum_eye_state *eye,
                      const lum_eye_state *other)
{
    return lum_stream_lead(&other->lines.low_clock_us, &eye->stream.heard_us) >
           (int32_t)a->config.gap_us;
}

/* Whether all open lines are of frames behind this one. A line of a single
 * packet has no frame yet, and does not hold one back. */
static bool are_lines_past(const lum_eye_state *eye, uint32_t frame)
{
    const lum_line_slot *slot = eye->lines.oldest;
    for (unsigned i = 0; i < eye->lines.open_count; i++) {
        if (slot->accepted >= 2 && !frame_is_before(frame, slot->frame)) {
            return false;
        }
        slot = slot->next;
    }
    return true;
}

/* Whether an eye has no open line of the next frame to announce, or of one
 * before it, and expects none. */
static bool is_past(const lum_assembler *a, const lum_eye_state *eye)
{
    return frame_is_before(a->frames.next, eye->reach->frame) &&
           are_lines_past(eye, a->frames.next);
}

/* Step 5. */
bool lum_frames_are_due(const lum_assembler *a)
{
    const lum_eye_state *blue = &a->eye[LUM_EYE_BLUE];
    const lum_eye_state *green = &a->eye[LUM_EYE_GREEN];
    const bool blue_past = is_past(a, blue);
    if (blue_past == is_past(a, green)) {
        return blue_past;
    }
    return blue_past ? is_silent(a, green, blue) : is_silent(a, blue, green);
}

bool lum_frames_remain(const lum_assembler *a)
{
    return !frame_is_before(a->frames.highest, a->frames.next);
}

void lum_frames_announce(lum_assembler *a)
{
    LUM_CHECK(lum_frames_remain(a));
    a->frames.announced = 1;
    a->frames.next++;
}

void lum_frames_count_gaps(lum_assembler *a)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        LUM_CHECK(a->eye[e].lines.open_count == 0);
        count_gap(a, &a->eye[e].frames);
    }
}

/* Where a line has been, an eye that has not begun counts as begun too: its
 * first line must not fall into a frame that was announced. */
void lum_frames_end(lum_assembler *a)
{
    LUM_CHECK(!lum_frames_remain(a));
    for (unsigned e = 0; e < LUM_EYES && a->frames.announced != 0; e++) {
        lum_eye_state *eye = &a->eye[e];
        eye->frames.begun = true;
        eye->frames.frame = a->frames.highest;
        lum_frames_break(a, eye);
    }
}
