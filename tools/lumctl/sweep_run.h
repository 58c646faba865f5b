/* A sweep: steps of settings in one session, each with a recording. */
#ifndef LUMCTL_SWEEP_RUN_H
#define LUMCTL_SWEEP_RUN_H

#include "../common/geometry.h"
#include "manifest.h"
#include "memory.h"

struct sweep {
    struct ctl *ctl;
    const char *file; /* the plan's */
    const char *folder;
    lum_sweep plan;
    struct manifest *manifest;
    struct geometry geometry;      /* what recordings say of themselves */
    struct memory expected;        /* what the steps so far have set */
    struct memory_clock clock;     /* the latest look at the sensor's, */
    int64_t looked_ns;             /* monotonic */
    struct settings_plan settings; /* what the step at hand sends */
    struct settings_plan in_force; /* and what the steps so far come to */
    bool has_status;               /* of the last proof */
    uint16_t status;
    struct recorder *dropped;  /* its file is not wanted; NULL: none */
    bool is_whole;             /* all steps are done */
    char why[LUM_ERROR_BYTES]; /* its status is not EXIT_DONE */
};

/* Sets, settles, records and proves a step, and notes it in the manifest.
 * EXIT_DONE: it is done. Else why says why not, and the sweep ends with that
 * status. */
enum exit_status sweep_step(struct sweep *sweep, size_t step);

/* Has the session go on for a time, or until it is known what became of laser
 * on, there is trouble or an end by a signal: EXIT_DONE, or a status and why.
 */
enum exit_status sweep_await_laser(struct sweep *sweep, int64_t ns);

/* EXIT_DONE, or the status of what the session has met, and why. */
enum exit_status sweep_trouble(struct sweep *sweep);

#endif
