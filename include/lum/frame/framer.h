/** @file
 * Makes lines and frames of records: records are pushed in, events come out. It
 * is for programs that get records one at a time, for example from a socket.
 * For a file, use a lum_reader (lum/frame/reader.h): a framer with its source.
 *
 * A framer has a demultiplexer, and the unfinished frames of each sensor. There
 * are no callbacks: an event is returned before the record is consumed, and the
 * caller pushes the same record again:
 *
 * @code
 * lum_framer_event event;
 * while ((event = lum_framer_push(framer, &record, NULL)) != LUM_FRAMER_NONE) {
 *     switch (event) { ... }
 * }
 * @endcode
 *
 * At the end of the stream, do the same with lum_framer_flush(): without it the
 * last frame does not come. Let the compiler check that a switch names all
 * events (-Wswitch-enum), so that a new event is not missed.
 *
 * Only one thread at a time may use a framer; two share nothing. Its memory
 * does not grow with the stream: 550 KB for each sensor, and at most four
 * unfinished frames of each. */
#ifndef LUM_FRAME_FRAMER_H
#define LUM_FRAME_FRAMER_H

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/capture/demux.h"
#include "lum/frame/clock_fit.h"
#include "lum/frame/frame.h"
#include "lum/points.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most views of a framer. */
#define LUM_VIEWS_MAX 8u

/** Which points of a frame are wanted, and which columns. */
typedef struct lum_view {
    size_t struct_size; /**< sizeof(lum_view), as lum_view_default() sets */
    lum_selection selection; /**< which points */
    uint32_t smooth_window;  /**< of lum_smooth_init(); 0: no smoothing */
    uint32_t smooth_order;   /**< likewise */
    lum_columns columns;     /**< 0: no points, only lines */
} lum_view;

/** All rising returns, x y z, no smoothing. */
static inline void lum_view_default(lum_view *out)
{
    out->struct_size = sizeof *out;
    lum_selection_default(&out->selection);
    out->smooth_window = 0;
    out->smooth_order = 0;
    out->columns = LUM_COLUMNS_XYZ;
}

/** What a push returns. */
typedef enum lum_framer_event {
    LUM_FRAMER_NONE,      /**< the record was consumed, or all is flushed */
    LUM_FRAMER_LINE,      /**< a line: lum_framer_line() */
    LUM_FRAMER_FRAME,     /**< a frame: lum_framer_frame() */
    LUM_FRAMER_FRAME_END, /**< no line of lum_framer_frame_number() or of one
                               before it is expected */
    LUM_FRAMER_FAILED     /**< there was no memory; push again to try again */
} lum_framer_event;

/** Which events are wanted, a bit each. */
enum lum_framer_wants {
    LUM_WANT_FRAMES = 1,     /**< LUM_FRAMER_FRAME; else none is made */
    LUM_WANT_LINES = 2,      /**< LUM_FRAMER_LINE */
    LUM_WANT_FRAME_ENDS = 4, /**< LUM_FRAMER_FRAME_END */
    LUM_WANT_ALL_LINES = 8   /**< LUM_FRAMER_LINE also of lines that the options
                                  leave out: lum_framer_line_is_wanted() */
};

/** Most points of a frame by default. */
#define LUM_FRAME_POINTS_MAX 8000000u

/** Most threads of a framer. */
#define LUM_FRAMER_THREADS_MAX 64u

/** Which eyes are wanted, a bit each. */
enum lum_eyes {
    LUM_EYES_BLUE = 1,  /**< only blue */
    LUM_EYES_GREEN = 2, /**< only green */
    LUM_EYES_BOTH = 3   /**< both */
};

/** A sensor of a rig: how its lines become frames. It never grows. */
typedef struct lum_rig_member {
    uint32_t address;         /**< host order */
    const char *interface;    /**< as lum_demux_member.interface */
    const lum_layout *layout; /**< of its data; NULL: that of the options */
    const lum_calibration *calibration; /**< NULL: that of the options */
    const lum_projector
        *projector;       /**< in place of a calibration; NULL: none */
    const lum_pose *pose; /**< where it is on the vehicle: its points come in
                               the vehicle's frame; NULL: in its own. The
                               quaternion has length 1 */
    bool is_left_out;     /**< as lum_demux_member.is_left_out: it gives no
                             lines */
} lum_rig_member;

/** Most members of a rig. */
#define LUM_RIG_MEMBERS_MAX 8u

/** Options of a framer. All bytes 0 except struct_size are the defaults: both
 * eyes of all sensors, every frame, x y z of all rising returns. */
typedef struct lum_framer_options {
    size_t struct_size;                 /**< sizeof(lum_framer_options) */
    const lum_layout *layout;           /**< NULL: lum_layout_default() */
    const lum_calibration *calibration; /**< NULL: lum_calibration_default() */
    const lum_projector *projector;     /**< used instead of a calibration;
                                             copied; NULL: none */
    const lum_assembler_config *config; /**< NULL: the default constants */
    const lum_view *views; /**< view_count of them; NULL: lum_view_default() */
    size_t view_count;     /**< at most LUM_VIEWS_MAX */
    unsigned wants;        /**< ::lum_framer_wants; 0: frames */
    unsigned eyes;         /**< ::lum_eyes; 0: both */
    bool only_first; /**< if no sensor is requested, take the first that sends
                          data; for others, only packets are counted */
    bool has_sensor; /**< only one sensor is requested */
    uint32_t sensor; /**< its address, host order */
    bool has_range;  /**< only a range of frames is requested */
    int64_t frame_first;  /**< the first of them */
    int64_t frame_last;   /**< the last of them */
    bool drop_incomplete; /**< omit lines that lack angles or words */
    uint32_t points_max;  /**< of a frame; 0: LUM_FRAME_POINTS_MAX */
    uint32_t threads;     /**< that make the points of frames, including the
                               caller's, at most LUM_FRAMER_THREADS_MAX: the caller
                               reads and assembles while others project. 0 or 1:
                               only the caller's. Frames are identical, bit by bit.
                               The others start when 16 lines wait, get no signals,
                               and make only what the framer's functions wait for;
                               if the system has none, the caller does their work. A
                               child of fork() has none: it can free the framer, but
                               has lost the points of unfinished frames. They do not
                               help with a view that selects by returns, range or
                               box, nor in a build without threads. Each takes about
                               1 MB. */
    uint16_t port;        /**< as lum_demux_options.port; 0: ::LUM_PORT */
    const char *sensor_interface; /**< as lum_demux_options.sensor_interface;
                                NULL: the first of its address */
    bool records_are_single; /**< as lum_demux_options.records_are_single */
    const lum_rig_member *members; /**< the sensors of a rig; for others, only
                                        packets are counted. Not with has_sensor
                                        or only_first. NULL: no rig */
    size_t member_count;           /**< at most LUM_RIG_MEMBERS_MAX */
    bool keeps_raw; /**< each frame keeps the words, angles and packets of its
                         lines (lum/frame/raw.h): 4 KB a line, 5 bytes a word,
                         136 bytes a packet, and the time of copying them */
} lum_framer_options;

/** A framer. */
typedef struct lum_framer lum_framer;

/** Make a framer.
 * @param options read, with all that it points to, and not kept.
 * @param out     to be freed with lum_framer_free().
 * @param error   may be NULL; gets what is wrong: a value of the calibration,
 *                the constants, a view's smoothing, columns or count, the
 *                number of threads, or there is no memory.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_framer_new(const lum_framer_options *options,
                                  lum_framer **out, lum_error *error);

/** Free it; frames that were kept stay valid. NULL is allowed. */
void lum_framer_free(lum_framer *framer);

/** As lum_demux_set_interface(). */
void lum_framer_set_interface(lum_framer *framer, const char *name);

/** Take a record.
 * @param record from a lum_capture, or made of a datagram; its time is its
 *               arrival.
 * @param kind   may be NULL; as for lum_demux_push().
 * @return an event; LUM_FRAMER_NONE: the record was consumed. */
LUM_MUST_CHECK lum_framer_event lum_framer_push(lum_framer *framer,
                                                const lum_record *record,
                                                lum_packet_kind *kind);

/** The end of the stream: open lines and frames come out. Call until it returns
 * LUM_FRAMER_NONE. After that records may be pushed again. */
LUM_MUST_CHECK lum_framer_event lum_framer_flush(lum_framer *framer);

/** Set other views; each sensor's next frame that begins has them.
 * @param views view_count of them, at most LUM_VIEWS_MAX; with 0 frames have no
 *              points, and lum_framer_frame() of view 0 has their lines.
 * @return 0, or -1 with the reason in error; then nothing changes. */
LUM_MUST_CHECK int lum_framer_set_views(lum_framer *framer,
                                        const lum_view *views,
                                        size_t view_count, lum_error *error);

/** Skip all frames before this one: they are not projected, not handed out, and
 * their points are not counted. Those that have begun are dropped. */
void lum_framer_skip_to(lum_framer *framer, int64_t frame);

/** The line of the event LUM_FRAMER_LINE; lives until the next call. */
const lum_line *lum_framer_line(const lum_framer *framer);

/** Whether the options select that line, by its eye, frame and completeness.
 * False only with LUM_WANT_ALL_LINES. */
bool lum_framer_line_is_wanted(const lum_framer *framer);

/** The points of that line as a view selects and smooths them; the view's
 * columns do not matter.
 * @param view below the count of views.
 * @param out  gets an array of the framer that lives until the next call; NULL:
 *             only count them, which is much quicker.
 * @return how many there are. */
size_t lum_framer_line_samples(lum_framer *framer, size_t view,
                               const lum_sample **out);

/** The frame of the event LUM_FRAMER_FRAME, in a view.
 * @return NULL if there is no such view; else lives until the next push or
 *         flush, longer with lum_frame_keep(). */
const lum_frame *lum_framer_frame(const lum_framer *framer, size_t view);

/** The view that this frame was made for: the one set when the frame began.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return false if there is no such view, or struct_size is not set: then
 *         nothing is written. */
bool lum_framer_frame_view(const lum_framer *framer, size_t view,
                           lum_view *out);

/** The number of the last event's frame. */
int64_t lum_framer_frame_number(const lum_framer *framer);

/** The sensor of the last event: an index for lum_framer_count(). */
size_t lum_framer_sensor(const lum_framer *framer);

/** Which member of a rig a sensor is.
 * @param sensor an index of lum_demux_address().
 * @return its place in lum_framer_options.members; -1: it is no member, has
 *         sent no data, or there is no rig. */
int lum_framer_member(const lum_framer *framer, size_t sensor);

/** What is missing in lines in which the stream began or ended. It was not
 * lost. It never grows. */
typedef struct lum_under_way {
    uint64_t lines;    /**< of lines_missing_angles */
    uint64_t words;    /**< of lost_words */
    uint64_t no_angle; /**< of words whose pixel has no angles */
} lum_under_way;

/** Counters of the lines of one sensor. For its packets, see
 * lum_framer_demux(). */
typedef struct lum_framer_counters {
    size_t struct_size;       /**< sizeof(lum_framer_counters) */
    uint64_t lines[LUM_EYES]; /**< lines, by ::lum_eye, unwanted ones too */
    uint64_t rising;          /**< words that give a point, of rising edges */
    uint64_t falling;         /**< likewise, of falling edges */
    lum_point_losses losses;  /**< words that give none */
    uint64_t points;          /**< selected by the first view from the wanted
                                   lines; without a view, all rising ones */
    uint64_t lines_late;      /**< lines whose frame had been handed out */
    uint64_t points_late;     /**< selected by the first view from them */
    uint64_t points_cut;      /**< of the first view, beyond a frame's most
                                   points or lines */
    uint64_t lines_cut;       /**< lines beyond LUM_FRAME_LINES_MAX of a frame;
                                   their points are in points_cut */
    lum_under_way under_way;  /**< no losses */
    double frames_per_second; /**< of whole frames, by arrival; 0: not known */
    uint64_t lines_missing;   /**< sum of lum_frame_info.lines_missing of the
                                   frames that the options select, even if
                                   frames are not wanted */
    uint64_t missing_under_way; /**< of lines_missing: in frames in which the
                                     stream began or ended. They are not known
                                     to be lost */
    uint64_t pauses;            /**< times that the sensor, or one eye, sent no
                                     lines (docs/protocol.md, section 6, Pauses);
                                     this and the following three can become less
                                     again, as lines come */
    uint64_t paused_us;         /**< how long in all */
    uint64_t lines_in_pauses; /**< lines of both eyes missing in pauses, without
                                   those in lines_skipped */
    uint64_t stray_at_breaks; /**< of stray: packets that began a jump of the
                                   clock, which is a pause */
    uint64_t frames;          /**< complete frames that the options select; if
                                   frames are wanted, those handed out */
} lum_framer_counters;

/** Datagrams that were refused: late, in conflict, without room, stray,
 * malformed, of an unknown tag or type, foreign. A stray that began a jump of
 * the clock belongs to a pause and is not counted here, but in stray_at_breaks;
 * lum_assembly_counters.stray counts all.
 * @param packets, lines those of the same sensors. Thread safe. */
uint64_t lum_framer_refused(const lum_demux_counters *packets,
                            const lum_framer_counters *lines);

/** Read the counters of a sensor.
 * @param sensor an index of lum_demux_address(); if it sent no line, all are 0.
 * @param out    as for lum_frame_get_info().
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_framer_count(const lum_framer *framer, size_t sensor,
                            lum_framer_counters *out);

/** The first and the last frame of a sensor that are complete so far, including
 * skipped ones.
 * @return false: there is none. */
bool lum_framer_range(const lum_framer *framer, size_t sensor, int64_t *first,
                      int64_t *last);

/** The clock of a sensor, fitted to the arrival of its lines: UTC of any line,
 * drift.
 * @param sensor an index of lum_demux_address().
 * @return owned by the framer; NULL before the sensor's first line, or if the
 *         layout has no clock. */
const lum_clock_fit *lum_framer_clock(const lum_framer *framer, size_t sensor);

/** From the first line on, use what another framer has learned of the clocks in
 * the same stream, for example from the first part of a file, read in advance.
 * @param framer has taken nothing yet.
 * @param from   had the same options, except for wants.
 * @return 0, or -1 without memory. */
LUM_MUST_CHECK int lum_framer_learn_clocks(lum_framer *framer,
                                           const lum_framer *from);

/** The demultiplexer, for its counters and sensors. */
const lum_demux *lum_framer_demux(const lum_framer *framer);

#ifdef __cplusplus
}
#endif

#endif
