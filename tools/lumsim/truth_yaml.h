/* The true calibration of a simulated sensor, as a YAML file that loads as it
 * is. */
#ifndef LUMSIM_TRUTH_YAML_H
#define LUMSIM_TRUTH_YAML_H

#include "base/outfile.h"
#include "lum/base/error.h"
#include "options.h"

/* Write it; lum_outfile_finish() gives it its name. 0, or -1 with the reason in
 * error; then out is as before. */
int truth_yaml_begin(const struct options *o, lum_outfile *out,
                     lum_error *error);

#endif
