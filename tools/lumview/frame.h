/* A frame as the page gets it: one binary message, little-endian, laid out so
 * that each array can be used where it lies.
 *
 *  at        type   what
 *  0         u32    0x464d554c, "LUMF"
 *  4         u16    version, 4
 *  6         u16    bytes of this head, 80
 *  8         f64    frame number
 *  16        f64    sensor clock of its earliest line, microseconds
 *  24        f64    when that line began, seconds of UTC; 0: not known
 *  32        u32    N, points
 *  36        u8     edges, an enum lum_edges
 *  37        u8     smoothing window, 0: none
 *  38        u8     what that time is, an enum frame_time
 *  39        u8     M, sensors of a rig that it has; 0: no rig. The frame
 * number is then that of pictures of all, from 1 on 40        u32    lines 44
 * u32    lost words, from below 48        u32    sensor's address 52        u32
 * count of frames shown so far, this one included: that of a frame before the
 * shown one, sent as it was asked for, is below the shown one's 56        f64
 * when it was complete, seconds of the monotonic clock 64        f64    seconds
 * by which the time may be off, where it is fitted 72        u32    of the N
 * points, those by the second profile, which are the last ones; 0 without one
 *  76        u32    0
 *  80        f32    x y z of each point, metres            3 N
 *  80 + 12 N u16    pulse width, 0.01 ns, at most 65535    N
 *  80 + 14 N u16    line number, at most 65535             N
 *  80 + 16 N u16    pixel                                  N
 *  80 + 18 N u8     bits 0..6: return number, at most 127,
 *                   bit 7: strongest of its pixel and edge N
 *  80 + 19 N u8     bit 0: eye (0 blue, 1 green), bit 1: rising edge,
 *                   bits 2..7: number of returns, at most 63   N
 *  80 + 20 N f64    of each of those sensors: the number of its frame,  M
 *                   with it
 *            u32    how many of the N points, one sensor's after the other's,
 *            u32    and its place in the rig's file, from 0 on
 */
#ifndef LUMVIEW_FRAME_H
#define LUMVIEW_FRAME_H

#include <stddef.h>
#include <stdint.h>

#define FRAME_MAGIC       0x464d554cu
#define FRAME_VERSION     4u
#define FRAME_HEAD_BYTES  80u
#define FRAME_POINT_BYTES 20u
#define FRAME_PART_BYTES  16u

/* What the time of a frame is. */
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

#endif
