/* A run on a sensor: udp://ADDRESS. */
#ifndef LUMDUMP_LIVE_H
#define LUMDUMP_LIVE_H

#include "conclude.h"

/* Receive from the sensor until the duration is over, a signal comes, the
 * reader leaves or something fails; write and sum up as the options say. Uses
 * the pass up. */
enum exit_status live_run(struct pass *pass);

#endif
