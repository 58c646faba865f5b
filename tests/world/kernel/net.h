/* The network of the world: segments (ethernets) with the interfaces of hosts
 * at their cables, and every datagram that a host sends.
 *
 * Each datagram has a number and comes to exactly one end (world_fate). A cable
 * has two directions, with faults of their own. Where nothing is set, a
 * datagram takes 20 us from one interface to another and none is lost.
 *
 * Addresses are numbers of the host: 10.42.0.1 is 0x0a2a0001.
 *
 * What Linux does and this does not: TCP, IPv6, multicast, routers that
 * forward, firewalls, raw sockets (EPERM), packets of programs that are not
 * ARP, bytes through local sockets, fragments that come one by one (they are
 * lost one by one, and with one all), gratuitous ARP, the limits of how often a
 * closed port answers. Of a cable's faults, ARP and the answers of closed ports
 * meet is_cut, lose and delay_ns. */
#ifndef WORLD_NET_H
#define WORLD_NET_H

#include "host.h"
#include "random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct world_datagram;
typedef struct world_interface world_interface;
typedef struct world_segment world_segment;

#define WORLD_ADDRESS(a, b, c, d)                                              \
    ((uint32_t)(a) << 24 | (uint32_t)(b) << 16 | (uint32_t)(c) << 8 |          \
     (uint32_t)(d))

/* --- Ends of datagrams --- */

typedef enum world_fate {
    WORLD_UNDER_WAY,
    WORLD_RECEIVED,
    WORLD_LOST_LINK,      /* a cable's fault: lose, lose_next, loses */
    WORLD_LOST_CUT,       /* is_cut, no carrier, interface down, islands */
    WORLD_LOST_QUEUE,     /* beyond the room before a cable's bandwidth */
    WORLD_LOST_NO_ANSWER, /* nobody answered ARP for three seconds */
    WORLD_LOST_FOREIGN,   /* the host that got it does not have the address */
    WORLD_LOST_NO_SOCKET, /* no socket takes it: port unreachable */
    WORLD_LOST_CHECKSUM,  /* corrupt, and dropped by its UDP checksum */
    WORLD_LOST_BUFFER,    /* the socket's receive buffer is full */
    WORLD_LOST_UNREAD,    /* the socket was closed before it was read */
    WORLD_FATES
} world_fate;

const char *world_fate_name(world_fate fate);

/* What is kept of each UDP socket, also after it was closed. Each datagram is
 * counted once in sent[] of who sent it, and once in got[] of the socket that
 * it came to, if it came to one. */
typedef struct world_socket_log {
    struct world_socket_log *next; /* in the order of their making */
    uint64_t number;               /* of its world_file, after the making */
    const world_host *host;
    long pid;         /* of who made it; 0: a task of no process */
    uint32_t address; /* bound to, last; 0: any */
    uint16_t port;
    uint64_t sent_total;
    uint64_t sent[WORLD_FATES]; /* [WORLD_UNDER_WAY]: now under way */
    uint64_t got[WORLD_FATES];  /* received, checksum, buffer, unread */
    struct world_udp *socket;   /* NULL: closed */
    uint32_t queued;            /* bytes that wait for their interface */
} world_socket_log;

const world_socket_log *world_net_sockets(void);

/* Sums over all sockets, those that were closed too. */
uint64_t world_net_count(world_fate fate);
uint64_t world_net_sent(void);

/* A broadcast is a datagram for each interface that it goes to, and a further
 * one for each further socket of a host; a repeated one is a further one. The
 * copy has a number of its own, and `first` says of which. */
typedef struct world_datagram {
    uint64_t number;
    uint64_t first; /* its own number, or that of the one it is a copy of */
    world_fate fate;
    bool is_altered; /* corrupt, and its checksum does not tell */
    bool is_bad;     /* corrupt, and its checksum tells */
    uint32_t from, to;
    uint16_t from_port, to_port;
    world_socket_log *sender;
    world_socket_log *receiver; /* NULL: came to no socket */
    long receiver_pid;          /* who read it; 0 before */
    world_interface *out_at;    /* which it left by */
    world_interface *in_at;     /* which it goes to, or came in at; or NULL */
    int64_t sent_ns, ended_ns;  /* true time */
    size_t len;
    uint8_t *bytes; /* as they are now */
    struct world_datagram_private {
        struct world_datagram *next, *next_made;
        unsigned size_class;
        uint32_t truesize; /* what Linux counts for it */
        uint32_t drops;    /* of the receiver, when it came */
        int64_t utc_ns;    /* of the receiving host, when it came */
        bool is_broadcast, is_queued, is_held; /* is_held: to be overtaken */
    } private;
} world_datagram;

/* Called for each datagram twice: when it was sent (fate under way) and when it
 * has come to its end. It must not send or wait. At most eight; they are gone
 * with the world. */
void world_net_watch(void (*tell)(void *context,
                                  const world_datagram *datagram),
                     void *context);

/* For the trace: says in a few words what a datagram is; false: it is not
 * traced. NULL: its size is told. Stays from one world to the next. */
extern bool (*world_net_describe)(const world_datagram *datagram, char *out,
                                  size_t room);

/* Fails the run if a datagram was counted twice or got lost uncounted. */
void world_net_check(void);

/* --- Cables --- */

/* Of one direction of a cable. Probabilities are 0 to 1, of each datagram. All
 * zero: no fault. May be changed at any time. */
typedef struct world_link {
    int64_t delay_ns;  /* 10 us at first */
    int64_t jitter_ns; /* 0 to this more; the order stays */
    double lose;
    double repeat;      /* comes twice */
    double reorder;     /* is held back, so that later ones overtake it */
    int64_t reorder_ns; /* for 0 to this long; 0: 1 ms */
    double late;        /* the same once more, for another length */
    int64_t late_ns;
    double corrupt;      /* some bits are flipped */
    double pass;         /* of the corrupt: the checksum does not tell */
    uint64_t lose_next;  /* so many of the next, all of them */
    uint64_t bits_per_s; /* 0: no limit. Beyond 1000 waiting: lost */
    bool is_cut;         /* nothing goes this way */
    /* Loses those for which this is true; NULL: none. */
    bool (*loses)(void *context, const world_datagram *datagram);
    void *context;

    struct world_link_private {
        int64_t free_ns;        /* when the bandwidth is free again */
        int64_t last_ns;        /* arrival of the last: the order stays */
        uint64_t waiting;       /* before the bandwidth */
        world_random random[8]; /* each fault's own, see link.c */
    } private;
} world_link;

#define WORLD_ADDRESSES 64

typedef struct world_address {
    uint32_t address;
    unsigned prefix;
    unsigned
        bound; /* lasts while so many sockets are bound to it; 0: for good */
} world_address;

struct world_interface {
    world_interface *next; /* of the host */
    world_interface *next_of_segment;
    char name[16];
    unsigned index;
    uint8_t mac[6];
    unsigned mtu;
    world_host *host;
    world_segment *segment; /* NULL: the loopback */
    /* Change these by the functions below. */
    bool is_up, has_carrier;
    unsigned roams; /* prefix of addresses that come by bind(); 0: none */
    world_address addresses[WORLD_ADDRESSES];
    size_t address_count;
    /* Change these as you like. */
    world_link out, in; /* as the host sees it */
    unsigned island;    /* interfaces of another number are not heard */

    struct world_neighbours *neighbours;
    world_random arp_random;
    uint64_t stream; /* of random numbers */
};

/* --- Building and changing --- */

world_segment *world_segment_new(const char *name);

/* Up, with carrier, MTU 1500. A host has "lo" with 127.0.0.1 from the start. */
world_interface *world_interface_new(world_host *host, world_segment *segment,
                                     const char *name);
/* NULL: the host has none of that name. */
world_interface *world_interface_find(const world_host *host, const char *name);
world_interface *world_interface_first(const world_host *host);

void world_interface_add(world_interface *interface, uint32_t address,
                         unsigned prefix);
/* Sockets that are bound to it stay, and cannot send. */
void world_interface_remove(world_interface *interface, uint32_t address);
/* As `ip link set up` and `down`: routes by gateways are gone with a down. */
void world_interface_set_up(world_interface *interface, bool is_up);
void world_interface_set_carrier(world_interface *interface, bool has_carrier);
/* The host may bind any address, which it then has at this interface, with this
 * prefix, as long as a socket is bound to it: as a sensor, whose address is its
 * program's. */
void world_interface_roam(world_interface *interface, unsigned prefix);

/* A route beside those that addresses give. gateway 0: on the link. */
void world_route_add(world_interface *interface, uint32_t network,
                     unsigned prefix, uint32_t gateway);
void world_route_remove(world_interface *interface, uint32_t network,
                        unsigned prefix);

/* Both directions of every cable: no fault any more, delays as at first. */
void world_net_heal(void);

/* What programs of a host may. */
typedef struct world_net_rights {
    bool is_root;         /* ports below 1024, SO_RCVBUFFORCE, AF_PACKET */
    bool may_bind_device; /* SO_BINDTODEVICE: true since Linux 5.7 */
    uint32_t receive_max; /* net.core.rmem_max, 212992 at first */
    uint32_t send_max;    /* net.core.wmem_max, 212992 at first */
} world_net_rights;

world_net_rights *world_net_rights_of(const world_host *host);

/* Names that getaddrinfo() knows, beside those of the world's hosts and
 * localhost. address 0: known, but without an IPv4 address. */
void world_net_name(const char *name, uint32_t address);
/* The name server is slow; fails: EAI_AGAIN after that. */
void world_net_name_server(int64_t delay_ns, bool fails);

/* --- For the other parts of the world --- */

/* The text of a file of /proc/net or /proc/sys/net, for free(); NULL: there is
 * none. Processes find them on the host's disk. */
char *world_net_text(world_host *host, const char *path);

/* Everything is gone. Called after the files, and before the hosts. */
void world_net_reset(void);

#endif
