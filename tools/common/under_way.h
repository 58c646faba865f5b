/* Lines that were under way when a stream was joined, or left: the counters of
 * losses have what such a line lacks, though nothing was lost of it. */
#ifndef LUM_TOOLS_UNDER_WAY_H
#define LUM_TOOLS_UNDER_WAY_H

#include "lum/assembler.h"

#include <stdbool.h>
#include <stdint.h>

/* What lines lack; zero before the first. */
struct under_way_counts {
    uint64_t lines;    /* of lines_missing_angles */
    uint64_t words;    /* of lost_words */
    uint64_t no_angle; /* of words whose pixel has no angles */
};

/* Of one sensor; zero before the first line. */
struct under_way {
    struct under_way_counts counts;
    bool has_joined[LUM_EYES];
    bool is_leaving;
    struct under_way_counts last[LUM_EYES];
};

/* A line was handed out. The first of an eye was under way when the stream was
 * joined, as far as it lacks anything.
 * no_angle: its words whose pixel has no angles. */
void under_way_take(struct under_way *under_way, const lum_line *line,
                    uint64_t no_angle);

void under_way_add(struct under_way_counts *to,
                   const struct under_way_counts *more);

/* The lines that follow are those still open at the end, of which the last of
 * an eye was under way. */
void under_way_leave(struct under_way *under_way);

#endif
