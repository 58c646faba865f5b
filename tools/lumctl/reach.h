/* The way that this host's routes take to an address. */
#ifndef LUMCTL_REACH_H
#define LUMCTL_REACH_H

#include "../common/interfaces.h"

struct reach {
    bool is_known; /* otherwise the system cannot say, and nothing follows */
    bool exists;
    bool has_gateway;
    char interface[INTERFACE_NAME_BYTES]; /* this host's own: the loopback */
};

void reach_find(uint32_t address, struct reach *out);

/* The hardware address that this host's table has for an address on an
 * interface; false: none, or the system cannot say. */
bool reach_neighbour(uint32_t address, const char *interface,
                     char mac[INTERFACE_MAC_TEXT_BYTES]);

#endif
