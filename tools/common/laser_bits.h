/* A laser status for a person. */
#ifndef LUM_TOOLS_LASER_BITS_H
#define LUM_TOOLS_LASER_BITS_H

#include <stddef.h>
#include <stdint.h>

/* Names of the bits of a status that are in a mask, or "none". Returns out. */
const char *laser_bits_name(uint16_t status, uint16_t mask, char *out,
                            size_t room);

#endif
