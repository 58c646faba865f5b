/* Commands that continue: they ask repeatedly and show the answers. */
#ifndef LUMCTL_WATCH_H
#define LUMCTL_WATCH_H

#include "ctl.h"

struct watch {
    int64_t period_ns;                  /* between two requests */
    lum_result (*ask)(struct ctl *ctl); /* begins one; NULL: the status, as the
                                           laser session asks for it */
    bool (*take)(void *context, const lum_sensor_event *event); /* false: end */
    void *context;
};

/* Runs until --duration has passed, a signal comes, or take ends it: EXIT_DONE.
 * EXIT_FAILED if the socket fails. take gets every event, IDLE at least twice a
 * second; texts without a request are already printed. */
enum exit_status watch_run(struct ctl *ctl, const struct watch *watch);

#endif
