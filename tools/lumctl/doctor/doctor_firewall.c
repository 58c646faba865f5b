/* Whether this Linux host drops what the sensor sends, or what the host sends
 * to the sensor; and, if the kernel may be asked, the rule that does it. */
#define _GNU_SOURCE

#include "doctor.h"
#include "doctor_capture.h"
#include "doctor_knock.h"
#include "doctor_legacy.h"
#include "doctor_program.h"
#include "doctor_trace.h"
#include "doctor_way.h"

#include "../session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRIES       6
#define WAIT_MS     200
#define TRACE_MS    150
#define READY_TRIES 20 /* checks whether the trace is ready, TRACE_MS each */
#define LOST_MAX    2  /* of TRIES packets, may get lost on the way */

/* What happened to requests to the sensor. */
struct fate {
    bool was_denied; /* the kernel refused to send */
    bool was_heard;  /* an answer came */
    bool may_look;
    bool was_seen; /* an answer came in by the interface */
};

struct experiment {
    struct knock knock;
    int capture;         /* -1: none */
    struct trace *trace; /* NULL: none */
    struct fate fate;
};

/* --- Asking programs --- */

static bool is_over(const struct experiment *e)
{
    const struct trace_reader *r =
        e->trace != NULL ? trace_follow(e->trace, TRACE_MS) : NULL;
    return r == NULL ? e->fate.was_heard
                     : trace_dropped(r) != NULL ||
                           (e->fate.was_heard && trace_saw(r, false));
}

/* What is seen at the interface but not received is dropped in between. A
 * request or an answer may get lost, so this is repeated. */
static void run(struct doctor *d, struct experiment *e)
{
    for (int i = 0; i < TRIES && !is_over(e) && !doctor_is_cancelled(d); i++) {
        doctor_keep_alive(d);
        const enum knock_answer sent = knock_send(&e->knock);
        e->fate.was_denied = e->fate.was_denied || sent == KNOCK_DENIED;
        if (sent != KNOCK_SILENCE) {
            continue;
        }
        const enum knock_answer heard = knock_hear(&e->knock, WAIT_MS);
        e->fate.was_heard = e->fate.was_heard || heard == KNOCK_ANSWERED;
        e->fate.was_seen =
            e->fate.was_seen || (e->capture >= 0 && capture_saw(e->capture, 0));
    }
}

/* --- A rule that drops --- */

/* "lumctl --host 10.42.0.37 --interface eth0 doctor" */
static void fix_by_trace(const struct doctor *d, struct doctor_finding *out)
{
    doctor_fix(out, "sudo %s doctor --trace    # names the rule",
               session_ctl(d->ctl, d->sensor).text);
}

static bool is_builtin(const char *chain)
{
    static const char *const names[] = {"PREROUTING", "INPUT", "OUTPUT",
                                        "POSTROUTING"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(chain, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* A rule that lets the sensor's packets through. It is the first in the chain
 * that drops them, and is made by the program that manages this chain. */
static void fix_rule(const struct doctor *d, const struct trace_way *way,
                     struct doctor_finding *out)
{
    const unsigned port = d->sensor.port;
    if (strcmp(way->table, "firewalld") == 0) {
        doctor_fix(out, "sudo firewall-cmd --zone=trusted --add-source=%s",
                   d->address);
    } else if (way->has_ufw) {
        doctor_fix(out,
                   way->is_out ? "sudo ufw allow out proto udp to %s "
                                 "port %u"
                               : "sudo ufw allow proto udp from %s port "
                                 "%u",
                   d->address, port);
    } else if (strcmp(way->family, "ip") == 0 && is_builtin(way->base)) {
        doctor_fix(out,
                   "sudo iptables-nft -t %s -I %s %s %s -p udp --%s %u -j "
                   "ACCEPT",
                   way->table, way->chain, way->is_out ? "-d" : "-s",
                   d->address, way->is_out ? "dport" : "sport", port);
    } else {
        doctor_fix(out,
                   "sudo nft insert rule %s %s %s ip %s %s udp %s %u "
                   "accept",
                   way->family, way->table, way->chain,
                   way->is_out ? "daddr" : "saddr", d->address,
                   way->is_out ? "dport" : "sport", port);
    }
}

static void say_rule(const struct doctor *d, const struct trace_way *way,
                     struct doctor_finding *out)
{
    const char *direction = way->is_out ? "to" : "from";
    if (way->rule[0] == '\0') {
        doctor_wrong(
            out, "the policy of chain %s (table %s %s) drops packets %s %s",
            way->chain, way->family, way->table, direction, d->address);
    } else {
        doctor_wrong(out,
                     "a rule of chain %s (table %s %s) drops packets %s %s: %s",
                     way->chain, way->family, way->table, direction, d->address,
                     way->rule);
    }
    fix_rule(d, way, out);
}

static unsigned read_filter(const char *interface)
{
    char path[96];
    unsigned value = 0;
    (void)snprintf(path, sizeof path, "/proc/sys/net/ipv4/conf/%s/rp_filter",
                   interface);
    FILE *f = fopen(path, "re");
    char text[16] = "";
    if (f != NULL) {
        value = fgets(text, sizeof text, f) != NULL
                    ? (unsigned)strtoul(text, NULL, 10)
                    : 0;
        (void)fclose(f);
    }
    return value;
}

/* --- Filtered datagrams, and rules of iptables-legacy --- */

/* This is not a rule: a strict kernel takes a packet only from the interface by
 * which it would send to the sender. Of two settings the greater one is used; 2
 * is loose. */
static bool is_filtered(const struct doctor *d)
{
    struct way way;
    const unsigned here = read_filter(d->route.interface);
    const unsigned all = read_filter("all");
    return (here > all ? here : all) == 1u &&
           way_find(d->sensor.address, NULL, &way) && way.exists &&
           strcmp(way.interface, d->route.interface) != 0;
}

static void say_filtered(const struct doctor *d, struct doctor_finding *out)
{
    doctor_wrong(out,
                 "answers of %s come in by %s and are dropped by this host's "
                 "reverse path filter, since its own route leads elsewhere",
                 d->address, d->route.interface);
    doctor_fix(out, "sudo sysctl -w net/ipv4/conf/%s/rp_filter=2",
               d->route.interface);
}

/* Rules of iptables-legacy are not traced. */
static bool has_legacy_rules(void)
{
    char name[32];
    FILE *f = fopen("/proc/net/ip_tables_names", "re");
    const bool has = f != NULL && fgets(name, sizeof name, f) != NULL;
    if (f != NULL) {
        (void)fclose(f);
    }
    return has;
}

static bool read_legacy(struct legacy_rules *out)
{
    static char *const save[] = {"iptables-legacy-save", "-c", NULL};
    struct program p = program_none();
    FILE *text = tmpfile();
    const bool is_read =
        text != NULL && program_start(&p, save) && program_read(&p, text);
    program_end(&p);
    if (is_read) {
        rewind(text);
        legacy_read(text, out);
    }
    if (text != NULL) {
        (void)fclose(text);
    }
    return is_read && out->count > 0;
}

/* They count the packets that they drop, including ours. */
static const struct legacy_rule *find_legacy(struct doctor *d,
                                             const struct experiment *e,
                                             struct legacy_rules lists[2])
{
    struct knock knock = e->knock;
    if (!read_legacy(&lists[0])) {
        return NULL;
    }
    for (int i = 0; i < TRIES; i++) {
        doctor_keep_alive(d);
        (void)knock_send(&knock);
        (void)knock_hear(&knock, TRACE_MS);
    }
    return read_legacy(&lists[1])
               ? legacy_grown(&lists[0], &lists[1], TRIES - LOST_MAX)
               : NULL;
}

static void say_legacy(struct doctor *d, const struct experiment *e,
                       struct doctor_finding *out)
{
    const bool is_out = e->fate.was_denied;
    struct legacy_rules *lists = calloc(2, sizeof *lists);
    const struct legacy_rule *rule =
        lists != NULL ? find_legacy(d, e, lists) : NULL;
    if (rule != NULL) {
        doctor_wrong(out,
                     "%s of chain %s (iptables-legacy, table %s) drops packets "
                     "%s %s%s%s",
                     rule->text[0] != '\0' ? "a rule" : "the policy",
                     rule->chain, rule->table, is_out ? "to" : "from",
                     d->address, rule->text[0] != '\0' ? ": " : "", rule->text);
        doctor_fix(out,
                   "sudo iptables-legacy -t %s -I %s %s %s -p udp --%s %u -j "
                   "ACCEPT",
                   rule->table, rule->chain, is_out ? "-d" : "-s", d->address,
                   is_out ? "dport" : "sport", (unsigned)d->sensor.port);
    } else {
        doctor_fix(out, "sudo iptables-legacy-save -c | grep -E "
                        "'^[*]|DROP|REJECT'    # whose count grows?");
    }
    free(lists);
}

/* --- A packet that is traced --- */

static void end_trace(struct experiment *e)
{
    trace_stop(e->trace);
    e->trace = NULL;
}

static void say_dropped(struct doctor *d, struct experiment *e,
                        struct doctor_finding *out)
{
    if (e->fate.was_denied) {
        doctor_wrong(out,
                     "this host refuses to send packets to %s: a rule of "
                     "its firewall",
                     d->address);
    } else {
        doctor_wrong(out,
                     "answers of %s come in by %s, and this host drops them: "
                     "a rule of its firewall",
                     d->address, d->route.interface);
    }
    if (e->trace == NULL) {
        fix_by_trace(d, out);
    } else if (has_legacy_rules()) {
        end_trace(e); /* which gives no information about them */
        say_legacy(d, e, out);
    } else {
        doctor_add(out, ", though no rule of nftables does");
        doctor_fix_watch(d, out, "udp",
                         "what else looks at packets here: "
                         "bpftool net, an agent?");
    }
}

static void say_unseen(const struct doctor *d, const struct fate *fate,
                       struct doctor_finding *out)
{
    if (fate->may_look) {
        doctor_unseen(out,
                      "not looked at: no answer of %s comes in by %s that "
                      "could be dropped",
                      d->address, d->route.interface);
    } else {
        doctor_unseen(out, "not looked at: no answer was heard, and only root "
                           "can see whether one comes in and is dropped; "
                           "sudo lumctl doctor");
    }
}

static void conclude(struct doctor *d, struct experiment *e,
                     struct doctor_finding *out)
{
    const struct trace_way *way =
        e->trace != NULL ? trace_dropped(trace_follow(e->trace, 0)) : NULL;
    if (way != NULL) {
        say_rule(d, way, out);
    } else if (e->fate.was_heard) {
        doctor_fine(out, "requests to %s and its answers pass%s", d->address,
                    e->trace != NULL ? ", as the kernel's trace shows" : "");
    } else if (e->fate.was_seen && is_filtered(d)) {
        say_filtered(d, out);
    } else if (e->fate.was_denied || e->fate.was_seen) {
        say_dropped(d, e, out);
    } else {
        say_unseen(d, &e->fate, out);
    }
}

static bool begin_trace(struct doctor *d, struct experiment *e,
                        lum_error *error)
{
    int ready = trace_start(d->route.interface, d->sensor, e->knock.port,
                            &e->trace, error);
    for (int i = 0; i < READY_TRIES && ready == 0 && !doctor_is_cancelled(d);
         i++) {
        doctor_keep_alive(d);
        ready = trace_ready(e->trace, TRACE_MS, error);
    }
    if (ready > 0) {
        return true;
    }
    end_trace(e);
    return false;
}

void doctor_check_firewall(struct doctor *d, struct doctor_finding *out)
{
    struct experiment e = {.capture = -1};
    lum_error error = {""};
    if (knock_open(&e.knock, d->sensor, d->ctl->options.interface) !=
        KNOCK_SILENCE) {
        doctor_unseen(out, "not looked at: no socket for it");
        knock_end(&e.knock);
        return;
    }
    if (d->ctl->options.trace && !begin_trace(d, &e, &error)) {
        doctor_wrong(out, "no trace: %s", error.text);
        knock_end(&e.knock);
        return;
    }
    e.capture = capture_open(d->route.interface, d->sensor, e.knock.port);
    e.fate.may_look = e.capture >= 0;
    run(d, &e);
    conclude(d, &e, out);
    if (e.capture >= 0) {
        (void)close(e.capture);
    }
    end_trace(&e);
    knock_end(&e.knock);
}
