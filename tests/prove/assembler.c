/* Any stream of data packets into an assembler: any eye, line, clock and
 * content, in any order and number; then a flush. What is handed out can be
 * read to its end. Storage begins as zeros. words_contract.h stands for
 * words.c, which words.c here looks at; what stay_within_reach() admits is
 * argued in docs/proof.md. */
#include "lum/assembler.h"
#include "unknown.h"
#include "words_contract.h"

#define OPEN_LINES 1
#define REORDER    2
#define WORDS      6
#define SLOTS      (2 * OPEN_LINES)

/* The stream is followed as long as its clock and its frame numbers are within
 * this: 2^61 microseconds are 70,000 years, and a frame takes two packets. */
#define REACH (INT64_C(1) << 61)

static lum_assembler a;
static lum_line_slot slots[SLOTS];
static uint32_t words[SLOTS * WORDS];

/* The caller's and the argued side of the proof (docs/proof.md): a clock is one
 * that was read, or the one before all; no line closes that is not open, none
 * opens where all are. */
static void stay_within_reach(void)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_eye_state *eye = &a.eye[e];
        //@ assert eye->closed_next < REORDER;
        //@ assert eye->closed_count <= REORDER;
        //@ admit eye->open_count <= OPEN_LINES;
        //@ admit -REACH <= eye->frame <= REACH;
        //@ admit -2 * REACH <= eye->newest_us <= REACH;
        //@ admit -2 * REACH <= eye->heard_us <= REACH;
        //@ admit -2 * REACH <= eye->candidate_us <= REACH;
        //@ admit -2 * REACH <= eye->low_clock_us <= REACH;
        for (unsigned i = 0; i < REORDER; i++) {
            //@ admit -2 * REACH <= eye->closed[i].clock_us <= REACH;
        }
    }
    for (unsigned i = 0; i < SLOTS; i++) {
        //@ admit -2 * REACH <= slots[i].line.clock_us <= 2 * REACH - 1;
    }
    //@ admit -REACH <= a.clock_us <= REACH;
    //@ admit -REACH <= a.handed_low;
    //@ admit a.handed_high <= REACH;
}

static void choose(lum_group *g)
{
    g->eye = (uint8_t)any_u32(0, LUM_EYES - 1);
    g->tag = (uint8_t)any_u32(LUM_TAG_ANGLES, LUM_TAG_RANGES);
    g->line = any_u32(0, UINT32_MAX);
    g->clock_raw = any_u32(0, UINT32_MAX);
    g->num_samples = any_u32(1, UINT32_MAX);
    g->first_sample_index = any_u32(0, UINT32_MAX);
}

static void configure(lum_assembler_config *config, lum_layout *layout)
{
    any_bytes(layout, sizeof *layout);
    layout->profile.angle_order = (uint8_t)any_u32(0, LUM_ELEVATION_AZIMUTH);
    layout->profile.group[LUM_FIELD_TIMESTAMP].bytes = (uint8_t)any_u32(0, 4);
    config->open_lines = OPEN_LINES;
    config->reorder_lines = REORDER;
    config->words_per_line = WORDS;
    config->gap_us = any_u32(0, (UINT32_C(1) << 30) - 1u);
}

static void take(void)
{
    const lum_line *line = lum_assembler_line(&a);
    //@ assert line->word_count <= WORDS;
    //@ assert line->eye < LUM_EYES;
    //@ assert \valid_read(line->words + (0 .. WORDS - 1));
    //@ assert \valid_read(line->angles + (0 .. LUM_LINE_PIXELS - 1));
    //@ assert \initialized(line->angles + (0 .. LUM_LINE_PIXELS - 1));
    //@ assert \initialized(line->angle_marks + (0 .. 31));
}

static lum_result push(void)
{
    lum_group g;
    choose(&g);
    //@ split g.eye;
    stay_within_reach();
    const lum_result r =
        lum_assembler_push(&a, &g, any_i64(INT64_MIN, INT64_MAX));
    if (r == LUM_LINE_READY) {
        take();
    }
    return r;
}

static lum_result flush(void)
{
    stay_within_reach();
    const lum_result r = lum_assembler_flush(&a);
    if (r == LUM_LINE_READY) {
        take();
    }
    return r;
}

void main(void)
{
    lum_assembler_config config;
    lum_layout layout;
    configure(&config, &layout);
    if (lum_assembler_init(&a, &config, &layout, slots, words) != LUM_OK) {
        return;
    }
    /*@ loop widen_hints "all", REORDER, -2305843011361177600,
       2305843011361177599, -4611686018427387904; */
    while (any_u32(0, 1) == 1) {
        (void)push();
    }
    /*@ loop widen_hints "all", REORDER, -2305843011361177600,
       2305843011361177599, -4611686018427387904; */
    while (flush() > 0) {
    }
}
