/* A small capture for a sensor that replays it: rays are not traced again for
 * each session. */
#ifndef WORLD_CAPTURE_H
#define WORLD_CAPTURE_H

#include <stddef.h>
#include <stdint.h>

/* A pcap file of eight seconds: two lines of each eye a second, with ranges. It
 * belongs to the callee. */
const uint8_t *capture_small(size_t *size);

#endif
