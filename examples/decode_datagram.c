/* Two datagrams of one line, as the sensor sends them, to angles and ranges.
 * Needs lumsdk::core alone, and no floating point. */
#include "lum/calibration.h"
#include "lum/packet.h"

#include <inttypes.h>
#include <stdio.h>

#define HALF_SCALE 32768

static const uint8_t angles[] = {
    0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, /* magic */
    8,    0,    0,    0,                            /* packet type */
    2,    0,    17,   0, /* angles, blue eye, line 17 */
    2,    0,    0xf4, 1, /* 2 samples, pixel 500 on */
    0x40, 0x42, 0x0f, 0, /* clock: 1,000,000 us */
    0x00, 0x00, 0x00, 0, /* azimuth 0, elevation 0 */
    0x42, 0x00, 0x00, 0, /* azimuth 66, elevation 0 */
};

static const uint8_t ranges[] = {
    0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, /* magic */
    8,    0,    0,    0,                            /* packet type */
    3,    0,    17,   0, /* ranges, blue eye, line 17 */
    2,    0,    0,    0, /* 2 samples, the line's words 0 on */
    0x40, 0x42, 0x0f, 0, /* clock: 1,000,000 us */
    0xf4, 0x45, 0xa0, 0, /* tof 2564, rising, pixel 500 */
    0xf5, 0x85, 0x40, 1, /* tof 5128, rising, pixel 501 */
};

static int64_t scale(int16_t raw, int64_t span_udeg)
{
    return raw * (span_udeg / 2) / HALF_SCALE;
}

static void print_angle(const lum_eye_calibration *eye, uint32_t pixel,
                        lum_angle a)
{
    const int64_t min = eye->elevation_min_udeg;
    const int64_t max = eye->elevation_max_udeg;
    const int64_t azimuth =
        eye->azimuth_center_udeg + scale(a.azimuth, eye->azimuth_width_udeg);
    const int64_t elevation = (min + max) / 2 + scale(a.elevation, max - min);
    (void)printf("  pixel %" PRIu32 ": azimuth %" PRId64
                 " udeg, elevation %" PRId64 " udeg\n",
                 pixel, azimuth, elevation);
}

static void print_word(const lum_calibration *c, uint32_t word)
{
    /* fs x m/s is 1e-15 m; half of it, in um */
    const int64_t fs = lum_word_tof(word) * (int64_t)c->tof_lsb_fs;
    const int64_t range_um = fs * (c->speed_of_light / 1000) / 2000000;
    (void)printf("  pixel %" PRIu32 ": range %" PRId64 " um, %s edge\n",
                 lum_word_pixel(word), range_um,
                 lum_word_is_rising(word) ? "rising" : "falling");
}

static int decode(const lum_layout *layout, const void *bytes, size_t len)
{
    lum_calibration c;
    lum_group g;
    if (lum_packet_decode(layout, bytes, len, &g) != LUM_PACKET_DATA) {
        (void)fprintf(stderr, "not a data packet\n");
        return -1;
    }
    lum_calibration_default(&c);
    (void)printf("%s eye, line %" PRIu32 ", %" PRIu32 " samples\n",
                 g.eye == LUM_EYE_BLUE ? "blue" : "green", g.line,
                 g.num_samples);
    for (uint32_t i = 0; i < g.num_samples; i++) {
        if (g.tag == LUM_TAG_ANGLES) {
            print_angle(&c.eye[g.eye], g.first_sample_index + i,
                        lum_group_angle(layout, &g, i));
        } else {
            print_word(&c, lum_group_word(&g, i));
        }
    }
    return 0;
}

int main(void)
{
    lum_layout layout;
    lum_layout_default(&layout);
    if (decode(&layout, angles, sizeof angles) != 0 ||
        decode(&layout, ranges, sizeof ranges) != 0) {
        return 1;
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
