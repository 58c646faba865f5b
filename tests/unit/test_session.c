#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "fake_net.h"
#include "lum/laser.h"
#include "lum/live/laser_off.h"
#include "lum/net/sensor.h"

#include <string.h>

#define MS      INT64_C(1000000)
#define SECOND  (1000 * MS)
#define TIMEOUT (400 * MS)

#define ON  LUM_LASER_TLV_CMD_ON
#define OFF LUM_LASER_TLV_CMD_OFF
#define FAN LUM_LASER_FAN_PWM_BAD

static const lum_endpoint sensor_at = {LUM_BOOT_ADDRESS, LUM_PORT};
static const lum_endpoint stranger = {0x0a2a0063, LUM_PORT};

static lum_sensor *sensor;
static lum_sensor_event event;

/* What the sensor of a test answers, one entry a TLV packet that it gets. */
static struct script {
    const uint16_t *statuses; /* SILENT: no answer */
    size_t count;             /* the last is repeated */
    size_t next;
    int64_t delay_ns;
    char asked[512]; /* u, d, or a point for a poll */
} script;

#define SILENT 0xffffu
#define BLIND  0xfffeu /* an answer without a status */

/* Of a command that is not answered, in the usual time. */
#define OFF_TIME (LUM_SENSOR_OFF_MS * MS)
#define OFF_SENT (LUM_SENSOR_OFF_MS / LUM_SENSOR_OFF_EVERY_MS + 1)

static void answer_from(lum_endpoint from, int64_t ns, uint32_t sequence,
                        uint16_t status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                     LUM_OK);
    assert_int_equal(lum_tlv_add_u16(&w, 2, status), LUM_OK);
    fake_arrive(ns, from, packet, w.len);
}

static void answer_script(const struct fake_sent *sent)
{
    uint32_t sequence = 0;
    lum_tlv_reader tlvs;
    lum_tlv tlv;
    if (lum_tlv_open(sent->bytes, sent->len, &sequence, &tlvs) != LUM_OK) {
        return;
    }
    const bool is_poll = lum_tlv_next(&tlvs, &tlv) != LUM_OK;
    const size_t at =
        script.next < script.count ? script.next : script.count - 1;
    assert_in_range(script.next, 0, sizeof script.asked - 2);
    script.asked[script.next++] = is_poll ? '.' : (char)tlv.value[0];
    if (script.statuses[at] == BLIND) {
        uint8_t packet[LUM_TLV_PACKET_BYTES];
        lum_tlv_writer w;
        assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                         LUM_OK);
        fake_arrive(sent->ns + script.delay_ns, sensor_at, packet, w.len);
    } else if (script.statuses[at] != SILENT) {
        answer_from(sensor_at, sent->ns + script.delay_ns, sequence,
                    script.statuses[at]);
    }
}

static void play(const uint16_t *statuses, size_t count)
{
    script.statuses = statuses;
    script.count = count;
    fake.on_send = answer_script;
}

#define PLAY(...)                                                              \
    play((const uint16_t[]){__VA_ARGS__},                                      \
         sizeof(const uint16_t[]){__VA_ARGS__} / sizeof(uint16_t))

static lum_sensor_options options_of(bool owns)
{
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.owns = owns;
    options.has_sequence = true;
    options.sequence = 100;
    return options;
}

static void open_as(const lum_sensor_options *options)
{
    lum_error error;
    assert_int_equal(lum_sensor_open(options, &sensor, &error), LUM_NET_OK);
}

static void open_with(bool owns, lum_cancel *cancel)
{
    lum_sensor_options options = options_of(owns);
    options.cancel = cancel;
    open_as(&options);
}

static int set_up(void **state)
{
    (void)state;
    fake_reset();
    memset(&script, 0, sizeof script);
    script.delay_ns = MS;
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    lum_sensor_close(sensor);
    sensor = NULL;
    return 0;
}

static lum_sensor_event_kind receive_for(int64_t ns)
{
    lum_sensor_receive(sensor, fake.now_ns + ns, &event);
    return event.kind;
}

static lum_sensor_counters counters(void)
{
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_sensor_count(sensor, &c);
    return c;
}

static void options_that_cannot_work_are_refused(void **state)
{
    lum_sensor_options options;
    lum_error error;
    (void)state;
    static const struct {
        lum_endpoint sensor;
        uint32_t heartbeat_ms;
        uint32_t timeout_ms;
        const char *message;
    } cases[] = {
        {{0, 5517}, 200, 400, "0.0.0.0:5517"},
        {{0xe0000001, 5517}, 200, 400, "224.0.0.1:5517"},
        {{0xffffffff, 5517}, 200, 400, "255.255.255.255:5517"},
        {{LUM_BOOT_ADDRESS, 0}, 200, 400, "10.42.0.37:0"},
        {{LUM_BOOT_ADDRESS, 5517}, 9, 400, "9 ms"},
        {{LUM_BOOT_ADDRESS, 5517}, 1001, 400, "1001 ms"},
        {{LUM_BOOT_ADDRESS, 5517}, 200, 0, "0 ms"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lum_sensor_options_default(&options);
        options.sensor = cases[i].sensor;
        options.heartbeat_ms = cases[i].heartbeat_ms;
        options.timeout_ms = cases[i].timeout_ms;
        assert_int_equal(lum_sensor_open(&options, &sensor, &error),
                         LUM_NET_FAILED);
        assert_non_null(strstr(error.text, cases[i].message));
        assert_null(sensor);
    }
}

static void numbers_begin_anywhere_but_at_zero(void **state)
{
    lum_sensor_options options;
    uint8_t first[4];
    (void)state;
    lum_sensor_options_default(&options);
    for (unsigned i = 0; i < 2; i++) {
        fake.now_ns += MS;
        assert_int_equal(lum_sensor_open(&options, &sensor, NULL), LUM_NET_OK);
        assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
        (void)receive_for(0);
        assert_int_not_equal(memcmp(fake.sent[i].bytes + 12,
                                    i == 0 ? "\0\0\0\0" : (char *)first, 4),
                             0);
        memcpy(first, fake.sent[i].bytes + 12, 4);
        lum_sensor_close(sensor);
    }
    sensor = NULL;
}

static void nothing_is_sent_before_receive(void **state)
{
    (void)state;
    open_with(true, NULL);
    fake.now_ns += 10 * SECOND;
    assert_int_equal(lum_sensor_command(sensor, "d"), LUM_OK);
    assert_true(lum_sensor_is_waiting(sensor));
    assert_int_equal(fake.sent_count, 0);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent_count, 2);
    assert_int_equal(fake.sent[0].len, LUM_HEARTBEAT_BYTES);
    assert_int_equal(fake.sent[0].to.address, sensor_at.address);
    assert_int_equal(fake.sent[0].to.port, sensor_at.port);
    assert_int_equal(fake.sent[1].bytes[8], LUM_TYPE_TLV);
}

static void heartbeats_keep_their_grid_while_receive_is_called(void **state)
{
    (void)state;
    open_with(true, NULL);
    const int64_t begin = fake.now_ns;
    for (unsigned i = 0; i < 100; i++) {
        assert_int_equal(receive_for(37 * MS), LUM_SENSOR_IDLE);
    }
    assert_int_equal(fake.sent_count, 1 + 3700 / 200);
    for (size_t i = 0; i < fake.sent_count; i++) {
        assert_true(fake.sent[i].ns == begin + (int64_t)i * 200 * MS);
    }
    assert_int_equal(counters().heartbeats, fake.sent_count);
}

static void a_long_wait_sends_heartbeats_too(void **state)
{
    (void)state;
    open_with(true, NULL);
    assert_int_equal(receive_for(2 * SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent_count, 11);
}

static void without_receive_no_heartbeat_and_then_one_not_a_burst(void **state)
{
    (void)state;
    open_with(true, NULL);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    fake.now_ns += 5 * SECOND + MS;
    assert_int_equal(fake.sent_count, 1);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent_count, 2);
    assert_int_equal(receive_for(199 * MS), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent_count, 3);
}

static void who_does_not_own_sends_none_and_gets_no_data(void **state)
{
    uint8_t data[64] = {0};
    (void)state;
    open_with(false, NULL);
    lum_header_encode(data, LUM_TYPE_HEARTBEAT);
    fake_arrive(fake.now_ns, sensor_at, data, sizeof data);
    assert_int_equal(receive_for(3 * SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent_count, 0);
    assert_int_equal(counters().datagrams, 1);
    assert_int_equal(counters().bytes, sizeof data);
}

static void an_owner_gets_the_batch_and_then_what_it_holds(void **state)
{
    uint8_t data[64] = {0};
    (void)state;
    open_with(true, NULL);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    const int64_t sent = fake.now_ns;
    lum_header_encode(data, LUM_TYPE_HEARTBEAT);
    const int64_t arrival = fake.now_ns + 3 * MS;
    fake_arrive(arrival, sensor_at, data, sizeof data);
    answer_from(stranger, arrival, 100, ON);
    answer_from(sensor_at, arrival, 100, OFF);
    answer_from(sensor_at, arrival, 7, ON);
    fake_arrive(arrival, sensor_at, data, sizeof data);
    answer_from(sensor_at, arrival + MS, 8, ON);

    assert_int_equal(receive_for(SECOND), LUM_SENSOR_DATAGRAMS);
    assert_int_equal(event.datagram_count, 4);
    const size_t lengths[] = {64, 22, 22, 64};
    for (size_t i = 0; i < 4; i++) {
        assert_int_equal(event.datagrams[i].len, lengths[i]);
        assert_int_equal(event.datagrams[i].from.address, sensor_at.address);
    }
    assert_true(lum_sensor_is_waiting(sensor));
    fake.now_ns += MS;
    assert_int_equal(receive_for(0), LUM_SENSOR_ANSWER);
    assert_false(lum_sensor_is_waiting(sensor));
    assert_int_equal(event.status, OFF);
    assert_true(event.sent_ns == sent);
    assert_true(event.received_ns == arrival);
    assert_true(event.received_utc_ns == arrival);
    assert_int_equal(receive_for(0), LUM_SENSOR_ALERT);
    assert_int_equal(event.sequence, 7);
    assert_int_equal(event.status, ON);
    assert_int_equal(receive_for(0), LUM_SENSOR_DATAGRAMS);
    assert_int_equal(receive_for(0), LUM_SENSOR_ALERT);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(counters().foreign_source, 1);
    assert_int_equal(counters().other_port, 0);
    assert_int_equal(counters().answers, 1);
    assert_int_equal(counters().alerts, 2);
}

/* Data, or any packet with the magic. */
static void packets_from(lum_endpoint from, size_t count)
{
    uint8_t packet[LUM_HEADER_BYTES + 4] = {0};
    lum_header_encode(packet, LUM_TYPE_HEARTBEAT);
    for (size_t i = 0; i < count; i++) {
        fake_arrive(fake.now_ns, from, packet, sizeof packet);
    }
    (void)receive_for(0);
}

static void a_sensor_that_was_moved_is_found_by_its_magic(void **state)
{
    const lum_endpoint other_port = {sensor_at.address, 1234};
    lum_endpoint to = {1, 1};
    (void)state;
    open_with(true, NULL);
    packets_from(sensor_at, 1);
    packets_from(stranger, LUM_SENSOR_MOVED_COUNT - 1u);
    assert_false(lum_sensor_moved_to(sensor, &to));
    assert_int_equal(to.address, 1);
    packets_from(stranger, 1);
    assert_true(lum_sensor_moved_to(sensor, &to));
    assert_int_equal(to.address, stranger.address);
    assert_int_equal(to.port, stranger.port);
    packets_from(sensor_at, 1); /* it is back */
    assert_false(lum_sensor_moved_to(sensor, &to));
    packets_from(other_port, 2 * LUM_SENSOR_MOVED_COUNT);
    assert_false(lum_sensor_moved_to(sensor, &to));
    for (unsigned i = 0; i < 2u * LUM_SENSOR_MOVED_COUNT; i++) {
        packets_from((lum_endpoint){stranger.address + i % 2u, LUM_PORT}, 1);
        fake_arrive(fake.now_ns, stranger, "junk", 4);
    }
    assert_false(lum_sensor_moved_to(sensor, &to));
}

static void only_the_sensors_address_and_port_count(void **state)
{
    const lum_endpoint other_port = {sensor_at.address, 1234};
    (void)state;
    open_with(false, NULL);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    answer_from(stranger, fake.now_ns, 100, ON);
    answer_from(other_port, fake.now_ns, 100, ON);
    answer_from(stranger, fake.now_ns, 7, ON);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(counters().foreign_source, 3);
    assert_int_equal(counters().other_port, 1);
    assert_int_equal(counters().datagrams, 0);
    answer_from(sensor_at, fake.now_ns, 100, OFF);
    assert_int_equal(receive_for(0), LUM_SENSOR_ANSWER);
    assert_int_equal(event.status, OFF);
}

static void late_and_repeated_answers_are_counted_and_dropped(void **state)
{
    (void)state;
    open_with(false, NULL);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    lum_sensor_give_up(sensor);
    answer_from(sensor_at, fake.now_ns, 100, ON);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    PLAY(OFF);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    answer_from(sensor_at, fake.now_ns + 2 * MS, 101, ON);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_ANSWER);
    assert_int_equal(event.status, OFF);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(counters().answers, 1);
    assert_int_equal(counters().answers_dropped, 2);
    assert_int_equal(counters().alerts, 0);
}

static void a_malformed_answer_is_counted_and_the_resend_gets_another(
    void **state)
{
    uint8_t packet[LUM_TLV_PACKET_BYTES + 3] = {0};
    lum_tlv_writer w;
    (void)state;
    open_with(false, NULL);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, 100), LUM_OK);
    fake_arrive(fake.now_ns, sensor_at, packet, sizeof packet);
    answer_from(sensor_at, fake.now_ns + TIMEOUT + MS, 100, OFF);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_ANSWER);
    assert_int_equal(event.tries, 2);
    assert_int_equal(counters().malformed, 1);
    assert_int_equal(counters().resends, 1);
}

static void a_silent_sensor_gives_no_answer_after_the_last_try(void **state)
{
    (void)state;
    open_with(false, NULL);
    const int64_t begin = fake.now_ns;
    PLAY(SILENT);
    assert_int_equal(lum_sensor_command(sensor, "u"), LUM_OK);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_NO_ANSWER);
    assert_true(fake.now_ns == begin + 5 * TIMEOUT);
    assert_int_equal(event.tries, 5);
    assert_int_equal(event.sequence, 100);
    assert_string_equal(script.asked, "uuuuu");
    assert_false(lum_sensor_is_waiting(sensor));
    assert_int_equal(counters().requests, 1);
    assert_int_equal(counters().resends, 4);
}

static void an_answer_that_waited_unread_is_not_missed(void **state)
{
    (void)state;
    open_with(false, NULL);
    PLAY(SILENT);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(4 * TIMEOUT + MS), LUM_SENSOR_IDLE);
    answer_from(sensor_at, fake.now_ns, 100, OFF);
    fake.now_ns += 10 * SECOND;
    assert_int_equal(receive_for(0), LUM_SENSOR_ANSWER);
}

static void a_time_answer_bears_the_time_of_its_try(void **state)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp answer = {100, 4711};
    (void)state;
    open_with(false, NULL);
    const int64_t sent = fake.now_ns;
    assert_int_equal(lum_sensor_request_time(sensor), LUM_OK);
    lum_timestamp_encode(packet, &answer);
    fake_arrive(sent + TIMEOUT + 3 * MS, sensor_at, packet, sizeof packet);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_TIME);
    assert_int_equal(event.clock_us, 4711);
    assert_int_equal(event.tries, 2);
    assert_true(event.sent_ns == sent);
    assert_true(event.received_ns == sent + TIMEOUT + 3 * MS);
    assert_int_equal(fake_count_sent(LUM_TYPE_TIMESTAMP), 2);
    assert_int_equal(fake.sent[1].bytes[12], 101);
}

static void requests_too_long_or_too_many_are_refused(void **state)
{
    static const uint8_t tlvs[LUM_SENSOR_REQUEST_BYTES];
    char text[LUM_SENSOR_REQUEST_BYTES];
    (void)state;
    open_with(false, NULL);
    memset(text, 'd', sizeof text);
    text[LUM_SENSOR_REQUEST_BYTES - 19] = '\0';
    assert_int_equal(lum_sensor_command(sensor, text), LUM_E_SPACE);
    assert_int_equal(
        lum_sensor_request(sensor, tlvs, LUM_SENSOR_REQUEST_BYTES - 15),
        LUM_E_SPACE);
    assert_false(lum_sensor_is_waiting(sensor));
    text[LUM_SENSOR_REQUEST_BYTES - 20] = '\0';
    assert_int_equal(lum_sensor_command(sensor, text), LUM_OK);
    assert_int_equal(lum_sensor_command(sensor, "d"), LUM_E_VALUE);
    assert_int_equal(lum_sensor_request_time(sensor), LUM_E_VALUE);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(fake.sent[0].len, LUM_SENSOR_REQUEST_BYTES);
}

static void a_passed_deadline_takes_what_is_there(void **state)
{
    (void)state;
    open_with(false, NULL);
    for (unsigned i = 0; i < 200; i++) {
        fake_arrive(fake.now_ns, stranger, "x", 1);
    }
    answer_from(sensor_at, fake.now_ns, 7, ON);
    lum_sensor_receive(sensor, 0, &event);
    assert_int_equal(event.kind, LUM_SENSOR_ALERT);
    lum_sensor_receive(sensor, INT64_MIN, &event);
    assert_int_equal(event.kind, LUM_SENSOR_IDLE);
}

/* Each receive brings a full batch and takes a millisecond. */
static void begin_flood(lum_endpoint from)
{
    fake.floods = UINT32_MAX;
    fake.flooder = from;
    fake.receive_ns = MS;
}

static void in_a_flood_deadlines_heartbeats_and_resends_keep_time(void **state)
{
    const lum_endpoint flooders[] = {stranger, sensor_at};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        fake_reset();
        open_with(i == 0, NULL);
        begin_flood(flooders[i]);
        const int64_t begin = fake.now_ns;
        assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
        assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
        assert_in_range(fake.now_ns - begin, SECOND, SECOND + 20 * MS);
        assert_int_equal(fake_count_sent(LUM_TYPE_TLV), 3);
        assert_int_equal(fake_count_sent(LUM_TYPE_HEARTBEAT), i == 0 ? 6 : 0);
        assert_int_equal(receive_for(5 * SECOND), LUM_SENSOR_NO_ANSWER);
        assert_in_range(fake.now_ns - begin, 5 * TIMEOUT,
                        6 * TIMEOUT + 20 * MS);
        lum_sensor_close(sensor);
    }
    sensor = NULL;
}

static void a_cancel_ends_waits_but_not_what_was_received(void **state)
{
    lum_cancel *const any = (lum_cancel *)(void *)&fake;
    (void)state;
    open_with(true, any);
    answer_from(sensor_at, fake.now_ns, 7, ON);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_DATAGRAMS);
    fake.is_raised = true;
    const int64_t begin = fake.now_ns;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_ALERT);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_CANCELLED);
    assert_true(fake.now_ns == begin);
    fake.is_raised = false;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
}

static void a_request_that_cancels_kept_for_too_long_is_not_sent(void **state)
{
    lum_cancel *const any = (lum_cancel *)(void *)&fake;
    (void)state;
    open_with(false, any);
    fake.is_raised = true;
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    for (unsigned waited_ms = 0; waited_ms < LUM_SENSOR_STALE_MS;
         waited_ms += 500) {
        assert_int_equal(receive_for(SECOND), LUM_SENSOR_CANCELLED);
        fake.now_ns += 500 * MS;
    }
    fake.is_raised = false;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_NO_ANSWER);
    assert_int_equal(event.tries, 0);
    assert_int_equal(fake_count_sent(LUM_TYPE_TLV), 0);
}

static void a_flood_does_not_keep_a_cancel_away(void **state)
{
    lum_cancel *const any = (lum_cancel *)(void *)&fake;
    (void)state;
    open_with(true, any);
    begin_flood(sensor_at);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_DATAGRAMS);
    fake.is_raised = true;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_CANCELLED);
}

static void a_link_is_told_once_a_change_and_the_session_lives_on(void **state)
{
    (void)state;
    open_with(true, NULL);
    assert_int_equal(receive_for(300 * MS), LUM_SENSOR_IDLE);
    fake.send = LUM_NET_FAILED;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_LINK);
    assert_false(event.is_up);
    assert_string_equal(event.error.text, "the network is down");
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(3 * SECOND), LUM_SENSOR_NO_ANSWER);
    assert_int_equal(counters().requests, 0);
    assert_in_range(counters().send_failures, 15, 25);
    fake.send = LUM_NET_OK;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_LINK);
    assert_true(event.is_up);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
    PLAY(OFF);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_DATAGRAMS);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_ANSWER);
}

static void a_broken_socket_ends_the_session(void **state)
{
    (void)state;
    open_with(true, NULL);
    fake.receive_breaks = true;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_FAILED);
    assert_string_equal(event.error.text, "broken by the test");
    fake.receive_breaks = false;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_FAILED);
    assert_string_equal(event.error.text, "broken by the test");
    assert_int_equal(fake.sent_count, 1);
    const int64_t begin = fake.now_ns;
    assert_int_equal(
        lum_sensor_laser_off(sensor, LUM_SENSOR_OFF_MS, NULL, NULL),
        LUM_LASER_OFF_UNKNOWN);
    assert_true(fake.now_ns - begin < SECOND);
}

static void a_broken_wait_ends_the_session(void **state)
{
    (void)state;
    open_with(false, NULL);
    fake.wait_breaks = true;
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_FAILED);
    assert_non_null(strstr(event.error.text, "10.42.0.37:5517"));
}

static void set_ip_leaves_at_once_or_says_why_not(void **state)
{
    lum_error error = {""};
    (void)state;
    open_with(false, NULL);
    assert_int_equal(lum_sensor_set_ip(sensor, 0x0a2a0063, &error), LUM_NET_OK);
    assert_int_equal(fake.sent_count, 1);
    assert_int_equal(fake.sent[0].len, LUM_SET_IP_BYTES);
    assert_memory_equal(fake.sent[0].bytes + 12, "\12\52\0\143", 4);
    assert_int_equal(lum_sensor_set_ip(sensor, 0, &error), LUM_NET_FAILED);
    assert_non_null(strstr(error.text, "0.0.0.0 "));
    fake.send = LUM_NET_DENIED;
    assert_int_equal(lum_sensor_set_ip(sensor, 1u << 24, &error),
                     LUM_NET_DENIED);
    assert_string_equal(error.text, "the network is down");
    assert_int_equal(fake.sent_count, 1);
}

static void drops_of_the_kernel_are_counted(void **state)
{
    (void)state;
    open_with(false, NULL);
    fake.drops = 5;
    assert_int_equal(counters().kernel_drops, 5);
}

/* Switches off by a script; returns what the sensor was asked. */
static lum_laser_off switch_off(uint16_t *status)
{
    *status = 0x5a5a;
    return lum_sensor_laser_off(sensor, LUM_SENSOR_OFF_MS, NULL, status);
}

/* How often a letter was asked one after the other, from a place on. */
static size_t run_of(char letter, size_t from)
{
    size_t n = 0;
    while (script.asked[from + n] == letter) {
        n++;
    }
    return n;
}

static void a_laser_seen_down_twice_is_off(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(OFF, OFF | 0x10);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_int_equal(status, OFF | 0x10);
    assert_string_equal(script.asked, "d.");
    assert_in_range(fake.now_ns - begin, 300 * MS, 310 * MS);
}

/* Its own 3 s begin at once, whatever is lost. */
static void no_heartbeat_leaves_while_it_is_switched_off(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(SILENT);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(fake_count_sent(LUM_TYPE_HEARTBEAT), 0);
    assert_false(lum_sensor_is_waiting(sensor));
    const size_t asked = script.next;
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(fake_count_sent(LUM_TYPE_HEARTBEAT), 1);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_IDLE);
    assert_int_equal(script.next, asked); /* nothing is left under way */
}

static void a_silent_sensor_is_asked_every_50_ms_for_10_s(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(SILENT);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(status, 0x5a5a);
    assert_int_equal(run_of('d', 0), 201);
    assert_int_equal(script.next, 201);
    assert_true(fake.now_ns - begin == 10 * SECOND);
    for (size_t i = 1; i < 201; i++) {
        assert_true(fake.sent[i].ns - fake.sent[i - 1].ns == 50 * MS);
    }
}

static void a_sensor_that_falls_silent_leaves_the_laser_unknown(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(OFF, SILENT);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(run_of('d', 0), 1);
    assert_int_equal(run_of('.', 1), 41); /* 2 s of looks */
    assert_in_range(run_of('d', 42), 150, 160);
    assert_int_equal(script.next, 42 + run_of('d', 42));
    assert_int_equal(status, OFF);
}

static void a_laser_that_stays_up_is_refused(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(ON);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_REFUSED);
    assert_int_equal(script.next, run_of('d', 0));
    assert_in_range(script.next, 30, 35);
    assert_in_range(fake.now_ns - begin, OFF_TIME, OFF_TIME + SECOND);
    assert_int_equal(status, ON);
}

static void a_laser_that_goes_down_late_is_off(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(ON, ON, ON, ON, ON, ON, ON, ON, OFF, OFF);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "ddddddddd.");
}

static void a_laser_that_flips_up_again_is_switched_off_again(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(OFF, ON, OFF, ON, OFF, OFF);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "d.d.d.");
    assert_int_equal(status, OFF);
}

/* Its `u` came between the two looks, in a hazard. */
static void a_laser_that_waits_for_a_hazards_end_is_switched_off_again(
    void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(OFF | FAN, ON | FAN, OFF | FAN, OFF | FAN);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "d.d.");
    assert_int_equal(status, OFF | FAN);
}

static void a_sensor_that_always_shows_a_command_to_be_on_is_off(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(ON | OFF | FAN);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "d.d.d.d.d.");
}

/* However few retries there are. */
static void a_laser_that_waits_is_never_called_off(void **state)
{
    uint16_t status = 0;
    (void)state;
    lum_sensor_options options = options_of(true);
    options.retries = 0;
    open_as(&options);
    PLAY(OFF | FAN, ON | FAN, OFF | FAN, ON | FAN, OFF | FAN, OFF | FAN);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "d.d.d.");
    memset(&script, 0, sizeof script);
    script.delay_ns = MS;
    PLAY(ON | FAN);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_REFUSED);
    assert_in_range(fake.now_ns - begin, OFF_TIME, OFF_TIME + SECOND);
    assert_int_equal(status, ON | FAN);
}

static void a_laser_that_keeps_flipping_is_refused(void **state)
{
    uint16_t flips[200];
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    for (size_t i = 0; i < sizeof flips / sizeof *flips; i++) {
        flips[i] = i % 2 == 0 ? OFF : ON;
    }
    play(flips, sizeof flips / sizeof *flips);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_REFUSED);
    assert_in_range(script.next, 60, 70);
}

static void lost_answers_do_not_keep_the_laser_on(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(SILENT, SILENT, OFF, SILENT, OFF);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "ddd..");
    assert_in_range(fake.now_ns - begin, 450 * MS, 460 * MS);
}

/* One answer in 30: with five tries of 400 ms this failed. */
static void nearly_every_answer_may_be_lost(void **state)
{
    uint16_t rare[190];
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    for (size_t i = 0; i < sizeof rare / sizeof *rare; i++) {
        rare[i] = i % 30 == 18 || i % 30 == 28 ? OFF : SILENT;
    }
    play(rare, sizeof rare / sizeof *rare);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
}

static void answers_without_a_status_are_told_apart_from_silence(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(BLIND);
    const int64_t begin = fake.now_ns;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNSEEN);
    assert_string_equal(script.asked, "ddddd");
    assert_in_range(fake.now_ns - begin, 5 * 300 * MS, 5 * 310 * MS);
    assert_int_equal(status, 0x5a5a);
    memset(&script, 0, sizeof script);
    script.delay_ns = MS;
    PLAY(BLIND, BLIND, BLIND, OFF, BLIND, OFF, OFF);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "dddd.d.");
}

static void raise_after_a_second(const struct fake_sent *sent)
{
    fake.is_raised = fake.is_raised || sent->ns >= 2 * SECOND;
}

static void a_given_time_and_a_cancel_end_it(void **state)
{
    const lum_cancel *const any = (const lum_cancel *)(const void *)&fake;
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(SILENT);
    int64_t begin = fake.now_ns;
    assert_int_equal(lum_sensor_laser_off(sensor, 300, NULL, &status),
                     LUM_LASER_OFF_UNKNOWN);
    assert_true(fake.now_ns - begin == 300 * MS);
    assert_string_equal(script.asked, "ddddddd");
    fake.on_send = raise_after_a_second;
    begin = fake.now_ns;
    assert_int_equal(lum_sensor_laser_off(sensor, 5000, any, &status),
                     LUM_LASER_OFF_UNKNOWN);
    assert_in_range(fake.now_ns, 2 * SECOND, 2 * SECOND + 100 * MS);
    fake.on_send = NULL;
    const size_t sent = fake.sent_count;
    assert_int_equal(lum_sensor_laser_off(sensor, 5000, any, &status),
                     LUM_LASER_OFF_UNKNOWN);
    assert_in_range(fake.sent_count, sent + 1, sent + 2);
}

/* Events that wait come before the command leaves. */
static void it_is_sent_once_whatever_waits_and_whoever_cancels(void **state)
{
    const lum_cancel *const any = (const lum_cancel *)(const void *)&fake;
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(SILENT);
    for (unsigned i = 0; i < 5; i++) {
        answer_from(sensor_at, fake.now_ns, 7, ON);
    }
    assert_int_equal(receive_for(0), LUM_SENSOR_DATAGRAMS);
    fake.is_raised = true;
    assert_int_equal(lum_sensor_laser_off(sensor, 0, any, &status),
                     LUM_LASER_OFF_UNKNOWN);
    assert_string_equal(script.asked, "d");
}

/* What the session asks afterwards has its own time again. */
static void other_requests_keep_their_timeout(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(false, NULL);
    PLAY(OFF);
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    PLAY(SILENT);
    const int64_t begin = fake.now_ns;
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(receive_for(5 * SECOND), LUM_SENSOR_NO_ANSWER);
    assert_int_equal(event.tries, 5);
    assert_true(fake.now_ns - begin == 5 * TIMEOUT);
}

static void alerts_and_old_answers_prove_nothing(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    PLAY(SILENT);
    assert_int_equal(lum_sensor_command(sensor, "u"), LUM_OK);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    for (int64_t ms = 1; ms < 10000; ms += 50) {
        answer_from(sensor_at, fake.now_ns + ms * MS, 100, OFF);
        answer_from(sensor_at, fake.now_ns + ms * MS, 7, OFF);
    }
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(script.next, 1 + OFF_SENT);
    assert_int_equal(status, 0x5a5a);
}

static void a_cancel_does_not_keep_the_laser_on(void **state)
{
    lum_cancel *const any = (lum_cancel *)(void *)&fake;
    uint16_t status = 0;
    (void)state;
    open_with(true, any);
    PLAY(OFF);
    fake.is_raised = true;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
    assert_string_equal(script.asked, "d.");
}

static void a_flood_does_not_keep_switching_off_from_ending(void **state)
{
    const lum_endpoint flooders[] = {stranger, sensor_at};
    uint16_t status = 0;
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        fake_reset();
        memset(&script, 0, sizeof script);
        open_with(true, NULL);
        PLAY(OFF);
        begin_flood(flooders[i]);
        const int64_t begin = fake.now_ns;
        assert_int_equal(switch_off(&status), LUM_LASER_OFF_SEEN);
        assert_in_range(fake.now_ns - begin, 300 * MS, 400 * MS);
        PLAY(SILENT);
        assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
        lum_sensor_close(sensor);
    }
    sensor = NULL;
}

static void a_link_lost_while_switching_off_is_told_afterwards(void **state)
{
    uint16_t status = 0;
    (void)state;
    open_with(true, NULL);
    fake.send = LUM_NET_FAILED;
    assert_int_equal(switch_off(&status), LUM_LASER_OFF_UNKNOWN);
    assert_int_equal(receive_for(SECOND), LUM_SENSOR_LINK);
    assert_false(event.is_up);
}

static lum_net_result wait_any(int64_t ns, const lum_cancel *cancel)
{
    return lum_sensor_wait_any(&sensor, 1, -1, cancel, fake.now_ns + ns);
}

static void a_wait_ends_when_something_is_to_be_done(void **state)
{
    const lum_cancel *const any = (const lum_cancel *)(const void *)&fake;
    (void)state;
    open_with(true, NULL);
    assert_int_equal(wait_any(SECOND, NULL), LUM_NET_OK); /* a heartbeat */
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    const int64_t begin = fake.now_ns;
    assert_int_equal(wait_any(10 * MS, NULL), LUM_NET_TIMEOUT);
    assert_int_equal(wait_any(SECOND, NULL), LUM_NET_OK); /* the next one */
    assert_true(fake.now_ns == begin + 200 * MS);
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
    assert_int_equal(wait_any(SECOND, NULL), LUM_NET_OK); /* the request */
    assert_int_equal(receive_for(0), LUM_SENSOR_IDLE);
    answer_from(sensor_at, fake.now_ns + MS, 100, OFF);
    assert_int_equal(wait_any(SECOND, NULL), LUM_NET_OK); /* the answer */
    assert_int_equal(receive_for(0), LUM_SENSOR_DATAGRAMS);
    const int64_t now = fake.now_ns;
    assert_int_equal(wait_any(SECOND, NULL),
                     LUM_NET_OK); /* not yet looked at */
    assert_true(fake.now_ns == now);
    assert_int_equal(receive_for(0), LUM_SENSOR_ANSWER);
    fake.is_raised = true;
    assert_int_equal(wait_any(SECOND, any), LUM_NET_CANCELLED);
    fake.is_raised = false;
    fake.wait_breaks = true;
    assert_int_equal(wait_any(SECOND, NULL), LUM_NET_FAILED);
}

#define FRESH(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FRESH(options_that_cannot_work_are_refused),
        FRESH(numbers_begin_anywhere_but_at_zero),
        FRESH(nothing_is_sent_before_receive),
        FRESH(heartbeats_keep_their_grid_while_receive_is_called),
        FRESH(a_long_wait_sends_heartbeats_too),
        FRESH(without_receive_no_heartbeat_and_then_one_not_a_burst),
        FRESH(who_does_not_own_sends_none_and_gets_no_data),
        FRESH(an_owner_gets_the_batch_and_then_what_it_holds),
        FRESH(a_sensor_that_was_moved_is_found_by_its_magic),
        FRESH(only_the_sensors_address_and_port_count),
        FRESH(late_and_repeated_answers_are_counted_and_dropped),
        FRESH(a_malformed_answer_is_counted_and_the_resend_gets_another),
        FRESH(a_silent_sensor_gives_no_answer_after_the_last_try),
        FRESH(an_answer_that_waited_unread_is_not_missed),
        FRESH(a_time_answer_bears_the_time_of_its_try),
        FRESH(requests_too_long_or_too_many_are_refused),
        FRESH(a_passed_deadline_takes_what_is_there),
        FRESH(in_a_flood_deadlines_heartbeats_and_resends_keep_time),
        FRESH(a_cancel_ends_waits_but_not_what_was_received),
        FRESH(a_request_that_cancels_kept_for_too_long_is_not_sent),
        FRESH(a_flood_does_not_keep_a_cancel_away),
        FRESH(a_link_is_told_once_a_change_and_the_session_lives_on),
        FRESH(a_broken_socket_ends_the_session),
        FRESH(a_broken_wait_ends_the_session),
        FRESH(set_ip_leaves_at_once_or_says_why_not),
        FRESH(drops_of_the_kernel_are_counted),
        FRESH(a_laser_seen_down_twice_is_off),
        FRESH(no_heartbeat_leaves_while_it_is_switched_off),
        FRESH(a_silent_sensor_is_asked_every_50_ms_for_10_s),
        FRESH(a_sensor_that_falls_silent_leaves_the_laser_unknown),
        FRESH(a_laser_that_stays_up_is_refused),
        FRESH(a_laser_that_goes_down_late_is_off),
        FRESH(a_laser_that_flips_up_again_is_switched_off_again),
        FRESH(a_laser_that_waits_for_a_hazards_end_is_switched_off_again),
        FRESH(a_sensor_that_always_shows_a_command_to_be_on_is_off),
        FRESH(a_laser_that_waits_is_never_called_off),
        FRESH(a_laser_that_keeps_flipping_is_refused),
        FRESH(lost_answers_do_not_keep_the_laser_on),
        FRESH(nearly_every_answer_may_be_lost),
        FRESH(answers_without_a_status_are_told_apart_from_silence),
        FRESH(a_given_time_and_a_cancel_end_it),
        FRESH(it_is_sent_once_whatever_waits_and_whoever_cancels),
        FRESH(other_requests_keep_their_timeout),
        FRESH(alerts_and_old_answers_prove_nothing),
        FRESH(a_cancel_does_not_keep_the_laser_on),
        FRESH(a_flood_does_not_keep_switching_off_from_ending),
        FRESH(a_link_lost_while_switching_off_is_told_afterwards),
        FRESH(a_wait_ends_when_something_is_to_be_done),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
