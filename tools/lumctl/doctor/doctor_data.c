/* Owns the session for two seconds, hands the data that comes to
 * doctor_stream.c, and says whether any came. */
#include "doctor.h"

#include "../../common/arrival.h"

#include "lum/base/time.h"

#include <inttypes.h>
#include <stdio.h>

#define TAKE_NS INT64_C(2000000000)
#define SLOT_NS INT64_C(100000000)
#define REST_NS INT64_C(300000000)

/* --- Receiving data --- */

/* One slot of the session's time. A request is always under way, so that the
 * clock is measured until the end. */
static void ask_next(struct doctor *d, unsigned slot)
{
    if (!lum_sensor_is_waiting(d->session.handle)) {
        /* refused only while another is under way */
        const lum_result r =
            slot % 5u == 4u ? lum_sensor_request(d->session.handle, NULL, 0)
                            : lum_sensor_request_time(d->session.handle);
        (void)r;
    }
}

static void take_event(struct doctor *d, const lum_sensor_event *event)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    const int64_t now_utc_ns = lum_time_utc_ns();
    doctor_note_event(&d->session, event);
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
    lum_socket_local(lum_sensor_socket(d->session.handle), &local);
    return d->route.interface[0] == '\0'
               ? -1
               : capture_open(d->route.interface, d->sensor, local.port);
}

/* Takes what was counted and is still waiting; answers may stand between.
 * False: it does not end. */
static bool take_rest(struct doctor *d, lum_sensor_event *event)
{
    const int64_t end = lum_time_monotonic_ns() + REST_NS;
    do {
        lum_sensor_receive(d->session.handle, 0, event);
        take_event(d, event);
    } while (event->kind != LUM_SENSOR_IDLE && !doctor_is_broken(event->kind) &&
             lum_time_monotonic_ns() < end);
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
    while (now < begin + TAKE_NS && !doctor_is_broken(event.kind)) {
        if (now >= begin + (int64_t)slot * SLOT_NS) {
            session_keep_alive(d->ctl);
            ask_next(d, slot);
            slot++;
        }
        lum_sensor_receive(d->session.handle, begin + (int64_t)slot * SLOT_NS,
                           &event);
        take_event(d, &event);
        now = lum_time_monotonic_ns();
    }
    d->stream.came_in = capture_end(counter);
    if (!doctor_is_broken(event.kind) && !take_rest(d, &event)) {
        d->stream.came_in = 0;
    }
    *error = event.kind == LUM_SENSOR_FAILED ? event.error : (lum_error){""};
    d->stream.duration_ns = lum_time_monotonic_ns() - begin;
    d->stream.session.struct_size = sizeof d->stream.session;
    lum_sensor_count(d->session.handle, &d->stream.session);
    d->stream.counts_drops =
        lum_socket_counts_drops(lum_sensor_socket(d->session.handle));
    return !doctor_is_broken(event.kind);
}

/* --- Check: data --- */

static void say_no_data(struct doctor *d, struct doctor_finding *out)
{
    char filter[48];
    doctor_lack(d, DOCTOR_NEEDS_DATA, "no data");
    if (d->stream.session.other_port > 0) {
        doctor_wrong(out,
                     "heartbeats were sent, but packets of %s came from "
                     "another port than %u: a device on the way rewrites ports",
                     d->address, (unsigned)d->sensor.port);
    } else if (doctor_stream_filtered(d) > 0) {
        doctor_wrong(out,
                     "%" PRIu64 " datagrams of data came in by %s, and this "
                     "host drops them, though not short answers: a rule of its "
                     "firewall",
                     doctor_stream_filtered(d), d->route.interface);
        doctor_fix_rules(d, out);
        return;
    } else {
        doctor_wrong(out,
                     "heartbeats were sent for %.0f s, and no data came, "
                     "though the sensor answers: it does not start its scan, "
                     "or another host also sends heartbeats and gets the data",
                     1e-9 * (double)d->stream.duration_ns);
    }
    (void)snprintf(filter, sizeof filter, "udp and host %s", d->address);
    doctor_fix_watch_while(d, out, filter, "heartbeat", "who talks to it?");
}

static void say_data(struct doctor *d, struct doctor_finding *out)
{
    const double seconds = 1e-9 * (double)d->stream.duration_ns;
    const uint64_t n =
        d->stream.kinds[LUM_PACKET_DATA] + doctor_stream_odd(&d->stream);
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
        doctor_close(d);
    }
}
