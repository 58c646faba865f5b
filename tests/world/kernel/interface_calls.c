#define _GNU_SOURCE
#include "net_internal.h"
#include "socket_calls.h"
#include "task.h"
#include "time.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if_arp.h>
#include <netpacket/packet.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>

#define CALL_NS WORLD_US
#define LIST_NS (20 * WORLD_US)

static const world_host *here(void)
{
    return world_process_self()->host;
}

static unsigned flags_of(const world_interface *interface)
{
    const bool is_loopback = world_interface_is_loopback(interface);
    unsigned flags = is_loopback ? IFF_LOOPBACK : IFF_BROADCAST | IFF_MULTICAST;
    if (interface->is_up) {
        flags |= IFF_UP;
        flags |= interface->has_carrier ? IFF_RUNNING | 1u << 16 : 0;
    }
    return flags; /* 1 << 16: IFF_LOWER_UP */
}

static struct sockaddr_in internet(uint32_t address)
{
    struct sockaddr_in in;
    memset(&in, 0, sizeof in);
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(address);
    return in;
}

/* --- the list of all --- */

/* An entry and what it points to, in one block with the others. */
typedef struct entry {
    struct ifaddrs list;
    char name[IFNAMSIZ];
    struct sockaddr_in address, mask, broadcast;
    struct sockaddr_ll link;
} entry;

static size_t count_entries(const world_host *host)
{
    size_t n = 0;
    for (const world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        n += 1u + i->address_count;
    }
    return n;
}

static void name_entry(entry *e, const world_interface *interface)
{
    memset(e, 0, sizeof *e);
    (void)snprintf(e->name, sizeof e->name, "%s", interface->name);
    e->list.ifa_name = e->name;
    e->list.ifa_flags = flags_of(interface);
}

static void put_link(entry *e, const world_interface *interface)
{
    name_entry(e, interface);
    e->link.sll_family = AF_PACKET;
    e->link.sll_ifindex = (int)interface->index;
    e->link.sll_hatype =
        world_interface_is_loopback(interface) ? ARPHRD_LOOPBACK : ARPHRD_ETHER;
    e->link.sll_halen = sizeof interface->mac;
    memcpy(e->link.sll_addr, interface->mac, sizeof interface->mac);
    e->list.ifa_addr = (struct sockaddr *)&e->link;
}

static void put_address(entry *e, const world_interface *interface,
                        const world_address *address)
{
    const uint32_t mask = world_mask(address->prefix);
    name_entry(e, interface);
    e->address = internet(address->address);
    e->mask = internet(mask);
    e->broadcast = internet(world_interface_is_loopback(interface)
                                ? address->address
                                : address->address | ~mask);
    e->list.ifa_addr = (struct sockaddr *)&e->address;
    e->list.ifa_netmask = (struct sockaddr *)&e->mask;
    e->list.ifa_broadaddr = (struct sockaddr *)&e->broadcast;
}

/* First the links of all, then their addresses, as glibc lists them. */
static size_t put_all(const world_host *host, entry *entries)
{
    size_t n = 0;
    for (const world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        put_link(&entries[n++], i);
    }
    for (const world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        for (size_t k = 0; k < i->address_count; k++) {
            put_address(&entries[n++], i, &i->addresses[k]);
        }
    }
    return n;
}

int world_call_getifaddrs(struct ifaddrs **out)
{
    world_call(LIST_NS);
    const world_host *host = here();
    entry *entries = world_malloc(count_entries(host) * sizeof *entries);
    if (entries == NULL) {
        errno = ENOMEM;
        return -1;
    }
    const size_t n = put_all(host, entries);
    for (size_t i = 0; i + 1u < n; i++) {
        entries[i].list.ifa_next = &entries[i + 1u].list;
    }
    *out = &entries[0].list;
    return 0;
}

void world_call_freeifaddrs(struct ifaddrs *list)
{
    world_free(list);
}

/* --- names and numbers --- */

unsigned world_call_if_nametoindex(const char *name)
{
    world_call(CALL_NS);
    const world_interface *found = world_interface_find(here(), name);
    if (found == NULL) {
        errno = ENODEV;
        return 0;
    }
    return found->index;
}

char *world_call_if_indextoname(unsigned index, char *out)
{
    world_call(CALL_NS);
    const world_interface *found = world_interface_by_index(here(), index);
    if (found == NULL) {
        errno = ENXIO;
        return NULL;
    }
    (void)snprintf(out, IFNAMSIZ, "%s", found->name);
    return out;
}

struct if_nameindex *world_call_if_nameindex(void)
{
    world_call(LIST_NS);
    const world_interface *first = world_interface_first(here());
    size_t count = 0;
    for (const world_interface *i = first; i != NULL; i = i->next) {
        count++;
    }
    struct if_nameindex *out =
        world_malloc((count + 1u) * sizeof *out + count * IFNAMSIZ);
    if (out == NULL) {
        errno = ENOBUFS;
        return NULL;
    }
    char *names = (char *)(out + count + 1u);
    size_t n = 0;
    for (const world_interface *i = first; i != NULL; i = i->next) {
        out[n] = (struct if_nameindex){i->index, names + n * IFNAMSIZ};
        (void)snprintf(out[n].if_name, IFNAMSIZ, "%s", i->name);
        n++;
    }
    out[n] = (struct if_nameindex){0, NULL};
    return out;
}

void world_call_if_freenameindex(struct if_nameindex *list)
{
    world_free(list);
}

/* --- ioctl of sockets --- */

static int refuse(int code)
{
    errno = code;
    return -1;
}

static bool put_in(struct sockaddr *out, const world_interface *interface,
                   bool is_mask)
{
    if (interface->address_count == 0) {
        return false;
    }
    const world_address *first = &interface->addresses[0];
    const struct sockaddr_in in =
        internet(is_mask ? world_mask(first->prefix) : first->address);
    memcpy(out, &in, sizeof in);
    return true;
}

static int tell(const world_interface *interface, unsigned long request,
                struct ifreq *out)
{
    switch (request) {
    case SIOCGIFINDEX:
        out->ifr_ifindex = (int)interface->index;
        return 0;
    case SIOCGIFMTU:
        out->ifr_mtu = (int)interface->mtu;
        return 0;
    case SIOCGIFFLAGS:
        out->ifr_flags = (short)flags_of(interface);
        return 0;
    case SIOCGIFADDR:
    case SIOCGIFNETMASK:
        return put_in(&out->ifr_addr, interface, request == SIOCGIFNETMASK)
                   ? 0
                   : refuse(EADDRNOTAVAIL);
    case SIOCGIFHWADDR:
        memset(&out->ifr_hwaddr, 0, sizeof out->ifr_hwaddr);
        out->ifr_hwaddr.sa_family = world_interface_is_loopback(interface)
                                        ? ARPHRD_LOOPBACK
                                        : ARPHRD_ETHER;
        memcpy(out->ifr_hwaddr.sa_data, interface->mac, sizeof interface->mac);
        return 0;
    default:
        return refuse(ENOTTY);
    }
}

int world_socket_ioctl(const world_host *host, unsigned long request,
                       void *argument)
{
    char name[IFNAMSIZ + 1] = "";
    if (request < SIOCGIFNAME || request > SIOCGIFINDEX) {
        return refuse(ENOTTY);
    }
    memcpy(name, argument, IFNAMSIZ);
    const world_interface *interface = world_interface_find(host, name);
    return interface != NULL ? tell(interface, request, argument)
                             : refuse(ENODEV);
}
