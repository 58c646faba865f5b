/** @file
 * The laser switched off, and seen to be down (docs/protocol.md, sections 4 and
 * 5; docs/safety.md). A program that keeps a session uses
 * lum_laser_session_end() of lum/live/laser_session.h, which does this and says
 * what came of it. */
#ifndef LUM_LIVE_LASER_OFF_H
#define LUM_LIVE_LASER_OFF_H

#include "lum/net/sensor.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How an attempt to switch the laser off ended. */
typedef enum lum_laser_off {
    LUM_LASER_OFF_SEEN,    /**< a status shows it down, and stayed so */
    LUM_LASER_OFF_UNKNOWN, /**< no answer: it may be on */
    LUM_LASER_OFF_REFUSED, /**< answers came, and it is up, or would come up by
                                itself when a hazard ends: see the status */
    LUM_LASER_OFF_UNSEEN   /**< answers came, but none has a status: it may be
                                on, or the profile's tlv.status is wrong */
} lum_laser_off;

#define LUM_SENSOR_OFF_MS       10000u /**< how long it is tried */
#define LUM_SENSOR_OFF_EVERY_MS 50u    /**< between its commands */
#define LUM_SENSOR_SETTLE_MS    300u   /**< between its two looks */

/** Switch the laser off and see that it is down: the command's own answer must
 * show it, and a poll `LUM_SENSOR_SETTLE_MS` later must show it still, because
 * an old `laser on` may have been delayed in the network. If the poll shows it
 * on, all begins again; also if it shows the laser down and TLV_CMD_ON, since
 * it would come up when a hazard ends (with TLV_CMD_OFF beside it, which no
 * sensor should show, retries + 1 times). What is not answered is sent again
 * every `LUM_SENSOR_OFF_EVERY_MS` before it is given up, whatever the options'
 * timeout is. Answers without a status end it after retries + 1 of them. At
 * most 3 s more than that pass. Not ended by the cancel, which is the most
 * usual reason to call it. An owner sends no heartbeats during this time, so
 * that a sensor that receives none of this switches itself off within 3 s. Data
 * that comes during this time is dropped.
 * @param ms     to go on for without success, LUM_SENSOR_OFF_MS as a rule; the
 *               command is sent once at least.
 * @param cancel ends it between two sends, as if the time were over; it need
 *               not be the session's, which has no part in it; may be NULL.
 * @param status gets the last status that was answered, and stays as it is when
 *               there was none; may be NULL. */
lum_laser_off lum_sensor_laser_off(lum_sensor *sensor, uint32_t ms,
                                   const lum_cancel *cancel, uint16_t *status);

#ifdef __cplusplus
}
#endif

#endif
