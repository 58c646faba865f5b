/* Any sequence of calls, against limits small and large. Every input is a list
 * of calls as a careless program might make them: another packet after an
 * event, a flush or a question for idle lines at any time, groups that no
 * decoder gives. What include/lum/assembler.h promises is checked after each.
 */
#include "lum/assembler.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define CONFIG_BYTES  7u
#define CALL_BYTES    9u
#define CALLS_MAX     300u
#define SAMPLES_MAX   369u /* of a datagram of 1,500 bytes */
#define FRAME_NUMBERS 1024u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct run {
    lum_assembler assembler;
    lum_assembler before; /* as it was before a call that must not touch it */
    lum_assembler_config config;
    lum_layout layout;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
    lum_group awaited; /* where waits: of the packet that the event waits for */
    int waits;
    int is_large; /* packets of as many samples as a datagram holds */
    uint32_t clock;
    int64_t arrival; /* of the last call */
    uint64_t calls;
    uint64_t taken; /* packets that were accepted or dropped */
    uint64_t accepted;
    uint64_t refused;
    uint64_t lines;
    uint64_t idle;
    uint64_t words_out;
    uint64_t lost_out;
    uint64_t frames;    /* distinct ones of lines */
    uint64_t announced; /* as often as a frame was */
    int64_t last_frame;
    uint8_t seen[FRAME_NUMBERS];
    uint8_t samples[SAMPLES_MAX * LUM_SAMPLE_BYTES];
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
    run->is_large = (b[6] & 1u) != 0;
    run->arrival = b[6] & 2u ? -20 : INT64_MIN + 8;
    if ((b[6] & 0xf0u) == 0xf0u) { /* dear, so seldom */
        run->config.open_lines = 1;
        run->config.words_per_line = LUM_LINE_WORDS_MAX;
    } else if (run->is_large) {
        run->config.words_per_line *= 8u;
    }
}

static void require_no_begin(struct run *run)
{
    uint8_t sample[LUM_SAMPLE_BYTES] = {0};
    const lum_group g = {
        .samples = sample, .num_samples = 1, .tag = LUM_TAG_RANGES};
    require(lum_assembler_push(&run->assembler, &g, 0) == LUM_E_ORDER);
    require(lum_assembler_close_idle(&run->assembler, 0) == LUM_E_ORDER);
    require(lum_assembler_flush(&run->assembler) == LUM_E_ORDER);
    require(lum_assembler_line(&run->assembler) == NULL);
    require(lum_assembler_counters(&run->assembler)->refused == 3);
}

static void require_no_space(struct run *run, lum_assembler_storage s,
                             unsigned which)
{
    size_t *const counts[] = {&s.slot_count, &s.word_count, &s.reach_count};
    --*counts[which % 3u];
    run->before = run->assembler;
    require(lum_assembler_init(&run->assembler, &run->config, &run->layout,
                               &s) == LUM_E_SPACE);
    require(memcmp(&run->before, &run->assembler, sizeof run->before) == 0);
}

static int begin(struct run *run, unsigned which)
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
    require_no_begin(run);
    require_no_space(run, s, which);
    memset(&run->assembler, 0xa5, sizeof run->assembler);
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
    require(line->arrival <= run->arrival);
    check_angles(line);
    check_words(run, line);
    run->lines++;
    run->words_out += line->word_count;
    run->lost_out += line->lost_words;
    require(line->frame >= 0 && line->frame < (int64_t)FRAME_NUMBERS);
    uint8_t *seen = &run->seen[line->frame];
    run->frames += *seen == 0 ? 1u : 0u;
    *seen = 1;
}

static void check_event(struct run *run, lum_result r)
{
    require(r == LUM_LINE_READY || r == LUM_FRAME_READY);
    if (r == LUM_LINE_READY) {
        check_line(run, lum_assembler_line(&run->assembler));
        return;
    }
    const int64_t frame = lum_assembler_frame(&run->assembler);
    require(run->announced == 0 || frame == run->last_frame + 1);
    run->last_frame = frame;
    run->announced++;
}

static void check_counters(const struct run *run)
{
    const lum_assembly_counters *c = lum_assembler_counters(&run->assembler);
    require(run->taken == run->accepted + c->stray + c->late + c->duplicate +
                              c->conflict + c->no_room);
    require(c->refused == run->refused);
    require(c->lines == run->lines);
    require(c->lines_idle == run->idle);
    require(c->words == run->words_out);
    require(c->lost_words == run->lost_out);
    /* between, numbers whose lines are still open may be counted ahead */
    require(c->frames >= run->frames && c->frames >= run->announced);
    require(c->lines_missing_angles <= c->lines);
}

/* A call that was answered so must have touched nothing but that count. */
static void require_untouched(struct run *run, lum_result r,
                              lum_result expected)
{
    require(r == expected);
    if (r == LUM_E_ORDER) {
        run->refused++;
        run->before.counters.refused++;
    }
    require(memcmp(&run->before, &run->assembler, sizeof run->before) == 0);
}

static int is_same(const lum_group *a, const lum_group *b)
{
    return a->line == b->line && a->num_samples == b->num_samples &&
           a->first_sample_index == b->first_sample_index &&
           a->clock_raw == b->clock_raw && a->eye == b->eye && a->tag == b->tag;
}

/* One call; 0: the packet has been taken. */
static int push_once(struct run *run, const lum_group *g)
{
    if (run->waits && !is_same(&run->awaited, g)) {
        run->before = run->assembler;
        require_untouched(run,
                          lum_assembler_push(&run->assembler, g, run->arrival),
                          LUM_E_ORDER);
        return 0;
    }
    const lum_result r = lum_assembler_push(&run->assembler, g, run->arrival);
    run->waits = r > 0;
    run->awaited = *g;
    if (r > 0) {
        check_event(run, r);
        return 1;
    }
    run->taken++;
    run->accepted += r == LUM_OK ? 1u : 0u;
    require(r == LUM_OK || (r <= LUM_E_STRAY && r >= LUM_E_NO_ROOM));
    return 0;
}

/* how: 0 once, as with `if` in place of `while`; else until it is taken. */
static void push(struct run *run, const lum_group *g, unsigned how)
{
    const uint64_t most = run->calls + run->config.open_lines + 4u;
    uint64_t rounds = 0;
    while (push_once(run, g) && how != 0) {
        require(++rounds <= most);
    }
}

static void close_idle(struct run *run, int64_t before, unsigned how)
{
    uint64_t rounds = 0;
    lum_result r = LUM_OK;
    if (run->waits) {
        run->before = run->assembler;
        require_untouched(run,
                          lum_assembler_close_idle(&run->assembler, before),
                          LUM_E_ORDER);
        return;
    }
    while ((r = lum_assembler_close_idle(&run->assembler, before)) > 0) {
        require(++rounds <= 2u * run->config.open_lines);
        require(r == LUM_LINE_READY);
        check_event(run, r);
        run->idle++;
        require(lum_assembler_line(&run->assembler)->arrival < before);
        if (how == 0) {
            return;
        }
    }
    require(r == LUM_OK);
}

static void flush(struct run *run, unsigned how)
{
    const uint64_t most = run->calls + 2u * run->config.open_lines + 4u;
    uint64_t rounds = 0;
    lum_result r = LUM_OK;
    run->refused += run->waits ? 1u : 0u;
    run->waits = 0;
    while ((r = lum_assembler_flush(&run->assembler)) > 0) {
        require(++rounds <= most);
        check_event(run, r);
        if (how == 0) {
            return;
        }
    }
    require(r == LUM_OK);
    const lum_assembly_counters *c = lum_assembler_counters(&run->assembler);
    require(run->accepted == 0 || c->lines > 0);
    require(c->frames == run->frames && c->frames >= run->announced);
}

/* No packet that a decoder gives. */
static void push_nonsense(struct run *run, lum_group g, unsigned which)
{
    switch (which % 4u) {
    case 0:
        g.eye = (uint8_t)(LUM_EYES + which / 4u);
        break;
    case 1:
        g.tag = (uint8_t)(LUM_TAG_RANGES + 1u + which / 4u);
        break;
    case 2:
        g.num_samples = 0;
        break;
    default:
        g.tag = LUM_TAG_ANGLES;
        g.first_sample_index = LUM_LINE_PIXELS - g.num_samples + 1u + which;
        break;
    }
    run->before = run->assembler;
    require_untouched(run, lum_assembler_push(&run->assembler, &g, 0),
                      LUM_E_VALUE);
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

static void make_packet(struct run *run, const uint8_t *b, lum_group *g)
{
    const uint32_t small = 1u + (b[0] >> 2) % 32u;
    const uint32_t n = run->is_large && (b[0] & 0x80u) != 0
                           ? SAMPLES_MAX - 4u * (small - 1u)
                           : small;
    const uint32_t first = (uint32_t)(b[3] | (b[4] << 8));
    *g = (lum_group){.samples = run->samples,
                     .line = b[1] == 255 ? 0xffffffffu : b[1] % 80u,
                     .num_samples = n,
                     .first_sample_index = first,
                     .eye = b[0] & 1u,
                     .tag = b[0] & 2u ? LUM_TAG_ANGLES : LUM_TAG_RANGES};
    if (g->tag == LUM_TAG_ANGLES) {
        g->first_sample_index = first % (LUM_LINE_PIXELS + 1u - n);
    }
    make_samples(b, n, run->samples);
    run->clock += step_of(b[2]);
    g->clock_raw = run->clock;
}

/* b[8] tells the call: most are packets, pushed until they are taken. */
static void call(struct run *run, const uint8_t *b)
{
    lum_group g;
    run->calls++;
    run->arrival += b[8] >> 6;
    switch (b[8] % 16u) {
    case 0:
        flush(run, b[0] & 1u);
        break;
    case 1:
        close_idle(run, run->arrival - b[0] % 8u + 1, b[1] & 1u);
        break;
    case 2:
        make_packet(run, b, &g);
        push_nonsense(run, g, b[7]);
        break;
    case 3: /* what waits, with other samples */
        if (run->waits) {
            make_samples(b, run->awaited.num_samples, run->samples);
            g = run->awaited;
            push(run, &g, b[0] & 1u);
        }
        break;
    case 4:
    case 5:
        make_packet(run, b, &g);
        push(run, &g, 0);
        break;
    default:
        if (run->waits) {
            g = run->awaited;
            push(run, &g, 1);
        }
        make_packet(run, b, &g);
        push(run, &g, 1);
        break;
    }
    check_counters(run);
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
    if (begin(run, data[6] >> 2)) {
        data += CONFIG_BYTES;
        size -= CONFIG_BYTES;
        while (size >= CALL_BYTES && run->calls < CALLS_MAX) {
            call(run, data);
            data += CALL_BYTES;
            size -= CALL_BYTES;
        }
        flush(run, 1);
        check_counters(run);
    }
    free(run->slots);
    free(run->words);
    free(run->reach);
    free(run);
    return 0;
}
