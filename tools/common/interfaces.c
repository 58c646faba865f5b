#include "interfaces.h"

#include <stdio.h>
#include <string.h>

const struct host_interface *interfaces_find(const struct host_interface *all,
                                             size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(all[i].name, name) == 0) {
            return &all[i];
        }
    }
    return NULL;
}

static const struct interface_address *find_address(
    const struct host_interface *in, uint32_t address)
{
    for (size_t i = 0; i < in->address_count; i++) {
        if (in->addresses[i].address == address) {
            return &in->addresses[i];
        }
    }
    return NULL;
}

const struct host_interface *interfaces_owner(
    const struct host_interface *all, size_t count, uint32_t address,
    const struct interface_address **at)
{
    for (size_t i = 0; i < count; i++) {
        const struct interface_address *found = find_address(&all[i], address);
        if (found != NULL) {
            if (at != NULL) {
                *at = found;
            }
            return &all[i];
        }
    }
    return NULL;
}

const struct interface_address *interfaces_subnet(
    const struct host_interface *interface, uint32_t address)
{
    const struct interface_address *best = NULL;
    for (size_t i = 0; i < interface->address_count; i++) {
        const struct interface_address *a = &interface->addresses[i];
        if (a->mask != 0 && ((a->address ^ address) & a->mask) == 0 &&
            (best == NULL || a->prefix > best->prefix)) {
            best = a;
        }
    }
    return best;
}

unsigned interfaces_mask_bits(uint32_t mask)
{
    unsigned n = 0;
    while (n < 32u && (mask >> (31u - n) & 1u) != 0) {
        n++;
    }
    return n;
}

const char *interfaces_format_mac(const uint8_t mac[INTERFACE_MAC_BYTES],
                                  char out[INTERFACE_MAC_TEXT_BYTES])
{
    (void)snprintf(out, INTERFACE_MAC_TEXT_BYTES,
                   "%02x:%02x:%02x:%02x:%02x:%02x", (unsigned)mac[0],
                   (unsigned)mac[1], (unsigned)mac[2], (unsigned)mac[3],
                   (unsigned)mac[4], (unsigned)mac[5]);
    return out;
}
