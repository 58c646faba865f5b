/* A sensor's points by lwIP's raw API (lidar.c).
 *
 * lwIP runs in one context: its tcpip thread, or the main loop where there is
 * no system (NO_SYS 1). All of this runs there too, and needs no lock. The
 * interrupt of the MAC does not call it: its driver hands lwIP the frame by
 * netif->input, which is tcpip_input() with a system, and is called by the main
 * loop without one.
 *
 * The sensor sends to the address and the port that its heartbeats come from:
 * send them with udp_sendto(lidar->pcb, ...), as examples/firmware/heart.h
 * says. udp_remove(lidar->pcb) ends it. */
#ifndef LIDAR_H
#define LIDAR_H

#include "lum/packet.h"
#include "lum/points_fixed.h"
#include "lum/receiver.h"

#include <lwip/err.h>

#define LIDAR_BYTES 1472u /* of a datagram that fits a frame of Ethernet */

struct lidar {
    /* To be set before lidar_begin(), by lumtable or by the core's functions;
     * all else is 0 then. */
    const lum_layout *layout;
    const lum_fixed_projector *projector;
    void (*use)(const lum_fixed_point *points, size_t count);

    /* To be read, in lwIP's context. */
    uint32_t kinds[LUM_PACKET_KINDS]; /* datagrams, by what they were */
    uint32_t too_long;                /* datagrams dropped unread */
    uint32_t refused; /* data packets: receiver.counters says why */
    lum_point_losses losses;
    lum_receiver receiver;

    struct udp_pcb *pcb; /* to send by */

    /* Private. */
    uint32_t words[LUM_RECEIVER_WORDS(LIDAR_BYTES)];
    uint8_t bytes[LIDAR_BYTES];
};

/* Call it in lwIP's context: by tcpip_callback(), or between
 * LOCK_TCPIP_CORE() and UNLOCK_TCPIP_CORE(). */
err_t lidar_begin(struct lidar *lidar, uint16_t port);

#endif
