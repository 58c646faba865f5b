/* Network interfaces of Windows, by their adapters. */
#include "interfaces.h"

#include "net/adapter.h"

#include <stdlib.h>
#include <string.h>

static bool is_ipv4(const IP_ADAPTER_UNICAST_ADDRESS *a)
{
    return a->Address.lpSockaddr->sa_family == AF_INET;
}

static struct interface_address describe_address(
    const IP_ADAPTER_UNICAST_ADDRESS *a)
{
    struct sockaddr_in in;
    struct interface_address out;
    memcpy(&in, a->Address.lpSockaddr, sizeof in);
    out.address = ntohl(in.sin_addr.s_addr);
    out.prefix = a->OnLinkPrefixLength;
    out.mask = out.prefix == 0 ? 0 : 0xffffffffu << (32u - out.prefix);
    return out;
}

static struct host_interface describe(const IP_ADAPTER_ADDRESSES *entry)
{
    struct host_interface out;
    memset(&out, 0, sizeof out);
    out.index = entry->IfIndex;
    lum_adapter_name(entry, out.name);
    out.is_up = entry->OperStatus == IfOperStatusUp;
    out.has_link = out.is_up;
    out.is_loopback = entry->IfType == IF_TYPE_SOFTWARE_LOOPBACK;
    out.is_ethernet = entry->IfType == IF_TYPE_ETHERNET_CSMACD;
    out.has_mac = entry->PhysicalAddressLength == INTERFACE_MAC_BYTES;
    if (out.has_mac) {
        memcpy(out.mac, entry->PhysicalAddress, sizeof out.mac);
    }
    return out;
}

static size_t count_addresses(const IP_ADAPTER_ADDRESSES *entry)
{
    size_t n = 0;
    for (const IP_ADAPTER_UNICAST_ADDRESS *a = entry->FirstUnicastAddress;
         a != NULL; a = a->Next) {
        n += is_ipv4(a) ? 1u : 0u;
    }
    return n;
}

static struct interface_address *add(const IP_ADAPTER_ADDRESSES *entry,
                                     struct host_interface *out,
                                     struct interface_address *addresses)
{
    *out = describe(entry);
    out->addresses = addresses;
    for (const IP_ADAPTER_UNICAST_ADDRESS *a = entry->FirstUnicastAddress;
         a != NULL; a = a->Next) {
        if (is_ipv4(a)) {
            *addresses = describe_address(a);
            addresses++;
            out->address_count++;
        }
    }
    return addresses;
}

static struct host_interface *collect(const IP_ADAPTER_ADDRESSES *all,
                                      size_t *count)
{
    size_t addresses = 0;
    for (const IP_ADAPTER_ADDRESSES *i = all; i != NULL; i = i->Next) {
        (*count)++;
        addresses += count_addresses(i);
    }
    struct host_interface *out =
        malloc(*count * sizeof *out +
               addresses * sizeof(struct interface_address) + 1u);
    if (out == NULL) {
        return NULL;
    }
    struct interface_address *next =
        (struct interface_address *)(void *)(out + *count);
    struct host_interface *to = out;
    for (const IP_ADAPTER_ADDRESSES *i = all; i != NULL; i = i->Next) {
        next = add(i, to, next);
        to++;
    }
    return out;
}

int interfaces_list(struct host_interface **out, size_t *count,
                    lum_error *error)
{
    unsigned long code = 0;
    IP_ADAPTER_ADDRESSES *all = lum_adapter_all(&code);
    *out = NULL;
    *count = 0;
    if (code == ERROR_NO_DATA) {
        return 0;
    }
    if (code != NO_ERROR) {
        return lum_error_set(
            error, "the system does not list its interfaces: code %lu", code);
    }
    *out = collect(all, count);
    free(all);
    if (*out == NULL) {
        *count = 0;
        return lum_error_set(error, "no memory for the list of interfaces");
    }
    return 0;
}
