/* The files that a run is told of the sensor, and where it was. */
#ifndef LUMVIEW_SETTING_FILES_H
#define LUMVIEW_SETTING_FILES_H

#include "../common/geometry.h"
#include "options.h"

#include "lum/base/error.h"

struct files {
    struct geometry geometry;
    lum_profile second; /* where there is one */
    lum_rig_files rig;  /* likewise */
    lum_poses *poses;   /* to be freed; NULL: none */
};

/* Those of the options, which lead to out then. 0, or -1 with the reason in
 * error. */
int files_load(struct options *o, struct files *out, lum_error *error);

#endif
