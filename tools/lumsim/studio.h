/* Renders reels in a separate thread, so that the sensor can answer during that
 * time. One reel at a time: a request for another one cancels the present
 * one. */
#ifndef LUMSIM_STUDIO_H
#define LUMSIM_STUDIO_H

#include "lum/base/error.h"
#include "sim/device.h"
#include "sim/reel.h"

#include <stdbool.h>
#include <stdint.h>

struct studio;

/* What to render. */
struct order {
    lum_render_options options; /* but elevations_udeg */
    int32_t elevations_udeg[LUM_EYES][LUM_DEVICE_YSCAN_MAX];
    bool is_aimed; /* elevations_udeg counts */
    unsigned frames;
};

/* 0, or -1 with the reason in error. */
int studio_open(struct studio **out, lum_error *error);

/* Ends the thread. NULL is allowed. */
void studio_close(struct studio *studio);

/* Ask for a reel; the order is copied. */
void studio_order(struct studio *studio, const struct order *order);

/* Whether something that was ordered has not been fetched yet. */
bool studio_is_busy(struct studio *studio);

/* Whether there is something to fetch. */
bool studio_is_done(struct studio *studio);

/* What was ordered last, once it is done: true, with its result and, for
 * LUM_OK, the reel, which is the caller's then. */
bool studio_fetch(struct studio *studio, lum_reel **reel, lum_result *result);

#endif
