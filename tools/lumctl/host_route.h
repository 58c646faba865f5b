/* The route of this host's kernel to an address. */
#ifndef LUMCTL_HOST_ROUTE_H
#define LUMCTL_HOST_ROUTE_H

#include "../common/interfaces.h"

struct host_route {
    bool is_known; /* otherwise the system cannot say, and nothing follows */
    bool exists;
    int error; /* an errno, when it does not */
    bool is_local;
    bool is_default;                      /* the default route */
    char interface[INTERFACE_NAME_BYTES]; /* this host's own: the loopback */
    bool has_gateway;
    uint32_t gateway;
    uint32_t source; /* this host's address on it; 0: not known */
};

/* Asks the kernel. interface: only there; NULL: anywhere. */
struct host_route host_route_find(uint32_t address, const char *interface);

/* The MTU of an interface; 0: not known. */
unsigned host_route_mtu(const char *interface);

/* The hardware address that this host's table has for an address on an
 * interface; false: none, or the system cannot say. */
bool host_route_neighbour(uint32_t address, const char *interface,
                          char mac[INTERFACE_MAC_TEXT_BYTES]);

#endif
