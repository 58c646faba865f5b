/* A frame as the page gets it: the messages that lum/frame/packed.h describes,
 * one after the other. */
#ifndef LUMVIEW_PAGE_FRAME_H
#define LUMVIEW_PAGE_FRAME_H

#include "lum/frame/packed.h"

#include <stddef.h>
#include <stdint.h>

/* Enough for any sensor, and no more than a browser can take. */
#define FRAME_POINTS_MAX 8000000u

/* Buffers that frames no longer need, kept for the next. Any thread. */
struct frame_pool;

/* NULL without memory. */
struct frame_pool *frame_pool_new(void);

/* No more frames can be made; existing ones stay valid. NULL is allowed. */
void frame_pool_free(struct frame_pool *pool);

/* Counted by reference: a slow browser keeps the one that it is being sent
 * while newer ones come and go. Any thread. */
struct frame;

/* As lum_packed_make(), with at most FRAME_POINTS_MAX points. NULL without
 * memory. */
struct frame *frame_make(struct frame_pool *pool, const lum_packed_head *head,
                         const lum_packed_part *parts, size_t count);

struct frame *frame_keep(struct frame *frame);
void frame_release(struct frame *frame); /* NULL is allowed */
const uint8_t *frame_bytes(const struct frame *frame, size_t *len);

/* Length of the message that begins at this byte; 0: there are no more. */
size_t frame_piece(const struct frame *frame, size_t at);

#endif
