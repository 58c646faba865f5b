/* The gateway compared with a model of its promises, at each millisecond and
 * for times in any relation: the machine may move only while each eye has shown
 * a point within the silence, and each line, whole and clear, within the hold.
 * The model knows when each packet was measured, and which ones the gateway
 * got, but not how the gateway decides. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "gateway.h"

#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define BOTH     (1u << LUM_EYE_BLUE | 1u << LUM_EYE_GREEN)
#define MM(x)    ((x)*LUM_FIXED_PER_MM)
#define NEAR_TOF 2564 /* 5 m straight ahead, in the zone */
#define FAR_TOF  20512

#define LINES      12u
#define KEPT       1024u /* packets sent, that may be sent again */
#define LOOKS      96u   /* frames that the model remembers */
#define ANSWERS    64u
#define TICK_MS    10u
#define DAWN       100000 /* the world's time is far from 0 */
#define PARTS      5u /* packets of a line: three of angles, two of ranges */
#define ANGLES     7u /* the first three */
#define RANGES     24u
#define LAST_RANGE 16u

/* What is wrong for a while. */
enum trouble {
    NONE,
    PAUSE,     /* nothing comes */
    BLUE_GONE, /* one eye does not come */
    GREEN_GONE,
    ANGLES_ONLY,
    RANGES_ONLY,
    REPLAY,     /* nothing but what came before */
    REPLAY_TOO, /* that as well */
    TWICE,      /* each packet */
    LOSS,
    HELD, /* a queue hands out late what was sent */
    HANG, /* the main loop makes no round */
    MUTE, /* the sensor does not answer requests for its clock */
    SLOW_ANSWERS,
    OBJECT,
    RESTART,     /* of the sensor, whose clock then is anything */
    NOT_DRAINED, /* somebody leaves an event in the assembler */
    TROUBLES
};

struct packet {
    int64_t measured_ms;
    uint32_t clock_us;
    uint32_t frame;
    uint32_t line;
    uint32_t hits;
    unsigned eye;
    unsigned part;
};

struct answer {
    int64_t due_ms;
    lum_timestamp t;
};

/* A line of an eye, as far as it came. */
struct seen {
    int64_t measured_ms;
    uint32_t frame;
    uint32_t hits;
    uint8_t parts;
};

struct world {
    gateway gateway; /* first: it has to be aligned */
    void *memory;
    gateway_config config;
    lum_layout layout;
    int64_t ms;
    uint32_t ms_of_gateway; /* what that calls 0 */
    uint64_t seed;
    enum trouble trouble;
    int64_t trouble_ends;
    uint32_t frame_ms; /* in truth */
    uint32_t clock_us; /* of the sensor, at 0 */
    uint32_t frame;
    uint32_t line;
    int64_t line_ms; /* when the next line is due */
    struct packet packets[KEPT];
    size_t sent; /* of them, ever */
    size_t held; /* index of the oldest that the queue holds */
    struct answer answers[ANSWERS];
    size_t asked;
    size_t answered;
    struct seen seen[LUM_EYES][LINES][LOOKS];
    int64_t point_ms[LUM_EYES];
    uint32_t moved_ms;
};

static uint32_t gateway_ms(const struct world *w)
{
    return (uint32_t)w->ms + w->ms_of_gateway;
}

static uint32_t clock_at(const struct world *w, int64_t ms)
{
    return (uint32_t)ms * 1000u + w->clock_us;
}

static bool take_request(void *context, const uint8_t *bytes, size_t len)
{
    struct world *const w = context;
    struct answer *const a = &w->answers[w->asked % ANSWERS];
    lum_timestamp request;
    if (lum_timestamp_decode(bytes, len, &request) == LUM_OK &&
        w->trouble != MUTE) {
        const uint32_t longest = w->trouble == SLOW_ANSWERS ? 1500 : 5;
        a->due_ms = w->ms + next_random(&w->seed) % longest;
        a->t.sequence = request.sequence;
        a->t.clock_us = clock_at(w, w->ms);
        w->asked++;
    }
    return true;
}

static bool is_full(const struct world *w)
{
    const ring *const r = &w->gateway.ring;
    return r->committed - r->released == RING_SLOTS;
}

/* Whether the datagram found room. */
static bool receive(struct world *w, const void *bytes, size_t len)
{
    ring_slot *slot;
    if (is_full(w) && w->trouble != HANG) {
        (void)gateway_receive(&w->gateway, gateway_ms(w));
    }
    slot = ring_claim(&w->gateway.ring);
    if (slot == NULL) {
        return false;
    }
    memcpy(slot->bytes, bytes, len);
    slot->len = (uint32_t)len;
    ring_commit(&w->gateway.ring);
    return true;
}

static uint32_t count_samples(const struct packet *p)
{
    static const uint32_t n[PARTS] = {334, 334, 332, 0, 1};
    return p->part == 3 ? (p->hits > 0 ? p->hits : 1u) : n[p->part];
}

static uint8_t *encode(const struct world *w, const struct packet *p,
                       size_t *len)
{
    uint8_t samples[334 * LUM_SAMPLE_BYTES];
    const bool is_range = (RANGES >> p->part & 1u) != 0;
    const uint32_t first = p->part == 4 ? 400u : 334u * (p->part % 3u);
    const int32_t tof = p->hits > 0 && p->part == 3 ? NEAR_TOF : FAR_TOF;
    const lum_group group = {
        .line = p->line,
        .num_samples = count_samples(p),
        .first_sample_index =
            !is_range ? first
                      : (p->part == 3 ? 0 : (p->hits > 0 ? p->hits : 1u)),
        .clock_raw = p->clock_us,
        .eye = (uint8_t)p->eye,
        .tag = is_range ? LUM_TAG_RANGES : LUM_TAG_ANGLES};
    memset(samples, 0, sizeof samples);
    for (uint32_t i = 0; is_range && i < group.num_samples; i++) {
        lum_word_encode(lum_word_make(tof, true, first + i),
                        samples + (size_t)LUM_SAMPLE_BYTES * i);
    }
    return encode_packet(&w->layout, &group, samples, len);
}

/* Whether a line seems whole: nothing shows that its last range packets are
 * missing. */
static bool is_whole(uint8_t parts)
{
    return (parts & ANGLES) == ANGLES && (parts & RANGES) != LAST_RANGE;
}

static void note(struct world *w, const struct packet *p)
{
    struct seen *const s = &w->seen[p->eye][p->line][p->frame % LOOKS];
    if (s->frame != p->frame) {
        *s = (struct seen){
            .measured_ms = p->measured_ms, .frame = p->frame, .hits = p->hits};
    }
    s->parts = (uint8_t)(s->parts | 1u << p->part);
    if ((RANGES >> p->part & 1u) != 0 && p->measured_ms > w->point_ms[p->eye]) {
        w->point_ms[p->eye] = p->measured_ms;
    }
}

static void deliver(struct world *w, const struct packet *p)
{
    size_t len = 0;
    uint8_t *const bytes = encode(w, p, &len);
    if (receive(w, bytes, len)) {
        note(w, p);
    }
    free(bytes);
}

static bool is_lost(struct world *w, const struct packet *p)
{
    switch (w->trouble) {
    case PAUSE:
    case REPLAY:
    case HELD:
        return true;
    case BLUE_GONE:
        return p->eye == LUM_EYE_BLUE;
    case GREEN_GONE:
        return p->eye == LUM_EYE_GREEN;
    case ANGLES_ONLY:
        return (RANGES >> p->part & 1u) != 0;
    case RANGES_ONLY:
        return (ANGLES >> p->part & 1u) != 0;
    case LOSS:
        return next_random(&w->seed) % 50u == 0;
    case NONE:
    case REPLAY_TOO:
    case TWICE:
    case HANG:
    case MUTE:
    case SLOW_ANSWERS:
    case OBJECT:
    case RESTART:
    case NOT_DRAINED:
    case TROUBLES:
    default:
        return false;
    }
}

static void send_packet(struct world *w, const struct packet *p)
{
    w->packets[w->sent % KEPT] = *p;
    w->sent++;
    if (is_lost(w, p)) {
        return;
    }
    deliver(w, p);
    if (w->trouble == TWICE) {
        deliver(w, p);
    }
}

static void scan_line(struct world *w)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        for (unsigned part = 0; part < PARTS; part++) {
            const struct packet p = {.measured_ms = w->ms,
                                     .clock_us = clock_at(w, w->ms),
                                     .frame = w->frame,
                                     .line = w->line,
                                     .hits = w->trouble == OBJECT &&
                                                     w->line == LINES / 2u
                                                 ? w->config.hits
                                                 : 0,
                                     .eye = eye,
                                     .part = part};
            send_packet(w, &p);
        }
    }
    w->line++;
    if (w->line == LINES) {
        w->line = 0;
        w->frame++;
    }
}

/* Packets of any time, in their order or not. */
static void replay(struct world *w)
{
    const size_t kept = w->sent < KEPT ? w->sent : KEPT;
    const size_t back = 1u + next_random(&w->seed) % kept;
    for (size_t i = 0; i < 10u && i < back; i++) {
        deliver(w, &w->packets[(w->sent - back + i) % KEPT]);
    }
}

/* As fast as they were sent, all later by as much. */
static void hand_out_held(struct world *w)
{
    for (unsigned i = 0; i < 4u && w->held < w->sent; i++) {
        const struct packet *const p = &w->packets[w->held % KEPT];
        if (w->sent - w->held < KEPT && p->measured_ms + 700 <= w->ms) {
            deliver(w, p);
        }
        w->held += w->sent - w->held >= KEPT || p->measured_ms + 700 <= w->ms;
    }
}

static void leave_event(struct world *w)
{
    const struct packet *const p = &w->packets[(w->sent - 1u) % KEPT];
    size_t len = 0;
    uint8_t *const bytes = encode(w, p, &len);
    lum_group group;
    assert_int_equal(lum_packet_decode(&w->layout, bytes, len, &group),
                     LUM_PACKET_DATA);
    for (uint32_t i = 0; i < 4u * LINES; i++) {
        group.line = p->line + i; /* until one waits, with luck */
        if (lum_assembler_push(&w->gateway.assembler, &group,
                               w->gateway.now_ms) > 0) {
            break;
        }
    }
    free(bytes);
}

static void begin_trouble(struct world *w, enum trouble trouble, int64_t ms)
{
    w->trouble = trouble;
    w->trouble_ends = w->ms + ms;
    w->held = w->sent;
    if (trouble == RESTART) {
        w->clock_us = next_random(&w->seed);
        w->line = 0;
        w->frame++;
    } else if (trouble == NOT_DRAINED && w->sent > 0) {
        leave_event(w);
    }
}

/* Half of the time all is well. */
static void change_trouble(struct world *w)
{
    if (w->ms >= w->trouble_ends) {
        const uint32_t ms = 1u + next_random(&w->seed) % 1500u;
        begin_trouble(w,
                      w->trouble != NONE
                          ? NONE
                          : (enum trouble)(next_random(&w->seed) % TROUBLES),
                      ms);
    }
}

/* Whether a line was seen whole, and clear, within the hold. */
static bool is_clear(const struct world *w, const struct seen *looks,
                     int64_t slack_ms)
{
    for (unsigned i = 0; i < LOOKS; i++) {
        const struct seen *const s = &looks[i];
        if (is_whole(s->parts) && s->hits == 0 &&
            w->ms - s->measured_ms < (int64_t)w->config.hold_ms + slack_ms) {
            return true;
        }
    }
    return false;
}

static bool may_move(const struct world *w, unsigned eye, int64_t slack_ms)
{
    uint32_t lines = 0;
    for (uint32_t i = 0; i < LINES; i++) {
        lines += is_clear(w, w->seen[eye][i], slack_ms);
    }
    return lines >= w->config.lines &&
           w->ms - w->point_ms[eye] < (int64_t)w->config.silence_ms + slack_ms;
}

/* A hang shows at a tick, and a round at the tick after it. */
static void check(struct world *w)
{
    const int64_t slack_ms = w->trouble == HANG ? 2 * TICK_MS : 0;
    if (gateway_reasons(&w->gateway) != 0) {
        return;
    }
    w->moved_ms++;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if ((w->config.eyes >> eye & 1u) != 0 && !may_move(w, eye, slack_ms)) {
            print_error("eye %u at %ld ms, trouble %d: frame %u, told %u, "
                        "hold %u, silence %u, hits %u, lines %u\n",
                        eye, (long)w->ms - DAWN, (int)w->trouble, w->frame_ms,
                        w->config.frame_ms, w->config.hold_ms,
                        w->config.silence_ms, w->config.hits, w->config.lines);
            fail();
        }
    }
}

static void hand_out_answers(struct world *w)
{
    while (w->answered < w->asked &&
           w->answers[w->answered % ANSWERS].due_ms <= w->ms) {
        uint8_t packet[LUM_TIMESTAMP_BYTES];
        lum_timestamp_encode(packet, &w->answers[w->answered % ANSWERS].t);
        (void)receive(w, packet, sizeof packet);
        w->answered++;
    }
}

/* A millisecond. */
static void pass(struct world *w)
{
    w->ms++;
    hand_out_answers(w);
    if (w->ms >= w->line_ms) {
        w->line_ms += w->frame_ms / LINES;
        scan_line(w);
    }
    if ((w->trouble == REPLAY || w->trouble == REPLAY_TOO) && w->sent > 0) {
        replay(w);
    } else if (w->trouble == HELD) {
        hand_out_held(w);
    }
    if (w->ms % TICK_MS == 0) {
        gateway_tick(&w->gateway, gateway_ms(w));
    }
    if (w->trouble != HANG) {
        (void)gateway_receive(&w->gateway, gateway_ms(w));
    }
    check(w);
}

static struct world *world_new(uint32_t frame_ms, uint64_t seed)
{
    uint8_t *const memory = calloc(1, sizeof(struct world) + RING_LINE_BYTES);
    struct world *w;
    assert_non_null(memory);
    w = (void *)(memory +
                 (RING_LINE_BYTES - (uintptr_t)memory % RING_LINE_BYTES));
    w->memory = memory;
    w->seed = seed;
    w->ms = DAWN;
    w->frame_ms = frame_ms;
    w->frame = 1;
    w->line_ms = w->ms;
    w->clock_us = 0u - (uint32_t)w->ms * 1000u - 8000000u; /* wraps soon */
    w->ms_of_gateway = 0u - (uint32_t)w->ms - 5000u;       /* likewise */
    w->point_ms[0] = INT64_MIN / 2;
    w->point_ms[1] = INT64_MIN / 2;
    w->trouble_ends = INT64_MAX;
    lum_layout_default(&w->layout);
    w->config =
        (gateway_config){.zone = {.min = {MM(1000), MM(-1000), MM(-500)},
                                  .max = {MM(8000), MM(1000), MM(500)}},
                         .hits = 1,
                         .lines = LINES,
                         .frame_ms = 1,
                         .eyes = BOTH};
    return w;
}

static void world_begin(struct world *w)
{
    const gateway_output output = {.context = w, .send = take_request};
    lum_calibration calibration;
    lum_calibration_default(&calibration);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        calibration.eye[eye].elevation_min_udeg = -10000000;
        calibration.eye[eye].elevation_max_udeg = 10000000;
        calibration.eye[eye].mount_yaw_udeg = 0;
    }
    assert_int_equal(gateway_init(&w->gateway, &w->config, &output,
                                  &calibration, &w->layout, gateway_ms(w)),
                     LUM_OK);
}

static void world_free(struct world *w)
{
    free(w->memory);
}

static void pass_for(struct world *w, uint32_t ms)
{
    for (; ms > 0; ms--) {
        pass(w);
    }
}

/* In a sound world. */
static void expect_going(struct world *w)
{
    pass_for(w, HEART_SILENCE_MS + 3u * w->frame_ms + w->config.hold_ms + 100u);
    assert_int_equal(gateway_reasons(&w->gateway), 0);
    w->moved_ms = 0;
}

static void try_times(uint32_t frame_ms, uint32_t hold_ms, uint32_t silence_ms,
                      uint64_t seed)
{
    struct world *const w = world_new(frame_ms, seed);
    w->config.hold_ms = hold_ms;
    w->config.silence_ms = silence_ms;
    w->config.frame_ms =
        seed % 2u == 0 || silence_ms <= frame_ms || hold_ms <= 3u * frame_ms
            ? 1
            : frame_ms;
    w->config.hits = seed % 3u == 0 ? 4 : 1;
    world_begin(w);
    /* two frames, the open lines, a packet's age and a round */
    if (hold_ms > 2u * frame_ms + 3u * frame_ms / LINES + 8u &&
        silence_ms > 3u * frame_ms / LINES + 8u) {
        expect_going(w);
    } else {
        pass_for(w, HEART_SILENCE_MS);
    }
    w->trouble_ends = w->ms;
    for (unsigned i = 0; i < 4000; i++) {
        change_trouble(w);
        pass(w);
    }
    world_free(w);
}

static void no_relation_of_the_times_lets_the_machine_move_unseeing(
    void **state)
{
    static const uint32_t frames[] = {36, 96, 240};
    static const uint32_t holds[] = {60, 210, 560, 3000};
    static const uint32_t silences[] = {15, 110, 500, 2500};
    uint64_t seed = 1;
    (void)state;
    for (unsigned f = 0; f < 3; f++) {
        for (unsigned h = 0; h < 4; h++) {
            for (unsigned s = 0; s < 4; s++) {
                try_times(frames[f], holds[h], silences[s], seed++);
            }
        }
    }
}

/* Each trouble separately, between two times without trouble: the gateway
 * recovers by itself. */
static void after_each_trouble_the_machine_goes_on(void **state)
{
    (void)state;
    for (unsigned trouble = 0; trouble < TROUBLES; trouble++) {
        struct world *const w = world_new(96, trouble);
        w->config.hold_ms = 260;
        w->config.silence_ms = 130;
        world_begin(w);
        expect_going(w);
        begin_trouble(w, (enum trouble)trouble, 2000);
        pass_for(w, 2000);
        begin_trouble(w, NONE, 0);
        pass_for(w, 2000);
        assert_int_equal(gateway_reasons(&w->gateway), 0);
        world_free(w);
    }
}

/* What a network may do to packets harms nothing. */
static void what_comes_twice_or_again_does_not_stop(void **state)
{
    static const enum trouble harmless[] = {NONE, TWICE, REPLAY_TOO, MUTE};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct world *const w = world_new(96, i);
        w->config.hold_ms = 260;
        w->config.silence_ms = 130;
        world_begin(w);
        expect_going(w);
        begin_trouble(w, harmless[i], 1000);
        pass_for(w, 1000);
        assert_int_equal(w->moved_ms, 1000);
        world_free(w);
    }
}

/* Lines that were left open show what was there before a pause. */
static void old_points_in_open_lines_do_not_count(void **state)
{
    struct world *const w = world_new(96, 1);
    (void)state;
    w->config.frame_ms = 100;
    w->config.hold_ms = 230;
    w->config.silence_ms = 1000;
    world_begin(w);
    expect_going(w);
    begin_trouble(w, PAUSE, 10000);
    pass_for(w, 10000);
    assert_true(w->moved_ms < 230);
    w->moved_ms = 0;
    begin_trouble(w, ANGLES_ONLY, 5000);
    pass_for(w, 5000);
    assert_int_equal(w->moved_ms, 0);
    assert_int_equal(w->gateway.old_lines, 2u * GATEWAY_OPEN_LINES);
    world_free(w);
}

/* The frames of an eye that lost their upper half go on as one. */
static void half_a_frame_is_no_look_however_often_it_comes(void **state)
{
    struct world *const w = world_new(96, 1);
    (void)state;
    w->config.hold_ms = 400;
    w->config.silence_ms = 1000;
    world_begin(w);
    expect_going(w);
    for (unsigned i = 0; i < 3000; i++) {
        pass(w);
        w->trouble = w->line * 2u >= LINES ? PAUSE : NONE;
    }
    assert_true((gateway_reasons(&w->gateway) & GATEWAY_SILENT) != 0);
    assert_true(w->moved_ms < 400);
    world_free(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_comes_twice_or_again_does_not_stop),
        cmocka_unit_test(after_each_trouble_the_machine_goes_on),
        cmocka_unit_test(old_points_in_open_lines_do_not_count),
        cmocka_unit_test(half_a_frame_is_no_look_however_often_it_comes),
        cmocka_unit_test(
            no_relation_of_the_times_lets_the_machine_move_unseeing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
