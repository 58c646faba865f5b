/* Pauses: where a sensor's clock goes on by clearly more lines than the line
 * numbers do, or jumps (docs/protocol.md, section 6, Pauses). */
#ifndef LUM_FRAME_PAUSE_H
#define LUM_FRAME_PAUSE_H

#include "base/pack.h"
#include "lum/assembler.h"
#include "lum/profile.h"
#include "pause_eye.h"

#include <stdbool.h>
#include <stdint.h>

/* Frames of which is kept that a pause lies in them. */
#define LUM_PAUSE_FRAMES 4u

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

/* The latest pause. Numbers may show lines of it before it is confirmed and
 * after, also as lines of the other eye. */
typedef struct lum_pause_latest {
    uint8_t fresh;  /* lines of both eyes that may yet show some */
    int64_t lines;  /* missing by the clock, less those that numbers show */
    bool has_pause; /* else there is but what numbers show */
    bool is_break;
    int64_t from_us;
    int64_t to_us;
} lum_pause_latest;

/* One sensor; zero but for what lum_pause_init() sets. */
typedef struct lum_pause {
    lum_pause_clock clock;
    bool by_arrival; /* there is no clock */
    lum_pause_eye eye[LUM_EYES];
    lum_pause_frame frames[LUM_PAUSE_FRAMES];
    uint8_t frames_next;
    lum_pause_latest latest;
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

/* All but what lum_pause_init() sets, the latest pause and the counts, in
 * either direction: these begin anew where it is read. */
void lum_pause_pack(lum_pause *p, lum_pack *pack);

#endif
