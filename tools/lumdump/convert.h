/* One pass over a source: records to lines to points to outputs. Where records
 * come from is the caller's matter. */
#ifndef LUMDUMP_CONVERT_H
#define LUMDUMP_CONVERT_H

#include "../common/frame_watch.h"
#include "cut.h"
#include "diagnosis.h"
#include "frame_lines.h"
#include "options.h"
#include "outputs.h"
#include "pose_motion.h"
#include "rig_run.h"
#include "row_threads.h"
#include "summary.h"
#include "voxels.h"

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

/* The capture that is read; replay.c changes it. All zero: a live run. */
struct pass_capture {
    lum_capture *capture; /* open before it is read first */
    const struct provenance_source *about;
    bool has_changed;  /* a later part of it says something else of itself */
    lum_error warning; /* set where it broke off */
};

/* The newest status of the sensor's laser, from TLVs. */
struct pass_laser {
    bool is_known;
    uint16_t status;
    int64_t at_ns; /* monotonic */
};

/* When outputs heard last how the run goes; of health.c. */
struct pass_told {
    uint64_t packets;   /* of data, as of then */
    int64_t packets_ns; /* monotonic, when there were more of them */
    int64_t capture_ns; /* by a capture's time; 0: not yet */
};

/* The frames that are still to come. */
struct pass_frames {
    bool want_rows; /* they are to be arranged in rows */
    bool are_done;  /* of --frames nothing more comes */
};

struct pass {
    const struct options *options;
    const lum_layout *layout;
    const lum_projector *projector;
    struct motion *motion; /* NULL: points stay where they were seen */
    struct pass_capture source;
    bool counts_alone;        /* it gets no outputs */
    struct outputs *outputs;  /* NULL: count alone */
    struct voxels *voxels;    /* NULL: points are as they are */
    struct row_threads *rows; /* NULL: lines go to the outputs from here */
    struct outputs_notes notes;

    struct summary summary;
    struct diagnosis diagnosis;
    struct cut *cut; /* of captures; NULL: they are copied whole */
    struct frame_watch
        frames[LUM_RIG_SENSORS_MAX]; /* of each sensor, for a rotation */
    lum_framer *framer;
    struct frame_lines *frame_lines[LUM_RIG_SENSORS_MAX]; /* of each sensor;
                                               NULL: frames are not wanted */
    struct pass_frames frames_to_come;
    struct pass_laser laser;
    struct pass_told told;
    uint64_t dropped; /* live: datagrams that its buffer had no room for */
};

/* How it ends where an output has failed, by errno. */
enum pass_result pass_failure(void);

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
