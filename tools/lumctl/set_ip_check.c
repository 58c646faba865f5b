#include "set_ip_check.h"

#include "../common/interfaces.h"
#include "../common/number.h"
#include "ctl_session.h"
#include "host_route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MS_NS    INT64_C(1000000)
#define WAIT_NS  (800 * MS_NS)
#define AGAIN_NS (100 * MS_NS)
#define MORE_NS  (300 * MS_NS)

/* --- Whether the address would strand the sensor --- */

struct move_plan {
    const struct ctl *ctl;
    const struct host_interface *interfaces;
    size_t count;
    uint32_t old;
    uint32_t new;
    const char *interface; /* --interface; NULL: as the routes say */
};

static bool is_loopback(uint32_t address)
{
    return address >> 24 == 127u;
}

static const struct host_interface *owner_of(const struct move_plan *p,
                                             uint32_t address)
{
    return interfaces_owner(p->interfaces, p->count, address, NULL);
}

static enum exit_status refuse(uint32_t address, const char *why)
{
    return ctl_complain(
        EXIT_BAD, "set-ip: %s %s: nothing was sent. --force sends it anyway",
        number_address(address).text, why);
}

static enum exit_status check_own(const struct move_plan *p)
{
    char why[INTERFACE_NAME_BYTES + 64];
    const struct host_interface *owner = owner_of(p, p->new);
    const bool is_here = is_loopback(p->old) || owner_of(p, p->old) != NULL;
    if (is_loopback(p->new) && !is_loopback(p->old)) {
        return refuse(p->new, "is an address of the loopback, which never "
                              "leaves this host");
    }
    if (owner == NULL || is_here) {
        return EXIT_DONE;
    }
    (void)snprintf(why, sizeof why, "is this host's own address, on %s",
                   owner->name);
    return refuse(p->new, why);
}

/* A /31 and a /32 have neither of both. */
static enum exit_status check_ends(const struct move_plan *p)
{
    char why[INTERFACE_NAME_BYTES + 80];
    for (size_t i = 0; i < p->count; i++) {
        const struct interface_address *a =
            interfaces_subnet(&p->interfaces[i], p->new);
        const uint32_t host = a != NULL ? p->new & ~a->mask : 1u;
        if (a == NULL || a->prefix > 30u || (host != 0 && host != ~a->mask)) {
            continue;
        }
        (void)snprintf(
            why, sizeof why, "is the %s address of %s's subnet %s/%u",
            host == 0 ? "network" : "broadcast", p->interfaces[i].name,
            number_address(a->address & a->mask).text, a->prefix);
        return refuse(p->new, why);
    }
    return EXIT_DONE;
}

/* The interface by which the sensor is reached, or NULL. */
static const struct host_interface *way_to_old(const struct move_plan *p,
                                               const struct host_route *route)
{
    if (p->interface != NULL) {
        return interfaces_find(p->interfaces, p->count, p->interface);
    }
    if (route->is_known) {
        return route->exists
                   ? interfaces_find(p->interfaces, p->count, route->interface)
                   : NULL;
    }
    for (size_t i = 0; i < p->count; i++) {
        if (interfaces_subnet(&p->interfaces[i], p->old) != NULL) {
            return &p->interfaces[i];
        }
    }
    return NULL;
}

static enum exit_status refuse_unreached(const struct move_plan *p,
                                         const char *interface,
                                         const struct host_route *route)
{
    char why[2 * INTERFACE_NAME_BYTES + 128];
    if (route->exists && route->has_gateway) {
        (void)snprintf(why, sizeof why,
                       "is reached by a gateway (%s), and not at %s, where the "
                       "sensor is",
                       route->interface, interface);
    } else if (route->exists) {
        (void)snprintf(why, sizeof why,
                       "is reached by %s, and the sensor is at %s",
                       route->interface, interface);
    } else {
        (void)snprintf(why, sizeof why,
                       "is out of reach: no route of %s leads there (ip addr "
                       "add, or another address)",
                       interface);
    }
    if (p->ctl->options.dry_run) { /* routes may be others by then */
        ctl_note(p->ctl, "set-ip: the address %s; it would be refused", why);
        return EXIT_DONE;
    }
    return refuse(p->new, why);
}

static enum exit_status check_way(const struct move_plan *p)
{
    const struct host_route old = host_route_find(p->old, NULL);
    const struct host_route new = host_route_find(p->new, NULL);
    const struct host_interface *interface = way_to_old(p, &old);
    if (interface == NULL || interfaces_subnet(interface, p->new) != NULL) {
        return EXIT_DONE;
    }
    const bool is_far = old.exists && old.has_gateway;
    if (new.exists && strcmp(new.interface, interface->name) == 0 &&
        (is_far || !new.has_gateway)) {
        return EXIT_DONE;
    }
    return refuse_unreached(p, interface->name, &new);
}

enum exit_status set_ip_check_reach(const struct ctl *ctl, uint32_t address)
{
    struct host_interface *all = NULL;
    lum_error error = {""};
    struct move_plan p = {.ctl = ctl,
                          .old = session_host(ctl).address,
                          .new = address,
                          .interface = ctl->options.interface};
    if (address == p.old) {
        return EXIT_DONE;
    }
    if (interfaces_list(&all, &p.count, &error) != 0) {
        return ctl_complain(EXIT_FAILED, "set-ip: %s", error.text);
    }
    p.interfaces = all;
    enum exit_status status = check_own(&p);
    status = status == EXIT_DONE ? check_ends(&p) : status;
    status = status == EXIT_DONE ? check_way(&p) : status;
    free(all);
    return status;
}

/* --- Which devices have an address --- */

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

bool set_ip_can_search(const struct ctl *ctl, uint32_t address)
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

void set_ip_search(struct ctl *ctl, uint32_t address, struct arp_answers *out)
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

const char *set_ip_other(const struct arp_answers *all,
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
