/* Any sequence of calls, against limits small and large. Every input is a list
 * of calls as a careless program might make them: another packet after an
 * event, a flush or a question for idle lines at any time, groups that no
 * decoder gives. What include/lum/assembler.h promises is checked after each,
 * and the assembler agrees with a model (model.h) about every packet and line.
 *
 * An execution costs what its calls cost: memory is that of the first, filled
 * and fenced anew, and what a line says is checked once, when it is handed out.
 * One call may stand for a whole line, or for neighbouring lines of both eyes,
 * so that short inputs go far. */
#include "fuzz_assembler.h"

#include "core/layout.h"
#include "model.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#if defined(__has_include)
#if __has_include(<sanitizer/asan_interface.h>)
#include <sanitizer/asan_interface.h>
#endif
#endif
#ifndef ASAN_POISON_MEMORY_REGION
#define ASAN_POISON_MEMORY_REGION(from, size)   ((void)(from), (void)(size))
#define ASAN_UNPOISON_MEMORY_REGION(from, size) ((void)(from), (void)(size))
#endif

/* Whether frames.c is linked, and not frames_none.c. */
#ifdef LUM_TEST_FRAMES_NONE
#define HAS_FRAMES false
#else
#define HAS_FRAMES true
#endif

#define FRAME_NUMBERS 4096u
#define LONG_LINE     4000u
#define SLOTS_MOST    LUM_ASSEMBLER_SLOTS(LUM_OPEN_LINES_MAX)
#define WORDS_MOST    LUM_ASSEMBLER_WORDS(1u, LUM_LINE_WORDS_MAX)
#define REACH_MOST    LUM_ASSEMBLER_REACH(LUM_REORDER_MAX)

/* Memory that lasts: of it as much as a run needs, the rest fenced off. */
struct arena {
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
};

struct run {
    lum_assembler assembler;
    lum_assembler before; /* as it was before a call that must not touch it */
    lum_assembler_config config;
    lum_layout layout;
    lum_assembler_storage storage;
    struct model model;
    bool is_judged;    /* by the model: the packet that the event waits for */
    lum_group awaited; /* where waits: of the packet that the event waits for */
    bool waits;
    bool was_flushed;
    int is_large; /* packets of as many samples as a datagram holds */
    uint32_t clock;
    int64_t arrival; /* of the last call */
    uint64_t calls;
    uint64_t taken; /* packets that were accepted or dropped */
    uint64_t accepted;
    uint64_t refused;
    uint64_t lines;
    uint64_t idle;
    uint64_t bad_words; /* of packets that were accepted */
    uint64_t words_out;
    uint64_t lost_out;
    uint64_t frames;    /* distinct ones of lines */
    uint64_t announced; /* as often as a frame was */
    int64_t last_frame;
    int64_t flushed_frame; /* the last one of before a flush */
    uint8_t seen[FRAME_NUMBERS];
    uint8_t samples[SAMPLES_MAX * LUM_SAMPLE_BYTES];
};

static uint64_t met[SIGHTS];

static const char *const sight_names[SIGHTS] = {
    [MET_OK] = "a packet accepted",
    [MET_FRAME] = "a frame announced",
    [MET_STRAY] = "a stray",
    [MET_JUMP] = "a jump of the clock",
    [MET_LATE] = "a late packet",
    [MET_DUPLICATE] = "a duplicate",
    [MET_CONFLICT] = "a conflict",
    [MET_NO_ROOM] = "a packet for which there is no room",
    [MET_BAD_WORDS] = "bad words beside good ones",
    [MET_BEFORE] = "words before those of their line",
    [MET_BETWEEN] = "words among those of their line",
    [MET_DATAGRAM] = "a packet of 1,500 bytes",
    [MET_ALL_ANGLES] = "a line of all angles",
    [MET_FULL] = "a line at its limit",
    [MET_LONG] = "a line of 4,000 words",
    [MET_LONGEST] = "a line of 32,768 words",
    [MET_LOST] = "a line that lost words",
    [MET_OTHER_PACKET] = "another packet than the awaited one",
    [MET_OTHER_SAMPLES] = "the awaited packet with other samples",
    [MET_IDLE] = "an idle line",
    [MET_IDLE_WAITS] = "a question for idle lines while a packet is awaited",
    [MET_FLUSH_WAITS] = "a flush while a packet is awaited",
    [MET_FLUSH_LEFT] = "a flush that is left before its end",
    [MET_AFTER_FLUSH] = "a packet after a flush",
    [MET_NONSENSE] = "a group that no decoder gives",
    [MET_MOST_OPEN] = "16 open lines of an eye",
};

static void meet(enum sight sight, bool fact)
{
    met[sight] += fact ? 1u : 0u;
}

unsigned fuzz_missed(FILE *out)
{
    unsigned missed = 0;
    for (unsigned i = 0; i < SIGHTS; i++) {
        if (met[i] == 0 && (HAS_FRAMES || i != MET_FRAME)) {
            (void)fprintf(out, "fuzz_assembler: not met: %s\n", sight_names[i]);
            missed++;
        }
    }
    (void)fprintf(out, "fuzz_assembler: met %u of %u\n", SIGHTS - missed,
                  (unsigned)SIGHTS);
    return missed;
}

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

/* Mostly as few as firmware has. */
static uint8_t some_open_lines(uint8_t b)
{
    if (b >= 240) {
        return LUM_OPEN_LINES_MAX;
    }
    return (uint8_t)(1u + b % (b < 224 ? 4u : LUM_OPEN_LINES_MAX));
}

static void configure(struct run *run, const uint8_t *b)
{
    static const uint32_t gaps[] = {100000, 0, 50, 1000, 100000, 5000};
    call_layout(b[0], LUM_AZIMUTH_ELEVATION, &run->layout);
    run->layout.profile.line_span_us = b[1] < 128 ? 2000u : b[1];
    run->config = (lum_assembler_config){
        .open_lines = some_open_lines(b[2]),
        .reorder_lines = (uint8_t)(1u + b[3] % LUM_REORDER_MAX),
        .words_per_line = 1u + b[4],
        .gap_us = gaps[b[5] % 6u],
    };
    run->is_large = (b[6] & 1u) != 0;
    run->arrival = b[6] & 2u ? -20 : INT64_MIN + 8;
    if ((b[6] & 0xf8u) == 0xf8u) { /* dear, so seldom */
        run->config.open_lines = 1;
        run->config.words_per_line =
            b[4] % 2u == 0 ? LUM_LINE_WORDS_MAX : LONG_LINE;
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

static void require_no_layout(struct run *run, const lum_assembler_storage *s)
{
    run->before = run->assembler;
    require(lum_assembler_init(&run->assembler, &run->config, &run->layout,
                               s) == LUM_E_VALUE);
    require(memcmp(&run->before, &run->assembler, sizeof run->before) == 0);
    call_built_in(&run->layout);
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

static bool allocate(struct arena *arena)
{
    if (arena->reach == NULL) {
        arena->slots = malloc(SLOTS_MOST * sizeof *arena->slots);
        arena->words = malloc(WORDS_MOST * sizeof *arena->words);
        arena->reach = malloc(REACH_MOST * sizeof *arena->reach);
    }
    return arena->slots != NULL && arena->words != NULL && arena->reach != NULL;
}

/* What the run may use has the same content each time, the rest no reader. */
static void fill(void *from, size_t size, size_t whole)
{
    ASAN_UNPOISON_MEMORY_REGION(from, size);
    memset(from, 0xa5, size);
    ASAN_POISON_MEMORY_REGION((uint8_t *)from + size, whole - size);
}

static bool begin(struct run *run, unsigned which)
{
    static struct arena arena;
    const lum_assembler_config *c = &run->config;
    lum_assembler_storage s = {
        .slot_count = LUM_ASSEMBLER_SLOTS(c->open_lines),
        .word_count = LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line),
        .reach_count = LUM_ASSEMBLER_REACH(c->reorder_lines)};
    if (!allocate(&arena)) {
        return false;
    }
    s.slots = arena.slots;
    s.words = arena.words;
    s.reach = arena.reach;
    fill(s.slots, s.slot_count * sizeof *s.slots, SLOTS_MOST * sizeof *s.slots);
    fill(s.words, s.word_count * sizeof *s.words, WORDS_MOST * sizeof *s.words);
    fill(s.reach, s.reach_count * sizeof *s.reach,
         REACH_MOST * sizeof *s.reach);
    require_no_begin(run);
    if (!lum_layout_is_read(&run->layout)) {
        require_no_layout(run, &s);
    }
    require_no_space(run, s, which);
    memset(&run->assembler, 0xa5, sizeof run->assembler);
    require(lum_assembler_init(&run->assembler, c, &run->layout, &s) == LUM_OK);
    run->storage = s;
    model_init(&run->model, c, &run->layout);
    return true;
}

static bool is_inside(const void *part, size_t size, const void *whole,
                      size_t whole_size)
{
    const uintptr_t at = (uintptr_t)part - (uintptr_t)whole;
    return at <= whole_size && size <= whole_size - at;
}

/* The model, which reads them, is not sanitized where fuzzers are. */
static void check_memory(const struct run *run, const lum_line *line)
{
    const lum_assembler_storage *s = &run->storage;
    const size_t slots = s->slot_count * sizeof *s->slots;
    require(is_inside(line, sizeof *line, s->slots, slots));
    require(is_inside(line->angles, LUM_LINE_PIXELS * sizeof *line->angles,
                      s->slots, slots));
    require(is_inside(line->angle_marks,
                      LUM_PIXEL_MARK_WORDS * sizeof *line->angle_marks,
                      s->slots, slots));
    require(line->word_count <= run->config.words_per_line);
    require(is_inside(line->words, line->word_count * sizeof *line->words,
                      s->words, s->word_count * sizeof *s->words));
}

/* What was handed out as the model's oldest line of an eye, or one behind. */
static void check_line(struct run *run, unsigned eye, unsigned index)
{
    const lum_line *line = lum_assembler_line(&run->assembler);
    const uint32_t capacity = run->config.words_per_line;
    require(index < run->model.eye[eye].open_count);
    const struct model_line expected = model_close(&run->model, eye, index);
    check_memory(run, line);
    require(line->eye == eye);
    require(model_agrees(&expected, line));
    run->lines++;
    run->words_out += line->word_count;
    run->lost_out += line->lost_words;
    require(line->frame >= 0 && line->frame < (int64_t)FRAME_NUMBERS);
    uint8_t *seen = &run->seen[line->frame];
    run->frames += HAS_FRAMES && *seen == 0 ? 1u : 0u;
    *seen = 1;
    require(HAS_FRAMES || line->frame == 0);
    /* with fewer packets, its frame is a mere label */
    require(expected.accepted < 2 || line->frame > run->flushed_frame);
    meet(MET_ALL_ANGLES, line->angle_count == LUM_LINE_PIXELS);
    meet(MET_FULL, line->word_count == capacity);
    meet(MET_LONG, line->word_count == LONG_LINE);
    meet(MET_LONGEST, line->word_count == LUM_LINE_WORDS_MAX);
    meet(MET_LOST, line->lost_words > 0);
}

static void check_frame(struct run *run)
{
    const int64_t frame = lum_assembler_frame(&run->assembler);
    require(HAS_FRAMES);
    require(run->announced == 0 || frame == run->last_frame + 1);
    run->last_frame = frame;
    run->announced++;
    meet(MET_FRAME, true);
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
    require(c->bad_words == run->bad_words);
    /* between, numbers whose lines are still open may be counted ahead */
    require(c->frames >= run->frames && c->frames >= run->announced);
    require(HAS_FRAMES || (c->frames == 0 && c->lines_skipped == 0));
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

/* Frames are announced before a packet is looked at, lines are closed after. */
static void judge(struct run *run, const lum_group *g)
{
    if (!run->is_judged) {
        model_judge(&run->model, g);
        run->is_judged = true;
        meet(MET_JUMP, run->model.place == MODEL_BREAK);
    }
}

/* Whether the packet lies before, or among, what its line has of words. */
static void meet_order(const struct run *run, const lum_group *g)
{
    const struct model *m = &run->model;
    if (m->place != MODEL_OPEN || g->tag != LUM_TAG_RANGES) {
        return;
    }
    const struct model_line *line = &m->eye[g->eye].open[m->target];
    const uint32_t last =
        (g->samples[0] | (uint32_t)g->samples[1] << 8) & LUM_WORD_PIXEL;
    uint32_t below = 0;
    uint32_t above = 0;
    for (uint32_t w = 0; w < LUM_PIXEL_MARK_WORDS; w++) {
        below |= w < last / 32u ? line->word_marks[w] : 0;
        above |= w > last / 32u ? line->word_marks[w] : 0;
    }
    meet(MET_BEFORE, below == 0 && above != 0);
    meet(MET_BETWEEN, below != 0 && above != 0);
}

static void finish(struct run *run, const lum_group *g, lum_result r)
{
    uint64_t bad = 0;
    meet_order(run, g);
    require(run->model.to_close == 0);
    require(r == model_finish(&run->model, g, run->arrival, &bad));
    run->taken++;
    run->accepted += r == LUM_OK ? 1u : 0u;
    run->bad_words += bad;
    run->is_judged = false;
    meet(MET_OK, r == LUM_OK);
    meet(MET_STRAY, r == LUM_E_STRAY);
    meet(MET_LATE, r == LUM_E_LATE);
    meet(MET_DUPLICATE, r == LUM_E_DUPLICATE);
    meet(MET_CONFLICT, r == LUM_E_CONFLICT);
    meet(MET_NO_ROOM, r == LUM_E_NO_ROOM);
    meet(MET_BAD_WORDS, bad > 0 && bad < g->num_samples);
    meet(MET_DATAGRAM, g->num_samples == SAMPLES_MAX);
    meet(MET_AFTER_FLUSH, r == LUM_OK && run->was_flushed);
    meet(MET_MOST_OPEN,
         run->model.eye[g->eye].open_count == LUM_OPEN_LINES_MAX);
}

/* One call; false: the packet has been taken. */
static bool push_once(struct run *run, const lum_group *g)
{
    if (run->waits && !is_same(&run->awaited, g)) {
        run->before = run->assembler;
        require_untouched(run,
                          lum_assembler_push(&run->assembler, g, run->arrival),
                          LUM_E_ORDER);
        meet(MET_OTHER_PACKET, true);
        return false;
    }
    const lum_result r = lum_assembler_push(&run->assembler, g, run->arrival);
    run->waits = r > 0;
    run->awaited = *g;
    if (r == LUM_FRAME_READY) {
        require(!run->is_judged);
        check_frame(run);
        return true;
    }
    judge(run, g);
    if (r == LUM_LINE_READY) {
        require(run->model.to_close > 0);
        run->model.to_close--;
        check_line(run, g->eye, 0);
        return true;
    }
    finish(run, g, r);
    return false;
}

/* how: 0 once, as with `if` in place of `while`; else until it is taken. */
static void push(struct run *run, const lum_group *g, unsigned how)
{
    const uint64_t most = run->lines + run->config.open_lines + 4u;
    uint64_t rounds = 0;
    while (push_once(run, g) && how != 0) {
        require(++rounds <= most);
    }
}

static void close_idle(struct run *run, int64_t before, unsigned how)
{
    unsigned eye = 0;
    unsigned index = 0;
    if (run->waits) {
        run->before = run->assembler;
        require_untouched(run,
                          lum_assembler_close_idle(&run->assembler, before),
                          LUM_E_ORDER);
        meet(MET_IDLE_WAITS, true);
        return;
    }
    while (model_find_idle(&run->model, before, &eye, &index)) {
        require(lum_assembler_close_idle(&run->assembler, before) ==
                LUM_LINE_READY);
        check_line(run, eye, index);
        run->idle++;
        meet(MET_IDLE, true);
        if (how == 0) {
            return;
        }
    }
    require(lum_assembler_close_idle(&run->assembler, before) == LUM_OK);
}

/* A packet that waits is given up. */
static void begin_flush(struct run *run)
{
    if (run->waits) {
        run->refused++;
        run->waits = false;
        run->is_judged = false;
        meet(MET_FLUSH_WAITS, true);
    }
}

static void flush(struct run *run, unsigned how)
{
    const uint64_t most = run->lines + 2u * run->config.open_lines + 4u;
    uint64_t rounds = 0;
    lum_result r = LUM_OK;
    begin_flush(run);
    while ((r = lum_assembler_flush(&run->assembler)) > 0) {
        require(++rounds <= most);
        if (r == LUM_LINE_READY) {
            check_line(run, run->model.eye[0].open_count > 0 ? 0 : 1, 0);
        } else {
            require(r == LUM_FRAME_READY);
            check_frame(run);
        }
        if (how == 0) {
            meet(MET_FLUSH_LEFT, true);
            return;
        }
    }
    require(r == LUM_OK);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        require(run->model.eye[e].open_count == 0);
    }
    model_end(&run->model);
    run->was_flushed = true;
    run->flushed_frame = run->announced > 0 ? run->last_frame : -1;
    const lum_assembly_counters *c = lum_assembler_counters(&run->assembler);
    require(run->accepted == 0 || c->lines > 0);
    require(c->frames == run->frames && c->frames >= run->announced);
}

/* No packet that a decoder gives. */
static void push_nonsense(struct run *run, lum_group g, unsigned which)
{
    call_spoil(&g, which);
    run->before = run->assembler;
    require_untouched(run, lum_assembler_push(&run->assembler, &g, 0),
                      LUM_E_VALUE);
    meet(MET_NONSENSE, true);
}

static void make_packet(struct run *run, const uint8_t *b, lum_group *g)
{
    call_packet(b, run->is_large, run->samples, g);
    run->clock += call_step(b[2]);
    g->clock_raw = run->clock;
}

/* Neighbouring lines as a sensor sends them, of both eyes: two packets each.
 * Now and then more than may be open. */
static void push_lines(struct run *run, const uint8_t *b)
{
    lum_group g;
    uint8_t one[CALL_BYTES];
    const unsigned lines =
        b[7] < 240 ? 1u + b[0] % 4u : LUM_OPEN_LINES_MAX + 1u;
    memcpy(one, b, sizeof one);
    for (unsigned i = 0; i < 4u * lines; i++) {
        one[0] = (uint8_t)((b[0] & 0xfcu) | (i / 2u) % 2u | (i % 2u) << 1);
        one[1] = (uint8_t)((b[1] + i / 4u) % 80u);
        one[2] = i % 4u == 0 ? b[2] : 0; /* a step of 0 else */
        make_packet(run, one, &g);
        push(run, &g, 1);
    }
}

/* A part of a line's pixels, in which n words are in order. */
static void make_part(uint32_t part, uint32_t parts, uint32_t n,
                      uint8_t *samples)
{
    const uint32_t first = LUM_LINE_PIXELS * part / parts;
    const uint32_t width = LUM_LINE_PIXELS * (part + 1u) / parts - first;
    for (uint32_t i = 0; i < n; i++) {
        call_word(i << 12 | (first + i * width / n),
                  samples + (size_t)LUM_SAMPLE_BYTES * i);
    }
}

/* A line of all angles and as many words as there is room for, then more. The
 * parts come in order or, by b[5], the odd ones last. */
static void push_whole(struct run *run, const uint8_t *b)
{
    const uint32_t room = run->config.words_per_line;
    const uint32_t parts = (room + SAMPLES_MAX - 1u) / SAMPLES_MAX;
    lum_group g;
    make_packet(run, b, &g);
    g.tag = LUM_TAG_ANGLES;
    for (uint32_t first = 0; first < LUM_LINE_PIXELS; first += 334u) {
        g.first_sample_index = first;
        g.num_samples = first == 668u ? 332u : 334u;
        push(run, &g, 1);
    }
    g.tag = LUM_TAG_RANGES;
    for (uint32_t i = 0; i <= parts; i++) {
        uint32_t part = i;
        if (b[5] % 2u != 0 && i < parts) {
            const uint32_t even = (parts + 1u) / 2u;
            part = i < even ? 2u * i : 2u * (i - even) + 1u;
        }
        g.first_sample_index = part * SAMPLES_MAX;
        g.num_samples =
            part + 1u == parts ? room - part * SAMPLES_MAX : SAMPLES_MAX;
        make_part(part, parts + 1u, g.num_samples, run->samples);
        push(run, &g, 1);
    }
}

/* Long lines take the time of many short ones. */
static unsigned dearness(const struct run *run)
{
    if (run->config.words_per_line > LONG_LINE) {
        return 16;
    }
    return run->config.words_per_line == LONG_LINE ? 4 : 1;
}

/* What waits goes first. */
static void push_awaited(struct run *run)
{
    if (run->waits) {
        const lum_group g = run->awaited;
        push(run, &g, 1);
    }
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
            call_samples(b, run->awaited.num_samples, run->samples);
            g = run->awaited;
            push(run, &g, b[0] & 1u);
            meet(MET_OTHER_SAMPLES, true);
        }
        break;
    case 4:
    case 5:
        make_packet(run, b, &g);
        push(run, &g, 0);
        break;
    case 6:
        push_awaited(run);
        push_lines(run, b);
        break;
    case 7:
        push_awaited(run);
        if (b[7] % dearness(run) == 0) {
            push_whole(run, b);
        }
        break;
    default:
        push_awaited(run);
        make_packet(run, b, &g);
        push(run, &g, 1);
        break;
    }
    check_counters(run);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct run run;
    if (size < CONFIG_BYTES) {
        return 0;
    }
    memset(&run, 0, sizeof run);
    run.flushed_frame = -1;
    configure(&run, data);
    if (!begin(&run, data[6] >> 2)) {
        return 0;
    }
    data += CONFIG_BYTES;
    size -= CONFIG_BYTES;
    while (size >= CALL_BYTES && run.calls < CALLS_MAX) {
        call(&run, data);
        data += CALL_BYTES;
        size -= CALL_BYTES;
    }
    flush(&run, 1);
    check_counters(&run);
    return 0;
}
