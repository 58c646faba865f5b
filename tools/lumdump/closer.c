#include "closer.h"

#include "base/outfile_io.h"
#include "base/thread.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The first failure. */
struct failure {
    bool is_there;
    int code;
    lum_error error;
};

/* What became of files that others removed or renamed. */
struct lost {
    bool is_there;
    bool is_told; /* one of them was */
    lum_error first;
    lum_error list[CLOSER_ROOM_MAX]; /* to be told */
    size_t count;
};

struct closer {
    size_t room;
    pthread_t thread;
    bool is_started;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    struct closing files[CLOSER_ROOM_MAX]; /* the first is under way */
    size_t count;
    int copy;               /* to be synced; -1: none */
    char name[256];         /* of that */
    struct retention *plan; /* whose next file is to be planned; NULL: none */
    unsigned waiting;       /* threads */
    bool ends;
    struct failure failure;
    struct lost lost;
};

/* A file that others have removed or renamed is told too. */
int closing_finish(const struct closing *closing, lum_error *error)
{
    const int result = output_file_close(&closing->file, error);
    const int code = errno;
    if (closing->retention == NULL || (result != 0 && code != ENOENT)) {
        return result;
    }
    const int listed =
        retention_finish(closing->retention, closing->file.number,
                         closing->last_ns, result == 0 ? error : NULL);
    errno = result == 0 ? errno : code;
    return result == 0 ? listed : result;
}

struct closer *closer_new(size_t room, lum_error *error)
{
    struct closer *c = calloc(1, sizeof *c);
    if (c == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    c->room = room;
    c->copy = -1;
    (void)pthread_mutex_init(&c->lock, NULL);
    (void)pthread_cond_init(&c->changed, NULL);
    return c;
}

/* They are taken twice a second: there is room. */
static void note_lost(struct lost *lost, const lum_error *error)
{
    if (!lost->is_there) {
        lost->is_there = true;
        lost->first = *error;
    }
    if (lost->count < CLOSER_ROOM_MAX) {
        lost->list[lost->count++] = *error;
    }
}

/* The lock is held. code: 0 or an errno. */
static void note(struct closer *c, int code, const lum_error *error)
{
    if (code == ENOENT) {
        note_lost(&c->lost, error);
    } else if (code != 0 && !c->failure.is_there) {
        c->failure = (struct failure){true, code, *error};
    }
}

/* The lock is held before and after. */
static void finish_first(struct closer *c)
{
    lum_error error = {""};
    struct closing file = c->files[0];
    (void)pthread_mutex_unlock(&c->lock);
    const int result = closing_finish(&file, &error);
    const int reason = errno != 0 ? errno : EIO;
    const int code = result != 0 ? reason : 0;
    (void)pthread_mutex_lock(&c->lock);
    note(c, code, &error);
    c->count--;
    memmove(c->files, c->files + 1, c->count * sizeof c->files[0]);
    (void)pthread_cond_broadcast(&c->changed);
}

/* The lock is held before and after. */
static void sync_copy(struct closer *c)
{
    lum_error error = {""};
    const int copy = c->copy;
    char name[sizeof c->name];
    memcpy(name, c->name, sizeof name);
    c->copy = -1;
    (void)pthread_mutex_unlock(&c->lock);
    const int code = lum_outfile_sync_copy(copy);
    (void)lum_error_set(&error, "%s: cannot write it to the disk: %s", name,
                        strerror(code));
    (void)pthread_mutex_lock(&c->lock);
    note(c, code, &error);
}

/* The lock is held before and after. */
static void make_plan(struct closer *c)
{
    lum_error error = {""};
    struct retention *retention = c->plan;
    (void)pthread_mutex_unlock(&c->lock);
    const int result = retention_plan(retention, &error);
    const int code = result != 0 ? errno : 0;
    (void)pthread_mutex_lock(&c->lock);
    note(c, code, &error);
    c->plan = NULL;
    (void)pthread_cond_broadcast(&c->changed);
}

static void *run(void *argument)
{
    struct closer *c = argument;
    (void)pthread_mutex_lock(&c->lock);
    while (c->count > 0 || c->copy >= 0 || c->plan != NULL || !c->ends) {
        if (c->copy >= 0) {
            sync_copy(c);
        } else if (c->plan != NULL) {
            make_plan(c);
        } else if (c->count > 0) {
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
    while (c->count > count || (count == 0 && c->plan != NULL)) {
        (void)pthread_cond_wait(&c->changed, &c->lock);
    }
    c->waiting--;
}

/* The lock is held. */
static int pass_on(const struct failure *failure, lum_error *error)
{
    if (!failure->is_there) {
        return 0;
    }
    if (error != NULL) {
        *error = failure->error;
    }
    errno = failure->code;
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
    const int result = pass_on(&closer->failure, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&closer->lock);
    errno = code;
    return result;
}

/* One that waits still is of a file that has ended meanwhile, and is synced
 * when that is finished. */
void closer_sync(struct closer *closer, int copy, const char *name)
{
    if (copy < 0) {
        return;
    }
    start(closer);
    (void)pthread_mutex_lock(&closer->lock);
    const int unused = closer->is_started ? closer->copy : copy;
    closer->copy = closer->is_started ? copy : -1;
    (void)snprintf(closer->name, sizeof closer->name, "%s", name);
    (void)pthread_cond_broadcast(&closer->changed);
    (void)pthread_mutex_unlock(&closer->lock);
    if (unused >= 0) {
        (void)close(unused);
    }
}

bool closer_plan(struct closer *closer, struct retention *retention)
{
    start(closer);
    if (!closer->is_started) {
        return false;
    }
    (void)pthread_mutex_lock(&closer->lock);
    if (closer->plan == NULL) {
        closer->plan = retention;
        (void)pthread_cond_broadcast(&closer->changed);
    }
    (void)pthread_mutex_unlock(&closer->lock);
    return true;
}

int closer_check(struct closer *closer, lum_error *error)
{
    (void)pthread_mutex_lock(&closer->lock);
    const int result = pass_on(&closer->failure, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&closer->lock);
    errno = code;
    return result;
}

/* The lock is held. */
static bool take_lost(struct lost *lost, lum_error *out)
{
    if (lost->count == 0) {
        return false;
    }
    *out = lost->list[0];
    lost->count--;
    memmove(lost->list, lost->list + 1, lost->count * sizeof lost->list[0]);
    lost->is_told = true;
    return true;
}

/* Who waits for the end tells the first one himself. */
bool closer_take_lost(struct closer *closer, lum_error *out)
{
    (void)pthread_mutex_lock(&closer->lock);
    const bool is_taken = closer->waiting == 0 && take_lost(&closer->lost, out);
    (void)pthread_mutex_unlock(&closer->lock);
    return is_taken;
}

/* The lock is held. */
static int pass_on_lost(struct lost *lost, lum_error *error)
{
    lum_error first;
    if (!lost->is_there) {
        return 0;
    }
    if (error != NULL && !lost->is_told) {
        (void)take_lost(lost, &first);
    }
    if (error != NULL) {
        *error = lost->first;
    }
    errno = ENOENT;
    return -1;
}

int closer_wait(struct closer *closer, lum_error *error)
{
    (void)pthread_mutex_lock(&closer->lock);
    wait_until(closer, 0);
    const int result = pass_on(&closer->failure, error) != 0
                           ? -1
                           : pass_on_lost(&closer->lost, error);
    const int code = errno;
    (void)pthread_mutex_unlock(&closer->lock);
    errno = code;
    return result;
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
