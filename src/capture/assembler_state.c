/* The state of an assembler as bytes, to go on from the middle of a capture. */
#include "demux_state.h"

#include "lum/clock.h"
#include "lum/group.h"

#include <string.h>

/* Clocks of packets but strays lie within 2^61 us of 0; what is not set yet
 * is 2^62 before 0 (src/core/stream.c). */
#define CLOCK_MIN (INT64_MIN / 2)
#define CLOCK_MAX ((INT64_C(1) << 61) + (INT64_C(1) << 33))

/* More frames are never waited for at a time. */
#define FRAMES_MAX 1000u

static void pack_clock(lum_pack *p, int64_t *clock_us, int64_t near_us)
{
    lum_pack_near(p, clock_us, near_us);
    (void)lum_pack_check(p, *clock_us >= CLOCK_MIN && *clock_us <= CLOCK_MAX);
}

/* --- Words and angles of an open line --- */

static uint32_t pixel_of(uint32_t word)
{
    return word & LUM_WORD_PIXEL;
}

/* How many words a pixel has, from this one on. */
static uint32_t count_words(const lum_line_slot *slot, uint32_t from,
                            uint32_t pixel)
{
    uint32_t i = from;
    while (i < slot->line.word_count && pixel_of(slot->words[i]) == pixel) {
        i++;
    }
    return i - from;
}

/* How many pixels in turn have as many words as this one. */
static uint32_t count_pixels(const lum_line_slot *slot, uint32_t from,
                             uint32_t pixel, uint32_t words)
{
    uint32_t next = pixel;
    while (next < LUM_LINE_PIXELS && count_words(slot, from, next) == words) {
        from += words;
        next++;
    }
    return next - pixel;
}

/* Words of some pixels in turn; returns how many. */
static uint32_t put_pixels(lum_line_slot *slot, uint32_t from, uint32_t pixel,
                           uint32_t pixels, uint32_t words)
{
    for (uint32_t i = 0; i < pixels * words; i++) {
        slot->words[from + i] = pixel + i / words;
    }
    return pixels * words;
}

/* Pixels rise, and most have as many words as the one before. */
static void pack_pixels(lum_pack *p, lum_line_slot *slot)
{
    const bool is_reading = lum_pack_is_reading(p);
    uint32_t at = 0;
    uint32_t pixel = 0;
    while (pixel < LUM_LINE_PIXELS) {
        const uint32_t left = slot->line.word_count - at;
        uint32_t words = is_reading ? 0 : count_words(slot, at, pixel);
        uint32_t pixels = is_reading ? 0 : count_pixels(slot, at, pixel, words);
        lum_pack_u32(p, &words);
        lum_pack_u32(p, &pixels);
        if (!lum_pack_check(p, pixels > 0 &&
                                   pixels <= LUM_LINE_PIXELS - pixel &&
                                   (uint64_t)pixels * words <= left)) {
            return;
        }
        at += is_reading ? put_pixels(slot, at, pixel, pixels, words)
                         : pixels * words;
        pixel += pixels;
    }
    (void)lum_pack_check(p, at == slot->line.word_count);
}

/* Pixels rise. */
static void pack_words(lum_pack *p, lum_line_slot *slot)
{
    int64_t before = 0;
    for (uint32_t i = 0; i < slot->line.word_count; i++) {
        int64_t word = slot->words[i];
        lum_pack_near(p, &word, before);
        const uint32_t place =
            (uint32_t)word & (LUM_WORD_ZERO | LUM_WORD_PIXEL);
        if (!lum_pack_check(p, word >= 0 && word <= UINT32_MAX &&
                                   place >= pixel_of((uint32_t)before) &&
                                   place < LUM_LINE_PIXELS)) {
            return;
        }
        slot->words[i] = (uint32_t)word;
        before = word;
    }
}

static uint16_t count_bits(const uint32_t *marks)
{
    uint16_t count = 0;
    for (uint32_t i = 0; i < LUM_LINE_PIXELS; i++) {
        count = (uint16_t)(count + (marks[i / 32u] >> (i % 32u) & 1u));
    }
    return count;
}

static void pack_angles(lum_pack *p, lum_line_slot *slot, bool matters)
{
    lum_angle before = {.azimuth = 0};
    for (size_t i = 0; i < LUM_PIXEL_MARK_WORDS; i++) {
        uint32_t mark = ~slot->angle_marks[i]; /* most are whole */
        lum_pack_u32(p, &mark);
        slot->angle_marks[i] = ~mark;
    }
    const uint32_t last = slot->angle_marks[LUM_PIXEL_MARK_WORDS - 1u];
    if (!lum_pack_check(p, last >> (LUM_LINE_PIXELS % 32u) == 0)) {
        return;
    }
    slot->line.angle_count = count_bits(slot->angle_marks);
    if (lum_pack_is_reading(p)) {
        memset(slot->angles, 0, sizeof slot->angles);
    }
    for (uint32_t i = 0; i < LUM_LINE_PIXELS; i++) {
        if (matters && (slot->angle_marks[i / 32u] >> (i % 32u) & 1u) != 0) {
            int64_t azimuth = slot->angles[i].azimuth;
            int64_t elevation = slot->angles[i].elevation;
            lum_pack_near(p, &azimuth, before.azimuth);
            lum_pack_near(p, &elevation, before.elevation);
            slot->angles[i] = (lum_angle){(int16_t)azimuth, (int16_t)elevation};
            before = slot->angles[i];
        }
    }
}

/* --- Open and closed lines --- */

static uint64_t last_ticks(const lum_assembler *a)
{
    return a->stream.clock.lowest + a->stream.clock.half;
}

/* The clock of the last packet, which others are near. */
static int64_t last_us(const lum_assembler *a)
{
    return lum_clock_us(last_ticks(a), a->stream.clock.unit_ns);
}

static void pack_slot(lum_pack *p, const lum_assembler *a, uint32_t from,
                      lum_line_slot *slot)
{
    lum_line *line = &slot->line;
    const uint32_t words_max = a->config.words_per_line;
    lum_pack_u32(p, &line->number);
    pack_clock(p, &line->clock_us, last_us(a));
    lum_pack_i64(p, &line->arrival);
    lum_pack_near(p, &slot->last_arrival, line->arrival);
    lum_pack_u32(p, &slot->accepted);
    lum_pack_u32(p, &slot->frame);
    lum_pack_u32(p, &slot->words_seen);
    lum_pack_u32(p, &slot->words_end);
    lum_pack_u32(p, &line->word_count);
    if (!lum_pack_check(p, slot->accepted <= 2u &&
                               slot->words_seen <= words_max &&
                               slot->words_end <= words_max &&
                               line->word_count <= words_max)) {
        line->word_count = 0;
        return;
    }
    if (slot->accepted != 0) {
        pack_clock(p, &slot->low_clock_us, line->clock_us);
    } else {
        slot->low_clock_us = INT64_MAX;
    }
    line->lost_words = 0;
    const bool matters = slot->accepted < 2u || (slot->frame - from) >> 31 == 0;
    pack_angles(p, slot, matters);
    if (matters) {
        pack_words(p, slot);
    } else {
        pack_pixels(p, slot);
    }
}

static void pack_lines(lum_pack *p, const lum_assembler *a, uint32_t from,
                       lum_eye_state *eye)
{
    lum_eye_lines *lines = &eye->lines;
    lum_line_slot *slot = lines->oldest;
    lum_pack_u8(p, &lines->open_count);
    lum_pack_u8(p, &lines->closed_next);
    pack_clock(p, &lines->low_clock_us, last_us(a));
    if (!lum_pack_check(p, lines->open_count <= a->config.open_lines &&
                               lines->closed_next < a->config.reorder_lines)) {
        lines->open_count = 0;
        lines->closed_next = 0;
        return;
    }
    for (unsigned i = 0; i < lines->open_count; i++) {
        pack_slot(p, a, from, slot);
        slot = slot->next;
    }
    lines->unused = slot;
    for (unsigned i = 0; i < a->config.reorder_lines; i++) {
        pack_clock(p, &eye->reach[i].clock_us, last_us(a));
        lum_pack_u32(p, &eye->reach[i].number);
        lum_pack_u32(p, &eye->reach[i].frame);
    }
}

/* --- Frames and clocks --- */

static void pack_frames(lum_pack *p, lum_eye_frames *f)
{
    lum_pack_u8(p, &f->straggling);
    lum_pack_bool(p, &f->begun);
    lum_pack_bool(p, &f->after_break);
    lum_pack_u32(p, &f->frame);
    lum_pack_u32(p, &f->top);
    lum_pack_u32(p, &f->previous_top);
    lum_pack_u32(p, &f->gap);
}

static void pack_stream(lum_pack *p, const lum_assembler *a, lum_eye_stream *s)
{
    lum_pack_u32(p, &s->seen);
    pack_clock(p, &s->newest_us, last_us(a));
    pack_clock(p, &s->heard_us, last_us(a));
    lum_pack_i64(p, &s->candidate_us);
}

/* Frames are announced one by one, and so few may be left to announce. */
static void pack_span(lum_pack *p, lum_frame_span *span)
{
    lum_pack_u32(p, &span->announced);
    lum_pack_u32(p, &span->next);
    lum_pack_u32(p, &span->first);
    lum_pack_u32(p, &span->highest);
    const uint32_t left = span->highest + 1u - span->next;
    if (left > FRAMES_MAX && left >> 31 == 0) {
        p->has_failed = true;
    }
}

/* A line is the first member of its slot, which stays as it is meanwhile. */
bool lum_assembler_line_is_decided(const lum_assembler *a)
{
    const lum_line_slot *slot = (const lum_line_slot *)(const void *)a->line;
    return slot->accepted >= 2u;
}

bool lum_assembler_pack(lum_assembler *a, uint32_t from, lum_pack *pack)
{
    lum_pack *p = pack;
    uint64_t ticks = last_ticks(a);
    pack_span(p, &a->frames);
    lum_pack_u32(p, &a->stream.begun);
    lum_pack_u64(p, &ticks);
    a->stream.clock.lowest = ticks - a->stream.clock.half;
    (void)lum_pack_check(p, last_us(a) >= CLOCK_MIN && last_us(a) <= CLOCK_MAX);
    for (unsigned e = 0; e < LUM_EYES && !p->has_failed; e++) {
        pack_frames(p, &a->eye[e].frames);
        pack_stream(p, a, &a->eye[e].stream);
        pack_lines(p, a, from, &a->eye[e]);
    }
    return !p->has_failed;
}
