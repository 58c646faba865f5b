/** @file
 * The laser status bits by name (docs/protocol.md, section 5). */
#ifndef LUM_HOST_LASER_NAME_H
#define LUM_HOST_LASER_NAME_H

#include "lum/laser.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The manual's name of a bit; without one, BIT_10 and so on.
 * @param bit 0..15.
 * @return a static string; NULL if bit is above 15. */
const char *lum_laser_bit_name(unsigned bit);

/** The laser's state by a status: "down", "up", or "may be up" if it shows
 * neither. A static string. */
const char *lum_laser_status_name(uint16_t status);

/** Room for the names of all bits with two bytes between them, and a NUL. */
#define LUM_LASER_BITS_TEXT 320u

/** The names of the bits that are set, such as "HW_SAFETY_BAD TLV_CMD_OFF";
 * "none" without any.
 * @param between text between two names.
 * @param out     room bytes; the text is cut to room - 1, and ends with a NUL.
 * @param room    at least 1.
 * @return out. */
const char *lum_laser_bits_name(uint16_t bits, const char *between, char *out,
                                size_t room);

#ifdef __cplusplus
}
#endif

#endif
