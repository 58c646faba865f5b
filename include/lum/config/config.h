/** @file
 * Calibration and wire profile from YAML files (docs/formats.md).
 *
 * Files may be partial: missing keys keep their defaults. These are errors,
 * with file, line, key and what is allowed: keys unknown or repeated, values of
 * a wrong kind, out of range, NaN or infinite, aliases and anchors, more than
 * one document, files over LUM_CONFIG_BYTES_MAX. Reentrant; a file is held in
 * memory while it is read. */
#ifndef LUM_CONFIG_CONFIG_H
#define LUM_CONFIG_CONFIG_H

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/profile.h"
#include "lum/result.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Largest YAML file that is read: 64 KiB. */
#define LUM_CONFIG_BYTES_MAX 65536u

/** Read a calibration.
 * @param path  a file, or "-" for standard input.
 * @param out   written only on success.
 * @param error gets the message on failure.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_calibration_load(const char *path, lum_calibration *out,
                                        lum_error *error);

/** Read a wire profile. As lum_calibration_load(); the profile is also checked
 * as by lum_layout_init(), and an error names the line of its key. */
LUM_MUST_CHECK int lum_profile_load(const char *path, lum_profile *out,
                                    lum_error *error);

/** Read a calibration from memory.
 * @param text  len bytes; need not be terminated.
 * @param name  used as the file's name in messages. */
LUM_MUST_CHECK int lum_calibration_parse(const char *text, size_t len,
                                         const char *name, lum_calibration *out,
                                         lum_error *error);

/** Read a wire profile from memory. As lum_calibration_parse(). */
LUM_MUST_CHECK int lum_profile_parse(const char *text, size_t len,
                                     const char *name, lum_profile *out,
                                     lum_error *error);

#ifdef __cplusplus
}
#endif

#endif
