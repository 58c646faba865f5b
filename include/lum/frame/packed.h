/** @file
 * Frames as messages for a page that draws them, about 9 bytes a point. Each
 * message is a piece of whole lines that are spread over the frame, so that the
 * first pieces already show all of it, coarsely. lumview sends them
 * (docs/look.md).
 *
 * A message is one piece, and also describes its whole frame. Numbers are
 * little-endian; those of 16 bits lie at even places, and messages at multiples
 * of 4.
 *
 *     at  type what
 *     0   u32  0x464d554c, "LUMF"
 *     4   u16  version, 5
 *     6   u16  bytes of this head, 104
 *     8   f64  frame number
 *     16  f64  sensor clock of its earliest line, microseconds
 *     24  f64  when that line began, seconds of UTC; 0: not known
 *     32  u32  points of the frame
 *     36  u8   edges, an enum lum_edges
 *     37  u8   smoothing window, 0: none
 *     38  u8   what that time is, an enum lum_packed_time
 *     39  u8   M, sensors of a rig in it; the frame number then counts pictures
 *              of all of them, from 1 on; 0: no rig
 *     40  u32  lines
 *     44  u32  lost words
 *     48  u32  sensor's address
 *     52  u32  count of frames shown so far, this one included; of an earlier
 *              frame, sent on request, below that of the shown one
 *     56  f64  when it was complete, seconds of the monotonic clock
 *     64  f64  seconds by which a fitted time may be off
 *     72  u32  points by a second profile, the last of all points; 0 without
 *              one
 *     76  f32  the coarsest step of its coordinates, metres: 2^-9
 *     80  u32  bytes of this message
 *     84  u32  which piece of the frame it is, from 0 on
 *     88  u32  pieces that the frame has, at least 1; they are sent in order
 *     92  u32  N, points in this piece
 *     96  u32  R, runs in this piece
 *     100 u32  O, kinds in this piece that are written out
 *     104      M sensors, 16 bytes each
 *              R runs, 32 bytes each
 *              u16  x steps, their low 16 bits, of each point: N
 *              u16  y, likewise: N
 *              u16  z, likewise: N
 *              u16  pulse width, 0.01 ns, at most 65535: N
 *              u8   bits 0..1: bits 16..17 of x; 2..3: of y; 4..5: of z; 6..7:
 *                   its kind, 0..2: one of its run's, 3: the next that is
 *                   written out: N
 *              u8   0, if N is odd
 *              u16  kinds that are written out: O
 *              u8   pixels of each run
 *              u8   0, up to a multiple of 4 bytes
 *
 * A sensor of a rig: f64 the number of its frame, u32 the number of its points,
 * which follow those of the sensor before, u32 its place in the rig's file,
 * from 0 on.
 *
 * A run is up to 4096 points that follow each other in the frame and in one
 * line:
 *
 *     at type what
 *     0  u32  its first point's place in the frame
 *     4  u32  line number
 *     8  i32  X, Y and Z
 *     20 u16  points, at least 1
 *     22 u16  pixel of the first one
 *     24 u16  three kinds
 *     30 u8   E
 *     31 u8   eye: 0 blue, 1 green
 *
 * The coordinate of a point is (X + its x steps) / 2^E metres, and likewise of
 * y and z. E is 9 to 12, the largest by which the run fits; so a coordinate is
 * off by at most half a step, 0.98 mm.
 *
 * A kind: bits 0..6 return number, at most 127; bit 7: strongest of its pixel
 * and edge; bit 8: 0; bit 9: rising edge; bits 10..15: number of returns, at
 * most 63.
 *
 * The pixels of a run are bits, from the lowest bit of a byte to the highest.
 * Each 0 goes on by one pixel, each 1 is a point in the current pixel; unused
 * bits of the last byte are 0.
 *
 * All functions only read what they are given and write the caller's memory;
 * any thread. */
#ifndef LUM_FRAME_PACKED_H
#define LUM_FRAME_PACKED_H

#include "lum/frame/frame.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The first four bytes of a message, as a little-endian number. */
#define LUM_PACKED_MAGIC UINT32_C(0x464d554c)
/** The version that this header describes. */
#define LUM_PACKED_VERSION 5u
/** Bytes of a message's head. */
#define LUM_PACKED_HEAD_BYTES 104u
/** Bytes of a sensor of a rig. */
#define LUM_PACKED_PART_BYTES 16u
/** Bytes of a run. */
#define LUM_PACKED_RUN_BYTES 32u
/** Most bytes of a message. */
#define LUM_PACKED_PIECE_BYTES 65536u
/** Most sensors of a rig. */
#define LUM_PACKED_PARTS_MAX 8u
/** Most points of a frame. */
#define LUM_PACKED_POINTS_MAX (UINT32_C(1) << 28)

/** The columns of a frame that lum_packed_part_of() needs. */
#define LUM_PACKED_COLUMNS                                                     \
    (LUM_COLUMNS_XYZ | LUM_COLUMN_BIT(LUM_COLUMN_PULSE_WIDTH) |                \
     LUM_COLUMN_BIT(LUM_COLUMN_LINE) | LUM_COLUMN_BIT(LUM_COLUMN_PIXEL) |      \
     LUM_COLUMN_BIT(LUM_COLUMN_RETURN_NUMBER) |                                \
     LUM_COLUMN_BIT(LUM_COLUMN_NUMBER_OF_RETURNS) |                            \
     LUM_COLUMN_BIT(LUM_COLUMN_EYE) | LUM_COLUMN_BIT(LUM_COLUMN_EDGE) |        \
     LUM_COLUMN_BIT(LUM_COLUMN_STRONGEST))

/** What the time of a frame is. */
typedef enum lum_packed_time {
    LUM_PACKED_TIME_UNKNOWN, /**< nothing */
    LUM_PACKED_TIME_ARRIVAL, /**< when its earliest line came: nothing is fitted
                              */
    LUM_PACKED_TIME_FITTED   /**< when that line began, by the sensor's clock
                                  fitted to arrivals */
} lum_packed_time;

/** The description of a frame in its messages. */
typedef struct lum_packed_head {
    size_t struct_size;   /**< sizeof(lum_packed_head), set by the caller */
    int64_t frame;        /**< its number */
    int64_t clock_us;     /**< sensor clock of its earliest line */
    int64_t utc_ns;       /**< when that line began; 0: not known */
    int64_t utc_error_ns; /**< how far off that may be, or
                               ::LUM_CLOCK_ERROR_UNKNOWN */
    int64_t complete_ns;  /**< when it was complete, by the monotonic clock */
    uint64_t lost_words;  /**< range words known to be lost */
    uint64_t shown;  /**< count of frames shown so far, this one included */
    uint32_t sensor; /**< its address, host order */
    uint32_t lines;  /**< lines that came */
    uint8_t time;    /**< what utc_ns is, a ::lum_packed_time */
    uint8_t edges;   /**< a ::lum_edges */
    uint8_t smooth;  /**< smoothing window; 0: none */
    bool is_rig;     /**< its parts are sensors of a rig; else the second part,
                          if there is one, has the points by a second profile */
} lum_packed_head;

/** Any points, in the order of a frame: those of a sensor, or by a profile. As
 * parts form an array, struct_size must be the size that this library has. */
typedef struct lum_packed_part {
    size_t struct_size;       /**< sizeof(lum_packed_part), set by the caller */
    size_t count;             /**< points */
    const float *x;           /**< metres, forward */
    const float *y;           /**< metres, left */
    const float *z;           /**< metres, up */
    const float *pulse_width; /**< nanoseconds; 0: not known */
    const uint32_t *line;     /**< line number */
    const uint16_t *pixel;    /**< in its line */
    const uint16_t *return_number;     /**< from 1 */
    const uint16_t *number_of_returns; /**< of the pixel and edge */
    const uint8_t *eye;                /**< an ::lum_eye */
    const uint8_t *edge;               /**< 1 rising, 0 falling */
    const uint8_t *strongest;          /**< 1: of its pixel and edge */
    int64_t frame;   /**< of a rig: the number of the sensor's frame */
    uint32_t sensor; /**< of a rig: its place in it, from 0 on */
} lum_packed_part;

/** The messages of a frame, one after the other. All bytes 0: none, and no
 * memory. It never grows. */
typedef struct lum_packed {
    uint8_t *bytes; /**< of lum_packed_make(); to be given to
                         lum_packed_free() */
    size_t len;     /**< bytes of all messages */
    size_t room;    /**< bytes of that memory */
} lum_packed;

/** The columns of a frame as points, which live as long as the frame. The
 * members frame and sensor become 0.
 * @param out struct_size is set by the caller.
 * @return LUM_OK; LUM_E_VALUE if the frame lacks one of ::LUM_PACKED_COLUMNS or
 *         struct_size is not set: then nothing is written. */
LUM_MUST_CHECK lum_result lum_packed_part_of(const lum_frame *frame,
                                             lum_packed_part *out);

/** Make the messages of a frame. Coordinates beyond 2^21 metres, and those that
 * are not finite, become arbitrary ones. Linear, except for a sort of the
 * lines.
 * @param parts one, or two of two profiles, or up to ::LUM_PACKED_PARTS_MAX
 *              sensors of a rig.
 * @param out   its messages are overwritten, and its memory is used again or
 *              enlarged.
 * @return LUM_OK; LUM_E_VALUE if a struct_size is not set, if there are too
 *         many or no parts or too many points; LUM_E_SPACE without memory. Then
 *         out has no messages. */
LUM_MUST_CHECK lum_result lum_packed_make(const lum_packed_head *head,
                                          const lum_packed_part *parts,
                                          size_t count, lum_packed *out);

/** Free the memory; all bytes become 0. */
void lum_packed_free(lum_packed *packed);

/** Bytes of the message that begins at a byte.
 * @param at where a message begins; packed->len after the last one.
 * @return 0: there is no other one. */
size_t lum_packed_piece(const lum_packed *packed, size_t at);

#ifdef __cplusplus
}
#endif

#endif
