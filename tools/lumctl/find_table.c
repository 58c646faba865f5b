#include "find.h"

#include <string.h>

static struct find_found *look_up(struct find_result *r, lum_endpoint host,
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
    return NULL;
}

static size_t find_lost(const struct find_result *r, uint32_t address)
{
    size_t i = 0;
    while (i < r->lost_count && r->lost[i] != address) {
        i++;
    }
    return i;
}

static void lose(struct find_result *r, uint32_t address)
{
    if (find_lost(r, address) < r->lost_count) {
        return;
    }
    if (r->lost_count < FIND_LOST_MAX) {
        r->lost[r->lost_count++] = address;
    } else {
        r->has_lost_more = true;
    }
}

static void regain(struct find_result *r, uint32_t address)
{
    const size_t at = find_lost(r, address);
    if (at < r->lost_count) {
        r->lost[at] = r->lost[--r->lost_count];
    }
}

/* The least sure entry gives way to one that is surer. */
static struct find_found *make_room(struct find_result *r, enum find_how how)
{
    struct find_found *least = &r->found[0];
    for (size_t i = 1; i < r->count; i++) {
        least = r->found[i].how < least->how ? &r->found[i] : least;
    }
    if (least->how >= how) {
        return NULL;
    }
    lose(r, least->host.address);
    return least;
}

struct find_found *find_entry(struct find_result *r, lum_endpoint host,
                              const struct host_interface *interface,
                              enum find_how how)
{
    struct find_found *f = look_up(r, host, interface);
    if (f != NULL) {
        return f;
    }
    f = r->count < FIND_FOUND_MAX ? &r->found[r->count++] : make_room(r, how);
    if (f == NULL) {
        lose(r, host.address);
        return NULL;
    }
    regain(r, host.address);
    *f = (struct find_found){
        .how = FIND_ARP, .host = host, .interface = interface};
    return f;
}

void find_note_mac(struct find_found *f, const uint8_t mac[INTERFACE_MAC_BYTES],
                   bool is_sensor)
{
    if (f->has_mac && memcmp(f->mac, mac, INTERFACE_MAC_BYTES) != 0) {
        f->has_other_mac = true;
        if (!is_sensor) {
            (void)memcpy(f->other_mac, mac, INTERFACE_MAC_BYTES);
            return;
        }
        (void)memcpy(f->other_mac, f->mac, INTERFACE_MAC_BYTES);
    }
    f->has_mac = true;
    f->is_mac_of_sensor |= is_sensor;
    (void)memcpy(f->mac, mac, INTERFACE_MAC_BYTES);
}
