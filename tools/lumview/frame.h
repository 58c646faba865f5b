/* A frame as the page gets it: the messages that lum/frame/packed.h describes,
 * one behind the other. */
#ifndef LUMVIEW_FRAME_H
#define LUMVIEW_FRAME_H

#include <stddef.h>
#include <stdint.h>

/* What the time of a frame is, as lum_packed_time has it. */
enum frame_time {
    FRAME_TIME_UNKNOWN,
    FRAME_TIME_ARRIVAL, /* when its earliest line came: nothing is fitted */
    FRAME_TIME_FITTED   /* when that line began, by the sensor's clock fitted to
                           arrivals */
};

/* Counted by reference: a slow browser keeps the one that it is being sent
 * while newer ones come and go. Any thread. */
struct frame;

struct frame *frame_keep(struct frame *frame);
void frame_release(struct frame *frame); /* NULL is allowed */
const uint8_t *frame_bytes(const struct frame *frame, size_t *len);

/* Bytes of the message that begins at one of these; 0: there is none any more.
 */
size_t frame_piece(const struct frame *frame, size_t at);

#endif
