/** @file
 * What tools make of the sensors of a rig. */
#ifndef LUM_TOOLS_RIG_SENSORS_H
#define LUM_TOOLS_RIG_SENSORS_H

#include "lum/host/rig.h"
#include "lum/pose.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Where a sensor is on the vehicle. */
static inline lum_pose rig_pose(const lum_rig_sensor *sensor)
{
    const double at[3] = {sensor->at_um[0] * 1e-6, sensor->at_um[1] * 1e-6,
                          sensor->at_um[2] * 1e-6};
    return lum_pose_of_angles(at, sensor->roll_udeg * 1e-6,
                              sensor->pitch_udeg * 1e-6,
                              sensor->yaw_udeg * 1e-6);
}

/** The name of a sensor's file: `name` has a %s, in place of which the sensor's
 * name stands. To be freed; NULL: there is no memory. */
static inline char *rig_file_name(const char *name, const char *sensor)
{
    const char *at = strstr(name, "%s");
    const size_t room = strlen(name) + strlen(sensor);
    char *out = malloc(room);
    if (out != NULL) {
        (void)snprintf(out, room, "%.*s%s%s", (int)(at - name), name, sensor,
                       at + 2);
    }
    return out;
}

#endif
