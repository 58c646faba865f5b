/** @file
 * The packets in messages of lumsdk_ros/Packets, as the node for ROS 1
 * publishes them (docs/ros.md): each batch is two messages, one of each eye,
 * and its packets have numbers. Internal to the capture room. */
#ifndef LUM_CAPTURE_BAG_PACKETS_H
#define LUM_CAPTURE_BAG_PACKETS_H

#include "lum/capture/record.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>

/** Most bytes of a message. */
#define LUM_BAG_MESSAGE_MAX ((uint32_t)8 << 20)

/** Batches that wait for the other eye, and packets that wait to be taken. */
typedef struct lum_bag_packets lum_bag_packets;

/** @return NULL without memory. */
LUM_MUST_CHECK lum_bag_packets *lum_bag_packets_new(void);

/** Free it. NULL is allowed. */
void lum_bag_packets_free(lum_bag_packets *packets);

/** Add a message, when lum_bag_packets_next() has no packet any more. Its
 * packets wait until the other eye has reached their numbers, because a busy
 * recorder writes several batches of one eye before those of the other. They
 * wait no longer if 64 batches of their eye or 32 MiB of their sensor wait, or
 * if a fifth sensor needs the place; then packets may come out of order.
 * @param message its bytes in the serialisation of ROS 1; copied.
 * @return 1; 0 if it contradicts itself, or is too long; -1 without memory. */
LUM_MUST_CHECK int lum_bag_packets_add(lum_bag_packets *packets,
                                       const uint8_t *message, size_t len);

/** No message follows: what waits for the other eye waits no longer. */
void lum_bag_packets_end(lum_bag_packets *packets);

/** Take the next packet, by its number.
 * @param out its payload lives until the next call; it was sent to nobody.
 * @return whether there is one. */
LUM_MUST_CHECK bool lum_bag_packets_next(lum_bag_packets *packets,
                                         lum_record *out);

#endif
