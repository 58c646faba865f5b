#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/base/time.h"
#include "lum/net/sensor.h"

#include <stdio.h>
#include <string.h>

#define MS INT64_C(1000000)

/* Long enough to be seen as a hang. */
#define A_MINUTE (60000 * MS)

/* 127.62.1.0 and what follows: this test's alone. */
#define HERE UINT32_C(0x7f3e0100)

#define STATUS 0x0a00u

/* The end of the wire where a sensor would be. */
struct peer {
    lum_socket *socket;
    lum_endpoint at;
    lum_endpoint client; /* who sent the last datagram */
    uint8_t bytes[LUM_SENSOR_REQUEST_BYTES];
    size_t len;
};

static void peer_open(struct peer *p, unsigned host, uint16_t port)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {HERE + host, port}};
    lum_error error = {""};
    memset(p, 0, sizeof *p);
    if (lum_socket_open(&options, &p->socket, &error) != LUM_NET_OK) {
        fail_msg("%s", error.text);
    }
    lum_socket_local(p->socket, &p->at);
}

/* Takes the datagrams that came; how many. Keeps the last. */
static size_t peer_take(struct peer *p)
{
    size_t total = 0;
    size_t count = 0;
    do {
        lum_received *got = NULL;
        assert_int_equal(lum_socket_receive(p->socket, &got, &count, NULL),
                         LUM_NET_OK);
        if (count > 0) {
            const lum_received *last = &got[count - 1];
            assert_true(last->len <= sizeof p->bytes);
            p->client = last->from;
            p->len = last->len;
            memcpy(p->bytes, last->bytes, last->len);
        }
        total += count;
    } while (count > 0);
    return total;
}

static void peer_send(struct peer *p, lum_endpoint to, const void *bytes,
                      size_t len)
{
    const lum_outgoing out = {bytes, len, to};
    lum_error error = {""};
    if (lum_socket_send(p->socket, &out, &error) != LUM_NET_OK) {
        fail_msg("%s", error.text);
    }
}

static void peer_answer(struct peer *p, lum_endpoint to, uint32_t sequence)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                     LUM_OK);
    assert_int_equal(lum_tlv_add_u16(&w, 2, STATUS), LUM_OK);
    peer_send(p, to, packet, w.len);
}

static lum_sensor_options options_for(const struct peer *p, bool owns)
{
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = p->at;
    options.owns = owns;
    options.has_sequence = true;
    options.sequence = 100;
    options.receive_buffer = 0;
    return options;
}

static lum_sensor *open_with(const lum_sensor_options *options)
{
    lum_sensor *sensor = NULL;
    lum_error error = {""};
    if (lum_sensor_open(options, &sensor, &error) != LUM_NET_OK) {
        fail_msg("%s", error.text);
    }
    return sensor;
}

static lum_sensor *open_for(const struct peer *p, bool owns)
{
    const lum_sensor_options options = options_for(p, owns);
    return open_with(&options);
}

/* Does what is due; expects no event. */
static void let_send(lum_sensor *sensor)
{
    lum_sensor_event event;
    lum_sensor_receive(sensor, 0, &event);
    assert_int_equal(event.kind, LUM_SENSOR_IDLE);
}

static lum_sensor_event expect(lum_sensor *sensor, lum_sensor_event_kind kind)
{
    lum_sensor_event event;
    lum_sensor_receive(sensor, lum_time_monotonic_ns() + A_MINUTE, &event);
    assert_int_equal(event.kind, kind);
    return event;
}

static lum_sensor_counters counters(lum_sensor *sensor)
{
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_sensor_count(sensor, &c);
    return c;
}

static void a_request_is_answered(void **state)
{
    struct peer p;
    lum_tlv tlv;
    (void)state;
    peer_open(&p, 1, 0);
    lum_sensor *sensor = open_for(&p, false);
    assert_int_equal(lum_sensor_endpoint(sensor).address, p.at.address);
    const int64_t before = lum_time_monotonic_ns();
    assert_int_equal(lum_sensor_command(sensor, "50p u"), LUM_OK);
    let_send(sensor);
    assert_int_equal(peer_take(&p), 1);
    assert_int_equal(p.len, 25);
    assert_memory_equal(p.bytes + 12, "d\0\0\0\1\0\5\00050p u", 13);
    peer_answer(&p, p.client, 100);
    lum_sensor_event e = expect(sensor, LUM_SENSOR_ANSWER);
    assert_int_equal(e.sequence, 100);
    assert_int_equal(e.tries, 1);
    assert_true(e.has_status);
    assert_int_equal(e.status, STATUS);
    assert_int_equal(lum_tlv_next(&e.tlvs, &tlv), LUM_OK);
    assert_int_equal(tlv.type, 2);
    assert_true(before <= e.sent_ns && e.sent_ns <= e.received_ns);
    assert_true(e.received_ns <= lum_time_monotonic_ns());
    assert_true(e.received_utc_ns > 0);
    assert_int_equal(counters(sensor).datagrams, 1);
    assert_int_equal(counters(sensor).bytes, 22);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

static void others_are_not_heard(void **state)
{
    struct peer p;
    struct peer other_port;
    struct peer other_address;
    (void)state;
    peer_open(&p, 2, 0);
    peer_open(&other_port, 2, 0);
    peer_open(&other_address, 3, p.at.port);
    lum_sensor *sensor = open_for(&p, true);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    let_send(sensor);
    assert_int_equal(peer_take(&p), 2);
    peer_answer(&other_port, p.client, 100);
    peer_answer(&other_address, p.client, 100);
    peer_answer(&other_address, p.client, 7);
    let_send(sensor);
    assert_true(lum_sensor_is_waiting(sensor));
    assert_int_equal(counters(sensor).foreign_source, 3);
    assert_int_equal(counters(sensor).other_port, 1);
    peer_answer(&p, p.client, 100);
    (void)expect(sensor, LUM_SENSOR_DATAGRAMS);
    (void)expect(sensor, LUM_SENSOR_ANSWER);
    lum_sensor_close(sensor);
    lum_socket_close(other_address.socket);
    lum_socket_close(other_port.socket);
    lum_socket_close(p.socket);
}

static void a_batch_comes_whole_and_then_its_answers(void **state)
{
    struct peer p;
    uint8_t data[100] = {0};
    (void)state;
    peer_open(&p, 4, 0);
    lum_sensor *sensor = open_for(&p, true);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    let_send(sensor);
    assert_int_equal(peer_take(&p), 2);
    lum_header_encode(data, LUM_TYPE_HEARTBEAT);
    for (uint8_t i = 0; i < 10; i++) {
        data[99] = i;
        peer_send(&p, p.client, data, sizeof data);
    }
    peer_answer(&p, p.client, 100);
    peer_answer(&p, p.client, 7);
    size_t seen = 0;
    while (seen < 12) {
        const lum_sensor_event e = expect(sensor, LUM_SENSOR_DATAGRAMS);
        for (size_t i = 0; i < e.datagram_count && seen + i < 10; i++) {
            assert_int_equal(e.datagrams[i].len, 100);
            assert_int_equal(e.datagrams[i].bytes[99], seen + i);
        }
        seen += e.datagram_count;
    }
    (void)expect(sensor, LUM_SENSOR_ANSWER);
    assert_int_equal(expect(sensor, LUM_SENSOR_ALERT).sequence, 7);
    let_send(sensor);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

static void a_silent_sensor_is_tried_and_given_up(void **state)
{
    struct peer p;
    (void)state;
    peer_open(&p, 5, 0);
    lum_sensor_options options = options_for(&p, false);
    options.timeout_ms = 20;
    options.retries = 2;
    lum_sensor *sensor = open_with(&options);
    const int64_t before = lum_time_monotonic_ns();
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    const lum_sensor_event e = expect(sensor, LUM_SENSOR_NO_ANSWER);
    assert_true(lum_time_monotonic_ns() - before >= 60 * MS);
    assert_int_equal(e.tries, 3);
    assert_int_equal(peer_take(&p), 3);
    assert_int_equal(p.bytes[12], 100);
    peer_answer(&p, p.client, 100);
    let_send(sensor);
    assert_int_equal(counters(sensor).answers_dropped, 1);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

static void an_earlier_try_of_a_time_request_counts(void **state)
{
    struct peer p;
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp answer = {100, 4711};
    (void)state;
    peer_open(&p, 6, 0);
    lum_sensor_options options = options_for(&p, false);
    options.timeout_ms = 20;
    options.retries = 1000000;
    lum_sensor *sensor = open_with(&options);
    assert_int_equal(lum_sensor_request_time(sensor), LUM_OK);
    let_send(sensor);
    const int64_t after_first = lum_time_monotonic_ns();
    lum_time_sleep_until(after_first + 25 * MS);
    let_send(sensor);
    assert_true(peer_take(&p) >= 2);
    assert_true(p.bytes[12] > 100);
    lum_timestamp_encode(packet, &answer);
    peer_send(&p, p.client, packet, sizeof packet);
    const lum_sensor_event e = expect(sensor, LUM_SENSOR_TIME);
    assert_int_equal(e.clock_us, 4711);
    assert_int_equal(e.sequence, 100);
    assert_true(e.sent_ns <= after_first);
    assert_true(e.received_ns - e.sent_ns >= 25 * MS);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

static void heartbeats_stop_with_the_calls_and_go_on_without_a_burst(
    void **state)
{
    struct peer p;
    lum_sensor_event event;
    (void)state;
    peer_open(&p, 7, 0);
    lum_sensor_options options = options_for(&p, true);
    options.heartbeat_ms = 10;
    lum_sensor *sensor = open_with(&options);
    const int64_t begin = lum_time_monotonic_ns();
    lum_sensor_receive(sensor, begin + 105 * MS, &event);
    assert_int_equal(event.kind, LUM_SENSOR_IDLE);
    const size_t beats = peer_take(&p);
    assert_int_equal(p.len, LUM_HEARTBEAT_BYTES);
    assert_in_range(beats, 1, 12);
    lum_time_sleep_until(lum_time_monotonic_ns() + 100 * MS);
    assert_int_equal(peer_take(&p), 0);
    let_send(sensor);
    assert_in_range(peer_take(&p), 1, 2);
    assert_in_range(counters(sensor).heartbeats, beats + 1, beats + 2);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

static void a_cancel_ends_the_wait(void **state)
{
    struct peer p;
    lum_cancel *cancel = NULL;
    (void)state;
    peer_open(&p, 8, 0);
    assert_int_equal(lum_cancel_new(&cancel, NULL), 0);
    lum_sensor_options options = options_for(&p, true);
    options.cancel = cancel;
    lum_sensor *sensor = open_with(&options);
    lum_cancel_raise(cancel);
    (void)expect(sensor, LUM_SENSOR_CANCELLED);
    assert_int_equal(lum_sensor_wait_any(&sensor, 1, -1, cancel, INT64_MAX),
                     LUM_NET_CANCELLED);
    lum_cancel_reset(cancel);
    let_send(sensor);
    lum_sensor_close(sensor);
    lum_cancel_free(cancel);
    lum_socket_close(p.socket);
}

static void a_sensor_has_one_owner_at_a_time(void **state)
{
    struct peer p;
    lum_sensor *second = NULL;
    lum_error error = {""};
    (void)state;
    peer_open(&p, 9, 0);
    const lum_sensor_options options = options_for(&p, true);
    lum_sensor *first = open_with(&options);
    assert_int_equal(lum_sensor_open(&options, &second, &error), LUM_NET_BUSY);
    assert_string_not_equal(error.text, "");
    assert_null(second);
    lum_sensor *guest = open_for(&p, false);
    assert_int_equal(lum_sensor_request(guest, NULL, 0), LUM_OK);
    let_send(guest);
    assert_int_equal(peer_take(&p), 1);
    peer_answer(&p, p.client, 100);
    (void)expect(guest, LUM_SENSOR_ANSWER);
    lum_sensor_close(guest);
    lum_sensor_close(first);
    lum_sensor_close(open_with(&options));
    lum_socket_close(p.socket);
}

#define SENSORS 5u
#define ROUNDS  20u

/* Each peer that got something answers the last request, maybe again. */
static void answer_all(struct peer *peers, const uint32_t *sequences)
{
    for (unsigned i = 0; i < SENSORS; i++) {
        if (peer_take(&peers[i]) > 0) {
            peer_answer(&peers[i], peers[i].client, sequences[i]);
        }
    }
}

/* Receives all events of a session; whether its answer was among them. */
static bool drain(lum_sensor *sensor, uint32_t sequence)
{
    lum_sensor_event e;
    bool is_answered = false;
    do {
        lum_sensor_receive(sensor, 0, &e);
        assert_true(e.kind == LUM_SENSOR_IDLE || e.kind == LUM_SENSOR_ANSWER ||
                    e.kind == LUM_SENSOR_DATAGRAMS);
        if (e.kind == LUM_SENSOR_ANSWER) {
            assert_int_equal(e.sequence, sequence);
            is_answered = true;
        }
    } while (e.kind != LUM_SENSOR_IDLE);
    return is_answered;
}

static void several_sensors_live_in_one_thread(void **state)
{
    struct peer peers[SENSORS];
    lum_sensor *sensors[SENSORS];
    uint32_t sequences[SENSORS];
    unsigned answers[SENSORS] = {0};
    unsigned total = 0;
    (void)state;
    for (unsigned i = 0; i < SENSORS; i++) {
        peer_open(&peers[i], 10 + i, 0);
        lum_sensor_options options = options_for(&peers[i], i % 2 == 0);
        options.sequence = sequences[i] = 1000 * i;
        options.timeout_ms = 60000;
        sensors[i] = open_with(&options);
        assert_int_equal(lum_sensor_request(sensors[i], NULL, 0), LUM_OK);
    }
    while (total < SENSORS * ROUNDS) {
        assert_int_equal(
            lum_sensor_wait_any(sensors, SENSORS, -1, NULL,
                                lum_time_monotonic_ns() + A_MINUTE),
            LUM_NET_OK);
        for (unsigned i = 0; i < SENSORS; i++) {
            if (drain(sensors[i], sequences[i]) && ++answers[i] < ROUNDS) {
                assert_int_equal(lum_sensor_request(sensors[i], NULL, 0),
                                 LUM_OK);
                sequences[i]++;
                let_send(sensors[i]);
            }
        }
        answer_all(peers, sequences);
        total = 0;
        for (unsigned i = 0; i < SENSORS; i++) {
            total += answers[i];
        }
    }
    for (unsigned i = 0; i < SENSORS; i++) {
        assert_int_equal(answers[i], ROUNDS);
        lum_sensor_close(sensors[i]);
        lum_socket_close(peers[i].socket);
    }
}

static void a_wait_for_nothing_ends_by_its_deadline(void **state)
{
    struct peer p;
    (void)state;
    peer_open(&p, 20, 0);
    lum_sensor *sensor = open_for(&p, false);
    const int64_t deadline = lum_time_monotonic_ns() + 20 * MS;
    assert_int_equal(lum_sensor_wait_any(&sensor, 1, -1, NULL, deadline),
                     LUM_NET_TIMEOUT);
    assert_true(lum_time_monotonic_ns() >= deadline);
    lum_sensor_close(sensor);
    lum_socket_close(p.socket);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_request_is_answered),
        cmocka_unit_test(others_are_not_heard),
        cmocka_unit_test(a_batch_comes_whole_and_then_its_answers),
        cmocka_unit_test(a_silent_sensor_is_tried_and_given_up),
        cmocka_unit_test(an_earlier_try_of_a_time_request_counts),
        cmocka_unit_test(
            heartbeats_stop_with_the_calls_and_go_on_without_a_burst),
        cmocka_unit_test(a_cancel_ends_the_wait),
        cmocka_unit_test(a_sensor_has_one_owner_at_a_time),
        cmocka_unit_test(several_sensors_live_in_one_thread),
        cmocka_unit_test(a_wait_for_nothing_ends_by_its_deadline),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
