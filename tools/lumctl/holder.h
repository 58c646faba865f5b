/* Which devices of the sensor's network have an address. */
#ifndef LUMCTL_HOLDER_H
#define LUMCTL_HOLDER_H

#include "../common/arp_answers.h"
#include "ctl.h"

#include <stdbool.h>
#include <stdint.h>

/* Whether the devices of an address can be searched: it is reached directly, by
 * an interface with ARP, and the system says so. */
bool holders_can(const struct ctl *ctl, uint32_t address);

/* Asks by ARP, for at most a second. If this program may not, the kernel's
 * table is read; then a packet must have been sent to the address before. The
 * heartbeats of a shell continue. */
void holders_find(struct ctl *ctl, uint32_t address, struct arp_answers *out);

/* The hardware address of one that is not among others, or NULL. */
const char *holders_other(const struct arp_answers *all,
                          const struct arp_answers *others);

#endif
