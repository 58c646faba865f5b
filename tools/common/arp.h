/* ARP requests, sent and received on the wire: who has an address, independent
 * of the kernel's table. Needs the right to raw sockets: root, or CAP_NET_RAW.
 * One struct arp belongs to one thread. */
#ifndef LUM_TOOLS_ARP_H
#define LUM_TOOLS_ARP_H

#include "interfaces.h"

#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

struct arp;

enum arp_opened {
    ARP_OPENED,
    ARP_NO_RIGHT, /* not root */
    ARP_NO_WAY    /* not on this system, or not on this interface */
};

/* The sender of an ARP packet: of an answer, or of its own request. */
struct arp_speaker {
    uint32_t address; /* host order, never 0 */
    uint8_t mac[INTERFACE_MAC_BYTES];
    bool is_answer;
};

/* Opens one interface, which has to have a MAC. out: arp_close() it; written
 * only on ARP_OPENED, otherwise error is set. */
enum arp_opened arp_open(const struct host_interface *interface,
                         struct arp **out, lum_error *error);

/* Asks at once who has an address, from the interface's own address in a subnet
 * that contains it; if there is none, from 0.0.0.0 as a probe, which changes
 * nobody's table. Returns 0; -1 with error set. */
int arp_ask(struct arp *arp, uint32_t address, lum_error *error);

/* The next one who spoke; waits for it until a time of lum_time_monotonic_ns(),
 * one in the past: not at all. What leaves by this interface is passed over.
 * False: nobody did, a signal came, or far too much else came. */
bool arp_receive(struct arp *arp, int64_t deadline_ns, struct arp_speaker *out);

/* Readable when arp_receive() may have something, for poll(). */
int arp_descriptor(const struct arp *arp);

/* NULL is allowed. */
void arp_close(struct arp *arp);

#endif
