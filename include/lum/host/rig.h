/** @file
 * A rig: the sensors of a vehicle, by name, address and place. Set key by key
 * as texts, for YAML files, command lines and other languages (docs/formats.md
 * has the keys).
 *
 * @code
 * lum_rig rig;
 * lum_rig_init(&rig);
 * if (lum_rig_set_sensor(&rig, 0, "name", "front", &why) != LUM_OK ||
 *     lum_rig_set_sensor(&rig, 0, "address", "10.42.0.37", &why) != LUM_OK ||
 *     lum_rig_set_sensor(&rig, 0, "pose.x_m", "1.2", &why) != LUM_OK ||
 *     lum_rig_check(&rig, &why) != LUM_OK) {
 *     printf("%s: %s\n", why.key, why.text);
 * }
 * @endcode
 *
 * Freestanding and reentrant; nothing is allocated or kept. */
#ifndef LUM_HOST_RIG_H
#define LUM_HOST_RIG_H

#include "lum/host/keys.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most sensors of a rig. */
#define LUM_RIG_SENSORS_MAX 8u

/** Bytes of a sensor's name, its NUL included. */
#define LUM_RIG_NAME_BYTES 32u

/** Bytes of the name of the vehicle's frame, its NUL included. */
#define LUM_RIG_FRAME_BYTES 64u

/** Bytes of an interface's name, its NUL included: LUM_INTERFACE_BYTES. */
#define LUM_RIG_INTERFACE_BYTES 64u

/** Bytes of a file's name, its NUL included. */
#define LUM_RIG_PATH_BYTES 1024u

/** A sensor of a rig. Its pose is where it is on the vehicle: a point p of the
 * sensor is at Rz(yaw) Ry(pitch) Rx(roll) p + at. */
typedef struct lum_rig_sensor {
    char name[LUM_RIG_NAME_BYTES]; /**< 1 to 31 letters, digits and '_', a
                                        letter first */
    char interface[LUM_RIG_INTERFACE_BYTES]; /**< as lum_capture_interface()
                              names it; empty: the first of its address
                              that no other sensor of the rig names */
    uint32_t address;   /**< host order; 0: it was not set */
    int32_t at_um[3];   /**< x, y, z in micrometres; within +-1 km */
    int32_t roll_udeg;  /**< about x, microdegrees; -360..360 degrees */
    int32_t pitch_udeg; /**< about y; likewise */
    int32_t yaw_udeg;   /**< about z; likewise */
} lum_rig_sensor;

/** A rig. About 1.1 KB, caller-owned, freely copied. */
typedef struct lum_rig {
    char frame[LUM_RIG_FRAME_BYTES];            /**< the vehicle's frame */
    size_t count;                               /**< sensors */
    lum_rig_sensor sensor[LUM_RIG_SENSORS_MAX]; /**< count of them */
} lum_rig;

/** A rig without sensors, whose frame is "base_link". Cannot fail.
 * @param out caller-owned, overwritten. */
void lum_rig_init(lum_rig *out);

/** Set a value of the rig itself.
 * @param key   "frame", or "version", which must be 1 and is not kept.
 * @param value as it would stand in a YAML file.
 * @param why   may be NULL; written only on failure.
 * @return LUM_OK; LUM_E_TYPE if there is no such key or it has no value of its
 *         own; LUM_E_VALUE if its value is not allowed. On failure nothing is
 *         set. */
LUM_MUST_CHECK lum_result lum_rig_set(lum_rig *rig, const char *key,
                                      const char *value, lum_key_refusal *why);

/** Set a value of a sensor.
 * @param i     which one, from 0 on; i == rig->count adds one.
 * @param key   "name", "address", "interface", "pose.x_m" and the others of a
 *              pose; "calibration" and "profile", which must be names of files
 *              and are not kept.
 * @param value as it would stand in a YAML file. An address may be followed by
 *              '%' and its interface.
 * @param why   may be NULL; written only on failure, with a key such as
 *              "sensors.2.pose.x_m" and the place i + 1.
 * @return as lum_rig_set(); LUM_E_SPACE if i is not below LUM_RIG_SENSORS_MAX,
 *         or above rig->count. */
LUM_MUST_CHECK lum_result lum_rig_set_sensor(lum_rig *rig, size_t i,
                                             const char *key, const char *value,
                                             lum_key_refusal *why);

/** Check all values together: there is a sensor, each has a name and an
 * address, names differ from each other and from the vehicle's frame, and
 * sensors that share an address differ in interface.
 * @param why may be NULL; written only on failure; its place is the sensor's
 *            number from 1 on, 0: none.
 * @return LUM_OK, or LUM_E_VALUE. */
LUM_MUST_CHECK lum_result lum_rig_check(const lum_rig *rig,
                                        lum_key_refusal *why);

#ifdef __cplusplus
}
#endif

#endif
