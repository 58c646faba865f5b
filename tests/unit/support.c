#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/packet.h"

#include <stdlib.h>
#include <string.h>

static void *allocate(size_t n)
{
    void *p = malloc(n > 0 ? n : 1u);
    assert_non_null(p);
    return p;
}

uint8_t *exact_copy(const void *bytes, size_t len)
{
    uint8_t *p = allocate(len);
    if (len > 0) {
        memcpy(p, bytes, len);
    }
    return p;
}

uint8_t *encode_packet(const lum_layout *layout, const lum_group *group,
                       const uint8_t *samples, size_t *len)
{
    const size_t body = (size_t)LUM_SAMPLE_BYTES * group->num_samples;
    uint8_t head[LUM_GROUP_HEAD_MAX];
    size_t n = 0;
    assert_int_equal(lum_group_encode(layout, group, head, sizeof head, &n),
                     LUM_OK);
    uint8_t *p = allocate(n + body);
    memcpy(p, head, n);
    memcpy(p + n, samples, body);
    *len = n + body;
    return p;
}

struct stream *stream_new(void)
{
    struct stream *s = allocate(sizeof *s);
    memset(s, 0, sizeof *s);
    lum_layout_default(&s->layout);
    lum_assembler_config_default(&s->config);
    s->clock = 1000000;
    s->step = 5000;
    return s;
}

void stream_begin(struct stream *s)
{
    const lum_assembler_config *c = &s->config;
    lum_assembler_storage storage = {
        .slot_count = LUM_ASSEMBLER_SLOTS(c->open_lines),
        .word_count = LUM_ASSEMBLER_WORDS(c->open_lines, c->words_per_line),
        .reach_count = LUM_ASSEMBLER_REACH(c->reorder_lines)};
    const size_t slots = storage.slot_count * sizeof *s->slots;
    const size_t words = storage.word_count * sizeof *s->words;
    const size_t reach = storage.reach_count * sizeof *s->reach;
    storage.slots = s->slots = allocate(slots);
    storage.words = s->words = allocate(words);
    storage.reach = s->reach = allocate(reach);
    memset(s->slots, 0xa5, slots);
    memset(s->reach, 0x25, reach); /* frames far ahead */
    memset(&s->assembler, 0xa5, sizeof s->assembler);
    /* good words of the last pixel: any could follow them */
    memset(s->words, 0xe7, words);
    assert_int_equal(lum_assembler_init(&s->assembler, c, &s->layout, &storage),
                     LUM_OK);
}

struct stream *stream_open(void)
{
    struct stream *s = stream_new();
    stream_begin(s);
    return s;
}

void stream_free(struct stream *s)
{
    for (size_t i = 0; i < s->event_count; i++) {
        free(s->events[i]->words);
        free(s->events[i]);
    }
    free(s->events);
    free(s->slots);
    free(s->words);
    free(s->reach);
    free(s);
}

static void keep_line(struct event *e, const lum_line *line)
{
    e->line = *line;
    e->frame = line->frame;
    e->words = (uint32_t *)(void *)exact_copy(
        line->words, line->word_count * sizeof *line->words);
    memcpy(e->angles, line->angles, sizeof e->angles);
    memcpy(e->marks, line->angle_marks, sizeof e->marks);
    e->line.words = e->words;
    e->line.angles = e->angles;
    e->line.angle_marks = e->marks;
}

static void keep(struct stream *s, lum_result what)
{
    struct event *e = allocate(sizeof *e);
    memset(e, 0, sizeof *e);
    e->what = what;
    if (what == LUM_LINE_READY) {
        keep_line(e, lum_assembler_line(&s->assembler));
    } else {
        assert_int_equal(what, LUM_FRAME_READY);
        e->frame = lum_assembler_frame(&s->assembler);
    }
    s->events =
        realloc(s->events, (s->event_count + 1u) * sizeof(struct event *));
    assert_non_null(s->events);
    s->events[s->event_count++] = e;
}

lum_result send_group(struct stream *s, const lum_group *group,
                      const uint8_t *samples)
{
    size_t len = 0;
    uint8_t *packet = encode_packet(&s->layout, group, samples, &len);
    lum_group decoded;
    assert_int_equal(lum_packet_decode(&s->layout, packet, len, &decoded),
                     LUM_PACKET_DATA);
    lum_result r = LUM_OK;
    unsigned rounds = 0;
    while ((r = lum_assembler_push(&s->assembler, &decoded, s->arrival)) > 0) {
        keep(s, r);
        assert_true(++rounds < 1000u);
    }
    s->arrival++;
    free(packet);
    return r;
}

lum_result send_angles(struct stream *s, unsigned eye, uint32_t line,
                       uint32_t clock, uint32_t first, uint32_t n)
{
    uint8_t *samples = allocate((size_t)LUM_SAMPLE_BYTES * n);
    const lum_group g = {.line = line,
                         .num_samples = n,
                         .first_sample_index = first,
                         .clock_raw = clock,
                         .eye = (uint8_t)eye,
                         .tag = LUM_TAG_ANGLES};
    for (uint32_t i = 0; i < n; i++) {
        const int32_t pixel = (int32_t)(first + i);
        const lum_angle angle = {(int16_t)(3 * pixel + (int32_t)(line % 99u)),
                                 (int16_t)-pixel};
        lum_angle_encode(&s->layout, angle, samples + LUM_SAMPLE_BYTES * i);
    }
    const lum_result r = send_group(s, &g, samples);
    free(samples);
    return r;
}

lum_result send_words(struct stream *s, unsigned eye, uint32_t line,
                      uint32_t clock, uint32_t first, const uint32_t *words,
                      uint32_t n)
{
    uint8_t *samples = allocate((size_t)LUM_SAMPLE_BYTES * n);
    const lum_group g = {.line = line,
                         .num_samples = n,
                         .first_sample_index = first,
                         .clock_raw = clock,
                         .eye = (uint8_t)eye,
                         .tag = LUM_TAG_RANGES};
    for (uint32_t i = 0; i < n; i++) {
        lum_group_word_encode(&s->layout, words[i],
                              samples + LUM_SAMPLE_BYTES * i);
    }
    const lum_result r = send_group(s, &g, samples);
    free(samples);
    return r;
}

lum_result send_pixels(struct stream *s, unsigned eye, uint32_t line,
                       uint32_t clock, uint32_t pixel, uint32_t n)
{
    uint32_t words[LUM_LINE_PIXELS];
    assert_true(pixel + n <= LUM_LINE_PIXELS);
    for (uint32_t i = 0; i < n; i++) {
        words[i] = lum_word_make((int32_t)(1000u + i), true, pixel + i);
    }
    return send_words(s, eye, line, clock, pixel, words, n);
}

void send_line(struct stream *s, unsigned eye, uint32_t line)
{
    assert_int_equal(send_angles(s, eye, line, s->clock, 0, 1), LUM_OK);
    assert_int_equal(send_angles(s, eye, line, s->clock, 1, 1), LUM_OK);
    s->clock += s->step;
}

void send_lines(struct stream *s, unsigned eye, uint32_t line, uint32_t last)
{
    while (line <= last) {
        send_line(s, eye, line++);
    }
}

void stream_end(struct stream *s)
{
    lum_result r = LUM_OK;
    unsigned rounds = 0;
    while ((r = lum_assembler_flush(&s->assembler)) > 0) {
        keep(s, r);
        assert_true(++rounds < 1000u);
    }
    assert_int_equal(r, LUM_OK);
}

const lum_assembly_counters *counters(const struct stream *s)
{
    return lum_assembler_counters(&s->assembler);
}

size_t count_events(const struct stream *s, lum_result what)
{
    size_t n = 0;
    for (size_t i = 0; i < s->event_count; i++) {
        n += s->events[i]->what == what ? 1u : 0u;
    }
    return n;
}

const lum_line *nth_line(const struct stream *s, size_t n)
{
    for (size_t i = 0; i < s->event_count; i++) {
        if (s->events[i]->what == LUM_LINE_READY && n-- == 0) {
            return &s->events[i]->line;
        }
    }
    fail_msg("fewer lines than that came out");
    return NULL;
}

const lum_line *find_line(const struct stream *s, unsigned eye, uint32_t number,
                          size_t n)
{
    for (size_t i = 0; i < s->event_count; i++) {
        const lum_line *line = &s->events[i]->line;
        if (s->events[i]->what == LUM_LINE_READY && line->eye == eye &&
            line->number == number && n-- == 0) {
            return line;
        }
    }
    fail_msg("eye %u has no such line %u", eye, (unsigned)number);
    return NULL;
}

int64_t frame_of(const struct stream *s, unsigned eye, uint32_t number,
                 size_t n)
{
    return find_line(s, eye, number, n)->frame;
}

long frame_event(const struct stream *s, int64_t frame)
{
    for (size_t i = 0; i < s->event_count; i++) {
        if (s->events[i]->what == LUM_FRAME_READY &&
            s->events[i]->frame == frame) {
            return (long)i;
        }
    }
    return -1;
}

void assert_lines(const struct stream *s, const uint32_t *numbers, size_t n)
{
    assert_int_equal(count_events(s, LUM_LINE_READY), n);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(nth_line(s, i)->number, numbers[i]);
    }
}

void needs_any_layout(void **state)
{
    (void)state;
    print_message("not here: another layout than the built-in one\n");
    skip();
}

void needs_frames(void **state)
{
    (void)state;
    print_message("not here: frame numbers\n");
    skip();
}

uint32_t next_random(uint64_t *state)
{
    *state =
        *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33);
}
