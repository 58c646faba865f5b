/* What a sweep has done, as JSON in its folder: a line for each step, written
 * anew after each (docs/formats.md, "The manifest of a sweep"). */
#ifndef LUMCTL_MANIFEST_H
#define LUMCTL_MANIFEST_H

#include "ctl.h"
#include "recorder.h"
#include "settings_plan.h"

#include "config/sweep_plan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct manifest;

#define MANIFEST_PATH_BYTES 4096

/* How a step ended. */
struct manifest_result {
    bool is_done;
    char file[32];      /* in the folder; empty: nothing was recorded */
    int64_t set_utc_ns; /* its settings were answered; 0: they were not */
    uint16_t status;    /* the last */
    bool has_status;
    struct recorder_counts counts; /* of the file */
    char why[LUM_ERROR_BYTES];     /* it is not done */
};

/* Begins the manifest of a plan in a folder. goes_on: takes over what the one
 * that is there says is done. Nothing is written yet. EXIT_BAD if there is one
 * and it does not go on, or it cannot be read. Complains. */
enum exit_status manifest_open(struct ctl *ctl, const char *folder,
                               const char *plan, size_t steps, bool goes_on,
                               struct manifest **out);

/* Names a step, from 0 on, and what it sets and records; to be called for all,
 * before others. False: there is no memory. */
bool manifest_name(struct manifest *m, size_t step,
                   const struct settings_plan *settings,
                   const lum_sweep_step *what);

/* After all are named: EXIT_BAD with a complaint if files would be replaced
 * that no manifest has, or if the earlier manifest has steps as done that are
 * not of this plan, sensor, calibration and --laser. */
enum exit_status manifest_check(const struct manifest *m);

/* Whether it was done by an earlier run, and its file is there. */
bool manifest_is_done(const struct manifest *m, size_t step);

/* Writes it for the first time, and waits for that. False with the reason in
 * error. */
bool manifest_begin(struct manifest *m, lum_error *error);

/* The name of its file in the folder, and its path. */
void manifest_file(const struct manifest *m, size_t step, char name[32],
                   char path[MANIFEST_PATH_BYTES]);

/* Says how a step ended, and has that written. Does not wait. */
void manifest_note(struct manifest *m, size_t step,
                   const struct manifest_result *result);

/* A failure to write it, once. */
bool manifest_tell(struct manifest *m, lum_error *out);

/* Writes why the sweep ended, if it has begun, and frees all. False: it could
 * not be written. NULL is allowed. */
bool manifest_end(struct manifest *m, const char *why, enum exit_status status);

#endif
