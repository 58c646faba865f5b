/* Lines that were under way when a stream was joined, or left: the counters of
 * losses have what such a line lacks, though nothing was lost of it. */
#ifndef LUM_FRAME_UNDER_WAY_H
#define LUM_FRAME_UNDER_WAY_H

#include "lum/assembler.h"
#include "lum/frame/framer.h"

#include <stdbool.h>
#include <stdint.h>

/* Of one sensor; zero before the first line. */
typedef struct lum_under_way_state {
    lum_under_way counts;
    bool has_joined[LUM_EYES];
    bool is_leaving;
    lum_under_way last[LUM_EYES];
} lum_under_way_state;

/* A line was handed out. The first of an eye was under way when the stream was
 * joined, as far as it lacks anything.
 * no_angle: its words whose pixel has no angles. */
void lum_under_way_take(lum_under_way_state *state, const lum_line *line,
                        uint64_t no_angle);

/* The lines that follow are those still open at the end, of which the last of
 * an eye was under way. */
void lum_under_way_leave(lum_under_way_state *state);

/* The stream goes on after its end: it is joined anew. */
void lum_under_way_join(lum_under_way_state *state);

#endif
