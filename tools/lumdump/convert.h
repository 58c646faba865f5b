/* One pass over a source: records to lines to points to an output. */
#ifndef LUMDUMP_CONVERT_H
#define LUMDUMP_CONVERT_H

#include "diagnosis.h"
#include "options.h"
#include "output.h"
#include "progress.h"
#include "summary.h"

#include "lum/io/error.h"

enum pass_result {
    PASS_DONE,        /* the source was read to its end */
    PASS_INTERRUPTED, /* a signal came */
    PASS_READER_LEFT, /* nobody reads the output any more */
    PASS_SENSORS,     /* an output, and several sensors: one must be named */
    PASS_REFUSED,     /* the options ask for what cannot be; see the error */
    PASS_FAILED       /* see the error */
};

struct pass {
    const struct options *options;
    const lum_layout *layout;
    const lum_projector *projector;
    struct output *output; /* NULL: count alone */
    struct progress *progress;

    struct summary summary;
    struct diagnosis diagnosis;
    lum_demux *demux;
    lum_sample *samples;
    lum_sample_workspace workspace;
    lum_error warning; /* set where the source broke off */
};

/* The pass's results live until pass_free(). */
enum pass_result pass_run(struct pass *pass, lum_error *error);
void pass_free(struct pass *pass);

#endif
