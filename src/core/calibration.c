#include "lum/calibration.h"

#include "lum/group.h"

#include <stdbool.h>
#include <stddef.h>

#define DEGREE 1000000

static const lum_eye_calibration typical = {
    .tof_offset_fs = 0,
    .azimuth_center_udeg = 0,
    .azimuth_width_udeg = 60 * DEGREE,
    .elevation_min_udeg = -17 * DEGREE,
    .elevation_max_udeg = 3 * DEGREE,
};

void lum_calibration_default(lum_calibration *out)
{
    out->speed_of_light = 300000000u;
    out->tof_lsb_fs = 13000u;
    out->eye[LUM_EYE_BLUE] = typical;
    out->eye[LUM_EYE_GREEN] = typical;
    out->eye[LUM_EYE_BLUE].mount_yaw_udeg = -30 * DEGREE;
    out->eye[LUM_EYE_GREEN].mount_yaw_udeg = 30 * DEGREE;
}

static bool is_within(int64_t value, int64_t min, int64_t max)
{
    return value >= min && value <= max;
}

static lum_calibration_fault check_eye(const lum_eye_calibration *e)
{
    const int64_t turn = 360 * (int64_t)DEGREE;
    const int64_t km_um = 1000 * (int64_t)1000000;
    const int64_t ten_us_fs = INT64_C(10000000000);
    const struct {
        lum_calibration_fault fault;
        int64_t value;
        int64_t min;
        int64_t max;
    } rows[] = {
        {LUM_CALIBRATION_TOF_OFFSET, e->tof_offset_fs, -ten_us_fs, ten_us_fs},
        {LUM_CALIBRATION_AZIMUTH_CENTER, e->azimuth_center_udeg, -turn / 2,
         turn / 2},
        {LUM_CALIBRATION_AZIMUTH_WIDTH, e->azimuth_width_udeg, 1, turn},
        {LUM_CALIBRATION_ELEVATION_MIN, e->elevation_min_udeg, -turn / 4,
         turn / 4},
        {LUM_CALIBRATION_ELEVATION_MAX, e->elevation_max_udeg, -turn / 4,
         turn / 4},
        {LUM_CALIBRATION_ELEVATION_ORDER, e->elevation_max_udeg,
         e->elevation_min_udeg + (int64_t)1, turn},
        {LUM_CALIBRATION_MOUNT_X, e->mount_um[0], -km_um, km_um},
        {LUM_CALIBRATION_MOUNT_Y, e->mount_um[1], -km_um, km_um},
        {LUM_CALIBRATION_MOUNT_Z, e->mount_um[2], -km_um, km_um},
        {LUM_CALIBRATION_MOUNT_ROLL, e->mount_roll_udeg, -turn, turn},
        {LUM_CALIBRATION_MOUNT_PITCH, e->mount_pitch_udeg, -turn, turn},
        {LUM_CALIBRATION_MOUNT_YAW, e->mount_yaw_udeg, -turn, turn},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (!is_within(rows[i].value, rows[i].min, rows[i].max)) {
            return rows[i].fault;
        }
    }
    return LUM_CALIBRATION_FINE;
}

static lum_calibration_fault find_fault(const lum_calibration *c, unsigned *eye)
{
    *eye = 0;
    if (!is_within(c->speed_of_light, 200000000, 310000000)) {
        return LUM_CALIBRATION_SPEED_OF_LIGHT;
    }
    if (!is_within(c->tof_lsb_fs, 1, 1000000)) {
        return LUM_CALIBRATION_TOF_LSB;
    }
    for (unsigned i = 0; i < LUM_EYES; i++) {
        const lum_calibration_fault fault = check_eye(&c->eye[i]);
        if (fault != LUM_CALIBRATION_FINE) {
            *eye = i;
            return fault;
        }
    }
    return LUM_CALIBRATION_FINE;
}

lum_result lum_calibration_check(const lum_calibration *calibration,
                                 lum_calibration_fault *fault, unsigned *eye)
{
    unsigned where = 0;
    const lum_calibration_fault found = find_fault(calibration, &where);
    if (fault != NULL) {
        *fault = found;
    }
    if (eye != NULL) {
        *eye = where;
    }
    return found == LUM_CALIBRATION_FINE ? LUM_OK : LUM_E_VALUE;
}

int32_t lum_calibration_min_tof(const lum_calibration *calibration,
                                unsigned eye)
{
    const int64_t lsb = calibration->tof_lsb_fs;
    const int64_t offset = calibration->eye[eye].tof_offset_fs;
    /* the smallest t with t x lsb > -offset: floor(-offset / lsb) + 1 */
    int64_t t = -offset / lsb;
    if (-offset % lsb < 0) {
        t--;
    }
    t++;
    if (t < LUM_TOF_MIN) {
        return LUM_TOF_MIN;
    }
    return t > LUM_TOF_MAX ? LUM_TOF_MAX + 1 : (int32_t)t;
}
