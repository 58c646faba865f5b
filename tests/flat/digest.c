/* digest FLAT_FILE...: everything that the core makes of the datagrams, as
 * counts and 64-bit digests. Every target prints the same text, boards too, so
 * files and text go through examples/firmware/port. */
#include "lum/assembler.h"
#include "lum/packet.h"
#include "lum/points_fixed.h"
#include "lum/returns.h"

#include "port/port.h"
#include "port/text.h"

#include <string.h>

#define OPEN_LINES     4u
#define REORDER_LINES  8u
#define WORDS_PER_LINE 16384u
#define DATAGRAM_MAX   65535u
#define BLOCK          100u
#define NAME_COLUMNS   21u

typedef struct state {
    lum_layout layout;
    lum_assembler assembler;
    lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
    uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_PER_LINE)];
    lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
    lum_return returns[WORDS_PER_LINE];
    uint8_t datagram[DATAGRAM_MAX];
    uint64_t kinds[LUM_PACKET_KINDS];
    uint64_t digest;
    lum_fixed_projector projector;
    lum_fixed_point block[BLOCK];
    lum_point_losses losses;
    uint64_t points;
    uint64_t points_digest;
} state;

/* FNV-1a over the value's bytes, lowest first. */
static void add(uint64_t *digest, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        *digest ^= (value >> (8u * i)) & 0xffu;
        *digest *= UINT64_C(0x100000001b3);
    }
}

static void mix(state *s, uint64_t value, unsigned bytes)
{
    add(&s->digest, value, bytes);
}

static void mix_angles(state *s, const lum_line *line)
{
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        mix(s, lum_line_has_angles(line, p) ? 1u : 0u, 1);
        mix(s, (uint16_t)line->angles[p].azimuth, 2);
        mix(s, (uint16_t)line->angles[p].elevation, 2);
    }
}

static void mix_words(state *s, const lum_line *line)
{
    lum_returns_compute(line->words, line->word_count, s->returns);
    for (uint32_t i = 0; i < line->word_count; i++) {
        mix(s, line->words[i], 4);
        mix(s, s->returns[i].number, 2);
        mix(s, s->returns[i].count, 2);
        mix(s, s->returns[i].width_tof, 4);
    }
}

static void mix_point(state *s, const lum_fixed_point *point)
{
    add(&s->points_digest, (uint32_t)point->x, 4);
    add(&s->points_digest, (uint32_t)point->y, 4);
    add(&s->points_digest, (uint32_t)point->z, 4);
    add(&s->points_digest, point->word, 4);
}

static void mix_points(state *s, const lum_line *line)
{
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        const size_t n = lum_points_fixed_compute(&s->projector, line, i, BLOCK,
                                                  s->block, &s->losses);
        s->points += n;
        for (size_t k = 0; k < n; k++) {
            mix_point(s, &s->block[k]);
        }
    }
}

static void mix_line(state *s, const lum_line *line)
{
    mix(s, (uint64_t)line->frame, 8);
    mix(s, (uint64_t)line->clock_us, 8);
    mix(s, (uint64_t)line->arrival, 8);
    mix(s, line->number, 4);
    mix(s, line->word_count, 4);
    mix(s, line->lost_words, 4);
    mix(s, line->angle_count, 2);
    mix(s, line->eye, 1);
    mix_angles(s, line);
    mix_words(s, line);
    mix_points(s, line);
}

static void take_event(state *s, lum_result event)
{
    switch (event) {
    case LUM_LINE_READY:
        mix_line(s, lum_assembler_line(&s->assembler));
        break;
    case LUM_FRAME_READY:
        mix(s, (uint64_t)lum_assembler_frame(&s->assembler), 8);
        break;
    case LUM_OK:
    case LUM_END:
    case LUM_E_SHORT:
    case LUM_E_SPACE:
    case LUM_E_VALUE:
    case LUM_E_FOREIGN:
    case LUM_E_TYPE:
    case LUM_E_MALFORMED:
    case LUM_E_UNKNOWN_TAG:
    case LUM_E_STRAY:
    case LUM_E_LATE:
    case LUM_E_DUPLICATE:
    case LUM_E_CONFLICT:
    case LUM_E_NO_ROOM:
    case LUM_E_ORDER:
    default: /* no event */
        break;
    }
}

static void take_datagram(state *s, size_t len, int64_t time_ns)
{
    lum_group group;
    lum_result r;
    const lum_packet_kind kind =
        lum_packet_decode(&s->layout, s->datagram, len, &group);

    s->kinds[kind]++;
    if (kind != LUM_PACKET_DATA) {
        return;
    }
    while ((r = lum_assembler_push(&s->assembler, &group, time_ns)) > 0) {
        take_event(s, r);
    }
    mix(s, (uint64_t)(-(int)r), 1);
}

static uint64_t get_le(const uint8_t *in, unsigned bytes)
{
    uint64_t value = 0;

    for (unsigned i = 0; i < bytes; i++) {
        value |= (uint64_t)in[i] << (8u * i);
    }
    return value;
}

/* Reads one datagram: 1, 0 at the end, -1 for a file that is no flat file. */
static int next(state *s, int in, size_t *len, int64_t *time_ns)
{
    uint8_t head[12];
    const long got = port_read(in, head, sizeof head);

    if (got != (long)sizeof head) {
        return got == 0 ? 0 : -1;
    }
    *len = (size_t)get_le(head, 4);
    *time_ns = (int64_t)get_le(head + 4, 8);
    if (*len > DATAGRAM_MAX || port_read(in, s->datagram, *len) != (long)*len) {
        return -1;
    }
    return 1;
}

static int digest_file(state *s, int in)
{
    lum_result r;
    int64_t time_ns = 0;
    size_t len = 0;
    int more;

    while ((more = next(s, in, &len, &time_ns)) > 0) {
        take_datagram(s, len, time_ns);
    }
    while ((r = lum_assembler_flush(&s->assembler)) > 0) {
        take_event(s, r);
    }
    return more;
}

static void print(text *out, const char *name, uint64_t value)
{
    text_put(out, name);
    text_pad(out, NAME_COLUMNS);
    text_put_number(out, value);
    text_end(out);
}

static void print_digest(text *out, const char *name, uint64_t value)
{
    text_put(out, name);
    text_pad(out, NAME_COLUMNS);
    text_put_hex(out, value);
    text_end(out);
}

static void report(const state *s)
{
    const lum_assembly_counters *c = lum_assembler_counters(&s->assembler);
    text out = {.len = 0};

    for (unsigned kind = 0; kind < LUM_PACKET_KINDS; kind++) {
        text_put(&out, "kind ");
        text_put_number(&out, kind);
        print(&out, "", s->kinds[kind]);
    }
    print(&out, "late", c->late);
    print(&out, "duplicate", c->duplicate);
    print(&out, "conflict", c->conflict);
    print(&out, "no_room", c->no_room);
    print(&out, "stray", c->stray);
    print(&out, "bad_words", c->bad_words);
    print(&out, "lines", c->lines);
    print(&out, "lines_missing_angles", c->lines_missing_angles);
    print(&out, "lines_skipped", c->lines_skipped);
    print(&out, "words", c->words);
    print(&out, "lost_words", c->lost_words);
    print(&out, "frames", c->frames);
    print(&out, "no_angle", s->losses.no_angle);
    print(&out, "no_range", s->losses.no_range);
    print(&out, "points", s->points);
    print_digest(&out, "digest", s->digest);
    print_digest(&out, "digest of points", s->points_digest);
}

static bool begin(state *s)
{
    lum_assembler_config config;
    lum_calibration calibration;

    s->digest = UINT64_C(0xcbf29ce484222325);
    s->points_digest = s->digest;
    lum_layout_default(&s->layout);
    lum_calibration_default(&calibration);
    calibration.eye[LUM_EYE_GREEN].azimuth_center_udeg = 100000000;
    calibration.eye[LUM_EYE_GREEN].tof_offset_fs = -1234567;
    calibration.eye[LUM_EYE_GREEN].mount_um[1] = -123456;
    calibration.eye[LUM_EYE_GREEN].mount_roll_udeg = 1500000;
    calibration.eye[LUM_EYE_GREEN].mount_pitch_udeg = -2500000;
    lum_assembler_config_default(&config);
    config.open_lines = OPEN_LINES;
    config.reorder_lines = REORDER_LINES;
    config.words_per_line = WORDS_PER_LINE;
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(s->slots, s->words, s->reach);
    return lum_fixed_projector_init(&s->projector, &calibration, &s->layout) ==
               LUM_OK &&
           lum_assembler_init(&s->assembler, &config, &s->layout, &storage) ==
               LUM_OK;
}

static int fail(const char *file, const char *why)
{
    text out = {.len = 0};

    text_put(&out, "digest: ");
    text_put(&out, file);
    text_put(&out, why);
    text_end(&out);
    return 1;
}

static int digest_path(state *s, const char *path)
{
    text out = {.len = 0};
    const int in = port_open(path);

    if (in < 0) {
        return fail(path, " cannot be opened");
    }
    memset(s, 0, sizeof *s);
    if (!begin(s)) {
        return fail("", "a constant of its own is out of range");
    }
    if (digest_file(s, in) != 0) {
        return fail(path, " is cut or no flat file");
    }
    text_put(&out, path);
    text_end(&out);
    report(s);
    return 0;
}

int main(int argc, char **argv)
{
    static state all;

    if (argc < 2) {
        return fail("", "usage: digest FLAT_FILE..., files made by flatten");
    }
    for (int i = 1; i < argc; i++) {
        if (digest_path(&all, argv[i]) != 0) {
            return 1;
        }
    }
    return 0;
}
