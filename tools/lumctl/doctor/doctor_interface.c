/* Which interface of a Linux host the sensor is on, and whether the kernel's
 * route leads there. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../../common/host.h"
#include "../../common/number.h"
#include "../beside.h"
#include "../session.h"
#include "doctor_knock.h"
#include "doctor_neighbour.h"
#include "doctor_way.h"

#include <stdio.h>
#include <string.h>

#define LIST_SIZE 384u

/* --- Interfaces that could be the one --- */

bool host_is_asked_for(const struct doctor *d, const struct host_interface *i)
{
    const char *only = d->ctl->options.interface;
    return only == NULL || strcmp(only, i->name) == 0;
}

static bool is_usable(const struct host_interface *i)
{
    return i->is_up && i->has_link;
}

size_t host_candidates(const struct doctor *d,
                       struct candidate out[CANDIDATES_MAX])
{
    size_t n = 0;
    for (size_t i = 0; i < d->interface_count && n < CANDIDATES_MAX; i++) {
        const struct host_interface *w = &d->interfaces[i];
        const struct interface_address *a =
            interfaces_subnet(w, d->sensor.address);
        if (a != NULL && is_usable(w) && host_is_asked_for(d, w)) {
            out[n] = (struct candidate){w, a, false, false, false};
            n++;
        }
    }
    return n;
}

void host_look(struct doctor *d, struct candidate *c)
{
    struct arp_answers who;
    if (c->is_looked_at) {
        return;
    }
    c->is_looked_at = true;
    doctor_keep_alive(d);
    c->is_sensor = knock_reaches(d->sensor, c->interface->name);
    c->has_neighbour = c->is_sensor;
    if (!c->is_sensor) {
        neighbours_find(d, c->interface, &who);
        c->has_neighbour = who.count > 0;
    }
}

static bool is_reached(struct doctor *d)
{
    if (!d->is_reach_known) {
        d->is_reach_known = true;
        doctor_keep_alive(d);
        d->is_reached = knock_reaches(d->sensor, d->ctl->options.interface);
    }
    return d->is_reached;
}

bool host_spare(struct doctor *d, struct doctor_finding *out)
{
    if (!is_reached(d)) {
        return false;
    }
    out->result = DOCTOR_NOTE;
    out->fix[0] = '\0';
    doctor_add(out, "; a sensor answers at %s all the same", d->address);
    return true;
}

/* An interface that the kernel would not choose must be better, not just as
 * good. */
static int rank(const struct candidate *c, const struct way *way)
{
    return (c->is_sensor ? 4 : 0) + (c->has_neighbour ? 2 : 0) +
           (way->exists && strcmp(way->interface, c->interface->name) == 0 ? 1
                                                                           : 0);
}

static struct candidate *choose(struct doctor *d, struct candidate *all,
                                size_t n)
{
    struct way way;
    struct candidate *best = &all[0];
    if (n == 1) {
        return best;
    }
    if (!way_find(d->sensor.address, d->ctl->options.interface, &way)) {
        way.exists = false;
    }
    for (size_t i = 0; i < n; i++) {
        host_look(d, &all[i]);
        if (rank(&all[i], &way) > rank(best, &way)) {
            best = &all[i];
        }
    }
    return best;
}

/* --- Where the sensor most likely is --- */

static bool has_global_address(const struct host_interface *w)
{
    for (size_t i = 0; i < w->address_count; i++) {
        if (w->addresses[i].address >> 16 != 0xa9feu) {
            return true;
        }
    }
    return false;
}

static const struct interface_address *find_near(const struct doctor *d,
                                                 const struct host_interface *w)
{
    for (size_t i = 0; i < w->address_count; i++) {
        if (((w->addresses[i].address ^ d->sensor.address) & BESIDE_MASK) ==
            0) {
            return &w->addresses[i];
        }
    }
    return NULL;
}

/* How likely the sensor's cable is there. Every distribution names cables e...,
 * but not bridges and the ends of containers. An interface with an address in
 * the sensor's subnet was set up for it. */
static int likelihood(const struct doctor *d, const struct host_interface *w)
{
    if (!host_is_asked_for(d, w) || w->is_loopback) {
        return 0;
    }
    if (d->ctl->options.interface != NULL || find_near(d, w) != NULL) {
        return 100;
    }
    return w->is_ethernet
               ? 1 + (w->has_link ? 4 : 0) + (w->name[0] == 'e' ? 3 : 0) +
                     (has_global_address(w) ? 0 : 2)
               : 0;
}

static const struct host_interface *likeliest(const struct doctor *d)
{
    const struct host_interface *best = NULL;
    for (size_t i = 0; i < d->interface_count; i++) {
        const int here = likelihood(d, &d->interfaces[i]);
        if (here > 0 && (best == NULL || here > likelihood(d, best))) {
            best = &d->interfaces[i];
        }
    }
    return best;
}

/* Where a device answers for it, if that can be heard; else a guess. */
static const struct host_interface *where(struct doctor *d)
{
    const struct host_interface *found = neighbours_search(d, NULL);
    return found != NULL && host_is_asked_for(d, found) ? found : likeliest(d);
}

/* --- Addresses, and a free one --- */

static size_t list_address(char *out, size_t room,
                           const struct host_interface *w, size_t k)
{
    char address[16];
    const struct interface_address *a = &w->addresses[k];
    return (size_t)snprintf(
        out, room, "%s%s%s/%u", k > 0 ? "" : w->name, k > 0 ? " and " : " has ",
        number_format_address(a->address, address), a->prefix);
}

/* "eth0 has 10.42.0.1/28 and 192.168.7.2/24, eth1 has none" */
static void list_addresses(const struct doctor *d, char out[LIST_SIZE])
{
    size_t len = 0;
    (void)snprintf(out, LIST_SIZE, "there is no other than loopback");
    for (size_t i = 0; i < d->interface_count && len < LIST_SIZE; i++) {
        const struct host_interface *w = &d->interfaces[i];
        if (w->is_loopback || !host_is_asked_for(d, w)) {
            continue;
        }
        len += (size_t)snprintf(out + len, LIST_SIZE - len, "%s",
                                len > 0 ? ", " : "");
        for (size_t k = 0; k < w->address_count && len < LIST_SIZE; k++) {
            len += list_address(out + len, LIST_SIZE - len, w, k);
        }
        if (w->address_count == 0 && len < LIST_SIZE) {
            len += (size_t)snprintf(out + len, LIST_SIZE - len, "%s has none",
                                    w->name);
        }
    }
}

struct wish {
    struct doctor *d;
    const struct host_interface *on; /* NULL: none that can be asked */
};

static bool is_taken(void *context, uint32_t address)
{
    struct wish *w = context;
    struct arp_answers who = {0};
    if (interfaces_owner(w->d->interfaces, w->d->interface_count, address,
                         NULL) != NULL) {
        return true;
    }
    return w->on != NULL && neighbours_hear(w->d, w->on, address, &who) &&
           who.count > 0;
}

uint32_t host_address_beside(struct doctor *d, const struct host_interface *w)
{
    struct wish wish = {d, w != NULL && is_usable(w) ? w : NULL};
    return beside_find(d->sensor.address, is_taken, &wish);
}

void host_say_full(const struct doctor *d, const struct host_interface *w,
                   struct doctor_finding *out)
{
    char first[16];
    char last[16];
    const uint32_t subnet = d->sensor.address & BESIDE_MASK;
    doctor_add(out, "; of %s to %s every address is taken",
               number_format_address(subnet | 1u, first),
               number_format_address(subnet | BESIDE_LAST, last));
    doctor_fix(out,
               "sudo lumctl find --interface %s --subnet %s/24    # who has "
               "which; then give %s one that nobody has",
               w != NULL ? w->name : "INTERFACE",
               number_format_address(subnet, first),
               w != NULL ? w->name : "INTERFACE");
}

static void fix_subnet(struct doctor *d, const struct host_interface *w,
                       const struct interface_address *near,
                       struct doctor_finding *out)
{
    char address[16];
    char add[128 + 2 * INTERFACE_NAME_BYTES];
    const uint32_t ours =
        near != NULL ? near->address : host_address_beside(d, w);
    if (ours == 0) {
        host_say_full(d, w, out);
        return;
    }
    (void)snprintf(add, sizeof add, "%s%s%ssudo ip addr add %s/24 dev %s",
                   w != NULL && !w->is_up ? "sudo ip link set " : "",
                   w != NULL && !w->is_up ? w->name : "",
                   w != NULL && !w->is_up ? " up && " : "",
                   number_format_address(ours, address),
                   w != NULL ? w->name : "INTERFACE");
    if (!doctor_fix_simulator(out, add)) {
        doctor_fix(out, "%s", add);
    }
}

/* --- What is said of it --- */

/* The sensor is on another interface than the requested one. */
static const struct host_interface *find_elsewhere(struct doctor *d)
{
    const char *only = d->ctl->options.interface;
    struct way way;
    if (only == NULL) {
        return NULL;
    }
    doctor_keep_alive(d);
    if (way_find(d->sensor.address, NULL, &way) && way.exists &&
        strcmp(way.interface, only) != 0 && knock_reaches(d->sensor, NULL)) {
        return interfaces_find(d->interfaces, d->interface_count,
                               way.interface);
    }
    for (size_t i = 0; i < d->interface_count; i++) {
        const struct host_interface *w = &d->interfaces[i];
        doctor_keep_alive(d);
        if (is_usable(w) && !w->is_loopback && strcmp(w->name, only) != 0 &&
            interfaces_subnet(w, d->sensor.address) != NULL &&
            knock_reaches(d->sensor, w->name)) {
            return w;
        }
    }
    return neighbours_search(d, only);
}

/* A second interface in the sensor's subnet would take the route sooner or
 * later, and it is not needed. */
static bool point_elsewhere(struct doctor *d, struct doctor_finding *out)
{
    const struct host_interface *w = find_elsewhere(d);
    if (w == NULL) {
        return false;
    }
    doctor_add(out, "; %s answers on %s", d->address, w->name);
    host_fix_interface(d, w->name, out);
    return true;
}

static void say_addresses(const struct doctor *d, struct doctor_finding *out)
{
    const char *only = d->ctl->options.interface;
    char list[LIST_SIZE];
    list_addresses(d, list);
    if (only != NULL) {
        doctor_wrong(out,
                     "interface %s has no address in the sensor's subnet (%s)",
                     only, list);
    } else {
        doctor_wrong(out,
                     "no interface has an address in the sensor's subnet (%s)",
                     list);
    }
}

static void say_no_subnet(struct doctor *d, struct doctor_finding *out)
{
    char text[3][16];
    const struct host_interface *w = where(d);
    const struct interface_address *near = w != NULL ? find_near(d, w) : NULL;
    if (near != NULL) {
        doctor_wrong(
            out, "%s has %s/%u, a subnet from %s to %s, which leaves %s out",
            w->name, number_format_address(near->address, text[0]),
            near->prefix,
            number_format_address(near->address & near->mask, text[1]),
            number_format_address(near->address | ~near->mask, text[2]),
            d->address);
    } else {
        say_addresses(d, out);
    }
    if (!host_spare(d, out)) {
        if (!point_elsewhere(d, out)) {
            fix_subnet(d, w, near, out);
        }
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE,
                    "no interface in the sensor's subnet");
    }
}

static void say_down(struct doctor *d, const struct host_interface *w,
                     const char *has, struct doctor_finding *out)
{
    doctor_wrong(out, "%s, but is down", has);
    if (!host_spare(d, out)) {
        if (!point_elsewhere(d, out)) {
            doctor_fix(out, "sudo ip link set %s up", w->name);
        }
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface is down");
    }
}

static void say_no_link(struct doctor *d, const struct host_interface *w,
                        const char *has, struct doctor_finding *out)
{
    doctor_wrong(out,
                 "%s and is up, but has no link: no cable, or the sensor at "
                 "its other end has no power",
                 has);
    if (!host_spare(d, out)) {
        if (!point_elsewhere(d, out)) {
            doctor_fix(out,
                       "ip -br link show %s    # plug the cable in, power the "
                       "sensor: it has to say LOWER_UP",
                       w->name);
        }
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface has no link");
    }
}

/* One in the sensor's subnet that cannot be used as it is. */
static bool find_unusable(struct doctor *d, struct doctor_finding *out)
{
    char has[INTERFACE_NAME_BYTES + 32];
    char address[16];
    for (size_t i = 0; i < d->interface_count; i++) {
        const struct host_interface *w = &d->interfaces[i];
        const struct interface_address *a =
            interfaces_subnet(w, d->sensor.address);
        if (a == NULL || !host_is_asked_for(d, w)) {
            continue;
        }
        (void)snprintf(has, sizeof has, "%s has %s/%u", w->name,
                       number_format_address(a->address, address), a->prefix);
        (w->is_up ? say_no_link : say_down)(d, w, has, out);
        return true;
    }
    return false;
}

static void say_candidates(struct doctor *d, const struct candidate *all,
                           size_t n, const struct candidate *best,
                           struct doctor_finding *out)
{
    char address[16];
    doctor_fine(out, "%s is up and has %s/%u", best->interface->name,
                number_format_address(best->address->address, address),
                best->address->prefix);
    if (n > 1) {
        doctor_add(out,
                   best->has_neighbour ? ", and %s answers there"
                                       : ", and nobody answers for %s "
                                         "there",
                   d->address);
    }
    for (size_t i = 0; i < n; i++) {
        if (&all[i] != best) {
            doctor_add(out,
                       "; %s with %s/%u is in that subnet too, and %s there",
                       all[i].interface->name,
                       number_format_address(all[i].address->address, address),
                       all[i].address->prefix,
                       all[i].has_neighbour ? "the address answers"
                                            : "nobody answers");
        }
    }
}

/* A simulator's address, or one that was given to this host by mistake. */
static void say_own(struct doctor *d, const struct host_interface *w,
                    const struct interface_address *at,
                    struct doctor_finding *out)
{
    d->is_local = true;
    if (d->sensor.address >> 24 != 127u) {
        d->chosen = w;
        (void)snprintf(d->own, sizeof d->own, "%s/%u dev %.32s", d->address,
                       at->prefix, w->name);
    }
    if (w->is_up) {
        doctor_fine(out, "%s is this host's own address, on %s", d->address,
                    w->name);
        return;
    }
    doctor_wrong(out, "%s is down, which has %s", w->name, d->address);
    doctor_fix(out, "sudo ip link set %s up", w->name);
    doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface is down");
}

/* --- Check: interface --- */

/* A sensor behind a router of its own network. */
static bool is_routed(const struct doctor *d, struct way *way)
{
    return way_find(d->sensor.address, d->ctl->options.interface, way) &&
           way->exists && way->has_gateway && !way->is_default;
}

static void look_for_subnet(struct doctor *d, struct doctor_finding *out)
{
    struct candidate all[CANDIDATES_MAX];
    struct way way;
    char gateway[16];
    const size_t n = host_candidates(d, all);
    if (n > 0) {
        const struct candidate *best = choose(d, all, n);
        d->chosen = best->interface;
        d->chosen_address = best->address->address;
        d->chosen_answers = best->has_neighbour;
        d->is_local = best->interface->is_loopback;
        say_candidates(d, all, n, best, out);
    } else if (find_unusable(d, out)) {
        return;
    } else if (is_routed(d, &way)) {
        doctor_note(out,
                    "no interface is in the sensor's subnet; %s leads there by "
                    "the gateway %s",
                    way.interface, number_format_address(way.gateway, gateway));
    } else {
        say_no_subnet(d, out);
    }
}

void doctor_check_interface(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    const char *only = d->ctl->options.interface;
    const struct interface_address *at = NULL;
    if (interfaces_list(&d->interfaces, &d->interface_count, &error) != 0) {
        doctor_unseen(out, "not looked at: %s", error.text);
        return;
    }
    if (only != NULL && !host_lists_interface(d->interfaces, d->interface_count,
                                              only, &error)) {
        doctor_wrong(out, "%s", error.text);
        doctor_fix(out, "ip -br addr    # then --interface NAME");
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "no such interface");
        return;
    }
    const struct host_interface *own = interfaces_owner(
        d->interfaces, d->interface_count, d->sensor.address, &at);
    if (own != NULL) {
        say_own(d, own, at, out);
    } else {
        look_for_subnet(d, out);
    }
}

/* --- Check: route --- */

static void say_no_route(struct doctor *d, int error,
                         struct doctor_finding *out)
{
    doctor_wrong(out, "no route to %s: %s", d->address, strerror(error));
    doctor_fix(out,
               "ip route get %s; ip route; ip rule    # take the rule "
               "out that forbids it",
               d->address);
    doctor_lack(d, DOCTOR_NEEDS_ROUTE, "no route");
}

void host_fix_interface(const struct doctor *d, const char *interface,
                        struct doctor_finding *out)
{
    char at[SESSION_CTL_BYTES];
    doctor_fix(out, "%s doctor    # --interface %s with every tool",
               lum_news_ctl(d->sensor, interface, at, sizeof at), interface);
}

/* --interface changes nothing on this host. A route must be set if another
 * route leads to a gateway even on the right interface. */
static void fix_astray(const struct doctor *d, struct doctor_finding *out)
{
    struct way there;
    char source[16];
    const char *name = d->chosen->name;
    if (way_find(d->sensor.address, name, &there) && there.exists &&
        !there.has_gateway) {
        host_fix_interface(d, name, out);
    } else {
        doctor_fix(out, "sudo ip route replace %s/32 dev %s src %s", d->address,
                   name, number_format_address(d->chosen_address, source));
    }
}

/* Whether a device answers on the interface in the sensor's subnet. */
static bool chosen_answers(struct doctor *d)
{
    struct arp_answers who;
    if (!d->chosen_answers) {
        neighbours_find(d, d->chosen, &who);
        d->chosen_answers = who.count > 0;
    }
    return d->chosen_answers;
}

/* The kernel does not send by the interface in the sensor's subnet. This is
 * wrong only if the sensor is seen there. */
static void say_astray(struct doctor *d, const struct way *way,
                       struct doctor_finding *out)
{
    char gateway[16];
    doctor_wrong(
        out, "%s goes out by %s%s%s, and not by %s in its subnet", d->address,
        way->interface, way->has_gateway ? " to the gateway " : "",
        way->has_gateway ? number_format_address(way->gateway, gateway) : "",
        d->chosen->name);
    if (host_spare(d, out)) {
        return;
    }
    if (chosen_answers(d)) {
        doctor_add(out, ", where it answers");
        fix_astray(d, out);
        doctor_lack(d, DOCTOR_NEEDS_ROUTE, "the route leads elsewhere");
    } else {
        doctor_add(out, ", where nobody answers for it either");
        out->result = DOCTOR_NOTE;
    }
}

static void keep_way(struct doctor *d, const struct way *way)
{
    (void)snprintf(d->interface, sizeof d->interface, "%s", way->interface);
    d->is_local = d->is_local || way->is_local;
    d->source = way->source;
    d->next_hop = way->has_gateway ? way->gateway : d->sensor.address;
}

void doctor_check_route(struct doctor *d, struct doctor_finding *out)
{
    struct way way;
    char address[16];
    if (!way_find(d->sensor.address, d->ctl->options.interface, &way)) {
        doctor_unseen(out,
                      "not looked at: the kernel does not tell its routes");
        return;
    }
    if (!way.exists) {
        say_no_route(d, way.error, out);
        return;
    }
    keep_way(d, &way);
    if (d->chosen != NULL && !d->is_local &&
        (way.has_gateway || strcmp(way.interface, d->chosen->name) != 0)) {
        say_astray(d, &way, out);
        return;
    }
    doctor_fine(out, "%s goes out by %s%s%s", d->address, way.interface,
                way.has_gateway ? " to the gateway " : ", directly",
                way.has_gateway ? number_format_address(way.gateway, address)
                                : "");
    if (way.source != 0) {
        doctor_add(out, ", from %s",
                   number_format_address(way.source, address));
    }
}
