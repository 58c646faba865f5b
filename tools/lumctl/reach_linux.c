#define _POSIX_C_SOURCE 200809L

#include "reach.h"

#include "doctor/doctor_facts.h"
#include "doctor/doctor_way.h"

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

bool reach_neighbour(uint32_t address, const char *interface,
                     char mac[INTERFACE_MAC_TEXT_BYTES])
{
    FILE *f = fopen("/proc/net/arp", "re");
    if (f == NULL) {
        return false;
    }
    const enum arp_state state = facts_arp(f, address, interface, mac);
    (void)fclose(f);
    return state == ARP_COMPLETE;
}
