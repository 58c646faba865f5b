/* gateway FLAT_FILE: the gateway on the datagrams of a capture, as
 * tests/flat/flatten writes them: of each its length (u32), its time in ns
 * (i64), both little-endian, and its bytes. Their times are the clock. On every
 * target the same text comes out. */
#include "gateway.h"
#include "port/port.h"
#include "port/text.h"

#define NS_PER_MS  1000000
#define US_PER_MS  1000u
#define TICK_MS    50u
#define GAP_MS     10000u /* a longer one, or one backwards, is cut */
#define HEAD_BYTES 12u
#define COLUMN     20u
#define HOLD_MS    1200u
#define MM(length) ((length)*LUM_FIXED_PER_MM)

/* A board's port sets its watchdog to this. When the timer is dead and no data
 * shows it, the machine moves on until then, by what is as old as HOLD_MS. */
#ifndef WATCHDOG_MS
#define WATCHDOG_MS 1000u
#endif
#if WATCHDOG_MS > HOLD_MS
#error "WATCHDOG_MS has to be HOLD_MS or less"
#endif

typedef struct program {
    gateway gateway;
    uint64_t lines_digest;
    uint64_t points_digest;
    uint64_t projected; /* words: rising and falling edges */
    uint64_t frames;
    uint64_t kicks;    /* of the watchdog */
    int64_t file_ms;   /* time of the newest datagram */
    uint32_t now_ms;   /* since the first one */
    uint32_t reasons;  /* as told last */
    uint32_t too_long; /* datagrams longer than a slot */
    uint32_t waiting;  /* datagrams in the ring */
    uint32_t clock_us; /* of the newest packet of data */
    uint32_t clock_ms; /* when it came */
    bool has_clock;
    int file;
    text out;
} program;

/* FNV-1a over the value's bytes, lowest first. */
static void mix(uint64_t *digest, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        *digest ^= (value >> (8u * i)) & 0xffu;
        *digest *= UINT64_C(0x100000001b3);
    }
}

/* The sensor of the recording cannot be asked for its clock: it advances from
 * the newest packet. Before the first packet it does not answer. */
static bool answer(void *context, const uint8_t *bytes, size_t len)
{
    program *const p = context;
    lum_timestamp t;
    ring_slot *slot;

    if (!p->has_clock || lum_timestamp_decode(bytes, len, &t) != LUM_OK) {
        return true;
    }
    slot = ring_claim(&p->gateway.ring);
    if (slot == NULL) {
        return false;
    }
    t.clock_us = p->clock_us + (p->now_ms - p->clock_ms) * US_PER_MS;
    lum_timestamp_encode(slot->bytes, &t);
    slot->len = LUM_TIMESTAMP_BYTES;
    ring_commit(&p->gateway.ring);
    p->waiting++;
    return true;
}

static void note_clock(program *p, const ring_slot *slot)
{
    lum_group group;

    if (lum_packet_decode(&p->gateway.layout, slot->bytes, slot->len, &group) ==
        LUM_PACKET_DATA) {
        p->clock_us = (uint32_t)group.clock_raw;
        p->clock_ms = p->now_ms;
        p->has_clock = true;
    }
}

static void digest_line(void *context, const lum_line *line)
{
    uint64_t *const digest = &((program *)context)->lines_digest;

    mix(digest, (uint64_t)line->frame, 8);
    mix(digest, (uint64_t)line->clock_us, 8);
    mix(digest, line->number, 4);
    mix(digest, line->eye, 1);
    mix(digest, line->angle_count, 2);
    mix(digest, line->lost_words, 4);
    for (uint32_t i = 0; i < line->word_count; i++) {
        mix(digest, line->words[i], 4);
    }
}

static void digest_points(void *context, const lum_fixed_point *points,
                          size_t n)
{
    program *const p = context;

    p->projected += n;
    for (size_t i = 0; i < n; i++) {
        mix(&p->points_digest, (uint32_t)points[i].x, 4);
        mix(&p->points_digest, (uint32_t)points[i].y, 4);
        mix(&p->points_digest, (uint32_t)points[i].z, 4);
        mix(&p->points_digest, points[i].word, 4);
    }
}

static void print_frame(void *context, int64_t frame, const zone_sight *sight)
{
    program *const p = context;

    p->frames++;
    text_put(&p->out, "frame ");
    text_put_signed(&p->out, frame);
    text_put(&p->out, ": ");
    text_put_number(&p->out, sight->hits);
    text_put(&p->out, " hits");
    if (sight->hits > 0) {
        text_put(&p->out, ", the nearest at ");
        text_put_number(&p->out, zone_nearest_mm(sight));
        text_put(&p->out, " mm");
    }
    text_end(&p->out);
}

static void print_reasons(program *p)
{
    static const char *const names[GATEWAY_REASONS] = {" object", " silent",
                                                       " laser", " stalled"};
    const uint32_t reasons = gateway_reasons(&p->gateway);

    if (reasons == p->reasons) {
        return;
    }
    p->reasons = reasons;
    text_put_number(&p->out, p->now_ms);
    text_put(&p->out, reasons == 0 ? " ms: go" : " ms: stop,");
    for (unsigned i = 0; i < GATEWAY_REASONS; i++) {
        if ((reasons >> i & 1u) != 0) {
            text_put(&p->out, names[i]);
        }
    }
    text_end(&p->out);
}

/* A round of the main loop. Its output takes the place of the relay. */
static void turn(program *p)
{
    p->waiting -= gateway_receive(&p->gateway, p->now_ms);
    print_reasons(p);
    if (gateway_may_kick(&p->gateway)) {
        p->kicks++;
    }
}

static void pass_time(program *p, uint32_t ms)
{
    for (; ms > 0; ms--) {
        p->now_ms++;
        if (p->now_ms % TICK_MS == 0) {
            gateway_tick(&p->gateway, p->now_ms); /* a timer's interrupt */
            turn(p);
        }
    }
}

/* Lets time pass until a datagram's time. */
static void wait_until(program *p, int64_t time_ms)
{
    const int64_t left = time_ms - p->file_ms;

    p->file_ms = time_ms;
    if (left > 0) {
        pass_time(p, left < GAP_MS ? (uint32_t)left : GAP_MS);
    }
}

static uint64_t get_le(const uint8_t *in, unsigned bytes)
{
    uint64_t value = 0;

    for (unsigned i = 0; i < bytes; i++) {
        value |= (uint64_t)in[i] << (8u * i);
    }
    return value;
}

/* The rest of a datagram that is too long for a slot is read into the same
 * slot. */
static int fill(program *p, ring_slot *slot, uint32_t len)
{
    uint32_t left = len;

    do {
        const uint32_t part = left < RING_SLOT_BYTES ? left : RING_SLOT_BYTES;
        if (port_read(p->file, slot->bytes, part) != (long)part) {
            return -1;
        }
        left -= part;
    } while (left > 0);
    return 0;
}

/* The work of an interrupt of the network, without the waiting. */
static int receive_one(program *p, uint32_t len)
{
    ring_slot *const slot = ring_claim(&p->gateway.ring);

    if (slot == NULL || fill(p, slot, len) != 0) {
        return -1;
    }
    if (len > RING_SLOT_BYTES) {
        p->too_long++;
        return 0;
    }
    slot->len = len;
    note_clock(p, slot);
    ring_commit(&p->gateway.ring);
    p->waiting++;
    return 0;
}

/* The recording begins after the gateway has started to ask and to beat.
 * Returns 0 at the file's end, -1 if it is cut or not a flat file. */
static int run(program *p)
{
    uint8_t head[HEAD_BYTES];
    long got;
    bool begun = false;

    pass_time(p, HEART_SILENCE_MS);
    while ((got = port_read(p->file, head, sizeof head)) == HEAD_BYTES) {
        const uint32_t len = (uint32_t)get_le(head, 4);
        const int64_t time = (int64_t)get_le(head + 4, 8);
        if (!begun) {
            p->file_ms = time / NS_PER_MS;
            begun = true;
        }
        wait_until(p, time / NS_PER_MS);
        if (receive_one(p, len) != 0) {
            return -1;
        }
        if (p->waiting == RING_SLOTS) {
            turn(p);
        }
    }
    turn(p);
    gateway_finish(&p->gateway);
    return got == 0 ? 0 : -1;
}

static void print(program *p, const char *name, uint64_t value)
{
    text_put(&p->out, name);
    text_pad(&p->out, COLUMN);
    text_put_number(&p->out, value);
    text_end(&p->out);
}

static void print_digest(program *p, const char *name, uint64_t value)
{
    text_put(&p->out, name);
    text_pad(&p->out, COLUMN);
    text_put_hex(&p->out, value);
    text_end(&p->out);
}

static void report(program *p)
{
    const gateway *const g = &p->gateway;
    const lum_assembly_counters *const c =
        lum_assembler_counters(&g->assembler);

    print(p, "data", g->kinds[LUM_PACKET_DATA]);
    print(p, "tlv", g->kinds[LUM_PACKET_TLV]);
    print(p, "malformed", g->kinds[LUM_PACKET_MALFORMED]);
    print(p, "too long", p->too_long);
    print(p, "dropped", ring_dropped(&g->ring));
    print(p, "lines", c->lines);
    print(p, "words", c->words);
    print(p, "no_room", c->no_room);
    print(p, "words projected", p->projected);
    print(p, "no_angle", g->losses.no_angle);
    print(p, "no_range", g->losses.no_range);
    print(p, "frames", p->frames);
    print(p, "old packets", g->old_packets);
    print(p, "old lines", g->old_lines);
    print(p, "heartbeats", g->heart.sent);
    print(p, "watchdog kicked", p->kicks);
    print_digest(p, "digest of lines", p->lines_digest);
    print_digest(p, "digest of points", p->points_digest);
}

/* The way in front of a vehicle: 12 m long and 3 m wide, and near the vehicle
 * at most 30 degrees to either side. */
static bool begin(program *p)
{
    const gateway_config config = {
        .zone = {.min = {MM(1000), MM(-1500), MM(-1000)},
                 .max = {MM(12000), MM(1500), MM(1000)},
                 .range = MM(12000),
                 .left = 37837, /* tan 30 degrees */
                 .right = -37837},
        .hits = 10,
        .lines = 64,
        .frame_ms = 500, /* two a second */
        .hold_ms = HOLD_MS,
        .silence_ms = 600,
        .eyes = 1u << LUM_EYE_BLUE | 1u << LUM_EYE_GREEN};
    const gateway_output output = {.context = p,
                                   .send = answer,
                                   .line = digest_line,
                                   .points = digest_points,
                                   .frame = print_frame};
    lum_calibration calibration;
    lum_layout layout;

    p->lines_digest = UINT64_C(0xcbf29ce484222325);
    p->points_digest = p->lines_digest;
    lum_calibration_default(&calibration);
    lum_layout_default(&layout);
    return gateway_init(&p->gateway, &config, &output, &calibration, &layout,
                        p->now_ms) == LUM_OK;
}

static int fail(program *p, const char *why)
{
    text_put(&p->out, "gateway: ");
    text_put(&p->out, why);
    text_end(&p->out);
    return 1;
}

int main(int argc, char **argv)
{
    static program program_;
    program *const p = &program_;

    if (argc != 2) {
        return fail(p, "one argument is wanted: a file that flatten made");
    }
    p->file = port_open(argv[1]);
    if (p->file < 0) {
        return fail(p, "the file cannot be opened");
    }
    if (!begin(p)) {
        return fail(p, "a value of the configuration is out of range");
    }
    print_reasons(p);
    if (run(p) != 0) {
        return fail(p, "the file is cut, or no flat file");
    }
    report(p);
    return 0;
}
