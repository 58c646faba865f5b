/* The arrivals that a fit keeps: the earliest of each span of the window, and
 * what bounds the truth between them. */
#ifndef LUM_FRAME_CLOCK_ARRIVALS_H
#define LUM_FRAME_CLOCK_ARRIVALS_H

#include "clock_line.h"

/* An arrival contradicts the line if it lies this far below its lowest possible
 * place. */
#define LUM_CLOCK_LOW_NS INT64_C(1000000)

/* What is common to all stamps: they lie on whole multiples of their
 * resolution, counted from whole seconds. */
struct lum_clock_stamps {
    int64_t step_us;   /* the largest that fits; 0: there is none yet */
    int64_t lines_us;  /* the same of the distances between readings */
    uint32_t halvings; /* of a second, the fewest that fit;
                          LUM_CLOCK_HALVINGS: none do */
};

#define LUM_CLOCK_STEP_MAX_US INT64_C(1000000)
#define LUM_CLOCK_HALVINGS    16u

/* The earliest of the latenesses that there are in a span. */
#define LUM_CLOCK_EARLIEST 8u

struct lum_clock_earliest {
    struct lum_clock_reading first; /* to arrive */
    uint32_t count;
    int64_t late_ns[LUM_CLOCK_EARLIEST]; /* after the first, rising */
};

struct lum_clock_arrivals {
    struct lum_clock_bucket buckets[LUM_CLOCK_BUCKETS];
    struct lum_clock_reading newest;
    struct lum_clock_reading last;      /* in order of arrival */
    struct lum_clock_reading latest;    /* the truth is no later than this */
    struct lum_clock_earliest earliest; /* of the newest bucket */
    struct lum_clock_stamps stamps;
};

/* The first reading of a new window; stamps stay known. */
void lum_clock_arrivals_begin(struct lum_clock_arrivals *a,
                              const struct lum_clock_line *line,
                              const struct lum_clock_reading *r);

/* One more. Returns whether the line is to be laid anew. */
bool lum_clock_arrivals_take(struct lum_clock_arrivals *a,
                             const struct lum_clock_line *line,
                             const struct lum_clock_reading *r);

/* Note a stamp, for the resolution. */
void lum_clock_arrivals_note_stamp(struct lum_clock_arrivals *a,
                                   int64_t arrival_ns);

/* Of the stamps, in ns; at least 1000 once there is one. */
int64_t lum_clock_arrivals_resolution(const struct lum_clock_arrivals *a);

/* The window that a line is laid under. */
void lum_clock_arrivals_look(const struct lum_clock_arrivals *a,
                             struct lum_clock_window *out);

/* By how much the truth may be later than a line's time of a reading. */
int64_t lum_clock_arrivals_later(const struct lum_clock_arrivals *a,
                                 const struct lum_clock_line *line,
                                 int64_t clock_us);

/* The error of a line's time. */
int64_t lum_clock_arrivals_error(const struct lum_clock_arrivals *a,
                                 const struct lum_clock_line *line,
                                 int64_t clock_us);

/* All but the buckets, in either direction; and these. */
void lum_clock_arrivals_pack(struct lum_clock_arrivals *a, lum_pack *pack);
void lum_clock_arrivals_pack_buckets(struct lum_clock_arrivals *a,
                                     lum_pack *pack);

#endif
