/* A framer, what it knows of each sensor, and its frames under way. */
#ifndef LUM_FRAME_FRAMER_INTERNAL_H
#define LUM_FRAME_FRAMER_INTERNAL_H

#include "lum/frame/framer.h"

#include "capture/demux_state.h"
#include "pause.h"
#include "threads.h"

/* --- The points of one line at a time: line_points.c --- */

/* Views that a caller asked for, once they are checked. */
typedef struct lum_checked_view {
    lum_view asked;
    uint32_t window; /* of its smoothing; 0: none */
    lum_smooth smooth;
} lum_checked_view;

typedef struct lum_checked_views {
    lum_checked_view view[LUM_VIEWS_MAX];
    size_t count;
} lum_checked_views;

typedef struct lum_line_points {
    const lum_projector *projector; /* of the line's sensor */
    const lum_line *line;
    const lum_raw_list *packets; /* NULL: frames keep nothing raw */
    uint64_t rising;             /* words that give a point; set by _count() */
    uint64_t falling;
    lum_point_losses losses;
    lum_line smoothed;                   /* the line, as a view smooths it */
    const lum_checked_view *smoothed_by; /* NULL: by none yet */
    lum_angle angles[LUM_LINE_PIXELS];
    lum_column_work work;
    unsigned leaves; /* what samples have not: LUM_LEAVE_DEGREES, ... */
    const lum_checked_view *sampled_by; /* NULL: there are no samples of it */
    size_t sample_count;
} lum_line_points;

/* Take another line, which lives until the next one or the end, as its
 * projector does. */
void lum_line_points_begin(lum_line_points *points, const lum_line *line,
                           const lum_projector *projector);

/* Count the points of the line before any selection, and the words that give
 * none. */
void lum_line_points_count(lum_line_points *points);

/* How many of them a view selects; NULL: rising edges. */
uint64_t lum_line_points_select(lum_line_points *points,
                                const lum_checked_view *view);

/* The samples of the line in a view, which live until the next call. */
size_t lum_line_points_sample(lum_line_points *points,
                              const lum_checked_view *view);

/* Whether a view has as many points as its edges have words, so that they are
 * counted before they are made; n gets their number. */
bool lum_line_points_are_known(const lum_line_points *points,
                               const lum_checked_view *view, uint64_t *n);

/* What a frame of this view takes of the line, which is smoothed for it now, or
 * by who makes the points. */
lum_frame_part lum_line_points_part(lum_line_points *points,
                                    const lum_checked_view *view,
                                    bool is_smoothed);

/* Views may go: nothing of them is remembered. */
void lum_line_points_forget(lum_line_points *points);

/* --- Frames under way, and a line into the views of its own: drafts.c --- */

/* An eye may begin a frame before the other has ended the one before. */
#define LUM_DRAFTS_MAX 4u

/* A frame under way. Without views it has one frame without points, for what it
 * lacks. */
typedef struct lum_draft {
    bool is_used;
    int64_t number;
    lum_checked_views views;
    size_t frame_count;
    lum_frame *frames[LUM_VIEWS_MAX];
} lum_draft;

/* Of one sensor; zero before the first line. */
typedef struct lum_drafts {
    lum_draft draft[LUM_DRAFTS_MAX];
    size_t recent_points[LUM_VIEWS_MAX]; /* that frames of a view have */
} lum_drafts;

/* By its number; one that is not used; the one with the lowest number. NULL:
 * there is none. */
lum_draft *lum_drafts_find(lum_drafts *drafts, int64_t number);
lum_draft *lum_drafts_find_unused(lum_drafts *drafts);
lum_draft *lum_drafts_find_lowest(lum_drafts *drafts);

/* Begin an unused one. views: copied; NULL: none.
 * recent_points: that each view is likely to have; NULL: not known.
 * False: there is no memory, and it stays unused. */
bool lum_draft_begin(lum_draft *draft, int64_t number,
                     const lum_checked_views *views, lum_frame_pool *pool,
                     const size_t *recent_points);

/* Put a line into all its views. threads: makes the points that it can; NULL:
 * the caller makes all. With makes_points false the line is counted alone.
 * False: there is no memory, and the line is in none of the views. */
bool lum_draft_add(lum_draft *draft, lum_line_points *line,
                   lum_line_threads *threads, bool makes_points);

/* It is whole: remember how many points its views have. */
void lum_drafts_note_sizes(lum_drafts *drafts, const lum_draft *draft);

/* Release its frames; it is unused then. */
void lum_draft_drop(lum_draft *draft);

/* The same of all whose number is below one. */
void lum_drafts_drop_below(lum_drafts *drafts, int64_t number);

/* Frames a second of one sensor; zero before the first line. */
typedef struct lum_pace {
    bool has_frame;
    bool has_begin;
    int64_t frame; /* the newest */
    int64_t first; /* the first whose begin was seen, and when that was */
    int64_t first_ns;
    int64_t last_ns; /* when the newest began */
} lum_pace;

/* --- Lines under way when a stream is joined or left: sensor_stream.c --- */

/* Of one sensor; zero before the first line. The counters of losses include
 * what such a line lacks, although nothing was lost. */
typedef struct lum_under_way_state {
    lum_under_way counts;
    bool has_joined[LUM_EYES];
    bool is_leaving;
    lum_under_way last[LUM_EYES];
} lum_under_way_state;

/* A line was handed out. If the first line of an eye lacks anything, it had
 * begun before the stream was joined. no_angle: its words whose pixel has no
 * angles. */
void lum_under_way_take(lum_under_way_state *state, const lum_line *line,
                        uint64_t no_angle);

/* The following lines are those still open at the end; the last of each eye was
 * unfinished. */
void lum_under_way_leave(lum_under_way_state *state);

/* The stream continues after its end: it is joined again. */
void lum_under_way_join(lum_under_way_state *state);

/* --- The framer and its sensors: framer.c, sensor_stream.c --- */

/* The lines of the frame before, by which the next one's missing lines are
 * counted. */
typedef struct lum_lines_before {
    uint32_t lines[LUM_EYES]; /* of whole lines, as lum_frame_whole_rows() */
    bool has_next; /* next[] replaces lines[] from frame next_from on */
    int64_t next_from;
    uint32_t next[LUM_EYES];
} lum_lines_before;

/* How lines of a sensor become frames: that of a member of a rig, or of all
 * sensors. */
typedef struct lum_member_way {
    lum_projector projector;
    lum_pose pose; /* of its points */
    bool is_placed;
    bool has_clock;
    lum_pause pause; /* of a sensor without lines */
} lum_member_way;

/* What a framer knows of one sensor. */
typedef struct lum_sensor_stream {
    size_t way; /* of the framer's ways */
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
    lum_member_way *ways; /* as many as members; 1: there is no rig */
    size_t member_count;  /* 0: there is no rig */
    bool has_from;        /* frames before one are skipped */
    int64_t from;
    bool is_flushing;
    lum_frame_pool *pool;
    lum_line_threads *threads; /* NULL: the caller makes all points */
    lum_raw_watch *watch;      /* NULL: frames keep nothing raw */
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

/* Which of the framer's ways a sensor that the demultiplexer knows has. */
size_t lum_sensor_stream_way(const lum_framer *framer, size_t i);

/* A framer's sensor by its index, made if no line of it came yet: with this
 * way. NULL: there is no memory. */
lum_sensor_stream *lum_sensor_stream_at(lum_framer *framer, size_t i,
                                        size_t way);

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
