/* What set-ip checks before it sends: whether a new address would strand the
 * sensor, and which devices of its network have an address. */
#ifndef LUMCTL_SET_IP_CHECK_H
#define LUMCTL_SET_IP_CHECK_H

#include "../common/arp_answers.h"
#include "ctl.h"

/* EXIT_DONE if this host will reach the sensor there by the present interface,
 * as far as the system can say. Otherwise EXIT_BAD, and a message that names
 * --force: an address of this host or its loopback, a subnet's own or its
 * broadcast, or one without a route by that interface. A sensor that is this
 * host's own program may have its addresses and the loopback's. In a dry run
 * the missing route is only a note. */
enum exit_status set_ip_check_reach(const struct ctl *ctl, uint32_t address);

/* Whether the devices of an address can be searched: it is reached directly, by
 * an interface with ARP, and the system says so. */
bool set_ip_can_search(const struct ctl *ctl, uint32_t address);

/* Asks by ARP, for at most a second. If this program may not, the kernel's
 * table is read; then a packet must have been sent to the address before. The
 * heartbeats of a shell continue. */
void set_ip_search(struct ctl *ctl, uint32_t address, struct arp_answers *out);

/* The hardware address of one that is not among others, or NULL. */
const char *set_ip_other(const struct arp_answers *all,
                         const struct arp_answers *others);

#endif
