/* No route is known on systems other than Linux. */
#include "host_route.h"

struct host_route host_route_find(uint32_t address, const char *interface)
{
    (void)address;
    (void)interface;
    return (struct host_route){.is_known = false};
}

bool host_route_neighbour(uint32_t address, const char *interface,
                          char mac[INTERFACE_MAC_TEXT_BYTES])
{
    (void)address;
    (void)interface;
    (void)mac;
    return false;
}
