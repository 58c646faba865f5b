/* A live sensor: one thread keeps the session and never waits for anything
 * else, another makes frames from the ring. */
#ifndef LUMVIEW_SENSOR_LINK_H
#define LUMVIEW_SENSOR_LINK_H

#include "decoder.h"
#include "options.h"

#include "lum/base/error.h"

struct link;

struct link_options {
    struct live_options live;
    struct decoder_options decoder;
};

/* Begin; the sensor is owned from here on. 0, or -1 with the reason in error.
 */
int link_start(const struct link_options *options, struct link **out,
               lum_error *error);

/* End; the stage is closing. 0, or -1: the laser that was to be switched off
 * was not seen down, error says more. NULL is allowed. */
int link_end(struct link *link, lum_error *error);

#endif
