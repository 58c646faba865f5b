/* Information from Linux in its files, read line by line. */
#ifndef LUMCTL_DOCTOR_FACTS_H
#define LUMCTL_DOCTOR_FACTS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum arp_state {
    ARP_UNKNOWN,    /* no request was sent */
    ARP_INCOMPLETE, /* a request was sent, no answer came */
    ARP_COMPLETE
};

#define MAC_BYTES 18u

/* /proc/net/arp: an address, in host order, on a device; mac is written when
 * complete. */
enum arp_state facts_arp(FILE *in, uint32_t address, const char *device,
                         char mac[MAC_BYTES]);

struct udp_user {
    uint32_t address; /* bound to, host order; 0: any */
    uint16_t port;
    uint32_t uid;
    uint64_t inode;
};

/* /proc/net/udp or udp6: sockets bound to a port, 0: to any port. IPv6 sockets
 * that cannot take IPv4 are left out. Returns how many, at most room. */
size_t facts_udp(FILE *in, uint16_t port, struct udp_user *out, size_t room);

#endif
