#include "lum/calibration.h"

#include "lum/group.h"
#include "product.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#define DEGREE    1000000
#define STEP      10000000 /* microdegrees or micrometres */
#define TEN_US_FS UINT64_C(10000000000)

void lum_calibration_default(lum_calibration *out)
{
    memset(out, 0, sizeof *out);
    out->speed_of_light = 300000000u;
    out->tof_lsb_fs = 13000u;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        lum_eye_calibration *e = &out->eye[i];
        e->azimuth_width_udeg = 60 * DEGREE;
        e->elevation_min_udeg = -17 * DEGREE;
        e->elevation_max_udeg = 3 * DEGREE;
        e->mount_yaw_udeg = i == LUM_EYE_BLUE ? -30 * DEGREE : 30 * DEGREE;
    }
}

/* A value's limit either way in steps of 10 degrees, or of 10 metres. */
struct limit {
    uint8_t at;
    uint8_t steps;
};

#define FIRST LUM_CALIBRATION_AZIMUTH_CENTER
#define LIMIT(fault, field, steps)                                             \
    [LUM_CALIBRATION_##fault -                                                 \
        FIRST] = {offsetof(lum_eye_calibration, field), steps}

static const struct limit limits[] = {
    LIMIT(AZIMUTH_CENTER, azimuth_center_udeg, 18),
    LIMIT(AZIMUTH_WIDTH, azimuth_width_udeg, 36),
    LIMIT(ELEVATION_MIN, elevation_min_udeg, 9),
    LIMIT(ELEVATION_MAX, elevation_max_udeg, 9),
    LIMIT(ELEVATION_ORDER, elevation_max_udeg, 9),
    LIMIT(MOUNT_X, mount_um[0], 100),
    LIMIT(MOUNT_Y, mount_um[1], 100),
    LIMIT(MOUNT_Z, mount_um[2], 100),
    LIMIT(MOUNT_ROLL, mount_roll_udeg, 36),
    LIMIT(MOUNT_PITCH, mount_pitch_udeg, 36),
    LIMIT(MOUNT_YAW, mount_yaw_udeg, 36),
};

static bool is_within(const lum_eye_calibration *e, unsigned fault)
{
    const struct limit *limit = &limits[fault - FIRST];
    const void *field = (const uint8_t *)e + limit->at;
    const int32_t value = *(const int32_t *)field;
    const int32_t max = limit->steps * STEP;
    if (fault == LUM_CALIBRATION_AZIMUTH_WIDTH && value < 1) {
        return false;
    }
    if (fault == LUM_CALIBRATION_ELEVATION_ORDER &&
        value <= e->elevation_min_udeg) {
        return false;
    }
    return value >= -max && value <= max;
}

static unsigned check_eye(const lum_eye_calibration *e)
{
    if ((uint64_t)e->tof_offset_fs + TEN_US_FS > 2 * TEN_US_FS) {
        return LUM_CALIBRATION_TOF_OFFSET;
    }
    for (unsigned fault = FIRST; fault <= LUM_CALIBRATION_MOUNT_YAW; fault++) {
        if (!is_within(e, fault)) {
            return fault;
        }
    }
    return LUM_CALIBRATION_FINE;
}

/* The fault, and above it the eye. */
static LUM_ONE_COPY unsigned find_fault(const lum_calibration *c)
{
    if (c->speed_of_light - 200000000u > 110000000u) {
        return LUM_CALIBRATION_SPEED_OF_LIGHT;
    }
    if (c->tof_lsb_fs - 1u >= 1000000u) {
        return LUM_CALIBRATION_TOF_LSB;
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const unsigned fault = check_eye(&c->eye[eye]);
        if (fault != LUM_CALIBRATION_FINE) {
            return fault | eye << 8;
        }
    }
    return LUM_CALIBRATION_FINE;
}

lum_result lum_calibration_check(const lum_calibration *calibration,
                                 lum_calibration_fault *fault, unsigned *eye)
{
    const unsigned found = find_fault(calibration);
    if (fault != NULL) {
        *fault = (lum_calibration_fault)(found & 0xffu);
    }
    if (eye != NULL) {
        *eye = found >> 8;
    }
    return found == LUM_CALIBRATION_FINE ? LUM_OK : LUM_E_VALUE;
}

/* By halves: a division of 64 bits is a big routine on small targets. */
int32_t lum_calibration_min_tof(const lum_calibration *calibration,
                                unsigned eye)
{
    const int64_t offset_fs = calibration->eye[eye].tof_offset_fs;
    const int32_t lsb_fs = (int32_t)calibration->tof_lsb_fs;
    uint32_t low = 0;
    uint32_t high = LUM_TOF_MAX + 1 - LUM_TOF_MIN;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        const int32_t tof = (int32_t)middle + LUM_TOF_MIN;
        if (product(tof, lsb_fs) + offset_fs > 0) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return (int32_t)low + LUM_TOF_MIN;
}
