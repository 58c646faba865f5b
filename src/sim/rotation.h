/** @file
 * Rotations: Rz(yaw) Ry(pitch) Rx(roll), row by row. */
#ifndef LUM_SIM_ROTATION_H
#define LUM_SIM_ROTATION_H

/** A full turn, radians. */
#define LUM_FULL_TURN 6.28318530717958647692

static inline double lum_radians(double degrees)
{
    return degrees * 3.14159265358979323846 / 180.0;
}

/** Make a rotation of angles in degrees. */
void lum_rotation_make(double roll_deg, double pitch_deg, double yaw_deg,
                       float out[9]);

/** Rotate a vector.
 * @param out not v. */
static inline void lum_rotation_turn(const float m[9], const float v[3],
                                     float out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
    }
}

#endif
