/* The shown frame, the wanted views and the status, shared by the threads that
 * make frames and the one that gets them. The lock is held for a few
 * assignments at a time. */
#ifndef LUMVIEW_STAGE_H
#define LUMVIEW_STAGE_H

#include "feed.h"
#include "picture.h"

#include <pthread.h>

/* An order to the player of a capture. */
struct orders {
    bool closing;
    bool plays;
    bool loops;
    double speed;
    bool has_seek;
    int64_t seek;
    int64_t steps;   /* from there, or from the shown frame */
    size_t wanted;   /* views */
    unsigned frames; /* shown at once */
    bool lacks_view; /* the shown frame, or one of those at once with it, is
                        missing or lacks a wanted view */
    unsigned serial; /* of the newest order */
};

/* Counters of feed_status. */
struct totals {
    uint64_t packets;
    uint64_t packets_joined; /* of them, captured joined with others */
    uint64_t bytes;
    uint64_t points;
    uint64_t lost_words;
    uint64_t lost_lines;
    uint64_t joined_words; /* of them, of lines that were under way */
    uint64_t joined_lines;
    uint64_t pauses;
    uint64_t refused;
};

/* The sum, or the nearest number to it. */
int64_t add_clamped(int64_t a, int64_t b);

void totals_add(struct totals *to, const struct totals *more);
void totals_subtract(struct totals *from, const struct totals *less);

struct stage {
    void (*wake)(void *context);
    void *context;
    struct frame_pool *pool; /* of the shown frame; its owner outlives this */

    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    struct orders orders;
    struct feed_view views[FEED_VIEWS_MAX];
    struct picture shown;
    struct trail trail; /* behind it */
    bool has_failed;
    struct feed_status status;
};

void stage_init(struct stage *stage, void (*wake)(void *context),
                void *context);
void stage_end(struct stage *stage);

/* The side that makes frames. */

/* Copies the orders; a jump among them is the caller's then. */
void stage_take_orders(struct stage *stage, struct orders *out);

/* Wait until there is a newer order, or a moment, at most a quarter of a
 * second; monotonic. */
void stage_wait(struct stage *stage, unsigned serial, int64_t until_ns);

/* Wait until somebody looks. False: the stage is closing. */
bool stage_wait_wanted(struct stage *stage);

bool stage_is_closing(struct stage *stage);

/* The views that are wanted now. */
size_t stage_views(struct stage *stage, struct feed_view *views);

/* A jump leads to a frame. Returns the first of those that are shown at once
 * with it; all of these are kept or shown from now on. */
int64_t stage_aim(struct stage *stage, int64_t target);

/* Keep one of those before the target; it is the stage's then. */
void stage_keep(struct stage *stage, struct picture *picture);

/* Show a picture, in place of the one before; it is the stage's then. */
void stage_show(struct stage *stage, struct picture *picture,
                int64_t complete_ns);

void stage_set_state(struct stage *stage, enum feed_state state);
void stage_set_message(struct stage *stage, const char *message);
/* Where a recording is missing, as text. */
void stage_set_gaps(struct stage *stage, const char *gaps);
/* What is odd about the records, as text. */
void stage_set_remarks(struct stage *stage, const char *remarks);
void stage_set_others(struct stage *stage, const char *others);
/* Why the layout may be another one. */
void stage_set_doubt(struct stage *stage, const char *doubt);
/* All is over: state and message stay from here on. */
void stage_fail(struct stage *stage, const char *message);

void stage_set_range(struct stage *stage, int64_t first, int64_t last);
void stage_set_totals(struct stage *stage, const struct totals *totals);

/* Live: received and lost packets. */
void stage_set_received(struct stage *stage, uint64_t packets, uint64_t bytes,
                        uint64_t kernel, uint64_t ring);
void stage_set_laser(struct stage *stage, bool is_known, uint16_t status);

/* The side that asks. */

/* The status and the shown frame do not change between these two. */
const struct feed_status *stage_begin_look(struct stage *stage);
void stage_end_look(struct stage *stage);

/* An order is given between these two. */
struct orders *stage_begin_order(struct stage *stage);
void stage_end_order(struct stage *stage);

#endif
