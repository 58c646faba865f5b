/* A laser status for a person. */
#ifndef LUM_TOOLS_LASER_BITS_H
#define LUM_TOOLS_LASER_BITS_H

#include <stddef.h>
#include <stdint.h>

/* Names of the bits of a status that are in a mask, or "none". Returns out. */
const char *laser_bits_name(uint16_t status, uint16_t mask, char *out,
                            size_t room);

/* What put the laser down, behind the names of the bits: ": ..." where that is
 * no hazard but a command to be off, which a sensor also shows after a time
 * without heartbeats; else "". */
const char *laser_bits_cause(uint16_t status);

#endif
