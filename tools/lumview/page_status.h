/* Texts to a browser, as JSON. */
#ifndef LUMVIEW_PAGE_STATUS_H
#define LUMVIEW_PAGE_STATUS_H

#include "feed.h"

#include <stddef.h>
#include <stdint.h>

/* What the counters were before, for rates. */
struct status_sample {
    int64_t time_ns;
    uint64_t points;
    uint64_t frames;
    int64_t frame_ns; /* of the last of these */
    uint64_t bytes;
};

#define STATUS_SAMPLES 3u

struct status {
    struct feed_status feed;                      /* as last looked at */
    struct feed_marks marks;                      /* likewise */
    struct status_sample samples[STATUS_SAMPLES]; /* oldest first */
    unsigned sample_count;
    unsigned browsers;
};

/* Take the feed's present status. at_tick: half a second has passed since the
 * last such call, for the rates. */
void status_update(struct status *status, const struct feed_status *feed,
                   int64_t now_ns, bool at_tick);

/* Whether a person would want to know of the difference at once. */
bool status_differs(const struct feed_status *a, const struct feed_status *b);

/* A text with room before it; to be freed. NULL: no memory. */
struct text {
    char *memory;
    char *bytes;
    size_t len;
};

/* The first text of a connection. 0, or -1: no memory. */
int status_hello(const struct options *options, const struct feed *feed,
                 size_t room_before, struct text *out);

/* The status as JSON. skipped: frames that this browser did not get, or not
 * whole. has_marks: it has the marks already. */
int status_text(const struct status *status, uint64_t skipped, bool has_marks,
                size_t room_before, struct text *out);

#endif
