/* The status as commands that watch it show it. */
#ifndef LUMCTL_STATUS_H
#define LUMCTL_STATUS_H

#include "ctl.h"

/* Prints a line, or a JSON object, with the time: if has_status is false, the
 * sensor does not answer. was_up: the line before showed the laser up. False if
 * nobody reads. */
bool status_log(const struct ctl *ctl, bool was_up, bool has_status,
                uint16_t status);

#endif
