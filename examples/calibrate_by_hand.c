/* The time-of-flight offset of the blue eye, from a wall at a known distance.
 * Needs lumsdk::points. */
#include "lum/points.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define WALL_UM INT64_C(10000000) /* from the eye, by tape measure */
#define FIRST   496u              /* pixel of the first reading */

/* Times of flight of pixels that look at the wall, taken from a capture. */
static const int32_t readings[] = {5156, 5158, 5157, 5157,
                                   5156, 5159, 5157, 5156};

#define READINGS (sizeof readings / sizeof readings[0])

/* What has to be added to the readings: the time to the wall and back, less
 * their mean. */
static int64_t find_offset_fs(const lum_calibration *c)
{
    const int64_t wall_fs =
        2 * WALL_UM * 1000000000 / (int64_t)c->speed_of_light;
    int64_t sum = 0;
    for (size_t i = 0; i < READINGS; i++) {
        sum += readings[i];
    }
    return wall_fs - sum * (int64_t)c->tof_lsb_fs / (int64_t)READINGS;
}

/* A line as an assembler hands it out: here made by hand. */
static int print_ranges(const char *title, const lum_calibration *c)
{
    static const int16_t ahead[LUM_LINE_PIXELS];
    static lum_sample_workspace workspace;
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[READINGS];
    lum_return returns[READINGS];
    lum_sample samples[READINGS];
    lum_point_losses losses = {0, 0};
    lum_selection all;
    lum_layout layout;
    lum_projector projector;
    lum_layout_default(&layout);
    lum_selection_default(&all);
    if (lum_projector_init(&projector, c, &layout) != LUM_OK) {
        (void)fprintf(stderr, "%s: a value is out of range\n", title);
        return -1;
    }
    for (uint32_t i = 0; i < READINGS; i++) {
        words[i] = lum_word_make(readings[i], true, FIRST + i);
    }
    memset(marks, 0xff, sizeof marks);
    workspace.returns = returns;
    const lum_line line = {.azimuth = ahead,
                           .elevation = ahead,
                           .angle_marks = marks,
                           .angle_count = LUM_LINE_PIXELS,
                           .words = words,
                           .word_count = READINGS,
                           .eye = LUM_EYE_BLUE};
    const size_t n = lum_samples_compute(&projector, &line, &all, &workspace,
                                         samples, &losses);
    (void)printf("%s:", title);
    for (size_t i = 0; i < n; i++) {
        (void)printf(" %.3f", (double)samples[i].range);
    }
    (void)printf(" m\n");
    return 0;
}

int main(void)
{
    lum_calibration c;
    lum_calibration_default(&c);
    if (print_ranges("before", &c) != 0) {
        return 1;
    }
    const int64_t offset_fs = find_offset_fs(&c);
    c.eye[LUM_EYE_BLUE].tof_offset_fs = offset_fs;
    (void)printf("offset: %" PRId64 " fs\n", offset_fs);
    if (print_ranges("after", &c) != 0) {
        return 1;
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
