#define _DEFAULT_SOURCE /* getifaddrs */

#include "interface_link.h"

#include <net/if_arp.h>
#include <netpacket/packet.h>
#include <string.h>
#include <sys/socket.h>

/* By the names that every distribution gives. */
static bool is_wireless(const char *name)
{
    return strncmp(name, "wl", 2) == 0;
}

void interface_link(const struct ifaddrs *entry, struct host_interface *out)
{
    struct sockaddr_ll link;
    if (entry->ifa_addr == NULL || entry->ifa_addr->sa_family != AF_PACKET) {
        return;
    }
    memcpy(&link, entry->ifa_addr, sizeof link);
    if (link.sll_hatype == ARPHRD_ETHER &&
        link.sll_halen == INTERFACE_MAC_BYTES) {
        out->is_ethernet = !is_wireless(out->name);
        out->has_mac = true;
        memcpy(out->mac, link.sll_addr, sizeof out->mac);
    }
}
