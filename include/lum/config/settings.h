/** @file
 * Settings of a sensor from a YAML file (docs/formats.md): what `lumctl apply`
 * sends.
 *
 * Every key may be left out; a setting that a file does not name stays as it is
 * on the sensor. These are errors, with file, line, key and what is allowed:
 * all that lum/config/config.h refuses, and the laser, because no file may
 * switch it. Reentrant. */
#ifndef LUM_CONFIG_SETTINGS_H
#define LUM_CONFIG_SETTINGS_H

#include "lum/base/error.h"
#include "lum/command.h"
#include "lum/host/yscan_plan.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The settings of a file. It grows with the table of commands, so compile a
 * program with the header of the library that it links. */
typedef struct lum_settings {
    bool has[LUM_COMMANDS];       /**< by ::lum_command_id; never the laser's */
    uint16_t value[LUM_COMMANDS]; /**< one that the command's spec allows */
    bool has_shape;        /**< a Y-scan table, instead of LUM_COMMAND_YSCAN */
    lum_yscan_shape shape; /**< regions sorted, its limits checked */
} lum_settings;

/** Read settings.
 * @param path  a file, or "-" for standard input.
 * @param out   written only on success.
 * @param error gets the message on failure.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_settings_load(const char *path, lum_settings *out,
                                     lum_error *error);

/** Read settings from memory.
 * @param text  len bytes; need not be terminated.
 * @param name  used as the file's name in messages. */
LUM_MUST_CHECK int lum_settings_parse(const char *text, size_t len,
                                      const char *name, lum_settings *out,
                                      lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
