/* What comes in by an interface of a Linux host, before any rule can drop it.
 */
#ifndef LUMCTL_DOCTOR_CAPTURE_H
#define LUMCTL_DOCTOR_CAPTURE_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

/* Opens a capture of what the sensor sends to a UDP port of this host. Returns
 * a descriptor to close(); -1: this is not allowed, or there is no such
 * interface. */
int capture_open(const char *interface, lum_endpoint sensor, uint16_t to_port);

/* Whether something came; waits for this time at most. */
bool capture_saw(int fd, int wait_ms);

/* Number of packets since it was opened, or since the last count. */
uint64_t capture_count(int fd);

#endif
