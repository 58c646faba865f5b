/* Frames a second, from whole frames only: the first and the last frame of a
 * stream are incomplete. */
#ifndef LUM_FRAME_PACE_H
#define LUM_FRAME_PACE_H

#include <stdbool.h>
#include <stdint.h>

/* Of one sensor; zero before the first line. */
typedef struct lum_pace {
    bool has_frame;
    bool has_begin;
    int64_t frame; /* the newest */
    int64_t first; /* the first whose begin was seen, and when that was */
    int64_t first_ns;
    int64_t last_ns; /* when the newest began */
} lum_pace;

/* A line of a frame, whose first packet came at a time. */
void lum_pace_take(lum_pace *pace, int64_t frame, int64_t time_ns);

/* 0: no whole frame came. */
double lum_pace_rate(const lum_pace *pace);

#endif
