/* Pauses: where a sensor's clock goes on by clearly more lines than the line
 * numbers do, or jumps (docs/protocol.md, section 6, Pauses).
 *
 * Lines of an eye follow each other at a steady period. A line whose clock and
 * number do not agree with the one before it, or behind which lines are missing
 * that the numbers do not show, tells nothing alone: its clock or its number
 * may be corrupt. The lines behind it confirm it. */
#ifndef LUM_FRAME_PAUSE_H
#define LUM_FRAME_PAUSE_H

#include "base/pack.h"
#include "lum/assembler.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stdint.h>

/* Lines from which a period is learned. */
#define LUM_PAUSE_SAMPLES 9u

/* Lines that agree before a pause is told: the first one behind it counts. */
#define LUM_PAUSE_CONFIRM 3u

/* Frames of which is kept that a pause lies in them. */
#define LUM_PAUSE_FRAMES 4u

/* What of a line matters. */
typedef struct lum_pause_line {
    int64_t clock_us;
    int64_t arrival_ns;
    uint32_t number;
    uint32_t frame;
} lum_pause_line;

/* One eye. The period is sum_us / sum_lines. */
typedef struct lum_pause_eye {
    bool has_period;
    bool has_last;      /* a line that fits, or the first */
    bool has_turn;      /* a sweep's end was seen */
    bool is_first_turn; /* turn_us is of one sweep alone: it may be a pause */
    bool is_break;      /* between last and next[0] */
    uint8_t sample_count;
    uint8_t next_count;
    uint8_t strange; /* lines in turn that fit nothing */
    uint8_t fresh;   /* lines that may yet show what the last pause lacks */
    lum_pause_line sample[LUM_PAUSE_SAMPLES]; /* no period yet */
    lum_pause_line last;
    lum_pause_line next[LUM_PAUSE_CONFIRM]; /* to be confirmed */
    int64_t highest_us;                     /* clock, since the last break */
    int64_t sum_us;
    int64_t sum_lines;
    int64_t turn_us; /* from the end of a sweep to the next */
    uint32_t sweep;  /* lines of a sweep */
    uint32_t frame;  /* the current one, and its highest line: as the
                        assembler has them */
    uint32_t top;
    uint32_t gap;
} lum_pause_eye;

/* What a frame lacks by a pause inside it. */
typedef struct lum_pause_frame {
    uint8_t eyes; /* those that paused in it, a bit each; 0: not used */
    uint32_t frame;
    uint64_t lines[LUM_EYES];
} lum_pause_frame;

/* What was found so far. It can become less again: the first turn of a mirror
 * that takes long looks like a pause until the second. */
typedef struct lum_pause_counts {
    uint64_t pauses;    /* of the sensor: both eyes pause together */
    uint64_t paused_us; /* from the last line before to the first behind */
    uint64_t lines;     /* missing in them, but for those that the assembler
                           counts as skipped */
    uint64_t breaks;    /* jumps of an eye's clock; each began with a stray */
} lum_pause_counts;

/* One sensor; zero but for what lum_pause_init() sets. */
typedef struct lum_pause {
    int64_t gap_us;   /* beyond it the clock has jumped */
    int64_t tick_us;  /* how exact clocks are */
    int64_t least_us; /* a shorter pause cannot be told */
    bool by_arrival;  /* there is no clock */
    lum_pause_eye eye[LUM_EYES];
    lum_pause_frame frames[LUM_PAUSE_FRAMES];
    uint8_t frames_next;
    bool has_pause;  /* the latest one: */
    bool is_counted; /* else it was told elsewhere in the stream */
    bool has_eye[LUM_EYES];
    int64_t from_us;
    int64_t to_us;
    uint64_t lines[LUM_EYES];
    lum_pause_counts counts;
} lum_pause;

/* gap_us: of the assembler. Lines of a layout without a clock are timed by
 * arrival, which tells only a second or more. */
void lum_pause_init(lum_pause *p, uint32_t gap_us, const lum_profile *profile);

/* A line was handed out; in their order. is_decided: its frame was decided; if
 * not, its number tells nothing. */
void lum_pause_take(lum_pause *p, const lum_line *line, bool is_decided);

/* The stream ends: no more lines confirm what there is. */
void lum_pause_end(lum_pause *p);

/* It goes on after its end, with any clock. */
void lum_pause_join(lum_pause *p);

/* No line of this frame comes any more.
 * eyes:  the wanted ones, a bit each. is_end: the stream ended with it.
 * lines: gets those missing in pauses inside it, as far as they are known.
 * Returns whether one lies in it, or an eye pauses that has not all of it. */
bool lum_pause_frame_ends(lum_pause *p, uint32_t frame, unsigned eyes,
                          bool is_end, uint64_t *lines);

/* All but what lum_pause_init() sets and the counts, in either direction. The
 * counts begin anew where it is read. */
void lum_pause_pack(lum_pause *p, lum_pack *pack);

#endif
