/** @file
 * The keys of a rig and of its sensors, and what their texts may be. Internal
 * to host and config. */
#ifndef LUM_HOST_RIG_KEYS_H
#define LUM_HOST_RIG_KEYS_H

#include "key_table.h"

/** The values of a rig's file in order, then those of a sensor. */
enum lum_rig_value {
    LUM_RIG_VERSION,
    LUM_RIG_FRAME,
    LUM_RIG_SENSORS,
    LUM_RIG_FILE_VALUES,
    LUM_RIG_NAME = 0,
    LUM_RIG_ADDRESS,
    LUM_RIG_INTERFACE,
    LUM_RIG_CALIBRATION,
    LUM_RIG_PROFILE,
    LUM_RIG_X,
    LUM_RIG_Y,
    LUM_RIG_Z,
    LUM_RIG_ROLL,
    LUM_RIG_PITCH,
    LUM_RIG_YAW,
    LUM_RIG_SENSOR_VALUES
};

extern const lum_key_table lum_rig_keys;
extern const lum_key_table lum_rig_sensor_keys;

/** Take an address that was checked.
 * @return where its interface begins; text + len: it names none. */
const char *lum_rig_take_address(const char *text, size_t len, uint32_t *out);

#endif
