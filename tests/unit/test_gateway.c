#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "gateway.h"

#include "lum/laser.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define BLUE  (1u << LUM_EYE_BLUE)
#define GREEN (1u << LUM_EYE_GREEN)
#define BOTH  (BLUE | GREEN)
#define MM(x) ((x)*LUM_FIXED_PER_MM)

#define NEAR_TOF 2564 /* 5 m straight ahead */
#define FAR_TOF  20512
#define HITS     5u
#define STEP     25u /* from line to line */
#define LINES    14u
#define FRAME    (LINES * STEP)
#define HOLD     1600u
#define SILENCE  500u
#define SENT_MAX 4096u

#define PACKET_MAX 250u /* samples; a quarter of a line */

struct sent {
    uint32_t ms;
    uint32_t sequence;
    uint8_t type;
};

/* A gateway, the clock of its machine, and a sensor. */
struct rig {
    gateway gateway; /* first: it has to be aligned */
    void *memory;
    gateway_config config;
    gateway_output output;
    lum_calibration calibration;
    lum_layout layout;
    uint32_t now;
    uint32_t line;
    uint32_t boot_us; /* what the sensor's clock is ahead of now */
    bool refuses;
    bool is_mute; /* the sensor does not tell its clock */
    size_t sent_count;
    struct sent sent[SENT_MAX];
    size_t lines;
    size_t points;
    size_t frames;
    int64_t frame;
    zone_sight sight; /* of that frame */
};

static bool receive(struct rig *r, const void *bytes, size_t len)
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

static uint32_t sensor_clock(const struct rig *r)
{
    return r->now * 1000u + r->boot_us;
}

static void tell_clock(struct rig *r, uint32_t sequence, uint32_t clock_us)
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

static struct rig *rig_new(void)
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

static void rig_free(struct rig *r)
{
    free(r->memory);
}

static lum_result rig_init(struct rig *r)
{
    return gateway_init(&r->gateway, &r->config, &r->output, &r->calibration,
                        &r->layout, r->now);
}

static struct rig *rig_at(uint32_t now)
{
    struct rig *const r = rig_new();
    r->now = now;
    assert_int_equal(rig_init(r), LUM_OK);
    return r;
}

/* Knows the sensor's clock, before it asks. */
static struct rig *rig_informed(uint32_t now)
{
    struct rig *const r = rig_at(now);
    tell_clock(r, now, sensor_clock(r));
    return r;
}

/* n samples alike, of a line's pixels from first on. */
static void put(struct rig *r, unsigned eye, uint8_t tag, int32_t tof,
                bool rising, uint32_t first, uint32_t n)
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

static void put_angles(struct rig *r, unsigned eye)
{
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel += PACKET_MAX) {
        put(r, eye, LUM_TAG_ANGLES, 0, false, pixel, PACKET_MAX);
    }
}

static void next_line(struct rig *r)
{
    r->line = (r->line + 1u) % LINES;
}

/* A line of some eyes, with n returns straight ahead, and no others. */
static void show(struct rig *r, unsigned eyes, int32_t tof, uint32_t n)
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

/* So many more lines, each of a return outside the zone, that what was shown
 * comes out. */
static void show_out(struct rig *r)
{
    for (unsigned i = 0; i < GATEWAY_OPEN_LINES; i++) {
        show(r, BOTH, FAR_TOF, 1);
    }
}

/* Time passes; some eyes see something outside the zone. */
static void pass(struct rig *r, uint32_t ms, unsigned eyes)
{
    for (; ms > 0; ms -= STEP) {
        r->now += STEP;
        gateway_tick(&r->gateway, r->now);
        show(r, eyes, FAR_TOF, 1);
    }
}

static void next_frame(struct rig *r)
{
    while (r->line != 0) {
        pass(r, STEP, BOTH);
    }
}

static uint32_t reasons(const struct rig *r)
{
    return gateway_reasons(&r->gateway);
}

/* A rig that goes. */
static struct rig *rig_going(uint32_t now)
{
    struct rig *const r = rig_informed(now);
    pass(r, 4000, BOTH);
    assert_int_equal(reasons(r), 0);
    assert_true(r->sent_count > 0);
    return r;
}

static void it_is_stopped_until_both_eyes_were_heard(void **state)
{
    struct rig *const r = rig_informed(0);
    (void)state;
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    pass(r, 10u * FRAME, BLUE);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, FRAME + 2u * STEP, BOTH); /* then green's first frame is out */
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, HOLD - STEP, BOTH);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void a_hold_of_a_moment_does_not_end_the_first_silence(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->now = 77;
    r->config.frame_ms = 1;
    r->config.hold_ms = 3;
    assert_int_equal(rig_init(r), LUM_OK);
    for (unsigned i = 0; i < 3; i++) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
    }
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

/* Of its newest lines two are open. */
static void an_eye_that_falls_silent_stops(void **state)
{
    static const unsigned alone[] = {BLUE, GREEN};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct rig *const r = rig_going(0);
        pass(r, SILENCE - 3u * STEP, alone[i]);
        assert_int_equal(reasons(r), 0);
        pass(r, STEP, alone[i]);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        pass(r, 2u * FRAME, BOTH);
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        pass(r, HOLD + 2u * STEP, BOTH);
        assert_int_equal(reasons(r), 0);
        rig_free(r);
    }
}

static void an_eye_that_is_not_wanted_may_be_silent(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.eyes = GREEN;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 10u * FRAME, GREEN);
    assert_int_equal(reasons(r), 0);
    pass(r, 1000, BLUE);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

static void lines_without_points_are_silence(void **state)
{
    (void)state;
    for (unsigned with_angles = 0; with_angles < 2; with_angles++) {
        struct rig *const r = rig_going(0);
        for (unsigned i = 0; i < SILENCE / STEP; i++) {
            r->now += STEP;
            gateway_tick(&r->gateway, r->now);
            if (with_angles != 0) {
                put_angles(r, LUM_EYE_GREEN);
            } else {
                put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, NEAR_TOF, true, 0, 10);
            }
            show(r, BLUE, FAR_TOF, 1);
        }
        assert_int_equal(reasons(r), GATEWAY_SILENT);
        rig_free(r);
    }
}

static void silence_lasts_beyond_a_wrap_of_the_clock(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    pass(r, 1000, 0);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    r->now += UINT32_MAX - 900u; /* as long ago as a moment, by the clock */
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    rig_free(r);
}

static void as_many_hits_as_wanted_stop_at_once(void **state)
{
    (void)state;
    for (uint32_t n = HITS - 1u; n <= HITS; n++) {
        struct rig *const r = rig_going(0);
        show(r, GREEN, NEAR_TOF, n);
        show_out(r);
        assert_int_equal(reasons(r), n < HITS ? 0 : GATEWAY_OBJECT);
        rig_free(r);
    }
}

static void hits_of_both_eyes_and_many_lines_add_up_within_a_frame(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    show(r, BLUE, NEAR_TOF, 2);
    show(r, GREEN, NEAR_TOF, 2);
    show_out(r);
    assert_int_equal(reasons(r), 0);
    show(r, BLUE, NEAR_TOF, 1);
    show_out(r);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    rig_free(r);
}

static void hits_of_two_frames_do_not_add_up(void **state)
{
    struct rig *const r = rig_going(0);
    const size_t frames = r->frames;
    (void)state;
    for (unsigned frame = 0; frame < 6; frame++) {
        next_frame(r);
        show(r, BOTH, NEAR_TOF, HITS / 2u);
    }
    show_out(r);
    assert_int_equal(reasons(r), 0);
    assert_true(r->frames >= frames + 4u);
    rig_free(r);
}

static void falling_edges_are_no_hits(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    put_angles(r, LUM_EYE_BLUE);
    put(r, LUM_EYE_BLUE, LUM_TAG_RANGES, NEAR_TOF, false, 0, 20);
    (void)gateway_receive(&r->gateway, r->now);
    next_line(r);
    show_out(r);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void a_stop_outlives_its_cause_by_the_hold(void **state)
{
    struct rig *const r = rig_going(UINT32_MAX - 4400u); /* wraps meanwhile */
    (void)state;
    show(r, BLUE, NEAR_TOF, HITS);
    show_out(r);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    pass(r, HOLD - STEP, BOTH);
    assert_int_equal(reasons(r), GATEWAY_OBJECT);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

/* Whether what stands in the way shows first in odd frames, and last in even
 * ones: two frames less a line apart. */
static bool is_in_sight(unsigned frame, uint32_t line)
{
    return line == (frame % 2u != 0 ? 0 : LINES - 1u);
}

static void what_two_frames_show_far_apart_is_one_stop(void **state)
{
    struct rig *const r = rig_new();
    bool seen = false;
    (void)state;
    r->config.hold_ms = 2u * FRAME + (GATEWAY_OPEN_LINES + 1u) * STEP;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 4000, BOTH);
    next_frame(r);
    assert_int_equal(reasons(r), 0);
    for (unsigned frame = 1; frame < 9; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            r->now += STEP;
            gateway_tick(&r->gateway, r->now);
            if (is_in_sight(frame, line)) {
                show(r, BOTH, NEAR_TOF, HITS);
            } else {
                show(r, BOTH, FAR_TOF, 1);
            }
            seen = seen || reasons(r) != 0;
            assert_int_equal(reasons(r), seen ? GATEWAY_OBJECT : 0);
        }
    }
    assert_true(seen);
    rig_free(r);
}

static void what_stays_in_the_zone_keeps_the_machine_stopped(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    for (unsigned frame = 0; frame < 8; frame++) {
        next_frame(r);
        show(r, BLUE, NEAR_TOF, HITS);
        show_out(r);
        assert_int_equal(reasons(r), GATEWAY_OBJECT);
        pass(r, 500, BOTH);
        assert_int_equal(reasons(r), GATEWAY_OBJECT);
    }
    rig_free(r);
}

static void a_frame_tells_its_hits_and_the_nearest(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    next_frame(r);
    show(r, GREEN, NEAR_TOF + 100, 2);
    show(r, BLUE, NEAR_TOF, 2);
    show(r, BLUE, NEAR_TOF + 200, 3);
    for (unsigned i = 0; i < 2u * LINES && r->sight.hits == 0; i++) {
        pass(r, STEP, BOTH);
    }
    const int64_t frame = r->frame;
    assert_int_equal(r->sight.hits, 7);
    assert_int_equal(zone_nearest_mm(&r->sight), 4999); /* 4999.8 */
    pass(r, FRAME, BOTH);
    assert_int_equal(r->frame, frame + 1);
    assert_int_equal(r->sight.hits, 0);
    assert_int_equal(zone_nearest_mm(&r->sight), 0);
    rig_free(r);
}

static void a_line_too_late_for_its_frame_counts_for_the_newer_one(void **state)
{
    struct rig *const r = rig_informed(0);
    const gateway_frame *const frame = &r->gateway.frames[1];
    (void)state;
    pass(r, 3u * STEP, BOTH);
    assert_int_equal(frame->number, 1);
    r->gateway.frames[1].number = 1 + GATEWAY_FRAMES; /* its place */
    show(r, BLUE, NEAR_TOF, HITS);
    show_out(r);
    assert_true(r->points > 0);
    assert_int_equal(frame->sight.hits, HITS);
    assert_int_equal(frame->number, 1 + GATEWAY_FRAMES);
    assert_true((reasons(r) & GATEWAY_OBJECT) != 0);
    while (r->frames == 0) {
        pass(r, STEP, BOTH);
    }
    assert_int_equal(r->frame, 1); /* of which nothing is known any more */
    assert_int_equal(r->sight.hits, 0);
    rig_free(r);
}

/* As if so many frames had been. */
static void count_frames_to(struct rig *r, uint32_t frame)
{
    lum_assembler *const a = &r->gateway.assembler;
    gateway_finish(&r->gateway);
    a->frames.highest = frame;
    a->frames.next = frame + 1u;
    for (unsigned e = 0; e < LUM_EYES; e++) {
        a->eye[e].frames.frame = frame;
        for (unsigned i = 0; i < GATEWAY_REORDER_LINES; i++) {
            a->eye[e].reach[i].frame = frame + 1u;
        }
        r->gateway.looks[e].frame = frame;
    }
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        r->gateway.frames[(frame - i) % GATEWAY_FRAMES].number = frame - i;
    }
}

static void a_wrap_of_frame_numbers_changes_nothing(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    next_frame(r);
    count_frames_to(r, UINT32_MAX - 2u);
    for (unsigned frame = 0; frame < 12; frame++) {
        show(r, BOTH, NEAR_TOF, HITS / 2u);
        pass(r, STEP, BOTH);
        next_frame(r);
        assert_int_equal(reasons(r), 0);
    }
    assert_int_equal(r->frame, 8);
    assert_int_equal(r->sight.hits, HITS / 2u * 2u);
    rig_free(r);
}

static void a_frame_before_the_first_is_a_frame_too(void **state)
{
    struct rig *const r = rig_informed(0);
    (void)state;
    show(r, BLUE, FAR_TOF, 1);
    show(r, BLUE, FAR_TOF, 1);
    r->line = 50; /* far ahead of the other eye: of its last frame */
    show(r, GREEN, NEAR_TOF, 2);
    for (unsigned i = 0; i < GATEWAY_OPEN_LINES; i++) {
        r->line = 51 + i;
        show(r, GREEN, FAR_TOF, 1);
    }
    assert_int_equal(r->gateway.frames[0].number, 0);
    assert_int_equal(r->gateway.frames[0].sight.hits, 2);
    assert_int_equal(zone_nearest_mm(&r->gateway.frames[0].sight), 4999);
    rig_free(r);
}

static void the_end_hands_out_what_is_open(void **state)
{
    struct rig *const r = rig_going(0);
    size_t lines;
    (void)state;
    next_frame(r);
    lines = r->lines;
    show(r, BOTH, NEAR_TOF, HITS);
    gateway_finish(&r->gateway);
    assert_int_equal(r->lines, lines + 2u + 2u * GATEWAY_OPEN_LINES);
    assert_int_equal(r->sight.hits, 2u * HITS);
    rig_free(r);
}

static void observers_may_be_missing(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->output.line = NULL;
    r->output.points = NULL;
    r->output.frame = NULL;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 4000, BOTH);
    gateway_finish(&r->gateway);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static size_t count_sent(const struct rig *r, uint8_t type)
{
    size_t n = 0;
    for (size_t i = 0; i < r->sent_count; i++) {
        n += r->sent[i].type == type;
    }
    return n;
}

static uint32_t longest_pause(const struct rig *r)
{
    uint32_t longest = 0;
    for (size_t i = 1; i < r->sent_count; i++) {
        const uint32_t pause = r->sent[i].ms - r->sent[i - 1u].ms;
        longest = pause > longest ? pause : longest;
    }
    return longest;
}

/* A tick each step, and a round of the main loop. */
static void run(struct rig *r, uint32_t ms, uint32_t step)
{
    for (uint32_t t = 0; t < ms; t += step) {
        r->now += step;
        gateway_tick(&r->gateway, r->now);
        (void)gateway_receive(&r->gateway, r->now);
    }
}

static void five_heartbeats_a_second_leave_across_a_wrap(void **state)
{
    static const uint32_t starts[] = {0, UINT32_MAX - 5000u,
                                      UINT32_MAX / 2u - 5000u, UINT32_MAX};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct rig *const r = rig_at(starts[i]);
        run(r, HEART_SILENCE_MS + 10000u, 10);
        assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 1 + 50);
        assert_int_equal(r->gateway.heart.sent, 1 + 50);
        assert_int_equal(longest_pause(r), 200);
        rig_free(r);
    }
}

static void a_beat_keeps_its_pace_where_ticks_do_not_fit_it(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 30);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 1 + 50);
    rig_free(r);
}

static void a_slow_tick_makes_no_burst(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 6000u);
    size_t before;
    (void)state;
    run(r, 4u * 800u, 800);
    assert_int_equal(r->sent_count, 0);
    run(r, 8000, 800);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), 10);
    assert_int_equal(longest_pause(r), 800);
    before = count_sent(r, LUM_TYPE_HEARTBEAT);
    run(r, 200, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), before + 1u);
    rig_free(r);
}

static void the_status_is_asked_for_once_a_second(void **state)
{
    struct rig *const r = rig_at(0);
    uint32_t polls = 0;
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_TLV), 1 + 10);
    for (size_t i = 0; i < r->sent_count; i++) {
        if (r->sent[i].type == LUM_TYPE_TLV) {
            assert_int_equal(r->sent[i].sequence, r->sent[i].ms);
            assert_int_equal(r->sent[i].ms, HEART_SILENCE_MS + 1000u * polls);
            polls++;
        }
    }
    rig_free(r);
}

static void the_clock_is_asked_for_with_each_heartbeat(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 8000u);
    (void)state;
    run(r, HEART_SILENCE_MS + 10000u, 10);
    assert_int_equal(count_sent(r, LUM_TYPE_TIMESTAMP), 1 + 50);
    for (size_t i = 0; i < r->sent_count; i++) {
        if (r->sent[i].type == LUM_TYPE_TIMESTAMP) {
            assert_int_equal(r->sent[i].sequence, r->sent[i].ms);
            assert_int_equal(r->sent[i - 1u].type, LUM_TYPE_HEARTBEAT);
        }
    }
    rig_free(r);
}

static void a_heartbeat_that_was_refused_is_tried_again(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    run(r, HEART_SILENCE_MS + 1000u, 10);
    r->refuses = true;
    run(r, 300, 10);
    assert_int_equal(r->gateway.heart.failed, 11);
    r->refuses = false;
    run(r, 10, 10);
    assert_int_equal(r->sent[r->sent_count - 1u].ms, r->now);
    assert_true(longest_pause(r) < 1000);
    rig_free(r);
}

/* By the clock, what was due half its range ago is yet to come. */
static void a_heartbeat_is_tried_again_after_weeks_of_refusals(void **state)
{
    struct rig *const r = rig_at(0);
    size_t sent;
    (void)state;
    run(r, 5000, 10);
    sent = r->sent_count;
    r->refuses = true;
    run(r, UINT32_MAX / 16u * 11u, UINT32_MAX / 16u);
    r->refuses = false;
    run(r, 10, 10);
    assert_true(r->sent_count > sent);
    rig_free(r);
}

/* The timer goes on, the main loop does not. */
static void hang(struct rig *r, uint32_t ms)
{
    for (uint32_t t = 0; t < ms; t += 10) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
    }
}

static void nothing_is_sent_before_the_first_round(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 3000u);
    (void)state;
    hang(r, 10000);
    assert_int_equal(r->sent_count, 0);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    run(r, 20, 10);
    assert_true(r->sent_count > 0);
    rig_free(r);
}

/* So that a board in a loop of resets keeps no laser on. */
static void nothing_is_sent_until_the_sensor_has_timed_out(void **state)
{
    struct rig *const r = rig_at(UINT32_MAX - 2000u);
    (void)state;
    assert_true(HEART_SILENCE_MS > 3000u);
    run(r, HEART_SILENCE_MS - 1u, 1);
    assert_int_equal(r->sent_count, 0);
    run(r, 1, 1);
    assert_true(r->sent_count > 0);
    rig_free(r);
}

static void heartbeats_end_when_the_main_loop_hangs(void **state)
{
    struct rig *const r = rig_going(UINT32_MAX - 5000u);
    const uint32_t hung = r->now;
    size_t sent;
    (void)state;
    hang(r, HEART_STALL_MS + 10u);
    sent = r->sent_count;
    assert_true(r->sent[sent - 1u].ms - hung <= HEART_STALL_MS);
    assert_true(r->sent[sent - 1u].ms - hung > HEART_STALL_MS - 300u);
    hang(r, 60000);
    assert_int_equal(r->sent_count, sent);
    rig_free(r);
}

/* The newest line that is out is older by those that are open. A round was seen
 * by the tick that follows it. */
static void a_hang_stops_when_what_was_seen_is_old(void **state)
{
    static const struct {
        uint32_t silence, hold, wait;
    } rows[] = {
        {SILENCE, 6000, SILENCE - 2u * STEP},
        {2000, 6000, 2000 - 2u * STEP},
        {2040, 6000, 1990},
        {60000, 6000, 2000},
        {60000, 3000, 2000},
        {60000, 2000, 2000 - (FRAME + STEP)}, /* the newest whole look */
    };
    (void)state;
    for (unsigned i = 0; i < 6; i++) {
        struct rig *const r = rig_new();
        r->config.silence_ms = rows[i].silence;
        r->config.hold_ms = rows[i].hold;
        assert_int_equal(rig_init(r), LUM_OK);
        tell_clock(r, 0, sensor_clock(r));
        pass(r, 8000, BOTH);
        next_frame(r);
        pass(r, 2u * STEP, BOTH);
        hang(r, rows[i].wait);
        assert_int_equal(reasons(r), 0);
        hang(r, 10);
        assert_int_equal(reasons(r), GATEWAY_STALLED);
        rig_free(r);
    }
}

/* The tick comes between a decision and the end of its round. */
static void a_stall_that_no_decision_saw_is_held(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    hang(r, SILENCE + 10u);
    heart_beat(&r->gateway.heart, SILENCE);
    hang(r, 10);
    assert_int_equal(heart_stalls(&r->gateway.heart) % 2u, 0);
    assert_int_equal(reasons(r), GATEWAY_STALLED);
    pass(r, HOLD, BOTH);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    assert_int_equal(reasons(r) & GATEWAY_OBJECT, 0);
    pass(r, STEP, BOTH);
    assert_int_equal(reasons(r) & GATEWAY_STALLED, 0);
    pass(r, 2u * HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void the_watchdog_is_kicked_only_while_the_timer_goes_on(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 5; i++) {
        (void)gateway_receive(&r->gateway, r->now);
        assert_false(gateway_may_kick(&r->gateway));
    }
    for (unsigned i = 0; i < 5; i++) {
        run(r, 10, 10);
        assert_true(gateway_may_kick(&r->gateway));
        assert_false(gateway_may_kick(&r->gateway));
    }
    rig_free(r);
}

static void a_hang_lasts_beyond_a_wrap_of_the_clock(void **state)
{
    struct rig *const r = rig_going(0);
    size_t sent;
    (void)state;
    hang(r, 3000);
    sent = r->sent_count;
    for (unsigned i = 0; i < 40; i++) {
        r->now += UINT32_MAX / 16u;
        gateway_tick(&r->gateway, r->now);
    }
    assert_int_equal(r->sent_count, sent);
    assert_int_equal(reasons(r), GATEWAY_STALLED);
    pass(r, 2u * STEP, 0);
    assert_true(r->sent_count > sent);
    rig_free(r);
}

static void a_main_loop_that_comes_back_sends_again_and_is_held(void **state)
{
    struct rig *const r = rig_going(0);
    size_t sent;
    (void)state;
    hang(r, 5000);
    sent = count_sent(r, LUM_TYPE_HEARTBEAT);
    pass(r, STEP, BOTH);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    pass(r, STEP, BOTH);
    assert_int_equal(count_sent(r, LUM_TYPE_HEARTBEAT), sent + 1u);
    assert_true((reasons(r) & GATEWAY_STALLED) != 0);
    pass(r, 2u * FRAME + HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void tell_status(struct rig *r, uint16_t type, uint16_t status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now), LUM_OK);
    assert_int_equal(lum_tlv_add(&w, 3, "text", 4), LUM_OK);
    assert_int_equal(lum_tlv_add_u16(&w, type, status), LUM_OK);
    assert_true(receive(r, packet, w.len));
    (void)gateway_receive(&r->gateway, r->now);
}

static void every_bit_that_takes_the_laser_down_stops(void **state)
{
    struct rig *const r = rig_going(0);
    const uint16_t type = r->layout.profile.tlv[LUM_TLV_STATUS];
    (void)state;
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const uint16_t status = (uint16_t)(1u << bit);
        tell_status(r, type, status);
        assert_int_equal(
            reasons(r), (status & LUM_LASER_ALL_DOWN) != 0 ? GATEWAY_LASER : 0);
        pass(r, 2000, BOTH);
        assert_int_equal(
            reasons(r), (status & LUM_LASER_ALL_DOWN) != 0 ? GATEWAY_LASER : 0);
        tell_status(r, type, LUM_LASER_TLV_CMD_ON);
        pass(r, HOLD, BOTH);
        assert_int_equal(reasons(r), 0);
    }
    rig_free(r);
}

static void all_reasons_can_stand_together(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    hang(r, 2000);
    (void)gateway_receive(&r->gateway, r->now);
    for (unsigned i = 0; i < 2u + GATEWAY_OPEN_LINES; i++) {
        show(r, BLUE, NEAR_TOF, HITS); /* the first proves a jump */
    }
    tell_status(r, r->layout.profile.tlv[LUM_TLV_STATUS],
                LUM_LASER_FAN_PWM_BAD);
    hang(r, 30);
    assert_int_equal(reasons(r), GATEWAY_OBJECT | GATEWAY_SILENT |
                                     GATEWAY_LASER | GATEWAY_STALLED);
    rig_free(r);
}

static void add_status(struct rig *r, lum_tlv_writer *w, uint16_t status)
{
    assert_int_equal(
        lum_tlv_add_u16(w, r->layout.profile.tlv[LUM_TLV_STATUS], status),
        LUM_OK);
}

static void a_hazard_beside_a_clean_status_of_its_packet_stops(void **state)
{
    (void)state;
    for (unsigned first = 0; first < 2; first++) {
        struct rig *const r = rig_going(0);
        uint8_t packet[64];
        lum_tlv_writer w;
        assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, 1), LUM_OK);
        add_status(r, &w, first == 0 ? LUM_LASER_FAN_PWM_BAD : 0);
        add_status(r, &w, first == 0 ? 0 : LUM_LASER_FAN_PWM_BAD);
        assert_true(receive(r, packet, w.len));
        pass(r, 2000, BOTH);
        assert_int_equal(reasons(r), GATEWAY_LASER);
        rig_free(r);
    }
}

static void a_hazard_that_ends_before_the_round_does_stops(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        uint8_t packet[64];
        lum_tlv_writer w;
        assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now),
                         LUM_OK);
        add_status(r, &w, i == 0 ? LUM_LASER_FAN_PWM_BAD : 0);
        assert_true(receive(r, packet, w.len));
    }
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_LASER);
    pass(r, HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

static void what_is_no_status_changes_nothing(void **state)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    struct rig *const r = rig_going(0);
    const uint16_t type = r->layout.profile.tlv[LUM_TLV_STATUS];
    (void)state;
    tell_status(r, (uint16_t)(type + 1u), LUM_LASER_FAN_PWM_BAD);
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, 1), LUM_OK);
    assert_int_equal(lum_tlv_add(&w, type, "\x40", 1), LUM_OK);
    assert_true(receive(r, packet, w.len));
    assert_int_equal(lum_tlv_add_u16(&w, type, LUM_LASER_FAN_PWM_BAD), LUM_OK);
    assert_true(receive(r, packet, w.len - 1u)); /* its status is cut */
    assert_true(receive(r, packet, LUM_TLV_PACKET_BYTES - 1u));
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), 0);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_TLV], 3);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_MALFORMED], 1);
    rig_free(r);
}

static void tell_as(struct rig *r, uint32_t sequence, uint16_t status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, sequence),
                     LUM_OK);
    add_status(r, &w, status);
    assert_true(receive(r, packet, w.len));
    (void)gateway_receive(&r->gateway, r->now);
}

/* An alert is believed; that all is well only of an answer to a poll of lately,
 * which bears the time. */
static void an_old_status_says_nothing_good(void **state)
{
    struct rig *const r = rig_going(0);
    uint8_t packet[64];
    lum_tlv_writer w;
    (void)state;
    tell_as(r, r->now - 100000u, LUM_LASER_FAN_PWM_BAD);
    assert_int_equal(reasons(r), GATEWAY_LASER);
    for (unsigned i = 0; i < 3; i++) {
        if (i < 2) {
            tell_as(r, i == 0 ? r->now - SILENCE : r->now + 1u, 0);
        } else {
            assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now),
                             LUM_OK);
            assert_true(receive(r, packet, w.len)); /* no status */
        }
        pass(r, HOLD + STEP, BOTH);
        assert_int_equal(reasons(r), GATEWAY_LASER);
    }
    tell_as(r, r->now - SILENCE + 1u, 0);
    pass(r, HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
    rig_free(r);
}

/* All that is measured has the age of its clock. */
static void packets_as_old_as_the_silence_are_left_out(void **state)
{
    (void)state;
    for (uint32_t age_ms = SILENCE - 1u; age_ms <= SILENCE; age_ms++) {
        struct rig *const r = rig_going(0);
        const uint32_t old = r->gateway.old_packets;
        const size_t lines = r->lines;
        r->boot_us -= age_ms * 1000u;
        r->is_mute = true;
        show(r, BLUE, FAR_TOF, 1);
        if (age_ms < SILENCE) { /* late: newer lines have closed */
            assert_int_equal(r->gateway.old_packets, old);
            assert_int_equal(r->gateway.assembler.counters.late, 5);
        } else {
            assert_int_equal(r->gateway.old_packets, old + 5u);
            assert_int_equal(r->gateway.assembler.counters.late, 0);
        }
        assert_int_equal(r->lines, lines);
        rig_free(r);
    }
}

/* While the sensor is away, nothing comes out. */
static void lines_that_become_old_are_closed_and_left_out(void **state)
{
    struct rig *const r = rig_going(0);
    const lum_assembly_counters *const c =
        lum_assembler_counters(&r->gateway.assembler);
    const size_t lines = r->lines;
    (void)state;
    for (unsigned i = 0; i < SILENCE; i++) {
        r->now++;
        (void)gateway_receive(&r->gateway, r->now);
    }
    /* of the older two 525 ms have passed, of the others 500 */
    assert_int_equal(c->lines_idle, 2);
    r->now++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(c->lines_idle, 4);
    assert_int_equal(r->gateway.old_lines, 4);
    assert_int_equal(r->lines, lines);
    rig_free(r);
}

static void a_driver_without_a_ring_hands_over_datagrams(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 4u * HOLD / STEP; i++) {
        const ring_slot *slot;
        r->now += STEP;
        gateway_tick(&r->gateway, r->now);
        tell_clock(r, r->now, sensor_clock(r));
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            put_angles(r, eye);
            put(r, eye, LUM_TAG_RANGES, FAR_TOF, true, 0, 1);
            while ((slot = ring_front(&r->gateway.ring)) != NULL) {
                gateway_datagram(&r->gateway, slot->bytes, slot->len, r->now);
                ring_release(&r->gateway.ring);
            }
        }
        next_line(r);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
    }
    assert_int_equal(reasons(r), 0);
    r->now += SILENCE; /* time goes on with a datagram too */
    gateway_datagram(&r->gateway, (const uint8_t *)"", 0, r->now);
    assert_int_equal(r->gateway.now_ms, r->now);
    rig_free(r);
}

static void expect_recovery(struct rig *r)
{
    pass(r, 2u * HOLD, BOTH);
    assert_int_equal(reasons(r), 0);
}

static void drop_one(struct rig *r)
{
    while (receive(r, "", 0)) {
    }
}

static void waste_words(struct rig *r)
{
    for (unsigned i = 0; i < 1u + GATEWAY_LINE_WORDS / PACKET_MAX; i++) {
        uint8_t samples[PACKET_MAX * LUM_SAMPLE_BYTES];
        const lum_group group = {.line = r->line,
                                 .num_samples = PACKET_MAX,
                                 .first_sample_index = i * PACKET_MAX,
                                 .clock_raw = sensor_clock(r),
                                 .eye = LUM_EYE_GREEN,
                                 .tag = LUM_TAG_RANGES};
        size_t len = 0;
        uint8_t *packet;
        for (uint32_t k = 0; k < PACKET_MAX; k++) {
            lum_word_encode(lum_word_make(FAR_TOF, true, 100u + i),
                            samples + (size_t)LUM_SAMPLE_BYTES * k);
        }
        packet = encode_packet(&r->layout, &group, samples, &len);
        assert_true(receive(r, packet, len));
        (void)gateway_receive(&r->gateway, r->now);
        free(packet);
    }
}

static void conflict(struct rig *r)
{
    put_angles(r, LUM_EYE_GREEN);
    put(r, LUM_EYE_GREEN, LUM_TAG_ANGLES, 0, false, 100, PACKET_MAX);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 0, 10);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 9, 10);
    (void)gateway_receive(&r->gateway, r->now);
}

static void leave_event(struct rig *r)
{
    lum_group group = {.num_samples = 1,
                       .clock_raw = sensor_clock(r) + 1000u,
                       .eye = LUM_EYE_GREEN,
                       .tag = LUM_TAG_ANGLES};
    const uint8_t sample[LUM_SAMPLE_BYTES] = {0};
    group.samples = sample;
    group.line = r->line + 1u;
    assert_true(lum_assembler_push(&r->gateway.assembler, &group,
                                   r->gateway.now_ms) > 0);
}

/* A machine whose times leave no room for a frame that is not whole. */
static struct rig *rig_tight(unsigned eyes)
{
    struct rig *const r = rig_new();
    r->config.eyes = (uint8_t)eyes;
    r->config.hold_ms = 2u * FRAME + (GATEWAY_OPEN_LINES + 1u) * STEP;
    assert_int_equal(rig_init(r), LUM_OK);
    tell_clock(r, 0, sensor_clock(r));
    pass(r, 5000, BOTH);
    next_frame(r);
    pass(r, 5u * STEP, BOTH);
    assert_int_equal(reasons(r), 0);
    return r;
}

/* What shows in no line, since it may have been the last of its own. */
static void what_the_gateway_loses_makes_no_whole_look(void **state)
{
    static const struct {
        void (*lose)(struct rig *);
        unsigned eyes;
        bool is_blind;
    } rows[] = {
        {drop_one, BLUE, true},     {drop_one, GREEN, true},
        {waste_words, BLUE, false}, {waste_words, GREEN, true},
        {conflict, BLUE, false},    {conflict, GREEN, true},
        {leave_event, BLUE, true},  {leave_event, GREEN, true},
    };
    (void)state;
    for (unsigned i = 0; i < 8; i++) {
        struct rig *const r = rig_tight(rows[i].eyes);
        bool is_blind = false;
        rows[i].lose(r);
        for (uint32_t ms = 0; ms < 3u * FRAME; ms += STEP) {
            pass(r, STEP, BOTH);
            is_blind = is_blind || reasons(r) == GATEWAY_SILENT;
        }
        assert_true(is_blind == rows[i].is_blind);
        expect_recovery(r);
        rig_free(r);
    }
}

/* The packets that the last line of a frame still waited for come too late. */
static void lines_cut_by_an_event_that_waited_complete_no_look(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    int64_t whole_ms[LUM_EYES];
    (void)state;
    while (r->line != LINES - 1u) {
        pass(r, STEP, BOTH);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        put_angles(r, eye);
        (void)gateway_receive(&r->gateway, r->now);
        whole_ms[eye] = r->gateway.looks[eye].whole_ms;
    }
    leave_event(r);
    put(r, LUM_EYE_GREEN, LUM_TAG_RANGES, FAR_TOF, true, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(r->gateway.assembler.counters.refused, 2);
    assert_int_equal(r->gateway.assembler.eye[LUM_EYE_GREEN].lines.open_count,
                     1);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(r->gateway.looks[eye].whole_ms, whole_ms[eye]);
        assert_int_equal(r->gateway.looks[eye].count, LINES - 2u);
    }
    rig_free(r);
}

/* So that neither side takes a count for one that it has seen. */
static void each_count_goes_up_by_one(void **state)
{
    struct rig *const r = rig_at(0);
    const heart *const h = &r->gateway.heart;
    (void)state;
    gateway_tick(&r->gateway, r->now);
    for (uint32_t i = 1; i < 6; i++) {
        gateway_tick(&r->gateway, r->now);
        assert_int_equal(h->ticks, i + 1u);
        (void)gateway_receive(&r->gateway, r->now);
        assert_int_equal(h->rounds, i);
        assert_int_equal(heart_stalls(h), i == 1 ? 1 : 2);
    }
    hang(r, SILENCE + 20u);
    assert_int_equal(heart_stalls(h), 3);
    run(r, 20, 10);
    assert_int_equal(heart_stalls(h), 4);
    rig_free(r);
}

/* What is blind anyway has nothing that could grow old in a slow round. */
static void a_slow_round_is_no_stall_while_nothing_is_seen(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        hang(r, SILENCE - 50u);
        (void)gateway_receive(&r->gateway, r->now);
    }
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    hang(r, SILENCE + 10u);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    rig_free(r);
}

/* Whose view ends first is not who is looked at last. */
static void a_hang_stops_when_either_eye_is_old(void **state)
{
    static const unsigned alone[] = {BLUE, GREEN};
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct rig *const r = rig_going(0);
        pass(r, 200, alone[i]);
        hang(r, SILENCE - 2u * STEP - 200u);
        assert_int_equal(reasons(r), 0);
        hang(r, 10);
        assert_int_equal(reasons(r), GATEWAY_STALLED);
        rig_free(r);
    }
}

/* A line that has waited is one of its age. */
static void lines_are_taken_until_they_are_as_old_as_the_silence(void **state)
{
    (void)state;
    for (uint32_t age_ms = SILENCE - 1u; age_ms <= SILENCE; age_ms++) {
        struct rig *const r = rig_going(0);
        const size_t lines = r->lines;
        r->now += age_ms - STEP;
        show(r, BOTH, FAR_TOF, 1);
        assert_int_equal(r->lines, age_ms < SILENCE ? lines + 2u : lines);
        assert_int_equal(r->gateway.old_lines, age_ms < SILENCE ? 0 : 2);
        assert_int_equal(r->gateway.assembler.counters.duplicate, 0);
        rig_free(r);
    }
}

static void answers_as_old_as_the_silence_are_left_out(void **state)
{
    (void)state;
    for (uint32_t age_ms = SILENCE - 1u; age_ms <= SILENCE; age_ms++) {
        struct rig *const r = rig_at(10000);
        tell_clock(r, r->now - age_ms, sensor_clock(r));
        (void)gateway_receive(&r->gateway, r->now);
        assert_int_equal(r->gateway.age.answered, age_ms < SILENCE);
        rig_free(r);
    }
}

static void all_words_of_a_line_are_looked_at(void **state)
{
    struct rig *const r = rig_going(0);
    size_t points;
    (void)state;
    show_out(r);
    points = r->points;
    show(r, BLUE, FAR_TOF, 5u * GATEWAY_BLOCK + 3u);
    show(r, BLUE, FAR_TOF, 4u * GATEWAY_BLOCK);
    assert_int_equal(r->points, points + 2u);
    show(r, BLUE, FAR_TOF, 1);
    assert_int_equal(r->points, points + 2u + 5u * GATEWAY_BLOCK + 3u);
    show(r, BLUE, FAR_TOF, 1);
    assert_int_equal(r->points, points + 2u + 9u * GATEWAY_BLOCK + 3u);
    rig_free(r);
}

static void the_assembler_has_what_there_is_room_for(void **state)
{
    struct rig *const r = rig_at(0);
    const lum_assembler_config *const c = &r->gateway.assembler.config;
    (void)state;
    assert_int_equal(c->open_lines, GATEWAY_OPEN_LINES);
    assert_int_equal(c->reorder_lines, GATEWAY_REORDER_LINES);
    assert_int_equal(c->words_per_line, GATEWAY_LINE_WORDS);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_true(r->gateway.looks[eye].whole_ms < INT32_MIN);
    }
    rig_free(r);
}

/* Else a flood would keep it from deciding. */
static void a_round_takes_as_many_datagrams_as_there_are_slots(void **state)
{
    struct rig *const r = rig_at(0);
    (void)state;
    r->gateway.ring.committed += RING_SLOTS + 3u; /* meanwhile, as it were */
    assert_int_equal(gateway_receive(&r->gateway, 0), RING_SLOTS);
    assert_int_equal(gateway_receive(&r->gateway, 0), 3);
    rig_free(r);
}

/* By the driver, from what the network says. */
static void a_slot_with_impossible_lengths_is_malformed(void **state)
{
    static const struct {
        uint32_t begin, len;
        bool is_bad;
    } rows[] = {
        {0, RING_SLOT_BYTES, false},
        {0, RING_SLOT_BYTES + 1u, true},
        {42, RING_SLOT_BYTES - 42u, false},
        {42, RING_SLOT_BYTES - 41u, true},
        {RING_SLOT_BYTES, 0, false},
        {RING_SLOT_BYTES + 1u, 0, true},
        {UINT32_MAX, 2, true},
        {2, UINT32_MAX, true},
    };
    struct rig *const r = rig_at(0);
    uint32_t bad = 0;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ring_slot *const slot = ring_claim(&r->gateway.ring);
        memset(slot->bytes, 0, sizeof slot->bytes);
        slot->begin = rows[i].begin;
        slot->len = rows[i].len;
        ring_commit(&r->gateway.ring);
        assert_int_equal(gateway_receive(&r->gateway, 0), 1);
        bad += rows[i].is_bad;
        assert_int_equal(r->gateway.kinds[LUM_PACKET_MALFORMED], bad);
    }
    rig_free(r);
}

/* What is fresh is no stray, whatever the silence. */
static void the_gap_of_the_clock_is_no_less_than_the_silence(void **state)
{
    static const struct {
        uint32_t silence_ms, gap_us;
    } rows[] = {{60, 100000},
                {100, 100000},
                {101, 101000},
                {AGE_MAX_MS, AGE_MAX_MS * 1000u}};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct rig *const r = rig_new();
        r->config.frame_ms = 50;
        r->config.silence_ms = rows[i].silence_ms;
        assert_int_equal(rig_init(r), LUM_OK);
        assert_int_equal(r->gateway.assembler.config.gap_us, rows[i].gap_us);
        rig_free(r);
    }
}

static void garbage_is_counted_and_is_no_sign_of_life(void **state)
{
    struct rig *const r = rig_going(0);
    uint64_t seed = 5;
    uint8_t bytes[RING_SLOT_BYTES];
    uint32_t counted = 0;
    (void)state;
    memset(r->gateway.kinds, 0, sizeof r->gateway.kinds);
    for (unsigned i = 0; i < 4000; i++) {
        const size_t len = next_random(&seed) % sizeof bytes;
        for (size_t k = 0; k < sizeof bytes; k++) {
            bytes[k] = (uint8_t)next_random(&seed);
        }
        if (i % 2u == 0) { /* so that it is looked at further */
            lum_header_encode(bytes, (uint8_t)(5u + i / 2u % 4u));
        }
        assert_true(receive(r, bytes, len));
        r->now++;
        (void)gateway_receive(&r->gateway, r->now);
    }
    for (unsigned kind = 0; kind < LUM_PACKET_KINDS; kind++) {
        counted += r->gateway.kinds[kind];
    }
    assert_int_equal(counted, 4000);
    assert_true((reasons(r) & GATEWAY_SILENT) != 0);
    rig_free(r);
}

static void a_full_ring_drops_and_counts(void **state)
{
    static const uint8_t byte[1] = {0};
    struct rig *const r = rig_at(0);
    (void)state;
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        assert_true(receive(r, byte, 1));
    }
    assert_int_equal(ring_dropped(&r->gateway.ring), 0);
    assert_false(receive(r, byte, 1));
    assert_false(receive(r, byte, 1));
    assert_int_equal(ring_dropped(&r->gateway.ring), 2);
    assert_int_equal(gateway_receive(&r->gateway, 0), RING_SLOTS);
    assert_int_equal(gateway_receive(&r->gateway, 0), 0);
    assert_true(receive(r, byte, 1));
    assert_int_equal(ring_dropped(&r->gateway.ring), 2);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_FOREIGN], RING_SLOTS);
    rig_free(r);
}

static void a_ring_keeps_the_order_while_its_counts_wrap(void **state)
{
    static ring ring_;
    ring *const r = &ring_;
    uint32_t put_in = 0;
    uint32_t taken = 0;
    (void)state;
    memset(r, 0xa5, sizeof *r);
    ring_init(r);
    assert_int_equal(ring_dropped(r), 0);
    r->committed = UINT32_MAX - 20u;
    r->released = r->committed;
    for (uint32_t i = 0; i < 60; i++) {
        for (uint32_t k = 0; k < 1u + i % RING_SLOTS; k++) {
            ring_slot *const slot = ring_claim(r);
            if (slot != NULL) {
                slot->len = put_in++;
                ring_commit(r);
            }
        }
        for (uint32_t k = 0; k < 4 && ring_front(r) != NULL; k++) {
            assert_int_equal(ring_front(r)->len, taken++);
            ring_release(r);
        }
    }
    assert_true(put_in > 100 && ring_dropped(r) > 0);
}

static void a_claimed_slot_is_not_seen_before_it_is_committed(void **state)
{
    static ring ring_;
    ring *const r = &ring_;
    (void)state;
    memset(r, 0xa5, sizeof *r);
    ring_init(r);
    assert_non_null(ring_claim(r));
    assert_null(ring_front(r));
    ring_commit(r);
    assert_non_null(ring_front(r));
}

/* Behind the headers of a frame, as a bare MAC writes it. */
static void a_datagram_may_begin_within_its_slot(void **state)
{
    struct rig *const r = rig_at(0);
    ring_slot *slot;
    (void)state;
    for (uint32_t begin = 0; begin <= 46; begin += 23) {
        slot = ring_claim(&r->gateway.ring);
        assert_non_null(slot);
        assert_int_equal(slot->begin, 0);
        memset(slot->bytes, 0, sizeof slot->bytes);
        lum_heartbeat_encode(slot->bytes + begin);
        slot->begin = begin;
        slot->len = LUM_HEARTBEAT_BYTES;
        ring_commit(&r->gateway.ring);
    }
    assert_int_equal(gateway_receive(&r->gateway, 0), 3);
    assert_int_equal(r->gateway.kinds[LUM_PACKET_FOREIGN], 0);
    for (unsigned i = 0; i < RING_SLOTS; i++) { /* nor does it stay */
        assert_int_equal(ring_claim(&r->gateway.ring)->begin, 0);
        ring_commit(&r->gateway.ring);
    }
    rig_free(r);
}

/* A cache line that the driver invalidates holds nothing but its bytes. */
static void bytes_of_slots_fill_lines_of_a_cache(void **state)
{
    struct rig *const r = rig_at(0);
    const ring *const ring_ = &r->gateway.ring;
    (void)state;
    for (unsigned i = 0; i < RING_SLOTS; i++) {
        const uint8_t *const bytes = ring_->slots[i].bytes;
        assert_int_equal((uintptr_t)bytes % RING_LINE_BYTES, 0);
        assert_int_equal(sizeof ring_->slots[i].bytes % RING_LINE_BYTES, 0);
    }
    rig_free(r);
}

static void a_box_has_its_sides_and_a_sector_its_edges(void **state)
{
    static const zone box = {.min = {10, -20, -30}, .max = {100, 20, 30}};
    static const zone sector = {.min = {-1000, -1000, -1000},
                                .max = {1000, 1000, 1000},
                                .range = 50,
                                .left = ZONE_SLOPE_ONE,
                                .right = -ZONE_SLOPE_ONE / 2};
    static const zone left = {.min = {-1000, -1000, -1000},
                              .max = {1000, 1000, 1000},
                              .range = 500,
                              .right = -ZONE_SLOPE_ONE};
    static const zone right = {.min = {-1000, -1000, -1000},
                               .max = {1000, 1000, 1000},
                               .range = 500,
                               .left = ZONE_SLOPE_ONE};
    static const zone far = {.min = {0, 0, 0},
                             .max = {1000000, 1000000, 0},
                             .range = 1000000,
                             .left = ZONE_SLOPE_ONE};
    static const struct {
        const zone *zone;
        int32_t x, y, z;
        bool in;
    } rows[] = {
        {&left, 100, 0, 0, true},        {&left, 100, 1, 0, false},
        {&right, 100, 0, 0, true},       {&right, 100, -1, 0, false},
        {&far, 100000, 100000, 0, true}, {&far, 100000, 100001, 0, false},
        {&sector, 1, 0, 0, true},        {&box, 10, -20, -30, true},
        {&box, 100, 20, 30, true},       {&box, 9, 0, 0, false},
        {&box, 101, 0, 0, false},        {&box, 50, -21, 0, false},
        {&box, 50, 21, 0, false},        {&box, 50, 0, -31, false},
        {&box, 50, 0, 31, false},        {&sector, 30, 30, 0, true},
        {&sector, 30, 31, 0, false},     {&sector, 30, -15, 0, true},
        {&sector, 30, -16, 0, false},    {&sector, 50, 0, 0, true},
        {&sector, 50, 1, 0, false},      {&sector, 51, 0, 0, false},
        {&sector, 0, 0, 0, false},       {&sector, -10, -7, 0, false},
        {&sector, 30, 30, 1000, true},   {&sector, 30, 30, 1001, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const lum_fixed_point p = {rows[i].x, rows[i].y, rows[i].z, 0};
        assert_int_equal(zone_holds(rows[i].zone, &p), rows[i].in);
    }
}

static void the_nearest_is_exact_as_far_as_points_reach(void **state)
{
    static const zone all = {.min = {INT32_MIN, INT32_MIN, INT32_MIN},
                             .max = {INT32_MAX, INT32_MAX, INT32_MAX}};
    static const struct {
        int32_t x, y, z;
        uint32_t mm;
    } rows[] = {
        {MM(3000), MM(-4000), 0, 5000},
        {MM(2000), MM(-3000), MM(6000), 7000},
        {MM(1), 0, 0, 1},
        {MM(1) - 1, 0, 0, 0},
        {1400000000, 1400000000, -1400000000, 151554445},
        {INT32_MIN, INT32_MIN, INT32_MIN, 232471924},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const lum_fixed_point points[] = {
            {INT32_MIN, INT32_MIN, INT32_MIN, LUM_WORD_RISING},
            {rows[i].x, rows[i].y, rows[i].z, LUM_WORD_RISING},
            {0, 0, 0, 0}, /* a falling edge */
        };
        zone_sight sight = zone_empty();
        zone_look(&all, &sight, points, 3);
        assert_int_equal(sight.hits, 2);
        assert_int_equal(zone_nearest_mm(&sight), rows[i].mm);
    }
}

static void points_are_looked_at_one_by_one(void **state)
{
    static const zone box = {.min = {0, 0, 0}, .max = {MM(10), 0, 0}};
    static const lum_fixed_point points[] = {{MM(11), 0, 0, LUM_WORD_RISING},
                                             {MM(7), 0, 0, LUM_WORD_RISING},
                                             {MM(8), 0, 0, LUM_WORD_RISING}};
    zone_sight sight = zone_empty();
    (void)state;
    zone_look(&box, &sight, points, 3);
    assert_int_equal(sight.hits, 2);
    assert_int_equal(zone_nearest_mm(&sight), 7);
}

static void break_zone(struct rig *r, unsigned i)
{
    zone *const z = &r->config.zone;
    if (i < 3) {
        z->min[i] = z->max[i] + 1;
    } else if (i == 3) {
        z->range = -1;
    } else {
        z->right = z->left + 1;
    }
}

static void break_times(struct rig *r, unsigned i)
{
    if (i == 0) {
        r->config.frame_ms = 0;
    } else if (i == 1) { /* two frames and no open lines */
        r->config.hold_ms = 2u * FRAME + GATEWAY_OPEN_LINES * STEP;
    } else if (i == 2) {
        r->config.hold_ms = 0;
    } else if (i == 3) {
        r->config.silence_ms = FRAME;
    } else if (i == 4) {
        r->config.silence_ms = AGE_MAX_MS + 1u;
    } else {
        r->config.lines = 0;
    }
}

static void break_config(struct rig *r, unsigned i)
{
    if (i == 0) {
        r->config.hits = 0;
    } else if (i < 3) {
        r->config.eyes = i == 1 ? 0 : BOTH + 1u;
    } else if (i == 3) {
        r->output.send = NULL;
    } else if (i < 6) {
        r->layout.profile.group[LUM_FIELD_TIMESTAMP].bytes =
            (uint8_t)(i == 4 ? 0 : 2);
    } else {
        r->calibration.tof_lsb_fs = 0;
    }
}

static void times_may_be_as_short_as_two_frames_allow(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.hits = 1;
    r->config.lines = 1;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.lines = LINES;
    r->config.hold_ms = 2u * FRAME + GATEWAY_OPEN_LINES * STEP + 1u;
    r->config.silence_ms = FRAME + 1u;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.lines = UINT32_MAX; /* 2 x UINT32_MAX + 2 by 1 is just below */
    r->config.frame_ms = 1;
    r->config.hold_ms = 2;
    assert_int_equal(rig_init(r), LUM_E_VALUE);
    r->config.hold_ms = 3;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.hold_ms = UINT32_MAX;
    r->config.silence_ms = AGE_MAX_MS;
    r->config.frame_ms = AGE_MAX_MS - 1u;
    assert_int_equal(rig_init(r), LUM_OK);
    rig_free(r);
}

/* It is used as if nobody had looked at the result. */
static void expect_dead(struct rig *r)
{
    assert_int_equal(reasons(r), GATEWAY_SILENT);
    for (unsigned i = 0; i < 600; i++) {
        r->now += 10;
        gateway_tick(&r->gateway, r->now);
        gateway_datagram(&r->gateway, (const uint8_t *)"", 0, r->now);
        assert_int_equal(gateway_receive(&r->gateway, r->now), 0);
        assert_false(gateway_may_kick(&r->gateway));
        assert_int_equal(reasons(r), GATEWAY_SILENT);
    }
    gateway_finish(&r->gateway);
    assert_int_equal(r->sent_count, 0);
}

static void a_gateway_that_was_not_begun_stops(void **state)
{
    struct rig *const r = rig_new(); /* its memory is no zeros */
    (void)state;
    expect_dead(r);
    memset(&r->gateway, 0, sizeof r->gateway);
    expect_dead(r);
    rig_free(r);
}

static void a_zone_may_be_a_point(void **state)
{
    struct rig *const r = rig_new();
    zone *const z = &r->config.zone;
    (void)state;
    memcpy(z->min, z->max, sizeof z->min);
    z->left = 5;
    z->right = 5; /* of a box, they do not matter */
    assert_int_equal(rig_init(r), LUM_OK);
    rig_free(r);
}

static void a_configuration_out_of_range_is_refused_and_stops(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 18; i++) {
        struct rig *const r = rig_new();
        assert_int_equal(rig_init(r), LUM_OK);
        if (i < 5) {
            break_zone(r, i);
        } else if (i < 11) {
            break_times(r, i - 5u);
        } else {
            break_config(r, i - 11u);
        }
        assert_int_equal(rig_init(r), LUM_E_VALUE);
        expect_dead(r);
        rig_free(r);
    }
}

/* What a gateway begins with, whatever was in its memory. */
static void a_gateway_begins_with_nothing_seen(void **state)
{
    struct rig *const r = rig_at(77);
    const gateway *const g = &r->gateway;
    (void)state;
    assert_int_equal(g->reasons, GATEWAY_SILENT);
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        assert_int_equal(g->frames[i].sight.hits, 0);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_true(g->looks[eye].point_ms < -(INT64_C(1) << 60));
        assert_true(g->looks[eye].whole_ms < -(INT64_C(1) << 60));
    }
    assert_int_equal(g->assembler.config.open_lines, GATEWAY_OPEN_LINES);
    assert_int_equal(g->assembler.config.reorder_lines, GATEWAY_REORDER_LINES);
    assert_int_equal(g->assembler.config.words_per_line, GATEWAY_LINE_WORDS);
    assert_int_equal(g->assembler.config.gap_us, SILENCE * 1000u);
    rig_free(r);
}

static void the_first_stop_is_of_blindness_and_no_object(void **state)
{
    struct rig *const r = rig_at(77);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(reasons(r), GATEWAY_SILENT | GATEWAY_STALLED);
    assert_int_equal(r->gateway.heart.lasts_ms, SILENCE);
    rig_free(r);
}

static void one_line_and_one_hit_are_enough_to_ask_for(void **state)
{
    struct rig *const r = rig_new();
    (void)state;
    r->config.hits = 1;
    r->config.lines = 1;
    r->config.hold_ms = 5u * FRAME;
    assert_int_equal(rig_init(r), LUM_OK);
    r->config.zone.range = 10;
    r->config.zone.left = 3;
    r->config.zone.right = 5;
    assert_int_equal(rig_init(r), LUM_E_VALUE);
    rig_free(r);
}

static void every_point_is_handed_out_once(void **state)
{
    static const uint32_t counts[] = {1, 15, 16, 17, 31, 32, 33, 48, 100};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        struct rig *const r = rig_informed(0);
        show(r, BLUE, NEAR_TOF, counts[i]);
        gateway_finish(&r->gateway);
        assert_int_equal(r->lines, 1);
        assert_int_equal(r->points, counts[i]);
        assert_int_equal(
            lum_assembler_counters(&r->gateway.assembler)->duplicate, 0);
        rig_free(r);
    }
}

/* As many as may be under way have places of their own. */
static void frames_take_turns_with_their_places(void **state)
{
    struct rig *const r = rig_going(0);
    (void)state;
    pass(r, 6u * FRAME, BOTH);
    uint32_t least = UINT32_MAX;
    uint32_t most = 0;
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        const uint32_t number = r->gateway.frames[i].number;
        assert_int_equal(number % GATEWAY_FRAMES, i);
        least = number < least ? number : least;
        most = number > most ? number : most;
    }
    assert_true(least > GATEWAY_FRAMES);
    assert_int_equal(most - least, GATEWAY_FRAMES - 1u);
    rig_free(r);
}

static void assert_spoilt(const struct rig *r, unsigned eyes)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(r->gateway.looks[eye].spoilt_ms == r->now,
                         eyes >> eye & 1u);
    }
}

static void a_conflict_spoils_the_look_of_its_eye(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct rig *const r = rig_informed(55);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 0, 10);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 0, 10); /* a duplicate */
        (void)gateway_receive(&r->gateway, r->now);
        assert_spoilt(r, 0);
        put(r, eye, LUM_TAG_ANGLES, 0, false, 5, 10);
        (void)gateway_receive(&r->gateway, r->now);
        assert_spoilt(r, 1u << eye);
        rig_free(r);
    }
}

static void a_datagram_that_was_dropped_spoils_both_looks(void **state)
{
    struct rig *const r = rig_informed(55);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, 0);
    r->gateway.ring.dropped++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    r->now++;
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, 0);
    rig_free(r);
}

/* As an interrupt of the network does while the main loop is in its round. */
static void drop_during_a_line(void *context, const lum_line *line)
{
    struct rig *const r = context;
    take_line(context, line);
    r->gateway.output.line = take_line;
    r->gateway.ring.dropped++;
}

static void what_is_dropped_during_a_round_spoils_the_lines_behind(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    const look *const eye = &r->gateway.looks[LUM_EYE_BLUE];
    const uint32_t before = eye->count;
    (void)state;
    r->gateway.output.line = drop_during_a_line;
    for (unsigned i = 0; i < 2; i++) { /* each closes a whole line */
        put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
        next_line(r);
    }
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(eye->count, before + 1u);
    assert_spoilt(r, BOTH);
    rig_free(r);
}

/* Behind the last datagram too. */
static void what_is_dropped_at_a_rounds_end_is_seen_by_that_round(void **state)
{
    struct rig *const r = rig_tight(BOTH);
    (void)state;
    r->gateway.output.line = drop_during_a_line;
    put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    rig_free(r);
}

/* As of a flush by another. */
static void an_event_that_waits_spoils_both_looks_and_costs_no_packet(
    void **state)
{
    struct rig *const r = rig_informed(55);
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        put(r, LUM_EYE_GREEN, LUM_TAG_ANGLES, 0, false, 0, 1);
        next_line(r);
    }
    (void)gateway_receive(&r->gateway, r->now);
    const lum_group other = {.line = r->line,
                             .num_samples = 1,
                             .clock_raw = sensor_clock(r),
                             .eye = LUM_EYE_GREEN,
                             .tag = LUM_TAG_ANGLES,
                             .samples = (const uint8_t[4]){0}};
    assert_int_equal(lum_assembler_push(&r->gateway.assembler, &other, 0),
                     LUM_LINE_READY);
    r->line = 9;
    put(r, LUM_EYE_BLUE, LUM_TAG_ANGLES, 0, false, 0, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_spoilt(r, BOTH);
    const size_t before = r->lines;
    gateway_finish(&r->gateway);
    assert_int_equal(r->lines, before + 1u);
    rig_free(r);
}

/* What the eyes that have to be heard have shown, the shorter of both. */
static uint32_t served(struct rig *r, unsigned eyes, int64_t blue_ms,
                       int64_t green_ms, int64_t whole_ms)
{
    r->gateway.config.eyes = (uint8_t)eyes;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        look *const l = &r->gateway.looks[eye];
        l->point_ms = r->now - (eye == LUM_EYE_BLUE ? blue_ms : green_ms);
        l->whole_ms = r->now - whole_ms;
    }
    (void)gateway_receive(&r->gateway, r->now);
    return r->gateway.heart.lasts_ms;
}

static void a_round_serves_as_long_as_the_eye_that_ends_first(void **state)
{
    struct rig *const r = rig_informed(5000);
    (void)state;
    (void)gateway_receive(&r->gateway, r->now);
    assert_int_equal(served(r, BOTH, 100, 200, 0), SILENCE - 200u);
    assert_int_equal(served(r, BOTH, 300, 200, 0), SILENCE - 300u);
    assert_int_equal(served(r, BLUE, 100, 200, 0), SILENCE - 100u);
    assert_int_equal(served(r, GREEN, 300, 200, 0), SILENCE - 200u);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD - 100u), 100);
    assert_int_equal(served(r, BOTH, SILENCE - 1u, 0, 0), 1);
    /* and when nothing serves, a sign of life does */
    assert_int_equal(served(r, BOTH, SILENCE, 0, 0), SILENCE);
    assert_int_equal(served(r, BOTH, SILENCE + 1u, 0, 0), SILENCE);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD), SILENCE);
    assert_int_equal(served(r, BOTH, 0, 0, HOLD + 1u), SILENCE);
    rig_free(r);
}

/* Asked for longer ago than silence_ms, an answer is none. */
static void an_answer_serves_that_was_asked_for_lately(void **state)
{
    struct rig *const r = rig_at(5000);
    (void)state;
    tell_clock(r, r->now - HOLD + 1u, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_false(r->gateway.age.answered);
    tell_clock(r, r->now - SILENCE, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_false(r->gateway.age.answered);
    tell_clock(r, r->now - SILENCE + 1u, 1);
    (void)gateway_receive(&r->gateway, r->now);
    assert_true(r->gateway.age.answered);
    rig_free(r);
}

static void a_line_serves_until_silence_ms_old(void **state)
{
    static const uint32_t waits[] = {FRAME + 10u, SILENCE - 1u, SILENCE};
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct rig *const r = rig_informed(5000);
        show(r, BLUE, NEAR_TOF, 1);
        r->gateway.now_ms += waits[i];
        gateway_finish(&r->gateway);
        assert_int_equal(r->gateway.old_lines, waits[i] >= SILENCE ? 1 : 0);
        rig_free(r);
    }
}

static bool believes(struct rig *r, uint32_t ago_ms, bool with_status)
{
    uint8_t packet[64];
    lum_tlv_writer w;
    r->gateway.laser_down = true;
    assert_int_equal(lum_tlv_begin(&w, packet, sizeof packet, r->now - ago_ms),
                     LUM_OK);
    if (with_status) {
        add_status(r, &w, 0);
    }
    assert_true(receive(r, packet, w.len));
    (void)gateway_receive(&r->gateway, r->now);
    return !r->gateway.laser_down;
}

static void a_good_status_is_believed_of_lately(void **state)
{
    struct rig *const r = rig_at(5000);
    (void)state;
    assert_true(believes(r, 0, true));
    assert_true(believes(r, SILENCE - 1u, true));
    assert_false(believes(r, SILENCE, true));
    assert_false(believes(r, HOLD - 1u, true));
    assert_false(believes(r, 0, false));
    rig_free(r);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(it_is_stopped_until_both_eyes_were_heard),
    cmocka_unit_test(a_hold_of_a_moment_does_not_end_the_first_silence),
    cmocka_unit_test(an_eye_that_falls_silent_stops),
    cmocka_unit_test(an_eye_that_is_not_wanted_may_be_silent),
    cmocka_unit_test(lines_without_points_are_silence),
    cmocka_unit_test(silence_lasts_beyond_a_wrap_of_the_clock),
    cmocka_unit_test(as_many_hits_as_wanted_stop_at_once),
    cmocka_unit_test(hits_of_both_eyes_and_many_lines_add_up_within_a_frame),
    cmocka_unit_test(hits_of_two_frames_do_not_add_up),
    cmocka_unit_test(falling_edges_are_no_hits),
    cmocka_unit_test(a_stop_outlives_its_cause_by_the_hold),
    cmocka_unit_test(what_two_frames_show_far_apart_is_one_stop),
    cmocka_unit_test(what_stays_in_the_zone_keeps_the_machine_stopped),
    cmocka_unit_test(a_frame_tells_its_hits_and_the_nearest),
    cmocka_unit_test(a_frame_before_the_first_is_a_frame_too),
    cmocka_unit_test(a_line_too_late_for_its_frame_counts_for_the_newer_one),
    cmocka_unit_test(a_wrap_of_frame_numbers_changes_nothing),
    cmocka_unit_test(the_end_hands_out_what_is_open),
    cmocka_unit_test(observers_may_be_missing),
    cmocka_unit_test(five_heartbeats_a_second_leave_across_a_wrap),
    cmocka_unit_test(a_slow_tick_makes_no_burst),
    cmocka_unit_test(the_status_is_asked_for_once_a_second),
    cmocka_unit_test(the_clock_is_asked_for_with_each_heartbeat),
    cmocka_unit_test(a_heartbeat_that_was_refused_is_tried_again),
    cmocka_unit_test(a_heartbeat_is_tried_again_after_weeks_of_refusals),
    cmocka_unit_test(nothing_is_sent_before_the_first_round),
    cmocka_unit_test(nothing_is_sent_until_the_sensor_has_timed_out),
    cmocka_unit_test(heartbeats_end_when_the_main_loop_hangs),
    cmocka_unit_test(a_hang_stops_when_what_was_seen_is_old),
    cmocka_unit_test(a_stall_that_no_decision_saw_is_held),
    cmocka_unit_test(the_watchdog_is_kicked_only_while_the_timer_goes_on),
    cmocka_unit_test(a_hang_lasts_beyond_a_wrap_of_the_clock),
    cmocka_unit_test(a_main_loop_that_comes_back_sends_again_and_is_held),
    cmocka_unit_test(every_bit_that_takes_the_laser_down_stops),
    cmocka_unit_test(a_hazard_beside_a_clean_status_of_its_packet_stops),
    cmocka_unit_test(a_hazard_that_ends_before_the_round_does_stops),
    cmocka_unit_test(all_reasons_can_stand_together),
    cmocka_unit_test(what_is_no_status_changes_nothing),
    cmocka_unit_test(an_old_status_says_nothing_good),
    cmocka_unit_test(packets_as_old_as_the_silence_are_left_out),
    cmocka_unit_test(lines_that_become_old_are_closed_and_left_out),
    cmocka_unit_test(a_driver_without_a_ring_hands_over_datagrams),
    cmocka_unit_test(what_the_gateway_loses_makes_no_whole_look),
    cmocka_unit_test(lines_cut_by_an_event_that_waited_complete_no_look),
    cmocka_unit_test(a_hang_stops_when_either_eye_is_old),
    cmocka_unit_test(lines_are_taken_until_they_are_as_old_as_the_silence),
    cmocka_unit_test(answers_as_old_as_the_silence_are_left_out),
    cmocka_unit_test(all_words_of_a_line_are_looked_at),
    cmocka_unit_test(the_assembler_has_what_there_is_room_for),
    cmocka_unit_test(a_beat_keeps_its_pace_where_ticks_do_not_fit_it),
    cmocka_unit_test(each_count_goes_up_by_one),
    cmocka_unit_test(a_slow_round_is_no_stall_while_nothing_is_seen),
    cmocka_unit_test(a_round_takes_as_many_datagrams_as_there_are_slots),
    cmocka_unit_test(a_slot_with_impossible_lengths_is_malformed),
    cmocka_unit_test(the_gap_of_the_clock_is_no_less_than_the_silence),
    cmocka_unit_test(garbage_is_counted_and_is_no_sign_of_life),
    cmocka_unit_test(a_full_ring_drops_and_counts),
    cmocka_unit_test(a_ring_keeps_the_order_while_its_counts_wrap),
    cmocka_unit_test(a_claimed_slot_is_not_seen_before_it_is_committed),
    cmocka_unit_test(a_datagram_may_begin_within_its_slot),
    cmocka_unit_test(bytes_of_slots_fill_lines_of_a_cache),
    cmocka_unit_test(a_box_has_its_sides_and_a_sector_its_edges),
    cmocka_unit_test(the_nearest_is_exact_as_far_as_points_reach),
    cmocka_unit_test(points_are_looked_at_one_by_one),
    cmocka_unit_test(a_zone_may_be_a_point),
    cmocka_unit_test(times_may_be_as_short_as_two_frames_allow),
    cmocka_unit_test(a_gateway_that_was_not_begun_stops),
    cmocka_unit_test(a_configuration_out_of_range_is_refused_and_stops),
    cmocka_unit_test(a_gateway_begins_with_nothing_seen),
    cmocka_unit_test(the_first_stop_is_of_blindness_and_no_object),
    cmocka_unit_test(one_line_and_one_hit_are_enough_to_ask_for),
    cmocka_unit_test(every_point_is_handed_out_once),
    cmocka_unit_test(frames_take_turns_with_their_places),
    cmocka_unit_test(a_conflict_spoils_the_look_of_its_eye),
    cmocka_unit_test(a_datagram_that_was_dropped_spoils_both_looks),
    cmocka_unit_test(what_is_dropped_during_a_round_spoils_the_lines_behind),
    cmocka_unit_test(what_is_dropped_at_a_rounds_end_is_seen_by_that_round),
    cmocka_unit_test(an_event_that_waits_spoils_both_looks_and_costs_no_packet),
    cmocka_unit_test(a_round_serves_as_long_as_the_eye_that_ends_first),
    cmocka_unit_test(an_answer_serves_that_was_asked_for_lately),
    cmocka_unit_test(a_line_serves_until_silence_ms_old),
    cmocka_unit_test(a_good_status_is_believed_of_lately),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
