/* Checks that a usable interface of a Linux host is in the sensor's subnet;
 * if not, gives the commands that fix it. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../../common/host.h"
#include "../../common/number.h"
#include "doctor_neighbour.h"

#include <stdio.h>
#include <string.h>

#define LIST_SIZE 384u

/* --- Addresses --- */

/* "eth0 has 10.42.0.1/28 and 192.168.7.2/24, eth1 has none" */
static void list_addresses(const struct doctor *d, char out[LIST_SIZE])
{
    out[0] = '\0';
    for (size_t i = 0; i < d->host.count; i++) {
        const struct host_interface *w = &d->host.all[i];
        if (w->is_loopback || !host_is_asked_for(d, w)) {
            continue;
        }
        lum_text_add(out, LIST_SIZE, "%s%s has%s", out[0] != '\0' ? ", " : "",
                     w->name, w->address_count == 0 ? " none" : "");
        for (size_t k = 0; k < w->address_count; k++) {
            lum_text_add(out, LIST_SIZE, "%s %s/%u", k > 0 ? " and" : "",
                         number_address(w->addresses[k].address).text,
                         w->addresses[k].prefix);
        }
    }
    if (out[0] == '\0') {
        lum_text_add(out, LIST_SIZE, "loopback is the only one");
    }
}

static void fix_subnet(struct doctor *d, const struct host_interface *w,
                       const struct interface_address *near,
                       struct doctor_finding *out)
{
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
                   number_address(ours).text,
                   w != NULL ? w->name : "INTERFACE");
    if (!doctor_fix_simulator(out, add)) {
        doctor_fix(out, "%s", add);
    }
}

/* --- What is said of it --- */

/* Whether the fault has to be fixed: no sensor answers all the same, nor on
 * another interface than the requested one. A second interface in the sensor's
 * subnet would take the route sooner or later, and it is not needed. */
static bool needs_fix(struct doctor *d, const char *lack,
                      struct doctor_finding *out)
{
    if (host_spare(d, out)) {
        return false;
    }
    doctor_lack(d, DOCTOR_NEEDS_INTERFACE, lack);
    const struct host_interface *w = host_elsewhere(d);
    if (w != NULL) {
        doctor_add(out, "; %s answers on %s", d->address, w->name);
        host_fix_interface(d, w->name, out);
    }
    return w == NULL;
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
    const struct host_interface *w = host_likeliest(d);
    const struct interface_address *near = w != NULL ? host_near(d, w) : NULL;
    if (near != NULL) {
        doctor_wrong(
            out, "%s has %s/%u, a subnet from %s to %s, and %s is outside",
            w->name, number_address(near->address).text, near->prefix,
            number_address(near->address & near->mask).text,
            number_address(near->address | ~near->mask).text, d->address);
    } else {
        say_addresses(d, out);
    }
    if (needs_fix(d, "no interface in the sensor's subnet", out)) {
        fix_subnet(d, w, near, out);
    }
}

static void say_down(struct doctor *d, const struct host_interface *w,
                     const char *has, struct doctor_finding *out)
{
    doctor_wrong(out, "%s, but is down", has);
    if (needs_fix(d, "the interface is down", out)) {
        doctor_fix(out, "sudo ip link set %s up", w->name);
    }
}

static void say_no_link(struct doctor *d, const struct host_interface *w,
                        const char *has, struct doctor_finding *out)
{
    doctor_wrong(out,
                 "%s and is up, but has no link: no cable, or the sensor at "
                 "its other end has no power",
                 has);
    if (needs_fix(d, "the interface has no link", out)) {
        doctor_fix(out,
                   "ip -br link show %s    # plug the cable in, power the "
                   "sensor: it has to say LOWER_UP",
                   w->name);
    }
}

/* One in the sensor's subnet that cannot be used as it is. */
static bool find_unusable(struct doctor *d, struct doctor_finding *out)
{
    char has[INTERFACE_NAME_BYTES + 32];
    for (size_t i = 0; i < d->host.count; i++) {
        const struct host_interface *w = &d->host.all[i];
        const struct interface_address *a =
            interfaces_subnet(w, d->sensor.address);
        if (a == NULL || !host_is_asked_for(d, w)) {
            continue;
        }
        (void)snprintf(has, sizeof has, "%s has %s/%u", w->name,
                       number_address(a->address).text, a->prefix);
        (w->is_up ? say_no_link : say_down)(d, w, has, out);
        return true;
    }
    return false;
}

static void say_candidates(struct doctor *d, const struct candidate *all,
                           size_t n, const struct candidate *best,
                           struct doctor_finding *out)
{
    doctor_fine(out, "%s is up and has %s/%u", best->interface->name,
                number_address(best->address->address).text,
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
                       number_address(all[i].address->address).text,
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
        d->host.chosen = w;
        (void)snprintf(d->host.own, sizeof d->host.own, "%s/%u dev %.32s",
                       d->address, at->prefix, w->name);
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
static bool is_routed(const struct doctor *d, struct host_route *out)
{
    *out = host_route_find(d->sensor.address, d->ctl->options.interface);
    return out->exists && out->has_gateway && !out->is_default;
}

static void look_for_subnet(struct doctor *d, struct doctor_finding *out)
{
    struct candidate all[CANDIDATES_MAX];
    struct host_route route;
    const size_t n = host_candidates(d, all);
    if (n > 0) {
        const struct candidate *best = host_choose(d, all, n);
        d->host.chosen = best->interface;
        d->host.address = best->address->address;
        d->host.answers = best->has_neighbour;
        d->is_local = best->interface->is_loopback;
        say_candidates(d, all, n, best, out);
    } else if (find_unusable(d, out)) {
        return;
    } else if (is_routed(d, &route)) {
        doctor_note(out,
                    "no interface is in the sensor's subnet; %s leads there by "
                    "the gateway %s",
                    route.interface, number_address(route.gateway).text);
    } else {
        say_no_subnet(d, out);
    }
}

void doctor_check_interface(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    const char *only = d->ctl->options.interface;
    const struct interface_address *at = NULL;
    if (interfaces_list(&d->host.all, &d->host.count, &error) != 0) {
        doctor_unseen(out, "not looked at: %s", error.text);
        return;
    }
    if (only != NULL &&
        !host_lists_interface(d->host.all, d->host.count, only, &error)) {
        doctor_wrong(out, "%s", error.text);
        doctor_fix(out, "ip -br addr    # then --interface NAME");
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "no such interface");
        return;
    }
    const struct host_interface *own =
        interfaces_owner(d->host.all, d->host.count, d->sensor.address, &at);
    if (own != NULL) {
        say_own(d, own, at, out);
    } else {
        look_for_subnet(d, out);
    }
}

bool host_answers(struct doctor *d)
{
    struct arp_answers who;
    if (!d->host.answers) {
        neighbours_find(d, d->host.chosen, &who);
        d->host.answers = who.count > 0;
    }
    return d->host.answers;
}
