/* The way of packets from a Linux host to the sensor: whether the kernel's
 * route leads out by the interface in its subnet, and the MTU there. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../../common/number.h"

#include <stdio.h>
#include <string.h>

#define MTU_MIN 1500u

static void say_no_route(struct doctor *d, int error,
                         struct doctor_finding *out)
{
    doctor_wrong(out, "no route to %s: %s", d->address, strerror(error));
    doctor_fix(out,
               "ip route get %s; ip route; ip rule    # remove the rule that "
               "forbids it",
               d->address);
    doctor_lack(d, DOCTOR_NEEDS_ROUTE, "no route");
}

/* --interface changes nothing on this host. A route must be set if another
 * route leads to a gateway even on the right interface. */
static void fix_astray(const struct doctor *d, struct doctor_finding *out)
{
    const char *name = d->host.chosen->name;
    const struct host_route there = host_route_find(d->sensor.address, name);
    if (there.exists && !there.has_gateway) {
        host_fix_interface(d, name, out);
    } else {
        doctor_fix(out, "sudo ip route replace %s/32 dev %s src %s", d->address,
                   name, number_address(d->host.address).text);
    }
}

/* The kernel does not send by the interface in the sensor's subnet. This is
 * wrong only if the sensor is seen there. */
static void say_astray(struct doctor *d, const struct host_route *route,
                       struct doctor_finding *out)
{
    doctor_wrong(out, "%s goes out by %s%s%s, and not by %s in its subnet",
                 d->address, route->interface,
                 route->has_gateway ? " to the gateway " : "",
                 route->has_gateway ? number_address(route->gateway).text : "",
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

void doctor_check_route(struct doctor *d, struct doctor_finding *out)
{
    const struct host_route route =
        host_route_find(d->sensor.address, d->ctl->options.interface);
    if (!route.is_known) {
        doctor_unseen(out,
                      "not looked at: the kernel does not report its routes");
        return;
    }
    if (!route.exists) {
        say_no_route(d, route.error, out);
        return;
    }
    d->route = route;
    d->next_hop = route.has_gateway ? route.gateway : d->sensor.address;
    d->is_local = d->is_local || route.is_local;
    if (d->host.chosen != NULL && !d->is_local &&
        (route.has_gateway ||
         strcmp(route.interface, d->host.chosen->name) != 0)) {
        say_astray(d, &route, out);
        return;
    }
    doctor_fine(out, "%s goes out by %s%s%s", d->address, route.interface,
                route.has_gateway ? " to the gateway " : ", directly",
                route.has_gateway ? number_address(route.gateway).text : "");
    if (route.source != 0) {
        doctor_add(out, ", from %s", number_address(route.source).text);
    }
}

void doctor_check_mtu(struct doctor *d, struct doctor_finding *out)
{
    const unsigned mtu = host_route_mtu(d->route.interface);
    if (mtu == 0) {
        doctor_unseen(out,
                      "not looked at: the kernel does not report that of %s",
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
