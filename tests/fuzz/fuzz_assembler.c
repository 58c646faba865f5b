/* Any sequence of packets, against small limits. */
#include "lum/assembler.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define CONFIG_BYTES  6u
#define PACKET_BYTES  8u
#define PACKETS_MAX   300u
#define SAMPLES_MAX   32u
#define FRAME_OFFSET  4096
#define FRAME_NUMBERS 8192u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct run {
    lum_assembler assembler;
    lum_assembler_config config;
    lum_layout layout;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
    uint32_t clock;
    uint64_t pushed;
    uint64_t accepted;
    uint64_t lines;
    uint64_t words_out;
    uint64_t lost_out;
    uint64_t frames;
    int64_t last_frame;
    int has_frame;
    uint8_t seen[FRAME_NUMBERS];
};

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static void configure(struct run *run, const uint8_t *b)
{
    static const uint8_t clock_bytes[] = {4, 4, 2, 1, 0, 4, 4, 4};
    static const uint32_t gaps[] = {100000, 0, 50, 1000, 100000, 5000};
    lum_layout_default(&run->layout);
    run->layout.profile.group[LUM_FIELD_TIMESTAMP].bytes =
        clock_bytes[b[0] % 8u];
    run->layout.profile.line_span_us = b[1] < 128 ? 2000u : b[1];
    run->config = (lum_assembler_config){
        .open_lines = (uint8_t)(1u + b[2] % LUM_OPEN_LINES_MAX),
        .reorder_lines = (uint8_t)(1u + b[3] % LUM_REORDER_MAX),
        .words_per_line = 1u + b[4],
        .gap_us = gaps[b[5] % 6u],
    };
}

static int begin(struct run *run)
{
    const lum_assembler_config *c = &run->config;
    lum_assembler_storage s = {
        .slot_count = LUM_ASSEMBLER_SLOTS(c->open_lines),
        .word_count = LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line),
        .reach_count = LUM_ASSEMBLER_REACH(c->reorder_lines)};
    s.slots = run->slots = malloc(s.slot_count * sizeof *s.slots);
    s.words = run->words = malloc(s.word_count * sizeof *s.words);
    s.reach = run->reach = malloc(s.reach_count * sizeof *s.reach);
    if (s.slots == NULL || s.words == NULL || s.reach == NULL) {
        return 0;
    }
    memset(s.slots, 0xa5, s.slot_count * sizeof *s.slots);
    memset(s.words, 0xa5, s.word_count * sizeof *s.words);
    memset(s.reach, 0xa5, s.reach_count * sizeof *s.reach);
    require(lum_assembler_init(&run->assembler, c, &run->layout, &s) == LUM_OK);
    return 1;
}

static void check_angles(const lum_line *line)
{
    unsigned marked = 0;
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        if (lum_line_has_angles(line, pixel)) {
            marked++;
        } else {
            require(line->angles[pixel].azimuth == 0 &&
                    line->angles[pixel].elevation == 0);
        }
    }
    require(marked == line->angle_count);
    require(line->angle_marks[LUM_PIXEL_MARK_WORDS - 1u] >>
                (LUM_LINE_PIXELS % 32u) ==
            0);
}

static void check_words(const struct run *run, const lum_line *line)
{
    require(line->word_count <= run->config.words_per_line);
    require(line->lost_words <= run->config.words_per_line);
    for (uint32_t i = 0; i < line->word_count; i++) {
        require(lum_word_is_good(line->words[i]));
        require(i == 0 || lum_word_pixel(line->words[i - 1u]) <=
                              lum_word_pixel(line->words[i]));
    }
}

static void check_line(struct run *run, const lum_line *line)
{
    require(line->eye < LUM_EYES);
    require(line->arrival >= 0 && (uint64_t)line->arrival < run->pushed);
    check_angles(line);
    check_words(run, line);
    run->lines++;
    run->words_out += line->word_count;
    run->lost_out += line->lost_words;
    require(line->frame > -FRAME_OFFSET && line->frame < FRAME_OFFSET);
    uint8_t *seen = &run->seen[line->frame + FRAME_OFFSET];
    run->frames += *seen == 0 ? 1u : 0u;
    *seen = 1;
}

static void check_frame(struct run *run, int64_t frame)
{
    require(!run->has_frame || frame > run->last_frame);
    run->has_frame = 1;
    run->last_frame = frame;
}

static void check_event(struct run *run, lum_result r)
{
    require(r == LUM_LINE_READY || r == LUM_FRAME_READY);
    if (r == LUM_LINE_READY) {
        check_line(run, lum_assembler_line(&run->assembler));
    } else {
        check_frame(run, lum_assembler_frame(&run->assembler));
    }
}

static void check_counters(const struct run *run)
{
    const lum_assembly_counters *c = lum_assembler_counters(&run->assembler);
    require(run->pushed == run->accepted + c->stray + c->late + c->duplicate +
                               c->conflict + c->no_room);
    require(c->lines == run->lines);
    require(c->words == run->words_out);
    require(c->lost_words == run->lost_out);
    /* between, numbers whose lines are still open may be counted ahead */
    require(c->frames >= run->frames);
    require(c->lines_missing_angles <= c->lines);
}

static void push(struct run *run, const lum_group *g)
{
    const uint64_t most = run->pushed + run->config.open_lines + 4u;
    const int64_t arrival = (int64_t)run->pushed;
    uint64_t rounds = 0;
    lum_result r = LUM_OK;
    run->pushed++;
    while ((r = lum_assembler_push(&run->assembler, g, arrival)) > 0) {
        require(++rounds <= most);
        check_event(run, r);
    }
    run->accepted += r == LUM_OK ? 1u : 0u;
    require(r == LUM_OK || (r <= LUM_E_STRAY && r >= LUM_E_NO_ROOM));
    check_counters(run);
}

/* Samples of which neighbours are alike, as in a line; some are not. */
static void make_samples(const uint8_t *b, uint32_t n, uint8_t *samples)
{
    uint32_t pixel = (uint32_t)(b[3] | (b[4] << 8)) % 1100u;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t word = ((uint32_t)b[5] * 7919u * (i + 1u)) << 12 |
                              ((b[6] >> (i % 8u)) & 1u ? LUM_WORD_RISING : 0u) |
                              (b[7] % 29u == i ? (uint32_t)LUM_WORD_ZERO : 0u) |
                              (pixel & LUM_WORD_PIXEL);
        lum_word_encode(word, samples + (size_t)LUM_SAMPLE_BYTES * i);
        pixel += b[6] % 3u;
        pixel ^= b[7] % 31u == i ? 5u : 0u;
    }
}

static uint32_t step_of(uint8_t b)
{
    static const uint32_t steps[] = {
        0,    0,     0,      100,    500,     1999,     2000, 2001,
        5000, 99999, 100000, 100001, 1000000, 1u << 31, 50,   10};
    const uint32_t step = steps[b % 16u];
    return b & 0x80u ? 0u - step : step;
}

static void push_packet(struct run *run, const uint8_t *b)
{
    uint8_t samples[SAMPLES_MAX * LUM_SAMPLE_BYTES];
    const uint32_t n = 1u + (b[0] >> 2) % SAMPLES_MAX;
    const uint32_t first = (uint32_t)(b[3] | (b[4] << 8));
    lum_group g = {.samples = samples,
                   .line = b[1] == 255 ? 0xffffffffu : b[1] % 80u,
                   .num_samples = n,
                   .first_sample_index = first,
                   .eye = b[0] & 1u,
                   .tag = b[0] & 2u ? LUM_TAG_ANGLES : LUM_TAG_RANGES};
    if (g.tag == LUM_TAG_ANGLES) {
        g.first_sample_index = first % (LUM_LINE_PIXELS + 1u - n);
    }
    make_samples(b, n, samples);
    run->clock += step_of(b[2]);
    g.clock_raw = run->clock;
    push(run, &g);
}

static void finish(struct run *run)
{
    const uint64_t most = run->pushed + 2u * run->config.open_lines + 4u;
    uint64_t rounds = 0;
    lum_result r = LUM_OK;
    while ((r = lum_assembler_flush(&run->assembler)) > 0) {
        require(++rounds <= most);
        check_event(run, r);
    }
    require(r == LUM_OK);
    check_counters(run);
    const lum_assembly_counters *c = lum_assembler_counters(&run->assembler);
    require(run->accepted == 0 || c->lines > 0);
    require((c->frames > 0) == run->has_frame);
    require(c->frames == run->frames);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < CONFIG_BYTES) {
        return 0;
    }
    struct run *run = calloc(1, sizeof *run);
    if (run == NULL) {
        return 0;
    }
    configure(run, data);
    if (begin(run)) {
        data += CONFIG_BYTES;
        size -= CONFIG_BYTES;
        while (size >= PACKET_BYTES && run->pushed < PACKETS_MAX) {
            push_packet(run, data);
            data += PACKET_BYTES;
            size -= PACKET_BYTES;
        }
        finish(run);
    }
    free(run->slots);
    free(run->words);
    free(run->reach);
    free(run);
    return 0;
}
