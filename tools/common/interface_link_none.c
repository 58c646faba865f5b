#include "interface_link.h"

void interface_link(const struct ifaddrs *entry, struct host_interface *out)
{
    (void)entry;
    out->is_ethernet = false;
    out->has_mac = false;
}
