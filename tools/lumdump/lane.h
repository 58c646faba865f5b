/* The ring and the thread of one output of a live run. Each output has its own
 * lane, so that one that stalls or fails does not stop the others. The summary
 * has a lane without an output. The thread takes what a sensor sent out of the
 * ring, makes lines and points of it and writes them; it may wait for its disk
 * or its reader as long as it takes. */
#ifndef LUMDUMP_LANE_H
#define LUMDUMP_LANE_H

#include "convert.h"
#include "say.h"

#include "../common/ring.h"
#include "lum/net/socket.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* The state of an output, or how it ended. */
enum lane_end {
    LANE_LIVES,
    LANE_WHOLE,       /* finished */
    LANE_READER_LEFT, /* nobody reads it any more */
    LANE_FAILED,      /* see the error */
    LANE_STALLED,     /* it stood still, and was given up */
    LANE_ABANDONED    /* the same, and its thread waits still */
};

/* What it makes of datagrams. */
enum lane_kind {
    LANE_SUMMARY,   /* counts them; it has no output */
    LANE_RECORDING, /* has them alone, so nothing is decoded */
    LANE_POINTS
};

/* Where its output goes. */
enum lane_target {
    LANE_STREAM, /* a pipe or a terminal */
    LANE_FILE,
    LANE_LATE_PIPE /* whose opening waits for its reader */
};

/* In place of an output. */
#define LANE_OF_SUMMARY SIZE_MAX

/* When it was last seen to move; of lane_look(). */
struct lane_moves {
    int64_t at_ns;    /* when it took something, or waited for its disk to
                         finish a file */
    uint64_t dropped; /* as of then */
    int64_t read_ns;  /* when it took something, or had nothing to take */
};

/* What its thread has come to. */
struct lane_view {
    uint64_t taken; /* datagrams, as of now; the rest as of the last tenth of a
                       second */
    uint64_t points;
    uint64_t lost_words; /* without lines that were under way when it began */
    uint64_t lost_lines; /* skipped, or without all angles; likewise */
    uint64_t refused;    /* datagrams that reassembly could not use */
    bool has_all;        /* that --frames asks for */
    bool has_ended;      /* its outputs are closed, and no file is lost that
                            lane_take_lost() has not given */
};

/* Where datagrams went from and to. */
struct lane_ends {
    lum_endpoint sensor;
    lum_endpoint client;
};

/* Files that are found lost between two looks from outside. */
#define LANE_LOST_MAX 4u

/* What both sides use, under the lock. */
struct lane_shared {
    pthread_mutex_t lock;
    struct lane_view view;
    uint64_t dropped;
    lum_error lost[LANE_LOST_MAX]; /* what became of files, to be told */
    size_t lost_count;
    bool keep;
    bool is_dropped;
};

/* What is the thread's alone until it is joined. */
struct lane_work {
    enum pass_result result;
    lum_error failure;
    int64_t pipes_ns; /* when they were flushed */
    int64_t files_ns;
    int64_t view_ns;   /* when the view was made */
    int64_t health_ns; /* when outputs were told of it */
};

struct lane {
    struct options options; /* of its output alone */
    struct pass own;        /* the summary's lane uses the run's instead */
    struct pass *pass;
    struct ring *ring;
    struct closer *closer; /* of a file; else NULL */
    struct lane_ends ends;
    pthread_t thread;
    bool runs; /* the thread was started, and is not joined */
    enum lane_kind kind;
    enum lane_target target;

    struct lane_work work;
    struct lane_shared shared;

    enum lane_end end;
    lum_error error;       /* why it failed */
    int64_t ended_ns;      /* monotonic; 0: with the run */
    struct lane_view view; /* as last looked */
    uint64_t dropped;      /* datagrams that the ring had no room for */
    struct say_count told; /* of them */
    struct lane_moves moves;
};

/* The lane of an output. The output is open, except a pipe without a reader:
 * the lane's own thread waits for the reader. run: also the pass of the
 * summary's lane. NULL with the reason in error. */
struct lane *lane_new(struct pass *run, size_t output, size_t ring_size,
                      lum_error *error);

int lane_start(struct lane *lane, struct lane_ends ends, lum_error *error);

/* No more will come. Its outputs are finished once all that is in the ring has
 * been written, where keep is set or one of them has failed, which is aborted;
 * else all are. Does not wait. */
void lane_finish(struct lane *lane, bool keep);

/* Take back a start, where nothing came yet. A thread that waits for the reader
 * of a pipe is left to itself. */
void lane_stop(struct lane *lane);

/* The receiving side; waits for nothing. */
void lane_put(struct lane *lane, const struct ring_item *item);

/* What it is called. */
const char *lane_name(const struct lane *lane);

/* Check its state; an end is noted. Returns whether it has ended since the last
 * check. */
bool lane_look(struct lane *lane, int64_t now_ns);

/* What became of a file that others removed or renamed: once while it is
 * written, and once when it is finished, except of the first if that says how
 * the lane ended. False: no more so far. */
bool lane_take_lost(struct lane *lane, lum_error *out);

/* Whether its buffer is full and nothing was taken from it for this long. */
bool lane_stands_still(const struct lane *lane, int64_t now_ns, int64_t limit);

/* Whether a reader of messages has taken nothing for this long though there is
 * something, as one that hangs or was stopped. */
bool lane_is_unread(const struct lane *lane, int64_t now_ns, int64_t limit);

/* Give up an output that stalls. */
void lane_drop(struct lane *lane, int64_t now_ns);

/* Free it. False: its thread still waits, so nothing that it uses may be. NULL
 * is allowed. */
bool lane_free(struct lane *lane);

#endif
