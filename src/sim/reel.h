/** @file
 * Frames rendered in advance, to be sent repeatedly like those of a live
 * sensor: datagrams whose clocks are set when they are sent, and whose returns
 * are reduced to those that the laser's power and the thresholds leave.
 *
 * Frames are rendered at full power and with the lowest threshold; each range
 * word's strength is kept beside it. Reducing a line is fast and is repeated
 * only when gain or thresholds changed. Rendering is slow, and another thread
 * can do it while this one plays another reel. */
#ifndef LUM_SIM_REEL_H
#define LUM_SIM_REEL_H

#include "lum/result.h"
#include "packets.h"
#include "render.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Frames of a scene, rendered. */
typedef struct lum_reel lum_reel;

/** What to let through. */
typedef struct lum_reel_settings {
    float gain;                /**< 0..1; 0: no ranges at all */
    float threshold[LUM_EYES]; /**< by ::lum_eye; 1 is usual, 0 shows all */
} lum_reel_settings;

/** One datagram of a reel. */
typedef struct lum_reel_packet {
    const uint8_t *bytes; /**< lives until the next lum_reel_line() of this
                               frame and line, or lum_reel_free() */
    size_t len;           /**< of bytes */
} lum_reel_packet;

/** Whether a rendering should end early; called between lines, in the thread
 * that renders. */
typedef struct lum_reel_stop {
    bool (*ask)(void *context); /**< NULL: never */
    void *context;              /**< handed to ask */
} lum_reel_stop;

/** Render.
 * @param options what to render; gain and threshold are ignored.
 * @param frames  how many, at least 1.
 * @param stop    its ask may be NULL.
 * @param out     to be freed with lum_reel_free() after LUM_OK.
 * @return LUM_OK; LUM_E_VALUE as lum_render_init() or lum_packets_check();
 *         LUM_E_SPACE without memory; LUM_END when stopped. */
LUM_MUST_CHECK lum_result lum_reel_new(const lum_render_options *options,
                                       unsigned frames, lum_reel_stop stop,
                                       lum_reel **out);

/** Free. NULL is allowed. */
void lum_reel_free(lum_reel *reel);

/** How many frames it has. */
unsigned lum_reel_frames(const lum_reel *reel);

/** Lines of a frame. */
uint32_t lum_reel_lines(const lum_reel *reel);

/** Most datagrams of one line, both eyes. */
#define LUM_REEL_LINE_PACKETS (2u * LUM_PACKETS_LINE_MAX)

/** The datagrams of one line of both eyes, reduced and with a clock, in the
 * order in which they leave; the eyes take turns.
 * @param frame    below lum_reel_frames().
 * @param line     below lum_reel_lines().
 * @param clock_us the sensor's clock, which has not wrapped, for every one of
 *                 them.
 * @param out      room for LUM_REEL_LINE_PACKETS.
 * @return how many. */
size_t lum_reel_line(lum_reel *reel, unsigned frame, uint32_t line,
                     const lum_reel_settings *settings, int64_t clock_us,
                     lum_reel_packet *out);

#endif
