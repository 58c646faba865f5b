/* A frame of the sensor, or of all sensors of a rig, as each of the views shows
 * it. */
#ifndef LUMVIEW_VIEW_PICTURE_H
#define LUMVIEW_VIEW_PICTURE_H

#include "feed.h"
#include "page_frame.h"

#include "lum/frame/framer.h"

/* Most sensors of a rig. */
#define PICTURE_PARTS_MAX LUM_RIG_MEMBERS_MAX

/* Of a sensor of a rig. */
struct picture_part {
    int64_t frame;  /* the sensor's own number */
    uint8_t sensor; /* its place in the rig */
};

struct picture {
    int64_t frame;
    int64_t arrival_ns;   /* of its earliest line; UTC, 0 or below: not known */
    int64_t clock_us;     /* likewise */
    int64_t begin_utc_ns; /* when clock_us was, by the fit; 0: there is none */
    int64_t utc_error_ns; /* how far off that may be */
    uint32_t lines;
    uint64_t lost_words;
    struct feed_loss loss; /* at its ends of the stream there is none */
    uint32_t sensor;
    uint64_t cut; /* points, of the view that lost most */
    struct feed_views views;
    size_t parts; /* sensors of a rig that it has; 0: no rig */
    struct picture_part part[PICTURE_PARTS_MAX];
    lum_frame *points[PICTURE_PARTS_MAX]
                     [FEED_VIEWS_MAX];    /* until it is sealed; without a rig
                                             the first row */
    lum_frame *second[FEED_VIEWS_MAX];    /* by the second profile, likewise;
                                             NULL: none */
    struct frame *frames[FEED_VIEWS_MAX]; /* then; NULL: there was no memory */
};

/* The frames before the one that is shown, which are shown at once with it. */
struct trail {
    struct picture pictures[FEED_FRAMES_MAX]; /* by number */
    size_t count;
    int64_t from; /* none is missing from this one on */
};

/* Ask a framer for the views that are wanted now, where they are others than
 * now. False: there was no memory. */
bool views_follow(lum_framer *framer, struct feed_views *now,
                  const struct feed_views *wanted);

/* Make it the framer's frame, in all views of that; it is empty before. */
void picture_take(struct picture *picture, const lum_framer *framer);

/* The points of a view of one sensor, until it is sealed; NULL: it has none. */
const lum_frame *picture_points(const struct picture *picture,
                                const struct feed_view *view);

/* Release its frame; it is empty then. */
void picture_drop(struct picture *picture);

/* Make its frames, which can then be shown.
 * complete_ns: when it was complete, monotonic.
 * shown: frames so far, this one included. */
void picture_seal(struct picture *picture, struct frame_pool *pool,
                  int64_t complete_ns, uint64_t shown);

/* The frame of a view; NULL: it has none. */
struct frame *picture_find(const struct picture *picture,
                           const struct feed_view *view);

/* Whether it has all of the views. */
bool picture_has(const struct picture *picture, const struct feed_views *views);

/* Put one in, in place of one of its number; it is the trail's then. Where
 * there is no room the first one goes. */
void trail_put(struct trail *trail, struct picture *picture);

/* Release all but those from first to before another. */
void trail_cut(struct trail *trail, int64_t first, int64_t before);

/* By its number; NULL: it is not in. */
const struct picture *trail_find(const struct trail *trail, int64_t number);

/* Release those that lack one of the views. */
void trail_shed(struct trail *trail, const struct feed_views *views);

/* Whether all have all of the views. */
bool trail_has(const struct trail *trail, const struct feed_views *views);

#endif
