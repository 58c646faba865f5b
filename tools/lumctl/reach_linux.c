#include "reach.h"

#include "doctor_way.h"

#include <stdio.h>

void reach_find(uint32_t address, struct reach *out)
{
    struct way way;
    *out = (struct reach){.is_known = way_find(address, NULL, &way)};
    if (out->is_known) {
        out->exists = way.exists;
        out->has_gateway = way.has_gateway;
        (void)snprintf(out->interface, sizeof out->interface, "%s",
                       way.interface);
    }
}
