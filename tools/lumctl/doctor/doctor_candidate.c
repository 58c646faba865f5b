/* Which interface of a Linux host may lead to the sensor: those in its subnet,
 * the best of them by what answers there, else the likeliest. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../beside.h"
#include "doctor_knock.h"
#include "doctor_neighbour.h"

#include <string.h>

/* --- Interfaces in the sensor's subnet --- */

static bool is_usable(const struct host_interface *i)
{
    return i->is_up && i->has_link;
}

size_t host_candidates(const struct doctor *d,
                       struct candidate out[CANDIDATES_MAX])
{
    size_t n = 0;
    for (size_t i = 0; i < d->host.count && n < CANDIDATES_MAX; i++) {
        const struct host_interface *w = &d->host.all[i];
        const struct interface_address *a =
            interfaces_subnet(w, d->sensor.address);
        if (a != NULL && is_usable(w) && host_is_asked_for(d, w)) {
            out[n] = (struct candidate){w, a, false, false};
            n++;
        }
    }
    return n;
}

static void look(struct doctor *d, struct candidate *c)
{
    struct arp_answers who;
    session_keep_alive(d->ctl);
    c->is_sensor = knock_reaches(d->sensor, c->interface->name);
    c->has_neighbour = c->is_sensor;
    if (!c->is_sensor) {
        neighbours_find(d, c->interface, &who);
        c->has_neighbour = who.count > 0;
    }
}

/* An interface that the kernel would not choose must be better, not just as
 * good. */
static int rank(const struct candidate *c, const struct host_route *route)
{
    return (c->is_sensor ? 4 : 0) + (c->has_neighbour ? 2 : 0) +
           (route->exists && strcmp(route->interface, c->interface->name) == 0
                ? 1
                : 0);
}

struct candidate *host_choose(struct doctor *d, struct candidate *all, size_t n)
{
    struct candidate *best = &all[0];
    if (n == 1) {
        return best;
    }
    const struct host_route route =
        host_route_find(d->sensor.address, d->ctl->options.interface);
    for (size_t i = 0; i < n; i++) {
        look(d, &all[i]);
        if (rank(&all[i], &route) > rank(best, &route)) {
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

const struct interface_address *host_near(const struct doctor *d,
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
    if (d->ctl->options.interface != NULL || host_near(d, w) != NULL) {
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
    for (size_t i = 0; i < d->host.count; i++) {
        const int here = likelihood(d, &d->host.all[i]);
        if (here > 0 && (best == NULL || here > likelihood(d, best))) {
            best = &d->host.all[i];
        }
    }
    return best;
}

const struct host_interface *host_likeliest(struct doctor *d)
{
    const struct host_interface *found = neighbours_search(d, NULL);
    return found != NULL && host_is_asked_for(d, found) ? found : likeliest(d);
}

const struct host_interface *host_elsewhere(struct doctor *d)
{
    const char *only = d->ctl->options.interface;
    if (only == NULL) {
        return NULL;
    }
    session_keep_alive(d->ctl);
    const struct host_route route = host_route_find(d->sensor.address, NULL);
    if (route.exists && strcmp(route.interface, only) != 0 &&
        knock_reaches(d->sensor, NULL)) {
        return interfaces_find(d->host.all, d->host.count, route.interface);
    }
    for (size_t i = 0; i < d->host.count; i++) {
        const struct host_interface *w = &d->host.all[i];
        session_keep_alive(d->ctl);
        if (is_usable(w) && !w->is_loopback && strcmp(w->name, only) != 0 &&
            interfaces_subnet(w, d->sensor.address) != NULL &&
            knock_reaches(d->sensor, w->name)) {
            return w;
        }
    }
    return neighbours_search(d, only);
}
