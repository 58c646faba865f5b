/* Questions and answers of ARP on a wire, and who listens to it. */
#ifndef WORLD_ARP_H
#define WORLD_ARP_H

#include "net_internal.h"

#define WORLD_ARP_BYTES 28u

/* From an interface to all others: who has this address? source 0: the host
 * has none yet. */
void world_arp_ask(world_interface *from, uint32_t source, uint32_t target);
/* A packet as a program has made it. */
void world_arp_send(world_interface *from, const uint8_t *packet);

/* In neighbour.c: an answer has come, or a question of somebody. */
void world_neighbour_answered(world_interface *at, uint32_t address,
                              world_interface *target);
void world_neighbour_learn(world_interface *at, uint32_t address,
                           world_interface *target);

/* In packet.c: sockets of AF_PACKET hear what comes. type: PACKET_HOST,
 * PACKET_BROADCAST. */
bool world_packet_listens(const world_host *host);
void world_packet_hear(world_interface *at, world_interface *from,
                       uint16_t protocol, uint8_t type, const uint8_t *bytes,
                       size_t len);
void world_packet_hear_datagram(world_interface *at,
                                const world_datagram *datagram);
world_file *world_packet_file(world_host *host, int flags, uint16_t protocol);

#endif
