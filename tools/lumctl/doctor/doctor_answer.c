/* Whether the sensor answers requests; if not, how its answers go astray, and
 * if so, whether another host is at work with it. */
#include "doctor.h"
#include "doctor_knock.h"

#include "lum/base/time.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <stdio.h>

#define MS_NS     INT64_C(1000000)
#define SLOT_NS   (100 * MS_NS)
#define LATE_NS   (3000 * MS_NS) /* for answers that nobody waits for */
#define SLOW_NS   (250 * MS_NS)  /* no sensor beside this host needs it */
#define REST_NS   (300 * MS_NS)
#define LET_GO_NS (LUM_HEARTBEAT_TIMEOUT_MS * MS_NS + REST_NS)

/* --- No answer --- */

void doctor_fix_watch_while(const struct doctor *d, struct doctor_finding *out,
                            const char *filter, const char *command,
                            const char *question)
{
    char what[SESSION_CTL_BYTES + 80];
    (void)snprintf(what, sizeof what, "while %s %s runs: %s",
                   session_ctl(d->ctl, d->sensor).text, command, question);
    doctor_fix_watch(d, out, filter, what);
}

/* It answers, but from another place than the request went to. */
static void say_other_port(struct doctor *d, uint16_t port,
                           struct doctor_finding *out)
{
    char filter[48];
    doctor_lack(d, DOCTOR_NEEDS_ANSWER, "answers come from another port");
    doctor_wrong(out,
                 "%s answers from port %u to what is sent to its port %u, so "
                 "its answers are ignored: a device on the way rewrites ports",
                 d->address, (unsigned)port, (unsigned)d->sensor.port);
    session_keep_alive(d->ctl);
    const lum_endpoint there = {d->sensor.address, port};
    if (knock_reaches(there, d->ctl->options.interface)) {
        doctor_fix(out, "%s doctor", session_ctl(d->ctl, there).text);
    } else {
        (void)snprintf(filter, sizeof filter, "udp and host %s", d->address);
        doctor_fix_watch(d, out, filter,
                         "remove the router or container that does it");
    }
}

static bool has_dropped(const struct doctor *d)
{
    lum_sensor_counters counters = {.struct_size = sizeof counters};
    lum_sensor_count(d->session.handle, &counters);
    return counters.answers_dropped > 0;
}

/* Answers that came in time and were none to these requests, or came after they
 * were given up. */
static bool say_misfit(struct doctor *d, int64_t begin_ns,
                       struct doctor_finding *out)
{
    const struct request_options *o = &d->ctl->options.requests;
    const bool is_other = has_dropped(d);
    int64_t now = lum_time_monotonic_ns();
    const int64_t end = now + LATE_NS;
    while (!has_dropped(d) && now < end &&
           doctor_rest_until(d, now + SLOT_NS)) {
        now = lum_time_monotonic_ns();
    }
    if (!has_dropped(d)) {
        return false;
    }
    const unsigned ms = (unsigned)((now - begin_ns) / MS_NS);
    doctor_lack(d, DOCTOR_NEEDS_ANSWER,
                is_other ? "answers have another sequence number"
                         : "answers come too late");
    if (is_other) {
        doctor_wrong(out,
                     "%s answers with another sequence number than that of the "
                     "request, so its answers are ignored",
                     d->address);
        doctor_fix(out, "look for a proxy or a second device that answers in "
                        "its place, or for another firmware");
    } else {
        doctor_wrong(out,
                     "%s answers late, %u ms after the first of %u requests, "
                     "each of which is given up after %u ms",
                     d->address, ms, (unsigned)o->retries + 1u,
                     (unsigned)o->timeout_ms);
        doctor_fix(out,
                   "%s --timeout %u doctor    # --timeout with every command "
                   "of lumctl",
                   session_ctl(d->ctl, d->sensor).text,
                   (2u * ms + 99u) / 100u * 100u);
    }
    return true;
}

static void say_unanswered(struct doctor *d, int64_t begin_ns,
                           struct doctor_finding *out)
{
    char filter[32];
    if (say_misfit(d, begin_ns, out)) {
        return;
    }
    session_keep_alive(d->ctl);
    const uint16_t port =
        knock_other_port(d->sensor, d->ctl->options.interface);
    if (port != 0) {
        say_other_port(d, port, out);
        return;
    }
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_ANSWER, "the sensor does not answer");
    doctor_wrong(out, "no answer to %u timestamp requests to %s:%u",
                 (unsigned)d->ctl->options.requests.retries + 1u, d->address,
                 (unsigned)d->sensor.port);
    (void)snprintf(filter, sizeof filter, "udp port %u",
                   (unsigned)d->sensor.port);
    doctor_fix_watch_while(d, out, filter, "time --watch",
                           "do requests leave, do answers come?");
}

static void say_silent(struct doctor *d, int64_t begin_ns,
                       struct doctor_finding *out)
{
    if (!d->was_refused) {
        say_unanswered(d, begin_ns, out);
        return;
    }
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_ANSWER, "the sensor does not answer");
    doctor_wrong(out,
                 "%s is there, but nothing listens on its port %u: no sensor, "
                 "or one that has not started",
                 d->address, (unsigned)d->sensor.port);
    if (d->host.own[0] != '\0') {
        doctor_fix(out, "sudo ip addr del %s", d->host.own);
    } else if (d->is_local) {
        doctor_fix(out, "lumsim --address %s &", doctor_place(d->sensor).text);
    } else {
        doctor_fix_elsewhere(d, out);
    }
}

/* --- Answers --- */

static bool is_seen_down(struct doctor *d)
{
    return doctor_ask_status(d) && d->session.has_status &&
           lum_laser_is_down(d->session.status);
}

/* If another host drives the sensor, the data is for that host. Heartbeats of a
 * program that has ended are in effect for 3 s. A poll without an answer tells
 * nothing. */
static void respect_others(struct doctor *d, struct doctor_finding *out)
{
    const int64_t end = lum_time_monotonic_ns() + LET_GO_NS;
    if (d->lacks[DOCTOR_NEEDS_SESSION] != NULL || is_seen_down(d) ||
        !d->session.has_status) {
        return;
    }
    const bool is_on = lum_laser_is_on(d->session.status);
    while (lum_time_monotonic_ns() < end) {
        if (!doctor_rest_until(d, lum_time_monotonic_ns() + REST_NS)) {
            return;
        }
        if (is_seen_down(d)) {
            doctor_add(out,
                       "; its laser %s up until 3 s after the last heartbeat "
                       "of another program",
                       is_on ? "was" : "may have been");
            return;
        }
    }
    doctor_add(out,
               "; its laser %s up, still after 3 s, so another host may be "
               "using it: its data is not taken",
               is_on ? "is" : "may be");
    out->result = DOCTOR_NOTE;
    doctor_lack(d, DOCTOR_NEEDS_SESSION,
                "the laser is on, or may be, for a session of another host");
}

void doctor_check_answer(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    lum_clock_estimate e;
    if (doctor_open(d, false, &error) != LUM_NET_OK) {
        doctor_wrong(out, "%s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_ANSWER, "no socket for it");
        return;
    }
    const int64_t begin_ns = lum_time_monotonic_ns();
    doctor_ask_times(d);
    if (lum_clock_sync_estimate(&d->session.clock, &e) != LUM_OK) {
        say_silent(d, begin_ns, out);
        return;
    }
    doctor_say(out, 2 * e.error_ns > SLOW_NS ? DOCTOR_NOTE : DOCTOR_FINE,
               "the sensor answers a timestamp, %swithin %.2f ms",
               2 * e.error_ns > SLOW_NS ? "but late, " : "",
               2e-6 * (double)e.error_ns);
    respect_others(d, out);
}
