/* UDP sockets. */
#ifndef WORLD_UDP_H
#define WORLD_UDP_H

#include "net_internal.h"

#include <netinet/in.h>

struct world_udp {
    struct world_udp *next_of_port;
    struct world_udp *before, *after; /* all of them */
    world_file *file;
    world_host *host;
    world_socket_log *log;

    uint32_t address; /* that it receives at; 0: any */
    uint32_t source;  /* that it sends from; 0: by the way */
    uint16_t port;    /* 0: not bound */
    bool has_taken_address;
    bool is_connected;
    uint32_t peer;
    uint16_t peer_port;

    /* Options. */
    const world_interface *device;  /* SO_BINDTODEVICE */
    const world_interface *send_by; /* IP_UNICAST_IF */
    bool reuses_address, reuses_port, may_broadcast, tells_packet, tells_time,
        tells_time_us, tells_drops, tells_errors, is_free;
    uint32_t receive_room, send_room;
    int64_t receive_wait_ns, send_wait_ns; /* 0: without end */

    int error; /* told by the next call */
    uint32_t held, drops;
    world_datagram *first, *last; /* to be read */

    /* The last way. */
    bool has_way;
    uint64_t generation;
    uint32_t way_to;
    const world_interface *way_by;
    world_way way;
};

struct world_udp *world_udp_of(const world_file *file);

int world_udp_setsockopt(world_file *file, int level, int name,
                         const void *value, socklen_t size);
int world_udp_getsockopt(world_file *file, int level, int name, void *value,
                         socklen_t *size);
ssize_t world_udp_sendmsg(world_file *file, const struct msghdr *message,
                          int flags);
ssize_t world_udp_recvmsg(world_file *file, struct msghdr *message, int flags);

/* Whether there is something to read. */
bool world_udp_has_data(const struct world_udp *udp);
bool world_udp_can_send(const struct world_udp *udp);
/* 0, or -1 and errno. */
int world_udp_bind_any(struct world_udp *udp);
int world_udp_find_way(struct world_udp *udp, uint32_t to, world_way *out);
/* The pending error, which is then told; 0: none. */
int world_udp_take_error(struct world_udp *udp);
/* Those in front that are corrupt are gone. */
void world_udp_drop_bad(struct world_udp *udp);
/* A chain of the first to the last that sockets of a port have. */
struct world_udp *world_udp_at_port(const world_host *host, uint16_t port);

#endif
