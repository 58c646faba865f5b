/* Frames as the library makes them to the messages that the page gets. */
#ifndef LUMVIEW_FRAME_MAKE_H
#define LUMVIEW_FRAME_MAKE_H

#include "frame.h"

#include "lum/frame/packed.h"

#include <stdint.h>

/* Enough for any sensor, and no more than a browser can take. */
#define FRAME_POINTS_MAX 8000000u

/* What frame_make() reads. */
#define FRAME_COLUMNS LUM_PACKED_COLUMNS

/* Buffers that frames no longer need, kept for the next. Any thread. */
struct frame_pool;

/* NULL without memory. */
struct frame_pool *frame_pool_new(void);

/* No frame is made any more; those that there are live on. NULL is allowed. */
void frame_pool_free(struct frame_pool *pool);

/* When a frame began. */
struct frame_moment {
    enum frame_time kind;
    int64_t utc_ns;   /* 0: not known */
    int64_t error_ns; /* how far off it may be, where it is fitted; or
                         LUM_CLOCK_ERROR_UNKNOWN */
};

/* The rest of the head. */
struct frame_head {
    int64_t frame;
    int64_t clock_us;
    struct frame_moment begin;
    int64_t complete_ns;
    lum_edges edges;
    unsigned smooth;
    uint32_t lines;
    uint64_t lost_words;
    uint32_t sensor;
    uint64_t shown;
};

/* points: with FRAME_COLUMNS, and at most FRAME_POINTS_MAX. second: those by a
 * second profile, which stand behind; NULL: there are none. NULL without
 * memory. */
struct frame *frame_make(struct frame_pool *pool, const lum_frame *points,
                         const lum_frame *second,
                         const struct frame_head *head);

/* One sensor of a rig. */
struct frame_part {
    const lum_frame *points;
    int64_t frame;   /* its own number */
    unsigned sensor; /* its place in the rig */
};
#define FRAME_PARTS_MAX LUM_PACKED_PARTS_MAX

/* Likewise of one to FRAME_PARTS_MAX sensors of a rig. */
struct frame *frame_make_rig(struct frame_pool *pool,
                             const struct frame_part *parts, size_t count,
                             const struct frame_head *head);

#endif
