/* Who answers ARP for an address on an interface of this Linux host. */
#ifndef LUMCTL_DOCTOR_NEIGHBOUR_H
#define LUMCTL_DOCTOR_NEIGHBOUR_H

#include "../../common/arp_answers.h"
#include "doctor.h"
#include "doctor_facts.h"
#include "doctor_knock.h"

#include <stdbool.h>
#include <stdint.h>

/* Hears them on the wire. Takes up to a second and a half where nobody answers.
 * False: this program may not, or the interface has no ARP. */
bool neighbours_hear(struct doctor *d, const struct host_interface *on,
                     uint32_t address, struct arp_answers *out);

/* As above, or, where that may not be, sends a packet to the sensor there and
 * looks at the kernel's table. */
void neighbours_find(struct doctor *d, const struct host_interface *on,
                     struct arp_answers *out);

/* The interface, of all that are up, on which somebody answers for the sensor's
 * address, whatever addresses it has; heard on all at once, for at most a
 * second and a half. but: the name of one that is left out, or NULL. NULL:
 * nobody does, or this program may not hear it. */
const struct host_interface *neighbours_search(struct doctor *d,
                                               const char *but);

/* Sends the sensor a packet by an interface (NULL: as the routes say), and
 * looks until an answer comes, or the kernel's table has the MAC of hop on an
 * interface, for at most a second and a half. */
enum knock_answer neighbours_probe(struct doctor *d, const char *by,
                                   uint32_t hop, const char *on,
                                   char mac[MAC_BYTES], enum arp_state *state);

/* "9a:62:cd:08:a4:01 and 9a:62:cd:08:a4:02"; returns out. */
#define NEIGHBOURS_TEXT_BYTES 128u
const char *neighbours_format(const struct arp_answers *all,
                              char out[NEIGHBOURS_TEXT_BYTES]);

#endif
