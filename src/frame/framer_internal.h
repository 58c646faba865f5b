/* A framer and what it knows of each sensor. */
#ifndef LUM_FRAME_FRAMER_INTERNAL_H
#define LUM_FRAME_FRAMER_INTERNAL_H

#include "capture/demux_state.h"
#include "drafts.h"
#include "line_points.h"
#include "lum/frame/framer.h"
#include "pace.h"
#include "pause.h"
#include "under_way.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The lines of the frame before, by which the next one's missing lines are
 * counted. */
typedef struct lum_lines_before {
    uint32_t lines[LUM_EYES]; /* of whole lines, as lum_frame_whole_rows() */
    bool has_next; /* next[] replaces lines[] from frame next_from on */
    int64_t next_from;
    uint32_t next[LUM_EYES];
} lum_lines_before;

/* What a framer knows of one sensor. */
typedef struct lum_sensor_stream {
    lum_drafts drafts;
    bool has_joined; /* a line came */
    int64_t joined;  /* in this frame */
    bool has_done;   /* a frame was handed out */
    int64_t done;    /* the highest of these */
    bool has_range;  /* a frame was complete */
    int64_t first;
    int64_t last;
    lum_lines_before before;
    uint64_t lines_late; /* since the frame before */
    lum_pace pace;
    lum_clock_fit *clock; /* NULL: the layout has none */
    lum_under_way_state under_way;
    lum_pause pause;
    lum_framer_counters counters;
} lum_sensor_stream;

/* Which lines and frames the options select. */
typedef struct lum_framer_choice {
    unsigned wants;
    unsigned eyes;
    bool has_range;
    int64_t frame_first;
    int64_t frame_last;
    bool drop_incomplete;
    bool only_first;
} lum_framer_choice;

/* Work that the next call continues before it takes more records. */
typedef enum lum_in_hand {
    IN_HAND_NOTHING,
    IN_HAND_NEW,  /* a line that is not counted */
    IN_HAND_LINE, /* counted, and in no frame yet */
    IN_HAND_END   /* of a frame */
} lum_in_hand;

struct lum_framer {
    lum_demux *demux;
    lum_checked_views views;
    lum_framer_choice choice;
    bool has_clock;
    bool has_from; /* frames before one are skipped */
    int64_t from;
    bool is_flushing;
    lum_pause pause; /* of a sensor without lines */
    lum_frame_pool *pool;
    lum_crew *crew; /* NULL: the caller makes all points */
    lum_sensor_stream *sensors[LUM_DEMUX_SENSORS_MAX];

    lum_in_hand in_hand;
    lum_line_points line; /* the latest */
    bool is_wanted;
    uint64_t selected; /* points of it that the first view selects */
    int64_t number;    /* of the frame that the last event is about */
    lum_draft out;     /* what was handed out */
};

/* Otherwise only what a frame lacks is counted. */
static inline bool lum_framer_makes_frames(const lum_framer *framer)
{
    return (framer->choice.wants & LUM_WANT_FRAMES) != 0;
}

/* NULL: there is no memory. */
lum_sensor_stream *lum_sensor_stream_new(const lum_framer *framer);

/* NULL is allowed. */
void lum_sensor_stream_free(lum_sensor_stream *sensor);

/* A line of it came: what this means for its clock and its pauses. is_decided:
 * as lum_pause_take(). */
void lum_sensor_stream_take(lum_sensor_stream *sensor, const lum_line *line,
                            bool is_decided);

/* Begin a frame of it. is_empty: none of its lines came; otherwise it is likely
 * to have about as many points as recent ones. False: there is no memory. */
bool lum_sensor_stream_begin(const lum_framer *framer,
                             const lum_sensor_stream *sensor, lum_draft *draft,
                             int64_t number, bool is_empty);

/* A frame of it is whole: count what it lacks, and complete it in all views. */
void lum_sensor_stream_seal(lum_framer *framer, lum_sensor_stream *sensor,
                            lum_draft *draft);

#endif
