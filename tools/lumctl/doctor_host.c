/* What Linux tells of this host's side. */
#define _POSIX_C_SOURCE 200809L

#include "doctor.h"

#include "../common/number.h"
#include "doctor_facts.h"
#include "doctor_knock.h"
#include "doctor_way.h"

#include "lum/base/time.h"

#include <stdio.h>
#include <string.h>

#define MS_NS      INT64_C(1000000)
#define ARP_NS     (1500 * MS_NS)
#define ARP_LOOK   50 /* ms */
#define MTU_MIN    1500u
#define NAMES_SIZE 256u

/* Interfaces, as the checks of the sensor's subnet see them. */
struct view {
    struct way_interface all[WAY_INTERFACES_MAX];
    size_t count;
};

static bool is_asked_for(const struct doctor *d, const struct way_interface *i)
{
    const char *only = d->ctl->options.interface;
    return only == NULL || strcmp(only, i->name) == 0;
}

static bool is_usable(const struct way_interface *i)
{
    return i->is_up && i->has_link;
}

/* The interface whose subnet holds the sensor, a usable one first. */
static const struct way_interface *find_subnet(const struct doctor *d,
                                               const struct view *view)
{
    const struct way_interface *best = NULL;
    for (size_t i = 0; i < view->count; i++) {
        const struct way_interface *w = &view->all[i];
        if (w->has_address && w->mask != 0 && is_asked_for(d, w) &&
            ((w->address ^ d->sensor.address) & w->mask) == 0 &&
            (best == NULL || (is_usable(w) && !is_usable(best)))) {
            best = w;
        }
    }
    return best;
}

static const struct way_interface *find_own(const struct doctor *d,
                                            const struct view *view)
{
    for (size_t i = 0; i < view->count; i++) {
        if (view->all[i].has_address &&
            view->all[i].address == d->sensor.address) {
            return &view->all[i];
        }
    }
    return NULL;
}

static bool has_global_address(const struct view *view, const char *name)
{
    for (size_t i = 0; i < view->count; i++) {
        const struct way_interface *w = &view->all[i];
        if (strcmp(w->name, name) == 0 && w->has_address &&
            w->address >> 16 != 0xa9feu) {
            return true;
        }
    }
    return false;
}

/* How likely the sensor's cable is there. Cables are named e... by every
 * distribution; bridges and containers' ends are not. */
static int likelihood(const struct doctor *d, const struct view *view,
                      const struct way_interface *w)
{
    if (!is_asked_for(d, w) || w->is_loopback) {
        return 0;
    }
    if (d->ctl->options.interface != NULL) {
        return 100;
    }
    return w->is_ethernet
               ? 1 + (w->has_link ? 4 : 0) + (w->name[0] == 'e' ? 3 : 0) +
                     (has_global_address(view, w->name) ? 0 : 2)
               : 0;
}

static const struct way_interface *likeliest(const struct doctor *d,
                                             const struct view *view)
{
    const struct way_interface *best = NULL;
    for (size_t i = 0; i < view->count; i++) {
        const int here = likelihood(d, view, &view->all[i]);
        if (here > 0 && (best == NULL || here > likelihood(d, view, best))) {
            best = &view->all[i];
        }
    }
    return best;
}

/* "eth0, wlan0", each once. */
static void list_names(const struct view *view, char out[NAMES_SIZE])
{
    size_t len = 0;
    *out = '\0';
    for (size_t i = 0; i < view->count && len < NAMES_SIZE; i++) {
        bool is_new = true;
        for (size_t k = 0; k < i; k++) {
            is_new =
                is_new && strcmp(view->all[k].name, view->all[i].name) != 0;
        }
        if (is_new) {
            len += (size_t)snprintf(out + len, NAMES_SIZE - len, "%s%s",
                                    len > 0 ? ", " : "", view->all[i].name);
        }
    }
}

/* An address of this host beside the sensor's. */
static const char *address_beside(const struct doctor *d, char out[16])
{
    const uint32_t subnet = d->sensor.address & 0xffffff00u;
    const uint32_t last = (d->sensor.address & 0xffu) == 1u ? 2u : 1u;
    return number_format_address(subnet | last, out);
}

static void say_no_subnet(const struct doctor *d, const struct view *view,
                          struct doctor_finding *out)
{
    char address[16];
    char add[128];
    char names[NAMES_SIZE];
    const struct way_interface *w = likeliest(d, view);
    list_names(view, names);
    doctor_wrong(
        out,
        "no interface%s%s has an address in the sensor's subnet "
        "(interfaces: %s)",
        d->ctl->options.interface != NULL ? " " : "",
        d->ctl->options.interface != NULL ? d->ctl->options.interface : "",
        names);
    (void)snprintf(add, sizeof add, "%s%s%ssudo ip addr add %s/24 dev %s",
                   w != NULL && !w->is_up ? "sudo ip link set " : "",
                   w != NULL && !w->is_up ? w->name : "",
                   w != NULL && !w->is_up ? " up && " : "",
                   address_beside(d, address),
                   w != NULL ? w->name : "INTERFACE");
    if (!doctor_mend_simulator(out, add)) {
        doctor_mend(out, "%s", add);
    }
}

static bool names_an_interface(const struct doctor *d, const struct view *view)
{
    for (size_t i = 0; i < view->count; i++) {
        if (is_asked_for(d, &view->all[i])) {
            return true;
        }
    }
    return false;
}

static void say_subnet(struct doctor *d, const struct way_interface *w,
                       struct doctor_finding *out)
{
    char address[16];
    if (!w->is_up) {
        doctor_wrong(out, "%s has %s/%u, but is down", w->name,
                     number_format_address(w->address, address),
                     way_mask_bits(w->mask));
        doctor_mend(out, "sudo ip link set %s up", w->name);
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface is down");
        return;
    }
    if (!w->has_link) {
        doctor_wrong(out,
                     "%s has %s/%u and is up, but has no link: no cable, or "
                     "the sensor at its other end has no power",
                     w->name, number_format_address(w->address, address),
                     way_mask_bits(w->mask));
        doctor_mend(out,
                    "ip -br link show %s    # plug the cable in, power the "
                    "sensor: it has to say LOWER_UP",
                    w->name);
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface has no link");
        return;
    }
    doctor_fine(out, "%s is up and has %s/%u", w->name,
                number_format_address(w->address, address),
                way_mask_bits(w->mask));
}

/* A simulator's address, or one that was given to this host by mistake. */
static void say_own(struct doctor *d, const struct way_interface *w,
                    struct doctor_finding *out)
{
    d->is_local = true;
    if (!w->is_loopback) {
        (void)snprintf(d->own, sizeof d->own, "%s/%u dev %s", d->address,
                       way_mask_bits(w->mask), w->name);
    }
    if (w->is_up) {
        doctor_fine(out, "%s is this host's own address, on %s", d->address,
                    w->name);
        return;
    }
    doctor_wrong(out, "%s is down, which has %s", w->name, d->address);
    doctor_mend(out, "sudo ip link set %s up", w->name);
    doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "the interface is down");
}

/* A sensor behind a router of its own network. */
static bool is_routed(const struct doctor *d, struct way *way)
{
    return way_find(d->sensor.address, d->ctl->options.interface, way) &&
           way->exists && way->has_gateway && !way->is_default;
}

static void look_for_subnet(struct doctor *d, const struct view *view,
                            struct doctor_finding *out)
{
    struct way way;
    char gateway[16];
    const struct way_interface *w = find_subnet(d, view);
    if (w != NULL && w->is_loopback) {
        d->is_local = true;
    }
    if (w != NULL) {
        say_subnet(d, w, out);
    } else if (is_routed(d, &way)) {
        doctor_note(out,
                    "no interface is in the sensor's subnet; %s leads there by "
                    "the gateway %s",
                    way.interface, number_format_address(way.gateway, gateway));
    } else {
        say_no_subnet(d, view, out);
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE,
                    "no interface in the sensor's subnet");
    }
}

void doctor_check_interface(struct doctor *d, struct doctor_finding *out)
{
    struct view view = {.count = 0};
    char names[NAMES_SIZE];
    view.count = way_interfaces(view.all, WAY_INTERFACES_MAX);
    if (view.count == 0) {
        doctor_unseen(out, "not looked at: the kernel does not list them");
        return;
    }
    if (!names_an_interface(d, &view)) {
        list_names(&view, names);
        doctor_wrong(out, "there is no interface %s; this host has %s",
                     d->ctl->options.interface, names);
        doctor_mend(out, "ip -br addr    # then --interface NAME");
        doctor_lack(d, DOCTOR_NEEDS_INTERFACE, "no such interface");
        return;
    }
    const struct way_interface *own = find_own(d, &view);
    if (own != NULL) {
        say_own(d, own, out);
    } else {
        look_for_subnet(d, &view, out);
    }
}

static void say_no_route(struct doctor *d, int error,
                         struct doctor_finding *out)
{
    doctor_wrong(out, "no route to %s: %s", d->address, strerror(error));
    doctor_mend(out,
                "ip route get %s; ip route; ip rule    # take the rule "
                "out that forbids it",
                d->address);
    doctor_lack(d, DOCTOR_NEEDS_ROUTE, "no route");
}

/* The kernel would send it past the interface in the sensor's subnet. */
static void say_astray(struct doctor *d, const struct way *way,
                       const struct way_interface *w,
                       struct doctor_finding *out)
{
    char gateway[16];
    char source[16];
    doctor_wrong(
        out, "%s goes out by %s%s%s, and not by %s in its subnet", d->address,
        way->interface, way->has_gateway ? " to the gateway " : "",
        way->has_gateway ? number_format_address(way->gateway, gateway) : "",
        w->name);
    doctor_mend(out, "sudo ip route replace %s/32 dev %s src %s", d->address,
                w->name, number_format_address(w->address, source));
    doctor_lack(d, DOCTOR_NEEDS_ROUTE, "the route leads elsewhere");
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
    struct view view = {.count = 0};
    struct way way;
    char address[16];
    view.count = way_interfaces(view.all, WAY_INTERFACES_MAX);
    const struct way_interface *w = find_subnet(d, &view);
    if (!way_find(d->sensor.address, d->ctl->options.interface, &way)) {
        doctor_unseen(out,
                      "not looked at: the kernel does not tell its routes");
        return;
    }
    if (!way.exists) {
        say_no_route(d, way.error, out);
        return;
    }
    if (w != NULL && !way.is_local &&
        (way.has_gateway || strcmp(way.interface, w->name) != 0)) {
        say_astray(d, &way, w, out);
        return;
    }
    keep_way(d, &way);
    doctor_fine(out, "%s goes out by %s%s%s", d->address, way.interface,
                way.has_gateway ? " to the gateway " : ", directly",
                way.has_gateway ? number_format_address(way.gateway, address)
                                : "");
    if (way.source != 0) {
        doctor_add(out, ", from %s",
                   number_format_address(way.source, address));
    }
}

static enum arp_state look_up(const struct doctor *d, char mac[MAC_BYTES])
{
    FILE *f = fopen("/proc/net/arp", "re");
    if (f == NULL) {
        return ARP_UNKNOWN;
    }
    const enum arp_state state = facts_arp(f, d->next_hop, d->interface, mac);
    (void)fclose(f);
    return state;
}

/* Sends something, and looks until an answer or the kernel's word is there. */
static enum knock_answer probe(struct doctor *d, char mac[MAC_BYTES],
                               enum arp_state *state)
{
    const int64_t deadline = lum_time_monotonic_ns() + ARP_NS;
    struct knock knock = {-1};
    enum knock_answer answer =
        knock_begin(&knock, d->sensor, d->ctl->options.interface);
    *state = look_up(d, mac);
    while (answer == KNOCK_SILENCE && *state != ARP_COMPLETE &&
           lum_time_monotonic_ns() < deadline && !doctor_is_cancelled(d)) {
        doctor_keep_alive(d);
        answer = knock_hear(&knock, ARP_LOOK);
        *state = look_up(d, mac);
    }
    if (answer == KNOCK_SILENCE) {
        answer = knock_hear(&knock, 2 * ARP_LOOK);
    }
    knock_end(&knock);
    return answer;
}

static void say_nobody(struct doctor *d, struct doctor_finding *out)
{
    char hop[16];
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "nobody has the address");
    doctor_wrong(out,
                 "nobody on %s answers for %s: no power, another cable, or "
                 "another address",
                 d->interface, number_format_address(d->next_hop, hop));
    doctor_mend_elsewhere(d, out);
}

/* What leaves is refused to the sender by this host's own rules alone. */
static void say_denied(struct doctor *d, struct doctor_finding *out)
{
    doctor_wrong(out, "this host's own firewall forbids packets to %s",
                 d->address);
    doctor_mend(out, "sudo nft list ruleset | grep -nE 'hook out|drop|reject'"
                     "    # and take the rule out");
    doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "a firewall rule of this host");
}

void doctor_check_arp(struct doctor *d, struct doctor_finding *out)
{
    char mac[MAC_BYTES] = "";
    char hop[16];
    enum arp_state state = ARP_UNKNOWN;
    const enum knock_answer answer = probe(d, mac, &state);
    d->was_refused = answer == KNOCK_REFUSED;
    if (answer == KNOCK_DENIED) {
        say_denied(d, out);
    } else if (d->is_local) {
        doctor_fine(out, "not needed: %s is on this host", d->address);
    } else if (state == ARP_COMPLETE) {
        doctor_fine(out, "%s is at %s", number_format_address(d->next_hop, hop),
                    mac);
    } else if (answer == KNOCK_ANSWERED || answer == KNOCK_REFUSED) {
        doctor_fine(out, "%s answers, and needs no ARP on %s", d->address,
                    d->interface);
    } else if (state == ARP_INCOMPLETE || answer == KNOCK_UNREACHABLE) {
        say_nobody(d, out);
    } else {
        doctor_note(out, "the kernel has no word on %s", d->address);
    }
}

void doctor_check_mtu(struct doctor *d, struct doctor_finding *out)
{
    const unsigned mtu = way_mtu(d->interface);
    if (mtu == 0) {
        doctor_unseen(out, "not looked at: the kernel does not tell that of %s",
                      d->interface);
    } else if (mtu < MTU_MIN) {
        doctor_wrong(out,
                     "%s takes packets of %u bytes at most; the sensor's need "
                     "%u",
                     d->interface, mtu, MTU_MIN);
        doctor_mend(out, "sudo ip link set dev %s mtu %u", d->interface,
                    MTU_MIN);
    } else {
        doctor_fine(out, "%s takes packets of %u bytes", d->interface, mtu);
    }
}

void doctor_mend_watch(const struct doctor *d, struct doctor_finding *out,
                       const char *filter, const char *why)
{
    doctor_mend(out, "sudo tcpdump -ni %s '%s'    # %s",
                d->interface[0] != '\0' ? d->interface : "any", filter, why);
}

/* The kernel doubles what is asked for, for its own overhead. */
size_t doctor_buffer_payload(size_t granted)
{
    return granted / 2u;
}

void doctor_mend_buffer(struct doctor_finding *out)
{
    doctor_mend(out, "sudo sysctl -w net.core.rmem_max=%u",
                LUM_SOCKET_RECEIVE_BUFFER);
}
