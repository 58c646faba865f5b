/* What the tests of a feed share: one that watches it, and its frames. */
#ifndef LUM_TEST_VIEW_H
#define LUM_TEST_VIEW_H

#include "feed.h"
#include "unpacked.h"

#include <pthread.h>
#include <stdbool.h>

/* Longest wait for what must come. */
#define VIEW_PATIENCE_S 300

/* A feed and who looks at it. */
struct viewer {
    struct options options;
    const lum_profile *second; /* a profile to show beside; or NULL */
    struct feed *feed;
    pthread_mutex_t lock;
    pthread_cond_t woken;
    unsigned wakes;
};

/* Options of a source. */
void viewer_init(struct viewer *viewer, const char *source);

/* Open, and want rising edges as they come; fails the test if it cannot. */
void viewer_open(struct viewer *viewer);

/* Open, expecting that it cannot be; error gets why. */
void viewer_open_badly(struct viewer *viewer, lum_error *error);

/* 0, or -1 with the reason in error. */
int viewer_close(struct viewer *viewer, lum_error *error);

void viewer_want(struct viewer *viewer, lum_edges edges, unsigned smooth);

/* Wait until the feed is so; fails the test if that does not come. Returns the
 * status as of then. */
typedef bool view_condition(const struct feed_status *status, int64_t argument);
struct feed_status viewer_wait(struct viewer *viewer, view_condition *condition,
                               int64_t argument);

/* Wait for a frame in a view. */
struct frame *viewer_wait_frame(struct viewer *viewer, lum_edges edges,
                                unsigned smooth);

/* Conditions. */
bool is_in_state(const struct feed_status *status, int64_t state);
bool shows_frame(const struct feed_status *status, int64_t frame);
bool has_shown(const struct feed_status *status, int64_t frames);
bool has_range(const struct feed_status *status, int64_t ignored);
bool has_message(const struct feed_status *status, int64_t ignored);

/* All of a frame's points; to be freed. */
struct unpacked frame_arrays(const struct frame *frame);

/* Of a frame's head. */
uint32_t frame_points(const struct frame *frame);
double frame_double(const struct frame *frame, size_t at);
uint32_t frame_u32(const struct frame *frame, size_t at);

#endif
