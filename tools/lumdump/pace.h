/* Frames a second, of whole frames alone: a recording's first and last are seen
 * in part. */
#ifndef LUMDUMP_PACE_H
#define LUMDUMP_PACE_H

#include <stdbool.h>
#include <stdint.h>

/* Of one sensor; zero before the first line. */
struct pace {
    bool has_frame;
    bool has_begin;
    int64_t frame; /* the newest */
    int64_t first; /* the first whose begin was seen, and when that was */
    int64_t first_ns;
    int64_t last_ns; /* when the newest began */
};

/* A line of a frame, whose first packet came at a time. */
void pace_take(struct pace *pace, int64_t frame, int64_t time_ns);

/* 0: no whole frame came. */
double pace_rate(const struct pace *pace);

#endif
