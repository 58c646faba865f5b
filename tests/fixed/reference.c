#include "reference.h"

#include "lum/group.h"

#include <math.h>
#include <string.h>

#define PI         3.14159265358979323846
#define HALF_SCALE 32768

static double radians(double degrees)
{
    return degrees * (PI / 180.0);
}

static void fill(wave out[RAW_VALUES], double center_deg, double full_deg,
                 uint64_t lsb_pdeg)
{
    const double bit_deg =
        lsb_pdeg != 0 ? (double)lsb_pdeg * 1e-12 : full_deg / HALF_SCALE;
    for (int raw = -HALF_SCALE; raw < HALF_SCALE; raw++) {
        const double angle = radians(center_deg + raw * bit_deg);
        out[raw + HALF_SCALE] = (wave){sin(angle), cos(angle)};
    }
}

/* out = a b; out is neither. */
static void multiply(const double a[9], const double b[9], double out[9])
{
    for (unsigned i = 0; i < 9; i++) {
        const double *row = &a[i / 3u * 3u];
        const double *column = &b[i % 3u];
        out[i] = row[0] * column[0] + row[1] * column[3] + row[2] * column[6];
    }
}

/* Rz(yaw) Ry(pitch) Rx(roll) */
static void rotate(const lum_eye_calibration *e, double out[9])
{
    const double roll = radians(e->mount_roll_udeg * 1e-6);
    const double pitch = radians(e->mount_pitch_udeg * 1e-6);
    const double yaw = radians(e->mount_yaw_udeg * 1e-6);
    const double x[9] = {1,          0, 0,         0,        cos(roll),
                         -sin(roll), 0, sin(roll), cos(roll)};
    const double y[9] = {cos(pitch), 0,           sin(pitch), 0,         1,
                         0,          -sin(pitch), 0,          cos(pitch)};
    const double z[9] = {cos(yaw), -sin(yaw), 0, sin(yaw), cos(yaw),
                         0,        0,         0, 1};
    double zy[9];
    multiply(z, y, zy);
    multiply(zy, x, out);
}

void reference_init(reference *out, const lum_calibration *calibration,
                    unsigned eye, uint64_t angle_lsb_pdeg)
{
    const lum_eye_calibration *e = &calibration->eye[eye];
    const double min = e->elevation_min_udeg * 1e-6;
    const double max = e->elevation_max_udeg * 1e-6;
    fill(out->azimuth, e->azimuth_center_udeg * 1e-6,
         e->azimuth_width_udeg * 1e-6 / 2.0, angle_lsb_pdeg);
    fill(out->elevation, (min + max) / 2.0, (max - min) / 2.0, angle_lsb_pdeg);
    rotate(e, out->rotation);
    for (unsigned i = 0; i < 3; i++) {
        out->mount_mm[i] = e->mount_um[i] * 1e-3;
    }
    out->lsb_fs = calibration->tof_lsb_fs;
    out->offset_fs = e->tof_offset_fs;
    out->mm_per_fs = calibration->speed_of_light * 1e3 * 1e-15 / 2.0;
}

bool reference_has_range(const reference *r, int32_t tof)
{
    return tof * r->lsb_fs + r->offset_fs > 0;
}

double reference_range_mm(const reference *r, int32_t tof)
{
    return (double)(tof * r->lsb_fs + r->offset_fs) * r->mm_per_fs;
}

bool reference_reach(const reference *r, double range_mm, int32_t *nearest,
                     int32_t *farthest)
{
    int32_t low = LUM_TOF_MIN;
    int32_t high = LUM_TOF_MAX;
    while (low <= LUM_TOF_MAX && !reference_has_range(r, low)) {
        low++;
    }
    while (high >= low && reference_range_mm(r, high) > range_mm) {
        high--;
    }
    *nearest = low;
    *farthest = high;
    return low <= high;
}

void reference_point_mm(const reference *r, int32_t tof, int32_t azimuth,
                        int32_t elevation, double out[3])
{
    const double range = reference_range_mm(r, tof);
    const wave az = r->azimuth[azimuth + HALF_SCALE];
    const wave el = r->elevation[elevation + HALF_SCALE];
    const double x = range * el.cosine * az.cosine;
    const double y = range * el.cosine * az.sine;
    const double z = range * el.sine;
    for (unsigned i = 0; i < 3; i++) {
        const double *m = &r->rotation[3u * i];
        out[i] = m[0] * x + m[1] * y + m[2] * z + r->mount_mm[i];
    }
}
