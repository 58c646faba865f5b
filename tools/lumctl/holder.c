#include "holder.h"

#include "../common/arp.h"
#include "reach.h"
#include "session.h"

#include "lum/base/time.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MS_NS    INT64_C(1000000)
#define WAIT_NS  (800 * MS_NS)
#define AGAIN_NS (100 * MS_NS) /* between questions: each could be lost */
#define MORE_NS  (300 * MS_NS) /* after the first answer */

static void add(struct holders *all, const char *mac)
{
    for (size_t i = 0; i < all->count; i++) {
        if (strcmp(all->macs[i], mac) == 0) {
            return;
        }
    }
    if (all->count < HOLDERS_MAX) {
        (void)snprintf(all->macs[all->count], sizeof all->macs[0], "%s", mac);
        all->count++;
    }
}

/* The interface by which an address is reached without a gateway, or NULL. */
static const struct host_interface *link_to(const struct ctl *ctl,
                                            const struct host_interface *all,
                                            size_t count, uint32_t address)
{
    const char *only = ctl->options.interface;
    struct reach reach;
    reach_find(address, &reach);
    const bool is_direct = reach.exists && !reach.has_gateway;
    const char *name = only != NULL ? only : reach.interface;
    const struct host_interface *found =
        reach.is_known ? interfaces_find(all, count, name) : NULL;
    if (found == NULL || found->is_loopback || !found->has_mac) {
        return NULL;
    }
    return (is_direct && strcmp(reach.interface, name) == 0) ||
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

static int64_t earlier(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static void hear(struct ctl *ctl, struct arp *arp, uint32_t address,
                 struct holders *out)
{
    int64_t now = lum_time_monotonic_ns();
    int64_t end = now + WAIT_NS;
    int64_t next = now;
    while (now < end && !lum_cancel_is_raised(ctl->cancel)) {
        struct arp_speaker who;
        session_keep_alive(ctl);
        if (now >= next) {
            (void)arp_ask(arp, address, NULL);
            next = now + AGAIN_NS;
        }
        if (arp_receive(arp, earlier(next, end), &who) &&
            who.address == address) {
            char mac[INTERFACE_MAC_TEXT_BYTES];
            end = out->count == 0 ? lum_time_monotonic_ns() + MORE_NS : end;
            add(out, interfaces_format_mac(who.mac, mac));
        }
        now = lum_time_monotonic_ns();
    }
}

void holders_find(struct ctl *ctl, uint32_t address, struct holders *out)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    struct arp *arp = NULL;
    char mac[INTERFACE_MAC_TEXT_BYTES];
    *out = (struct holders){false, 0, {""}};
    if (interfaces_list(&all, &count, NULL) != 0) {
        return;
    }
    const struct host_interface *on = link_to(ctl, all, count, address);
    if (on != NULL && arp_open(on, &arp, NULL) == ARP_OPENED) {
        out->is_heard = true;
        hear(ctl, arp, address, out);
        arp_close(arp);
    } else if (on != NULL && reach_neighbour(address, on->name, mac)) {
        add(out, mac);
    }
    free(all);
}

const char *holders_other(const struct holders *all,
                          const struct holders *others)
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
