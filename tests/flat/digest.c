/* digest FLAT_FILE: everything that the core makes of the datagrams, as counts
 * and one 64-bit digest. Every target prints the same text. */
#include "lum/assembler.h"
#include "lum/packet.h"
#include "lum/returns.h"

#include <stdio.h>
#include <stdlib.h>

#define OPEN_LINES     4u
#define WORDS_PER_LINE 16384u
#define DATAGRAM_MAX   65535u

typedef struct state {
    lum_layout layout;
    lum_assembler assembler;
    lum_line_slot slots[2u * OPEN_LINES];
    uint32_t words[2u * OPEN_LINES * WORDS_PER_LINE];
    lum_return returns[WORDS_PER_LINE];
    uint8_t datagram[DATAGRAM_MAX];
    uint64_t kinds[LUM_PACKET_KINDS];
    uint64_t digest;
} state;

/* FNV-1a over the value's bytes, lowest first. */
static void mix(state *s, uint64_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        s->digest ^= (value >> (8u * i)) & 0xffu;
        s->digest *= UINT64_C(0x100000001b3);
    }
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
}

static void take_event(state *s, lum_result event)
{
    if (event == LUM_LINE_READY) {
        mix_line(s, lum_assembler_line(&s->assembler));
    } else {
        mix(s, (uint64_t)lum_assembler_frame(&s->assembler), 8);
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
static int next(state *s, FILE *in, size_t *len, int64_t *time_ns)
{
    uint8_t head[12];
    const size_t got = fread(head, 1, sizeof head, in);

    if (got != sizeof head) {
        return got == 0 && !ferror(in) ? 0 : -1;
    }
    *len = (size_t)get_le(head, 4);
    *time_ns = (int64_t)get_le(head + 4, 8);
    if (*len > DATAGRAM_MAX || fread(s->datagram, 1, *len, in) != *len) {
        return -1;
    }
    return 1;
}

static int digest_file(state *s, FILE *in)
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

static void print(const char *name, uint64_t value)
{
    (void)printf("%-20s %llu\n", name, (unsigned long long)value);
}

static void report(const state *s)
{
    const lum_assembly_counters *c = lum_assembler_counters(&s->assembler);

    for (unsigned kind = 0; kind < LUM_PACKET_KINDS; kind++) {
        (void)printf("kind %u ", kind);
        print("", s->kinds[kind]);
    }
    print("late", c->late);
    print("duplicate", c->duplicate);
    print("conflict", c->conflict);
    print("no_room", c->no_room);
    print("stray", c->stray);
    print("bad_words", c->bad_words);
    print("lines", c->lines);
    print("lines_missing_angles", c->lines_missing_angles);
    print("lines_skipped", c->lines_skipped);
    print("words", c->words);
    print("lost_words", c->lost_words);
    print("frames", c->frames);
    (void)printf("%-20s %016llx\n", "digest", (unsigned long long)s->digest);
}

static bool begin(state *s)
{
    lum_assembler_config config;

    s->digest = UINT64_C(0xcbf29ce484222325);
    lum_layout_default(&s->layout);
    lum_assembler_config_default(&config);
    config.open_lines = OPEN_LINES;
    config.words_per_line = WORDS_PER_LINE;
    return lum_assembler_init(&s->assembler, &config, &s->layout, s->slots,
                              s->words) == LUM_OK;
}

int main(int argc, char **argv)
{
    state *s = calloc(1, sizeof *s);
    FILE *in = argc == 2 ? fopen(argv[1], "rb") : NULL;
    int status = EXIT_FAILURE;

    if (s == NULL || in == NULL || !begin(s)) {
        (void)fputs("usage: digest FLAT_FILE, a file made by flatten\n",
                    stderr);
    } else if (digest_file(s, in) != 0) {
        (void)fprintf(stderr, "digest: %s is cut or no flat file\n", argv[1]);
    } else {
        report(s);
        status = EXIT_SUCCESS;
    }
    if (in != NULL) {
        (void)fclose(in);
    }
    free(s);
    return status;
}
