/* Datagrams to points on a controller: no heap, no float, no stdio. Here they
 * come from an array; on a controller, from its Ethernet driver. */
#include "lum/assembler.h"
#include "lum/packet.h"
#include "lum/points_fixed.h"

#if __STDC_HOSTED__
#include <inttypes.h>
#include <stdio.h>
#endif

/* Memory: see docs/firmware-reference.md. */
#define OPEN_LINES    2u /* of each eye */
#define REORDER_LINES 8u /* how far packets pass each other */
#define WORDS_PER_LINE                                                         \
    1000u         /* pixels times edges times returns, as you set it */
#define BLOCK 16u /* points projected at a time */

#define MAGIC 0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12

static const uint8_t angles[] = {
    MAGIC, 8,    0,    0, 0, /* a packet of type 8 */
    2,     0,    17,   0,    /* angles, blue eye, line 17 */
    2,     0,    0xf4, 1,    /* 2 samples, from pixel 500 on */
    0x40,  0x42, 0x0f, 0,    /* clock: 1,000,000 us */
    0x00,  0x00, 0x00, 0,    /* azimuth 0, elevation 0 */
    0x42,  0x00, 0x00, 0,    /* azimuth 66, elevation 0 */
};

static const uint8_t ranges[] = {
    MAGIC, 8,    0,    0, 0, /* a packet of type 8 */
    3,     0,    17,   0,    /* ranges, blue eye, line 17 */
    3,     0,    0,    0,    /* 3 samples, from the line's first word on */
    0x40,  0x42, 0x0f, 0,    /* clock: 1,000,000 us */
    0xf4,  0x45, 0xa0, 0,    /* time of flight 2564, rising, pixel 500 */
    0xf4,  0x81, 0xa2, 0,    /* time of flight 2600, falling, pixel 500 */
    0xf5,  0x85, 0x40, 1,    /* time of flight 5128, rising, pixel 501 */
};

static lum_layout layout;
static lum_fixed_projector projector;
static lum_assembler assembler;
static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_PER_LINE)];
static lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
static const lum_assembler_storage storage =
    LUM_ASSEMBLER_STORAGE(slots, words, reach);
static uint32_t points_seen;

/* What the application does with a point. */
static void use_point(const lum_fixed_point *p)
{
    points_seen++;
#if __STDC_HOSTED__
    (void)printf("%" PRId32 " %" PRId32 " %" PRId32 " mm\n",
                 p->x / LUM_FIXED_PER_MM, p->y / LUM_FIXED_PER_MM,
                 p->z / LUM_FIXED_PER_MM);
#else
    (void)p;
#endif
}

static void use_line(const lum_line *line)
{
    lum_point_losses losses = {0, 0};
    lum_fixed_point block[BLOCK];
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        const size_t n = lum_points_fixed_compute(&projector, line, i, BLOCK,
                                                  block, &losses);
        for (size_t k = 0; k < n; k++) {
            /* The end of a pulse is also a point, and usually not wanted. */
            if (lum_word_is_rising(block[k].word)) {
                use_point(&block[k]);
            }
        }
    }
}

static void use_datagram(const uint8_t *bytes, size_t len)
{
    lum_group group;
    lum_result r;
    if (lum_packet_decode(&layout, bytes, len, &group) != LUM_PACKET_DATA) {
        return;
    }
    while ((r = lum_assembler_push(&assembler, &group, 0)) > 0) {
        if (r == LUM_LINE_READY) {
            use_line(lum_assembler_line(&assembler));
        }
    }
}

static lum_result begin(void)
{
    lum_calibration calibration;
    lum_assembler_config config;
    lum_calibration_default(&calibration);
    lum_layout_default(&layout);
    lum_assembler_config_default(&config);
    config.open_lines = OPEN_LINES;
    config.reorder_lines = REORDER_LINES;
    config.words_per_line = WORDS_PER_LINE;
    if (lum_fixed_projector_init(&projector, &calibration, &layout) != LUM_OK) {
        return LUM_E_VALUE;
    }
    return lum_assembler_init(&assembler, &config, &layout, &storage);
}

int main(void)
{
    lum_result r;
    if (begin() != LUM_OK) {
        return 1;
    }
    use_datagram(angles, sizeof angles);
    use_datagram(ranges, sizeof ranges);
    /* A controller never flushes: the next lines close this one. */
    while ((r = lum_assembler_flush(&assembler)) > 0) {
        if (r == LUM_LINE_READY) {
            use_line(lum_assembler_line(&assembler));
        }
    }
    return points_seen == 2u ? 0 : 1;
}
