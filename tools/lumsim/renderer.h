/* Renders reels in a separate thread, so that the sensor can answer during that
 * time. One reel at a time: a request for another one cancels the present
 * one. */
#ifndef LUMSIM_RENDERER_H
#define LUMSIM_RENDERER_H

#include "lum/base/error.h"
#include "sim/device.h"
#include "sim/reel.h"

#include <stdbool.h>
#include <stdint.h>

struct renderer;

/* What to render. */
struct render_order {
    lum_render_options options; /* but elevations_udeg */
    int32_t elevations_udeg[LUM_EYES][LUM_DEVICE_YSCAN_MAX];
    bool is_aimed; /* elevations_udeg counts */
    unsigned frames;
};

/* 0, or -1 with the reason in error. */
int renderer_open(struct renderer **out, lum_error *error);

/* Ends the thread. NULL is allowed. */
void renderer_close(struct renderer *renderer);

/* Ask for a reel; the order is copied. */
void renderer_order(struct renderer *renderer,
                    const struct render_order *order);

/* Whether something that was ordered has not been fetched yet. */
bool renderer_is_busy(struct renderer *renderer);

/* Whether there is something to fetch. */
bool renderer_is_done(struct renderer *renderer);

/* What was ordered last, once it is done: true, with its result and, for
 * LUM_OK, the reel, which is the caller's then. */
bool renderer_fetch(struct renderer *renderer, lum_reel **reel,
                    lum_result *result);

#endif
