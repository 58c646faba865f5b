/* What is true of a simulated capture: its exact points as CSV, in the order in
 * which a decoder of the whole capture hands out lines, and the calibration. */
#ifndef LUMSIM_TRUTH_H
#define LUMSIM_TRUTH_H

#include "base/outfile.h"
#include "lum/base/error.h"
#include "lum/profile.h"
#include "options.h"

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

/* truth_yaml.c: write the true calibration as a YAML file that loads as it is;
 * lum_outfile_finish() gives it its name. 0, or -1 with the reason in error;
 * then out is as before. */
int truth_yaml_begin(const struct options *o, lum_outfile *out,
                     lum_error *error);

#endif
