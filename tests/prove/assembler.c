/* Any sequence of calls: packets of any eye, line, clock and size, groups that
 * no decoder gives, another packet after an event, idle lines of any arrival
 * and flushes that are left before their end. Lines that are handed out can be
 * read to their end. Storage has any content at init. words_contract.h replaces
 * words.c, which the driver words.c covers; docs/internals/proof.md has the
 * arguments for the admitted facts. */
#include "lum/assembler.h"
#include "unknown.h"
#include "words_contract.h"

#define OPEN_LINES 1
#define REORDER    2
#define WORDS      6
#define SLOTS      (2 * OPEN_LINES)

static lum_assembler a;
static lum_line_slot slots[SLOTS];
static uint32_t words[SLOTS * WORDS];
static lum_reach reach[2 * REORDER];

/* No caller can break these: no line closes that is not open, none opens where
 * all are. */
static void keep_what_is_argued(void)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        lum_eye_state *eye = &a.eye[e];
        //@ admit eye->lines.open_count <= OPEN_LINES;
        //@ admit eye->lines.closed_next < REORDER;
    }
}

static void take(void)
{
    const lum_line *line = lum_assembler_line(&a);
    //@ assert line->word_count <= WORDS;
    //@ assert line->eye < LUM_EYES;
    //@ assert \valid_read(line->words + (0 .. WORDS - 1));
    //@ assert \valid_read(line->angles + (0 .. LUM_LINE_PIXELS - 1));
}

static void push(void)
{
    lum_group g;
    any_bytes(&g, sizeof g);
    g.eye = (uint8_t)any_u32(0, LUM_EYES);
    //@ split g.eye;
    keep_what_is_argued();
    if (lum_assembler_push(&a, &g, any_i64(INT64_MIN, INT64_MAX)) ==
        LUM_LINE_READY) {
        take();
    }
}

static void flush(void)
{
    keep_what_is_argued();
    if (lum_assembler_flush(&a) == LUM_LINE_READY) {
        take();
    }
}

static void close_idle(void)
{
    keep_what_is_argued();
    if (lum_assembler_close_idle(&a, any_i64(INT64_MIN, INT64_MAX)) ==
        LUM_LINE_READY) {
        take();
    }
}

void main(void)
{
    lum_layout layout;
    const lum_assembler_config config = {
        .open_lines = OPEN_LINES,
        .reorder_lines = REORDER,
        .words_per_line = WORDS,
        .gap_us = any_u32(0, (UINT32_C(1) << 30) - 1u)};
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    any_bytes(&layout, sizeof layout);
    layout.profile.angle_order = (uint8_t)any_u32(0, LUM_ELEVATION_AZIMUTH);
    layout.profile.clock_unit_ns = any_u32(1, LUM_CLOCK_UNIT_MAX_NS);
    layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = (uint8_t)any_u32(0, 8);
    layout.profile.group[LUM_FIELD_TIMESTAMP].bits = (uint8_t)any_u32(0, 64);
    any_bytes(slots, sizeof slots);
    any_bytes(words, sizeof words);
    any_bytes(reach, sizeof reach);
    if (lum_assembler_init(&a, &config, &layout, &storage) != LUM_OK) {
        return;
    }
    while (any_u32(0, 1) == 1) {
        switch (any_u32(0, 2)) {
        case 0:
            push();
            break;
        case 1:
            close_idle();
            break;
        default:
            flush();
            break;
        }
    }
}
