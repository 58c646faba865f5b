#include "threads.h"

#include "base/thread_pool.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* Lines that wait or are under way. */
#define JOBS 32u

/* Waking a thread takes as long as a few lines. */
#define WAKING 16u

/* --- A lock --- */

struct lum_lock {
    pthread_mutex_t mutex;
};

lum_lock *lum_lock_new(void)
{
    lum_lock *lock = malloc(sizeof *lock);
    if (lock != NULL) {
        (void)pthread_mutex_init(&lock->mutex, NULL);
    }
    return lock;
}

void lum_lock_free(lum_lock *lock)
{
    (void)pthread_mutex_destroy(&lock->mutex);
    free(lock);
}

void lum_lock_take(lum_lock *lock)
{
    (void)pthread_mutex_lock(&lock->mutex);
}

void lum_lock_leave(lum_lock *lock)
{
    (void)pthread_mutex_unlock(&lock->mutex);
}

/* --- Making points --- */

struct job {
    lum_line_task task;
    lum_line line; /* a copy */
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t *words;
    size_t room; /* for words */
};

struct lum_line_threads {
    size_t words_max;
    lum_thread_pool *pool;
    struct job jobs[JOBS];
};

static void end(void *tools)
{
    if (tools != NULL) {
        lum_column_work_release(tools);
        free(tools);
    }
}

static void *begin(void *context)
{
    const lum_line_threads *threads = context;
    lum_column_work *work = calloc(1, sizeof *work);
    if (work != NULL && !lum_column_work_allocate(work, threads->words_max)) {
        end(work);
        return NULL;
    }
    return work;
}

static void make(void *context, size_t place, void *tools)
{
    lum_line_threads *threads = context;
    struct job *job = &threads->jobs[place];
    const lum_frame_part part = {.line = job->task.line,
                                 .selection = job->task.selection,
                                 .work = tools};
    if (job->task.smooth != NULL) {
        lum_smooth_line(job->task.smooth, &job->line, job->angles);
    }
    lum_column_work_begin(tools);
    (void)lum_frame_make_points(&part, &job->task.places);
}

/* --- For the caller --- */

static bool copy_words(struct job *job, const lum_line *line)
{
    if (job->room < line->word_count) {
        uint32_t *words = malloc(line->word_count * sizeof *words);
        if (words == NULL) {
            return false;
        }
        free(job->words);
        job->words = words;
        job->room = line->word_count;
    }
    memcpy(job->words, line->words, line->word_count * sizeof *job->words);
    return true;
}

bool lum_line_threads_give(lum_line_threads *threads, const lum_line_task *task)
{
    const lum_line *line = task->line.line;
    struct job *job = &threads->jobs[lum_thread_pool_next(threads->pool)];
    if (!copy_words(job, line)) {
        return false;
    }
    memcpy(job->angles, line->angles, sizeof job->angles);
    memcpy(job->marks, line->angle_marks, sizeof job->marks);
    job->line = *line;
    job->line.angles = job->angles;
    job->line.angle_marks = job->marks;
    job->line.words = job->words;
    job->task = *task;
    job->task.line.line = &job->line;
    lum_thread_pool_give(threads->pool);
    return true;
}

void lum_line_threads_settle(lum_line_threads *threads)
{
    if (threads != NULL) {
        lum_thread_pool_settle(threads->pool);
    }
}

bool lum_line_threads_new(unsigned threads, size_t words,
                          lum_line_threads **out)
{
    lum_line_threads *t = calloc(1, sizeof *t);
    *out = NULL;
    if (t == NULL) {
        return false;
    }
    t->words_max = words;
    t->pool = lum_thread_pool_new(&(lum_thread_pool_work){.places = JOBS,
                                                          .threads = threads,
                                                          .waking = WAKING,
                                                          .context = t,
                                                          .begin = begin,
                                                          .work = make,
                                                          .end = end});
    if (t->pool == NULL) {
        free(t);
        return false;
    }
    *out = t;
    return true;
}

void lum_line_threads_free(lum_line_threads *threads)
{
    if (threads == NULL) {
        return;
    }
    lum_thread_pool_free(threads->pool);
    for (unsigned i = 0; i < JOBS; i++) {
        free(threads->jobs[i].words);
    }
    free(threads);
}
