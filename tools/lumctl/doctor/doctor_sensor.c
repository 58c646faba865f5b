/* What the sensor itself shows: answers, data, its clock, its status. */
#include "doctor.h"

#include "../../common/arrival.h"
#include "../report.h"
#include "../session.h"

#include "lum/base/time.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>

#define MS_NS         INT64_C(1000000)
#define EXCHANGES     5u
#define TAKE_NS       (2000 * MS_NS)
#define SLOT_NS       (100 * MS_NS)
#define RATE_NS       (1000 * MS_NS)
#define LATE_NS       (3000 * MS_NS) /* for answers that nobody waits for */
#define SLOW_NS       (250 * MS_NS)  /* no sensor beside this host needs it */
#define REST_NS       (300 * MS_NS)
#define NEAR_NS       (RATE_NS / 2) /* of exchanges that are alike */
#define LET_GO_NS     (LUM_HEARTBEAT_TIMEOUT_MS * MS_NS + REST_NS)
#define DATA_CLOCK_US INT64_C(250000)
#define DRIFT_MAX_PPB INT64_C(1000000)
#define MIB           1048576.0

/* --- Requests and their answers --- */

lum_net_result doctor_open(struct doctor *d, bool owns, lum_error *error)
{
    const struct ctl_options *o = &d->ctl->options;
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = d->sensor;
    options.interface_name = o->interface;
    options.layout = d->ctl->layout;
    options.owns = owns;
    options.timeout_ms = o->timeout_ms;
    options.retries = o->retries;
    options.cancel = d->ctl->cancel;
    lum_sensor_close(d->session);
    d->session = NULL;
    return lum_sensor_open(&options, &d->session, error);
}

static bool is_ending(lum_sensor_event_kind kind)
{
    switch (kind) {
    case LUM_SENSOR_ANSWER:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_NO_ANSWER:
    case LUM_SENSOR_CANCELLED:
    case LUM_SENSOR_FAILED:
        return true;
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_DATAGRAMS:
    case LUM_SENSOR_ALERT:
    case LUM_SENSOR_LINK:
        break;
    }
    return false;
}

static void note_status(struct doctor *d, const lum_sensor_event *event)
{
    if ((event->kind == LUM_SENSOR_ANSWER || event->kind == LUM_SENSOR_ALERT) &&
        event->has_status) {
        d->has_status = true;
        d->status = event->status;
    }
}

static int64_t round_trip_ns(const struct doctor_exchange *e)
{
    return e->received_ns - e->sent_ns;
}

/* The rate is measured between two exchanges: the one with the shortest round
 * trip at the beginning, and the one with the shortest at the end. */
static void keep_for_rate(struct doctor *d, const struct doctor_exchange *e)
{
    if (!d->has_time) {
        d->begin_ns = e->sent_ns;
        d->early = *e;
        d->late = *e;
        d->has_time = true;
    }
    if (e->sent_ns - d->begin_ns < NEAR_NS &&
        round_trip_ns(e) < round_trip_ns(&d->early)) {
        d->early = *e;
    }
    if (e->sent_ns - d->late.sent_ns > NEAR_NS ||
        round_trip_ns(e) < round_trip_ns(&d->late)) {
        d->late = *e;
    }
}

static void note_time(struct doctor *d, const lum_sensor_event *event)
{
    const struct doctor_exchange e = {event->sent_ns, event->received_ns,
                                      event->clock_us};
    if (event->kind == LUM_SENSOR_TIME &&
        lum_clock_sync_add(&d->clock, e.sent_ns, e.received_ns, e.clock_us) ==
            LUM_OK) {
        keep_for_rate(d, &e);
    }
}

/* The result of the request under way. */
static lum_sensor_event_kind finish_request(struct doctor *d)
{
    lum_sensor_event event;
    do {
        doctor_keep_alive(d);
        lum_sensor_receive(d->session, lum_time_monotonic_ns() + SLOT_NS,
                           &event);
        note_status(d, &event);
        note_time(d, &event);
    } while (!is_ending(event.kind));
    return event.kind;
}

static lum_sensor_event_kind ask_time(struct doctor *d)
{
    return d->session != NULL && lum_sensor_request_time(d->session) == LUM_OK
               ? finish_request(d)
               : LUM_SENSOR_FAILED;
}

/* Receives, without a request, until a time. */
static bool rest_until(struct doctor *d, int64_t end)
{
    lum_sensor_event event = {.kind = LUM_SENSOR_IDLE};
    int64_t now = lum_time_monotonic_ns();
    while (now < end && event.kind != LUM_SENSOR_CANCELLED &&
           event.kind != LUM_SENSOR_FAILED) {
        doctor_keep_alive(d);
        lum_sensor_receive(d->session,
                           now + SLOT_NS < end ? now + SLOT_NS : end, &event);
        note_status(d, &event);
        now = lum_time_monotonic_ns();
    }
    return event.kind != LUM_SENSOR_CANCELLED &&
           event.kind != LUM_SENSOR_FAILED;
}

/* Asks for the time repeatedly, as long as answers come. */
static void ask_times(struct doctor *d)
{
    lum_sensor_event_kind kind = LUM_SENSOR_TIME;
    for (unsigned i = 0; i < EXCHANGES && kind == LUM_SENSOR_TIME; i++) {
        kind = ask_time(d);
    }
}

static lum_sensor_event_kind ask_status(struct doctor *d)
{
    return d->session != NULL &&
                   lum_sensor_request(d->session, NULL, 0) == LUM_OK
               ? finish_request(d)
               : LUM_SENSOR_FAILED;
}

/* --- Checks: session, buffer --- */

/* Becomes the owner for a moment; nothing is sent. */
void doctor_check_session(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    const lum_net_result result = doctor_open(d, true, &error);
    lum_sensor_close(d->session);
    d->session = NULL;
    if (result == LUM_NET_OK) {
        doctor_fine(out, "no other program of this host owns %s", d->address);
    } else if (result == LUM_NET_BUSY) {
        doctor_note(out, "%s; its data is left alone", error.text);
        doctor_lack(d, DOCTOR_NEEDS_SESSION,
                    "another session of this host owns the sensor");
    } else {
        doctor_wrong(out, "%s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "no socket for it");
    }
}

void doctor_check_buffer(struct doctor *d, struct doctor_finding *out)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .receive_buffer =
                                            LUM_SOCKET_RECEIVE_BUFFER};
    lum_socket *socket = NULL;
    lum_error error = {""};
    if (lum_socket_open(&options, &socket, &error) != LUM_NET_OK) {
        doctor_wrong(out, "%s", error.text);
        return;
    }
    const size_t room =
        doctor_buffer_payload(lum_socket_receive_buffer(socket));
    if (lum_socket_has_room(socket)) {
        doctor_fine(out,
                    "the kernel grants a receive buffer of %.1f MiB, a quarter "
                    "of a second at 125 MB/s",
                    (double)room / MIB);
    } else {
        /* the data of a simulator on this host does not fill the link */
        (d->is_local ? doctor_note : doctor_wrong)(
            out,
            "the kernel grants a receive buffer of %.1f MiB only; a quarter of "
            "a second at 125 MB/s needs %.0f",
            (double)room / MIB, (double)LUM_SOCKET_RECEIVE_BUFFER / MIB);
        doctor_fix_buffer(out);
    }
    lum_socket_close(socket);
}

/* --- Check: answer --- */

void doctor_fix_elsewhere(const struct doctor *d, struct doctor_finding *out)
{
    doctor_fix(out,
               "sudo lumctl find --interface %s    # at which address does "
               "it answer? It boots at 10.42.0.37",
               d->interface);
}

/* It answers, but from another place than the request went to. */
static void say_other_port(struct doctor *d, uint16_t port,
                           struct doctor_finding *out)
{
    char at[SESSION_CTL_BYTES];
    char filter[48];
    doctor_lack(d, DOCTOR_NEEDS_ANSWER, "answers come from another port");
    doctor_wrong(out,
                 "%s answers from port %u to what is sent to its port %u, so "
                 "that its answers are taken for a stranger's: something "
                 "between rewrites ports",
                 d->address, (unsigned)port, (unsigned)d->sensor.port);
    doctor_keep_alive(d);
    if (doctor_answers_at(d, port)) {
        const lum_endpoint there = {d->sensor.address, port};
        doctor_fix(out, "%s doctor", session_ctl(d->ctl, there, at));
    } else {
        (void)snprintf(filter, sizeof filter, "udp and host %s", d->address);
        doctor_fix_watch(d, out, filter,
                         "take the router or container out that does it");
    }
}

/* What to look at while a command of lumctl runs. */
static void fix_watch(const struct doctor *d, struct doctor_finding *out,
                      const char *filter, const char *command,
                      const char *question)
{
    char at[SESSION_CTL_BYTES];
    char what[SESSION_CTL_BYTES + 80];
    (void)snprintf(what, sizeof what, "while %s %s runs: %s",
                   session_ctl(d->ctl, d->sensor, at), command, question);
    doctor_fix_watch(d, out, filter, what);
}

static void fix_port_watch(const struct doctor *d, struct doctor_finding *out)
{
    char filter[32];
    (void)snprintf(filter, sizeof filter, "udp port %u",
                   (unsigned)d->sensor.port);
    fix_watch(d, out, filter, "time --watch",
              "do requests leave, do answers come?");
}

static bool has_dropped(const struct doctor *d)
{
    lum_sensor_counters counters = {.struct_size = sizeof counters};
    lum_sensor_count(d->session, &counters);
    return counters.answers_dropped > 0;
}

/* Answers that came in time and were none to these requests, or came after they
 * were given up. */
static bool say_misfit(struct doctor *d, int64_t begin_ns,
                       struct doctor_finding *out)
{
    char at[SESSION_CTL_BYTES];
    const struct ctl_options *o = &d->ctl->options;
    const bool is_other = has_dropped(d);
    int64_t now = lum_time_monotonic_ns();
    const int64_t end = now + LATE_NS;
    while (!has_dropped(d) && now < end && rest_until(d, now + SLOT_NS)) {
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
                     "request, so that its answers are not believed",
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
                   session_ctl(d->ctl, d->sensor, at),
                   (2u * ms + 99u) / 100u * 100u);
    }
    return true;
}

static void say_unanswered(struct doctor *d, int64_t begin_ns,
                           struct doctor_finding *out)
{
    if (say_misfit(d, begin_ns, out)) {
        return;
    }
    doctor_keep_alive(d);
    const uint16_t port = doctor_other_port(d);
    if (port != 0) {
        say_other_port(d, port, out);
        return;
    }
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_ANSWER, "the sensor does not answer");
    doctor_wrong(out, "no answer to %u timestamp requests to %s:%u",
                 (unsigned)d->ctl->options.retries + 1u, d->address,
                 (unsigned)d->sensor.port);
    fix_port_watch(d, out);
}

static void say_silent(struct doctor *d, int64_t begin_ns,
                       struct doctor_finding *out)
{
    char place[DOCTOR_PLACE_BYTES];
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
    if (d->own[0] != '\0') {
        doctor_fix(out, "sudo ip addr del %s", d->own);
    } else if (d->is_local) {
        doctor_fix(out, "lumsim --address %s &",
                   doctor_place(d->sensor.address, d->sensor.port, place));
    } else {
        doctor_fix_elsewhere(d, out);
    }
}

static bool is_seen_down(struct doctor *d)
{
    return ask_status(d) == LUM_SENSOR_ANSWER && d->has_status &&
           lum_laser_is_down(d->status);
}

/* If another host drives the sensor, the data is for that host. Heartbeats of a
 * program that has ended are in effect for 3 s. A poll without an answer tells
 * nothing. */
static void respect_others(struct doctor *d, struct doctor_finding *out)
{
    const int64_t end = lum_time_monotonic_ns() + LET_GO_NS;
    if (d->lacks[DOCTOR_NEEDS_SESSION] != NULL || is_seen_down(d) ||
        !d->has_status) {
        return;
    }
    const bool is_on = lum_laser_is_on(d->status);
    while (lum_time_monotonic_ns() < end) {
        if (!rest_until(d, lum_time_monotonic_ns() + REST_NS)) {
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
               "; its laser %s up, still after 3 s, so another host may be at "
               "work with it: its data is left alone",
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
    ask_times(d);
    if (lum_clock_sync_estimate(&d->clock, &e) != LUM_OK) {
        say_silent(d, begin_ns, out);
        return;
    }
    (2 * e.error_ns > SLOW_NS ? doctor_note : doctor_fine)(
        out, "the sensor answers a timestamp, %swithin %.2f ms",
        2 * e.error_ns > SLOW_NS ? "but late, " : "",
        2e-6 * (double)e.error_ns);
    respect_others(d, out);
}

/* --- Receiving data --- */

/* One slot of the session's time. A request is always under way, so that the
 * clock is measured until the end. */
static void ask_next(struct doctor *d, unsigned slot)
{
    if (!lum_sensor_is_waiting(d->session)) {
        /* refused only while another is under way */
        const lum_result r = slot % 5u == 4u
                                 ? lum_sensor_request(d->session, NULL, 0)
                                 : lum_sensor_request_time(d->session);
        (void)r;
    }
}

static void take_event(struct doctor *d, const lum_sensor_event *event)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    const int64_t now_utc_ns = lum_time_utc_ns();
    note_status(d, event);
    note_time(d, event);
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        for (size_t i = 0; i < event->datagram_count; i++) {
            const lum_received *r = &event->datagrams[i];
            doctor_stream_take(d, r, arrival_ns(r->utc_ns, now_ns, now_utc_ns));
        }
    }
}

static int begin_count(const struct doctor *d)
{
    lum_endpoint local = {0, 0};
    lum_socket_local(lum_sensor_socket(d->session), &local);
    return doctor_count_begin(d, local.port);
}

/* Takes what was counted and is still waiting; answers may stand between.
 * False: it does not end. */
static bool take_rest(struct doctor *d, lum_sensor_event *event)
{
    const int64_t end = lum_time_monotonic_ns() + REST_NS;
    do {
        lum_sensor_receive(d->session, 0, event);
        take_event(d, event);
    } while (
        event->kind != LUM_SENSOR_IDLE && event->kind != LUM_SENSOR_FAILED &&
        event->kind != LUM_SENSOR_CANCELLED && lum_time_monotonic_ns() < end);
    return event->kind == LUM_SENSOR_IDLE;
}

/* False if it failed or was cancelled. */
static bool take_data(struct doctor *d, lum_error *error)
{
    const int counter = begin_count(d);
    const int64_t begin = lum_time_monotonic_ns();
    lum_sensor_event event = {.kind = LUM_SENSOR_IDLE};
    int64_t now = begin;
    unsigned slot = 0;
    while (now < begin + TAKE_NS && event.kind != LUM_SENSOR_FAILED &&
           event.kind != LUM_SENSOR_CANCELLED) {
        if (now >= begin + (int64_t)slot * SLOT_NS) {
            doctor_keep_alive(d);
            ask_next(d, slot);
            slot++;
        }
        lum_sensor_receive(d->session, begin + (int64_t)slot * SLOT_NS, &event);
        take_event(d, &event);
        now = lum_time_monotonic_ns();
    }
    d->stream.came_in = doctor_count_end(counter);
    if (event.kind != LUM_SENSOR_FAILED && event.kind != LUM_SENSOR_CANCELLED &&
        !take_rest(d, &event)) {
        d->stream.came_in = 0;
    }
    *error = event.kind == LUM_SENSOR_FAILED ? event.error : (lum_error){""};
    d->stream.duration_ns = lum_time_monotonic_ns() - begin;
    d->stream.session.struct_size = sizeof d->stream.session;
    lum_sensor_count(d->session, &d->stream.session);
    d->stream.counts_drops =
        lum_socket_counts_drops(lum_sensor_socket(d->session));
    return event.kind != LUM_SENSOR_FAILED &&
           event.kind != LUM_SENSOR_CANCELLED;
}

/* --- Check: data --- */

static uint64_t data_datagrams(const struct doctor_stream *s)
{
    return s->kinds[LUM_PACKET_DATA] + s->kinds[LUM_PACKET_UNKNOWN_TYPE] +
           s->kinds[LUM_PACKET_MALFORMED] + s->kinds[LUM_PACKET_UNKNOWN_TAG];
}

static void say_no_data(struct doctor *d, struct doctor_finding *out)
{
    char filter[48];
    doctor_lack(d, DOCTOR_NEEDS_DATA, "no data");
    if (d->stream.session.other_port > 0) {
        doctor_wrong(out,
                     "heartbeats were sent, and what came from %s came from "
                     "another port than %u: something between rewrites ports",
                     d->address, (unsigned)d->sensor.port);
    } else if (doctor_stream_filtered(d) > 0) {
        doctor_wrong(out,
                     "%" PRIu64 " datagrams of data came in by %s, and this "
                     "host drops them, though not short answers: a rule of its "
                     "firewall",
                     doctor_stream_filtered(d), d->interface);
        doctor_fix(out,
                   "sudo nft list ruleset | grep -nE 'length|limit|drop|"
                   "reject'    # and let UDP from %s through",
                   d->address);
        return;
    } else {
        doctor_wrong(out,
                     "heartbeats were sent for %.0f s, and no data came; the "
                     "sensor answers, so it does not start its scan, or "
                     "another host sends heartbeats too and gets the data",
                     1e-9 * (double)d->stream.duration_ns);
    }
    (void)snprintf(filter, sizeof filter, "udp and host %s", d->address);
    fix_watch(d, out, filter, "heartbeat", "who talks to it?");
}

static void say_data(struct doctor *d, struct doctor_finding *out)
{
    const double seconds = 1e-9 * (double)d->stream.duration_ns;
    const uint64_t n = data_datagrams(&d->stream);
    if (n == 0) {
        say_no_data(d, out);
        return;
    }
    doctor_fine(
        out, "heartbeats bring data: %.0f datagrams and %.2f MB a second",
        (double)n / seconds, 1e-6 * (double)d->stream.session.bytes / seconds);
}

void doctor_check_data(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    const lum_net_result result = doctor_open(d, true, &error);
    if (result == LUM_NET_BUSY) {
        doctor_unseen(out, "not looked at: %s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_SESSION,
                    "another session of this host owns the sensor");
        return;
    }
    if (result != LUM_NET_OK) {
        doctor_wrong(out, "%s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_SESSION, "no session");
        return;
    }
    if (!doctor_stream_open(d)) {
        doctor_unseen(out, "not looked at: out of memory");
        doctor_lack(d, DOCTOR_NEEDS_SESSION, "out of memory");
        return;
    }
    if (take_data(d, &error) || error.text[0] == '\0') {
        say_data(d, out);
        if (d->stream.lacks_memory) {
            doctor_lack(d, DOCTOR_NEEDS_DATA, "out of memory");
        }
    } else {
        doctor_wrong(out, "%s", error.text);
        doctor_lack(d, DOCTOR_NEEDS_DATA, "the session broke");
        lum_sensor_close(d->session);
        d->session = NULL;
    }
}

/* --- Check: clock --- */

/* Microseconds by which the data's clock is behind the sensor's clock of the
 * timestamps. */
static int64_t data_clock_lag(const struct doctor *d,
                              const lum_clock_estimate *e)
{
    const int64_t sensor_us = (d->stream.clock_ns - e->offset_ns) / 1000;
    return (int32_t)((uint32_t)sensor_us - d->stream.clock_us);
}

static void look_at_data_clock(const struct doctor *d,
                               const lum_clock_estimate *e,
                               struct doctor_finding *out)
{
    if (!d->stream.has_clock || d->lacks[DOCTOR_NEEDS_DATA] != NULL) {
        return;
    }
    const int64_t lag = data_clock_lag(d, e);
    const int64_t allowed = DATA_CLOCK_US + e->error_ns / 1000;
    if (lag < -allowed || lag > allowed) {
        doctor_wrong(out,
                     "the clock in the data is %.3f s away from the clock in "
                     "the timestamps: the profile's timestamp may stand at "
                     "the wrong place",
                     1e-6 * (double)lag);
        char at[SESSION_CTL_BYTES];
        doctor_fix(out,
                   "%s --profile FILE doctor    # group.timestamp corrected in "
                   "it",
                   session_ctl(d->ctl, d->sensor, at));
    } else {
        doctor_add(out, "; the data bears the same clock, %.1f ms behind",
                   1e-3 * (double)lag);
    }
}

/* Billionths by which this host's clock runs faster than the sensor's, and the
 * error. The estimate of the offset assumes good clocks; this does not. */
struct rate {
    int64_t ppb;
    int64_t error_ppb;
};

static struct rate rate_of(const struct doctor *d)
{
    const int64_t host_ns = d->late.sent_ns - d->early.sent_ns;
    const int64_t sensor_ns =
        1000 * (int64_t)(d->late.clock_us - d->early.clock_us);
    const int64_t error_ns =
        round_trip_ns(&d->early) + round_trip_ns(&d->late) + 1000;
    const double scale = 1e9 / (double)(host_ns > 0 ? host_ns : 1);
    return (struct rate){(int64_t)((double)(host_ns - sensor_ns) * scale),
                         (int64_t)((double)error_ns * scale)};
}

/* Asks for timestamps at a sufficient distance from the early ones. No
 * heartbeats are sent, so that no data is under way at the same time. */
static void wait_for_rate(struct doctor *d)
{
    lum_error error = {""};
    if (d->session != NULL && doctor_open(d, false, &error) == LUM_NET_OK &&
        rest_until(d, d->early.sent_ns + RATE_NS)) {
        ask_times(d);
    }
}

static void look_at_rate(const struct doctor *d, struct doctor_finding *out)
{
    const struct rate rate = rate_of(d);
    const int64_t drift = rate.ppb < 0 ? -rate.ppb : rate.ppb;
    if (d->late.sent_ns - d->early.sent_ns < RATE_NS / 2) {
        return;
    }
    if (drift - rate.error_ppb > DRIFT_MAX_PPB) {
        doctor_wrong(out,
                     "the sensor's clock runs %.0f ppm %s than this host's; "
                     "1000 are allowed: one of the two is not to be trusted",
                     1e-3 * (double)drift, rate.ppb > 0 ? "slower" : "faster");
        doctor_fix(out, "timedatectl timesync-status    # is this host's "
                        "clock in order? Then the sensor's is not");
    } else {
        doctor_add(out, ", and runs at this host's rate within %.0f ppm%s",
                   1e-3 * (double)(drift + rate.error_ppb),
                   rate.error_ppb > DRIFT_MAX_PPB
                       ? ", as far as answers so slow can tell"
                       : "");
    }
}

void doctor_check_clock(struct doctor *d, struct doctor_finding *out)
{
    char at[SESSION_CTL_BYTES];
    lum_clock_estimate e;
    wait_for_rate(d);
    if (lum_clock_sync_estimate(&d->clock, &e) != LUM_OK) {
        doctor_unseen(out, "not looked at: no timestamps");
        return;
    }
    if (e.resets > 0) {
        doctor_wrong(out, "the sensor's clock began anew while it was looked "
                          "at: it restarts");
        doctor_fix(out,
                   "%s time --watch    # look at its power supply until that "
                   "stops",
                   session_ctl(d->ctl, d->sensor, at));
        return;
    }
    doctor_fine(out, "the sensor's clock stands at %.6f s, known to %.3f ms",
                1e-6 * (double)(uint32_t)e.clock_us, 1e-6 * (double)e.error_ns);
    look_at_rate(d, out);
    if (out->result == DOCTOR_FINE) {
        look_at_data_clock(d, &e, out);
    }
}

/* --- Check: status --- */

/* What to do about a hazard; if there are several, the lowest rank comes
 * first. */
struct remedy {
    unsigned rank;
    const char *fix; /* NULL: nothing to do, it is not a hazard */
};

static struct remedy remedy_of(unsigned bit)
{
    switch ((enum lum_laser_bit)(1u << bit)) {
    case LUM_LASER_SYS_ON_SW_OFF:
        return (struct remedy){1, "turn the SYS_ON switch on"};
    case LUM_LASER_HW_SAFETY_BAD:
        return (struct remedy){2, "close the hardware interlock"};
    case LUM_LASER_BOARD_OVER_105:
        return (struct remedy){3, "switch the sensor off and let it cool"};
    case LUM_LASER_FAN_PWM_BAD:
        return (struct remedy){4, "free the fan, switch the sensor off and on"};
    case LUM_LASER_GALVO_AMP_BX_BAD:
    case LUM_LASER_GALVO_AMP_BY_BAD:
    case LUM_LASER_GALVO_AMP_GX_BAD:
    case LUM_LASER_GALVO_AMP_GY_BAD:
        return (struct remedy){5, "switch the sensor off and on; if the bit "
                                  "comes back, its mirror drive is broken"};
    case LUM_LASER_HEARTBEAT_TIMEOUT: /* the checks of the session say it */
    case LUM_LASER_TLV_CMD_OFF:
    case LUM_LASER_TLV_CMD_ON:
        break;
    }
    return (struct remedy){UINT_MAX, NULL};
}

static struct remedy first_remedy(uint16_t status)
{
    struct remedy first = {UINT_MAX, NULL};
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const struct remedy r = remedy_of(bit);
        if (((unsigned)status >> bit & 1u) != 0 && r.rank < first.rank) {
            first = r;
        }
    }
    return first;
}

static void say_hazard(struct doctor *d, bool is_owned,
                       struct doctor_finding *out)
{
    char line[REPORT_LINE_BYTES];
    const struct remedy remedy = first_remedy(d->status);
    d->has_hazard = true;
    doctor_wrong(out, "hazard, 0x%04x, %s", (unsigned)d->status,
                 report_line(d->status, is_owned, line));
    if (remedy.fix != NULL) {
        doctor_fix(out, "%s", remedy.fix);
    }
}

void doctor_check_status(struct doctor *d, struct doctor_finding *out)
{
    char line[REPORT_LINE_BYTES];
    if (!d->has_status && ask_status(d) != LUM_SENSOR_ANSWER) {
        doctor_wrong(out, "the sensor answers timestamps, but no status poll");
        return;
    }
    if (!d->has_status) {
        doctor_note(out,
                    "the sensor's answers bear no status: tlv.status (%u) of "
                    "the profile may be another number",
                    (unsigned)d->ctl->layout.profile.tlv[LUM_TLV_STATUS]);
        return;
    }
    /* A session of the doctor's own begins after the status was asked for. */
    const bool is_owned =
        d->session == NULL && session_is_owned(d->ctl, d->status);
    if (ctl_status_exit(d->status, is_owned) == EXIT_HAZARD) {
        say_hazard(d, is_owned, out);
        return;
    }
    doctor_fine(out, "no hazard, 0x%04x, %s", (unsigned)d->status,
                report_line(d->status, is_owned, line));
}
