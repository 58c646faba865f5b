#define _XOPEN_SOURCE 700 /* setpriority */
#include "renderer.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/resource.h>
#endif

#define NICENESS 5

struct renderer {
    pthread_t thread;
    pthread_mutex_t mutex; /* of all below */
    pthread_cond_t ordered;
    struct render_order next;
    bool has_order; /* next is not begun yet */
    bool is_busy;   /* ordered, and not fetched */
    bool is_done;   /* result and reel are those of the last order */
    bool ends;
    lum_result result;
    lum_reel *reel;
    struct render_order current; /* used only by the thread */
};

/* Whether nobody waits for the present rendering. */
static bool is_in_vain(void *context)
{
    struct renderer *s = context;
    (void)pthread_mutex_lock(&s->mutex);
    const bool in_vain = s->has_order || s->ends;
    (void)pthread_mutex_unlock(&s->mutex);
    return in_vain;
}

static lum_result render(struct renderer *s, lum_reel **out)
{
    struct render_order *order = &s->current;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        order->options.elevations_udeg[eye] =
            order->is_aimed ? order->elevations_udeg[eye] : NULL;
    }
    const lum_reel_stop stop = {is_in_vain, s};
    return lum_reel_new(&order->options, order->frames, stop, out);
}

/* With the mutex held, but while rendering. */
static void render_order(struct renderer *s)
{
    lum_reel *reel = NULL;
    s->current = s->next;
    s->has_order = false;
    (void)pthread_mutex_unlock(&s->mutex);
    const lum_result result = render(s, &reel);
    (void)pthread_mutex_lock(&s->mutex);
    if (s->has_order || s->ends) { /* nobody wants it any more */
        lum_reel_free(result == LUM_OK ? reel : NULL);
        return;
    }
    s->result = result;
    s->reel = reel;
    s->is_done = true;
}

/* Rendering waits for the data rather than the data for it. Elsewhere niceness
 * is the process's. */
static void step_back(void)
{
#ifdef __linux__
    (void)setpriority(PRIO_PROCESS, 0, NICENESS);
#endif
}

static void *work(void *argument)
{
    struct renderer *s = argument;
    step_back();
    (void)pthread_mutex_lock(&s->mutex);
    while (!s->ends) {
        if (s->has_order) {
            render_order(s);
        } else {
            (void)pthread_cond_wait(&s->ordered, &s->mutex);
        }
    }
    (void)pthread_mutex_unlock(&s->mutex);
    return NULL;
}

int renderer_open(struct renderer **out, lum_error *error)
{
    struct renderer *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return lum_error_set(error, "not enough memory");
    }
    (void)pthread_mutex_init(&s->mutex, NULL);
    (void)pthread_cond_init(&s->ordered, NULL);
    const int reason = pthread_create(&s->thread, NULL, work, s);
    if (reason != 0) {
        free(s);
        return lum_error_set(error, "no thread to render in: %s",
                             strerror(reason));
    }
    *out = s;
    return 0;
}

/* With the mutex held. */
static void discard(struct renderer *s)
{
    if (s->is_done && s->result == LUM_OK) {
        lum_reel_free(s->reel);
    }
    s->reel = NULL;
    s->is_done = false;
}

void renderer_close(struct renderer *renderer)
{
    if (renderer == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&renderer->mutex);
    renderer->ends = true;
    (void)pthread_cond_signal(&renderer->ordered);
    (void)pthread_mutex_unlock(&renderer->mutex);
    (void)pthread_join(renderer->thread, NULL);
    discard(renderer);
    (void)pthread_cond_destroy(&renderer->ordered);
    (void)pthread_mutex_destroy(&renderer->mutex);
    free(renderer);
}

void renderer_order(struct renderer *renderer, const struct render_order *order)
{
    (void)pthread_mutex_lock(&renderer->mutex);
    discard(renderer);
    renderer->next = *order;
    renderer->has_order = true;
    renderer->is_busy = true;
    (void)pthread_cond_signal(&renderer->ordered);
    (void)pthread_mutex_unlock(&renderer->mutex);
}

static bool is_set(struct renderer *s, const bool *flag)
{
    (void)pthread_mutex_lock(&s->mutex);
    const bool value = *flag;
    (void)pthread_mutex_unlock(&s->mutex);
    return value;
}

bool renderer_is_busy(struct renderer *renderer)
{
    return is_set(renderer, &renderer->is_busy);
}

bool renderer_is_done(struct renderer *renderer)
{
    return is_set(renderer, &renderer->is_done);
}

bool renderer_fetch(struct renderer *renderer, lum_reel **reel,
                    lum_result *result)
{
    (void)pthread_mutex_lock(&renderer->mutex);
    const bool is_done = renderer->is_done;
    if (is_done) {
        *reel = renderer->reel;
        *result = renderer->result;
        renderer->reel = NULL;
        renderer->is_done = false;
        renderer->is_busy = false;
    }
    (void)pthread_mutex_unlock(&renderer->mutex);
    return is_done;
}
