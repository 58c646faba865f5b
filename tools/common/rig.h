/** @file
 * Sensors of a rig as what frames take. */
#ifndef LUM_TOOLS_RIG_H
#define LUM_TOOLS_RIG_H

#include "lum/host/rig.h"
#include "lum/pose.h"

/** Where a sensor is on the vehicle. */
static inline lum_pose rig_pose(const lum_rig_sensor *sensor)
{
    const double at[3] = {sensor->at_um[0] * 1e-6, sensor->at_um[1] * 1e-6,
                          sensor->at_um[2] * 1e-6};
    return lum_pose_of_angles(at, sensor->roll_udeg * 1e-6,
                              sensor->pitch_udeg * 1e-6,
                              sensor->yaw_udeg * 1e-6);
}

#endif
