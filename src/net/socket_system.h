/* Where systems differ: socket_linux.c, or socket_plain.c anywhere else. */
#ifndef LUM_NET_SOCKET_SYSTEM_H
#define LUM_NET_SOCKET_SYSTEM_H

#include "net/sockaddr.h"

#if !defined(_WIN32)
#include <poll.h>
#endif

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A descriptor (POSIX) or a socket (Windows) that is readable while a cancel is
 * raised, for a wait; never NULL. */
intptr_t lum_cancel_handle(const lum_cancel *cancel);

/* Of a datagram, beside itself. */
typedef struct lum_arrival {
    unsigned if_index; /* index of the interface of arrival; 0: not known */
    uint32_t drops;    /* by the kernel, when it came */
    bool has_drops;
    bool is_joined; /* it came in one message with others */
} lum_arrival;

/* Most datagrams that are taken apart of a message: Linux joins 64 that it
 * receives, and lets a local sender join 128. */
#define LUM_SYSTEM_JOINED_MAX (LUM_SOCKET_JOINED_BATCH / LUM_SOCKET_BATCH)

/* From one message's buffer to the next, where messages may hold joined
 * datagrams. Not a power of two: the beginnings of all buffers would share a
 * few lines of the cache, and most messages are short. */
#define LUM_SYSTEM_JOINED_BYTES (65536u + 2176u)

/* A UDP socket, non-blocking and closed on exec; LUM_SYSTEM_NONE and a
 * message. */
lum_system_handle lum_system_socket(lum_error *error);

/* Restrict to an interface that there is, before the bind. May change local;
 * *only gets the interface that arrivals must come from, 0 if the system
 * ensures this. */
lum_net_result lum_system_use_interface(lum_system_handle fd, const char *name,
                                        lum_endpoint *local, unsigned *only,
                                        lum_error *error);

/* Ask for the receive buffer. Returns the bytes granted, as the kernel counts;
 * *enough: they hold `bytes` of payload. */
size_t lum_system_grow(lum_system_handle fd, size_t bytes, bool *enough);

/* Switch on the reports of arrival times and drops. Returns whether drops are
 * reported. */
bool lum_system_tell(lum_system_handle fd);

/* Drops up to now; false if the system reports them only with arrivals, or not
 * at all. */
bool lum_system_drops(lum_system_handle fd, uint32_t *out);

/* poll() for some nanoseconds. */
int lum_system_poll(struct pollfd *set, size_t count, int64_t wait_ns);

/* Let the kernel join datagrams that it hands out. Whether it does. */
bool lum_system_take_joined(lum_system_handle fd);

/* Receive up to LUM_SOCKET_BATCH datagrams into buffers of LUM_SOCKET_BYTES
 * each; utc_ns stays 0 if it is not known. joined: as lum_system_take_joined()
 * said; then as many messages into buffers of LUM_SYSTEM_JOINED_BYTES, with up
 * to LUM_SYSTEM_JOINED_MAX datagrams in each. Returns how many datagrams, or
 * -1. */
int lum_system_receive(lum_system_handle fd, bool joined, uint8_t *buffers,
                       lum_received *out, lum_arrival *arrivals);

/* Whether the kernel takes several datagrams of one size as one, and cuts them
 * apart as late as it can. */
bool lum_system_joins(lum_system_handle fd);

/* Send some, at most LUM_SOCKET_BATCH. *joins: as lum_system_joins() said; it
 * becomes false if the way there has no such thing. How many left; -1 if not
 * even the first. */
int lum_system_send(lum_system_handle fd, bool *joins,
                    const lum_outgoing *datagrams, size_t count);

#endif
