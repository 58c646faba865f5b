#include "frames.h"

#include <string.h>

void frames_init(lum_frame_state *self)
{
    memset(self, 0, sizeof *self);
    self->past = INT64_MIN;
}

int64_t frames_current(const lum_frame_state *self)
{
    return self->begun ? self->frame : 1;
}

void frames_break(lum_frame_state *self)
{
    if (!self->begun) {
        return;
    }
    self->after_break = true;
    if (self->past < self->frame) {
        self->past = self->frame;
    }
}

static bool is_near(int64_t a, int64_t b, unsigned reach)
{
    return a - b <= (int64_t)reach && b - a <= (int64_t)reach;
}

static int64_t first_frame(const lum_frame_state *other, int64_t l, unsigned r)
{
    if (!other->begun) {
        return 1;
    }
    if (is_near(l, other->top, r)) {
        return other->frame;
    }
    return l > other->top ? other->frame - 1 : other->frame + 1;
}

static void begin_frame(lum_frame_state *self, const lum_frame_state *other,
                        int64_t l, int64_t gap, unsigned r, uint64_t *skipped)
{
    *skipped += (uint64_t)self->gap;
    self->frame++;
    if (other->begun && is_near(l, other->top, r) &&
        self->frame < other->frame) {
        self->frame = other->frame;
    }
    self->top = l;
    self->gap = gap;
}

static bool is_wrap(const lum_frame_state *self, const lum_frame_state *other,
                    int64_t l, unsigned r)
{
    return l < self->top - (int64_t)r ||
           (other->begun && other->frame > self->frame &&
            is_near(l, other->top, r));
}

static void advance(lum_frame_state *self, int64_t l)
{
    if (l > self->top) {
        self->gap += l - self->top - 1;
        self->top = l;
    } else if (l < self->top && self->gap > 0) {
        self->gap--;
    }
}

/* Keeps the frame numbers of the latest r lines, the highest first. */
static void note_latest(lum_frame_state *self, int64_t frame, unsigned r)
{
    unsigned i = self->latest_count;
    if (i < r) {
        self->latest_count++;
    } else if (frame > self->latest[r - 1u]) {
        i = r - 1u;
    } else {
        return;
    }
    while (i > 0 && self->latest[i - 1u] < frame) {
        self->latest[i] = self->latest[i - 1u];
        i--;
    }
    self->latest[i] = frame;
}

static int64_t decide(lum_frame_state *self, const lum_frame_state *other,
                      int64_t l, unsigned r, uint64_t *skipped)
{
    if (!self->begun) {
        self->begun = true;
        self->since_wrap = (uint8_t)r;
        self->frame = first_frame(other, l, r);
        self->top = l;
        return self->frame;
    }
    if (self->after_break) {
        self->after_break = false;
        self->since_wrap = (uint8_t)r;
        begin_frame(self, other, l, 0, r, skipped);
        return self->frame;
    }
    if (is_wrap(self, other, l, r)) {
        self->previous_top = self->top;
        self->since_wrap = 0;
        begin_frame(self, other, l, l, r, skipped);
        return self->frame;
    }
    if (self->since_wrap < r) {
        self->since_wrap++;
    }
    if (l > self->top + (int64_t)r && self->since_wrap < r &&
        l >= self->previous_top - (int64_t)r) {
        return self->frame - 1;
    }
    advance(self, l);
    return self->frame;
}

int64_t frames_decide(lum_frame_state *self, const lum_frame_state *other,
                      uint32_t line, unsigned reorder_lines,
                      uint64_t *lines_skipped)
{
    const int64_t frame =
        decide(self, other, (int64_t)line, reorder_lines, lines_skipped);
    note_latest(self, frame, reorder_lines);
    return frame;
}

void frames_update_past(lum_frame_state *self, unsigned reorder_lines,
                        int64_t open_frame)
{
    if (self->latest_count < reorder_lines) {
        return;
    }
    int64_t past = self->latest[reorder_lines - 1u] - 1;
    if (past >= open_frame) {
        past = open_frame - 1;
    }
    if (self->past < past) {
        self->past = past;
    }
}
