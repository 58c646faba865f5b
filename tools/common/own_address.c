#include "own_address.h"

#include "interfaces.h"

#include "net/route.h"

#include <stdlib.h>

static uint32_t of_interface(const char *name)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    if (interfaces_list(&all, &count, NULL) != 0) {
        return 0;
    }
    const struct host_interface *found = interfaces_find(all, count, name);
    const uint32_t address = found != NULL && found->address_count > 0
                                 ? found->addresses[0].address
                                 : 0;
    free(all);
    return address;
}

uint32_t own_address(uint32_t to, const char *interface)
{
    return interface != NULL ? of_interface(interface) : lum_route_source(to);
}
