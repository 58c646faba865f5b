/* Pauses: where a sensor's clock goes on by clearly more lines than the line
 * numbers do, or jumps (docs/protocol.md, section 6, Pauses). */
#ifndef LUM_FRAME_PAUSE_H
#define LUM_FRAME_PAUSE_H

#include "base/pack.h"
#include "lum/assembler.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stdint.h>

/* Lines from which a period is learned. */
#define LUM_PAUSE_SAMPLES 9u

/* Fewer lines than this are not clearly more. */
#define LUM_PAUSE_LINES_MIN 5

/* Times and counts are computed with up to these: 17 years, and far more than
 * clocks of an index show. */
#define LUM_PAUSE_TIME_MAX_US  (INT64_C(1) << 49)
#define LUM_PAUSE_CLOCK_MAX_US (INT64_C(1) << 62)

/* What of a line matters. */
typedef struct lum_pause_line {
    int64_t clock_us;
    int64_t arrival_ns;
    uint32_t number;
    uint32_t frame;
} lum_pause_line;

/* What clocks of a layout can tell. */
typedef struct lum_pause_clock {
    int64_t gap_us;   /* beyond it the clock has jumped */
    int64_t tick_us;  /* how exact clocks are */
    int64_t least_us; /* a shorter pause cannot be told */
} lum_pause_clock;

/* --- How an eye scans: pause_scan.c --- */

/* Zero: nothing is known. */
typedef struct lum_pause_scan {
    int64_t sum_us; /* the period is sum_us / sum_lines */
    int64_t sum_lines;
    uint32_t sweep;     /* lines of it; 0: the end of none was seen */
    int64_t turn_us;    /* what the mirror takes from sweep to sweep */
    bool is_first_turn; /* turn_us is of one turn alone: it may be a pause, */
    int64_t first_us;   /* and ended at this clock */
} lum_pause_scan;

int64_t lum_pause_between_us(const lum_pause_line *a, const lum_pause_line *b);

/* a - b, whatever they are. */
int64_t lum_pause_minus(int64_t a, int64_t b);

/* Frames from one to another; of a straggler, which is of an earlier one, 0. */
uint32_t lum_pause_turns(uint32_t from, uint32_t to);

/* Finds the period: of the middle one of the steps from line to line. */
bool lum_pause_scan_begin(lum_pause_scan *s, const lum_pause_line *lines,
                          unsigned count);

/* How long so many lines take. */
int64_t lum_pause_scan_us(const lum_pause_scan *s, int64_t lines);

/* How many lines have their time between two, of which us passed. */
int64_t lum_pause_scan_lines(const lum_pause_scan *s, const lum_pause_line *a,
                             const lum_pause_line *b, int64_t us);

/* A line fits behind another. */
void lum_pause_scan_follow(lum_pause_scan *s, const lum_pause_line *a,
                           const lum_pause_line *b);

/* It is in the next sweep. is_pause: more time passed than is known of a turn.
 * Returns lines of a pause that was told, and was a turn. */
int64_t lum_pause_scan_turn(lum_pause_scan *s, const lum_pause_line *a,
                            const lum_pause_line *b, bool is_pause);

/* In either direction; zero if what is read is not possible. */
void lum_pause_scan_pack(lum_pause_scan *s, lum_pack *pack);

/* --- Which of its lines fit: pause_eye.c --- */

/* A line, and the numbering of the assembler behind it. */
typedef struct lum_pause_place {
    lum_pause_line line;
    uint32_t frame; /* the current one */
    uint32_t top;   /* its highest line */
} lum_pause_place;

/* Zero but for what is known. */
typedef struct lum_pause_eye {
    lum_pause_scan scan;
    uint8_t sample_count; /* no period yet */
    lum_pause_line sample[LUM_PAUSE_SAMPLES];
    bool has_last; /* a line that fits, or the first */
    lum_pause_place last;
    bool is_break;          /* between last and the first doubted */
    uint8_t next_count;     /* lines in turn that agree: to be confirmed */
    lum_pause_line doubted; /* the first of them */
    lum_pause_place next;   /* the last of them */
    int64_t next_lines;     /* missing between these, beside their numbers */
    uint8_t strange;        /* lines in turn that do not fit */
    int64_t highest_us;     /* clock, since the last break */
} lum_pause_eye;

/* What lines tell. */
typedef struct lum_pause_found {
    unsigned breaks; /* jumps of the clock */
    int64_t lines; /* missing by the clock, and not by their numbers; negative:
                      the numbers show more than are missing */
    bool has_pause;
    bool is_break;
    int64_t from_us;
    int64_t to_us;
    uint32_t before; /* the frames on both sides */
    uint32_t behind;
    int64_t lines_before; /* that the frame before lacks */
    int64_t turn_lines;   /* of a first turn that had been told as a pause, */
    int64_t turn_us;      /* and ended at this clock */
} lum_pause_found;

/* A line was handed out; out is added to. is_decided: its frame was decided; if
 * not, its number tells nothing. */
void lum_pause_eye_take(lum_pause_eye *e, const lum_pause_clock *clock,
                        const lum_pause_line *line, bool is_decided,
                        lum_pause_found *out);

/* No line will confirm what is doubted. is_end: the stream ends. */
void lum_pause_eye_end(lum_pause_eye *e, const lum_pause_clock *clock,
                       bool is_end, lum_pause_found *out);

/* It goes on after its end, with any clock. */
void lum_pause_eye_join(lum_pause_eye *e);

/* Whether it has stopped before the end of a frame, of which no line is
 * expected any more. */
bool lum_pause_eye_has_stopped(const lum_pause_eye *e, uint32_t frame);

/* Whether its latest line is a straggler of a frame, far behind lines of the
 * next by its clock: no other will confirm that before the frame ends. */
bool lum_pause_eye_doubts(const lum_pause_eye *e, uint32_t frame);

/* In either direction, as that of a scan. */
void lum_pause_eye_pack(lum_pause_eye *e, lum_pack *pack);

/* --- Pauses of both eyes: pause.c --- */

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
