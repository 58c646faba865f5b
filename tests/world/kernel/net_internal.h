/* What the parts of the network share. */
#ifndef WORLD_NET_INTERNAL_H
#define WORLD_NET_INTERNAL_H

#include "file.h"
#include "net.h"
#include "task.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WORLD_LOOPBACK   WORLD_ADDRESS(127, 0, 0, 1)
#define WORLD_EVERYBODY  UINT32_MAX
#define WORLD_HEADERS    28u /* of IP and UDP */
#define WORLD_UDP_MAX    65507u
#define WORLD_PORT_LISTS 64u

struct world_segment {
    world_segment *next;
    char name[24];
    world_interface *interfaces;
};

typedef struct world_route {
    struct world_route *next;
    world_interface *interface;
    uint32_t network;
    unsigned prefix;
    uint32_t gateway; /* 0: on the link */
    uint32_t source;  /* of an address's own route; 0: chosen */
} world_route;

/* Of a host. */
typedef struct world_net_host {
    struct world_net_host *next;
    world_host *host;
    world_interface *interfaces, *last;
    unsigned interface_count;
    world_route *routes; /* in the order of their making */
    world_net_rights rights;
    world_random ports;
    struct world_udp *by_port[WORLD_PORT_LISTS];
    struct world_local *locals;
    struct world_packet *packets;
} world_net_host;

world_net_host *world_net_of(const world_host *host);
world_net_host *world_net_first(void);

/* Counts up with each change of addresses, routes and interfaces. */
uint64_t world_net_generation(void);

/* --- routes --- */

typedef enum world_way_kind {
    WORLD_WAY_LINK,
    WORLD_WAY_LOCAL,
    WORLD_WAY_BROADCAST
} world_way_kind;

typedef struct world_way {
    world_way_kind kind;
    world_interface *interface; /* of a local address: where it is */
    uint32_t next_hop;
    uint32_t source;
    const world_route *route; /* NULL: none, but the interface was said */
} world_way;

/* The way to an address, from one (0: any) by one interface (NULL: any). 0, or
 * an errno. */
int world_way_find(const world_host *host, uint32_t to, uint32_t from,
                   const world_interface *by, world_way *out);

/* Its interface; NULL: the host does not have the address. */
world_interface *world_net_owner(const world_host *host, uint32_t address);
bool world_net_is_broadcast(const world_host *host, uint32_t address);
uint32_t world_mask(unsigned prefix);
/* The interface's own address for a neighbour; 0: it has none. */
uint32_t world_interface_source(const world_interface *interface, uint32_t to);
const world_address *world_interface_address(const world_interface *interface,
                                             uint32_t address);
world_interface *world_interface_by_index(const world_host *host,
                                          unsigned index);
bool world_interface_is_loopback(const world_interface *interface);

/* An address that a bind brings and a close takes away. */
bool world_net_take_address(const world_host *host, const world_interface *by,
                            uint32_t address);
void world_net_leave_address(const world_host *host, uint32_t address);

/* --- datagrams --- */

/* With room for len bytes; it has no number yet. */
world_datagram *world_datagram_new(size_t len);
/* Its life begins. */
void world_datagram_send(world_datagram *datagram);
/* A further one, sent. */
world_datagram *world_datagram_copy(const world_datagram *of);
/* Its life ends; it is free for another. */
void world_datagram_end(world_datagram *datagram, world_fate fate);
/* One that never had a number. */
void world_datagram_free(world_datagram *datagram);
/* It waits for its interface, or no longer. */
void world_datagram_queue(world_datagram *datagram);
void world_datagram_leave(world_datagram *datagram);
uint32_t world_truesize(size_t len);

world_socket_log *world_socket_log_new(const world_host *host);

/* --- on the wire --- */

/* To one neighbour or to all, by datagram->out_at. 0, or ENOBUFS and the
 * datagram is still the caller's. */
int world_net_output(world_datagram *datagram, uint32_t next_hop);
void world_link_cross(world_datagram *datagram, world_interface *to);
void world_link_output(world_datagram *datagram, world_interface *to);
void world_link_begin(world_link *link, const char *owner,
                      const char *direction);
/* Whether a small packet gets there now, or there and back; its time goes to
 * *ns. */
bool world_link_passes(world_interface *from, world_interface *to, int64_t *ns);
bool world_link_answers(world_interface *from, world_interface *to,
                        int64_t *ns);

/* It has come to datagram->in_at. */
void world_net_arrive(world_datagram *datagram);
/* Sockets of a host take it. */
void world_udp_deliver(const world_host *host, world_datagram *datagram);
/* So do those of the host that sends a broadcast. */
void world_udp_hear_own(world_datagram *datagram);
/* The port of a datagram of this host is closed there. */
void world_udp_refuse(const world_datagram *datagram);
/* A part of its sender's queue is free. */
void world_udp_drained(struct world_udp *socket);
/* For those who ask for all errors (IP_RECVERR). */
void world_udp_unreachable(struct world_udp *socket);

/* --- neighbours --- */

void world_neighbours_flush(world_interface *interface);
void world_neighbours_free(world_interface *interface);
/* Calls for each that the table shows: mac NULL: not known. */
void world_neighbours_list(const world_interface *interface,
                           void (*tell)(void *context, uint32_t address,
                                        const uint8_t *mac),
                           void *context);

/* --- files --- */

/* /proc/net and /proc/sys/net, and of each interface there. */
void world_net_publish(world_host *host);
void world_net_publish_interface(const world_interface *interface);

world_file *world_udp_file(world_host *host, int flags);
world_file *world_local_file(world_host *host, int flags);
world_file *world_netlink_file(world_host *host, int flags);
/* As /proc/PID/fd shows it. */
void world_socket_path(const world_file *file, char *out, size_t room);
bool world_file_is_socket(const world_file *file);
/* The host of the process that runs; that of the last socket() otherwise. */
world_host *world_net_here(void);
/* ioctl() of any socket; ENOTTY. */
int world_socket_ioctl(const world_host *host, unsigned long request,
                       void *argument);
int world_peer_name(const world_file *file, struct sockaddr *out,
                    socklen_t *size);
void world_put_address(struct sockaddr *out, socklen_t *size,
                       const void *address, socklen_t len);

void world_datagrams_reset(void);
void world_udp_reset(void);
void world_names_reset(void);

#endif
