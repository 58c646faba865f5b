#define _XOPEN_SOURCE 700 /* setpriority */
#include "studio.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/resource.h>
#endif

#define NICENESS 5

struct studio {
    pthread_t thread;
    pthread_mutex_t mutex; /* of all below */
    pthread_cond_t ordered;
    struct order next;
    bool has_order; /* next is not begun yet */
    bool is_busy;   /* ordered, and not fetched */
    bool is_done;   /* result and reel are those of the last order */
    bool ends;
    lum_result result;
    lum_reel *reel;
    struct order current; /* used only by the thread */
};

/* Whether nobody waits for the present rendering. */
static bool is_in_vain(void *context)
{
    struct studio *s = context;
    (void)pthread_mutex_lock(&s->mutex);
    const bool in_vain = s->has_order || s->ends;
    (void)pthread_mutex_unlock(&s->mutex);
    return in_vain;
}

static lum_result render(struct studio *s, lum_reel **out)
{
    struct order *order = &s->current;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        order->options.elevations_udeg[eye] =
            order->is_aimed ? order->elevations_udeg[eye] : NULL;
    }
    const lum_reel_stop stop = {is_in_vain, s};
    return lum_reel_new(&order->options, order->frames, stop, out);
}

/* With the mutex held, but while rendering. */
static void render_order(struct studio *s)
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
    struct studio *s = argument;
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

int studio_open(struct studio **out, lum_error *error)
{
    struct studio *s = calloc(1, sizeof *s);
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
static void discard(struct studio *s)
{
    if (s->is_done && s->result == LUM_OK) {
        lum_reel_free(s->reel);
    }
    s->reel = NULL;
    s->is_done = false;
}

void studio_close(struct studio *studio)
{
    if (studio == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&studio->mutex);
    studio->ends = true;
    (void)pthread_cond_signal(&studio->ordered);
    (void)pthread_mutex_unlock(&studio->mutex);
    (void)pthread_join(studio->thread, NULL);
    discard(studio);
    (void)pthread_cond_destroy(&studio->ordered);
    (void)pthread_mutex_destroy(&studio->mutex);
    free(studio);
}

void studio_order(struct studio *studio, const struct order *order)
{
    (void)pthread_mutex_lock(&studio->mutex);
    discard(studio);
    studio->next = *order;
    studio->has_order = true;
    studio->is_busy = true;
    (void)pthread_cond_signal(&studio->ordered);
    (void)pthread_mutex_unlock(&studio->mutex);
}

bool studio_is_busy(struct studio *studio)
{
    (void)pthread_mutex_lock(&studio->mutex);
    const bool is_busy = studio->is_busy;
    (void)pthread_mutex_unlock(&studio->mutex);
    return is_busy;
}

bool studio_is_done(struct studio *studio)
{
    (void)pthread_mutex_lock(&studio->mutex);
    const bool is_done = studio->is_done;
    (void)pthread_mutex_unlock(&studio->mutex);
    return is_done;
}

bool studio_fetch(struct studio *studio, lum_reel **reel, lum_result *result)
{
    (void)pthread_mutex_lock(&studio->mutex);
    const bool is_done = studio->is_done;
    if (is_done) {
        *reel = studio->reel;
        *result = studio->result;
        studio->reel = NULL;
        studio->is_done = false;
        studio->is_busy = false;
    }
    (void)pthread_mutex_unlock(&studio->mutex);
    return is_done;
}
