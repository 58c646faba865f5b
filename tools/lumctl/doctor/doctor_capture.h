/* What comes in by an interface, before any rule can drop it; nothing on
 * systems other than Linux. */
#ifndef LUMCTL_DOCTOR_CAPTURE_H
#define LUMCTL_DOCTOR_CAPTURE_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

/* Opens a capture of what the sensor sends to a UDP port of this host. Returns
 * a descriptor for capture_end(); -1: this is not allowed, or there is no such
 * interface. */
int capture_open(const char *interface, lum_endpoint sensor, uint16_t to_port);

/* Whether something came, without a wait. */
bool capture_saw(int fd);

/* Number of packets since it was opened; closes it. -1 is allowed. */
uint64_t capture_end(int fd);

#endif
