/* Which frame of a capture is shown next, and when: where orders lead, which
 * frame is shown, and at which pace. The player owns it. */
#ifndef LUMVIEW_PLAYHEAD_H
#define LUMVIEW_PLAYHEAD_H

#include "capture_scan.h"
#include "decoder.h"
#include "stage.h"

#include <stdbool.h>
#include <stdint.h>

/* What the reader of the capture does next. */
enum play {
    PLAY_WAIT, /* nothing, until the head's time or an order; then ask again */
    PLAY_ON,   /* read on */
    PLAY_SHOW, /* show the frame, then read on */
    PLAY_REOPEN, /* read from the beginning, without the frames before from */
    PLAY_STOP
};

/* How the next frame is chosen. */
enum aim {
    AIM_NONE,  /* by the pace */
    AIM_FRAME, /* the target, or the first after it, whatever the pace */
    AIM_REMAKE /* likewise: it is shown already, and lacks a view */
};

struct playhead {
    struct stage *stage;
    struct scan *scan; /* NULL: the captures can be read once */
    enum aim aim;
    int64_t target;
    int64_t from; /* pass over frames before it */
    bool has_shown;
    int64_t shown;
    int64_t shown_ns; /* when it was, or should have been; monotonic */
    int64_t shown_arrival_ns;
    int64_t shown_clock_us;
    int64_t distance_ns; /* between the latest two frames */
    bool was_paused;     /* at the end of the capture */
    int64_t until_ns; /* of PLAY_WAIT; monotonic, INT64_MAX: an order alone */
    unsigned serial;  /* of the newest order that was taken */
};

/* The first frame is shown at once. stage and scan: kept. */
void playhead_init(struct playhead *out, struct stage *stage,
                   struct scan *scan);

/* Nothing passes before somebody looks: PLAY_ON. */
enum play playhead_begin(struct playhead *head);

/* The complete frame waits until it is due, unless an order leads elsewhere. */
enum play playhead_present(struct playhead *head, struct decoder *decoder,
                           struct picture *complete);

/* Take orders while no frame is complete. */
enum play playhead_look(struct playhead *head, struct decoder *decoder);

/* What was read is of no use: all is read from the start again, and goes on
 * behind the shown frame, or to where an order leads. */
enum play playhead_restart(struct playhead *head);

/* Stay at the end of the capture until an order leads elsewhere. */
enum play playhead_end(struct playhead *head, const struct decoder *decoder);

/* Likewise where the capture cannot be read. */
enum play playhead_fail(struct playhead *head);

#endif
