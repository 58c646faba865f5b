/* Commands that continue: they ask repeatedly and show the answers. */
#ifndef LUMCTL_WATCH_H
#define LUMCTL_WATCH_H

#include "ctl.h"

struct watch {
    bool looks;        /* the laser session asks for the status, as it does */
    int64_t period_ns; /* between two requests of ask */
    const int64_t *wake_ns; /* take is called then, too, monotonic; NULL, or in
                               the past: it need not */
    lum_result (*ask)(struct ctl *ctl, void *context); /* begins one; may be
                                                          NULL beside looks */
    bool (*take)(void *context, const lum_sensor_event *event); /* false: end */
    void *context;
};

/* Runs until --duration has passed, a signal comes, or take ends it: EXIT_DONE.
 * EXIT_FAILED if the socket fails. take gets every event, IDLE at least twice a
 * second; texts without a request are already printed. */
enum exit_status watch_run(struct ctl *ctl, const struct watch *watch);

#endif
