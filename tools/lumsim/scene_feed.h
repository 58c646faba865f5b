/* The data of a sensor that looks at a scene: a reel, played in a loop, at the
 * pace and with the clock of the sensor. */
#ifndef LUMSIM_SCENE_FEED_H
#define LUMSIM_SCENE_FEED_H

#include "lum/net/socket.h"
#include "options.h"
#include "sim/device.h"
#include "sim/reel.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* All zero at first, but for the rate. */
struct scene {
    lum_reel *reel;     /* its owner frees it; NULL: nothing is rendered yet */
    double line_ns;     /* how long a line lasts */
    double rate_hz;     /* frames a second */
    int64_t begin_ns;   /* of line 0 */
    int64_t line;       /* the next one, counted from begin_ns */
    int64_t current_ns; /* when the line under way began */
    lum_reel_packet packets[LUM_REEL_LINE_PACKETS]; /* of that line */
    size_t count;
    size_t next;           /* the first that has not been given */
    bool is_held;          /* no other line begins */
    int64_t round;         /* of the line under way: how often all was played */
    uint64_t rounds_again; /* that began after another */
    uint64_t lines_sent;
    uint64_t lines_skipped;
};

/* Play another reel, which becomes the scene's: with the next line, or from its
 * start if it has another number of lines. */
void scene_load(struct scene *scene, lum_reel *reel, int64_t now_ns);

/* Play from the start. */
void scene_begin(struct scene *scene, int64_t now_ns);

/* Whether lines wait for another reel, so that it cuts none. True: the one
 * under way is over. */
bool scene_hold(struct scene *scene, bool is_held);

/* Up to max datagrams that are due, in order. Returns how many. */
size_t scene_take(struct scene *scene, const lum_device *device, int64_t now_ns,
                  lum_outgoing *out, size_t max);

/* When the next one is due; INT64_MAX without a reel. */
int64_t scene_next_ns(const struct scene *scene);

/* The laser went down: the rest of the line is sent without ranges. */
void scene_darken(struct scene *scene, const lum_device *device);

#endif
