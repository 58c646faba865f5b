/* A line under the earliest arrivals: it converts the sensor's clock to the
 * host's, and has an error. */
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

struct lum_clock_reading {
    int64_t clock_us;
    int64_t arrival_ns;
};

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
    int64_t resolution_ns; /* of the stamps */
    int64_t
        late_ns[LUM_CLOCK_BUCKETS]; /* what the search for the error sorts */
};

/* The state of a fit, in either direction. False: something failed; then what
 * was read is of no use. */
bool lum_clock_fit_pack(lum_clock_fit *fit, lum_pack *pack);

/* Note a stamp. */
void lum_clock_stamps_note(struct lum_clock_stamps *stamps, int64_t arrival_ns);

/* Note a reading, us after another. */
void lum_clock_stamps_note_reading(struct lum_clock_stamps *stamps, int64_t us);

/* In ns; at least 1000 once there is a stamp. */
int64_t lum_clock_stamps_resolution(const struct lum_clock_stamps *stamps);

/* Note an arrival of the span. Returns the widest gap among the earliest. */
int64_t lum_clock_earliest_note(struct lum_clock_earliest *earliest,
                                int64_t late_ns);

/* us x ppb, in ns. */
int64_t lum_clock_scale(int64_t us, int64_t ppb);

/* By how much b arrived later than a, if a took the usual time. */
int64_t lum_clock_lateness(const struct lum_clock_reading *a,
                           const struct lum_clock_reading *b,
                           int64_t drift_ppb);

/* By how much a reading arrived later than the line says. */
int64_t lum_clock_above(const struct lum_clock_line *line,
                        const struct lum_clock_reading *r);

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

#endif
