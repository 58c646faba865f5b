#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gateway_rig.h"
#include "support.h"

#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

bool receive(struct rig *r, const void *bytes, size_t len)
{
    ring_slot *const slot = ring_claim(&r->gateway.ring);
    if (slot == NULL) {
        return false;
    }
    assert_true(len <= sizeof slot->bytes);
    memcpy(slot->bytes, bytes, len);
    slot->len = (uint32_t)len;
    ring_commit(&r->gateway.ring);
    return true;
}

uint32_t sensor_clock(const struct rig *r)
{
    return r->now * 1000u + r->boot_us;
}

void tell_clock(struct rig *r, uint32_t sequence, uint32_t clock_us)
{
    const lum_timestamp answer = {sequence, clock_us};
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    lum_timestamp_encode(packet, &answer);
    (void)receive(r, packet, sizeof packet);
}

/* The sensor answers at once. */
static bool take_sent(void *context, const uint8_t *bytes, size_t len)
{
    struct rig *const r = context;
    struct sent *const s = &r->sent[r->sent_count];
    lum_tlv_reader reader;
    lum_timestamp request;
    if (r->refuses) {
        return false;
    }
    assert_true(r->sent_count < SENT_MAX);
    *s = (struct sent){.ms = r->now};
    assert_int_equal(lum_header_decode(bytes, len, &s->type), LUM_OK);
    if (s->type == LUM_TYPE_TLV) {
        assert_int_equal(lum_tlv_open(bytes, len, &s->sequence, &reader),
                         LUM_OK);
        assert_int_equal(reader.left, 0);
    } else if (s->type == LUM_TYPE_TIMESTAMP) {
        assert_int_equal(len, LUM_TIMESTAMP_BYTES);
        assert_int_equal(lum_timestamp_decode(bytes, len, &request), LUM_OK);
        assert_int_equal(request.clock_us, 0);
        s->sequence = request.sequence;
        if (!r->is_mute) {
            tell_clock(r, request.sequence, sensor_clock(r));
        }
    } else {
        assert_int_equal(len, LUM_HEARTBEAT_BYTES);
    }
    r->sent_count++;
    return true;
}

static void take_line(void *context, const lum_line *line)
{
    (void)line;
    ((struct rig *)context)->lines++;
}

static void take_points(void *context, const lum_fixed_point *points, size_t n)
{
    (void)points;
    ((struct rig *)context)->points += n;
}

static void take_frame(void *context, int64_t frame, const zone_sight *sight)
{
    struct rig *const r = context;
    r->frames++;
    r->frame = frame;
    r->sight = *sight;
}

/* Both eyes look straight ahead. */
static void look_ahead(lum_calibration *c)
{
    lum_calibration_default(c);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        c->eye[eye].elevation_min_udeg = -10000000;
        c->eye[eye].elevation_max_udeg = 10000000;
        c->eye[eye].mount_yaw_udeg = 0;
    }
}

struct rig *rig_new(void)
{
    uint8_t *const memory = calloc(1, sizeof(struct rig) + RING_LINE_BYTES);
    struct rig *r;
    assert_non_null(memory);
    r = (void *)(memory +
                 (RING_LINE_BYTES - (uintptr_t)memory % RING_LINE_BYTES));
    r->memory = memory;
    memset(&r->gateway, 0xa5, sizeof r->gateway);
    look_ahead(&r->calibration);
    lum_layout_default(&r->layout);
    r->config =
        (gateway_config){.zone = {.min = {MM(1000), MM(-1000), MM(-500)},
                                  .max = {MM(8000), MM(1000), MM(500)}},
                         .hits = HITS,
                         .lines = LINES,
                         .frame_ms = FRAME,
                         .hold_ms = HOLD,
                         .silence_ms = SILENCE,
                         .eyes = BOTH};
    r->output = (gateway_output){.context = r,
                                 .send = take_sent,
                                 .line = take_line,
                                 .points = take_points,
                                 .frame = take_frame};
    r->boot_us = 1000000;
    return r;
}

void rig_free(struct rig *r)
{
    free(r->memory);
}

lum_result rig_init(struct rig *r)
{
    return gateway_init(&r->gateway, &r->config, &r->output, &r->calibration,
                        &r->layout, r->now);
}

struct rig *rig_at(uint32_t now)
{
    struct rig *const r = rig_new();
    r->now = now;
    assert_int_equal(rig_init(r), LUM_OK);
    return r;
}

struct rig *rig_informed(uint32_t now)
{
    struct rig *const r = rig_at(now);
    tell_clock(r, now, sensor_clock(r));
    return r;
}

void put(struct rig *r, unsigned eye, uint8_t tag, int32_t tof, bool rising,
         uint32_t first, uint32_t n)
{
    uint8_t samples[PACKET_MAX * LUM_SAMPLE_BYTES];
    const lum_group group = {.line = r->line,
                             .num_samples = n,
                             .first_sample_index = first,
                             .clock_raw = sensor_clock(r),
                             .eye = (uint8_t)eye,
                             .tag = tag};
    size_t len = 0;
    assert_true(n <= PACKET_MAX);
    memset(samples, 0, sizeof samples);
    for (uint32_t i = 0; tag == LUM_TAG_RANGES && i < n; i++) {
        lum_word_encode(lum_word_make(tof, rising, first + i),
                        samples + (size_t)LUM_SAMPLE_BYTES * i);
    }
    uint8_t *const packet = encode_packet(&r->layout, &group, samples, &len);
    assert_true(receive(r, packet, len));
    free(packet);
}

void put_angles(struct rig *r, unsigned eye)
{
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel += PACKET_MAX) {
        put(r, eye, LUM_TAG_ANGLES, 0, false, pixel, PACKET_MAX);
    }
}

void next_line(struct rig *r)
{
    r->line = (r->line + 1u) % LINES;
}

void show(struct rig *r, unsigned eyes, int32_t tof, uint32_t n)
{
    (void)gateway_receive(&r->gateway, r->now);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if ((eyes >> eye & 1u) != 0) {
            put_angles(r, eye);
            put(r, eye, LUM_TAG_RANGES, tof, true, 0, n);
        }
        (void)gateway_receive(&r->gateway, r->now);
    }
    next_line(r);
}

void show_out(struct rig *r)
{
    for (unsigned i = 0; i < GATEWAY_OPEN_LINES; i++) {
        show(r, BOTH, FAR_TOF, 1);
    }
}

void pass(struct rig *r, uint32_t ms, unsigned eyes)
{
    for (; ms > 0; ms -= STEP) {
        r->now += STEP;
        gateway_tick(&r->gateway, r->now);
        show(r, eyes, FAR_TOF, 1);
    }
}

void next_frame(struct rig *r)
{
    while (r->line != 0) {
        pass(r, STEP, BOTH);
    }
}

uint32_t reasons(const struct rig *r)
{
    return gateway_reasons(&r->gateway);
}

struct rig *rig_going(uint32_t now)
{
    struct rig *const r = rig_informed(now);
    pass(r, 4000, BOTH);
    assert_int_equal(reasons(r), 0);
    assert_true(r->sent_count > 0);
    return r;
}

void run(struct rig *r, uint32_t ms, uint32_t step)
{
    for (uint32_t t = 0; t < ms; t += step) {
        r->now += step;
        gateway_tick(&r->gateway, r->now);
        (void)gateway_receive(&r->gateway, r->now);
    }
}

void hang(struct rig *r, uint32_t ms)
{
    for (uint32_t t = 0; t < ms; t += 10) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
    }
}
