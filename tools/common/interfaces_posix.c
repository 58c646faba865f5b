/* Network interfaces by getifaddrs(), and what Linux says of their links. */
#define _DEFAULT_SOURCE /* getifaddrs */
#define _DARWIN_C_SOURCE

#include "interfaces.h"

#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#if defined(__linux__)
#include <net/if_arp.h>
#include <netpacket/packet.h>
#endif

/* Room for all: no interface and no address has more than one entry. */
struct block {
    struct host_interface *interfaces;
    size_t count;
    struct interface_address *addresses;
    size_t address_count;
};

/* Labels of further addresses may have ":1" after the interface's name. */
static size_t name_len(const struct ifaddrs *entry)
{
    return strcspn(entry->ifa_name, ":");
}

static bool is_of(const struct ifaddrs *entry, const struct host_interface *i)
{
    const size_t len = name_len(entry);
    return strlen(i->name) == len &&
           strncmp(entry->ifa_name, i->name, len) == 0;
}

static struct host_interface *find(const struct block *block,
                                   const struct ifaddrs *entry)
{
    for (size_t i = 0; i < block->count; i++) {
        if (is_of(entry, &block->interfaces[i])) {
            return &block->interfaces[i];
        }
    }
    return NULL;
}

/* What the system says of the link. Wireless is known by the names that every
 * distribution gives. */
static void note_link(const struct ifaddrs *entry, struct host_interface *out)
{
#if defined(__linux__)
    struct sockaddr_ll link;
    if (entry->ifa_addr == NULL || entry->ifa_addr->sa_family != AF_PACKET) {
        return;
    }
    memcpy(&link, entry->ifa_addr, sizeof link);
    if (link.sll_hatype == ARPHRD_ETHER &&
        link.sll_halen == INTERFACE_MAC_BYTES) {
        out->is_ethernet = strncmp(out->name, "wl", 2) != 0;
        out->has_mac = true;
        memcpy(out->mac, link.sll_addr, sizeof out->mac);
    }
#else
    (void)entry;
    (void)out;
#endif
}

static void add_interface(struct block *block, const struct ifaddrs *entry)
{
    struct host_interface *out = find(block, entry);
    if (out == NULL) {
        out = &block->interfaces[block->count];
        block->count++;
        memset(out, 0, sizeof *out);
        (void)snprintf(out->name, sizeof out->name, "%.*s",
                       (int)name_len(entry), entry->ifa_name);
        out->index = if_nametoindex(out->name);
        out->is_up = (entry->ifa_flags & IFF_UP) != 0;
        out->has_link = (entry->ifa_flags & IFF_RUNNING) != 0;
        out->is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
    }
    note_link(entry, out);
}

static uint32_t address_of(const struct sockaddr *address)
{
    struct sockaddr_in in;
    if (address == NULL) {
        return 0;
    }
    memcpy(&in, address, sizeof in);
    return ntohl(in.sin_addr.s_addr);
}

/* An interface's addresses must be neighbours. */
static void add_addresses(struct block *block, const struct ifaddrs *list,
                          struct host_interface *to)
{
    to->addresses = &block->addresses[block->address_count];
    for (const struct ifaddrs *i = list; i != NULL; i = i->ifa_next) {
        if (i->ifa_addr == NULL || i->ifa_addr->sa_family != AF_INET ||
            !is_of(i, to)) {
            continue;
        }
        struct interface_address *a = &block->addresses[block->address_count];
        a->address = address_of(i->ifa_addr);
        a->mask = address_of(i->ifa_netmask);
        a->prefix = interfaces_mask_bits(a->mask);
        block->address_count++;
        to->address_count++;
    }
}

static bool make_block(const struct ifaddrs *list, struct block *out)
{
    size_t n = 0;
    for (const struct ifaddrs *i = list; i != NULL; i = i->ifa_next) {
        n++;
    }
    *out = (struct block){NULL, 0, NULL, 0};
    out->interfaces =
        n > 0 ? malloc(n * sizeof *out->interfaces + n * sizeof *out->addresses)
              : NULL;
    if (out->interfaces == NULL) {
        return n == 0;
    }
    out->addresses = (struct interface_address *)(void *)(out->interfaces + n);
    for (const struct ifaddrs *i = list; i != NULL; i = i->ifa_next) {
        add_interface(out, i);
    }
    for (size_t i = 0; i < out->count; i++) {
        add_addresses(out, list, &out->interfaces[i]);
    }
    return true;
}

int interfaces_list(struct host_interface **out, size_t *count,
                    lum_error *error)
{
    struct ifaddrs *list = NULL;
    struct block block;
    *out = NULL;
    *count = 0;
    if (getifaddrs(&list) != 0) {
        return lum_error_set(error,
                             "the system does not list its interfaces: %s",
                             strerror(errno));
    }
    const bool is_made = make_block(list, &block);
    freeifaddrs(list);
    if (!is_made) {
        return lum_error_set(error, "no memory for the list of interfaces");
    }
    *out = block.interfaces;
    *count = block.count;
    return 0;
}
