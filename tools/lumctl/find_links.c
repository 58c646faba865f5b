/* Opens sockets and listeners, one of each for an interface of the plan.
 * Which interfaces those are: find_plan.c. */
#include "find_search.h"

#include <stdio.h>

size_t find_links_listener(const struct find_links *links,
                           const struct host_interface *interface)
{
    size_t i = 0;
    while (i < links->listener_count &&
           links->listeners[i].interface != interface) {
        i++;
    }
    return i;
}

struct arp *find_links_arp(const struct find_links *links,
                           const struct host_interface *interface)
{
    const size_t i = find_links_listener(links, interface);
    return i < links->listener_count ? links->listeners[i].arp : NULL;
}

static enum exit_status add_socket(struct find_links *links,
                                   struct find_plan *plan, size_t range)
{
    const struct host_interface *interface = plan->ranges[range].interface;
    const lum_socket_options options = {
        .struct_size = sizeof options,
        .interface_name = interface != NULL ? interface->name : NULL};
    lum_error error = {""};
    size_t at = 0;
    while (at < links->socket_count && links->of[at] != interface) {
        at++;
    }
    if (at == FIND_SOCKETS_MAX) {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s was not searched: more than %u interfaces; name it "
                       "by --interface",
                       interface->name, FIND_SOCKETS_MAX);
        return EXIT_DONE;
    }
    if (at == links->socket_count) {
        if (lum_socket_open(&options, &links->sockets[at], &error) !=
            LUM_NET_OK) {
            return ctl_complain(EXIT_FAILED, "%s", error.text);
        }
        links->of[at] = interface;
        links->socket_count++;
    }
    links->socket_of[range] = links->sockets[at];
    return EXIT_DONE;
}

/* Without the right to listen, all that is asked by UDP is asked all the same.
 */
static void add_listener(struct find_links *links,
                         const struct host_interface *interface)
{
    const size_t at = links->listener_count;
    if (interface == NULL || interface->is_loopback || at == FIND_SOCKETS_MAX ||
        find_links_listener(links, interface) < at) {
        return;
    }
    struct listener *l = &links->listeners[links->listener_count++];
    l->interface = interface;
    links->has_no_right |= arp_open(interface, &l->arp, NULL) == ARP_NO_RIGHT;
    links->has_arp |= l->arp != NULL;
}

/* Addresses that could only be asked by ARP, but cannot be. */
static void leave_out_arp(const struct find_links *links,
                          struct find_plan *plan)
{
    char names[FIND_NAMES_BYTES] = "";
    const struct host_interface *last = NULL;
    for (size_t i = 0; i < plan->range_count; i++) {
        const struct find_range *r = &plan->ranges[i];
        if (r->by_arp && r->interface != last && !r->is_askable) {
            find_add_name(names, r->interface->name);
            last = r->interface;
        }
    }
    if (names[0] != '\0') {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s: no address in a sensor's subnet, and not asked by "
                       "ARP%s",
                       names,
                       links->has_no_right
                           ? ", which needs root: run 'sudo lumctl find'"
                           : ", which this system does not allow");
    }
}

enum exit_status find_links_open(struct find_links *links,
                                 struct find_plan *plan)
{
    for (size_t i = 0; i < plan->range_count; i++) {
        struct find_range *r = &plan->ranges[i];
        add_listener(links, r->interface);
        if (!r->by_arp && add_socket(links, plan, i) != EXIT_DONE) {
            return EXIT_FAILED;
        }
        r->is_askable = r->by_arp ? find_links_arp(links, r->interface) != NULL
                                  : links->socket_of[i] != NULL;
    }
    leave_out_arp(links, plan);
    return EXIT_DONE;
}

void find_links_close(struct find_links *links)
{
    for (size_t i = 0; i < links->socket_count; i++) {
        lum_socket_close(links->sockets[i]);
    }
    for (size_t i = 0; i < links->listener_count; i++) {
        arp_close(links->listeners[i].arp);
    }
}
