/* The shown frame, the wanted views and the status, shared by the threads that
 * make frames and the one that gets them. */
#ifndef LUMVIEW_STAGE_H
#define LUMVIEW_STAGE_H

#include "feed.h"
#include "thread_monitor.h"
#include "view_picture.h"

/* An order to the player of a capture. */
struct orders {
    bool closing;
    bool plays;
    bool loops;
    double speed;
    bool has_seek;
    int64_t seek;
    int64_t steps;   /* from there, or from the shown frame */
    bool is_wanted;  /* any view */
    unsigned frames; /* shown at once */
    bool lacks_view; /* the shown frame, or one of those at once with it, is
                        missing or lacks a wanted view */
    unsigned serial; /* of the newest order */
};

/* Counters of a decoder. */
struct totals {
    struct feed_received received;
    struct feed_decoded decoded;
};

/* The sum, or the nearest number to it. */
int64_t add_clamped(int64_t a, int64_t b);

void totals_add(struct totals *to, const struct totals *more);
void totals_subtract(struct totals *from, const struct totals *less);

void loss_add(struct feed_loss *to, const struct feed_loss *more);

struct stage {
    void (*wake)(void *context);
    void *context;
    struct frame_pool *pool; /* of the shown frame; its owner outlives this */

    struct monitor *monitor; /* guards what follows; news: orders */
    struct orders orders;
    struct feed_views views; /* that are wanted */
    struct picture shown;
    struct trail trail; /* behind it */
    bool has_failed;
    struct feed_status status;
    struct feed_marks marks; /* status.marks says when they changed */
};

/* False: there was no memory. */
bool stage_init(struct stage *stage, void (*wake)(void *context),
                void *context);
void stage_end(struct stage *stage);

/* The side that makes frames. */

/* Copies the orders; a jump among them is the caller's then. False: the stage
 * is closing. */
bool stage_take_orders(struct stage *stage, struct orders *out);

/* Wait until there is a newer order, or a moment, at most a quarter of a
 * second; monotonic. */
void stage_wait(struct stage *stage, unsigned serial, int64_t until_ns);

/* Whether somebody looks. serial: of the newest order. */
bool stage_is_wanted(struct stage *stage, unsigned *serial);

bool stage_is_closing(struct stage *stage);

/* The views that are wanted now. */
struct feed_views stage_views(struct stage *stage);

/* A jump leads to a frame. Returns the first of those that are shown at once
 * with it; all of these are kept or shown from now on. */
int64_t stage_aim(struct stage *stage, int64_t target);

/* Keep one of those before the target; it is the stage's then. */
void stage_keep(struct stage *stage, struct picture *picture);

/* Show a picture, in place of the one before; it is the stage's then. */
void stage_show(struct stage *stage, struct picture *picture,
                int64_t complete_ns);

void stage_set_state(struct stage *stage, enum feed_state state);
void stage_set_text(struct stage *stage, enum feed_text which,
                    const char *text);
/* All is over: state and message stay from here on. */
void stage_fail(struct stage *stage, const char *message);

/* A frame lacks something. Where there is no room for its mark, each becomes
 * one of twice as many frames. */
void stage_mark(struct stage *stage, int64_t frame,
                const struct feed_loss *loss);

void stage_set_range(struct stage *stage, int64_t first, int64_t last);
void stage_set_scanned(struct stage *stage, double share);
void stage_set_totals(struct stage *stage, const struct totals *totals);

/* Live: these packets count, and not those of the totals. */
void stage_set_received(struct stage *stage,
                        const struct feed_received *received,
                        const struct feed_dropped *dropped);
void stage_set_laser(struct stage *stage, bool is_known, uint16_t status);

/* The side that asks. */

/* The status and the shown frame do not change between these two. */
const struct feed_status *stage_begin_look(struct stage *stage);
void stage_end_look(struct stage *stage);

/* An order is given between these two. */
struct orders *stage_begin_order(struct stage *stage);
void stage_end_order(struct stage *stage);

#endif
