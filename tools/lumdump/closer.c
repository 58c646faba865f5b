#include "closer.h"

#include "cloud/thread.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

struct closer {
    size_t room;
    pthread_t thread;
    bool is_started;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    struct closing files[CLOSER_ROOM_MAX]; /* the first is under way */
    size_t count;
    unsigned waiting; /* threads */
    bool ends;
    bool has_failed;
    int code; /* of the failure */
    lum_error error;
};

int closing_finish(struct closing *file, lum_error *error)
{
    return file->cloud != NULL ? lum_writer_close(file->cloud, error)
                               : lum_capture_writer_close(file->capture, error);
}

struct closer *closer_new(size_t room, lum_error *error)
{
    struct closer *c = calloc(1, sizeof *c);
    if (c == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    c->room = room;
    (void)pthread_mutex_init(&c->lock, NULL);
    (void)pthread_cond_init(&c->changed, NULL);
    return c;
}

/* The lock is held before and after. */
static void finish_first(struct closer *c)
{
    lum_error error = {""};
    struct closing file = c->files[0];
    (void)pthread_mutex_unlock(&c->lock);
    const int result = closing_finish(&file, &error);
    const int code = errno;
    (void)pthread_mutex_lock(&c->lock);
    if (result != 0 && !c->has_failed) {
        c->has_failed = true;
        c->code = code;
        c->error = error;
    }
    c->count--;
    memmove(c->files, c->files + 1, c->count * sizeof c->files[0]);
    (void)pthread_cond_broadcast(&c->changed);
}

static void *run(void *argument)
{
    struct closer *c = argument;
    (void)pthread_mutex_lock(&c->lock);
    while (c->count > 0 || !c->ends) {
        if (c->count > 0) {
            finish_first(c);
        } else {
            (void)pthread_cond_wait(&c->changed, &c->lock);
        }
    }
    (void)pthread_mutex_unlock(&c->lock);
    return NULL;
}

/* Many runs have no file to finish before the end. */
static void start(struct closer *c)
{
    if (!c->is_started) {
        c->is_started = lum_thread_start(&c->thread, run, c) == 0;
    }
}

/* The lock is held. */
static void wait_until(struct closer *c, size_t count)
{
    c->waiting++;
    while (c->count > count) {
        (void)pthread_cond_wait(&c->changed, &c->lock);
    }
    c->waiting--;
}

/* The lock is held. */
static int tell(const struct closer *c, lum_error *error)
{
    if (!c->has_failed) {
        return 0;
    }
    if (error != NULL) {
        *error = c->error;
    }
    errno = c->code;
    return -1;
}

bool closer_has_room(struct closer *closer)
{
    (void)pthread_mutex_lock(&closer->lock);
    const bool has_room = closer->count < closer->room;
    (void)pthread_mutex_unlock(&closer->lock);
    return has_room;
}

/* Without a thread the caller finishes it, and waits. */
int closer_put(struct closer *closer, const struct closing *file,
               lum_error *error)
{
    start(closer);
    (void)pthread_mutex_lock(&closer->lock);
    wait_until(closer, closer->room - 1u);
    closer->files[closer->count++] = *file;
    if (closer->is_started) {
        (void)pthread_cond_broadcast(&closer->changed);
    } else {
        closer->waiting++;
        finish_first(closer);
        closer->waiting--;
    }
    const int result = tell(closer, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&closer->lock);
    errno = code;
    return result;
}

int closer_check(struct closer *closer, lum_error *error)
{
    (void)pthread_mutex_lock(&closer->lock);
    const int result = tell(closer, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&closer->lock);
    errno = code;
    return result;
}

int closer_wait(struct closer *closer, lum_error *error)
{
    (void)pthread_mutex_lock(&closer->lock);
    wait_until(closer, 0);
    (void)pthread_mutex_unlock(&closer->lock);
    return closer_check(closer, error);
}

bool closer_is_waited_for(struct closer *closer)
{
    (void)pthread_mutex_lock(&closer->lock);
    const bool is_waited_for = closer->waiting > 0;
    (void)pthread_mutex_unlock(&closer->lock);
    return is_waited_for;
}

void closer_free(struct closer *closer)
{
    if (closer == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&closer->lock);
    closer->ends = true;
    (void)pthread_cond_broadcast(&closer->changed);
    (void)pthread_mutex_unlock(&closer->lock);
    if (closer->is_started) {
        (void)pthread_join(closer->thread, NULL);
    }
    (void)pthread_cond_destroy(&closer->changed);
    (void)pthread_mutex_destroy(&closer->lock);
    free(closer);
}
