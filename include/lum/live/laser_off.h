/** @file
 * Switches the laser off and verifies that it is down (docs/protocol.md,
 * sections 4 and 5; docs/safety.md). A program with a laser session uses
 * lum_laser_session_end() of lum/live/laser_session.h, which also reports the
 * result. */
#ifndef LUM_LIVE_LASER_OFF_H
#define LUM_LIVE_LASER_OFF_H

#include "lum/net/sensor.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How an attempt to switch the laser off ended. */
typedef enum lum_laser_off {
    LUM_LASER_OFF_SEEN,    /**< a status showed it down, and a later one
                                still */
    LUM_LASER_OFF_UNKNOWN, /**< no answer: it may be on */
    LUM_LASER_OFF_REFUSED, /**< answers came, and it is up, or would come up by
                                itself when a hazard ends: see the status */
    LUM_LASER_OFF_UNSEEN   /**< answers came, but none has a status: it may be
                                on, or the profile's tlv.status is wrong */
} lum_laser_off;

#define LUM_SENSOR_OFF_MS       10000u /**< how long it is tried */
#define LUM_SENSOR_OFF_EVERY_MS 50u    /**< between its commands */
#define LUM_SENSOR_SETTLE_MS    300u   /**< between its two looks */

/** Switch the laser off and verify that it is down: the command's own answer
 * must show it, and a poll `LUM_SENSOR_SETTLE_MS` later must still show it,
 * because an old `laser on` may have been delayed in the network. If the poll
 * shows the laser up, or down with TLV_CMD_ON, it begins again: with TLV_CMD_ON
 * the laser would come up when a hazard ends (with TLV_CMD_OFF too, which no
 * sensor should show, it tries retries + 1 times). A request without an answer
 * is sent again every `LUM_SENSOR_OFF_EVERY_MS`, whatever the options' timeout
 * is. After retries + 1 answers without a status it ends. It takes at most 3 s
 * more than ms. The session's cancel does not end it, as that is the usual
 * reason to call it. An owner sends no heartbeats meanwhile, so a sensor that
 * receives nothing of this switches itself off within 3 s. Data that comes
 * meanwhile is dropped.
 * @param ms     how long to try, usually LUM_SENSOR_OFF_MS; the command is sent
 *               at least once.
 * @param cancel ends it between two sends, as if the time were over; may be
 *               NULL. The session's own cancel does not.
 * @param status gets the last status, and is unchanged if none came; may be
 *               NULL. */
lum_laser_off lum_sensor_laser_off(lum_sensor *sensor, uint32_t ms,
                                   const lum_cancel *cancel, uint16_t *status);

#ifdef __cplusplus
}
#endif

#endif
