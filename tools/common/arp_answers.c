#include "arp_answers.h"

#include "arp.h"

#include "lum/base/time.h"

#include <stdio.h>
#include <string.h>

void arp_answers_add(struct arp_answers *all, const char *mac)
{
    for (size_t i = 0; i < all->count; i++) {
        if (strcmp(all->macs[i], mac) == 0) {
            return;
        }
    }
    if (all->count < ARP_ANSWERS_MAX) {
        (void)snprintf(all->macs[all->count], sizeof all->macs[0], "%s", mac);
        all->count++;
    }
}

static void hear(struct arp *arp, uint32_t address,
                 const struct arp_patience *patience, struct arp_answers *out)
{
    int64_t now = lum_time_monotonic_ns();
    int64_t end = now + patience->wait_ns;
    int64_t next = now;
    while (now < end && patience->goes_on(patience->owner)) {
        struct arp_speaker who;
        if (now >= next) {
            (void)arp_ask(arp, address, NULL);
            next = now + patience->again_ns;
        }
        if (arp_receive(arp, next < end ? next : end, &who) &&
            who.address == address) {
            char mac[INTERFACE_MAC_TEXT_BYTES];
            if (out->count == 0) {
                end = lum_time_monotonic_ns() + patience->more_ns;
            }
            arp_answers_add(out, interfaces_format_mac(who.mac, mac));
        }
        now = lum_time_monotonic_ns();
    }
}

bool arp_answers_hear(const struct host_interface *on, uint32_t address,
                      const struct arp_patience *patience,
                      struct arp_answers *out)
{
    struct arp *arp = NULL;
    *out = (struct arp_answers){0};
    if (arp_open(on, &arp, NULL) != ARP_OPENED) {
        return false;
    }
    out->is_heard = true;
    hear(arp, address, patience, out);
    arp_close(arp);
    return true;
}
