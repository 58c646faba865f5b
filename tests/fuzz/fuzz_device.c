/* Any datagrams and any times to a simulated sensor. */
#include "lum/command.h"
#include "lum/laser.h"
#include "lum/wire.h"
#include "sim/device.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PACKET_MAX 1472u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What a step of the input does; its first byte modulo their number. */
enum step {
    STEP_HEARTBEAT, /* from one of four peers */
    STEP_TIME,      /* u16 milliseconds, then a tick */
    STEP_TLV,       /* u16 length, TLVs */
    STEP_DATAGRAM,  /* u16 length, any bytes */
    STEP_PACKET,    /* type, u8 length, bytes behind a good header */
    STEP_HAZARDS,   /* u16 set, u16 clear */
    STEPS
};

struct run {
    lum_device device;
    lum_device before;
    lum_device_effects fx;
    lum_calibration calibration;
    const uint8_t *next;
    size_t left;
    int64_t now;
    int64_t heartbeat; /* the last one, as told here */
    uint32_t sequence;
    uint32_t clock_us; /* at the beginning */
};

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static unsigned take(struct run *run)
{
    if (run->left == 0) {
        return 0;
    }
    run->left--;
    return *run->next++;
}

static uint16_t take_u16(struct run *run)
{
    const unsigned low = take(run);
    return (uint16_t)(low | take(run) << 8);
}

static size_t take_bytes(struct run *run, size_t n, uint8_t *out)
{
    const size_t most = n < run->left ? n : run->left;
    if (most > 0) {
        memcpy(out, run->next, most);
    }
    run->next += most;
    run->left -= most;
    return most;
}

static void check_value(lum_command_id id, uint16_t value)
{
    const lum_command command = {id, value};
    char text[LUM_COMMAND_TEXT_BYTES];
    size_t len = 0;
    require(lum_command_format(&command, text, &len) == LUM_OK);
}

static void check_table(const lum_device_settings *s)
{
    int falls = 0;
    int rises = 0;
    require(s->yscan_count == 0 || s->yscan_count == s->lines);
    for (size_t i = 1; i < s->yscan_count; i++) {
        falls |= s->yscan[i] < s->yscan[i - 1];
        rises |= s->yscan[i] > s->yscan[i - 1];
    }
    require(!(falls && rises));
}

static void check_elevations(const struct run *run)
{
    const lum_device_settings *s = &run->device.settings;
    int32_t udeg[LUM_DEVICE_YSCAN_MAX];
    const lum_eye_calibration *eye = &run->calibration.eye[0];
    const bool aimed = lum_device_elevations(s, &run->device.layout, eye, udeg);
    require(aimed == (s->yscan_count > 0 || s->fov_deg > 0));
    for (size_t i = 0; aimed && i < s->lines; i++) {
        require(udeg[i] >= eye->elevation_min_udeg &&
                udeg[i] <= eye->elevation_max_udeg);
    }
}

static void check_settings(const struct run *run)
{
    const lum_device_settings *s = &run->device.settings;
    check_value(LUM_COMMAND_POWER, s->power);
    check_value(LUM_COMMAND_THRESHOLD_GREEN, s->threshold[LUM_EYE_GREEN]);
    check_value(LUM_COMMAND_THRESHOLD_BLUE, s->threshold[LUM_EYE_BLUE]);
    check_value(LUM_COMMAND_HOLDOFF, s->holdoff);
    check_value(LUM_COMMAND_OFFSET_GREEN, s->offset[LUM_EYE_GREEN]);
    check_value(LUM_COMMAND_OFFSET_BLUE, s->offset[LUM_EYE_BLUE]);
    require(s->lines == 64 || s->lines == 640);
    if (s->fov_deg != 0) {
        check_value(LUM_COMMAND_YSCAN, s->fov_deg);
    }
    check_table(s);
    if (run->fx.geometry_changed) {
        check_elevations(run);
    }
}

static void check_laser(const struct run *run)
{
    const lum_device *d = &run->device;
    const bool up = lum_device_laser_is_up(d);
    const bool alive =
        d->has_client && run->now - run->heartbeat < LUM_DEVICE_TIMEOUT_NS;
    const bool on = (d->status & LUM_LASER_TLV_CMD_ON) != 0;
    const bool off = (d->status & LUM_LASER_TLV_CMD_OFF) != 0;
    const bool late = (d->status & LUM_LASER_HEARTBEAT_TIMEOUT) != 0;
    const float gain = lum_device_gain(d, run->now);
    require(!(on && off));
    require(up == (on && !lum_laser_is_down(d->status)));
    require(!up || alive);
    /* 3 s from boot are as long without HEARTBEAT_TIMEOUT */
    require(!d->has_client && !late ? run->now < LUM_DEVICE_TIMEOUT_NS
                                    : late == !alive);
    require(d->is_streaming == alive);
    require(lum_device_next_ns(d) ==
            (late ? INT64_MAX : run->heartbeat + LUM_DEVICE_TIMEOUT_NS));
    require(up || gain == 0.0f);
    require(gain >= 0.0f && gain <= (float)d->settings.power / 100.0f);
}

static void check_effects(const struct run *run)
{
    const lum_device *a = &run->before;
    const lum_device *b = &run->device;
    const lum_device_effects *fx = &run->fx;
    require(fx->status_changed == (a->status != b->status));
    require(fx->laser_changed ==
            (lum_device_laser_is_up(a) != lum_device_laser_is_up(b)));
    require(!fx->geometry_changed || fx->settings_changed);
    require(fx->settings_changed ||
            memcmp(&a->settings, &b->settings, sizeof a->settings) == 0);
    require(fx->streaming_changed || a->is_streaming == b->is_streaming);
    require(memchr(fx->note, '\0', sizeof fx->note) != NULL);
    for (const char *c = fx->note; *c != '\0'; c++) {
        require(*c >= ' ' && *c <= '~');
    }
}

/* A true status, then only printable texts. */
static void check_reply(const struct run *run, uint32_t sequence)
{
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t found = 0;
    uint16_t status = 0;
    lum_result result = LUM_OK;
    const lum_device_effects *fx = &run->fx;
    require(fx->has_reply && fx->reply_len <= LUM_DEVICE_REPLY_BYTES);
    require(lum_tlv_open(fx->reply, fx->reply_len, &found, &reader) == LUM_OK);
    require(found == sequence);
    require(lum_tlv_next(&reader, &tlv) == LUM_OK);
    require(tlv.type == run->device.layout.profile.tlv[LUM_TLV_STATUS]);
    require(lum_tlv_u16(&tlv, &status) == LUM_OK && tlv.length == 2);
    require(status == run->device.status);
    while ((result = lum_tlv_next(&reader, &tlv)) == LUM_OK) {
        require(tlv.type == run->device.layout.profile.tlv[LUM_TLV_DEBUG]);
        require(tlv.length > 0);
        for (unsigned i = 0; i < tlv.length; i++) {
            require(tlv.value[i] >= ' ' && tlv.value[i] <= '~');
        }
    }
    require(result == LUM_END);
}

static void check(const struct run *run)
{
    check_effects(run);
    check_laser(run);
    check_settings(run);
}

static void check_timestamp(const struct run *run, uint32_t sequence)
{
    lum_timestamp t = {0, 0};
    require(lum_timestamp_decode(run->fx.reply, run->fx.reply_len, &t) ==
            LUM_OK);
    require(t.sequence == sequence);
    require(t.clock_us ==
            (uint32_t)(run->clock_us + (uint64_t)run->now / 1000u));
}

static void check_address(const struct run *run)
{
    uint8_t packet[LUM_SET_IP_BYTES];
    require(lum_set_ip_encode(packet, &run->device.layout, run->fx.address) ==
            LUM_OK);
}

/* What the packet asks for is read by the SDK's own decoders. */
static void check_answer(struct run *run, const uint8_t *bytes, size_t len)
{
    lum_tlv_reader reader;
    lum_timestamp t;
    uint32_t sequence = 0;
    uint32_t address = 0;
    const bool is_tlv = lum_tlv_open(bytes, len, &sequence, &reader) == LUM_OK;
    const bool is_time = lum_timestamp_decode(bytes, len, &t) == LUM_OK;
    require(run->fx.has_reply == (is_tlv || is_time));
    if (is_tlv) {
        check_reply(run, sequence);
    } else if (is_time) {
        check_timestamp(run, t.sequence);
    }
    if (run->fx.has_address) {
        require(lum_set_ip_decode(&run->device.layout, bytes, len, &address) ==
                LUM_OK);
        require(address == run->fx.address);
        check_address(run);
    }
    require(run->fx.note[0] != '\0');
}

static bool is_heartbeat(const uint8_t *bytes, size_t len)
{
    uint8_t type = 0;
    return len == LUM_HEARTBEAT_BYTES &&
           lum_header_decode(bytes, len, &type) == LUM_OK &&
           type == LUM_TYPE_HEARTBEAT;
}

/* From memory of the exact size. */
static void receive_once(struct run *run, const uint8_t *bytes, size_t len)
{
    const lum_device_peer from = {0x0a2a0001u + run->left % 2u,
                                  (uint16_t)(run->left / 2u % 2u)};
    uint8_t *exact = malloc(len > 0 ? len : 1);
    if (exact == NULL) {
        return;
    }
    memcpy(exact, bytes, len);
    memset(&run->fx, 0xa5, sizeof run->fx);
    run->before = run->device;
    lum_device_receive(&run->device, run->now, from, exact, len, &run->fx);
    free(exact);
    if (is_heartbeat(bytes, len)) {
        run->heartbeat = run->now;
    }
    check_answer(run, bytes, len);
    check(run);
}

/* Every command sets an absolute state, so a repeated packet changes nothing.
 */
static void receive(struct run *run, const uint8_t *bytes, size_t len)
{
    receive_once(run, bytes, len);
    receive_once(run, bytes, len);
    require(!run->fx.settings_changed && !run->fx.status_changed);
    require(!run->fx.laser_changed && !run->fx.streaming_changed);
}

static void send_packet(struct run *run, uint8_t type, size_t n, bool numbered)
{
    uint8_t bytes[PACKET_MAX];
    size_t len = LUM_HEADER_BYTES;
    lum_header_encode(bytes, type);
    if (numbered) {
        const uint32_t sequence = ++run->sequence * 2654435761u;
        for (unsigned i = 0; i < 4; i++) {
            bytes[len++] = (uint8_t)(sequence >> (8u * i) & 0xffu);
        }
    }
    len += take_bytes(run, n < PACKET_MAX - len ? n : PACKET_MAX - len,
                      bytes + len);
    receive(run, bytes, len);
}

static void send_datagram(struct run *run)
{
    uint8_t bytes[PACKET_MAX];
    const size_t n = take_u16(run) % (PACKET_MAX + 1u);
    receive(run, bytes, take_bytes(run, n, bytes));
}

/* Changes without a command are reported to the client. */
static void check_alert(const struct run *run)
{
    const lum_device_effects *fx = &run->fx;
    require(fx->has_reply == (fx->status_changed && run->device.has_client));
    if (fx->has_reply) {
        check_reply(run, 0);
    }
    require(!fx->settings_changed && !fx->has_address);
    check(run);
}

static void let_time_pass(struct run *run)
{
    run->now += (int64_t)take_u16(run) * 1000000;
    memset(&run->fx, 0xa5, sizeof run->fx);
    run->before = run->device;
    lum_device_tick(&run->device, run->now, &run->fx);
    check_alert(run);
}

static void set_hazards(struct run *run)
{
    const uint16_t set = take_u16(run);
    const uint16_t clear = take_u16(run);
    memset(&run->fx, 0xa5, sizeof run->fx);
    run->before = run->device;
    lum_device_set_hazards(&run->device, set, clear, run->now, &run->fx);
    check_alert(run);
}

static void step(struct run *run)
{
    switch ((enum step)(take(run) % STEPS)) {
    case STEP_HEARTBEAT:
        send_packet(run, LUM_TYPE_HEARTBEAT, 0, false);
        break;
    case STEP_TIME:
        let_time_pass(run);
        break;
    case STEP_TLV:
        send_packet(run, LUM_TYPE_TLV, take_u16(run), true);
        break;
    case STEP_DATAGRAM:
        send_datagram(run);
        break;
    case STEP_PACKET: {
        const uint8_t type = (uint8_t)take(run);
        send_packet(run, type, take(run), false);
        break;
    }
    case STEP_HAZARDS:
        set_hazards(run);
        break;
    case STEPS:
    default:
        abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lum_layout layout;
    struct run *run = calloc(1, sizeof *run);
    if (run == NULL) {
        return 0;
    }
    run->next = data;
    run->left = size;
    lum_calibration_default(&run->calibration);
    lum_layout_default(&layout);
    const unsigned first = take(run);
    layout.profile.angle_lsb_pdeg = (first & 1u) != 0 ? 500000000u : 0u;
    layout.profile.set_ip_order =
        (first & 2u) != 0 ? LUM_SET_IP_LITTLE : LUM_SET_IP_NETWORK;
    run->clock_us = (first & 4u) != 0 ? 0xfffff000u : 0u;
    lum_device_init(&run->device, &layout, (first & 8u) != 0 ? 640 : 64,
                    (first & 16u) != 0 ? 0x0a00u : LUM_DEVICE_BOOT_STATUS,
                    run->clock_us, 0);
    while (run->left > 0) {
        step(run);
    }
    free(run);
    return 0;
}
