/** @file
 * The laser status bits by name (docs/protocol.md, section 5). */
#ifndef LUM_HOST_LASER_NAME_H
#define LUM_HOST_LASER_NAME_H

#include "lum/laser.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The manual's name of a bit, BIT_10 and so on where it has none.
 * @param bit 0..15.
 * @return a static string; NULL if bit is above 15. */
const char *lum_laser_bit_name(unsigned bit);

/** What a status tells of the laser: "down", "up", or "may be up" where it
 * tells neither. A static string. */
const char *lum_laser_status_name(uint16_t status);

#ifdef __cplusplus
}
#endif

#endif
