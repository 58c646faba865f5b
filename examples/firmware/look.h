/* What an eye has looked at, and for how long that serves. Two things make a
 * machine blind without an error: no light, and lines that do not come. So an
 * eye has to show points, and all lines of a frame.
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

/* A line, in the order in which they are handed out. It counts if it came
 * whole, and above those of its frame that counted. A frame of which so many
 * lines counted is a whole look, that began with the oldest of its lines. */
void look_take(look *l, const lum_line *line, int64_t measured_ms,
               uint32_t lines);

/* That it had points. */
void look_see(look *l, int64_t measured_ms);

/* Something was lost of which the lines that are open tell nothing: what was
 * measured up to now does not count any more. */
void look_spoil(look *l, int64_t now_ms);

/* For how long, from now on, the newest point is younger than silence_ms and
 * all of the newest whole look than hold_ms. 0: the eye is blind. */
uint32_t look_lasts(const look *l, uint32_t silence_ms, uint32_t hold_ms,
                    int64_t now_ms);

#endif
