/* Lines that had already begun when a stream was joined, or were unfinished
 * when it was left: the counters of losses include what such a line lacks,
 * although nothing was lost. */
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

/* A line was handed out. If the first line of an eye lacks anything, it had
 * begun before the stream was joined. no_angle: its words whose pixel has no
 * angles. */
void lum_under_way_take(lum_under_way_state *state, const lum_line *line,
                        uint64_t no_angle);

/* The following lines are those still open at the end; the last of each eye was
 * unfinished. */
void lum_under_way_leave(lum_under_way_state *state);

/* The stream continues after its end: it is joined again. */
void lum_under_way_join(lum_under_way_state *state);

#endif
