/** @file
 * A plan of steps from a YAML file: what `lumctl sweep` does (docs/formats.md).
 * Internal. */
#ifndef LUM_CONFIG_SWEEP_PLAN_H
#define LUM_CONFIG_SWEEP_PLAN_H

#include "lum/base/error.h"
#include "lum/config/settings.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

/** Most steps of a plan. */
#define LUM_SWEEP_STEPS 1000u

/** One step: settings, and what is recorded once they hold. */
typedef struct lum_sweep_step {
    lum_settings settings; /**< of the step alone, as of a settings file; with
                              a table also the lines that it is made for */
    lum_settings all;      /**< with those of the steps before it */
    int64_t record_ns;     /**< so long; 0: by frames, or nothing */
    uint32_t frames;       /**< so many whole ones; 0: by time, or nothing */
    int64_t settle_ns;     /**< between the answer and the recording */
} lum_sweep_step;

/** A plan. */
typedef struct lum_sweep {
    lum_sweep_step *steps; /**< count of them */
    size_t count;          /**< 1 to LUM_SWEEP_STEPS */
} lum_sweep;

/** Read a plan.
 * @param path  a file, or "-" for standard input.
 * @param out   to be freed with lum_sweep_free(); empty on failure.
 * @param error gets the message on failure.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_sweep_load(const char *path, lum_sweep *out,
                                  lum_error *error);

/** Read a plan from memory.
 * @param text len bytes; need not be terminated.
 * @param name used as the file's name in messages. */
LUM_MUST_CHECK int lum_sweep_parse(const char *text, size_t len,
                                   const char *name, lum_sweep *out,
                                   lum_error *error);

/** Add later settings to earlier ones: new lines clear a Y-scan table. */
void lum_sweep_merge(lum_settings *all, const lum_settings *later);

/** Free its steps. */
void lum_sweep_free(lum_sweep *sweep);

#endif
