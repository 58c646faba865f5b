/** @file
 * The laser status bits (docs/protocol.md, section 5). */
#ifndef LUM_LASER_H
#define LUM_LASER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Bits 0 to 8 are hazards, the rest is information. */
enum lum_laser_bit {
    LUM_LASER_GALVO_AMP_BX_BAD = 0x0001,  /**< blue azimuth mirror */
    LUM_LASER_GALVO_AMP_BY_BAD = 0x0002,  /**< blue elevation mirror */
    LUM_LASER_GALVO_AMP_GX_BAD = 0x0004,  /**< green azimuth mirror */
    LUM_LASER_GALVO_AMP_GY_BAD = 0x0008,  /**< green elevation mirror */
    LUM_LASER_HEARTBEAT_TIMEOUT = 0x0010, /**< no heartbeat for 3 s */
    LUM_LASER_BOARD_OVER_105 = 0x0020,    /**< board too hot */
    LUM_LASER_FAN_PWM_BAD = 0x0040,       /**< fan */
    LUM_LASER_HW_SAFETY_BAD = 0x0080,     /**< hardware interlock */
    LUM_LASER_SYS_ON_SW_OFF = 0x0100,     /**< off by the SYS_ON switch */
    LUM_LASER_TLV_CMD_OFF = 0x0200,       /**< off by a TLV command */
    LUM_LASER_TLV_CMD_ON = 0x0800         /**< on by a TLV command */
};

#define LUM_LASER_HAZARDS    0x01ffu /**< bits 0 to 8 */
#define LUM_LASER_ALL_DOWN   0x07ffu /**< any of these: the laser is down */
#define LUM_LASER_ALL_SW_BAD 0x077fu /**< the manual's mask of that name */
#define LUM_LASER_BITS       16u     /**< bits in a status */

/** Whether the laser is down: any bit of LUM_LASER_ALL_DOWN. */
bool lum_laser_is_down(uint16_t status);

/** Whether the laser is on: TLV_CMD_ON, and no bit of LUM_LASER_ALL_DOWN. If a
 * status shows neither down nor on, such as 0, the laser may be on. */
static inline bool lum_laser_is_on(uint16_t status)
{
    const unsigned on = LUM_LASER_TLV_CMD_ON;
    return (status & (LUM_LASER_ALL_DOWN | on)) == on;
}

/** Whether any hazard bit is set. */
bool lum_laser_has_hazard(uint16_t status);

#ifdef __cplusplus
}
#endif

#endif
