/* The time-of-flight offset of the blue eye, from a wall at a known distance.
 * Needs lumsdk::points. */
#include "lum/points.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define WALL_UM INT64_C(10000000) /* from the eye, by tape measure */
#define FIRST   496u              /* pixel of the first reading */

/* Times of flight of pixels on the wall, taken from a capture. */
static const int32_t readings[] = {5156, 5158, 5157, 5157,
                                   5156, 5159, 5157, 5156};

#define READINGS (sizeof readings / sizeof readings[0])

/* The time to the wall and back, minus the mean of the readings. */
static int64_t find_offset_fs(const lum_calibration *c)
{
    const int64_t wall_fs = 2000000000 * WALL_UM / (int64_t)c->speed_of_light;
    int64_t sum = 0;
    for (size_t i = 0; i < READINGS; i++) {
        sum += readings[i];
    }
    return wall_fs - sum * (int64_t)c->tof_lsb_fs / (int64_t)READINGS;
}

/* A line as an assembler hands it out, here made by hand. */
static void print_ranges(const lum_projector *projector)
{
    static const lum_angle ahead[LUM_LINE_PIXELS];
    static lum_sample_workspace workspace;
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[READINGS];
    lum_return returns[READINGS];
    lum_sample samples[READINGS];
    lum_point_losses losses = {0, 0};
    lum_selection all;
    for (uint32_t i = 0; i < READINGS; i++) {
        words[i] = lum_word_make(readings[i], true, FIRST + i);
    }
    memset(marks, 0xff, sizeof marks);
    const lum_line line = {.angles = ahead,
                           .angle_marks = marks,
                           .angle_count = LUM_LINE_PIXELS,
                           .words = words,
                           .word_count = READINGS,
                           .eye = LUM_EYE_BLUE};
    lum_selection_default(&all);
    workspace.returns = returns;
    const size_t n = lum_samples_compute(projector, &line, &all, &workspace,
                                         samples, &losses);
    for (size_t i = 0; i < n; i++) {
        (void)printf(" %.3f%s", samples[i].range, i + 1 < n ? "" : " m\n");
    }
}

int main(void)
{
    lum_layout layout;
    lum_calibration c;
    lum_projector projector;
    lum_layout_default(&layout);
    lum_calibration_default(&c);
    int64_t *offset_fs = &c.eye[LUM_EYE_BLUE].tof_offset_fs;
    for (unsigned round = 0; round < 2; round++) {
        if (lum_projector_init(&projector, &c, &layout) != LUM_OK) {
            (void)fprintf(stderr, "a value of the calibration is too large\n");
            return 1;
        }
        (void)printf("offset %7" PRId64 " fs:", *offset_fs);
        print_ranges(&projector);
        *offset_fs = find_offset_fs(&c);
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
