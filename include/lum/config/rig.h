/** @file
 * A rig from a YAML file (docs/formats.md): the sensors of a vehicle, each with
 * its calibration and its wire profile.
 *
 * These are errors, with file, line, key and what is allowed: all that
 * lum/config/config.h or lum_rig_check() refuses, and calibrations and profiles
 * that cannot be read. Reentrant. */
#ifndef LUM_CONFIG_RIG_H
#define LUM_CONFIG_RIG_H

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/host/rig.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What the files of a sensor say. */
typedef struct lum_rig_sensor_files {
    lum_calibration calibration; /**< of its file, or the default */
    lum_profile profile;         /**< likewise */
    char calibration_path[LUM_RIG_PATH_BYTES]; /**< of the file, as it was
                                     opened; empty: the default is used */
    char profile_path[LUM_RIG_PATH_BYTES];     /**< likewise */
} lum_rig_sensor_files;

/** A rig with the files that it names; 20 KB. */
typedef struct lum_rig_files {
    lum_rig rig;                                      /**< checked */
    lum_rig_sensor_files sensor[LUM_RIG_SENSORS_MAX]; /**< rig.count of them */
} lum_rig_files;

/** Read a rig.
 * @param path  a file, or "-" for standard input. File names in it are relative
 *              to its folder; in "-", to the current folder.
 * @param out   caller-owned; not valid on failure.
 * @param error gets the message on failure.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_rig_load(const char *path, lum_rig_files *out,
                                lum_error *error);

/** Read a rig from memory; the files that it names are read too.
 * @param text len bytes; need not be terminated.
 * @param name used as the file's name in messages, and for its folder. */
LUM_MUST_CHECK int lum_rig_parse(const char *text, size_t len, const char *name,
                                 lum_rig_files *out, lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
