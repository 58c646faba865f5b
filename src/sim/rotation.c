#include "rotation.h"

#include <math.h>

void lum_rotation_make(double roll_deg, double pitch_deg, double yaw_deg,
                       float out[9])
{
    const double cr = cos(lum_radians(roll_deg));
    const double sr = sin(lum_radians(roll_deg));
    const double cp = cos(lum_radians(pitch_deg));
    const double sp = sin(lum_radians(pitch_deg));
    const double cy = cos(lum_radians(yaw_deg));
    const double sy = sin(lum_radians(yaw_deg));
    const double m[9] = {cy * cp,
                         cy * sp * sr - sy * cr,
                         cy * sp * cr + sy * sr,
                         sy * cp,
                         sy * sp * sr + cy * cr,
                         sy * sp * cr - cy * sr,
                         -sp,
                         cp * sr,
                         cp * cr};
    for (int i = 0; i < 9; i++) {
        out[i] = (float)m[i];
    }
}
