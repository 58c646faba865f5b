/* One pass over a source: records to lines to points to outputs. Where records
 * come from is the caller's matter. */
#ifndef LUMDUMP_CONVERT_H
#define LUMDUMP_CONVERT_H

#include "cut.h"
#include "diagnosis.h"
#include "frame_watch.h"
#include "options.h"
#include "outputs.h"
#include "summary.h"

#include "lum/base/error.h"
#include "lum/capture/capture.h"

enum pass_result {
    PASS_DONE,        /* the source was read to its end */
    PASS_INTERRUPTED, /* a signal came */
    PASS_READER_LEFT, /* nobody reads an output any more */
    PASS_SENSORS,     /* an output, and several sensors: one must be named */
    PASS_REFUSED,     /* the options ask for what cannot be; see the error */
    PASS_DROPPED,     /* its output stalled, and was given up */
    PASS_FAILED       /* see the error */
};

struct pass {
    const struct options *options;
    const lum_layout *layout;
    const lum_projector *projector;
    const struct provenance_source *about; /* the capture; NULL: not one */
    bool has_changed; /* a later part of it says something else of itself */
    struct outputs *outputs; /* NULL: count alone */
    struct outputs_notes notes;
    size_t notes_told; /* as many of them */

    struct summary summary;
    struct diagnosis diagnosis;
    struct cut *cut;           /* of captures; NULL: they are copied whole */
    struct frame_watch frames; /* for a rotation */
    bool has_sensor;           /* packets of one sensor alone matter */
    uint32_t sensor;
    lum_framer *framer;
    lum_capture *capture; /* open before it is read first; NULL: live */
    lum_error warning;    /* set where the source broke off */
};

/* Get ready. The pass's results live until pass_free(). */
enum pass_result pass_prepare(struct pass *pass, lum_error *error);

/* Take a record. */
enum pass_result pass_take(struct pass *pass, const lum_record *record,
                           lum_error *error);

/* Take a record into captures alone, without a look at what is in it. */
enum pass_result pass_record(struct pass *pass, const lum_record *record,
                             lum_error *error);

/* The end of the source: what is still open comes out. */
enum pass_result pass_flush(struct pass *pass, lum_error *error);

void pass_free(struct pass *pass);

#endif
