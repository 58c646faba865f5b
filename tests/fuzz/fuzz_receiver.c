/* Any sequence of calls to a receiver, in any order of packets. Every input is
 * a list of calls; its form is that of fuzz_assembler.c. The promises of
 * include/lum/receiver.h are checked after each call, with the accepted
 * packets: no word is handed out with an angle of another line, and none
 * twice. */
#include "calls.h"

#include "core/layout.h"
#include "lum/receiver.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How often inputs were answered so. */
static const struct answer {
    lum_result result;
    const char *name;
} answers[] = {{LUM_OK, "accepted"},         {LUM_E_STRAY, "stray"},
               {LUM_E_LATE, "late"},         {LUM_E_DUPLICATE, "duplicate"},
               {LUM_E_CONFLICT, "conflict"}, {LUM_E_NO_ROOM, "no room"}};
#define ANSWERS (sizeof answers / sizeof answers[0])
static uint64_t met[ANSWERS];

unsigned fuzz_missed(FILE *out)
{
    unsigned missed = 0;
    for (size_t i = 0; i < ANSWERS; i++) {
        if (met[i] == 0) {
            (void)fprintf(out, "fuzz_receiver: not met: %s\n", answers[i].name);
            missed++;
        }
    }
    return missed;
}

static void note_answer(lum_result r)
{
    for (size_t i = 0; i < ANSWERS; i++) {
        met[i] += answers[i].result == r ? 1u : 0u;
    }
}

/* What the accepted packets said of a pixel's line. */
struct pixel {
    lum_angle angle;
    uint64_t angles_of; /* the line; 0: none */
    uint64_t words_of;
};

struct run {
    lum_receiver receiver;
    lum_receiver before;
    lum_layout layout;
    uint32_t gap_us;
    uint32_t *words;
    uint32_t word_room;
    int is_large;
    uint32_t clock;
    uint64_t calls;
    uint64_t taken;
    uint64_t accepted;
    uint64_t words_out;
    uint64_t lines; /* opened so far: the last one's name */
    uint64_t line_of[LUM_EYES];
    uint32_t number[LUM_EYES];
    int64_t clock_us[LUM_EYES];
    struct pixel pixels[LUM_EYES][LUM_LINE_PIXELS];
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
    static const uint32_t gaps[] = {100000, 0, 50, 1000, 100000, 5000};
    call_layout(b[0], b[2] & 1u, &run->layout);
    run->layout.profile.line_span_us = b[1] < 128 ? 2000u : b[1];
    run->gap_us = gaps[b[5] % 6u];
    run->is_large = (b[6] & 1u) != 0;
    run->word_room = b[4] < 64 ? 1u + b[4] : SAMPLES_MAX;
}

static int begin(struct run *run)
{
    lum_receiver *r = &run->receiver;
    uint8_t sample[LUM_SAMPLE_BYTES] = {0};
    const lum_group g = {
        .samples = sample, .num_samples = 1, .tag = LUM_TAG_RANGES};
    run->words = malloc(run->word_room * sizeof *run->words);
    if (run->words == NULL) {
        return 0;
    }
    memset(run->words, 0xa5, run->word_room * sizeof *run->words);
    require(lum_receiver_push(r, &g) == LUM_E_ORDER);
    lum_receiver_forget(r);
    require(lum_receiver_line(r) == NULL);
    memset(r, 0xa5, sizeof *r);
    run->before = *r;
    if (!lum_layout_is_read(&run->layout)) {
        require(lum_receiver_init(r, &run->layout, run->gap_us, run->words,
                                  1) == LUM_E_VALUE);
        call_built_in(&run->layout);
    }
    require(lum_receiver_init(r, &run->layout, run->gap_us, run->words, 0) ==
            LUM_E_SPACE);
    require(lum_receiver_init(r, &run->layout, 1u << 30, run->words, 1) ==
            LUM_E_VALUE);
    require(memcmp(&run->before, r, sizeof *r) == 0);
    require(lum_receiver_init(r, &run->layout, run->gap_us, run->words,
                              run->word_room) == LUM_OK);
    return 1;
}

/* The line of an accepted packet: a new one where the one before has ended. */
static uint64_t line_of(struct run *run, const lum_line *line)
{
    const unsigned eye = line->eye;
    if (run->line_of[eye] == 0) {
        run->line_of[eye] = ++run->lines;
        run->number[eye] = line->number;
        run->clock_us[eye] = line->clock_us;
    }
    require(run->number[eye] == line->number);
    require(run->clock_us[eye] == line->clock_us);
    return run->line_of[eye];
}

static void note_angles(struct run *run, const lum_group *g, uint64_t name)
{
    struct pixel *pixel = &run->pixels[g->eye][g->first_sample_index];
    for (uint32_t i = 0; i < g->num_samples; i++, pixel++) {
        require(pixel->angles_of != name);
        pixel->angles_of = name;
        pixel->angle = lum_group_angle(&run->layout, g, i);
    }
}

/* The words are the packet's good ones, in their order. */
static void note_words(struct run *run, const lum_group *g,
                       const lum_line *line, uint64_t name)
{
    struct pixel *pixels = run->pixels[g->eye];
    uint32_t n = 0;
    for (uint32_t i = 0; i < g->num_samples; i++) {
        const uint32_t word = lum_group_word(g, i);
        if (lum_word_is_good(word)) {
            require(n < line->word_count && line->words[n] == word);
            require(pixels[lum_word_pixel(word)].words_of != name);
            n++;
        }
    }
    require(n == line->word_count && n <= run->word_room);
    int is_sorted = 1;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t p = lum_word_pixel(line->words[i]);
        pixels[p].words_of = name;
        require(lum_line_has_angles(line, p) == (pixels[p].angles_of == name));
        is_sorted &= i == 0 || lum_word_pixel(line->words[i - 1u]) <= p;
    }
    require(lum_receiver_is_sorted(&run->receiver) == (is_sorted != 0));
    run->words_out += n;
}

static void check_angles(const struct run *run, const lum_line *line,
                         uint64_t name)
{
    unsigned marked = 0;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        const struct pixel *pixel = &run->pixels[line->eye][p];
        if (lum_line_has_angles(line, p)) {
            marked++;
            require(pixel->angles_of == name);
            require(pixel->angle.azimuth == line->angles[p].azimuth);
            require(pixel->angle.elevation == line->angles[p].elevation);
        }
    }
    require(marked == line->angle_count);
}

static void check_counters(const struct run *run)
{
    const lum_receiver_counters *c = lum_receiver_counted(&run->receiver);
    require(run->taken == run->accepted + c->stray + c->late + c->duplicate +
                              c->conflict + c->no_room);
    require(c->words == run->words_out);
    require(c->lines_missing_angles <= c->lines);
    require(run->before.counters.lost_words <= c->lost_words);
    require(run->before.counters.lines_skipped <= c->lines_skipped);
}

static void push(struct run *run, const lum_group *g)
{
    run->before = run->receiver;
    const lum_result r = lum_receiver_push(&run->receiver, g);
    const lum_line *line = lum_receiver_line(&run->receiver);
    note_answer(r);
    run->taken++;
    if (lum_receiver_counted(&run->receiver)->lines >
        run->before.counters.lines) {
        run->line_of[g->eye] = 0;
    }
    if (r != LUM_OK) {
        require(r <= LUM_E_STRAY && r >= LUM_E_NO_ROOM);
        require(line->word_count == 0);
        return;
    }
    run->accepted++;
    require(line->eye == g->eye && line->number == g->line);
    require(line->frame == 0 && line->arrival == 0);
    require(line->words == run->words);
    const uint64_t name = line_of(run, line);
    if (g->tag == LUM_TAG_ANGLES) {
        require(line->word_count == 0);
        note_angles(run, g, name);
    } else {
        note_words(run, g, line, name);
    }
    check_angles(run, line, name);
}

/* No packet that a decoder gives. */
static void push_nonsense(struct run *run, lum_group g, unsigned which)
{
    call_spoil(&g, which);
    run->before = run->receiver;
    require(lum_receiver_push(&run->receiver, &g) == LUM_E_VALUE);
    require(lum_receiver_line(&run->receiver)->word_count == 0);
    require(memcmp(&run->before.counters, &run->receiver.counters,
                   sizeof run->before.counters) == 0);
}

static void make_packet(struct run *run, const uint8_t *b, lum_group *g)
{
    call_packet(b, run->is_large, run->samples, g);
    run->clock += call_step(b[2]);
    g->clock_raw = run->clock;
}

static void forget(struct run *run)
{
    run->before = run->receiver;
    lum_receiver_forget(&run->receiver);
    require(lum_receiver_line(&run->receiver)->word_count == 0);
    memset(run->line_of, 0, sizeof run->line_of);
}

/* b[8] tells the call: most are packets. */
static void call(struct run *run, const uint8_t *b)
{
    lum_group g;
    run->calls++;
    make_packet(run, b, &g);
    switch (b[8] % 32u) {
    case 0:
        forget(run);
        break;
    case 1:
        push_nonsense(run, g, b[7]);
        break;
    case 2:
    case 3:
        push(run, &g);
        push(run, &g);
        break;
    default:
        push(run, &g);
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
    if (begin(run)) {
        data += CONFIG_BYTES;
        size -= CONFIG_BYTES;
        while (size >= CALL_BYTES && run->calls < CALLS_MAX) {
            call(run, data);
            data += CALL_BYTES;
            size -= CALL_BYTES;
        }
    }
    free(run->words);
    free(run);
    return 0;
}
