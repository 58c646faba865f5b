#include "net/session.h"

#include "lum/base/time.h"
#include "net/endpoint.h"

#include <string.h>

/* After the deadline, this many batches of other senders' datagrams are still
 * searched for ours: at most a thousand datagrams. */
#define LATE_BATCHES 16u

lum_net_result lum_session_send(lum_sensor *s, const void *bytes, size_t len,
                                uint64_t *counter, lum_error *error)
{
    lum_error reason = {""};
    const lum_outgoing packet = {bytes, len, s->endpoint};
    const lum_net_result r = lum_socket_send(s->socket, &packet, &reason);
    s->link.is_up = r == LUM_NET_OK;
    if (r == LUM_NET_OK) {
        (*counter)++;
        return r;
    }
    s->counters.send_failures++;
    s->link.error = reason;
    if (error != NULL) {
        *error = reason;
    }
    return r;
}

static void send_heartbeat(lum_sensor *s)
{
    uint8_t packet[LUM_HEARTBEAT_BYTES];
    if (lum_exchange_beat(&s->exchange, lum_time_monotonic_ns())) {
        lum_heartbeat_encode(packet);
        (void)lum_session_send(s, packet, sizeof packet,
                               &s->counters.heartbeats, NULL);
    }
}

/* What the exchange found, as an event. */
static void fill_found(lum_sensor_event *out, lum_sensor_event_kind kind,
                       const lum_exchange_found *found)
{
    out->kind = kind;
    out->tlvs = found->tlvs;
    out->has_status = found->has_status;
    out->status = found->status;
    out->sequence = found->sequence;
    out->clock_us = found->clock_us;
    out->tries = found->tries;
    out->sent_ns = found->sent_ns;
}

/* Sends what the request under way needs. True with an event when it ends. Not
 * more than one try: a send may have been held up, and the cancel is looked at
 * before the next. */
static bool advance_request(lum_sensor *s, lum_sensor_event *out)
{
    lum_exchange *x = &s->exchange;
    lum_exchange_found found;
    const lum_exchange_step step = lum_exchange_advance(
        x, lum_time_monotonic_ns(), s->batch.heard_ns, &found);
    if (step == LUM_EXCHANGE_REQUEST || step == LUM_EXCHANGE_RESEND) {
        (void)lum_session_send(s, x->packet, x->packet_len,
                               step == LUM_EXCHANGE_REQUEST
                                   ? &s->counters.requests
                                   : &s->counters.resends,
                               NULL);
    } else if (step == LUM_EXCHANGE_GIVEN_UP) {
        fill_found(out, LUM_SENSOR_NO_ANSWER, &found);
        return true;
    }
    return false;
}

static bool tell_link(struct session_link *link, lum_sensor_event *out)
{
    if (link->told == link->is_up) {
        return false;
    }
    link->told = link->is_up;
    out->kind = LUM_SENSOR_LINK;
    out->is_up = link->is_up;
    if (!link->is_up) {
        out->error = link->error;
    }
    return true;
}

/* Counts what came. The event that it is; LUM_SENSOR_IDLE: none. */
static lum_sensor_event_kind count_found(lum_sensor_counters *c,
                                         lum_exchange_kind kind)
{
    switch (kind) {
    case LUM_EXCHANGE_ANSWER:
        c->answers++;
        return LUM_SENSOR_ANSWER;
    case LUM_EXCHANGE_TIME:
        c->answers++;
        return LUM_SENSOR_TIME;
    case LUM_EXCHANGE_ALERT:
        c->alerts++;
        return LUM_SENSOR_ALERT;
    case LUM_EXCHANGE_DROPPED:
        c->answers_dropped++;
        break;
    case LUM_EXCHANGE_MALFORMED:
        c->malformed++;
        break;
    case LUM_EXCHANGE_OTHER:
    case LUM_EXCHANGE_KINDS:
        break;
    }
    return LUM_SENSOR_IDLE;
}

/* The next event that the batch holds. */
static bool next_found(lum_sensor *s, lum_sensor_event *out)
{
    while (s->batch.next < s->batch.count) {
        const lum_received *r = &s->batch.list[s->batch.next++];
        lum_exchange_found found;
        if (r->cut_short) {
            continue;
        }
        const lum_sensor_event_kind event =
            count_found(&s->counters, lum_exchange_take(&s->exchange, r->bytes,
                                                        r->len, &found));
        if (event != LUM_SENSOR_IDLE) {
            fill_found(out, event, &found);
            out->received_ns = s->batch.received_ns;
            out->received_utc_ns = r->utc_ns;
            return true;
        }
    }
    return false;
}

/* A sensor with a new address sends from it at once. */
static void note_stranger(struct session_stranger *s, const lum_received *r)
{
    uint8_t type = 0;
    if (lum_header_decode(r->bytes, r->len, &type) != LUM_OK) {
        return;
    }
    if (r->from.address != s->from.address || r->from.port != s->from.port) {
        *s = (struct session_stranger){.from = r->from};
    }
    s->count += s->count < LUM_SENSOR_MOVED_COUNT;
}

/* Counts a datagram; whether it is the sensor's. */
static bool is_ours(lum_sensor *s, const lum_received *r)
{
    lum_sensor_counters *c = &s->counters;
    const bool address_fits = r->from.address == s->endpoint.address;
    const bool fits = address_fits && r->from.port == s->endpoint.port;
    if (!fits) {
        c->foreign_source++;
        c->other_port += address_fits;
        if (!address_fits) {
            note_stranger(&s->stranger, r);
        }
        return false;
    }
    s->stranger.count = 0;
    c->datagrams++;
    c->bytes += r->len;
    c->cut_short += r->cut_short;
    return true;
}

/* Takes a batch and keeps what is the sensor's. False with the error if the
 * socket broke. */
static bool read_batch(lum_sensor *s, lum_error *error)
{
    size_t count = 0;
    const int64_t before_ns = lum_time_monotonic_ns();
    s->batch.count = 0;
    s->batch.next = 0;
    if (lum_socket_receive(s->socket, &s->batch.list, &count, error) !=
        LUM_NET_OK) {
        return false;
    }
    s->batch.received_ns = lum_time_monotonic_ns();
    s->batch.socket_is_empty = count < LUM_SOCKET_BATCH;
    if (s->batch.socket_is_empty) {
        s->batch.heard_ns = before_ns;
    }
    for (size_t i = 0; i < count; i++) {
        if (is_ours(s, &s->batch.list[i])) {
            s->batch.list[s->batch.count++] = s->batch.list[i];
        }
    }
    return true;
}

static void fail(lum_sensor *s, lum_sensor_event *out)
{
    s->has_failed = true;
    out->kind = LUM_SENSOR_FAILED;
    out->error = s->failure;
}

/* What is to be done before the socket is read; true with an event. */
static bool do_what_is_due(lum_sensor *s, const lum_cancel *cancel,
                           lum_sensor_event *out)
{
    const bool is_cancelled = lum_cancel_is_raised(cancel);
    if (!is_cancelled) {
        send_heartbeat(s);
    }
    if (next_found(s, out)) {
        return true;
    }
    if (is_cancelled || lum_cancel_is_raised(cancel)) {
        out->kind = LUM_SENSOR_CANCELLED;
        return true;
    }
    return advance_request(s, out) || tell_link(&s->link, out);
}

/* Reads the socket; true with an event. */
static bool read_socket(lum_sensor *s, lum_sensor_event *out)
{
    if (!read_batch(s, &s->failure)) {
        fail(s, out);
        return true;
    }
    if (!s->owns || s->batch.count == 0) {
        return next_found(s, out);
    }
    out->kind = LUM_SENSOR_DATAGRAMS;
    out->datagrams = s->batch.list;
    out->datagram_count = s->batch.count;
    out->received_ns = s->batch.received_ns;
    out->received_utc_ns = s->batch.list[0].utc_ns;
    return true;
}

/* Waits for a datagram or the next step; true with an event. */
static bool wait_for_more(lum_sensor *s, const lum_cancel *cancel,
                          int64_t deadline_ns, lum_sensor_event *out)
{
    const int64_t step_ns = lum_exchange_next_ns(&s->exchange);
    const int64_t now_ns = lum_time_monotonic_ns();
    if (step_ns <= now_ns) {
        return false;
    }
    if (deadline_ns <= now_ns) {
        out->kind = LUM_SENSOR_IDLE;
        return true;
    }
    const lum_net_result r =
        lum_socket_wait(&s->socket, 1, -1, cancel,
                        step_ns < deadline_ns ? step_ns : deadline_ns);
    if (r == LUM_NET_CANCELLED) {
        out->kind = LUM_SENSOR_CANCELLED;
        return true;
    }
    if (r != LUM_NET_OK && r != LUM_NET_TIMEOUT) {
        (void)lum_error_set(&s->failure, "cannot wait for datagrams from %s",
                            lum_endpoint_show(s->endpoint).text);
        fail(s, out);
        return true;
    }
    return false;
}

void lum_session_receive(lum_sensor *s, const lum_cancel *cancel,
                         int64_t deadline_ns, lum_sensor_event *out)
{
    unsigned late = 0;
    memset(out, 0, sizeof *out);
    if (s->has_failed) {
        fail(s, out);
        return;
    }
    for (;;) {
        if (do_what_is_due(s, cancel, out) || read_socket(s, out)) {
            return;
        }
        if (s->batch.socket_is_empty) {
            if (wait_for_more(s, cancel, deadline_ns, out)) {
                return;
            }
        } else if (deadline_ns <= s->batch.received_ns &&
                   ++late >= LATE_BATCHES) {
            return;
        }
    }
}
