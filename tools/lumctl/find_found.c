/* Who was found, and the command by which this host reaches them. */
#include "find.h"

#include "../common/number.h"
#include "beside.h"

#include <stdio.h>
#include <string.h>

/* --- Who was seen --- */

struct find_found *find_entry(struct find_result *r, lum_endpoint host,
                              const struct host_interface *interface)
{
    for (size_t i = 0; i < r->count; i++) {
        struct find_found *f = &r->found[i];
        const bool is_port = f->host.port == host.port || f->how == FIND_ARP;
        if (f->host.address == host.address && is_port &&
            f->interface == interface) {
            return f;
        }
    }
    if (r->count == FIND_FOUND_MAX) {
        r->is_full = true;
        return NULL;
    }
    r->found[r->count] = (struct find_found){
        .how = FIND_ARP, .host = host, .interface = interface};
    return &r->found[r->count++];
}

void find_note_mac(struct find_found *f, const char *mac, bool is_sensor)
{
    if (f->mac[0] != '\0' && strcmp(f->mac, mac) != 0) {
        (void)snprintf(f->other_mac, sizeof f->other_mac, "%s",
                       is_sensor ? f->mac : mac);
        if (!is_sensor) {
            return;
        }
    }
    f->is_mac_of_sensor |= is_sensor;
    (void)snprintf(f->mac, sizeof f->mac, "%s", mac);
}

/* --- How to reach them --- */

/* Another interface of this host has an address in the subnet. */
static bool is_elsewhere(const struct find_plan *plan,
                         const struct find_found *found)
{
    for (size_t i = 0; i < plan->interface_count; i++) {
        const struct host_interface *other = &plan->interfaces[i];
        if (other != found->interface && other->is_up &&
            interfaces_subnet(other, found->host.address) != NULL) {
            return true;
        }
    }
    return false;
}

/* Somebody has the same address at another interface. */
static bool has_twin(const struct find_result *result,
                     const struct find_found *found)
{
    for (size_t i = 0; i < result->count; i++) {
        const struct find_found *other = &result->found[i];
        if (other->host.address == found->host.address &&
            other->interface != found->interface) {
            return true;
        }
    }
    return false;
}

static bool is_out_of_reach(const struct find_found *found)
{
    return found->interface != NULL && found->how != FIND_ANSWERS &&
           interfaces_subnet(found->interface, found->host.address) == NULL;
}

bool find_needs_address(const struct find_plan *plan,
                        const struct find_found *found)
{
    return is_out_of_reach(found) && !is_elsewhere(plan, found);
}

static struct find_subnet_beside *look_up(struct find_result *result,
                                          const struct find_found *found)
{
    for (size_t i = 0; i < result->beside_count; i++) {
        struct find_subnet_beside *b = &result->besides[i];
        if (b->interface == found->interface &&
            b->network == (found->host.address & BESIDE_MASK)) {
            return b;
        }
    }
    return NULL;
}

void find_note_taken(uint32_t *taken, uint32_t network, uint32_t address)
{
    const uint32_t last = address & ~BESIDE_MASK;
    if ((address & BESIDE_MASK) == network && last <= BESIDE_LAST) {
        *taken |= UINT32_C(1) << last;
    }
}

void find_plan_besides(const struct find_plan *plan, struct find_result *result)
{
    result->beside_count = 0;
    for (size_t i = 0; i < result->count; i++) {
        const struct find_found *f = &result->found[i];
        if (find_needs_address(plan, f) &&
            result->beside_count < FIND_BESIDES_MAX &&
            look_up(result, f) == NULL) {
            result->besides[result->beside_count++] =
                (struct find_subnet_beside){
                    f->interface, f->host.address & BESIDE_MASK, 0, false};
        }
    }
}

struct wish {
    const struct find_plan *plan;
    uint32_t taken;
};

static bool is_taken(void *context, uint32_t address)
{
    const struct wish *w = context;
    return (w->taken >> (address & ~BESIDE_MASK) & 1u) != 0 ||
           interfaces_owner(w->plan->interfaces, w->plan->interface_count,
                            address, NULL) != NULL;
}

/* All that was seen of the subnet, on whichever interface. */
static uint32_t taken_in(const struct find_result *result, uint32_t network)
{
    uint32_t taken = 0;
    for (size_t i = 0; i < result->count; i++) {
        const struct find_found *f = &result->found[i];
        find_note_taken(&taken, network, f->host.address);
    }
    for (size_t i = 0; i < result->beside_count; i++) {
        const struct find_subnet_beside *b = &result->besides[i];
        taken |= b->network == network ? b->taken : 0;
    }
    return taken;
}

/* One that nobody has as far as was asked; 0: none, or not all are known. */
static uint32_t free_address(const struct find_plan *plan,
                             struct find_result *result,
                             const struct find_found *found)
{
    const struct find_subnet_beside *b = look_up(result, found);
    struct wish wish = {plan, 0};
    if (b == NULL || !b->is_asked || result->is_full) {
        return 0;
    }
    wish.taken = taken_in(result, b->network);
    return beside_find(found->host.address, is_taken, &wish);
}

struct find_reach find_reach(const struct find_plan *plan,
                             struct find_result *result,
                             const struct find_found *found)
{
    struct find_reach out = {""};
    if (find_needs_address(plan, found)) {
        const uint32_t free = free_address(plan, result, found);
        if (free != 0) {
            (void)snprintf(out.text, sizeof out.text,
                           "ip addr add %s/24 dev %s",
                           number_address(free).text, found->interface->name);
        }
    } else if (is_out_of_reach(found) && !has_twin(result, found)) {
        (void)snprintf(out.text, sizeof out.text, "ip route add %s/32 dev %s",
                       number_address(found->host.address).text,
                       found->interface->name);
    }
    return out;
}
