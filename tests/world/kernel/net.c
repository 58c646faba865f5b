#define _GNU_SOURCE
#include "net.h"

#include "arp.h"
#include "net_internal.h"
#include "trace.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MEMORY_MAX   212992u /* net.core.rmem_max and wmem_max of Linux */
#define MTU          1500u
#define LOOPBACK_MTU 65536u

static struct {
    world_net_host *hosts;
    world_segment *segments;
    uint64_t generation;
    uint64_t interfaces;
} net;

static void *make(size_t bytes)
{
    void *memory = calloc(1, bytes);
    if (memory == NULL) {
        abort();
    }
    return memory;
}

static void change(void)
{
    net.generation++;
}

uint64_t world_net_generation(void)
{
    return net.generation;
}

/* --- hosts and interfaces --- */

static world_interface *add_interface(world_net_host *host, const char *name)
{
    world_interface *interface = make(sizeof *interface);
    char owner[48];
    (void)snprintf(interface->name, sizeof interface->name, "%s", name);
    (void)snprintf(owner, sizeof owner, "%s:%s", host->host->name, name);
    interface->host = host->host;
    interface->index = ++host->interface_count;
    interface->stream = ++net.interfaces;
    interface->is_up = true;
    interface->has_carrier = true;
    interface->mtu = MTU;
    interface->arp_random = world_stream("arp", interface->stream);
    world_link_begin(&interface->out, owner, "out");
    world_link_begin(&interface->in, owner, "in");
    if (host->last != NULL) {
        host->last->next = interface;
    } else {
        host->interfaces = interface;
    }
    host->last = interface;
    world_net_publish_interface(interface);
    return interface;
}

static world_net_host *make_host(world_host *host)
{
    world_net_host *out = make(sizeof *out);
    out->host = host;
    out->next = net.hosts;
    net.hosts = out;
    host->net = out;
    out->rights = (world_net_rights){.may_bind_device = true,
                                     .receive_max = MEMORY_MAX,
                                     .send_max = MEMORY_MAX};
    out->ports = world_stream("ports", 0);
    for (const char *c = host->name; *c != '\0'; c++) {
        out->ports.state = out->ports.state * 31u + (unsigned char)*c;
    }
    world_net_publish(host);
    world_interface *lo = add_interface(out, "lo");
    lo->mtu = LOOPBACK_MTU;
    world_interface_add(lo, WORLD_LOOPBACK, 8);
    return out;
}

/* Made at the first question: whoever asks does not mean to change the host. */
world_net_host *world_net_of(const world_host *host)
{
    world_host *mutable = NULL;
    if (host->net != NULL) {
        return host->net;
    }
    for (world_host *h = world_host_first(); h != NULL; h = h->next) {
        mutable = h == host ? h : mutable;
    }
    if (mutable == NULL) {
        abort();
    }
    return make_host(mutable);
}

world_net_host *world_net_first(void)
{
    return net.hosts;
}

world_net_rights *world_net_rights_of(const world_host *host)
{
    return &world_net_of(host)->rights;
}

world_segment *world_segment_new(const char *name)
{
    world_segment *segment = make(sizeof *segment);
    (void)snprintf(segment->name, sizeof segment->name, "%s", name);
    segment->next = net.segments;
    net.segments = segment;
    return segment;
}

/* 02: an address that no maker gave. */
world_interface *world_interface_new(world_host *host, world_segment *segment,
                                     const char *name)
{
    world_interface *interface = add_interface(world_net_of(host), name);
    world_interface **last = &segment->interfaces;
    const uint8_t mac[6] = {2,
                            0,
                            0x5e,
                            (uint8_t)(interface->stream >> 16),
                            (uint8_t)(interface->stream >> 8),
                            (uint8_t)interface->stream};
    memcpy(interface->mac, mac, sizeof mac);
    interface->segment = segment;
    while (*last != NULL) {
        last = &(*last)->next_of_segment;
    }
    *last = interface;
    change();
    return interface;
}

world_interface *world_interface_first(const world_host *host)
{
    return world_net_of(host)->interfaces;
}

world_interface *world_interface_find(const world_host *host, const char *name)
{
    world_interface *i = world_interface_first(host);
    while (i != NULL && strcmp(i->name, name) != 0) {
        i = i->next;
    }
    return i;
}

world_interface *world_interface_by_index(const world_host *host,
                                          unsigned index)
{
    world_interface *i = world_interface_first(host);
    while (i != NULL && i->index != index) {
        i = i->next;
    }
    return i;
}

bool world_interface_is_loopback(const world_interface *interface)
{
    return interface->segment == NULL;
}

/* --- routes --- */

uint32_t world_mask(unsigned prefix)
{
    return prefix == 0 ? 0 : UINT32_MAX << (32u - prefix);
}

static void add_route(world_interface *interface, world_route route)
{
    world_route *out = make(sizeof *out);
    world_route **last = &world_net_of(interface->host)->routes;
    *out = route;
    out->interface = interface;
    out->next = NULL;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = out;
    change();
}

static void add_own_route(world_interface *interface, world_address address)
{
    if (interface->is_up) {
        add_route(interface,
                  (world_route){.network = address.address &
                                           world_mask(address.prefix),
                                .prefix = address.prefix,
                                .source = address.address});
    }
}

/* Those for which is_it() holds. */
static void remove_routes(world_interface *interface,
                          bool (*is_it)(const world_route *route,
                                        const world_route *like),
                          const world_route *like)
{
    world_route **at = &world_net_of(interface->host)->routes;
    while (*at != NULL) {
        world_route *route = *at;
        if (route->interface == interface && is_it(route, like)) {
            *at = route->next;
            free(route);
        } else {
            at = &route->next;
        }
    }
    change();
}

static bool is_any(const world_route *route, const world_route *like)
{
    (void)route;
    (void)like;
    return true;
}

static bool is_from(const world_route *route, const world_route *like)
{
    return route->source == like->source;
}

static bool is_to(const world_route *route, const world_route *like)
{
    return route->network == like->network && route->prefix == like->prefix;
}

void world_route_add(world_interface *interface, uint32_t network,
                     unsigned prefix, uint32_t gateway)
{
    add_route(interface, (world_route){.network = network & world_mask(prefix),
                                       .prefix = prefix,
                                       .gateway = gateway});
}

void world_route_remove(world_interface *interface, uint32_t network,
                        unsigned prefix)
{
    const world_route like = {.network = network & world_mask(prefix),
                              .prefix = prefix};
    remove_routes(interface, is_to, &like);
}

/* --- addresses --- */

void world_interface_add(world_interface *interface, uint32_t address,
                         unsigned prefix)
{
    if (interface->address_count == WORLD_ADDRESSES) {
        world_fail("%s of %s has no room for a further address",
                   interface->name, interface->host->name);
        return;
    }
    const world_address added = {.address = address, .prefix = prefix};
    interface->addresses[interface->address_count++] = added;
    add_own_route(interface, added);
    change();
}

static world_address *find_address(world_interface *interface, uint32_t address)
{
    for (size_t i = 0; i < interface->address_count; i++) {
        if (interface->addresses[i].address == address) {
            return &interface->addresses[i];
        }
    }
    return NULL;
}

const world_address *world_interface_address(const world_interface *interface,
                                             uint32_t address)
{
    for (size_t i = 0; i < interface->address_count; i++) {
        if (interface->addresses[i].address == address) {
            return &interface->addresses[i];
        }
    }
    return NULL;
}

void world_interface_remove(world_interface *interface, uint32_t address)
{
    const world_address *found = find_address(interface, address);
    const world_route like = {.source = address};
    if (found == NULL) {
        return;
    }
    const size_t at = (size_t)(found - interface->addresses);
    interface->address_count--;
    memmove(&interface->addresses[at], &interface->addresses[at + 1u],
            (interface->address_count - at) * sizeof interface->addresses[0]);
    remove_routes(interface, is_from, &like);
}

/* Every address of 127/8 is the loopback's. */
static bool has_address(const world_interface *interface, uint32_t address)
{
    return world_interface_address(interface, address) != NULL ||
           (world_interface_is_loopback(interface) && address >> 24 == 127u);
}

world_interface *world_net_owner(const world_host *host, uint32_t address)
{
    world_interface *i = world_interface_first(host);
    while (i != NULL && !has_address(i, address)) {
        i = i->next;
    }
    return i;
}

static bool is_broadcast_at(const world_interface *interface, uint32_t address)
{
    for (size_t i = 0; i < interface->address_count; i++) {
        const world_address *a = &interface->addresses[i];
        if (a->prefix < 31u &&
            (a->address | ~world_mask(a->prefix)) == address) {
            return true;
        }
    }
    return false;
}

static world_interface *broadcast_owner(const world_host *host,
                                        uint32_t address)
{
    world_interface *i = world_interface_first(host);
    while (i != NULL && (!i->is_up || !is_broadcast_at(i, address))) {
        i = i->next;
    }
    return i;
}

bool world_net_is_broadcast(const world_host *host, uint32_t address)
{
    return address == WORLD_EVERYBODY || broadcast_owner(host, address) != NULL;
}

uint32_t world_interface_source(const world_interface *interface, uint32_t to)
{
    for (size_t i = 0; i < interface->address_count; i++) {
        const world_address *a = &interface->addresses[i];
        if (((a->address ^ to) & world_mask(a->prefix)) == 0) {
            return a->address;
        }
    }
    return interface->address_count > 0 ? interface->addresses[0].address : 0;
}

/* --- changes --- */

void world_interface_set_up(world_interface *interface, bool is_up)
{
    if (interface->is_up == is_up) {
        return;
    }
    interface->is_up = is_up;
    if (is_up) {
        for (size_t i = 0; i < interface->address_count; i++) {
            add_own_route(interface, interface->addresses[i]);
        }
    } else {
        remove_routes(interface, is_any, NULL);
        world_neighbours_flush(interface);
    }
    WORLD_TRACE("%s of %s is set %s", interface->name, interface->host->name,
                is_up ? "up" : "down");
    change();
}

void world_interface_set_carrier(world_interface *interface, bool has_carrier)
{
    if (interface->has_carrier == has_carrier) {
        return;
    }
    interface->has_carrier = has_carrier;
    if (!has_carrier) {
        world_neighbours_flush(interface);
    }
    WORLD_TRACE("%s of %s has %s carrier", interface->name,
                interface->host->name, has_carrier ? "a" : "no");
    change();
}

void world_interface_roam(world_interface *interface, unsigned prefix)
{
    interface->roams = prefix;
}

bool world_net_take_address(const world_host *host, const world_interface *by,
                            uint32_t address)
{
    for (world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        if (i->roams == 0 || (by != NULL && by != i)) {
            continue;
        }
        if (find_address(i, address) == NULL &&
            i->address_count < WORLD_ADDRESSES) {
            world_interface_add(i, address, i->roams);
        }
        world_address *a = find_address(i, address);
        if (a != NULL) {
            a->bound++;
            return true;
        }
    }
    return false;
}

void world_net_leave_address(const world_host *host, uint32_t address)
{
    for (world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        world_address *a = find_address(i, address);
        if (a != NULL && a->bound > 0) {
            a->bound--;
            if (a->bound == 0) {
                world_interface_remove(i, address);
            }
            return;
        }
    }
}

static void heal(world_link *link)
{
    world_link good = {.private = link->private};
    world_link_begin(&good, "", "");
    memcpy(good.private.random, link->private.random,
           sizeof good.private.random);
    *link = good;
}

void world_net_heal(void)
{
    for (world_net_host *h = net.hosts; h != NULL; h = h->next) {
        for (world_interface *i = h->interfaces; i != NULL; i = i->next) {
            heal(&i->out);
            heal(&i->in);
            i->island = 0;
        }
    }
}

/* --- ways --- */

static const world_route *match(const world_host *host, uint32_t to,
                                const world_interface *by)
{
    const world_route *best = NULL;
    for (const world_route *r = world_net_of(host)->routes; r != NULL;
         r = r->next) {
        if ((by == NULL || r->interface == by) &&
            ((r->network ^ to) & world_mask(r->prefix)) == 0 &&
            (best == NULL || r->prefix > best->prefix)) {
            best = r;
        }
    }
    return best;
}

static void fill(world_way *out, world_way_kind kind,
                 world_interface *interface, uint32_t next_hop)
{
    out->kind = kind;
    out->interface = interface;
    out->next_hop = next_hop;
}

static int find_everybody(const world_host *host, uint32_t from,
                          const world_interface *by, world_way *out)
{
    world_interface *interface = NULL;
    if (by != NULL) {
        interface = world_interface_by_index(host, by->index);
    } else if (from != 0) {
        interface = world_net_owner(host, from);
    } else {
        const world_route *route = match(host, WORLD_EVERYBODY, NULL);
        interface = route != NULL ? route->interface : NULL;
    }
    if (interface == NULL) {
        return ENETUNREACH;
    }
    fill(out, WORLD_WAY_BROADCAST, interface, WORLD_EVERYBODY);
    out->source = world_interface_source(interface, 0);
    return 0;
}

static bool find_own(const world_host *host, uint32_t to,
                     const world_interface *by, world_way *out)
{
    world_interface *owner = world_net_owner(host, to);
    if (owner != NULL && (by == NULL || by == owner)) {
        fill(out, WORLD_WAY_LOCAL, owner, to);
        out->source = to >> 24 == 127u ? WORLD_LOOPBACK : to;
        return true;
    }
    owner = broadcast_owner(host, to);
    if (owner != NULL && (by == NULL || by == owner)) {
        fill(out, WORLD_WAY_BROADCAST, owner, to);
        out->source = world_interface_source(owner, to);
        return true;
    }
    return false;
}

/* That of the interface, or of another one. */
static uint32_t source_for(const world_interface *interface, uint32_t to)
{
    uint32_t source = world_interface_source(interface, to);
    for (const world_interface *i = world_interface_first(interface->host);
         i != NULL && source == 0; i = i->next) {
        if (!world_interface_is_loopback(i)) {
            source = world_interface_source(i, to);
        }
    }
    return source;
}

static world_interface *roamer(const world_host *host)
{
    world_interface *i = world_interface_first(host);
    while (i != NULL && (i->roams == 0 || !i->is_up)) {
        i = i->next;
    }
    return i;
}

/* Where no table knows the way, a socket that says by which interface finds the
 * address on its link. So does a sensor, wherever its address is from. */
static int find_other(const world_host *host, uint32_t to,
                      const world_interface *by, world_way *out)
{
    const world_route *route = match(host, to, by);
    out->route = route;
    if (route == NULL && by == NULL) {
        by = roamer(host);
    }
    if (route == NULL && by == NULL) {
        return ENETUNREACH;
    }
    world_interface *interface =
        route != NULL ? route->interface : world_interface_by_index(host, by->index);
    const bool is_near = route == NULL || route->gateway == 0;
    fill(out, WORLD_WAY_LINK, interface, is_near ? to : route->gateway);
    out->source = route != NULL && route->source != 0
                      ? route->source
                      : source_for(interface, out->next_hop);
    return 0;
}

int world_way_find(const world_host *host, uint32_t to, uint32_t from,
                   const world_interface *by, world_way *out)
{
    int code = 0;
    memset(out, 0, sizeof *out);
    if (to == 0) {
        to = from != 0 ? from : WORLD_LOOPBACK;
    }
    if ((from != 0 && world_net_owner(host, from) == NULL) ||
        (by != NULL && !by->is_up)) {
        return ENETUNREACH;
    }
    if (to == WORLD_EVERYBODY) {
        code = find_everybody(host, from, by, out);
    } else if (!find_own(host, to, by, out)) {
        code = find_other(host, to, by, out);
    }
    if (code == 0 && from != 0) {
        out->source = from;
    }
    return code;
}

/* --- arriving --- */

void world_net_arrive(world_datagram *datagram)
{
    const world_host *host = datagram->in_at->host;
    world_packet_hear_datagram(datagram->in_at, datagram);
    const bool is_for_all = world_net_is_broadcast(host, datagram->to);
    const world_interface *owner = world_net_owner(host, datagram->to);
    const bool is_ours =
        is_for_all || (owner != NULL && !world_interface_is_loopback(owner));
    if (!is_ours || world_net_owner(host, datagram->from) != NULL) {
        world_met("net:foreign");
        world_datagram_end(datagram, WORLD_LOST_FOREIGN);
        return;
    }
    datagram->private.is_broadcast = is_for_all;
    world_udp_deliver(host, datagram);
}

/* --- the end --- */

static void free_host(world_net_host *host)
{
    while (host->interfaces != NULL) {
        world_interface *next = host->interfaces->next;
        world_neighbours_free(host->interfaces);
        free(host->interfaces);
        host->interfaces = next;
    }
    while (host->routes != NULL) {
        world_route *next = host->routes->next;
        free(host->routes);
        host->routes = next;
    }
    host->host->net = NULL;
    free(host);
}

void world_net_reset(void)
{
    world_udp_reset();
    world_datagrams_reset();
    world_names_reset();
    while (net.hosts != NULL) {
        world_net_host *next = net.hosts->next;
        free_host(net.hosts);
        net.hosts = next;
    }
    while (net.segments != NULL) {
        world_segment *next = net.segments->next;
        free(net.segments);
        net.segments = next;
    }
    memset(&net, 0, sizeof net);
}
