/* Two datagrams of one line, as the sensor sends them, to angles and ranges.
 * Needs only lumsdk::core, and no floating point. */
#include "lum/calibration.h"
#include "lum/packet.h"

#include <inttypes.h>
#include <stdio.h>

#define MAGIC      0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12
#define HALF_SCALE 32768

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
    2,     0,    0,    0,    /* 2 samples, from the line's first word on */
    0x40,  0x42, 0x0f, 0,    /* clock: 1,000,000 us */
    0xf4,  0x45, 0xa0, 0,    /* time of flight 2564, rising, pixel 500 */
    0xf5,  0x85, 0x40, 1,    /* time of flight 5128, rising, pixel 501 */
};

static int64_t scale(int64_t raw, int64_t span_udeg)
{
    return raw * (span_udeg / 2) / HALF_SCALE;
}

static void print_angle(const lum_eye_calibration *eye, lum_angle a)
{
    const int64_t min = eye->elevation_min_udeg;
    const int64_t max = eye->elevation_max_udeg;
    (void)printf("  azimuth %" PRId64 ", elevation %" PRId64 " microdegrees\n",
                 eye->azimuth_center_udeg +
                     scale(a.azimuth, eye->azimuth_width_udeg),
                 (min + max) / 2 + scale(a.elevation, max - min));
}

static void print_word(const lum_calibration *c, uint32_t word)
{
    const int64_t fs = lum_word_tof(word) * (int64_t)c->tof_lsb_fs;
    (void)printf("  pixel %" PRIu32 ": range %" PRId64 " um, %s edge\n",
                 lum_word_pixel(word),
                 fs * (int64_t)c->speed_of_light / 2000000000,
                 lum_word_is_rising(word) ? "rising" : "falling");
}

static int decode(const uint8_t *bytes, size_t len)
{
    lum_calibration c;
    lum_layout layout;
    lum_group g;
    lum_calibration_default(&c);
    lum_layout_default(&layout);
    if (lum_packet_decode(&layout, bytes, len, &g) != LUM_PACKET_DATA) {
        (void)fprintf(stderr, "not a data packet\n");
        return -1;
    }
    (void)printf("eye %d, line %" PRIu32 ", from %" PRIu32 " on:\n", g.eye,
                 g.line, g.first_sample_index);
    for (uint32_t i = 0; i < g.num_samples; i++) {
        if (g.tag == LUM_TAG_ANGLES) {
            print_angle(&c.eye[g.eye], lum_group_angle(&layout, &g, i));
        } else {
            print_word(&c, lum_group_word(&g, i));
        }
    }
    return fflush(stdout);
}

int main(void)
{
    const int failed = decode(angles, sizeof angles) != 0 ||
                       decode(ranges, sizeof ranges) != 0;
    return failed ? 1 : 0;
}
