/* The plan of a search: which interfaces and addresses will be asked, by the
 * options and this host's networks. */
#include "find.h"

#include "../common/number.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

#define BOOT_BITS 24u

char *find_leave_out(struct find_left_out *out)
{
    if (out->count < FIND_LEFT_OUT_MAX) {
        return out->texts[out->count++];
    }
    out->more++;
    return out->texts[FIND_LEFT_OUT_MAX];
}

static uint32_t mask_of(unsigned bits)
{
    return bits == 0 ? 0 : UINT32_MAX << (32u - bits);
}

bool find_parse_subnet(const char *text, struct find_subnet *out)
{
    char address[16];
    uint32_t network = 0;
    int64_t bits = 0;
    const size_t len = strcspn(text, "/");
    if (text[len] != '/' || len >= sizeof address ||
        !number_parse_int(text + len + 1, 0, 32, &bits)) {
        return false;
    }
    (void)memcpy(address, text, len);
    address[len] = '\0';
    if (!number_parse_address(address, &network)) {
        return false;
    }
    *out =
        (struct find_subnet){network & mask_of((unsigned)bits), (unsigned)bits};
    return true;
}

struct find_subnet_text find_show_subnet(const struct find_subnet *subnet)
{
    struct find_subnet_text out;
    (void)snprintf(out.text, sizeof out.text, "%s/%u",
                   number_address(subnet->network).text, subnet->bits);
    return out;
}

bool find_is_in(const struct find_range *range, uint32_t address)
{
    return address >= range->first && address <= range->last;
}

bool find_is_repeated(const struct find_plan *plan, size_t range,
                      uint32_t address)
{
    for (size_t i = 0; i < range; i++) {
        if (plan->ranges[i].is_askable &&
            find_is_in(&plan->ranges[i], address)) {
            return true;
        }
    }
    return false;
}

static bool has_range(const struct find_plan *plan,
                      const struct find_range *range)
{
    for (size_t i = 0; i < plan->range_count; i++) {
        const struct find_range *r = &plan->ranges[i];
        if (r->interface == range->interface && r->first == range->first &&
            r->last == range->last && r->by_arp == range->by_arp) {
            return true;
        }
    }
    return false;
}

static void add_range(struct find_plan *plan, const struct find_range *range)
{
    if (has_range(plan, range)) {
        return;
    }
    if (plan->range_count == FIND_RANGES_MAX) {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s%s%s was not searched: more than %u subnets; name "
                       "one by --interface or --subnet",
                       find_show_subnet(&range->subnet).text,
                       range->interface != NULL ? " on " : "",
                       range->interface != NULL ? range->interface->name : "",
                       FIND_RANGES_MAX);
        return;
    }
    plan->ranges[plan->range_count++] = *range;
}

/* All addresses that a device can have. */
static void add_subnet(struct find_plan *plan,
                       const struct host_interface *interface,
                       struct find_subnet subnet, bool by_arp)
{
    const uint32_t top = subnet.network | ~mask_of(subnet.bits);
    const uint32_t ends = subnet.bits < 31u ? 1u : 0u;
    const struct find_range range = {.interface = interface,
                                     .subnet = subnet,
                                     .first = subnet.network + ends,
                                     .last = top - ends,
                                     .by_arp = by_arp};
    add_range(plan, &range);
}

static bool is_boot_in(const struct find_subnet *subnet)
{
    return (LUM_BOOT_ADDRESS & mask_of(subnet->bits)) == subnet->network;
}

/* Subnets of an interface, no wider than is asked at once. */
static void add_own(struct find_plan *plan,
                    const struct host_interface *interface,
                    const struct interface_address *own)
{
    const struct find_subnet whole = {own->address & own->mask, own->prefix};
    struct find_subnet part = whole;
    if (own->prefix == 32u) {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s has a /32: nobody else is in that subnet",
                       interface->name);
        return;
    }
    if (own->prefix < FIND_BITS_MIN) {
        part.bits = FIND_BITS_MIN;
        part.network = own->address & mask_of(FIND_BITS_MIN);
        (void)snprintf(
            find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
            "of %s on %s only %s was searched, around this host's "
            "own address%s; --subnet searches another part",
            find_show_subnet(&whole).text, interface->name,
            find_show_subnet(&part).text,
            is_boot_in(&whole) && !is_boot_in(&part) ? ", and 10.42.0.37" : "");
    }
    add_subnet(plan, interface, part, false);
    if (is_boot_in(&whole) && !is_boot_in(&part)) {
        const struct find_subnet boot = {LUM_BOOT_ADDRESS, 32};
        add_subnet(plan, interface, boot, false);
    }
}

/* Where sensors are as a rule, though the host has no address there. */
static void add_boot(struct find_plan *plan,
                     const struct host_interface *interface)
{
    const struct find_subnet subnet = {LUM_BOOT_ADDRESS & mask_of(BOOT_BITS),
                                       BOOT_BITS};
    add_subnet(plan, interface, subnet, true);
}

void find_add_name(char names[FIND_NAMES_BYTES], const char *name)
{
    const size_t n = strlen(names);
    const size_t room = FIND_NAMES_BYTES - n;
    const bool fits = strlen(name) + sizeof ", , ..." <= room;
    if (fits || n == 0) {
        (void)snprintf(names + n, room, "%s%.*s", n != 0 ? ", " : "",
                       (int)(FIND_NAMES_BYTES - sizeof ", ..."), name);
    } else if (names[n - 1] != '.') {
        (void)snprintf(names + n, room, ", ...");
    }
}

/* Interfaces of one fate, by name. */
struct names {
    char text[FIND_NAMES_BYTES];
    size_t count;
};

/* Why an interface that should be searched cannot be. */
struct lacks {
    struct names down;
    struct names no_link;
};

static bool is_usable(const struct host_interface *i, struct lacks *lacks)
{
    if (!i->is_up) {
        find_add_name(lacks->down.text, i->name);
        lacks->down.count++;
    } else if (!i->has_link) {
        find_add_name(lacks->no_link.text, i->name);
        lacks->no_link.count++;
    }
    return i->is_up && i->has_link;
}

static void tell_lacks(struct find_plan *plan, const struct lacks *lacks)
{
    const struct names *down = &lacks->down;
    const struct names *no_link = &lacks->no_link;
    if (down->count > 0) {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s: down, and not searched: ip link set %s up",
                       down->text, down->count == 1 ? down->text : "NAME");
    }
    if (no_link->count > 0) {
        (void)snprintf(find_leave_out(&plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s: no link, and not searched: look at its cable and "
                       "at the power of what is at its other end",
                       no_link->text);
    }
}

static void search_own(struct find_plan *plan, const struct host_interface *i)
{
    for (size_t k = 0; k < i->address_count; k++) {
        add_own(plan, i, &i->addresses[k]);
    }
    if (i->has_mac && !i->is_loopback &&
        interfaces_subnet(i, LUM_BOOT_ADDRESS) == NULL) {
        add_boot(plan, i);
    }
}

static void search_all(struct find_plan *plan, const char *name,
                       struct lacks *lacks)
{
    for (size_t k = 0; k < plan->interface_count; k++) {
        const struct host_interface *i = &plan->interfaces[k];
        const bool is_wanted =
            name != NULL ? strcmp(i->name, name) == 0 : !i->is_loopback;
        if (is_wanted && is_usable(i, lacks)) {
            search_own(plan, i);
        }
    }
}

/* By UDP on each interface with an address in the subnet. */
static bool search_inside(struct find_plan *plan, const char *name,
                          const struct find_subnet *subnet, struct lacks *lacks)
{
    bool has_any = false;
    for (size_t k = 0; k < plan->interface_count; k++) {
        const struct host_interface *i = &plan->interfaces[k];
        if ((name == NULL || strcmp(i->name, name) == 0) &&
            interfaces_subnet(i, subnet->network) != NULL &&
            is_usable(i, lacks)) {
            add_subnet(plan, i, *subnet, false);
            has_any = true;
        }
    }
    return has_any;
}

/* No interface has an address in the subnet: a router may lead there, or it is
 * on the wire all the same. */
static void search_outside(struct find_plan *plan, const char *name,
                           const struct find_subnet *subnet,
                           struct lacks *lacks)
{
    if (name == NULL) {
        add_subnet(plan, NULL, *subnet, false);
    }
    for (size_t k = 0; k < plan->interface_count; k++) {
        const struct host_interface *i = &plan->interfaces[k];
        const bool is_named = name != NULL && strcmp(i->name, name) == 0;
        if ((is_named || (name == NULL && i->is_up && i->has_link)) &&
            i->has_mac && !i->is_loopback &&
            interfaces_subnet(i, subnet->network) == NULL &&
            is_usable(i, lacks)) {
            add_subnet(plan, i, *subnet, true);
        }
    }
}

void find_make_plan(struct find_plan *plan, const char *name,
                    const struct find_subnet *subnet)
{
    struct lacks lacks = {.down = {.text = ""}, .no_link = {.text = ""}};
    if (subnet == NULL) {
        search_all(plan, name, &lacks);
    } else if (!search_inside(plan, name, subnet, &lacks)) {
        search_outside(plan, name, subnet, &lacks);
    }
    tell_lacks(plan, &lacks);
}
