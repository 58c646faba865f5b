/* Whether a new address would strand a sensor. */
#ifndef LUMCTL_STRAND_H
#define LUMCTL_STRAND_H

#include "ctl.h"

/* EXIT_DONE if this host will reach the sensor there by the present interface,
 * as far as the system can say. Otherwise EXIT_BAD, and a message that names
 * --force: an address of this host or its loopback, a subnet's own or its
 * broadcast, or one without a route by that interface. A sensor that is this
 * host's own program may have its addresses and the loopback's. In a dry run
 * the missing route is only a note. */
enum exit_status strand_check(const struct ctl *ctl, uint32_t address);

#endif
