/* The doctor's own session: whether it can be opened, whether the receive
 * buffer is large enough, its requests and the answers kept. */
#include "doctor.h"

#include "lum/base/time.h"

#define EXCHANGES 5u
#define SLOT_NS   INT64_C(100000000)
#define NEAR_NS   INT64_C(500000000) /* of exchanges that are alike */
#define MIB       1048576.0

lum_net_result doctor_open(struct doctor *d, bool owns, lum_error *error)
{
    const struct ctl_options *o = &d->ctl->options;
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = d->sensor;
    options.interface_name = o->interface;
    options.layout = d->ctl->layout;
    options.owns = owns;
    options.timeout_ms = o->requests.timeout_ms;
    options.retries = o->requests.retries;
    options.cancel = d->ctl->cancel;
    doctor_close(d);
    return lum_sensor_open(&options, &d->session.handle, error);
}

void doctor_close(struct doctor *d)
{
    lum_sensor_close(d->session.handle);
    d->session.handle = NULL;
}

/* --- What is kept of answers --- */

int64_t doctor_round_trip_ns(const struct doctor_exchange *e)
{
    return e->received_ns - e->sent_ns;
}

/* The rate is measured between two exchanges: the one with the shortest round
 * trip at the beginning, and the one with the shortest at the end. */
static void keep_for_rate(struct doctor_session *s,
                          const struct doctor_exchange *e)
{
    if (!s->has_time) {
        s->begin_ns = e->sent_ns;
        s->early = *e;
        s->late = *e;
        s->has_time = true;
    }
    if (e->sent_ns - s->begin_ns < NEAR_NS &&
        doctor_round_trip_ns(e) < doctor_round_trip_ns(&s->early)) {
        s->early = *e;
    }
    if (e->sent_ns - s->late.sent_ns > NEAR_NS ||
        doctor_round_trip_ns(e) < doctor_round_trip_ns(&s->late)) {
        s->late = *e;
    }
}

void doctor_note_event(struct doctor_session *s, const lum_sensor_event *event)
{
    const struct doctor_exchange e = {event->sent_ns, event->received_ns,
                                      event->clock_us};
    if ((event->kind == LUM_SENSOR_ANSWER || event->kind == LUM_SENSOR_ALERT) &&
        event->has_status) {
        s->has_status = true;
        s->status = event->status;
    }
    if (event->kind == LUM_SENSOR_TIME &&
        lum_clock_sync_add(&s->clock, e.sent_ns, e.received_ns, e.clock_us) ==
            LUM_OK) {
        keep_for_rate(s, &e);
    }
}

/* --- Requests --- */

bool doctor_is_broken(lum_sensor_event_kind kind)
{
    return kind == LUM_SENSOR_CANCELLED || kind == LUM_SENSOR_FAILED;
}

static void receive(struct doctor *d, int64_t end_ns, lum_sensor_event *event)
{
    session_keep_alive(d->ctl);
    lum_sensor_receive(d->session.handle, end_ns, event);
    doctor_note_event(&d->session, event);
}

/* The result of the request under way. */
static lum_sensor_event_kind finish_request(struct doctor *d)
{
    lum_sensor_event event;
    do {
        receive(d, lum_time_monotonic_ns() + SLOT_NS, &event);
    } while (event.kind != LUM_SENSOR_ANSWER && event.kind != LUM_SENSOR_TIME &&
             event.kind != LUM_SENSOR_NO_ANSWER &&
             !doctor_is_broken(event.kind));
    return event.kind;
}

bool doctor_rest_until(struct doctor *d, int64_t end)
{
    lum_sensor_event event = {.kind = LUM_SENSOR_IDLE};
    int64_t now = lum_time_monotonic_ns();
    while (now < end && !doctor_is_broken(event.kind)) {
        receive(d, now + SLOT_NS < end ? now + SLOT_NS : end, &event);
        now = lum_time_monotonic_ns();
    }
    return !doctor_is_broken(event.kind);
}

void doctor_ask_times(struct doctor *d)
{
    lum_sensor_event_kind kind = LUM_SENSOR_TIME;
    for (unsigned i = 0; i < EXCHANGES && kind == LUM_SENSOR_TIME; i++) {
        kind = lum_sensor_request_time(d->session.handle) == LUM_OK
                   ? finish_request(d)
                   : LUM_SENSOR_FAILED;
    }
}

bool doctor_ask_status(struct doctor *d)
{
    lum_sensor *handle = d->session.handle;
    return handle != NULL && lum_sensor_request(handle, NULL, 0) == LUM_OK &&
           finish_request(d) == LUM_SENSOR_ANSWER;
}

/* --- Checks: session, buffer --- */

/* Becomes the owner for a moment; nothing is sent. */
void doctor_check_session(struct doctor *d, struct doctor_finding *out)
{
    lum_error error = {""};
    const lum_net_result result = doctor_open(d, true, &error);
    doctor_close(d);
    if (result == LUM_NET_OK) {
        doctor_fine(out, "no other program of this host owns %s", d->address);
    } else if (result == LUM_NET_BUSY) {
        doctor_note(out, "%s; its data is not taken", error.text);
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
        doctor_say(
            out, d->is_local ? DOCTOR_NOTE : DOCTOR_WRONG,
            "the kernel grants a receive buffer of %.1f MiB only; a quarter of "
            "a second at 125 MB/s needs %.0f",
            (double)room / MIB, (double)LUM_SOCKET_RECEIVE_BUFFER / MIB);
        doctor_fix_buffer(out);
    }
    lum_socket_close(socket);
}
