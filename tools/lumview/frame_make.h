/* Frames being made: points of lines come in, and go at once where the message
 * has them. */
#ifndef LUMVIEW_FRAME_MAKE_H
#define LUMVIEW_FRAME_MAKE_H

#include "frame.h"

#include "lum/points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Enough for any sensor, and no more than a browser can take. */
#define FRAME_POINTS_MAX 8000000u

/* Buffers that frames no longer need, kept for the next. Any thread. */
struct frame_pool;

/* points_max: of a frame; the rest is cut off. NULL without memory. */
struct frame_pool *frame_pool_new(size_t points_max);

/* No frame is begun any more; those that there are live on. NULL is allowed. */
void frame_pool_free(struct frame_pool *pool);

/* An empty frame; NULL without memory. */
struct frame *frame_begin(struct frame_pool *pool);

/* Which points of a line, and of which. */
struct frame_part {
    const lum_sample *samples;
    const uint8_t *strongest; /* of each sample, 1 or 0 */
    size_t count;
    lum_edges edges; /* of the samples, these */
    uint32_t line;
    uint8_t eye;
};

/* False: there was no memory for more, and the part is not in it. */
bool frame_add(struct frame *frame, const struct frame_part *part);

/* Points that were cut off. */
uint64_t frame_cut(const struct frame *frame);

/* The rest of the head. */
struct frame_head {
    int64_t frame;
    int64_t clock_us;
    int64_t utc_ns; /* 0: not known */
    int64_t complete_ns;
    lum_edges edges;
    unsigned smooth;
    uint32_t lines;
    uint64_t lost_words;
    uint32_t sensor;
    uint64_t shown;
};

/* Nothing is added any more; the frame can be shown to others. */
void frame_seal(struct frame *frame, const struct frame_head *head);

#endif
