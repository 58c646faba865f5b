/* A feed without a source: frames of a moving wave, with FAKE_POINTS points and
 * FAKE_HZ frames a second, for tests of the server that need no decoder. */
#define _POSIX_C_SOURCE 200809L

#include "lumview/feed.h"

#include "lum/base/time.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS 250u

struct frame {
    pthread_mutex_t lock;
    unsigned references;
    size_t len;
    uint8_t bytes[];
};

struct feed {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    void (*wake)(void *context);
    void *context;
    bool is_live;
    bool ends;
    struct feed_status status;
    struct feed_view views[FEED_VIEWS_MAX];
    struct frame *frames[FEED_VIEWS_MAX];
    size_t view_count;
    uint32_t points;
    double hz;
    uint32_t shown;
};

struct frame *frame_keep(struct frame *frame)
{
    (void)pthread_mutex_lock(&frame->lock);
    frame->references++;
    (void)pthread_mutex_unlock(&frame->lock);
    return frame;
}

void frame_release(struct frame *frame)
{
    if (frame == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&frame->lock);
    const unsigned left = --frame->references;
    (void)pthread_mutex_unlock(&frame->lock);
    if (left == 0) {
        (void)pthread_mutex_destroy(&frame->lock);
        free(frame);
    }
}

const uint8_t *frame_bytes(const struct frame *frame, size_t *len)
{
    *len = frame->len;
    return frame->bytes;
}

/* Of this host's byte order, which is a little-endian one where it runs. */
static void put(uint8_t *at, const void *value, size_t len)
{
    (void)memcpy(at, value, len);
}

static void put_head(uint8_t *head, const struct feed *feed,
                     const struct feed_view *view)
{
    const uint32_t magic = FRAME_MAGIC;
    const uint16_t words[] = {FRAME_VERSION, FRAME_HEAD_BYTES};
    const double times[] = {(double)feed->status.frame,
                            1e5 * (double)feed->shown,
                            1.7e9 + 0.1 * (double)feed->shown};
    const uint32_t lines = feed->points / COLUMNS;
    const double error = 1e-4;
    const double now = (double)lum_time_monotonic_ns() * 1e-9;
    (void)memset(head, 0, FRAME_HEAD_BYTES);
    put(head, &magic, 4);
    put(head + 4, words, 4);
    put(head + 8, times, 24);
    put(head + 32, &feed->points, 4);
    head[36] = (uint8_t)view->edges;
    head[37] = (uint8_t)view->smooth;
    head[38] = FRAME_TIME_FITTED;
    put(head + 40, &lines, 4);
    put(head + 52, &feed->shown, 4);
    put(head + 56, &now, 8);
    put(head + 64, &error, 8);
}

static void put_point(uint8_t *arrays, const struct feed *feed, uint32_t i)
{
    const size_t n = feed->points;
    const uint16_t line = (uint16_t)(i / COLUMNS);
    const uint16_t pixel = (uint16_t)(i % COLUMNS * 4u);
    const float y = ((float)pixel - 500.0f) * 0.03f;
    const float x = 10.0f + (float)line * 0.2f;
    const float at[3] = {x, y,
                         sinf(y + x * 0.3f + (float)feed->status.frame * 0.2f)};
    const uint16_t width = (uint16_t)(500u + i % 1000u);
    put(arrays + 12u * i, at, 12);
    put(arrays + 12u * n + 2u * i, &width, 2);
    put(arrays + 14u * n + 2u * i, &line, 2);
    put(arrays + 16u * n + 2u * i, &pixel, 2);
    arrays[18u * n + i] = (uint8_t)(1u + i % 2u);
    arrays[19u * n + i] = (uint8_t)(i % 2u | 2u | 2u << 2);
}

static struct frame *make_frame(const struct feed *feed,
                                const struct feed_view *view)
{
    const size_t len =
        FRAME_HEAD_BYTES + (size_t)feed->points * FRAME_POINT_BYTES;
    struct frame *frame = malloc(sizeof *frame + len);
    if (frame == NULL) {
        return NULL;
    }
    (void)pthread_mutex_init(&frame->lock, NULL);
    frame->references = 1;
    frame->len = len;
    put_head(frame->bytes, feed, view);
    for (uint32_t i = 0; i < feed->points; i++) {
        put_point(frame->bytes + FRAME_HEAD_BYTES, feed, i);
    }
    return frame;
}

static void make_frames(struct feed *feed)
{
    feed->shown++;
    feed->status.frames++;
    feed->status.frame_ns = lum_time_monotonic_ns();
    feed->status.decoded.points += feed->points;
    feed->status.received.bytes += 4u * (uint64_t)feed->points;
    feed->status.received.packets++;
    for (size_t i = 0; i < feed->view_count; i++) {
        frame_release(feed->frames[i]);
        feed->frames[i] = make_frame(feed, &feed->views[i]);
    }
}

static void *run(void *context)
{
    struct feed *feed = context;
    int64_t next = lum_time_monotonic_ns();
    (void)pthread_mutex_lock(&feed->lock);
    while (!feed->ends) {
        if (feed->status.state == FEED_PLAYING) {
            feed->status.frame++;
            make_frames(feed);
        }
        (void)pthread_mutex_unlock(&feed->lock);
        feed->wake(feed->context);
        next += (int64_t)(1e9 / feed->hz);
        lum_time_sleep_until(next);
        (void)pthread_mutex_lock(&feed->lock);
    }
    (void)pthread_mutex_unlock(&feed->lock);
    return NULL;
}

static double read_number(const char *name, double fallback)
{
    const char *text = getenv(name);
    return text != NULL ? strtod(text, NULL) : fallback;
}

int feed_open(const struct options *options, const struct geometry *geometry,
              const lum_profile *second, void (*wake)(void *context),
              void *context, struct feed **out, lum_error *error)
{
    (void)geometry;
    (void)second;
    struct feed *feed = calloc(1, sizeof *feed);
    if (feed == NULL) {
        return lum_error_set(error, "no memory");
    }
    feed->wake = wake;
    feed->context = context;
    feed->points = (uint32_t)read_number("FAKE_POINTS", 20000);
    feed->hz = read_number("FAKE_HZ", 10);
    feed->is_live = options->is_live;
    feed->status = (struct feed_status){.state = FEED_PLAYING,
                                        .is_live = options->is_live,
                                        .has_range = !options->is_live,
                                        .last_frame = 1000,
                                        .speed = options->play.speed,
                                        .loops = options->play.loops,
                                        .has_laser = options->is_live,
                                        .laser = 0x0820};
    (void)pthread_mutex_init(&feed->lock, NULL);
    if (pthread_create(&feed->thread, NULL, run, feed) != 0) {
        free(feed);
        return lum_error_set(error, "no thread");
    }
    *out = feed;
    return 0;
}

int feed_close(struct feed *feed, lum_error *error)
{
    (void)error;
    (void)pthread_mutex_lock(&feed->lock);
    feed->ends = true;
    (void)pthread_mutex_unlock(&feed->lock);
    (void)pthread_join(feed->thread, NULL);
    for (size_t i = 0; i < FEED_VIEWS_MAX; i++) {
        frame_release(feed->frames[i]);
    }
    (void)pthread_mutex_destroy(&feed->lock);
    free(feed);
    return 0;
}

void feed_want(struct feed *feed, const struct feed_view *views, size_t count)
{
    (void)pthread_mutex_lock(&feed->lock);
    for (size_t i = 0; i < FEED_VIEWS_MAX; i++) {
        frame_release(feed->frames[i]);
        feed->frames[i] = NULL;
    }
    for (size_t i = 0; i < count; i++) {
        feed->views[i] = views[i];
        feed->frames[i] = make_frame(feed, &views[i]);
    }
    feed->view_count = count;
    (void)pthread_mutex_unlock(&feed->lock);
}

struct frame *feed_newest(struct feed *feed, const struct feed_view *view)
{
    struct frame *out = NULL;
    (void)pthread_mutex_lock(&feed->lock);
    for (size_t i = 0; i < feed->view_count; i++) {
        if (feed->views[i].edges == view->edges &&
            feed->views[i].smooth == view->smooth && feed->frames[i] != NULL) {
            out = frame_keep(feed->frames[i]);
        }
    }
    (void)pthread_mutex_unlock(&feed->lock);
    return out;
}

/* It keeps none. */
void feed_keep(struct feed *feed, unsigned frames)
{
    (void)feed;
    (void)frames;
}

struct frame *feed_past(struct feed *feed, const struct feed_view *view,
                        int64_t number)
{
    (void)feed;
    (void)view;
    (void)number;
    return NULL;
}

void feed_look(struct feed *feed, struct feed_status *out)
{
    (void)pthread_mutex_lock(&feed->lock);
    *out = feed->status;
    (void)pthread_mutex_unlock(&feed->lock);
}

void feed_marks(struct feed *feed, struct feed_marks *out)
{
    (void)feed;
    *out = (struct feed_marks){.count = 0};
}

void feed_geometry(const struct feed *feed, unsigned eye, float mount[3],
                   float rotation[9])
{
    (void)feed;
    for (unsigned i = 0; i < 9; i++) {
        rotation[i] = i % 4u == 0 ? 1.0f : 0.0f;
    }
    mount[0] = 0.0f;
    mount[1] = eye == 0 ? 0.1f : -0.1f;
    mount[2] = 0.0f;
}

/* No source: no profile. */
const lum_profile *feed_profile(const struct feed *feed, bool is_second)
{
    (void)feed;
    (void)is_second;
    return NULL;
}

/* Go to a frame and show it at once. */
static void show(struct feed *feed, enum feed_state state, int64_t frame)
{
    (void)pthread_mutex_lock(&feed->lock);
    if (!feed->is_live) {
        feed->status.state = state;
        feed->status.frame = frame;
        make_frames(feed);
    }
    (void)pthread_mutex_unlock(&feed->lock);
    feed->wake(feed->context);
}

void feed_play(struct feed *feed, bool plays)
{
    show(feed, plays ? FEED_PLAYING : FEED_PAUSED, feed->status.frame);
}

void feed_step(struct feed *feed, int64_t frames)
{
    show(feed, FEED_PAUSED, feed->status.frame + frames);
}

void feed_seek(struct feed *feed, int64_t frame)
{
    show(feed, feed->status.state, frame);
}

void feed_speed(struct feed *feed, double speed)
{
    (void)pthread_mutex_lock(&feed->lock);
    feed->status.speed = speed;
    (void)pthread_mutex_unlock(&feed->lock);
    feed->wake(feed->context);
}

void feed_loop(struct feed *feed, bool loops)
{
    (void)pthread_mutex_lock(&feed->lock);
    feed->status.loops = loops;
    (void)pthread_mutex_unlock(&feed->lock);
    feed->wake(feed->context);
}
