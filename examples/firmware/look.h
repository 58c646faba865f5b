/* What an eye has seen, and how long that is valid. Two things make a machine
 * blind without an error: no light, and lines that do not come. So an eye has
 * to show points, and all lines of a frame.
 *
 * Times are those of measuring, not of arrival. */
#ifndef LOOK_H
#define LOOK_H

#include "lum/assembler.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct look {
    int64_t point_ms;  /* the newest point was measured */
    int64_t whole_ms;  /* the newest whole look began */
    int64_t begun_ms;  /* the look under way */
    int64_t spoilt_ms; /* lines of before may lack something */
    uint32_t frame;    /* of the look under way, as the next two */
    uint32_t top;      /* highest line that counts */
    uint32_t count;    /* lines that count */
} look;

/* Begin: nothing was seen. */
void look_init(look *l);

/* A line, in the order in which they are handed out. It counts if it is whole,
 * and above those of its frame that counted before. A frame with enough lines
 * that counted is a whole look, which began with its oldest line. */
void look_take(look *l, const lum_line *line, int64_t measured_ms,
               uint32_t lines);

/* That it had points. */
void look_see(look *l, int64_t measured_ms);

/* Data was lost, and the open lines do not show it: everything measured up to
 * now no longer counts. */
void look_spoil(look *l, int64_t now_ms);

/* How long, from now on, the newest point stays younger than silence_ms and all
 * of the newest whole look younger than hold_ms. 0: the eye is blind. */
uint32_t look_lasts(const look *l, uint32_t silence_ms, uint32_t hold_ms,
                    int64_t now_ms);

#endif
