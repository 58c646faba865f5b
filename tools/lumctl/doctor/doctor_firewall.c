/* Whether this Linux host drops what the sensor sends, or what the host sends
 * to the sensor. */
#define _GNU_SOURCE

#include "doctor.h"

#include "doctor_knock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRIES   6
#define WAIT_MS 200

/* What happened to requests to the sensor. */
struct fate {
    bool was_denied; /* the kernel refused to send */
    bool was_heard;  /* an answer came */
    bool may_look;
    bool was_seen; /* an answer came in by the interface */
};

/* What is seen at the interface but not received is dropped in between. A
 * request or an answer may get lost, so this is repeated. */
static void run(struct doctor *d, struct knock *knock, int capture,
                struct fate *fate)
{
    for (int i = 0;
         i < TRIES && !fate->was_heard && !lum_cancel_is_raised(d->ctl->cancel);
         i++) {
        session_keep_alive(d->ctl);
        const enum knock_answer sent = knock_send(knock);
        fate->was_denied = fate->was_denied || sent == KNOCK_DENIED;
        if (sent != KNOCK_SILENCE) {
            continue;
        }
        fate->was_heard = knock_hear(knock, WAIT_MS) == KNOCK_ANSWERED;
        fate->was_seen =
            fate->was_seen || (capture >= 0 && capture_saw(capture));
    }
}

static unsigned read_filter(const char *interface)
{
    char path[INTERFACE_NAME_BYTES + 40];
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

/* This is not a rule: a strict kernel takes a packet only from the interface by
 * which it would send to the sender. Of two settings the greater one is used; 2
 * is loose. */
static bool is_filtered(const struct doctor *d)
{
    const unsigned here = read_filter(d->route.interface);
    const unsigned all = read_filter("all");
    const struct host_route route = host_route_find(d->sensor.address, NULL);
    return (here > all ? here : all) == 1u && route.exists &&
           strcmp(route.interface, d->route.interface) != 0;
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

static void say_dropped(const struct doctor *d, const struct fate *fate,
                        struct doctor_finding *out)
{
    if (fate->was_denied) {
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
    doctor_fix_rules(d, out);
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

static void conclude(struct doctor *d, const struct fate *fate,
                     struct doctor_finding *out)
{
    if (fate->was_heard) {
        doctor_fine(out, "requests to %s and its answers pass", d->address);
    } else if (fate->was_seen && is_filtered(d)) {
        say_filtered(d, out);
    } else if (fate->was_denied || fate->was_seen) {
        say_dropped(d, fate, out);
    } else {
        say_unseen(d, fate, out);
    }
}

void doctor_check_firewall(struct doctor *d, struct doctor_finding *out)
{
    struct knock knock;
    if (knock_open(&knock, d->sensor, d->ctl->options.interface) !=
        KNOCK_SILENCE) {
        doctor_unseen(out, "not looked at: no socket for it");
        knock_end(&knock);
        return;
    }
    const int capture = capture_open(d->route.interface, d->sensor, knock.port);
    struct fate fate = {.may_look = capture >= 0};
    run(d, &knock, capture, &fate);
    conclude(d, &fate, out);
    (void)capture_end(capture);
    knock_end(&knock);
}
