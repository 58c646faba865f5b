/* The exact points as CSV, in the order in which a decoder of the whole capture
 * hands out lines. */
#ifndef LUMSIM_TRUTH_H
#define LUMSIM_TRUTH_H

#include "lum/base/error.h"
#include "lum/profile.h"
#include "sim/render.h"

#include <stdbool.h>
#include <stdint.h>

struct truth;

/* is_utc: times are those that the capture's clock shows, and not the sensor's.
 * 0, or -1 with the reason in error. layout is copied. */
int truth_open(const char *path, const lum_layout *layout, bool is_utc,
               struct truth **out, lum_error *error);

/* The next line of an eye, with the time at which it began; copied. 0, or -1
 * with the reason in error. */
int truth_add(struct truth *truth, const lum_sim_line *line, int64_t utc_us,
              lum_error *error);

/* 0, or -1 with the reason in error; then no file is left. */
int truth_close(struct truth *truth, lum_error *error);

/* Remove what was written. NULL is allowed. */
void truth_abort(struct truth *truth);

#endif
