/* What the system says about an interface's link, in addition to its
 * addresses. */
#ifndef LUM_TOOLS_INTERFACE_LINK_H
#define LUM_TOOLS_INTERFACE_LINK_H

#include "interfaces.h"

#include <ifaddrs.h>

/* Sets mac, has_mac and is_ethernet if the entry has them. */
void interface_link(const struct ifaddrs *entry, struct host_interface *out);

#endif
