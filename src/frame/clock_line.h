/* The arrivals that a fit keeps, the earliest of each span of the window and
 * what bounds the truth between them; and a line under them: it converts the
 * sensor's clock to the host's, and has an error. */
#ifndef LUM_FRAME_CLOCK_LINE_H
#define LUM_FRAME_CLOCK_LINE_H

#include "base/pack.h"
#include "lum/frame/clock_fit.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The window: the earliest arrivals of this many spans of the sensor's
 * clock. */
#define LUM_CLOCK_BUCKETS   128
#define LUM_CLOCK_BUCKET_US 125000

/* How late the first arrival may be. */
#define LUM_CLOCK_SPREAD_NS INT64_C(40000000)

/* An arrival is on the line if it differs by less. */
#define LUM_CLOCK_SLACK_NS 1000

#define LUM_CLOCK_NOTHING INT64_MAX

/* Far above all that is measured, and sums of them fit. */
#define LUM_CLOCK_NS_MAX  (INT64_C(1) << 61)
#define LUM_CLOCK_PPB_MAX INT64_C(1000000000)

struct lum_clock_reading {
    int64_t clock_us;
    int64_t arrival_ns;
};

/* The earliest arrival of a span. */
struct lum_clock_bucket {
    int64_t index; /* of the span; LUM_CLOCK_NOTHING: unused */
    struct lum_clock_reading best;
    int64_t gap_ns;   /* the widest among its earliest */
    uint32_t batches; /* that ended in it; without batches, readings */
};

struct lum_clock_line {
    struct lum_clock_reading at;
    int64_t drift_ppb;
    int64_t drift_error_ppb;
    int64_t from_us; /* readings that it rests on */
    int64_t to_us;
    int64_t error_ns; /* between them */
};

/* The used buckets in their order. */
struct lum_clock_window {
    const struct lum_clock_bucket *list[LUM_CLOCK_BUCKETS];
    size_t count;
    int64_t batches;
    int64_t resolution_ns;              /* of the stamps */
    int64_t late_ns[LUM_CLOCK_BUCKETS]; /* of each, while a line is laid */
};

static inline int64_t lum_clock_magnitude(int64_t x)
{
    return x < 0 ? -x : x;
}

static inline int64_t lum_clock_smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static inline bool lum_clock_is_within(int64_t x, int64_t most)
{
    return x >= -most && x <= most;
}

/* Of a reading. */
static inline bool lum_clock_is_possible(const struct lum_clock_reading *r)
{
    return lum_clock_is_within(r->clock_us, LUM_CLOCK_FIT_CLOCK_MAX_US) &&
           lum_clock_is_within(r->arrival_ns, LUM_CLOCK_FIT_ARRIVAL_MAX_NS);
}

/* The state of a fit, in either direction. False: something failed; then what
 * was read is of no use. In clock_fit.c. */
bool lum_clock_fit_pack(lum_clock_fit *fit, lum_pack *pack);

/* us x ppb, in ns. */
static inline int64_t lum_clock_scale(int64_t us, int64_t ppb)
{
    return us / 1000000 * ppb + us % 1000000 * ppb / 1000000;
}

/* By how much b arrived later than a, if a took the usual time. */
static inline int64_t lum_clock_lateness(const struct lum_clock_reading *a,
                                         const struct lum_clock_reading *b,
                                         int64_t drift_ppb)
{
    const int64_t us = b->clock_us - a->clock_us;
    return b->arrival_ns - a->arrival_ns - us * 1000 -
           lum_clock_scale(us, drift_ppb);
}

/* By how much a reading arrived later than the line says. */
static inline int64_t lum_clock_above(const struct lum_clock_line *line,
                                      const struct lum_clock_reading *r)
{
    return lum_clock_lateness(&line->at, r, line->drift_ppb);
}

/* The line's error, if the stamps are exact and the host's clock has a steady
 * rate; grows with the distance from the arrivals that it rests on. */
int64_t lum_clock_error(const struct lum_clock_line *line, int64_t clock_us);

/* Lay the line under a window that is not empty. Its drift is measured if that
 * is more exact than the known one. line: its drift is where the search begins;
 * overwritten. Returns whether the drift was measured. */
bool lum_clock_lay(struct lum_clock_window *window, int64_t known_ppb,
                   int64_t known_error_ppb, struct lum_clock_line *line);

/* Whether a line lies under all of a window. */
bool lum_clock_holds(const struct lum_clock_window *window,
                     const struct lum_clock_line *line);

/* A number within +-most, a reading, a line, in either direction. near: a
 * reading that is packed before it. */
void lum_clock_pack_limited(lum_pack *pack, int64_t *value, int64_t most);
void lum_clock_reading_pack(lum_pack *pack, struct lum_clock_reading *r,
                            const struct lum_clock_reading *near);
void lum_clock_line_pack(lum_pack *pack, struct lum_clock_line *line,
                         const struct lum_clock_reading *near);

/* --- The arrivals that a fit keeps: clock_arrivals.c --- */

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
