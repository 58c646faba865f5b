/* Whether a device has the sensor's address, and only one. */
#define _POSIX_C_SOURCE 200809L

#include "doctor_host.h"

#include "../../common/number.h"
#include "doctor_facts.h"
#include "doctor_knock.h"
#include "doctor_neighbour.h"

/* A route to only the sensor takes nothing from the interface that has its
 * subnet. */
static void say_other(struct doctor *d, const struct host_interface *on,
                      struct doctor_finding *out)
{
    d->is_silent = false; /* the request went to the wrong place */
    doctor_wrong(out, "nobody on %s answers for %s, but a device on %s does",
                 d->route.interface, d->address, on->name);
    if (interfaces_subnet(on, d->sensor.address) != NULL) {
        host_fix_interface(d, on->name, out);
        return;
    }
    doctor_add(out, ", which has no address in its subnet");
    const uint32_t ours = host_address_beside(d, on);
    if (ours == 0) {
        host_say_full(d, on, out);
        return;
    }
    const struct number_address address = number_address(ours);
    doctor_fix(out,
               "sudo ip addr add %s/32 dev %s && sudo ip route add %s/32 dev "
               "%s src %s",
               address.text, on->name, d->address, on->name, address.text);
}

static void say_nobody(struct doctor *d, struct doctor_finding *out)
{
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "nobody has the address");
    doctor_wrong(out,
                 "nobody on %s answers for %s: no power, another cable, or "
                 "another address",
                 d->route.interface, number_address(d->next_hop).text);
    const struct host_interface *other =
        neighbours_search(d, d->route.interface);
    if (other != NULL) {
        say_other(d, other, out);
    } else {
        doctor_fix_elsewhere(d, out);
    }
}

static void say_two(struct doctor *d, const struct arp_answers *who,
                    struct doctor_finding *out)
{
    const struct number_address hop = number_address(d->next_hop);
    d->is_misled = true;
    doctor_wrong(out,
                 "%zu devices on %s answer for %s: %s; what is sent reaches "
                 "now one and now another (every sensor boots at 10.42.0.37)",
                 who->count, d->route.interface, hop.text,
                 neighbours_format(who).text);
    doctor_fix(out,
               "ip neigh show %s dev %s    # the one that is reached now; "
               "unplug all but one, and give that one another address",
               hop.text, d->route.interface);
}

/* What is on the network, beside what the kernel believes. */
static void add_wire(struct doctor *d, const struct arp_answers *who,
                     struct doctor_finding *out)
{
    if (who->count > 1) {
        say_two(d, who, out);
    } else if (!who->is_heard) {
        doctor_add(out, "; only root can see whether another device answers "
                        "for it, or has this host's address, too");
    }
}

/* If this host has the sensor's address, what it sends there never leaves the
 * host; the sensor may still be there. */
static void look_at_local(struct doctor *d, struct doctor_finding *out)
{
    struct arp_answers who;
    const struct host_interface *on = d->host.chosen != NULL &&
                                              d->host.chosen->is_loopback &&
                                              d->host.own[0] != '\0'
                                          ? neighbours_search(d, NULL)
                                          : d->host.chosen;
    if (on == NULL || !on->is_up ||
        !neighbours_hear(d, on, d->sensor.address, &who) || who.count == 0) {
        doctor_fine(out, "not needed: %s is on this host", d->address);
        return;
    }
    doctor_wrong(out,
                 "%s is this host's own address, and a device on %s has it, "
                 "too: %s; nothing that is sent there leaves this host",
                 d->address, on->name, neighbours_format(&who).text);
    doctor_fix(out, "sudo ip addr del %s", d->host.own);
}

/* What is sent goes to a device that does not have the address: an entry that
 * somebody made permanent, or one of a device that has gone. */
static bool say_misled(struct doctor *d, const struct arp_answers *who,
                       struct doctor_finding *out)
{
    char mac[MAC_BYTES] = "";
    const struct number_address hop = number_address(d->next_hop);
    struct arp_answers known = *who;
    if (who->count == 0 || who->count == ARP_ANSWERS_MAX ||
        neighbours_look_up(d->next_hop, d->route.interface, mac) !=
            ARP_COMPLETE) {
        return false;
    }
    arp_answers_add(&known, mac);
    if (known.count == who->count) {
        return false;
    }
    d->is_misled = true;
    doctor_wrong(out,
                 "this host's table says that %s is at %s, but %s answers for "
                 "it: what is sent does not reach it",
                 hop.text, mac, neighbours_format(who).text);
    doctor_fix(out, "sudo ip neigh del %s dev %s", hop.text,
               d->route.interface);
    return true;
}

/* The entry in the kernel's table may be of a device that has gone. */
static void say_neighbour(struct doctor *d, const char *mac, bool has_spoken,
                          struct doctor_finding *out)
{
    struct arp_answers who = {0};
    const struct host_interface *on =
        interfaces_find(d->host.all, d->host.count, d->route.interface);
    if (on != NULL) {
        (void)neighbours_hear(d, on, d->next_hop, &who);
    }
    if (who.is_heard && who.count == 0 && !has_spoken) {
        say_nobody(d, out);
        return;
    }
    if (say_misled(d, &who, out)) {
        return;
    }
    doctor_fine(out, "%s is at %s", number_address(d->next_hop).text, mac);
    add_wire(d, &who, out);
}

static void fix_own(struct doctor *d, const struct host_interface *on,
                    struct doctor_finding *out)
{
    const struct interface_address *at = NULL;
    const uint32_t beside = host_address_beside(d, on);
    if (beside == 0 || interfaces_owner(d->host.all, d->host.count,
                                        d->route.source, &at) == NULL) {
        host_say_full(d, on, out);
        return;
    }
    doctor_fix(out,
               "sudo ip addr add %s/%u dev %s && sudo ip addr del %s/%u dev "
               "%s    # or give the other one another address",
               number_address(beside).text, at->prefix, on->name,
               number_address(d->route.source).text, at->prefix, on->name);
}

/* What the sensor sends to this host's address goes now to this host and now
 * to another one with that address. */
static void look_at_own(struct doctor *d, struct doctor_finding *out)
{
    struct arp_answers who;
    const struct host_interface *on =
        interfaces_find(d->host.all, d->host.count, d->route.interface);
    if (on == NULL || d->route.source == 0) {
        return;
    }
    neighbours_rivals(d, on, d->route.source, &who);
    if (who.count == 0) {
        return;
    }
    d->is_misled = true;
    if (out->result == DOCTOR_WRONG) {
        doctor_add(out, "; and %s", neighbours_format(&who).text);
    } else {
        doctor_wrong(out, "%s", neighbours_format(&who).text);
        fix_own(d, on, out);
    }
    doctor_add(out,
               " on %s has this host's address %s, too: answers and data reach "
               "now this host and now that one",
               d->route.interface, number_address(d->route.source).text);
}

static void look_at_sensors(struct doctor *d, struct doctor_finding *out)
{
    char mac[MAC_BYTES] = "";
    enum arp_state state = ARP_UNKNOWN;
    const enum knock_answer answer =
        neighbours_probe(d, d->ctl->options.interface, d->next_hop,
                         d->route.interface, mac, &state);
    const bool has_spoken = answer == KNOCK_ANSWERED || answer == KNOCK_REFUSED;
    d->was_refused = answer == KNOCK_REFUSED;
    if (answer == KNOCK_DENIED) {
        doctor_unseen(out,
                      "not looked at: this host's own firewall forbids packets "
                      "to %s",
                      d->address);
        doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "a firewall rule of this host");
    } else if (d->is_local) {
        look_at_local(d, out);
    } else if (state == ARP_COMPLETE) {
        say_neighbour(d, mac, has_spoken, out);
    } else if (has_spoken) {
        doctor_fine(out, "%s answers, and needs no ARP on %s", d->address,
                    d->route.interface);
    } else if (state == ARP_INCOMPLETE || answer == KNOCK_UNREACHABLE) {
        say_nobody(d, out);
    } else {
        doctor_note(out, "the kernel has no entry for %s", d->address);
    }
}

void doctor_check_arp(struct doctor *d, struct doctor_finding *out)
{
    look_at_sensors(d, out);
    if (!d->is_local) {
        look_at_own(d, out);
    }
}
