#include "holder.h"

#include "host_route.h"
#include "session.h"

#include <stdlib.h>
#include <string.h>

#define MS_NS    INT64_C(1000000)
#define WAIT_NS  (800 * MS_NS)
#define AGAIN_NS (100 * MS_NS)
#define MORE_NS  (300 * MS_NS)

/* The interface by which an address is reached without a gateway, or NULL. */
static const struct host_interface *link_to(const struct ctl *ctl,
                                            const struct host_interface *all,
                                            size_t count, uint32_t address)
{
    const char *only = ctl->options.interface;
    const struct host_route route = host_route_find(address, NULL);
    const bool is_direct = route.exists && !route.has_gateway;
    const char *name = only != NULL ? only : route.interface;
    const struct host_interface *found =
        route.is_known ? interfaces_find(all, count, name) : NULL;
    if (found == NULL || found->is_loopback || !found->has_mac) {
        return NULL;
    }
    return (is_direct && strcmp(route.interface, name) == 0) ||
                   (only != NULL && interfaces_subnet(found, address) != NULL)
               ? found
               : NULL;
}

bool holders_can(const struct ctl *ctl, uint32_t address)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    if (interfaces_list(&all, &count, NULL) != 0) {
        return false;
    }
    const bool can = link_to(ctl, all, count, address) != NULL;
    free(all);
    return can;
}

void holders_find(struct ctl *ctl, uint32_t address, struct arp_answers *out)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    char mac[INTERFACE_MAC_TEXT_BYTES];
    const struct arp_patience patience = {WAIT_NS, AGAIN_NS, MORE_NS,
                                          session_goes_on, ctl};
    *out = (struct arp_answers){0};
    if (interfaces_list(&all, &count, NULL) != 0) {
        return;
    }
    const struct host_interface *on = link_to(ctl, all, count, address);
    if (on != NULL && !arp_answers_hear(on, address, &patience, out) &&
        host_route_neighbour(address, on->name, mac)) {
        arp_answers_add(out, mac);
    }
    free(all);
}

const char *holders_other(const struct arp_answers *all,
                          const struct arp_answers *others)
{
    for (size_t i = 0; i < all->count; i++) {
        bool is_among = false;
        for (size_t k = 0; k < others->count; k++) {
            is_among = is_among || strcmp(all->macs[i], others->macs[k]) == 0;
        }
        if (!is_among) {
            return all->macs[i];
        }
    }
    return NULL;
}
