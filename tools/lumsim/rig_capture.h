/* Several sensors in one capture: the options of that, and those of each
 * sensor. */
#ifndef LUMSIM_RIG_CAPTURE_H
#define LUMSIM_RIG_CAPTURE_H

#include "lum/config/rig.h"
#include "options.h"

#include <stdbool.h>

/* Files that each sensor has of its own: exact points, calibration, labels. */
#define RIG_NAMES 3

/* What was read of a rig, and what was made of it. */
struct rig_files {
    lum_rig_files of;
    char *names[LUM_RIG_SENSORS_MAX][RIG_NAMES];
};

/* Whether these options go together; complains. A street is driven along, if
 * nothing else is said. */
bool rig_check(struct options *o);

/* Read the rig; complains. */
bool rig_load(struct options *o);

/* Give each sensor its options, which live as long as o, and see whether they
 * can be; complains. */
bool rig_spread(struct options *o);

/* Free what it holds. */
void rig_free(struct options *o);

/* So much later than that of one alone the last sensor's last frame ends, at
 * most; seconds. */
double rig_late_s(const struct options *o, int64_t frames);

#endif
