#define _POSIX_C_SOURCE 200809L

#include "doctor_neighbour.h"

#include "../../common/arp.h"
#include "doctor_facts.h"
#include "doctor_knock.h"

#include "base/text.h"
#include "lum/base/time.h"

#include <poll.h>
#include <stdio.h>
#include <string.h>

#define MS_NS    INT64_C(1000000)
#define WAIT_NS  (1500 * MS_NS)
#define AGAIN_NS (150 * MS_NS) /* between questions */
#define MORE_NS  (400 * MS_NS) /* after the first answer */
#define LOOK_MS  50

#define SEARCH_MAX 32u /* interfaces */

static int64_t earlier(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

bool neighbours_hear(struct doctor *d, const struct host_interface *on,
                     uint32_t address, struct arp_answers *out)
{
    const struct arp_patience patience = {WAIT_NS, AGAIN_NS, MORE_NS,
                                          session_goes_on, d->ctl};
    return arp_answers_hear(on, address, &patience, out);
}

static bool is_ours(const struct doctor *d, const char *mac)
{
    for (size_t i = 0; i < d->host.count; i++) {
        char own[INTERFACE_MAC_TEXT_BYTES];
        if (d->host.all[i].has_mac &&
            strcmp(interfaces_format_mac(d->host.all[i].mac, own), mac) == 0) {
            return true;
        }
    }
    return false;
}

void neighbours_rivals(struct doctor *d, const struct host_interface *on,
                       uint32_t own, struct arp_answers *out)
{
    const struct arp_patience patience = {MORE_NS, AGAIN_NS, AGAIN_NS,
                                          session_goes_on, d->ctl};
    struct arp_answers who = {0};
    *out = who;
    (void)arp_answers_hear(on, own, &patience, &who);
    for (size_t i = 0; i < who.count; i++) {
        if (!is_ours(d, who.macs[i])) {
            arp_answers_add(out, who.macs[i]);
        }
    }
}

/* Questions on many interfaces at once. */
struct search {
    size_t count;
    struct pollfd waits[SEARCH_MAX];
    struct arp *arps[SEARCH_MAX];
    const struct host_interface *on[SEARCH_MAX];
};

static void open_all(const struct doctor *d, const char *but, struct search *s)
{
    s->count = 0;
    for (size_t i = 0; i < d->host.count && s->count < SEARCH_MAX; i++) {
        const struct host_interface *w = &d->host.all[i];
        if (w->is_up && w->has_link &&
            (but == NULL || strcmp(but, w->name) != 0) &&
            arp_open(w, &s->arps[s->count], NULL) == ARP_OPENED) {
            s->on[s->count] = w;
            s->waits[s->count] = (struct pollfd){
                .fd = arp_descriptor(s->arps[s->count]), .events = POLLIN};
            s->count++;
        }
    }
}

/* Waits for any of them, until a time. */
static const struct host_interface *hear_any(struct search *s, uint32_t address,
                                             int64_t until_ns)
{
    const int64_t left = until_ns - lum_time_monotonic_ns();
    if (left <= 0 ||
        poll(s->waits, (nfds_t)s->count, (int)(left / MS_NS) + 1) <= 0) {
        return NULL;
    }
    for (size_t i = 0; i < s->count; i++) {
        struct arp_speaker who;
        while (s->waits[i].revents != 0 && arp_receive(s->arps[i], 0, &who)) {
            if (who.address == address) {
                return s->on[i];
            }
        }
    }
    return NULL;
}

const struct host_interface *neighbours_search(struct doctor *d,
                                               const char *but)
{
    struct search s;
    const struct host_interface *found = NULL;
    const uint32_t address = d->sensor.address;
    int64_t now = lum_time_monotonic_ns();
    const int64_t end = now + WAIT_NS;
    int64_t next = now;
    open_all(d, but, &s);
    while (s.count > 0 && found == NULL && now < end &&
           !lum_cancel_is_raised(d->ctl->cancel)) {
        if (now >= next) {
            session_keep_alive(d->ctl);
            for (size_t i = 0; i < s.count; i++) {
                (void)arp_ask(s.arps[i], address, NULL);
            }
            next = now + AGAIN_NS;
        }
        found = hear_any(&s, address, earlier(next, end));
        now = lum_time_monotonic_ns();
    }
    for (size_t i = 0; i < s.count; i++) {
        arp_close(s.arps[i]);
    }
    return found;
}

enum arp_state neighbours_look_up(uint32_t address, const char *interface,
                                  char mac[MAC_BYTES])
{
    FILE *f = fopen("/proc/net/arp", "re");
    if (f == NULL) {
        return ARP_UNKNOWN;
    }
    const enum arp_state state = facts_arp(f, address, interface, mac);
    (void)fclose(f);
    return state;
}

enum knock_answer neighbours_probe(struct doctor *d, const char *by,
                                   uint32_t hop, const char *on,
                                   char mac[MAC_BYTES], enum arp_state *state)
{
    const int64_t end = lum_time_monotonic_ns() + WAIT_NS;
    struct knock knock;
    enum knock_answer answer = knock_begin(&knock, d->sensor, by);
    *state = neighbours_look_up(hop, on, mac);
    while (answer == KNOCK_SILENCE && *state != ARP_COMPLETE &&
           lum_time_monotonic_ns() < end &&
           !lum_cancel_is_raised(d->ctl->cancel)) {
        session_keep_alive(d->ctl);
        answer = knock_hear(&knock, LOOK_MS);
        *state = neighbours_look_up(hop, on, mac);
    }
    if (answer == KNOCK_SILENCE) {
        answer = knock_hear(&knock, 2 * LOOK_MS);
    }
    knock_end(&knock);
    return answer;
}

void neighbours_find(struct doctor *d, const struct host_interface *on,
                     struct arp_answers *out)
{
    const uint32_t address = d->sensor.address;
    char mac[MAC_BYTES] = "";
    enum arp_state state = ARP_UNKNOWN;
    if (neighbours_hear(d, on, address, out)) {
        return;
    }
    (void)neighbours_probe(d, on->name, address, on->name, mac, &state);
    if (state == ARP_COMPLETE) {
        arp_answers_add(out, mac);
    }
}

struct neighbours_text neighbours_format(const struct arp_answers *all)
{
    struct neighbours_text out = {""};
    for (size_t i = 0; i < all->count; i++) {
        lum_text_list(out.text, sizeof out.text, " and ", all->macs[i]);
    }
    return out;
}
