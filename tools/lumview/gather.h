/* Frames of a rig's sensors to pictures of all: each has the newest frame of
 * each sensor. Sensors run freely, so a picture is made when each that sends
 * has a new one, or when one has its next while another is missing. The same
 * stream always makes the same pictures. */
#ifndef LUMVIEW_GATHER_H
#define LUMVIEW_GATHER_H

#include "view_picture.h"

#include <stdbool.h>
#include <stdint.h>

/* Pictures without a new frame of a sensor, until it is left out and no longer
 * waited for: so others can be as many times as fast. */
#define GATHER_OLD 8u

/* A sensor's newest frame. */
struct gather_member {
    struct picture newest; /* where it has one */
    bool has_newest;
    bool is_new;     /* no picture has it yet */
    unsigned missed; /* pictures since its last one */
};

/* All bytes 0 except members: the beginning. */
struct gather {
    size_t members;
    struct gather_member member[PICTURE_PARTS_MAX];
    struct picture next; /* of one whose newest no picture has yet */
    size_t next_member;
    bool has_next;
    int64_t count; /* pictures so far, which is the number of the last */
    int64_t begin_ns[GATHER_OLD]; /* when the latest began, each at its number
                                     modulo GATHER_OLD */
    uint64_t late;                /* frames that were left out */
    size_t late_member;           /* the latest is its */
};

/* Release its frames. */
void gather_end(struct gather *gather);

/* A sensor's frame, which is the gather's then. gather_take() was false since
 * the one before. One that began before the last GATHER_OLD pictures, and whose
 * sensor they do not have, is left out: the sensor paused in it, or has
 * stopped. */
void gather_put(struct gather *gather, size_t member, struct picture *picture);

/* The next picture, where one is due; at the end of the source also the last
 * one. out is empty before, and the caller's then. */
bool gather_take(struct gather *gather, bool is_end, struct picture *out);

#endif
