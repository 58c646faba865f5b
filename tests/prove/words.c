/* A packet's samples into an open line: any samples, every number of them up to
 * 5 beside every number of words up to the line's capacity of 10, and angles at
 * any place where they end within the line. Samples, words and angles end where
 * their memory ends. The promises of words_contract.h are checked. */
#include "words_contract.h"

#define CAPACITY 10u
#define SAMPLES  5u

static lum_assembler a;
static lum_line_slot slot;
static uint32_t words[CAPACITY];
static uint8_t samples[SAMPLES * LUM_SAMPLE_BYTES];

static void place_ranges(lum_group *g)
{
    (void)lum_words_place_ranges(&a, &slot, g);
}

static void place_angles(lum_group *g)
{
    g->first_sample_index = any_u32(0, LUM_LINE_PIXELS - g->num_samples);
    (void)lum_words_place_angles(&slot, g, a.angle_order);
}

/* A line's words are good ones: see alarms.txt. */
static void place(uint32_t n, uint32_t count)
{
    lum_group g;
    any_bytes(words, sizeof words);
    any_bytes(slot.angle_marks, sizeof slot.angle_marks);
    slot.words = words;
    slot.line.words = words;
    slot.line.word_count = count;
    slot.line.angle_count = (uint16_t)any_u32(0, LUM_LINE_PIXELS);
    slot.words_seen = any_u32(0, CAPACITY);
    slot.words_end = any_u32(0, CAPACITY);
    g.num_samples = n;
    g.sample_order = (uint8_t)any_u32(0, LUM_ORDER_BIG);
    g.first_sample_index = any_u32(0, UINT32_MAX);
    g.samples = samples + (SAMPLES - n) * LUM_SAMPLE_BYTES;
    place_angles(&g);
    g.first_sample_index = any_u32(0, UINT32_MAX);
    place_ranges(&g);
}

void main(void)
{
    a.config.words_per_line = CAPACITY;
    a.angle_order = (uint8_t)any_u32(0, LUM_ELEVATION_AZIMUTH);
    any_bytes(samples, sizeof samples);
    const uint32_t n = any_u32(1, SAMPLES);
    //@ split n;
    const uint32_t count = any_u32(0, CAPACITY);
    //@ split count;
    place(n, count);
}
