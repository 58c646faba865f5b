/* One that looks at a feed, a browser or the page's own worker: the view that
 * it wants, and which message it gets next. Nothing here knows of a network. */
#ifndef LUMVIEW_VIEWER_H
#define LUMVIEW_VIEWER_H

#include "feed.h"
#include "page_command.h"
#include "page_frame.h"
#include "page_status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Of a frame's head, what tells it from others. */
#define VIEWER_LAST_BYTES 80u

struct viewer {
    struct viewer *next;
    struct feed_view view;
    unsigned frames;     /* shown at once */
    int64_t past_before; /* it asked for frames before this one */
    uint64_t past;       /* bit i: that one by i + 1 before */
    struct frame *frame; /* being sent; NULL: none */
    size_t sent;         /* bytes of it */
    int64_t begin_ns;    /* when its first piece went out, monotonic */
    bool is_past;        /* it asked for it */
    uint8_t last[VIEWER_LAST_BYTES]; /* head of the newest frame that it got */
    bool has_last;
    bool had_hello;
    bool wants_status;
    unsigned marks; /* feed_status.marks of those that it has */
    uint64_t skipped;
};

/* All viewers of a feed. */
struct viewers {
    const struct options *options;
    struct feed *feed; /* NULL: it is gone; viewers may still be removed */
    struct status status;
    struct viewer *first;
    size_t room_before;   /* a message */
    unsigned char *piece; /* of a frame, behind that room */
    struct text text;     /* the message before */
};

/* A message for a viewer. In front of the bytes is the room that viewers_init()
 * was given; it may be written. */
struct viewer_message {
    unsigned char *bytes;
    size_t len;
    bool is_text;
};

/* room_before: bytes that the sender writes in front of a message. -1: there is
 * no memory. */
int viewers_init(struct viewers *viewers, const struct options *options,
                 size_t room_before);
void viewers_free(struct viewers *viewers);

/* A viewer comes, and goes. */
void viewers_add(struct viewers *viewers, struct viewer *viewer);
void viewers_remove(struct viewers *viewers, struct viewer *viewer);

/* The feed may have something new: to be asked for with viewer_has_next(). */
void viewers_wake(struct viewers *viewers);

/* Half a second has passed: likewise. */
void viewers_tick(struct viewers *viewers);

/* A command came. False: it is none. */
bool viewer_take(struct viewers *viewers, struct viewer *viewer,
                 const char *text, size_t len);

/* Whether viewer_next() would give a message. */
bool viewer_has_next(const struct viewers *viewers,
                     const struct viewer *viewer);

/* The next message for a viewer: a text, or a piece of a frame. A frame that is
 * not the newest any more is left after a quarter of a second, once an eighth
 * of it is sent, so that a slow viewer sees the newest frames, coarsely, rather
 * than old ones. The message lives until the next call for any of the viewers.
 * 1: there is one; 0: there is none; -1: there is no memory. */
int viewer_next(struct viewers *viewers, struct viewer *viewer,
                struct viewer_message *out);

#endif
