/** @file
 * The values that turn samples of one sensor into geometry, in integer units
 * (docs/protocol.md, section 7). */
#ifndef LUM_CALIBRATION_H
#define LUM_CALIBRATION_H

#include "lum/profile.h"
#include "lum/result.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Calibration of one eye. Angles in microdegrees, lengths in micrometres,
 * times in femtoseconds. */
typedef struct lum_eye_calibration {
    int64_t tof_offset_fs;       /**< added to each time of flight; within
                                      +-10^10 (10 us) */
    int32_t azimuth_center_udeg; /**< -180..180 degrees */
    int32_t azimuth_width_udeg;  /**< above 0, at most 360 degrees */
    int32_t elevation_min_udeg;  /**< -90..90 degrees */
    int32_t elevation_max_udeg;  /**< above min, at most 90 degrees */
    int32_t mount_um[3];         /**< x, y, z; within +-1 km */
    int32_t mount_roll_udeg;     /**< about x; -360..360 degrees */
    int32_t mount_pitch_udeg;    /**< about y; -360..360 degrees */
    int32_t mount_yaw_udeg;      /**< about z; -360..360 degrees */
} lum_eye_calibration;

/** Calibration of a sensor. */
typedef struct lum_calibration {
    uint32_t speed_of_light;           /**< m/s, 200,000,000..310,000,000 */
    uint32_t tof_lsb_fs;               /**< 1..1,000,000 (1 ns) */
    lum_eye_calibration eye[LUM_EYES]; /**< by ::lum_eye */
} lum_calibration;

/** Which value of a calibration is out of range. */
typedef enum lum_calibration_fault {
    LUM_CALIBRATION_FINE,            /**< none */
    LUM_CALIBRATION_SPEED_OF_LIGHT,  /**< speed_of_light */
    LUM_CALIBRATION_TOF_LSB,         /**< tof_lsb_fs */
    LUM_CALIBRATION_TOF_OFFSET,      /**< tof_offset_fs */
    LUM_CALIBRATION_AZIMUTH_CENTER,  /**< azimuth_center_udeg */
    LUM_CALIBRATION_AZIMUTH_WIDTH,   /**< azimuth_width_udeg */
    LUM_CALIBRATION_ELEVATION_MIN,   /**< elevation_min_udeg */
    LUM_CALIBRATION_ELEVATION_MAX,   /**< elevation_max_udeg */
    LUM_CALIBRATION_ELEVATION_ORDER, /**< min is not below max */
    LUM_CALIBRATION_MOUNT_X,         /**< mount_um[0] */
    LUM_CALIBRATION_MOUNT_Y,         /**< mount_um[1] */
    LUM_CALIBRATION_MOUNT_Z,         /**< mount_um[2] */
    LUM_CALIBRATION_MOUNT_ROLL,      /**< mount_roll_udeg */
    LUM_CALIBRATION_MOUNT_PITCH,     /**< mount_pitch_udeg */
    LUM_CALIBRATION_MOUNT_YAW        /**< mount_yaw_udeg */
} lum_calibration_fault;

/** The manual's typical values: 60 degrees wide, from -17 to 3 degrees, 13 ps,
 * 3.0e8 m/s; yaw -30 degrees for blue, 30 for green. Cannot fail.
 * @param out caller-owned, overwritten. */
void lum_calibration_default(lum_calibration *out);

/** Check a calibration's ranges.
 * @param fault may be NULL; gets what is wrong, or LUM_CALIBRATION_FINE.
 * @param eye   may be NULL; gets the eye concerned, 0 if none is.
 * @return LUM_OK, or LUM_E_VALUE with the first fault. Reentrant. */
LUM_MUST_CHECK lum_result
lum_calibration_check(const lum_calibration *calibration,
                      lum_calibration_fault *fault, unsigned *eye);

/** Smallest time of flight, in units of the lsb, that gives a range above zero;
 * words below it give no point.
 * @param calibration checked.
 * @param eye         an ::lum_eye.
 * @return LUM_TOF_MIN..LUM_TOF_MAX + 1. */
int32_t lum_calibration_min_tof(const lum_calibration *calibration,
                                unsigned eye);

#ifdef __cplusplus
}
#endif

#endif
