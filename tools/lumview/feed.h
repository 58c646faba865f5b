/* Frames of a source, capture or sensor, made by separate threads, or where
 * there are none by feed_work(). The server, in its one thread, gets the newest
 * frame and sets which views are wanted. */
#ifndef LUMVIEW_FEED_H
#define LUMVIEW_FEED_H

#include "../common/geometry.h"
#include "options.h"
#include "page_frame.h"

#include "lum/base/error.h"
#include "lum/points.h"

#include <stdbool.h>
#include <stdint.h>

/* How a browser wants frames: edges and smoothing. Frames are made for those
 * that somebody wants now. */
struct feed_view {
    lum_edges edges;
    unsigned smooth; /* window; 0: none */
};
#define FEED_VIEWS_MAX 8u

/* Several, each once. */
struct feed_views {
    struct feed_view at[FEED_VIEWS_MAX];
    size_t count;
};

/* The place of one among them; their count: it is not. */
static inline size_t feed_views_find(const struct feed_views *views,
                                     const struct feed_view *view)
{
    size_t i = 0;
    while (i < views->count && (views->at[i].edges != view->edges ||
                                views->at[i].smooth != view->smooth)) {
        i++;
    }
    return i;
}

/* Frames that a page shows at once. */
#define FEED_FRAMES_MAX 50

enum feed_state {
    FEED_WAITING, /* no data yet */
    FEED_PLAYING,
    FEED_PAUSED,
    FEED_ENDED,  /* a capture, its end reached, without loop */
    FEED_SILENT, /* a sensor that stopped sending */
    FEED_FAILED  /* see message */
};

/* Texts for a person, "" where there is nothing to tell, in the order in which
 * the page has them. */
enum feed_text {
    FEED_MESSAGE, /* failure, laser off, silence */
    FEED_REMARKS, /* what is odd about the records of a capture */
    FEED_DOUBT,   /* what suggests another layout, and what finds it */
    FEED_OTHERS,  /* whose calibration or profile is not used */
    FEED_GAPS,    /* where a recording is missing between captures */
    FEED_TEXTS
};
#define FEED_TEXT_BYTES 1024

/* Packets; live, those that the session got. */
struct feed_received {
    uint64_t packets;
    uint64_t joined; /* of a capture: of them, those captured joined with
                        others */
    uint64_t bytes;
};

/* What became of them. */
struct feed_decoded {
    uint64_t points;     /* of the default view: rising edges, as projected */
    uint64_t lost_words; /* words and lines, see lumdump's status line */
    uint64_t lost_lines;
    uint64_t joined_words; /* of both, of lines that were under way when the
                              stream was joined or left: not lost */
    uint64_t joined_lines;
    uint64_t pauses;  /* of the sensor or one eye; their lines are lost */
    uint64_t refused; /* datagrams that reassembly could not use */
};

/* Live: datagrams that this host lost. */
struct feed_dropped {
    uint64_t kernel;
    uint64_t ring;
};

/* What a frame lacks, or several together. */
struct feed_loss {
    uint64_t words; /* of ranges */
    uint64_t lines; /* as far as is known, and not in pauses */
    uint64_t pauses;
};

/* Where a capture that was read as far as this lacks something. */
#define FEED_MARKS_MAX 400u
struct feed_mark {
    int64_t frame; /* the first of those that it is of, which is a multiple of
                      their number */
    struct feed_loss loss;
};
struct feed_marks {
    struct feed_mark at[FEED_MARKS_MAX]; /* by frame */
    size_t count;
    int64_t frames; /* that each is of; 0: there are none yet */
};

/* As of now; all counters since the start. For a capture they count the played
 * frames, not the frames skipped on the way to one. */
struct feed_status {
    enum feed_state state;
    bool is_live;
    char texts[FEED_TEXTS][FEED_TEXT_BYTES];
    int64_t frame;  /* newest shown */
    bool has_range; /* capture: first and last frame are known; never of a
                       source that can be read once */
    int64_t first_frame;
    int64_t last_frame;
    double scanned; /* share of a capture's files that was looked through for
                       them, 0 .. 1; 0 for one that can be read only once */
    unsigned marks; /* how often feed_look_marks() has changed */
    double speed;   /* capture */
    bool loops;     /* capture */
    struct feed_received received;
    struct feed_decoded decoded;
    struct feed_dropped dropped;
    uint64_t frames;
    int64_t frame_ns; /* when the newest was complete, monotonic */
    bool has_laser;   /* a status came, and the sensor still answers */
    uint16_t laser;   /* the last one */
};

struct feed;

/* Open the source and begin. geometry: of the command line's files; what the
 * source says of itself is taken, and then the options' keys. second: a profile
 * by which the same points are shown beside; NULL: none. A capture plays
 * only while a view is wanted. wake(context) is called from the feed's threads
 * when there is a new frame or the state has changed; it must not wait. 0, or
 * -1 with the reason in error.
 */
int feed_open(const struct options *options, const struct geometry *geometry,
              const lum_profile *second, void (*wake)(void *context),
              void *context, struct feed **out, lum_error *error);
/* Ends the threads; live with --laser: the laser is off, or error has the
 * reason. */
int feed_close(struct feed *feed, lum_error *error);

/* Does some work, at most about 20 ms, where the system has no threads: reads,
 * decodes, shows what is due. Returns nanoseconds until there is more to do, at
 * most a second; 0: at once. An order may bring more before. */
int64_t feed_work(struct feed *feed);

/* The views that are wanted now replace those before. */
void feed_want(struct feed *feed, const struct feed_view *views, size_t count);

/* So many frames, from 1 to FEED_FRAMES_MAX, are shown at once: those before
 * the newest are kept, and of files made again after a jump. */
void feed_keep(struct feed *feed, unsigned frames);

/* The newest frame of a view, kept for the caller; NULL: none yet. */
struct frame *feed_newest(struct feed *feed, const struct feed_view *view);

/* Likewise one of those before it, by its number; NULL: it is not there. */
struct frame *feed_past(struct feed *feed, const struct feed_view *view,
                        int64_t number);

void feed_look(struct feed *feed, struct feed_status *out);
void feed_look_marks(struct feed *feed, struct feed_marks *out);

/* Mount and rotation of an eye, for the page to compute range and angles; those
 * of a rig's sensors are eyes 2 i and 2 i + 1, in the vehicle's frame. */
void feed_geometry(const struct feed *feed, unsigned eye, float mount[3],
                   float rotation[9]);

/* The profile in use; the second one, or NULL: there is none. */
const lum_profile *feed_profile(const struct feed *feed, bool is_second);

/* For a capture; ignored live. Steps back are ignored if the source can be read
 * only once. Jumps beyond the ends go to the ends. */
void feed_play(struct feed *feed, bool plays); /* at the end: from the start */
void feed_step(struct feed *feed, int64_t frames); /* pauses; may be negative */
void feed_seek(struct feed *feed,
               int64_t frame); /* nearest there is; keeps playing or paused */
void feed_speed(struct feed *feed, double speed); /* 0.01 .. 100 */
void feed_loop(struct feed *feed, bool loops);

#endif
