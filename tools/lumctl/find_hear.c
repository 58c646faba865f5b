/* What arrives during a search: datagrams and ARP become findings, or answer
 * the questions asked. */
#include "find_search.h"

#include "beside.h"
#include "host_route.h"

#include "lum/base/time.h"
#include "lum/wire.h"

#include "net/route.h"

#include <stdio.h>
#include <string.h>

#define TAKE_MAX 64u /* of one interface in a step */

/* The range in which an address is asked on an interface; NULL: none. */
static const struct find_range *range_of(const struct search *s,
                                         const struct host_interface *on,
                                         uint32_t address, bool by_arp)
{
    for (size_t i = 0; i < s->plan->range_count && on != NULL; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        if (r->by_arp == by_arp && r->interface == on &&
            find_is_in(r, address)) {
            return r;
        }
    }
    return NULL;
}

/* The question to an address that is asked by UDP; NULL: it is not. */
static struct question *question_for(const struct search *s,
                                     const struct host_interface *on,
                                     uint32_t address)
{
    const struct find_range *r = range_of(s, on, address, false);
    return r != NULL ? &s->questions[s->index_of[r - s->plan->ranges] +
                                     (address - r->first)]
                     : NULL;
}

/* --- Answers of sensors --- */

static void recall_mac(const struct search *s, struct find_found *f)
{
    const struct question *q = question_for(s, f->interface, f->host.address);
    if (q != NULL && q->mac[0] != '\0') {
        find_note_mac(f, q->mac, false);
    }
}

/* Who answers is whom the kernel has asked. */
static void learn_mac(const struct search *s, struct find_found *f)
{
    char mac[INTERFACE_MAC_TEXT_BYTES];
    if (find_links_arp(&s->links, f->interface) != NULL &&
        host_route_neighbour(f->host.address, f->interface->name, mac)) {
        find_note_mac(f, mac, true);
    }
}

/* What a packet shows of its sender; FIND_HOWS: it has not our magic. */
static enum find_how how_of(const struct search *s, const uint8_t *bytes,
                            size_t len)
{
    uint8_t type = 0;
    const lum_result result = lum_header_decode(bytes, len, &type);
    if (result != LUM_OK) {
        return result == LUM_E_TYPE ? FIND_OTHER : FIND_HOWS;
    }
    return (type >= LUM_TYPE_SET_IP && type <= LUM_TYPE_HEARTBEAT) ||
                   type == s->ctl->layout.profile.data_packet_type
               ? FIND_SENDS
               : FIND_OTHER;
}

/* The question that a time stamp answers; NULL: none. */
static struct question *question_of(struct search *s, const uint8_t *bytes,
                                    size_t len, lum_timestamp *answer)
{
    if (s->total == 0 || lum_timestamp_decode(bytes, len, answer) != LUM_OK) {
        return NULL;
    }
    struct question *q =
        &s->questions[(answer->sequence - s->sequence) % s->total];
    return q->sent_ns != 0 ? q : NULL;
}

/* A packet without our magic is no finding. */
static void take_packet(struct search *s, const struct host_interface *on,
                        lum_endpoint from, const uint8_t *bytes, size_t len)
{
    lum_timestamp answer = {0, 0};
    const enum find_how how = how_of(s, bytes, len);
    struct question *q = question_of(s, bytes, len, &answer);
    struct find_found *f =
        how == FIND_HOWS ? NULL : find_entry(s->out, from, on);
    if (f == NULL) {
        return;
    }
    f->host = from;
    f->how = how > f->how ? how : f->how;
    recall_mac(s, f);
    if (q != NULL && f->how != FIND_ANSWERS) {
        f->how = FIND_ANSWERS;
        f->clock_us = answer.clock_us;
        f->round_trip_ns = q->sequence == answer.sequence
                               ? lum_time_monotonic_ns() - q->sent_ns
                               : 0;
        q->is_answered = true;
        learn_mac(s, f);
    }
}

/* Where a datagram came in that the routes led to its sender. */
static const struct host_interface *routed(const struct search *s,
                                           uint32_t address)
{
    char name[INTERFACE_NAME_BYTES];
    return lum_route_interface(address, name, sizeof name)
               ? interfaces_find(s->plan->interfaces, s->plan->interface_count,
                                 name)
               : NULL;
}

static enum exit_status take_datagrams(struct search *s, lum_socket *socket,
                                       const struct host_interface *of)
{
    lum_received *datagrams = NULL;
    lum_error error = {""};
    size_t count = 0;
    if (lum_socket_receive(socket, &datagrams, &count, &error) != LUM_NET_OK) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    for (size_t i = 0; i < count; i++) {
        const lum_received *d = &datagrams[i];
        take_packet(s, of != NULL ? of : routed(s, d->from.address), d->from,
                    d->bytes, d->len);
    }
    return EXIT_DONE;
}

/* --- Devices that were heard --- */

/* A device that has an address proposed for this host is not a finding: it was
 * asked only for that. */
static bool is_beside(struct search *s, const struct host_interface *on,
                      uint32_t address)
{
    for (size_t i = 0; i < s->out->beside_count; i++) {
        struct find_subnet_beside *b = &s->out->besides[i];
        if (b->interface == on && b->network == (address & BESIDE_MASK)) {
            find_note_taken(&b->taken, b->network, address);
            return (address & ~BESIDE_MASK) <= BESIDE_LAST;
        }
    }
    return false;
}

/* A device that is asked by UDP is not a finding because of its ARP. Two
 * devices of one address are, because one of them may be a sensor that no
 * packet reaches. */
static bool is_finding(struct search *s, const struct host_interface *on,
                       uint32_t address, const char *mac)
{
    struct question *q = question_for(s, on, address);
    if (q == NULL) {
        return interfaces_subnet(on, address) == NULL ||
               range_of(s, on, address, true) != NULL;
    }
    if (q->mac[0] != '\0' && strcmp(q->mac, mac) != 0) {
        return true;
    }
    (void)snprintf(q->mac, sizeof q->mac, "%s", mac);
    return false;
}

/* Returns false for a new device. */
static bool note_speaker(struct search *s, const struct host_interface *on,
                         uint32_t address, const char *mac)
{
    bool is_known = false;
    for (size_t i = 0; i < s->out->count; i++) {
        struct find_found *f = &s->out->found[i];
        if (f->host.address == address && f->interface == on) {
            find_note_mac(f, mac, false);
            is_known = true;
        }
    }
    return is_known;
}

static void take_speaker(struct search *s, const struct host_interface *on,
                         const struct arp_speaker *speaker)
{
    const uint32_t address = speaker->address;
    const lum_endpoint host = {address, s->ctl->options.host.port};
    char mac[INTERFACE_MAC_TEXT_BYTES];
    (void)interfaces_format_mac(speaker->mac, mac);
    if (note_speaker(s, on, address, mac) ||
        interfaces_owner(s->plan->interfaces, s->plan->interface_count, address,
                         NULL) != NULL ||
        is_beside(s, on, address) || !is_finding(s, on, address, mac)) {
        return;
    }
    struct find_found *f = find_entry(s->out, host, on);
    if (f != NULL) {
        recall_mac(s, f);
        find_note_mac(f, mac, false);
    }
}

static void take_arp(struct search *s, const struct listener *l)
{
    struct arp_speaker speaker;
    for (unsigned n = 0;
         n < TAKE_MAX && l->arp != NULL && arp_receive(l->arp, 0, &speaker);
         n++) {
        take_speaker(s, l->interface, &speaker);
    }
}

enum exit_status find_hear(struct search *s)
{
    const struct find_links *links = &s->links;
    for (size_t i = 0; i < links->socket_count; i++) {
        if (take_datagrams(s, links->sockets[i], links->of[i]) != EXIT_DONE) {
            return EXIT_FAILED;
        }
    }
    for (size_t i = 0; i < links->listener_count; i++) {
        take_arp(s, &links->listeners[i]);
    }
    return EXIT_DONE;
}
