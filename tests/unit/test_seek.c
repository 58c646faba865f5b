#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/demux_state.h"
#include "drive.h"
#include "frame/framer_state.h"
#include "frame/index.h"

#include "lum/assembler.h"
#include "lum/frame/reader.h"
#include "lum/group.h"
#include "lum/host/keys.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINES      20u
#define FRAMES     26u
#define FRAMES_MAX 8192u
#define SENSORS    2u
#define INTERFACES 4u
#define SEEKS      100u
#define OTHER      (DRIVE_SENSOR + 1u)
#define STRAY      (DRIVE_SENSOR + 9u)
#define FURTHER    0u
#define START_NS   INT64_C(1700000000000000000)

/* What docs/reader.md promises of an index. */
#define INDEX_BYTES_MAX (4u * 1024u * 1024u)

/* Small frames of each sensor, for an index that exceeds it several times. */
#define SMALL_FRAMES 2400u
#define SMALL_LINES  10u
#define SMALL_PIXELS 10u

/* With LUM_SOME those without floating point, which emulators are slow at and
 * no seek depends on. */
static uint32_t columns = LUM_COLUMNS_ALL;

/* --- Captures of all kinds --- */

enum disturbance {
    LOST = 1,
    REPEATED = 2,
    DISORDERED = 4,
    DAMAGED = 8,    /* line numbers and clocks */
    FRAGMENTS = 16, /* of one datagram in ten */
    LATE = 32,      /* by many lines */
    RAGGED = 64,    /* the last lines of a frame lack angles */
    JOINED = 128,   /* datagrams of one length, as far as possible */
    PAUSES = 256    /* of a sweep or so, every few sweeps */
};

/* How a capture is made. */
struct recipe {
    const char *name;
    unsigned disturbances;
    unsigned sensors;
    uint32_t clock; /* of its first line */
    bool is_pcapng; /* of several sections and interfaces */
    bool has_stray; /* a sensor of one packet */
    bool one_stops; /* the second sensor, halfway */
    bool shares;    /* the second has the first's address, and an interface */
    uint32_t batch_lines; /* each interface in turn writes so many */
    uint32_t late_lines;  /* each sensor comes again, so much later, on an
                             interface of its own */
    uint32_t second_from; /* the second sensor's first line */
    bool is_cut;          /* within a record */
};

static const struct recipe recipes[] = {
    {.name = "plain", .sensors = 1, .clock = 1000},
    {.name = "a wrap of the clock", .sensors = 1, .clock = 0xfffc0000u},
    {.name = "loss",
     .disturbances = LOST | REPEATED | DAMAGED,
     .sensors = 1,
     .clock = 5000},
    {.name = "disorder",
     .disturbances = LOST | DISORDERED | REPEATED,
     .sensors = 1,
     .clock = 0xffff0000u},
    {.name = "late",
     .disturbances = LOST | LATE | DISORDERED,
     .sensors = 1,
     .clock = 10},
    {.name = "pauses",
     .disturbances = LOST | PAUSES,
     .sensors = 1,
     .clock = 0xfffc0000u},
    {.name = "ragged", .disturbances = RAGGED, .sensors = 1, .clock = 10},
    {.name = "two sensors",
     .disturbances = LOST | DISORDERED | REPEATED | DAMAGED,
     .sensors = 2,
     .clock = 9000,
     .has_stray = true},
    {.name = "one stops",
     .disturbances = LOST,
     .sensors = 2,
     .clock = 9000,
     .one_stops = true},
    {.name = "pcapng",
     .disturbances = LOST | DISORDERED,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true},
    {.name = "fragments",
     .disturbances = LOST | FRAGMENTS,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true},
    {.name = "one address",
     .disturbances = LOST | DISORDERED,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true},
    {.name = "batches of one address",
     .disturbances = LOST,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .batch_lines = 250},
    {.name = "batches longer than what is remembered",
     .disturbances = LOST,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .batch_lines = 450},
    {.name = "batches from the middle on",
     .disturbances = LOST,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .batch_lines = 180,
     .second_from = 200},
    {.name = "a late mirror",
     .disturbances = LOST,
     .sensors = 1,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .late_lines = 200},
    {.name = "late mirrors of both",
     .disturbances = LOST,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .late_lines = 150},
    {.name = "batches and mirrors of both",
     .disturbances = LOST | REPEATED,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true,
     .shares = true,
     .batch_lines = 250,
     .late_lines = 1},
    {.name = "cut", .disturbances = LOST, .sensors = 1, .is_cut = true},
    {.name = "joined", .disturbances = JOINED, .sensors = 1, .clock = 10},
    {.name = "joined by chance",
     .disturbances = JOINED | LOST | DISORDERED,
     .sensors = 2,
     .clock = 7000,
     .is_pcapng = true},
};

#define RECIPES (sizeof recipes / sizeof recipes[0])

/* A datagram on its way. */
struct sent {
    uint64_t sort;
    int64_t time_ns;
    uint32_t sensor;
    uint32_t interface; /* where recipes share an address */
    size_t len;
    uint8_t bytes[DRIVE_BYTES];
};

struct bytes {
    uint8_t *at;
    size_t len;
    size_t room;
};

static uint64_t seed;

static uint32_t random_below(uint32_t n)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(seed >> 33) % n;
}

static void put(struct bytes *b, const void *from, size_t len)
{
    if (b->len + len > b->room) {
        b->room = 2u * (b->len + len);
        b->at = realloc(b->at, b->room);
        assert_non_null(b->at);
    }
    if (len > 0) {
        memcpy(b->at + b->len, from, len);
    }
    b->len += len;
}

static void put_le(struct bytes *b, uint64_t value, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        const uint8_t byte = (uint8_t)(value >> (8u * i) & 0xffu);
        put(b, &byte, 1);
    }
}

static void put_be(struct bytes *b, uint64_t value, size_t len)
{
    for (size_t i = len; i-- > 0;) {
        const uint8_t byte = (uint8_t)(value >> (8u * i) & 0xffu);
        put(b, &byte, 1);
    }
}

/* An IPv4 packet of some bytes of datagrams, UDP header included. */
static void put_ipv4(struct bytes *b, const struct sent *s, size_t count,
                     uint16_t id, size_t from, size_t len, bool more)
{
    struct bytes udp = {NULL, 0, 0};
    put_be(&udp, 5517, 2);
    put_be(&udp, 50000, 2);
    put_be(&udp, 8u + (count - 1u) * s->len + s[count - 1u].len, 2);
    put_be(&udp, 0, 2);
    for (size_t i = 0; i < count; i++) {
        put(&udp, s[i].bytes, s[i].len);
    }
    put_be(b, 0x4500, 2);
    put_be(b, 20u + len, 2);
    put_be(b, id, 2);
    put_be(b, (more ? 0x2000u : 0u) | from / 8u, 2);
    put_be(b, 0x4011, 2);
    put_be(b, 0, 2);
    put_be(b, s->sensor, 4);
    put_be(b, DRIVE_CLIENT, 4);
    put(b, udp.at + from, len);
    free(udp.at);
}

static void put_section(struct bytes *b)
{
    put_le(b, 0x0a0d0d0a, 4);
    put_le(b, 28, 4);
    put_le(b, 0x1a2b3c4d, 4);
    put_le(b, 1, 4);
    put_le(b, UINT64_MAX, 8);
    put_le(b, 28, 4);
}

/* Raw IPv4, in microseconds or nanoseconds. */
static void put_interface(struct bytes *b, unsigned exponent)
{
    put_le(b, 1, 4);
    put_le(b, 32, 4);
    put_le(b, 228, 4);
    put_le(b, 0, 4);
    put_le(b, 0x00010009, 4);
    put_le(b, exponent, 4);
    put_le(b, 0, 4);
    put_le(b, 32, 4);
}

static void put_record(struct bytes *b, const struct recipe *recipe,
                       const struct sent *sent, const struct bytes *packet,
                       size_t number)
{
    const int64_t time_ns = sent->time_ns;
    if (!recipe->is_pcapng) {
        put_le(b, (uint64_t)time_ns / 1000000000u, 4);
        put_le(b, (uint64_t)time_ns % 1000000000u, 4);
        put_le(b, packet->len, 4);
        put_le(b, packet->len, 4);
        put(b, packet->at, packet->len);
        return;
    }
    if (number % 700u == 0) {
        put_section(b);
        put_interface(b, number % 1400u == 0 ? 6 : 9);
    }
    for (unsigned i = 1; i < INTERFACES; i++) {
        if (number % 700u == (recipe->shares ? 0u : 300u)) {
            put_interface(b, 9);
        }
    }
    const bool is_second = number % 700u > 400u && number % 2u == 0;
    const uint32_t interface = recipe->shares ? sent->interface : is_second;
    const bool is_us = interface == 0 && number / 700u % 2u == 0;
    const uint64_t ticks =
        is_us ? (uint64_t)time_ns / 1000u : (uint64_t)time_ns;
    const size_t padding = (4u - packet->len % 4u) % 4u;
    const size_t all = 32u + packet->len + padding;
    put_le(b, 6, 4);
    put_le(b, all, 4);
    put_le(b, interface, 4);
    put_le(b, ticks >> 32, 4);
    put_le(b, ticks & UINT32_MAX, 4);
    put_le(b, packet->len, 4);
    put_le(b, packet->len, 4);
    put(b, packet->at, packet->len);
    put_le(b, 0, padding);
    put_le(b, all, 4);
}

static int by_sort(const void *a, const void *b)
{
    const struct sent *p = a;
    const struct sent *q = b;
    return (p->sort > q->sort) - (p->sort < q->sort);
}

static bool happens(const struct recipe *recipe, unsigned what, uint32_t in)
{
    return (recipe->disturbances & what) != 0 && random_below(in) == 0;
}

/* A packet at its turn, or not. */
static void disturb(const struct recipe *recipe, struct sent *s)
{
    if (happens(recipe, DISORDERED, 10)) {
        s->sort += random_below(600);
    }
    if (happens(recipe, LATE, 25)) {
        s->sort += random_below(5000);
    }
    if (happens(recipe, DAMAGED, 60)) {
        s->bytes[8u + random_below(20)] ^= (uint8_t)(1u << random_below(8));
    }
}

/* None, one or two of each packet of a line. */
static size_t send_line(const struct recipe *recipe,
                        const struct drive_line *line, size_t first,
                        struct sent of, struct sent *out)
{
    size_t count = 0;
    for (size_t p = first; p < line->count; p++) {
        const unsigned lost = happens(recipe, LOST, 40) ? 1u : 0u;
        const unsigned times = happens(recipe, REPEATED, 30) ? 2u : 1u;
        for (unsigned n = lost; n < times; n++) {
            struct sent *s = &out[count++];
            *s = of;
            s->sort += 10u * p;
            s->time_ns += random_below(300000);
            s->len = line->len[p];
            memcpy(s->bytes, line->bytes[p], s->len);
            disturb(recipe, s);
        }
    }
    return count;
}

/* Angles lack in one frame, and whole lines in the next; or in pauses. */
static bool lacks(const struct recipe *recipe, uint32_t i)
{
    return (recipe->disturbances & RAGGED) != 0 && i / LINES % 2u != 0 &&
           i % LINES >= 13u;
}

static bool is_left_out(const struct recipe *recipe, uint32_t i)
{
    return ((recipe->disturbances & RAGGED) != 0 && i / LINES % 2u == 0 &&
            i % LINES >= 10u) ||
           ((recipe->disturbances & PAUSES) != 0 &&
            i % (3u * LINES + 7u) < LINES - 2u);
}

static bool is_off(const struct recipe *recipe, uint32_t sensor, uint32_t i)
{
    return sensor == 1 && (i < recipe->second_from ||
                           (recipe->one_stops && i > FRAMES * LINES / 2u));
}

/* All again on interfaces of their own, later. */
static size_t mirror(const struct recipe *recipe, struct sent *all,
                     size_t count, uint64_t turns)
{
    const uint64_t late = turns / (FRAMES * LINES) * recipe->late_lines;
    for (size_t i = 0; i < count; i++) {
        all[count + i] = all[i];
        all[count + i].sort += late;
        all[count + i].time_ns += 1000000 * (int64_t)recipe->late_lines;
        all[count + i].interface += 2u;
    }
    return 2u * count;
}

/* The interfaces write in turn. */
static void put_in_batches(const struct recipe *recipe, struct sent *all,
                           size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const int64_t batch_ns = 1000000 * (int64_t)recipe->batch_lines;
        const uint64_t batch =
            (uint64_t)((all[i].time_ns - START_NS) / batch_ns);
        all[i].sort += (INTERFACES * batch + all[i].interface) << 32;
    }
}

/* The datagrams of a drive, disturbed. */
static struct sent *send_all(const struct recipe *recipe, size_t *count)
{
    static struct drive_line line;
    struct sent *all = calloc(FRAMES * LINES * SENSORS * 2u * 16u, sizeof *all);
    uint64_t turn = 0;
    assert_non_null(all);
    *count = 0;
    for (uint32_t i = 0; i < FRAMES * LINES; i++) {
        for (unsigned k = 0; k < 2u * recipe->sensors; k++) {
            const uint32_t sensor = k / 2u;
            const struct sent of = {.sort = turn,
                                    .time_ns = START_NS + 1000000 * (int64_t)i,
                                    .sensor = DRIVE_SENSOR +
                                              (recipe->shares ? 0 : sensor),
                                    .interface = sensor};
            drive_pixels(&line, k % 2u, (i + 7u * sensor) % LINES,
                         recipe->clock + 1000u * i + 17u * sensor,
                         10u * (i % 50u), 60u + i % 7u);
            turn += 10u * line.count;
            const bool is_gone =
                is_off(recipe, sensor, i) || is_left_out(recipe, i);
            *count += is_gone
                          ? 0
                          : send_line(recipe, &line, lacks(recipe, i) ? 1u : 0u,
                                      of, all + *count);
        }
    }
    if (recipe->late_lines != 0) {
        *count = mirror(recipe, all, *count, turn);
    }
    if (recipe->batch_lines != 0) {
        put_in_batches(recipe, all, *count);
    }
    qsort(all, *count, sizeof *all, by_sort);
    return all;
}

static void put_header(struct bytes *out)
{
    put_le(out, 0xa1b23c4d, 4);
    put_le(out, 0x00040002, 4);
    put_le(out, 0, 8);
    put_le(out, 65535, 4);
    put_le(out, 228, 4);
}

/* Which of the datagrams one record holds. The longest of a kernel would end
 * only with this capture's frames. */
static size_t count_joined(const struct recipe *recipe, const struct sent *s,
                           size_t left)
{
    size_t n = 1;
    while ((recipe->disturbances & JOINED) != 0 && n < left && n < 13u &&
           s[n].sensor == s->sensor && s[n].len <= s->len &&
           s[n - 1u].len == s->len) {
        n++;
    }
    return n;
}

static void make_capture(const struct recipe *recipe, struct bytes *out)
{
    size_t count = 0;
    size_t number = 0;
    seed = 7;
    struct sent *all = send_all(recipe, &count);
    *out = (struct bytes){NULL, 0, 0};
    if (recipe->has_stray) {
        all[1].sensor = STRAY;
    }
    if (!recipe->is_pcapng) {
        put_header(out);
    }
    for (size_t i = 0, n = 0; i < count; i += n) {
        n = count_joined(recipe, all + i, count - i);
        const size_t udp = (n - 1u) * all[i].len + all[i + n - 1u].len + 8u;
        const bool is_parted = (recipe->disturbances & FRAGMENTS) != 0 &&
                               i % 10u == 0 && udp > 800u;
        const size_t first = is_parted ? 800u : udp;
        struct bytes packet = {NULL, 0, 0};
        put_ipv4(&packet, &all[i], n, (uint16_t)i, 0, first, is_parted);
        put_record(out, recipe, &all[i], &packet, number++);
        packet.len = 0;
        /* the rest comes some packets later */
        const size_t back = i >= 5u ? i - 5u : count;
        if ((recipe->disturbances & FRAGMENTS) != 0 && back % 10u == 0 &&
            back < count && all[back].len + 8u > 800u) {
            put_ipv4(&packet, &all[back], 1, (uint16_t)back, 800u,
                     all[back].len + 8u - 800u, false);
            put_record(out, recipe, &all[i], &packet, number++);
        }
        free(packet.at);
    }
    free(all);
    out->len -= recipe->is_cut ? 100u : 0u;
}

/* --- What a frame is --- */

struct digest {
    uint64_t sum;
    uint32_t sensor;
    int64_t number;
    int64_t begin_ns;
    uint64_t lines_late;
};

static void add(uint64_t *sum, const void *bytes, size_t len)
{
    const uint8_t *at = bytes;
    for (size_t i = 0; i < len; i++) {
        *sum = (*sum ^ at[i]) * UINT64_C(1099511628211);
    }
}

static void add_number(uint64_t *sum, uint64_t value)
{
    add(sum, &value, sizeof value);
}

/* All of its info but for struct_size, whatever is between members. */
static void add_info(uint64_t *sum, const lum_frame_info *i)
{
    const uint64_t numbers[] = {(uint64_t)i->number,
                                i->sensor,
                                i->is_complete,
                                i->is_first,
                                i->is_last,
                                (uint64_t)i->times.begin_clock_us,
                                (uint64_t)i->times.end_clock_us,
                                (uint64_t)i->times.begin_arrival_ns,
                                (uint64_t)i->times.end_arrival_ns,
                                i->points,
                                i->lines[0],
                                i->lines[1],
                                i->lines_missing[0],
                                i->lines_missing[1],
                                i->lines_missing_angles,
                                i->lost_words,
                                i->losses.no_angle,
                                i->losses.no_range,
                                i->points_cut,
                                i->lines_cut,
                                i->lines_late,
                                (uint64_t)i->times.begin_utc_ns,
                                (uint64_t)i->times.utc_error_ns,
                                i->lines_in_pauses,
                                i->has_pause};
    add(sum, numbers, sizeof numbers);
}

static void add_lines(uint64_t *sum, const lum_frame *frame)
{
    lum_frame_line l = {.struct_size = sizeof l};
    for (size_t i = 0; i < lum_frame_line_count(frame); i++) {
        assert_true(lum_frame_get_line(frame, i, &l));
        const uint64_t numbers[] = {(uint64_t)l.clock_us,
                                    (uint64_t)l.arrival_ns,
                                    l.number,
                                    l.first_point,
                                    l.point_count,
                                    l.lost_words,
                                    l.angle_count,
                                    l.eye};
        add(sum, numbers, sizeof numbers);
    }
}

static struct digest digest_of(const lum_frame *frame)
{
    static const size_t sizes[] = {[LUM_TYPE_FLOAT] = 4,
                                   [LUM_TYPE_UINT32] = 4,
                                   [LUM_TYPE_UINT16] = 2,
                                   [LUM_TYPE_UINT8] = 1};
    lum_frame_info info = {.struct_size = sizeof info};
    struct digest d = {.sum = UINT64_C(14695981039346656037)};
    assert_int_equal(lum_frame_get_info(frame, &info), LUM_OK);
    add_info(&d.sum, &info);
    add(&d.sum, info.sensor_interface, sizeof info.sensor_interface);
    add_lines(&d.sum, frame);
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        const void *values = lum_frame_column(frame, (lum_column)c);
        if (values != NULL) {
            add(&d.sum, values,
                lum_frame_count(frame) *
                    sizes[lum_column_get_type((lum_column)c)]);
        }
    }
    add_number(&d.sum, lum_frame_count(frame));
    /* which no seek by number asks for */
    d.sensor = info.sensor_interface[0] != '\0' ? FURTHER : info.sensor;
    d.number = info.number;
    d.lines_late = info.lines_late;
    d.begin_ns =
        info.lines[0] + info.lines[1] > 0 ? info.times.begin_utc_ns : INT64_MIN;
    return d;
}

/* --- Readings --- */

static struct digest frames[FRAMES_MAX];
static size_t frame_count;

static lum_reader *open_reader(lum_reader_options options, const void *bytes,
                               size_t len)
{
    lum_view view;
    lum_reader *reader = NULL;
    lum_error error = {""};
    lum_view_default(&view);
    view.columns = columns;
    const lum_framer_options framer = {
        .struct_size = sizeof framer, .views = &view, .view_count = 1};
    options.struct_size = sizeof options;
    options.framer = options.framer != NULL ? options.framer : &framer;
    options.source = bytes != NULL ? lum_source_from_memory("drive", bytes, len)
                                   : options.source;
    if (lum_reader_open(&options, &reader, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return reader;
}

static lum_reader *open_bytes(const struct bytes *b)
{
    return open_reader((lum_reader_options){.keeps_index = true}, b->at,
                       b->len);
}

/* All frames of a reading from the start. */
static void read_all(const struct bytes *b)
{
    const lum_frame *frame = NULL;
    lum_reader *reader =
        open_reader((lum_reader_options){.keeps_index = false}, b->at, b->len);
    frame_count = 0;
    while (lum_reader_next_frame(reader, &frame, NULL) > 0) {
        assert_true(frame_count < FRAMES_MAX);
        frames[frame_count++] = digest_of(frame);
    }
    lum_reader_close(reader);
    assert_true(frame_count >= FRAMES - 9u);
}

static lum_reader_index index_of(const lum_reader *reader)
{
    lum_reader_index index = {.struct_size = sizeof index};
    assert_int_equal(lum_reader_get_index(reader, &index), LUM_OK);
    return index;
}

/* The next frames are those of the reading from the start. */
static void assert_frames(lum_reader *reader, size_t from, size_t count)
{
    const lum_frame *frame = NULL;
    for (size_t i = from; i < from + count && i < frame_count; i++) {
        lum_error error = {""};
        if (lum_reader_next_frame(reader, &frame, &error) != 1) {
            fail_msg("frame %zu of %zu does not come: %s", i, frame_count,
                     error.text);
        }
        const struct digest d = digest_of(frame);
        if (d.sum != frames[i].sum) {
            lum_frame_info info = {.struct_size = sizeof info};
            (void)lum_frame_get_info(frame, &info);
            fail_msg("frame %zu, number %lld of %08x instead of %lld of %08x, "
                     "differs",
                     i, (long long)d.number, d.sensor,
                     (long long)frames[i].number, frames[i].sensor);
        }
        assert_int_equal(index_of(reader).next, i + 1u);
    }
}

static void assert_end(lum_reader *reader, bool is_cut)
{
    const lum_frame *frame = NULL;
    lum_error error = {""};
    assert_int_equal(lum_reader_next_frame(reader, &frame, &error),
                     is_cut ? -1 : 0);
}

static size_t find_number(uint32_t sensor, int64_t number)
{
    size_t i = 0;
    while (i < frame_count &&
           (frames[i].sensor != sensor || frames[i].number < number)) {
        i++;
    }
    return i;
}

static size_t find_time(int64_t time_ns)
{
    size_t i = 0;
    while (i < frame_count && frames[i].begin_ns < time_ns) {
        i++;
    }
    return i;
}

/* One seek of any kind, and some frames. */
static void seek_somewhere(lum_reader *reader, bool is_cut)
{
    const size_t any = random_below((uint32_t)frame_count);
    const uint32_t sensor = frames[any].sensor;
    lum_error error = {""};
    size_t to = any;
    int status = 0;
    switch (sensor != FURTHER ? random_below(4) : 2u) {
    case 0: {
        const int64_t number = frames[any].number + (int64_t)random_below(2);
        status = lum_reader_seek_number(reader, sensor, number, &error);
        to = find_number(sensor, number);
        break;
    }
    case 1: {
        const int64_t time_ns =
            frames[any].begin_ns == INT64_MIN
                ? START_NS
                : frames[any].begin_ns + (int64_t)random_below(3) - 1;
        status = lum_reader_seek_time(reader, time_ns, &error);
        to = find_time(time_ns);
        break;
    }
    default:
        status = lum_reader_seek_frame(reader, any, &error);
        break;
    }
    if (status != 0) {
        fail_msg("%s", error.text);
    }
    assert_frames(reader, to, 1u + random_below(4));
    if (to == frame_count) {
        assert_end(reader, is_cut);
    }
}

static bool has_further(void)
{
    bool has_any = false;
    for (size_t i = 0; i < frame_count; i++) {
        has_any |= frames[i].sensor == FURTHER;
    }
    return has_any;
}

/* --- Facts --- */

static void a_sought_frame_is_that_of_a_reading_from_the_start(void **state)
{
    (void)state;
    for (size_t i = 0; i < RECIPES; i++) {
        struct bytes b;
        make_capture(&recipes[i], &b);
        print_message("%s: %zu bytes\n", recipes[i].name, b.len);
        read_all(&b);
        lum_reader *reader = open_bytes(&b);
        assert_frames(reader, 0, frame_count);
        assert_end(reader, recipes[i].is_cut);
        assert_true(index_of(reader).is_whole);
        assert_int_equal(index_of(reader).frames, frame_count);
        assert_int_equal(has_further(),
                         recipes[i].shares && recipes[i].sensors == 2);
        const bool has_few =
            recipes[i].one_stops ||
            recipes[i].batch_lines + recipes[i].late_lines != 0;
        assert_true(index_of(reader).entries + 6u >=
                    (has_few ? frame_count / 2u : frame_count));
        seed = 1000 + i;
        for (unsigned k = 0; k < SEEKS; k++) {
            seek_somewhere(reader, recipes[i].is_cut);
        }
        assert_int_equal(lum_reader_seek_frame(reader, 3, NULL), 0);
        assert_frames(reader, 3, frame_count);
        assert_end(reader, recipes[i].is_cut);
        assert_int_equal(index_of(reader).frames, frame_count);
        lum_reader_close(reader);
        free(b.at);
    }
}

/* The index grows by what a seek passes over. */
static void seeks_before_a_reading_are_right_too(void **state)
{
    (void)state;
    for (size_t i = 0; i < RECIPES; i++) {
        struct bytes b;
        make_capture(&recipes[i], &b);
        read_all(&b);
        for (unsigned turn = 0; turn < 4; turn++) {
            lum_reader *reader = open_bytes(&b);
            seed = 99u * i + turn;
            for (unsigned k = 0; k < 12; k++) {
                seek_somewhere(reader, recipes[i].is_cut);
            }
            lum_reader_close(reader);
        }
        free(b.at);
    }
}

static void without_an_index_a_seek_reads_from_the_start(void **state)
{
    (void)state;
    struct bytes b;
    make_capture(&recipes[6], &b);
    read_all(&b);
    lum_reader *reader =
        open_reader((lum_reader_options){.keeps_index = false}, b.at, b.len);
    seed = 5;
    for (unsigned k = 0; k < 6; k++) {
        seek_somewhere(reader, false);
        assert_int_equal(index_of(reader).entries, 0);
    }
    lum_reader_close(reader);
    free(b.at);
}

static void a_frame_that_is_not_there_is_the_end(void **state)
{
    (void)state;
    struct bytes b;
    make_capture(&recipes[0], &b);
    read_all(&b);
    for (unsigned turn = 0; turn < 2; turn++) {
        lum_reader *reader = open_bytes(&b);
        if (turn == 1) {
            assert_frames(reader, 0, frame_count);
            assert_end(reader, false);
        }
        assert_int_equal(lum_reader_seek_frame(reader, frame_count, NULL), 0);
        assert_end(reader, false);
        assert_end(reader, false);
        assert_int_equal(lum_reader_seek_frame(reader, 4, NULL), 0);
        assert_frames(reader, 4, 2);
        assert_int_equal(lum_reader_seek_time(reader, INT64_MAX, NULL), 0);
        assert_end(reader, false);
        assert_int_equal(lum_reader_seek_number(reader, STRAY, 1, NULL), 0);
        assert_end(reader, false);
        assert_int_equal(lum_reader_seek_frame(reader, 1, NULL), 0);
        assert_frames(reader, 1, frame_count);
        lum_reader_close(reader);
    }
    free(b.at);
}

/* --- Files --- */

static char directory[] = "/tmp/lum-seek-XXXXXX";
static char drive[64];
static char index_path[96];

static void write_file(const char *path, const void *bytes, size_t len)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, len, file), len);
    assert_int_equal(fclose(file), 0);
}

static struct bytes read_file(const char *path)
{
    struct bytes b = {NULL, 0, 0};
    char buffer[4096];
    size_t got = 0;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    while ((got = fread(buffer, 1, sizeof buffer, file)) > 0) {
        put(&b, buffer, got);
    }
    assert_int_equal(fclose(file), 0);
    return b;
}

static int make_directory(void **state)
{
    (void)state;
    assert_non_null(mkdtemp(directory));
    (void)snprintf(drive, sizeof drive, "%s/drive.pcap", directory);
    (void)snprintf(index_path, sizeof index_path, "%s.lumindex", drive);
    return 0;
}

static int remove_directory(void **state)
{
    (void)state;
    (void)remove(drive);
    (void)remove(index_path);
    return rmdir(directory);
}

static lum_reader *open_file(void)
{
    return open_reader((lum_reader_options){.path = drive, .keeps_index = true},
                       NULL, 0);
}

/* A capture, all its frames, and its index in a file. */
static void make_file(const struct recipe *recipe)
{
    struct bytes b;
    make_capture(recipe, &b);
    write_file(drive, b.at, b.len);
    read_all(&b);
    free(b.at);
    lum_reader *reader = open_file();
    lum_error error = {""};
    assert_frames(reader, 0, frame_count);
    assert_end(reader, recipe->is_cut);
    if (lum_reader_save_index(reader, NULL, &error) != 0) {
        fail_msg("%s", error.text);
    }
    lum_reader_close(reader);
}

static void an_index_can_be_kept_beside_the_capture(void **state)
{
    (void)state;
    for (size_t i = 0; i < RECIPES; i++) {
        make_file(&recipes[i]);
        lum_reader *reader = open_file();
        lum_error error = {""};
        if (lum_reader_load_index(reader, NULL, &error) != 1) {
            fail_msg("%s", error.text);
        }
        assert_true(index_of(reader).is_whole);
        assert_int_equal(index_of(reader).frames, frame_count);
        assert_true(index_of(reader).entries > 5u);
        assert_true(index_of(reader).bytes > 5000u);
        const uint64_t entries = index_of(reader).entries;
        seed = i;
        for (unsigned k = 0; k < SEEKS / 4u; k++) {
            seek_somewhere(reader, recipes[i].is_cut);
        }
        assert_int_equal(index_of(reader).entries, entries);
        lum_reader_close(reader);
    }
}

/* The index says how far a seek has to read. */
static void a_seek_reads_little_of_a_long_capture(void **state)
{
    (void)state;
    uint64_t done = 0;
    uint64_t total = 0;
    make_file(&recipes[0]);
    for (unsigned stray = 0; stray < 2; stray++) {
        if (stray == 1) {
            struct recipe recipe = recipes[0];
            recipe.has_stray = true;
            make_file(&recipe);
        }
        lum_reader *reader = open_file();
        assert_int_equal(lum_reader_load_index(reader, NULL, NULL), 1);
        assert_int_equal(lum_reader_seek_frame(reader, frame_count - 3u, NULL),
                         0);
        assert_frames(reader, frame_count - 3u, 1);
        assert_int_equal(lum_reader_seek_frame(reader, 5, NULL), 0);
        assert_frames(reader, 5, 1);
        lum_reader_progress(reader, &done, &total);
        assert_true(done < total / 2u);
        lum_reader_close(reader);
    }
}

static void assert_not_used(const char *says)
{
    lum_error error = {""};
    lum_reader *reader = open_file();
    assert_int_equal(lum_reader_load_index(reader, NULL, &error), -1);
    assert_non_null(strstr(error.text, "drive.pcap.lumindex: is not used: "));
    if (strstr(error.text, says) == NULL) {
        fail_msg("\"%s\" instead of \"%s\"", error.text, says);
    }
    assert_int_equal(lum_reader_seek_frame(reader, 3, NULL), 0);
    assert_frames(reader, 3, 2);
    lum_reader_close(reader);
}

static void an_index_that_does_not_fit_is_not_used(void **state)
{
    (void)state;
    make_file(&recipes[0]);
    struct bytes index = read_file(index_path);
    struct bytes capture = read_file(drive);
    for (size_t at = 0; at < index.len; at += at < 40u ? 1u : index.len / 97u) {
        index.at[at] ^= 0x10u;
        write_file(index_path, index.at, index.len);
        assert_not_used(at < 8u ? "it is not an index" : "");
        index.at[at] ^= 0x10u;
    }
    for (size_t len = 0; len < index.len; len += 1u + index.len / 31u) {
        write_file(index_path, index.at, len);
        assert_not_used(len < 14u ? "it is not an index"
                                  : "damaged or cut short");
    }
    index.at[8] = 1;
    write_file(index_path, index.at, index.len);
    assert_not_used("its format is 1; 3 can be read");
    index.at[8] = 3;
    write_file(index_path, index.at, index.len);
    capture.at[capture.len - 5u] ^= 1u;
    write_file(drive, capture.at, capture.len);
    read_all(&capture);
    assert_not_used("it is of another capture, or the capture has changed");
    write_file(drive, capture.at, capture.len - 3u);
    capture.len -= 3u;
    read_all(&capture);
    assert_not_used("it is of another capture, or the capture has changed");
    free(index.at);
    free(capture.at);
}

/* Whether the index serves a reading with these options. */
static bool has_index(const lum_framer_options *options)
{
    lum_error error = {""};
    lum_reader *reader = open_reader((lum_reader_options){.path = drive,
                                                          .framer = options,
                                                          .keeps_index = true},
                                     NULL, 0);
    const int loaded = lum_reader_load_index(reader, NULL, &error);
    assert_true(loaded == 1 ||
                strstr(error.text, "it was made with other options") != NULL);
    lum_reader_close(reader);
    return loaded == 1;
}

static void other_options_need_another_index(void **state)
{
    (void)state;
    make_file(&recipes[0]);
    const lum_framer_options framers[] = {
        {.struct_size = sizeof framers[0], .eyes = LUM_EYES_BLUE},
        {.struct_size = sizeof framers[0], .drop_incomplete = true},
        {.struct_size = sizeof framers[0], .only_first = true},
        {.struct_size = sizeof framers[0],
         .has_sensor = true,
         .sensor = DRIVE_SENSOR},
        {.struct_size = sizeof framers[0], .has_range = true, .frame_last = 9}};
    for (size_t i = 0; i < sizeof framers / sizeof framers[0]; i++) {
        assert_false(has_index(&framers[i]));
    }
    /* points are none of them */
    lum_view view;
    lum_view_default(&view);
    const lum_framer_options other = {.struct_size = sizeof other,
                                      .views = &view,
                                      .view_count = 1,
                                      .points_max = 1000};
    assert_true(has_index(&other));
}

/* What an index of these options is known by. */
static struct bytes key_of(const lum_framer_options *options)
{
    lum_framer *framer = NULL;
    lum_pack pack = {.written = NULL};
    assert_int_equal(lum_framer_new(options, &framer, NULL), 0);
    lum_framer_pack_options(framer, &pack);
    lum_framer_free(framer);
    assert_false(pack.has_failed);
    return (struct bytes){.at = pack.written, .len = pack.len};
}

static bool have_one_key(const lum_framer_options *a,
                         const lum_framer_options *b)
{
    const struct bytes of_a = key_of(a);
    const struct bytes of_b = key_of(b);
    const bool are_equal =
        of_a.len == of_b.len && memcmp(of_a.at, of_b.at, of_a.len) == 0;
    free(of_a.at);
    free(of_b.at);
    return are_equal;
}

static void each_option_needs_another_index(void **state)
{
    (void)state;
    lum_assembler_config configs[4];
    for (size_t i = 0; i < 4; i++) {
        lum_assembler_config_default(&configs[i]);
    }
    configs[0].open_lines++;
    configs[1].reorder_lines++;
    configs[2].words_per_line--;
    configs[3].gap_us++;
    lum_framer_options each[] = {{.eyes = LUM_EYES_BLUE},
                                 {.eyes = LUM_EYES_GREEN},
                                 {.eyes = LUM_EYES_BOTH},
                                 {.only_first = true},
                                 {.drop_incomplete = true},
                                 {.has_sensor = true, .sensor = 1},
                                 {.has_sensor = true, .sensor = 2},
                                 {.has_range = true},
                                 {.has_range = true, .frame_first = 1},
                                 {.has_range = true, .frame_last = 1},
                                 {.port = 5518},
                                 {.port = 5519},
                                 {.has_sensor = true, .sensor_interface = "a"},
                                 {.has_sensor = true, .sensor_interface = "b"},
                                 {.config = &configs[0]},
                                 {.config = &configs[1]},
                                 {.config = &configs[2]},
                                 {.config = &configs[3]}};
    for (size_t i = 0; i < sizeof each / sizeof each[0]; i++) {
        each[i].struct_size = sizeof each[i];
        for (size_t k = 0; k < i; k++) {
            assert_false(have_one_key(&each[i], &each[k]));
        }
    }
}

/* A layout whose fields have room on both sides. */
static lum_profile make_roomy(void)
{
    lum_profile profile;
    lum_profile_default(&profile);
    for (unsigned i = 0; i < LUM_GROUP_FIELDS; i++) {
        profile.group[i].at = (uint8_t)(12u + 8u * i);
    }
    profile.samples_at = 63;
    return profile;
}

static bool sets(const char *name, const char *value, lum_layout *out)
{
    lum_keys keys;
    lum_profile profile = make_roomy();
    char before[LUM_KEY_VALUE_BYTES];
    char after[LUM_KEY_VALUE_BYTES];
    lum_keys_of_profile(&keys, &profile);
    return lum_keys_get(&keys, name, before) == LUM_OK &&
           lum_keys_set(&keys, name, value, 1, NULL) == LUM_OK &&
           lum_keys_get(&keys, name, after) == LUM_OK &&
           strcmp(before, after) != 0 &&
           lum_keys_profile(&keys, &profile, NULL) == LUM_OK &&
           lum_layout_init(out, &profile, NULL, NULL) == LUM_OK;
}

/* A layout that differs from the roomy one in this key alone. */
static bool vary(const lum_key *key, lum_layout *out)
{
    bool is_found = sets(key->name, "[0, 4]", out);
    for (unsigned i = 0; !is_found && key->words[i] != NULL; i++) {
        is_found = sets(key->name, key->words[i], out);
    }
    for (unsigned i = 1; !is_found && i < 100; i++) {
        char value[LUM_KEY_VALUE_BYTES];
        (void)snprintf(value, sizeof value, "%u", i);
        is_found = sets(key->name, value, out);
    }
    return is_found;
}

/* What is of no account for which packets make which lines. */
static bool is_of_no_account(const char *key)
{
    return strncmp(key, "tlv.", 4) == 0 || strncmp(key, "set_ip", 6) == 0 ||
           strcmp(key, "angle_lsb_deg") == 0;
}

static void each_key_of_a_profile_needs_another_index(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key key;
    lum_layout roomy;
    lum_layout layout;
    size_t i = 0;
    const lum_profile profile = make_roomy();
    const lum_framer_options plain = {.struct_size = sizeof plain,
                                      .layout = &roomy};
    const lum_framer_options other = {.struct_size = sizeof other,
                                      .layout = &layout};
    assert_int_equal(lum_layout_init(&roomy, &profile, NULL, NULL), LUM_OK);
    lum_keys_of_profile(&keys, &profile);
    for (; lum_keys_describe(&keys, i, &key) == LUM_OK; i++) {
        const bool has_one_value = strcmp(key.name, "version") == 0;
        if (vary(&key, &layout) == has_one_value) {
            fail_msg("no other value is known for %s", key.name);
        }
        if (!has_one_value &&
            have_one_key(&plain, &other) != is_of_no_account(key.name)) {
            fail_msg("the index does not go by %s", key.name);
        }
        if (key.kind == LUM_KEY_WORD_OR_PAIR) { /* whose two numbers count */
            lum_layout shifted;
            lum_framer_options third = other;
            third.layout = &shifted;
            assert_true(sets(key.name, "[0, 4]", &layout));
            assert_true(sets(key.name, "[1, 5]", &shifted));
            assert_false(have_one_key(&third, &other));
        }
    }
    assert_true(i > 20);
}

static void what_has_no_index_says_so(void **state)
{
    (void)state;
    lum_error error = {""};
    struct bytes b;
    make_capture(&recipes[0], &b);
    lum_reader *reader = open_bytes(&b);
    assert_int_equal(lum_reader_save_index(reader, index_path, &error), -1);
    assert_string_equal(error.text, "only one capture file that is not "
                                    "compressed has an index");
    lum_reader_close(reader);
    write_file(drive, b.at, b.len);
    (void)remove(index_path);
    reader = open_reader((lum_reader_options){.path = drive}, NULL, 0);
    assert_int_equal(lum_reader_load_index(reader, NULL, &error), -1);
    assert_string_equal(
        error.text,
        "this reader keeps no index; set lum_reader_options.keeps_index");
    lum_reader_close(reader);
    reader = open_file();
    assert_int_equal(lum_reader_load_index(reader, NULL, &error), 0);
    lum_reader_close(reader);
    free(b.at);
}

/* Files that follow one another are opened again. */
static void several_captures_are_sought_from_the_start(void **state)
{
    (void)state;
    struct bytes b;
    char second[80];
    (void)snprintf(second, sizeof second, "%s/second.pcap", directory);
    make_capture(&recipes[0], &b);
    size_t half = 24; /* a record's begin */
    while (half < b.len / 2u) {
        half += 16u + (size_t)b.at[half + 8u] + 256u * b.at[half + 9u];
    }
    struct bytes rest = {NULL, 0, 0};
    put(&rest, b.at, 24);
    put(&rest, b.at + half, b.len - half);
    write_file(drive, b.at, half);
    write_file(second, rest.at, rest.len);
    read_all(&b);
    const char *const paths[] = {drive, second};
    lum_reader *reader = open_reader((lum_reader_options){.paths = paths,
                                                          .path_count = 2,
                                                          .keeps_index = true},
                                     NULL, 0);
    seed = 3;
    for (unsigned k = 0; k < 8; k++) {
        seek_somewhere(reader, false);
    }
    assert_false(index_of(reader).is_kept);
    lum_reader_close(reader);
    assert_int_equal(remove(second), 0);
    free(b.at);
    free(rest.at);
}

/* --- What an entry has to know --- */

/* A capture that is made line by line. */
struct script {
    struct bytes bytes;
    size_t records;
    uint32_t clock; /* of the latest line */
};

static void begin_script(struct script *s)
{
    *s = (struct script){.clock = 5000};
    put_header(&s->bytes);
}

static void send_packets(struct script *s, const struct drive_line *line,
                         size_t count, uint32_t sensor, uint32_t clock)
{
    static struct sent of;
    for (size_t p = 0; p < count; p++) {
        struct bytes packet = {NULL, 0, 0};
        of.sensor = sensor;
        of.len = line->len[p];
        memcpy(of.bytes, line->bytes[p], of.len);
        put_ipv4(&packet, &of, 1, 0, 0, of.len + 8u, false);
        of.time_ns = START_NS + 1000 * (int64_t)clock;
        put_record(&s->bytes, &recipes[0], &of, &packet, s->records++);
        free(packet.at);
    }
}

/* The first packets of a line. */
static void send(struct script *s, unsigned eye, uint32_t line, uint32_t clock,
                 size_t packets)
{
    static struct drive_line of;
    drive_pixels(&of, eye, line, clock, 10u * (line % 50u), 60u + line % 7u);
    send_packets(s, &of, packets < of.count ? packets : of.count, DRIVE_SENSOR,
                 clock);
}

/* Whole lines of both eyes, a millisecond each. */
static void send_lines(struct script *s, uint32_t from, uint32_t to)
{
    for (uint32_t line = from; line < to; line++) {
        s->clock += 1000u;
        send(s, LUM_EYE_BLUE, line, s->clock, DRIVE_PACKETS);
        send(s, LUM_EYE_GREEN, line, s->clock, DRIVE_PACKETS);
    }
}

static uint64_t count_late(void)
{
    uint64_t late = 0;
    for (size_t i = 0; i < frame_count; i++) {
        late += frames[i].lines_late;
    }
    return late;
}

/* Each frame by its own entry; the script is freed. */
static void assert_sought(struct script *s)
{
    read_all(&s->bytes);
    lum_reader *reader = open_bytes(&s->bytes);
    assert_frames(reader, 0, frame_count);
    assert_end(reader, false);
    assert_true(index_of(reader).entries + 6u >= frame_count);
    for (size_t i = frame_count; i-- > 0;) {
        assert_int_equal(lum_reader_seek_frame(reader, i, NULL), 0);
        assert_frames(reader, i, 2);
    }
    lum_reader_close(reader);
    free(s->bytes.at);
}

/* The last line of a frame comes behind the first of the next one. */
static void a_line_that_was_overtaken_is_of_its_frame(void **state)
{
    (void)state;
    struct script s;
    begin_script(&s);
    for (uint32_t i = 0; i < FRAMES; i++) {
        send_lines(&s, 1, LINES - 1u);
        const uint32_t clock = s.clock;
        s.clock += 1000u;
        send_lines(&s, 0, 1);
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            send(&s, eye, LINES - 1u, clock + 1000u, DRIVE_PACKETS);
        }
    }
    assert_sought(&s);
}

/* Line 12 is near the first of its frame, and near the last of the one before,
 * and is none of that. */
static void a_frame_that_lacks_its_begin_is_one_frame(void **state)
{
    (void)state;
    struct script s;
    begin_script(&s);
    for (uint32_t i = 0; i < FRAMES; i++) {
        s.clock += 5000u;
        send_lines(&s, 5, 6);
        s.clock += 6000u;
        send_lines(&s, 12, LINES);
    }
    assert_sought(&s);
}

/* Blue has decided a reach of lines of its next frame, and green is silent:
 * the frame ends at once, and what green sends then is late. */
static void lines_are_late_behind_the_same_line(void **state)
{
    (void)state;
    struct script s;
    uint32_t green = 0; /* its line's clock */
    begin_script(&s);
    for (uint32_t i = 0; i < FRAMES; i++) {
        for (uint32_t line = 0; line < LINES; line++) {
            s.clock += 10000u;
            send(&s, LUM_EYE_BLUE, line, s.clock, DRIVE_PACKETS);
            for (uint32_t late = 11; i > 0 && line == 7u && late < LINES;
                 late++) {
                green += 10000u;
                send(&s, LUM_EYE_GREEN, late, green, DRIVE_PACKETS);
            }
            if (line >= 8u && line <= 10u) {
                green = s.clock;
                send(&s, LUM_EYE_GREEN, line, green, DRIVE_PACKETS);
            }
        }
    }
    read_all(&s.bytes);
    assert_true(count_late() >= FRAMES - 1u);
    assert_sought(&s);
}

/* The clock jumps in both eyes, and the frame ends. Lines of a single packet
 * belong to it, until one of more packets begins the next: they are late. */
static void late_lines_before_a_frame_are_told_by_it(void **state)
{
    (void)state;
    struct script s;
    begin_script(&s);
    for (uint32_t i = 0; i < FRAMES; i++) {
        for (uint32_t line = 0; i > 0 && line < 6u; line++) {
            s.clock += line > 0 ? 1000u : 1000000u;
            send(&s, LUM_EYE_BLUE, line, s.clock, 1);
            send(&s, LUM_EYE_GREEN, line, s.clock, 1);
        }
        send_lines(&s, 6, LINES);
    }
    read_all(&s.bytes);
    assert_true(count_late() >= FRAMES - 1u);
    assert_sought(&s);
}

/* Frames of the second sensor are three times as long, so that many come when
 * later ones have come already. */
static void a_time_that_was_passed_is_sought_before(void **state)
{
    (void)state;
    static struct drive_line line;
    struct script s;
    unsigned passed = 0;
    begin_script(&s);
    for (uint32_t i = 0; i < FRAMES * LINES; i++) {
        s.clock += 1000u;
        for (unsigned k = 0; k < 2u * SENSORS; k++) {
            const uint32_t sensor = k / 2u;
            drive_pixels(&line, k % 2u, i % (sensor == 0 ? LINES : 3u * LINES),
                         s.clock, 100, 20);
            send_packets(&s, &line, line.count, DRIVE_SENSOR + sensor, s.clock);
        }
    }
    read_all(&s.bytes);
    lum_reader *reader = open_bytes(&s.bytes);
    assert_frames(reader, 0, frame_count);
    int64_t highest_ns = frames[0].begin_ns;
    for (size_t i = 1; i < frame_count; i++) {
        for (size_t k = 0; frames[i].begin_ns < highest_ns && k < i; k++) {
            const int64_t time_ns = frames[k].begin_ns;
            assert_int_equal(lum_reader_seek_frame(reader, i, NULL), 0);
            assert_frames(reader, i, 1);
            assert_int_equal(lum_reader_seek_time(reader, time_ns, NULL), 0);
            assert_frames(reader, find_time(time_ns), 1);
            passed++;
        }
        highest_ns =
            frames[i].begin_ns > highest_ns ? frames[i].begin_ns : highest_ns;
    }
    assert_true(passed > 50u);
    lum_reader_close(reader);
    free(s.bytes.at);
}

/* --- Lines that only decide which packets are accepted --- */

#define OPEN_LINES 4u
#define REORDER    8u
#define WORDS_MAX  2200u

struct assembly {
    lum_assembler a;
    lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
    uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_MAX)];
    lum_reach reach[LUM_ASSEMBLER_REACH(REORDER)];
};

static void begin_assembly(struct assembly *s)
{
    lum_layout layout;
    const lum_assembler_config config = {.open_lines = OPEN_LINES,
                                         .reorder_lines = REORDER,
                                         .words_per_line = WORDS_MAX,
                                         .gap_us = 100000};
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(s->slots, s->words, s->reach);
    lum_layout_default(&layout);
    assert_int_equal(lum_assembler_init(&s->a, &config, &layout, &storage),
                     LUM_OK);
}

/* All that comes of a packet. */
static uint64_t push(struct assembly *s, const lum_group *group)
{
    uint64_t sum = 0;
    lum_result r = LUM_OK;
    do {
        r = lum_assembler_push(&s->a, group, 1000);
        add_number(&sum, (uint64_t)(int64_t)r);
    } while (r > 0);
    return sum;
}

/* Words with some pixels two or three times, or angles, of one of the latest
 * lines. */
static lum_group make_group(uint32_t turn, uint8_t *samples)
{
    const uint32_t at = turn / 12u + 4u - random_below(4);
    lum_group g = {.line = at % LINES,
                   .num_samples = 60u + random_below(100),
                   .first_sample_index = 100u * random_below(8),
                   .clock_raw = 5000u + 1000u * at,
                   .eye = (uint8_t)random_below(2),
                   .tag = LUM_TAG_RANGES,
                   .samples = samples};
    uint32_t pixel = g.first_sample_index + random_below(20);
    for (uint32_t i = 0; i < g.num_samples; i++) {
        lum_word_encode(lum_word_make((int32_t)random_below(9000), true, pixel),
                        samples + (size_t)LUM_SAMPLE_BYTES * i);
        pixel += random_below(4) != 0 ? 1u : 0u;
    }
    g.tag = random_below(4) == 0 ? LUM_TAG_ANGLES : LUM_TAG_RANGES;
    return g;
}

/* A packet is accepted or not as it was without the words' values. */
static void a_state_without_values_accepts_the_same(void **state)
{
    (void)state;
    static struct assembly first;
    static struct assembly second;
    static uint8_t samples[160u * LUM_SAMPLE_BYTES];
    begin_assembly(&first);
    begin_assembly(&second);
    seed = 21;
    for (uint32_t turn = 0; turn < 20000u; turn++) {
        if (turn % 24u == 0) {
            const uint32_t none = first.a.frames.highest + 2u;
            lum_pack pack = {.written = NULL};
            assert_true(lum_assembler_pack(&first.a, none, &pack));
            lum_pack read = lum_pack_of(pack.written, pack.len);
            begin_assembly(&second);
            assert_true(lum_assembler_pack(&second.a, none, &read));
            assert_ptr_equal(read.at, read.end);
            lum_pack_reset(&pack);
        }
        const lum_group group = make_group(turn, samples);
        const uint64_t sum = push(&first, &group);
        assert_int_equal(push(&second, &group), sum);
    }
    assert_true(lum_assembler_counters(&first.a)->duplicate > 100u);
    assert_true(lum_assembler_counters(&first.a)->conflict > 100u);
}

/* --- Many frames --- */

/* A packet of a small line: angles, or words. */
static void make_small(struct drive_line *out, const lum_group *group)
{
    lum_layout layout;
    size_t head = 0;
    uint8_t *bytes = out->bytes[out->count];
    lum_layout_default(&layout);
    assert_int_equal(
        lum_group_encode(&layout, group, bytes, DRIVE_BYTES, &head), LUM_OK);
    for (uint32_t i = 0; i < group->num_samples; i++) {
        uint8_t *to = bytes + head + (size_t)LUM_SAMPLE_BYTES * i;
        const uint32_t pixel = SMALL_PIXELS * group->line + i;
        const lum_angle angle = {(int16_t)(50 * (int32_t)pixel),
                                 (int16_t)(100 * (int32_t)group->line)};
        if (group->tag == LUM_TAG_ANGLES) {
            lum_angle_encode(&layout, angle, to);
        } else {
            lum_word_encode(
                lum_word_make(2000 + (int32_t)random_below(9000), true, pixel),
                to);
        }
    }
    out->len[out->count++] =
        head + (size_t)LUM_SAMPLE_BYTES * group->num_samples;
}

/* Now and then a packet is lost. */
static void send_small(struct script *s, uint32_t sensor, unsigned eye,
                       uint32_t line)
{
    static struct drive_line of;
    lum_group group = {.line = line,
                       .num_samples = SMALL_PIXELS,
                       .first_sample_index = SMALL_PIXELS * line,
                       .clock_raw = s->clock,
                       .eye = (uint8_t)eye,
                       .tag = LUM_TAG_ANGLES};
    of.count = 0;
    if (random_below(50) != 0) {
        make_small(&of, &group);
    }
    group.first_sample_index = 0; /* a range group counts its words */
    group.tag = LUM_TAG_RANGES;
    if (random_below(50) != 0) {
        make_small(&of, &group);
    }
    send_packets(s, &of, of.count, DRIVE_SENSOR + sensor, s->clock);
}

static void make_small_frames(struct script *s)
{
    begin_script(s);
    seed = 11;
    for (uint32_t i = 0; i < SMALL_FRAMES * SMALL_LINES; i++) {
        s->clock += 12000u;
        for (unsigned k = 0; k < 2u * SENSORS; k++) {
            const uint32_t at = i + 3u * (k / 2u);
            send_small(s, k / 2u, k % 2u, at % SMALL_LINES * 5u);
        }
    }
}

/* Every frame is read, and the index stays within its bound. Returns how often
 * it became smaller. */
static unsigned assert_bound(lum_reader *reader)
{
    unsigned count = 0;
    uint64_t before = 0;
    for (size_t i = 0; i < frame_count; i++) {
        assert_frames(reader, i, 1);
        const lum_reader_index index = index_of(reader);
        assert_true(index.bytes <= INDEX_BYTES_MAX);
        count += index.entries < before ? 1u : 0u;
        before = index.entries;
    }
    return count;
}

static void an_index_that_becomes_too_large_is_thinned(void **state)
{
    (void)state;
    struct script s;
    make_small_frames(&s);
    write_file(drive, s.bytes.at, s.bytes.len);
    read_all(&s.bytes);
    free(s.bytes.at);
    assert_true(frame_count >= SENSORS * SMALL_FRAMES);
    lum_reader *reader = open_file();
    assert_in_range(assert_bound(reader), 3, 5);
    assert_end(reader, false);
    assert_int_equal(index_of(reader).frames, frame_count);
    /* it is not thinner than it has to be */
    assert_true(index_of(reader).bytes > INDEX_BYTES_MAX / 3u);
    assert_true(index_of(reader).entries > frame_count / 16u);
    for (unsigned k = 0; k < SEEKS; k++) {
        seek_somewhere(reader, false);
    }
    assert_int_equal(lum_reader_save_index(reader, NULL, NULL), 0);
    const uint64_t entries = index_of(reader).entries;
    lum_reader_close(reader);
    struct bytes file = read_file(index_path);
    assert_true(file.len <= INDEX_BYTES_MAX);
    free(file.at);
    reader = open_file();
    assert_int_equal(lum_reader_load_index(reader, NULL, NULL), 1);
    assert_int_equal(index_of(reader).entries, entries);
    for (unsigned k = 0; k < SEEKS / 4u; k++) {
        seek_somewhere(reader, false);
    }
    lum_reader_close(reader);
}

/* Entries so long that not each sensor can have one. */
static void the_bound_holds_for_any_entries(void **state)
{
    (void)state;
    lum_index index = {.stride = 1};
    for (uint32_t i = 0; i < 64u; i++) {
        lum_index_entry *entry = calloc(1, sizeof *entry);
        assert_non_null(entry);
        entry->sensor = i % LUM_DEMUX_SENSORS_MAX;
        entry->order = i;
        entry->state_len = INDEX_BYTES_MAX / 5u;
        entry->state = malloc(entry->state_len);
        assert_non_null(entry->state);
        lum_index_add(&index, entry);
        assert_true(index.bytes <= INDEX_BYTES_MAX);
        assert_in_range(index.count, i < 2u ? i + 1u : 3u, 4);
        assert_non_null(lum_index_of(&index, 0, i));
    }
    lum_index_clear(&index);
}

/* --- What cannot be sought --- */

struct pieces {
    const struct bytes *bytes;
    size_t at;
    unsigned seeks;
};

static int64_t read_piece(void *context, void *buffer, size_t room,
                          lum_error *error)
{
    struct pieces *p = context;
    const size_t left = p->bytes->len - p->at;
    const size_t n = left < room ? left : room;
    (void)error;
    memcpy(buffer, p->bytes->at + p->at, n);
    p->at += n;
    return (int64_t)n;
}

static int seek_piece(void *context, uint64_t offset, lum_error *error)
{
    struct pieces *p = context;
    p->at = (size_t)offset;
    p->seeks++;
    return p->seeks < 1000u ? 0 : lum_error_set(error, "it is worn out");
}

static void a_callers_function_may_seek(void **state)
{
    (void)state;
    struct bytes b;
    make_capture(&recipes[6], &b);
    read_all(&b);
    for (unsigned can = 0; can < 2; can++) {
        struct pieces pieces = {.bytes = &b};
        lum_error error = {""};
        const lum_source_functions functions = {.struct_size = sizeof functions,
                                                .read = read_piece,
                                                .seek = can != 0 ? seek_piece
                                                                 : NULL,
                                                .context = &pieces};
        lum_reader *reader = open_reader(
            (lum_reader_options){
                .source = lum_source_from_functions("pieces", &functions, NULL),
                .keeps_index = true},
            NULL, 0);
        assert_int_equal(lum_reader_seek_frame(reader, 5, NULL), 0);
        assert_frames(reader, 5, 2);
        assert_int_equal(lum_reader_seek_frame(reader, 9, NULL), 0);
        assert_frames(reader, 9, 1);
        if (can != 0) {
            for (unsigned k = 0; k < 9; k++) {
                seek_somewhere(reader, false);
            }
            pieces.seeks = 1000;
            for (unsigned k = 0; k < 2; k++) {
                assert_int_equal(lum_reader_seek_frame(reader, 2, &error), -1);
                assert_non_null(strstr(error.text, "it is worn out"));
                const lum_frame *frame = NULL;
                assert_int_equal(lum_reader_next_frame(reader, &frame, NULL),
                                 -1);
            }
        } else {
            assert_int_equal(lum_reader_seek_frame(reader, 9, &error), -1);
            assert_string_equal(error.text,
                                "pieces: cannot be read again from its start; "
                                "only later frames can be sought");
            assert_frames(reader, 10, 1);
        }
        lum_reader_close(reader);
    }
    free(b.at);
}

/* Nothing came before it, so it is ahead of a stream that cannot seek. */
static void a_first_seek_of_any_time_reads_on(void **state)
{
    static const int64_t times[] = {0, -5, INT64_MIN + 1};
    (void)state;
    struct bytes b;
    make_capture(&recipes[6], &b);
    read_all(&b);
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        struct pieces pieces = {.bytes = &b};
        const lum_source_functions functions = {.struct_size = sizeof functions,
                                                .read = read_piece,
                                                .context = &pieces};
        lum_reader *reader = open_reader(
            (lum_reader_options){.source = lum_source_from_functions(
                                     "pieces", &functions, NULL)},
            NULL, 0);
        assert_int_equal(lum_reader_seek_time(reader, times[i], NULL), 0);
        assert_frames(reader, 0, 2);
        lum_reader_close(reader);
    }
    free(b.at);
}

static int next_none(void *context, lum_record *out, lum_error *error)
{
    (void)context;
    (void)out;
    (void)error;
    return 0;
}

static bool say_no(void *context)
{
    (void)context;
    return *(const bool *)context;
}

static void what_cannot_be_sought_says_so(void **state)
{
    (void)state;
    lum_error error = {""};
    bool goes_on = true;
    struct bytes b;
    const lum_record_source records = {.struct_size = sizeof records,
                                       .next = next_none};
    const lum_framer_options lines = {.struct_size = sizeof lines,
                                      .wants = LUM_WANT_LINES};
    make_capture(&recipes[0], &b);
    lum_reader *reader =
        open_reader((lum_reader_options){.records = &records}, NULL, 0);
    assert_int_equal(lum_reader_seek_frame(reader, 0, &error), -1);
    assert_string_equal(
        error.text,
        "only a reader of captures can seek; this one was opened on records");
    lum_reader_close(reader);
    reader = open_reader((lum_reader_options){.framer = &lines}, b.at, b.len);
    assert_int_equal(lum_reader_seek_frame(reader, 0, &error), -1);
    assert_non_null(strstr(error.text, "that gives no frames cannot seek"));
    lum_reader_close(reader);
    reader = open_reader(
        (lum_reader_options){.go_on = say_no, .go_on_context = &goes_on}, b.at,
        b.len);
    assert_int_equal(lum_reader_seek_number(reader, DRIVE_SENSOR, -1, &error),
                     -1);
    assert_string_equal(error.text, "a frame's number is from 0 to 4294967295");
    lum_reader_close(reader);
    free(b.at);
}

int main(void)
{
    if (getenv("LUM_SOME") != NULL) {
        columns = LUM_COLUMN_BIT(LUM_COLUMN_LINE) |
                  LUM_COLUMN_BIT(LUM_COLUMN_PIXEL) |
                  LUM_COLUMN_BIT(LUM_COLUMN_EYE);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sought_frame_is_that_of_a_reading_from_the_start),
        cmocka_unit_test(seeks_before_a_reading_are_right_too),
        cmocka_unit_test(without_an_index_a_seek_reads_from_the_start),
        cmocka_unit_test(a_frame_that_is_not_there_is_the_end),
        cmocka_unit_test(an_index_can_be_kept_beside_the_capture),
        cmocka_unit_test(a_seek_reads_little_of_a_long_capture),
        cmocka_unit_test(an_index_that_does_not_fit_is_not_used),
        cmocka_unit_test(other_options_need_another_index),
        cmocka_unit_test(each_key_of_a_profile_needs_another_index),
        cmocka_unit_test(each_option_needs_another_index),
        cmocka_unit_test(what_has_no_index_says_so),
        cmocka_unit_test(several_captures_are_sought_from_the_start),
        cmocka_unit_test(a_line_that_was_overtaken_is_of_its_frame),
        cmocka_unit_test(a_frame_that_lacks_its_begin_is_one_frame),
        cmocka_unit_test(lines_are_late_behind_the_same_line),
        cmocka_unit_test(late_lines_before_a_frame_are_told_by_it),
        cmocka_unit_test(a_time_that_was_passed_is_sought_before),
        cmocka_unit_test(a_state_without_values_accepts_the_same),
        cmocka_unit_test(an_index_that_becomes_too_large_is_thinned),
        cmocka_unit_test(the_bound_holds_for_any_entries),
        cmocka_unit_test(a_callers_function_may_seek),
        cmocka_unit_test(a_first_seek_of_any_time_reads_on),
        cmocka_unit_test(what_cannot_be_sought_says_so),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
