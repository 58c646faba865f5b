/* One pass over a source: records to lines to points to outputs. Where records
 * come from is the caller's matter. */
#ifndef LUMDUMP_CONVERT_H
#define LUMDUMP_CONVERT_H

#include "../common/frame_watch.h"
#include "crew.h"
#include "cut.h"
#include "diagnosis.h"
#include "frame_lines.h"
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
    PASS_REFUSED,     /* the options cannot be fulfilled; see the error */
    PASS_DROPPED,     /* its output stalled, and was given up */
    PASS_FAILED       /* see the error */
};

struct pass {
    const struct options *options;
    const lum_layout *layout;
    const lum_projector *projector;
    const struct provenance_source *about; /* the capture; NULL: not one */
    bool has_changed;  /* a later part of it says something else of itself */
    bool counts_alone; /* it gets no outputs */
    struct outputs *outputs; /* NULL: count alone */
    struct crew *crew;       /* NULL: lines go to the outputs from here */
    struct outputs_notes notes;
    size_t notes_told; /* as many of them */

    struct summary summary;
    struct diagnosis diagnosis;
    struct cut *cut;           /* of captures; NULL: they are copied whole */
    struct frame_watch frames; /* for a rotation */
    bool has_sensor;           /* only packets of one sensor are used */
    uint32_t sensor;
    lum_framer *framer;
    struct frame_lines *frame_lines; /* NULL: frames are not wanted */
    bool wants_rows;
    bool has_all;         /* of --frames nothing more comes */
    lum_capture *capture; /* open before it is read first; NULL: live */
    lum_error warning;    /* set where the source broke off */
    uint64_t data_told;   /* packets of data, when outputs heard of it last */
    int64_t data_ns;      /* by the monotonic clock, when there were more */
    int64_t health_ns;    /* of a capture's time, likewise; 0: not yet */
    uint64_t dropped;     /* live: datagrams that its buffer had no room for */
    bool has_status;      /* the sensor's newest of its laser, from TLVs */
    uint16_t status;
    int64_t status_ns; /* by the monotonic clock */
};

/* Get ready. The pass's results live until pass_free(). */
enum pass_result pass_prepare(struct pass *pass, lum_error *error);

/* Take a record. */
enum pass_result pass_take(struct pass *pass, const lum_record *record,
                           lum_error *error);

/* Write a record to captures only, without decoding it. */
enum pass_result pass_record(struct pass *pass, const lum_record *record,
                             lum_error *error);

/* The end of the source: lines that are still open come out. */
enum pass_result pass_flush(struct pass *pass, lum_error *error);

/* Note in the summary which outputs lack points that came and were asked for,
 * and what pictures show: once all has come, and before they are closed. */
void pass_note_left_out(struct pass *pass);

void pass_free(struct pass *pass);

#endif
