#include "lum/net/sensor.h"

#include "base/sized.h"
#include "lum/base/time.h"
#include "net/endpoint.h"
#include "net/session.h"

#include <stdlib.h>
#include <string.h>

static int check_options(const lum_sensor_options *options, lum_error *error)
{
    if (!lum_address_is_host(options->sensor.address) ||
        options->sensor.port == 0) {
        return lum_error_set(
            error,
            "%s: no sensor can be there; give the address of one host, such "
            "as 10.42.0.37, and a port that is not 0",
            lum_endpoint_show(options->sensor).text);
    }
    if (options->heartbeat_ms < LUM_SENSOR_HEARTBEAT_MIN_MS ||
        options->heartbeat_ms > LUM_SENSOR_HEARTBEAT_MAX_MS) {
        return lum_error_set(
            error, "heartbeats every %lu ms: 10 to %u ms are allowed",
            (unsigned long)options->heartbeat_ms, LUM_SENSOR_HEARTBEAT_MAX_MS);
    }
    if (options->timeout_ms == 0) {
        return lum_error_set(error, "a timeout of 0 ms: at least 1 ms is "
                                    "needed for an answer to come");
    }
    return 0;
}

/* Not a secret; it should only differ from that of the session before. */
static uint32_t random_sequence(const lum_sensor *s)
{
    lum_endpoint local;
    lum_socket_local(s->socket, &local);
    uint64_t x = (uint64_t)lum_time_utc_ns() ^
                 ((uint64_t)lum_time_monotonic_ns() << 20) ^
                 ((uint64_t)local.port << 48);
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    const uint32_t sequence = (uint32_t)(x >> 32);
    return sequence != 0 ? sequence : 1u;
}

static void begin_exchange(lum_sensor *s, const lum_sensor_options *options)
{
    const lum_exchange_config config = {
        .status_tlv = options->layout.profile.tlv[LUM_TLV_STATUS],
        .owns = options->owns,
        .first = options->has_sequence ? options->sequence : random_sequence(s),
        .heartbeat_ns = NS_PER_MS * options->heartbeat_ms,
        .timeout_ns = NS_PER_MS * options->timeout_ms,
        .retries = options->retries};
    lum_exchange_init(&s->exchange, &config);
}

static lum_net_result open_parts(lum_sensor *s,
                                 const lum_sensor_options *options,
                                 lum_error *error)
{
    const lum_socket_options wanted = {
        .struct_size = sizeof wanted,
        .interface_name = options->interface_name,
        .receive_buffer = options->receive_buffer,
        .takes_joined = options->takes_joined};
    if (options->owns) {
        const lum_net_result r = lum_owner_take(
            options->sensor, options->interface_name, &s->owner, error);
        if (r != LUM_NET_OK) {
            return r;
        }
    }
    return lum_socket_open(&wanted, &s->socket, error);
}

static lum_net_result open_known(const lum_sensor_options *options,
                                 lum_sensor **out, lum_error *error)
{
    lum_sensor *s = calloc(1, sizeof *s);
    if (s == NULL) {
        (void)lum_error_set(error, "no memory for a session");
        return LUM_NET_FAILED;
    }
    s->endpoint = options->sensor;
    s->layout = options->layout;
    s->owns = options->owns;
    s->retries = options->retries;
    s->cancel = options->cancel;
    s->link.is_up = true;
    s->link.told = true;
    const lum_net_result r = open_parts(s, options, error);
    if (r != LUM_NET_OK) {
        lum_sensor_close(s);
        return r;
    }
    begin_exchange(s, options);
    *out = s;
    return LUM_NET_OK;
}

lum_net_result lum_sensor_open(const lum_sensor_options *options,
                               lum_sensor **out, lum_error *error)
{
    lum_sensor_options known;
    if (lum_sized_take(&known, sizeof known, options, "the session's options",
                       "lum_sensor_options", error) != 0 ||
        check_options(&known, error) != 0) {
        return LUM_NET_FAILED;
    }
    return open_known(&known, out, error);
}

bool lum_sensor_is_owned(lum_endpoint sensor, const char *interface_name,
                         lum_error *who)
{
    return lum_owner_look(sensor, interface_name, who);
}

void lum_sensor_close(lum_sensor *sensor)
{
    if (sensor != NULL) {
        lum_socket_close(sensor->socket);
        lum_owner_release(sensor->owner);
        free(sensor);
    }
}

void lum_sensor_receive(lum_sensor *sensor, int64_t deadline_ns,
                        lum_sensor_event *out)
{
    lum_session_receive(sensor, sensor->cancel, deadline_ns, out);
}

/* When a session has something to do without a datagram. */
static int64_t due_ns(const lum_sensor *s)
{
    const bool has_event = s->has_failed || s->batch.next < s->batch.count ||
                           s->link.told != s->link.is_up;
    return has_event ? INT64_MIN : lum_exchange_next_ns(&s->exchange);
}

lum_net_result lum_sensor_wait_any(lum_sensor *const *sensors, size_t count,
                                   int extra_fd, const lum_cancel *cancel,
                                   int64_t deadline_ns)
{
    lum_socket *sockets[LUM_SOCKET_WAIT_MAX];
    int64_t first_ns = INT64_MAX;
    if (count > LUM_SOCKET_WAIT_MAX) {
        return LUM_NET_FAILED;
    }
    if (lum_cancel_is_raised(cancel)) {
        return LUM_NET_CANCELLED;
    }
    for (size_t i = 0; i < count; i++) {
        const int64_t due = due_ns(sensors[i]);
        sockets[i] = sensors[i]->socket;
        first_ns = due < first_ns ? due : first_ns;
    }
    if (first_ns <= lum_time_monotonic_ns()) {
        return LUM_NET_OK;
    }
    const lum_net_result r =
        lum_socket_wait(sockets, count, extra_fd, cancel,
                        first_ns < deadline_ns ? first_ns : deadline_ns);
    return r == LUM_NET_TIMEOUT && first_ns <= deadline_ns ? LUM_NET_OK : r;
}

lum_result lum_sensor_request(lum_sensor *sensor, const void *tlvs, size_t len)
{
    return lum_exchange_request(&sensor->exchange, lum_time_monotonic_ns(),
                                tlvs, len);
}

lum_result lum_sensor_command(lum_sensor *sensor, const char *text)
{
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES];
    lum_tlv_writer writer;
    const size_t len = strlen(text);
    if (lum_tlv_begin(&writer, packet, sizeof packet, 0) != LUM_OK ||
        len > sizeof packet ||
        lum_tlv_add(&writer, sensor->layout.profile.tlv[LUM_TLV_COMMAND], text,
                    (uint16_t)len) != LUM_OK) {
        return LUM_E_SPACE;
    }
    return lum_sensor_request(sensor, packet + LUM_TLV_PACKET_BYTES,
                              writer.len - LUM_TLV_PACKET_BYTES);
}

lum_result lum_sensor_request_time(lum_sensor *sensor)
{
    return lum_exchange_request_time(&sensor->exchange,
                                     lum_time_monotonic_ns());
}

bool lum_sensor_is_waiting(const lum_sensor *sensor)
{
    return sensor->exchange.ask != LUM_ASK_NOTHING;
}

void lum_sensor_give_up(lum_sensor *sensor)
{
    lum_exchange_give_up(&sensor->exchange);
}

lum_net_result lum_sensor_set_ip(lum_sensor *sensor, uint32_t address,
                                 lum_error *error)
{
    uint8_t packet[LUM_SET_IP_BYTES];
    uint64_t sent = 0;
    if (lum_set_ip_encode(packet, &sensor->layout, address) != LUM_OK) {
        (void)lum_error_set(error,
                            "%s cannot be a sensor's address; give that of "
                            "one host, such as 10.42.0.99",
                            lum_endpoint_show_address(address).text);
        return LUM_NET_FAILED;
    }
    return lum_session_send(sensor, packet, sizeof packet, &sent, error);
}

lum_result lum_sensor_count(lum_sensor *sensor, lum_sensor_counters *out)
{
    sensor->counters.kernel_drops = lum_socket_drops(sensor->socket);
    sensor->counters.joined = lum_socket_joined(sensor->socket);
    return lum_sized_fill(out, &sensor->counters, sizeof sensor->counters)
               ? LUM_OK
               : LUM_E_VALUE;
}

bool lum_sensor_moved_to(const lum_sensor *sensor, lum_endpoint *out)
{
    if (sensor->stranger.count < LUM_SENSOR_MOVED_COUNT) {
        return false;
    }
    *out = sensor->stranger.from;
    return true;
}

lum_socket *lum_sensor_socket(lum_sensor *sensor)
{
    return sensor->socket;
}

lum_endpoint lum_sensor_endpoint(const lum_sensor *sensor)
{
    return sensor->endpoint;
}
