/* Commands that go on: they ask again and again and show what comes. */
#ifndef LUMCTL_WATCH_H
#define LUMCTL_WATCH_H

#include "ctl.h"

struct watch {
    int64_t period_ns;                     /* between two requests */
    lum_result (*ask)(lum_sensor *sensor); /* begins one */
    bool (*take)(void *context, const lum_sensor_event *event); /* false: end */
    void *context;
};

/* Runs until --duration has passed or a signal comes, or take says so:
 * EXIT_DONE. EXIT_FAILED when the socket breaks. take gets every event, IDLE
 * at least twice a second; texts that come unasked have been told. */
enum exit_status watch_run(struct ctl *ctl, const struct watch *watch);

#endif
