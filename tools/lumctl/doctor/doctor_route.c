/* The way of packets from a Linux host to the sensor: whether the kernel's
 * route leads out by the interface in its subnet, and the MTU there. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../../common/number.h"
#include "doctor_way.h"

#include <stdio.h>
#include <string.h>

#define MTU_MIN 1500u

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

/* --interface changes nothing on this host. A route must be set if another
 * route leads to a gateway even on the right interface. */
static void fix_astray(const struct doctor *d, struct doctor_finding *out)
{
    struct way there;
    const char *name = d->host.chosen->name;
    if (way_find(d->sensor.address, name, &there) && there.exists &&
        !there.has_gateway) {
        host_fix_interface(d, name, out);
    } else {
        doctor_fix(out, "sudo ip route replace %s/32 dev %s src %s", d->address,
                   name, number_address(d->host.address).text);
    }
}

/* The kernel does not send by the interface in the sensor's subnet. This is
 * wrong only if the sensor is seen there. */
static void say_astray(struct doctor *d, const struct way *way,
                       struct doctor_finding *out)
{
    doctor_wrong(out, "%s goes out by %s%s%s, and not by %s in its subnet",
                 d->address, way->interface,
                 way->has_gateway ? " to the gateway " : "",
                 way->has_gateway ? number_address(way->gateway).text : "",
                 d->host.chosen->name);
    if (host_spare(d, out)) {
        return;
    }
    if (host_answers(d)) {
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
    (void)snprintf(d->route.interface, sizeof d->route.interface, "%s",
                   way->interface);
    d->is_local = d->is_local || way->is_local;
    d->route.source = way->source;
    d->route.next_hop = way->has_gateway ? way->gateway : d->sensor.address;
}

void doctor_check_route(struct doctor *d, struct doctor_finding *out)
{
    struct way way;
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
    if (d->host.chosen != NULL && !d->is_local &&
        (way.has_gateway || strcmp(way.interface, d->host.chosen->name) != 0)) {
        say_astray(d, &way, out);
        return;
    }
    doctor_fine(out, "%s goes out by %s%s%s", d->address, way.interface,
                way.has_gateway ? " to the gateway " : ", directly",
                way.has_gateway ? number_address(way.gateway).text : "");
    if (way.source != 0) {
        doctor_add(out, ", from %s", number_address(way.source).text);
    }
}

void doctor_check_mtu(struct doctor *d, struct doctor_finding *out)
{
    const unsigned mtu = way_mtu(d->route.interface);
    if (mtu == 0) {
        doctor_unseen(out, "not looked at: the kernel does not tell that of %s",
                      d->route.interface);
    } else if (mtu < MTU_MIN) {
        doctor_wrong(out,
                     "%s takes packets of %u bytes at most; the sensor's need "
                     "%u",
                     d->route.interface, mtu, MTU_MIN);
        doctor_fix(out, "sudo ip link set dev %s mtu %u", d->route.interface,
                   MTU_MIN);
    } else {
        doctor_fine(out, "%s takes packets of %u bytes", d->route.interface,
                    mtu);
    }
}
