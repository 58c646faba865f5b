#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "thread_monitor.h"
#include "view.h"

#include <string.h>
#include <time.h>

#define SECOND_NS INT64_C(1000000000)

void viewer_init(struct viewer *viewer, const char *source)
{
    *viewer = (struct viewer){.options = {.source = source, .play.speed = 1.0}};
    viewer->options.sources =
        (struct sources){.paths = &viewer->options.source, .count = 1};
    (void)pthread_mutex_init(&viewer->lock, NULL);
    (void)pthread_cond_init(&viewer->woken, NULL);
}

static void wake(void *context)
{
    struct viewer *viewer = context;
    (void)pthread_mutex_lock(&viewer->lock);
    viewer->wakes++;
    (void)pthread_cond_signal(&viewer->woken);
    (void)pthread_mutex_unlock(&viewer->lock);
}

void viewer_want(struct viewer *viewer, lum_edges edges, unsigned smooth)
{
    const struct feed_view view = {edges, smooth};
    feed_want(viewer->feed, &view, 1);
}

static int open_feed(struct viewer *viewer, lum_error *error)
{
    const struct options *o = &viewer->options;
    struct geometry geometry;
    return geometry_load(o->calibration, o->profile, &o->sources, &geometry,
                         error) == 0
               ? feed_open(o, &geometry, viewer->second, wake, viewer,
                           &viewer->feed, error)
               : -1;
}

void viewer_open(struct viewer *viewer)
{
    lum_error error = {""};
    if (open_feed(viewer, &error) != 0) {
        fail_msg("%s", error.text);
    }
    viewer_want(viewer, LUM_EDGES_RISING, 0);
}

static void end(struct viewer *viewer)
{
    (void)pthread_cond_destroy(&viewer->woken);
    (void)pthread_mutex_destroy(&viewer->lock);
}

void viewer_open_badly(struct viewer *viewer, lum_error *error)
{
    assert_int_not_equal(open_feed(viewer, error), 0);
    end(viewer);
}

int viewer_close(struct viewer *viewer, lum_error *error)
{
    const int result = feed_close(viewer->feed, error);
    end(viewer);
    return result;
}

/* Without threads it is the feed's only one. */
static bool work(struct viewer *viewer)
{
    const int64_t wait_ns = feed_work(viewer->feed);
    const struct timespec wait = {.tv_sec = (time_t)(wait_ns / SECOND_NS),
                                  .tv_nsec = (long)(wait_ns % SECOND_NS)};
    if (viewer->wakes == 0) {
        (void)nanosleep(&wait, NULL);
    }
    const bool has_news = viewer->wakes > 0 || wait_ns < SECOND_NS;
    viewer->wakes = 0;
    return has_news;
}

/* False: nothing was new for a second. */
static bool sleep_until_woken(struct viewer *viewer)
{
    struct timespec until;
    int code = 0;
    if (!thread_exists()) {
        return work(viewer);
    }
    (void)clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec++;
    (void)pthread_mutex_lock(&viewer->lock);
    while (viewer->wakes == 0 && code == 0) {
        code = pthread_cond_timedwait(&viewer->woken, &viewer->lock, &until);
    }
    viewer->wakes = 0;
    (void)pthread_mutex_unlock(&viewer->lock);
    return code == 0;
}

struct feed_status viewer_wait(struct viewer *viewer, view_condition *condition,
                               int64_t argument)
{
    struct feed_status status;
    unsigned silent = 0;
    feed_look(viewer->feed, &status);
    while (!condition(&status, argument)) {
        silent += sleep_until_woken(viewer) ? 0u : 1u;
        if (silent > VIEW_PATIENCE_S) {
            fail_msg("never came: state %d, frame %d, %u frames, '%s'",
                     (int)status.state, (int)status.frame,
                     (unsigned)status.frames, status.texts[FEED_MESSAGE]);
        }
        feed_look(viewer->feed, &status);
    }
    return status;
}

struct frame *viewer_wait_frame(struct viewer *viewer, lum_edges edges,
                                unsigned smooth)
{
    const struct feed_view view = {edges, smooth};
    struct frame *frame = feed_newest(viewer->feed, &view);
    for (unsigned silent = 0; frame == NULL && silent <= VIEW_PATIENCE_S;) {
        silent += sleep_until_woken(viewer) ? 0u : 1u;
        frame = feed_newest(viewer->feed, &view);
    }
    assert_non_null(frame);
    return frame;
}

bool is_in_state(const struct feed_status *status, int64_t state)
{
    return (int64_t)status->state == state;
}

bool shows_frame(const struct feed_status *status, int64_t frame)
{
    return status->frames > 0 && status->frame == frame;
}

bool has_shown(const struct feed_status *status, int64_t frames)
{
    return status->frames >= (uint64_t)frames;
}

bool has_range(const struct feed_status *status, int64_t ignored)
{
    (void)ignored;
    return status->has_range;
}

bool has_message(const struct feed_status *status, int64_t ignored)
{
    (void)ignored;
    return status->texts[FEED_MESSAGE][0] != '\0';
}

struct unpacked frame_arrays(const struct frame *frame)
{
    struct unpacked out;
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    assert_true(unpack(bytes, len, &out));
    return out;
}

uint32_t frame_u32(const struct frame *frame, size_t at)
{
    size_t len = 0;
    return unpacked_u32(frame_bytes(frame, &len), at);
}

double frame_double(const struct frame *frame, size_t at)
{
    size_t len = 0;
    return unpacked_double(frame_bytes(frame, &len), at);
}

uint32_t frame_points(const struct frame *frame)
{
    return frame_u32(frame, 32);
}
