/* Integer projection: any calibration that passes its check, any layout's scale
 * of angles, any angles, marks and words; blocks of any place and size in a
 * line of up to 3 words, words and points ending where their memory ends. */
#include "lum/points_fixed.h"
#include "unknown.h"

#define WORDS 3u

static lum_calibration calibration;
static lum_fixed_projector projector;
static lum_angle angles[LUM_LINE_PIXELS];
static uint32_t marks[LUM_PIXEL_MARK_WORDS];
static uint32_t words[WORDS];
static lum_fixed_point points[WORDS];

static void choose_eye(lum_eye_calibration *e)
{
    const int64_t turn = 360000000;
    e->tof_offset_fs = any_i64(-10000000000, 10000000000);
    e->azimuth_center_udeg = (int32_t)any_i64(-turn / 2, turn / 2);
    e->azimuth_width_udeg = (int32_t)any_i64(1, turn);
    e->elevation_min_udeg = (int32_t)any_i64(-turn / 4, turn / 4);
    e->elevation_max_udeg = (int32_t)any_i64(-turn / 4, turn / 4);
    for (unsigned i = 0; i < 3; i++) {
        e->mount_um[i] = (int32_t)any_i64(-1000000000, 1000000000);
    }
    e->mount_roll_udeg = (int32_t)any_i64(-turn, turn);
    e->mount_pitch_udeg = (int32_t)any_i64(-turn, turn);
    e->mount_yaw_udeg = (int32_t)any_i64(-turn, turn);
}

static void init(void)
{
    lum_layout layout;
    any_bytes(&layout, sizeof layout);
    layout.profile.angle_lsb_pdeg =
        (uint64_t)any_i64(0, (int64_t)LUM_ANGLE_LSB_MAX_PDEG);
    calibration.speed_of_light = any_u32(200000000, 310000000);
    calibration.tof_lsb_fs = any_u32(1, 1000000);
    choose_eye(&calibration.eye[LUM_EYE_BLUE]);
    choose_eye(&calibration.eye[LUM_EYE_GREEN]);
    if (lum_fixed_projector_init(&projector, &calibration, &layout) != LUM_OK) {
        return;
    }
}

static void project(uint32_t n, uint32_t first, uint32_t count)
{
    lum_point_losses losses = {0};
    const lum_line line = {
        .angles = angles,
        .angle_marks = marks,
        .words = words + (WORDS - n),
        .word_count = n,
        .eye = (uint8_t)any_u32(0, LUM_EYES - 1),
    };
    (void)lum_points_fixed_compute(&projector, &line, first, count,
                                   points + (WORDS - count), &losses);
}

void main(void)
{
    init();
    any_bytes(angles, sizeof angles);
    any_bytes(marks, sizeof marks);
    for (unsigned i = 0; i < WORDS; i++) {
        words[i] = any_u32(0, UINT32_MAX);
    }
    const uint32_t n = any_u32(0, WORDS);
    //@ split n;
    const uint32_t first = any_u32(0, WORDS + 1);
    //@ split first;
    const uint32_t count = any_u32(0, WORDS);
    //@ split count;
    project(n, first, count);
}
