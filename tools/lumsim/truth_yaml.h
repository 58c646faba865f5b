/* The true calibration of a simulated sensor, as a YAML file that loads as it
 * is. */
#ifndef LUMSIM_TRUTH_YAML_H
#define LUMSIM_TRUTH_YAML_H

#include "lum/base/error.h"
#include "options.h"

struct truth_yaml;

/* 0, or -1 with the reason in error. */
int truth_yaml_open(const char *path, const struct options *o,
                    struct truth_yaml **out, lum_error *error);

/* 0, or -1 with the reason in error; then no file is left. */
int truth_yaml_close(struct truth_yaml *truth, lum_error *error);

/* Remove what was written. NULL is allowed. */
void truth_yaml_abort(struct truth_yaml *truth);

#endif
