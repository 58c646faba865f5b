/* A feed without a source: frames of a moving wave, with FAKE_POINTS points and
 * FAKE_HZ frames a second, for tests of the server that need no decoder. */
#define _POSIX_C_SOURCE 200809L

#include "lumview/feed.h"

#include "lum/base/time.h"
#include "lum/frame/packed.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS 250u

struct frame {
    pthread_mutex_t lock;
    unsigned references;
    lum_packed packed;
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
        lum_packed_free(&frame->packed);
        free(frame);
    }
}

const uint8_t *frame_bytes(const struct frame *frame, size_t *len)
{
    *len = frame->packed.len;
    return frame->packed.bytes;
}

size_t frame_piece(const struct frame *frame, size_t at)
{
    return lum_packed_piece(&frame->packed, at);
}

/* A point's columns. */
struct point {
    float x, y, z, pulse_width;
    uint32_t line;
    uint16_t pixel, return_number, number_of_returns;
    uint8_t eye, edge, strongest;
};

static struct point make_point(const struct feed *feed, uint32_t i)
{
    struct point p = {.line = i / COLUMNS,
                      .pixel = (uint16_t)(i % COLUMNS * 4u),
                      .return_number = 1,
                      .number_of_returns = 2,
                      .eye = (uint8_t)(i / COLUMNS % 2u),
                      .edge = 1,
                      .pulse_width = (float)(500u + i % 1000u) * 0.01f};
    p.y = ((float)p.pixel - 500.0f) * 0.03f;
    p.x = 10.0f + (float)p.line * 0.2f;
    p.z = sinf(p.y + p.x * 0.3f + (float)feed->status.frame * 0.2f);
    return p;
}

/* Memory for the columns of so many points, one behind the other, the widest
 * first. */
static uint8_t *make_columns(uint32_t count, lum_packed_part *out)
{
    const size_t n = count;
    uint8_t *at = malloc(29u * n + 1u);
    *out = (lum_packed_part){.struct_size = sizeof *out, .count = n};
    if (at != NULL) {
        out->x = (const float *)(void *)at;
        out->y = out->x + n;
        out->z = out->y + n;
        out->pulse_width = out->z + n;
        out->line = (const uint32_t *)(void *)(at + 16u * n);
        out->pixel = (const uint16_t *)(void *)(at + 20u * n);
        out->return_number = out->pixel + n;
        out->number_of_returns = out->return_number + n;
        out->eye = at + 26u * n;
        out->edge = out->eye + n;
        out->strongest = out->edge + n;
    }
    return at;
}

static void put_points(const struct feed *feed, uint8_t *at)
{
    const size_t n = feed->points;
    float *floats = (float *)(void *)at;
    uint32_t *lines = (uint32_t *)(void *)(at + 16u * n);
    uint16_t *words = (uint16_t *)(void *)(at + 20u * n);
    uint8_t *bytes = at + 26u * n;
    for (uint32_t i = 0; i < n; i++) {
        const struct point p = make_point(feed, i);
        const float all[] = {p.x, p.y, p.z, p.pulse_width};
        for (size_t k = 0; k < 4u; k++) {
            floats[k * n + i] = all[k];
        }
        lines[i] = p.line;
        words[i] = p.pixel;
        words[n + i] = p.return_number;
        words[2u * n + i] = p.number_of_returns;
        bytes[i] = p.eye;
        bytes[n + i] = p.edge;
        bytes[2u * n + i] = p.strongest;
    }
}

static int pack(const struct feed *feed, const struct feed_view *view,
                lum_packed *out)
{
    const lum_packed_head head = {.struct_size = sizeof head,
                                  .frame = feed->status.frame,
                                  .clock_us = 100000 * (int64_t)feed->shown,
                                  .utc_ns =
                                      INT64_C(1700000000000000000) +
                                      INT64_C(100000000) * (int64_t)feed->shown,
                                  .utc_error_ns = 100000,
                                  .complete_ns = lum_time_monotonic_ns(),
                                  .shown = feed->shown,
                                  .lines = feed->points / COLUMNS,
                                  .time = LUM_PACKED_TIME_FITTED,
                                  .edges = (uint8_t)view->edges,
                                  .smooth = (uint8_t)view->smooth};
    lum_packed_part part;
    uint8_t *columns = make_columns(feed->points, &part);
    if (columns == NULL) {
        return -1;
    }
    put_points(feed, columns);
    const lum_result result = lum_packed_make(&head, &part, 1, out);
    free(columns);
    return result == LUM_OK ? 0 : -1;
}

static struct frame *make_frame(const struct feed *feed,
                                const struct feed_view *view)
{
    struct frame *frame = calloc(1, sizeof *frame);
    if (frame == NULL || pack(feed, view, &frame->packed) != 0) {
        free(frame);
        return NULL;
    }
    (void)pthread_mutex_init(&frame->lock, NULL);
    frame->references = 1;
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

void feed_look_marks(struct feed *feed, struct feed_marks *out)
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
