/* A session as its sensor, strangers, the network and the application might
 * treat it: any datagrams, any times, any calls. */
#include "fake_net.h"

#include "lum/laser.h"
#include "lum/live/laser_off.h"
#include "lum/net/sensor.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define MS      INT64_C(1000000)
#define TIMEOUT (40 * MS)
#define SLACK   (30 * MS) /* what a flood of full batches costs */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static const lum_endpoint peers[] = {{LUM_BOOT_ADDRESS, LUM_PORT},
                                     {LUM_BOOT_ADDRESS, 1234},
                                     {0x0a2a0063, LUM_PORT},
                                     {LUM_BOOT_ADDRESS, LUM_PORT}};

/* What the input decides. */
static struct run {
    const uint8_t *next;
    size_t left;
    lum_sensor *sensor;
    lum_sensor_options options;
    uint32_t sequence; /* of the last request that was sent */
    uint64_t begun;    /* requests */
    uint64_t off_resends;
    int64_t start_ns;
    int64_t beat_ns;     /* last heartbeat, or when one could leave again */
    int64_t called_ns;   /* when the session was called */
    int64_t slack_ns;    /* what a flood may cost in this call */
    int64_t held_up_ns;  /* since all that was due was sent */
    bool was_held_up;    /* too long for a request to be sent again */
    uint8_t helpfulness; /* how often the sensor answers by itself */
} run;

static uint8_t take_byte(void)
{
    if (run.left == 0) {
        return 0;
    }
    run.left--;
    return *run.next++;
}

static size_t take_bytes(uint8_t *out, size_t most)
{
    const size_t n = run.left < most ? run.left : most;
    memcpy(out, run.next, n);
    run.next += n;
    run.left -= n;
    return n;
}

static void arrive_status(lum_endpoint from, int64_t ns, uint32_t sequence,
                          uint16_t status)
{
    uint8_t packet[32];
    lum_tlv_writer w;
    require(lum_tlv_begin(&w, packet, sizeof packet, sequence) == LUM_OK);
    require(lum_tlv_add_u16(&w, 2, status) == LUM_OK);
    fake_arrive(ns, from, packet, w.len);
}

static void arrive_time(lum_endpoint from, int64_t ns, uint32_t sequence)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp t = {sequence, (uint32_t)(ns / 1000)};
    lum_timestamp_encode(packet, &t);
    fake_arrive(ns, from, packet, sizeof packet);
}

/* While the session is called, heartbeats are no further apart than asked. */
static void check_beat(void)
{
    const int64_t since =
        run.beat_ns > run.called_ns ? run.beat_ns : run.called_ns;
    require(fake.now_ns - since <=
            run.options.heartbeat_ms * MS + run.slack_ns);
}

/* Everything that is sent is a whole packet, and goes to the sensor. */
static void on_send(const struct fake_sent *sent)
{
    uint8_t type = 0;
    uint32_t address = 0;
    lum_timestamp time;
    lum_tlv_reader tlvs;
    require(sent->to.address == peers[0].address);
    require(sent->to.port == peers[0].port);
    require(lum_header_decode(sent->bytes, sent->len, &type) == LUM_OK);
    const bool answers = run.helpfulness > take_byte();
    const int64_t at = sent->ns + (answers ? take_byte() * MS / 2 : 0);
    if (lum_timestamp_decode(sent->bytes, sent->len, &time) == LUM_OK) {
        require(sent->len == LUM_TIMESTAMP_BYTES);
        run.sequence = time.sequence;
        run.held_up_ns = 0;
        if (answers) {
            arrive_time(peers[0], at, run.sequence);
        }
    } else if (lum_tlv_open(sent->bytes, sent->len, &run.sequence, &tlvs) ==
               LUM_OK) {
        run.held_up_ns = 0;
        if (answers) {
            arrive_status(peers[0], at, run.sequence,
                          (uint16_t)(take_byte() << 4));
        }
    } else if (type == LUM_TYPE_HEARTBEAT) {
        require(run.options.owns && sent->len == LUM_HEARTBEAT_BYTES);
        check_beat();
        run.beat_ns = sent->ns;
    } else {
        require(lum_set_ip_decode(&run.options.layout, sent->bytes, sent->len,
                                  &address) == LUM_OK);
    }
}

static void arrive_anything(unsigned kind)
{
    uint8_t bytes[256] = {0};
    const lum_endpoint from = peers[take_byte() % 4u];
    const int64_t at = fake.now_ns + take_byte() * MS;
    const uint32_t sequence = run.sequence + 2u - take_byte() % 5u;
    uint8_t how = 0;
    size_t len = 0;
    switch (kind) {
    case 0:
        arrive_status(from, at, sequence, (uint16_t)(take_byte() << 4));
        break;
    case 1:
        arrive_time(from, at, sequence);
        break;
    case 2:
        lum_header_encode(bytes, take_byte() % 10u);
        memcpy(bytes + LUM_HEADER_BYTES, &sequence, sizeof sequence);
        how = take_byte();
        len = LUM_TLV_PACKET_BYTES;
        len += take_bytes(bytes + len, how % 64u);
        fake_arrive(at, from, bytes, how < 128u ? len : how % 64u);
        break;
    default:
        len = take_bytes(bytes, take_byte());
        fake_arrive(at, from, bytes, len);
        break;
    }
}

static void check_answer(const lum_sensor_event *e)
{
    require(e->tries >= 1 && e->tries <= run.options.retries + 1u);
    require(e->sent_ns >= run.start_ns && e->sent_ns <= e->received_ns);
    require(e->received_ns <= fake.now_ns);
}

static void check_tlvs(const lum_sensor_event *e)
{
    lum_tlv_reader reader = e->tlvs;
    lum_tlv tlv;
    bool has_status = false;
    lum_result r = LUM_OK;
    while ((r = lum_tlv_next(&reader, &tlv)) == LUM_OK) {
        has_status = has_status || (tlv.type == 2 && tlv.length >= 2);
    }
    require(r == LUM_END);
    require(has_status == e->has_status);
}

static void check_datagrams(const lum_sensor_event *e)
{
    unsigned sum = 0;
    require(run.options.owns);
    require(e->datagram_count >= 1 && e->datagram_count <= LUM_SOCKET_BATCH);
    for (size_t i = 0; i < e->datagram_count; i++) {
        const lum_received *r = &e->datagrams[i];
        require(r->from.address == peers[0].address);
        require(r->from.port == peers[0].port);
        for (size_t at = 0; at < r->len; at++) {
            sum += r->bytes[at];
        }
    }
    require(sum < UINT32_MAX);
}

static void check_event(const lum_sensor_event *e, bool was_waiting,
                        int64_t deadline_ns)
{
    const bool waits = lum_sensor_is_waiting(run.sensor);
    switch (e->kind) {
    case LUM_SENSOR_IDLE:
        require(fake.now_ns >= deadline_ns && waits == was_waiting);
        run.held_up_ns = 0;
        break;
    case LUM_SENSOR_CANCELLED:
        require(fake.is_raised && waits == was_waiting);
        break;
    case LUM_SENSOR_DATAGRAMS:
        check_datagrams(e);
        break;
    case LUM_SENSOR_ANSWER:
        check_tlvs(e);
        check_answer(e);
        require(was_waiting && !waits);
        break;
    case LUM_SENSOR_TIME:
        check_answer(e);
        require(was_waiting && !waits);
        break;
    case LUM_SENSOR_NO_ANSWER:
        require(was_waiting && !waits);
        require(e->tries == run.options.retries + 1u ||
                (run.was_held_up && e->tries <= run.options.retries));
        break;
    case LUM_SENSOR_ALERT:
        check_tlvs(e);
        break;
    case LUM_SENSOR_LINK:
        require(e->is_up || e->error.text[0] != '\0');
        break;
    case LUM_SENSOR_FAILED:
    default:
        abort();
    }
}

static void receive(int64_t for_ns)
{
    lum_sensor_event e;
    const int64_t before_ns = fake.now_ns;
    const int64_t deadline_ns = before_ns + for_ns;
    const bool was_waiting = lum_sensor_is_waiting(run.sensor);
    run.called_ns = before_ns;
    lum_sensor_receive(run.sensor, deadline_ns, &e);
    require(fake.now_ns <= deadline_ns + run.slack_ns);
    check_event(&e, was_waiting, deadline_ns);
    if (run.options.owns && fake.send == LUM_NET_OK) {
        run.called_ns = 0;
        if (fake.is_raised) { /* none is sent by what is told to end */
            run.beat_ns = fake.now_ns;
        }
        check_beat();
    }
}

static void begin(lum_result r)
{
    require(r == LUM_OK || r == LUM_E_VALUE);
    require(lum_sensor_is_waiting(run.sensor));
    if (r == LUM_OK) {
        run.begun++;
        run.held_up_ns = 0;
        run.was_held_up = false;
    }
}

static void hold_up(int64_t ns)
{
    fake.now_ns += ns;
    run.held_up_ns += ns;
    /* a flood before may have added some */
    run.was_held_up =
        run.was_held_up || run.held_up_ns + SLACK >= LUM_SENSOR_STALE_MS * MS;
}

static void laser_off(void)
{
    uint16_t status = 0;
    const uint32_t ms = take_byte();
    const uint64_t sent = fake.sent_count;
    const int64_t before_ns = fake.now_ns;
    const lum_laser_off end =
        lum_sensor_laser_off(run.sensor, ms, run.options.cancel, &status);
    require(end != LUM_LASER_OFF_SEEN || lum_laser_is_down(status));
    const bool waits = (status & LUM_LASER_TLV_CMD_ON) != 0;
    require(end != LUM_LASER_OFF_REFUSED || !lum_laser_is_down(status) ||
            waits);
    require(fake.now_ns - before_ns <=
            (ms + LUM_SENSOR_SETTLE_MS + 2000) * MS + 4 * SLACK);
    require(fake.send != LUM_NET_OK || fake.sent_count > sent);
    require(!lum_sensor_is_waiting(run.sensor));
    run.begun += ms + 4u; /* each has an answer, after 1 ms at the soonest */
    run.off_resends += ms / LUM_SENSOR_OFF_EVERY_MS + 64u;
    run.beat_ns = fake.now_ns;
}

static void wait_any(void)
{
    const int64_t deadline_ns = fake.now_ns + take_byte() * MS;
    const lum_net_result r = lum_sensor_wait_any(
        &run.sensor, 1, -1, run.options.cancel, deadline_ns);
    require(r == LUM_NET_OK || r == LUM_NET_TIMEOUT || r == LUM_NET_CANCELLED);
    require(r != LUM_NET_TIMEOUT || fake.now_ns >= deadline_ns);
}

static void change_network(void)
{
    /* Receives: after a deadline a session makes 16 more. The last outlasts
     * any call. */
    static const uint32_t lengths[] = {17, 20, 24, 32, 48, 80, 250, 3000};
    const uint8_t what = take_byte();
    fake.send = (what & 1u) != 0 ? LUM_NET_FAILED : LUM_NET_OK;
    run.beat_ns = fake.now_ns;
    fake.is_raised = (what & 2u) != 0;
    const unsigned length = (what & 8u) / 8u + what / 64u * 2u;
    fake.floods = (what & 4u) != 0 ? lengths[length] : 0;
    fake.flooder = peers[(what >> 4) % 4u];
}

static void step(void)
{
    const uint8_t op = take_byte();
    fake.receive_ns = fake.floods > 0 ? MS : 0;
    run.slack_ns = fake.floods > 0 ? SLACK : 0;
    switch (op % 16u) {
    case 0:
        begin(lum_sensor_request(run.sensor, NULL, 0));
        break;
    case 1:
        begin(lum_sensor_command(run.sensor, "50p u"));
        break;
    case 2:
        begin(lum_sensor_request_time(run.sensor));
        break;
    case 3:
        lum_sensor_give_up(run.sensor);
        break;
    case 4:
        hold_up((int64_t)take_byte() * take_byte() * MS / 10);
        break;
    case 5:
        laser_off();
        break;
    case 6:
        wait_any();
        break;
    case 7:
        change_network();
        break;
    case 8:
    case 9:
    case 10:
    case 11:
        arrive_anything(op % 4u);
        break;
    case 12:
        (void)!lum_sensor_set_ip(run.sensor, take_byte(), NULL);
        break;
    default:
        receive(take_byte() * MS);
        break;
    }
}

static void check_counters(void)
{
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_sensor_count(run.sensor, &c);
    const int64_t passed = fake.now_ns - run.start_ns;
    const uint64_t beats =
        (uint64_t)(passed / (MS * run.options.heartbeat_ms)) + 1u;
    require(c.heartbeats <= (run.options.owns ? beats : 0u));
    require(c.requests <= run.begun && c.answers <= run.begun);
    require(c.resends <= run.begun * run.options.retries + run.off_resends);
    require(c.answers + c.answers_dropped + c.alerts + c.malformed <=
            c.datagrams);
    require(c.other_port <= c.foreign_source);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const uint32_t firsts[] = {100, 0, 0xfffffffdu, 1};
    memset(&run, 0, sizeof run);
    run.next = data;
    run.left = size;
    fake_reset();
    fake.on_send = on_send;
    run.start_ns = fake.now_ns;
    lum_sensor_options_default(&run.options);
    const uint8_t how = take_byte();
    run.options.owns = (how & 1u) != 0;
    run.options.retries = (how >> 1) % 4u;
    run.options.has_sequence = true;
    run.options.sequence = firsts[(how >> 3) % 4u];
    run.options.heartbeat_ms = (how & 32u) != 0 ? 10 : 200;
    run.options.timeout_ms = TIMEOUT / MS;
    run.options.cancel = (lum_cancel *)(void *)&run;
    run.helpfulness = take_byte();
    require(lum_sensor_open(&run.options, &run.sensor, NULL) == LUM_NET_OK);
    while (run.left > 0) {
        step();
        check_counters();
        fake.sent_count = 0;
    }
    lum_sensor_close(run.sensor);
    return 0;
}
