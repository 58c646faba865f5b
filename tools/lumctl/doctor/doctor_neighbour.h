/* Which devices answer ARP for an address on an interface of this Linux
 * host. */
#ifndef LUMCTL_DOCTOR_NEIGHBOUR_H
#define LUMCTL_DOCTOR_NEIGHBOUR_H

#include "../../common/arp_answers.h"
#include "doctor.h"
#include "doctor_facts.h"
#include "doctor_knock.h"

#include <stdbool.h>
#include <stdint.h>

/* Hears them on the network. Takes up to a second and a half if no device
 * answers. False: this is not allowed, or the interface has no ARP. */
bool neighbours_hear(struct doctor *d, const struct host_interface *on,
                     uint32_t address, struct arp_answers *out);

/* Hears who else has an address of this host, within half a second. Not at
 * all, where this host answers itself on another of its interfaces. */
void neighbours_rivals(struct doctor *d, const struct host_interface *on,
                       uint32_t own, struct arp_answers *out);

/* The kernel's table; mac is written when it is ARP_COMPLETE. */
enum arp_state neighbours_look_up(uint32_t address, const char *interface,
                                  char mac[MAC_BYTES]);

/* As neighbours_hear(). If that is not allowed, sends a packet to the sensor
 * there and looks at the kernel's table. */
void neighbours_find(struct doctor *d, const struct host_interface *on,
                     struct arp_answers *out);

/* Of all interfaces that are up, the one on which a device answers for the
 * sensor's address, whatever addresses the interface has. Listens on all at
 * once, for at most a second and a half. but: the name of one that is left out,
 * or NULL. Returns NULL if no device answers, or listening is not allowed. */
const struct host_interface *neighbours_search(struct doctor *d,
                                               const char *but);

/* Sends a packet to the sensor by an interface (NULL: as the routes say). Then
 * waits, for at most a second and a half, until an answer comes or the kernel's
 * table has the MAC of hop on an interface. */
enum knock_answer neighbours_probe(struct doctor *d, const char *by,
                                   uint32_t hop, const char *on,
                                   char mac[MAC_BYTES], enum arp_state *state);

/* "9a:62:cd:08:a4:01 and 9a:62:cd:08:a4:02" */
struct neighbours_text {
    char text[128];
};
struct neighbours_text neighbours_format(const struct arp_answers *all);

#endif
