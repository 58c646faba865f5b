/* What is true of a simulated capture: its exact points as CSV, in the order in
 * which a decoder of the whole capture hands out lines; where the sensor was;
 * the calibration. */
#ifndef LUMSIM_TRUTH_H
#define LUMSIM_TRUTH_H

#include "base/outfile.h"
#include "cloud/sink.h"
#include "lum/base/error.h"
#include "lum/pose.h"
#include "lum/profile.h"
#include "options.h"

#include <stdbool.h>
#include <stdint.h>

struct truth;

/* Begin the file of the exact points of a sensor: in its frame, or in that of
 * its vehicle if it is on one; with the times that the capture's clock shows,
 * or the sensor's. 0, or -1 with the reason in error. The options are kept. */
int truth_open(const struct options *o, struct truth **out, lum_error *error);

/* The next line of an eye, with the time at which it began; copied. 0, or -1
 * with the reason in error. */
int truth_add(struct truth *truth, const lum_sim_line *line, int64_t utc_us,
              lum_error *error);

/* 0, or -1 with the reason in error; then no file is left. */
int truth_close(struct truth *truth, lum_error *error);

/* Remove what was written. NULL is allowed. */
void truth_abort(struct truth *truth);

/* Begin a TUM file of the true poses, to which lum_sink_close() or
 * lum_sink_abort() puts an end. 0, or -1 with the reason in error. */
int truth_poses_open(const struct options *o, lum_sink **out, lum_error *error);

/* The next one. 0, or -1 with the reason in error. */
int truth_poses_add(lum_sink *poses, int64_t time_ns, const lum_pose *pose,
                    lum_error *error);

/* Write the true calibration as a YAML file that loads as it is;
 * lum_outfile_finish() gives it its name. 0, or -1 with the reason in error;
 * then out is as before. */
int truth_yaml_begin(const struct options *o, lum_outfile *out,
                     lum_error *error);

#endif
