#include "thread_pool.h"

#include "system.h"
#include "thread.h"

#include <stdint.h>
#include <stdlib.h>

/* One of the threads. */
struct member {
    lum_thread_pool *pool;
    pthread_t thread;
    void *tools;
    struct member *next;
};

struct lum_thread_pool {
    lum_thread_pool_work work;
    long process;           /* that has the threads */
    void *tools;            /* of the user */
    struct member *members; /* the latest first */
    unsigned member_count;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t is_given;
    pthread_cond_t is_done;
    uint64_t given;
    uint64_t claimed; /* by who does them */
    uint64_t done;
    unsigned sleeping;
    bool stops;
    bool is_under_way[]; /* by place */
};

/* Not in a child of fork(). */
static bool has_threads(const lum_thread_pool *pool)
{
    return pool->process == lum_system_process();
}

static size_t place_of(const lum_thread_pool *pool, uint64_t number)
{
    return (size_t)(number % pool->work.places);
}

/* --- The threads; the lock is held before and after --- */

static void do_next(lum_thread_pool *pool, void *tools)
{
    const size_t place = place_of(pool, pool->claimed++);
    (void)pthread_mutex_unlock(&pool->lock);
    pool->work.work(pool->work.context, place, tools);
    (void)pthread_mutex_lock(&pool->lock);
    pool->is_under_way[place] = false;
    pool->done++;
    (void)pthread_cond_signal(&pool->is_done);
}

static void *run(void *argument)
{
    const struct member *member = argument;
    lum_thread_pool *pool = member->pool;
    (void)pthread_mutex_lock(&pool->lock);
    while (!pool->stops) {
        if (pool->claimed < pool->given) {
            do_next(pool, member->tools);
        } else {
            pool->sleeping++;
            (void)pthread_cond_wait(&pool->is_given, &pool->lock);
            pool->sleeping--;
        }
    }
    (void)pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Do a job that nobody has begun, or wait for one. */
static void help(lum_thread_pool *pool)
{
    if (pool->claimed < pool->given) {
        do_next(pool, pool->tools);
    } else {
        (void)pthread_cond_wait(&pool->is_done, &pool->lock);
    }
}

/* --- For the user --- */

static void free_member(const lum_thread_pool *pool, struct member *member)
{
    if (member != NULL) {
        pool->work.end(member->tools);
        free(member);
    }
}

/* Where the system has no thread or memory, the others, or the user, do its
 * work. */
static void start_another(lum_thread_pool *pool)
{
    struct member *m = calloc(1, sizeof *m);
    if (m != NULL) {
        m->pool = pool;
        m->tools = pool->work.begin(pool->work.context);
        m->next = pool->members;
    }
    if (m == NULL || m->tools == NULL ||
        lum_thread_start(&m->thread, run, m) != 0) {
        free_member(pool, m);
        pool->work.threads = pool->member_count;
        (void)pthread_cond_signal(&pool->is_given);
        return;
    }
    pool->members = m;
    pool->member_count++;
}

size_t lum_thread_pool_next(lum_thread_pool *pool)
{
    const size_t place = place_of(pool, pool->given);
    (void)(has_threads(pool) && lum_thread_pool_is_done(pool, place, true));
    return place;
}

void lum_thread_pool_give(lum_thread_pool *pool)
{
    const size_t place = place_of(pool, pool->given);
    if (!has_threads(pool)) {
        pool->work.work(pool->work.context, place, pool->tools);
        return;
    }
    (void)pthread_mutex_lock(&pool->lock);
    pool->is_under_way[place] = true;
    pool->given++;
    const bool is_much = pool->given - pool->claimed >= pool->work.waking;
    const bool wakes = is_much && pool->sleeping > 0;
    (void)pthread_mutex_unlock(&pool->lock);
    if (pool->work.threads == 0) {
        lum_thread_pool_settle(pool);
    } else if (is_much && pool->member_count < pool->work.threads) {
        start_another(pool);
    } else if (wakes) {
        (void)pthread_cond_signal(&pool->is_given);
    }
}

bool lum_thread_pool_help(lum_thread_pool *pool)
{
    (void)pthread_mutex_lock(&pool->lock);
    const bool has_one = pool->claimed < pool->given;
    if (has_one) {
        do_next(pool, pool->tools);
    }
    (void)pthread_mutex_unlock(&pool->lock);
    return has_one;
}

bool lum_thread_pool_is_done(lum_thread_pool *pool, size_t place, bool waits)
{
    (void)pthread_mutex_lock(&pool->lock);
    while (waits && pool->is_under_way[place]) {
        help(pool);
    }
    const bool is_done = !pool->is_under_way[place];
    (void)pthread_mutex_unlock(&pool->lock);
    return is_done;
}

/* In a child of fork() nobody does what its parent had given. */
void lum_thread_pool_settle(lum_thread_pool *pool)
{
    if (has_threads(pool)) {
        (void)pthread_mutex_lock(&pool->lock);
        while (pool->done < pool->given) {
            help(pool);
        }
        (void)pthread_mutex_unlock(&pool->lock);
    }
}

/* --- Making and freeing --- */

lum_thread_pool *lum_thread_pool_new(const lum_thread_pool_work *work)
{
    lum_thread_pool *pool = calloc(1, sizeof *pool + work->places);
    if (pool == NULL || (pool->tools = work->begin(work->context)) == NULL) {
        free(pool);
        return NULL;
    }
    pool->work = *work;
    pool->process = lum_system_process();
    (void)pthread_mutex_init(&pool->lock, NULL);
    (void)pthread_cond_init(&pool->is_given, NULL);
    (void)pthread_cond_init(&pool->is_done, NULL);
    return pool;
}

void lum_thread_pool_set_threads(lum_thread_pool *pool, unsigned threads)
{
    pool->work.threads = threads;
}

/* A child of fork() has none of the threads, and perhaps a lock that nobody
 * will leave. */
static void stop(lum_thread_pool *pool)
{
    (void)pthread_mutex_lock(&pool->lock);
    pool->stops = true;
    (void)pthread_cond_broadcast(&pool->is_given);
    (void)pthread_mutex_unlock(&pool->lock);
    for (struct member *m = pool->members; m != NULL; m = m->next) {
        (void)pthread_join(m->thread, NULL);
    }
    (void)pthread_cond_destroy(&pool->is_done);
    (void)pthread_cond_destroy(&pool->is_given);
    (void)pthread_mutex_destroy(&pool->lock);
}

void lum_thread_pool_free(lum_thread_pool *pool)
{
    if (pool == NULL) {
        return;
    }
    if (has_threads(pool)) {
        stop(pool);
    }
    while (pool->members != NULL) {
        struct member *member = pool->members;
        pool->members = member->next;
        free_member(pool, member);
    }
    pool->work.end(pool->tools);
    free(pool);
}
