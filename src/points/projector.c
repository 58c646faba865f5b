/* A calibration and a layout, checked and made ready for projection. */
#include "lum/points.h"

#include <math.h>
#include <string.h>

#define PI          3.14159265358979323846
#define RAD(degree) ((degree) * (PI / 180.0))
#define HALF_SCALE  32768.0

/* Where the polynomials of directions.c end. */
#define NARROW_RAD RAD(45.0)

static double degrees(int32_t udeg)
{
    return (double)udeg * 1e-6;
}

static void set_angles(lum_eye_projector *out, const lum_eye_calibration *eye,
                       uint64_t angle_lsb_pdeg)
{
    const double min = degrees(eye->elevation_min_udeg);
    const double max = degrees(eye->elevation_max_udeg);
    out->azimuth_center = degrees(eye->azimuth_center_udeg);
    out->elevation_center = (min + max) / 2.0;
    if (angle_lsb_pdeg != 0) {
        out->azimuth_deg = (double)angle_lsb_pdeg * 1e-12;
        out->elevation_deg = out->azimuth_deg;
    } else {
        out->azimuth_deg = degrees(eye->azimuth_width_udeg) / 2.0 / HALF_SCALE;
        out->elevation_deg = (max - min) / 2.0 / HALF_SCALE;
    }
    out->azimuth_rad = RAD(out->azimuth_deg);
    out->elevation_rad = RAD(out->elevation_deg);
    out->narrow = out->azimuth_rad * HALF_SCALE <= NARROW_RAD &&
                  out->elevation_rad * HALF_SCALE <= NARROW_RAD;
    out->center_sin = (float)sin(RAD(out->elevation_center));
    out->center_cos = (float)cos(RAD(out->elevation_center));
}

/* Rz(yaw) Ry(pitch) Rx(roll) Rz(azimuth's centre): the scan is computed about
 * its centre, where the angles are small. */
static void set_rotation(lum_eye_projector *out, const lum_eye_calibration *eye)
{
    const double roll = RAD(degrees(eye->mount_roll_udeg));
    const double pitch = RAD(degrees(eye->mount_pitch_udeg));
    const double yaw = RAD(degrees(eye->mount_yaw_udeg));
    const double cr = cos(roll), sr = sin(roll);
    const double cp = cos(pitch), sp = sin(pitch);
    const double cy = cos(yaw), sy = sin(yaw);
    const double mount[9] = {
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    };
    const double ca = cos(RAD(out->azimuth_center));
    const double sa = sin(RAD(out->azimuth_center));
    for (unsigned row = 0; row < 3; row++) {
        const double *m = &mount[3u * row];
        out->exact_rotation[3u * row] = m[0] * ca + m[1] * sa;
        out->exact_rotation[3u * row + 1u] = m[1] * ca - m[0] * sa;
        out->exact_rotation[3u * row + 2u] = m[2];
        out->exact_mount[row] = (double)eye->mount_um[row] * 1e-6;
    }
}

/* The floats that points are made with. */
static void set_floats(lum_eye_projector *out)
{
    for (unsigned i = 0; i < 9; i++) {
        out->rotation[i] = (float)out->exact_rotation[i];
    }
    for (unsigned row = 0; row < 3; row++) {
        out->mount[row] = (float)out->exact_mount[row];
    }
}

static void set_range(lum_eye_projector *out, const lum_calibration *c,
                      unsigned eye)
{
    const double metres_per_fs = (double)c->speed_of_light * 1e-15 / 2.0;
    out->range_lsb = (double)c->tof_lsb_fs * metres_per_fs;
    out->range_offset = (double)c->eye[eye].tof_offset_fs * metres_per_fs;
    out->min_tof = lum_calibration_min_tof(c, eye);
}

lum_result lum_projector_init(lum_projector *out,
                              const lum_calibration *calibration,
                              const lum_layout *layout)
{
    const lum_result r = lum_calibration_check(calibration, NULL, NULL);
    if (r != LUM_OK) {
        return r;
    }
    for (unsigned e = 0; e < LUM_EYES; e++) {
        set_angles(&out->eye[e], &calibration->eye[e],
                   layout->profile.angle_lsb_pdeg);
        set_rotation(&out->eye[e], &calibration->eye[e]);
        set_floats(&out->eye[e]);
        set_range(&out->eye[e], calibration, e);
    }
    out->tof_lsb_ns = (double)calibration->tof_lsb_fs * 1e-6;
    return LUM_OK;
}

static void place_eye(lum_eye_projector *eye, const lum_pose *pose)
{
    double turn[12]; /* 3 rows of 4 */
    double rotation[9];
    lum_pose_matrix(pose, turn);
    for (unsigned i = 0; i < 9; i++) {
        const double *row = &turn[4u * (i / 3u)];
        const double *column = &eye->exact_rotation[i % 3u];
        rotation[i] =
            row[0] * column[0] + row[1] * column[3] + row[2] * column[6];
    }
    memcpy(eye->exact_rotation, rotation, sizeof rotation);
    lum_pose_apply(pose, eye->exact_mount, eye->exact_mount);
    set_floats(eye);
}

void lum_projector_place(lum_projector *projector, const lum_pose *pose)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        place_eye(&projector->eye[e], pose);
    }
}
