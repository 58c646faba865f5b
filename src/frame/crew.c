#include "crew.h"

#include "base/system.h"
#include "base/thread.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* Lines that wait or are under way. */
#define JOBS 32u

/* A sleeping thread is woken when so many lines wait: waking one takes as long
 * as a few lines. */
#define WAKING 16u

struct job {
    lum_crew_task task;
    lum_line line; /* a copy */
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t *words;
    size_t room; /* for words */
    bool is_under_way;
};

/* One of the threads. */
struct member {
    lum_crew *crew;
    pthread_t thread;
    lum_column_work work;
};

struct lum_crew {
    long process; /* that has the threads */
    size_t words_max;
    struct job jobs[JOBS];
    lum_column_work work; /* of the caller */
    struct member *members;
    unsigned member_max;
    unsigned member_count;
    pthread_mutex_t lock; /* guards what follows, and is_under_way */
    pthread_cond_t is_given;
    pthread_cond_t is_made;
    uint64_t given;
    uint64_t claimed; /* by who makes them */
    uint64_t made;
    unsigned sleeping;
    bool stops;
};

static struct job *job_at(lum_crew *crew, uint64_t number)
{
    return &crew->jobs[number % JOBS];
}

/* Not in a child of fork(). */
static bool has_threads(const lum_crew *crew)
{
    return crew->process == lum_system_process();
}

/* --- Making points --- */

static void make(struct job *job, lum_column_work *work)
{
    const lum_frame_part part = {
        .line = job->task.line, .selection = job->task.selection, .work = work};
    if (job->task.smooth != NULL) {
        lum_smooth_line(job->task.smooth, &job->line, job->angles);
    }
    lum_column_work_begin(work);
    (void)lum_frame_make_points(&part, &job->task.places);
}

/* Make the next line; the lock is held before and after. */
static void make_next(lum_crew *crew, lum_column_work *work)
{
    struct job *job = job_at(crew, crew->claimed++);
    (void)pthread_mutex_unlock(&crew->lock);
    make(job, work);
    (void)pthread_mutex_lock(&crew->lock);
    job->is_under_way = false;
    crew->made++;
    (void)pthread_cond_signal(&crew->is_made);
}

/* --- The threads --- */

static void wait_for_work(lum_crew *crew)
{
    crew->sleeping++;
    (void)pthread_cond_wait(&crew->is_given, &crew->lock);
    crew->sleeping--;
}

static void work_on(lum_crew *crew, lum_column_work *work)
{
    (void)pthread_mutex_lock(&crew->lock);
    while (!crew->stops) {
        if (crew->claimed < crew->given) {
            make_next(crew, work);
        } else {
            wait_for_work(crew);
        }
    }
    (void)pthread_mutex_unlock(&crew->lock);
}

static void *run(void *argument)
{
    struct member *member = argument;
    work_on(member->crew, &member->work);
    return NULL;
}

/* Where the system has no thread or memory, the others, or the caller, do its
 * work. */
static void start_another(lum_crew *crew)
{
    if (crew->member_count == crew->member_max) {
        return;
    }
    struct member *member = &crew->members[crew->member_count];
    member->crew = crew;
    if (lum_column_work_allocate(&member->work, crew->words_max) &&
        lum_thread_start(&member->thread, run, member) == 0) {
        crew->member_count++;
    } else {
        lum_column_work_release(&member->work);
        crew->member_max = crew->member_count;
    }
}

/* --- The caller --- */

/* Make a line that nobody has begun, or wait for one; the lock is held before
 * and after. */
static void help(lum_crew *crew)
{
    if (crew->claimed < crew->given) {
        make_next(crew, &crew->work);
    } else {
        (void)pthread_cond_wait(&crew->is_made, &crew->lock);
    }
}

/* The next job, when it is free. */
static struct job *take_job(lum_crew *crew)
{
    (void)pthread_mutex_lock(&crew->lock);
    struct job *job = job_at(crew, crew->given);
    while (job->is_under_way) {
        help(crew);
    }
    (void)pthread_mutex_unlock(&crew->lock);
    return job;
}

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

static void copy_line(struct job *job, const lum_line *line)
{
    memcpy(job->angles, line->angles, sizeof job->angles);
    memcpy(job->marks, line->angle_marks, sizeof job->marks);
    job->line = *line;
    job->line.angles = job->angles;
    job->line.angle_marks = job->marks;
    job->line.words = job->words;
}

bool lum_crew_give(lum_crew *crew, const lum_crew_task *task)
{
    if (!has_threads(crew)) {
        return false;
    }
    struct job *job = take_job(crew);
    if (!copy_words(job, task->line.line)) {
        return false;
    }
    copy_line(job, task->line.line);
    job->task = *task;
    job->task.line.line = &job->line;
    (void)pthread_mutex_lock(&crew->lock);
    job->is_under_way = true;
    crew->given++;
    const uint64_t waiting = crew->given - crew->claimed;
    const bool wakes = waiting >= WAKING && crew->sleeping > 0;
    (void)pthread_mutex_unlock(&crew->lock);
    if (wakes) {
        (void)pthread_cond_signal(&crew->is_given);
    } else if (waiting >= WAKING) {
        start_another(crew);
    }
    return true;
}

/* In a child of fork() nobody makes what its parent had given. */
void lum_crew_settle(lum_crew *crew)
{
    if (crew == NULL || !has_threads(crew)) {
        return;
    }
    (void)pthread_mutex_lock(&crew->lock);
    while (crew->made < crew->given) {
        help(crew);
    }
    (void)pthread_mutex_unlock(&crew->lock);
}

/* --- Making and freeing --- */

bool lum_crew_new(unsigned threads, size_t words, lum_crew **out)
{
    *out = NULL;
    lum_crew *crew = calloc(1, sizeof *crew);
    if (crew == NULL) {
        return false;
    }
    if (pthread_mutex_init(&crew->lock, NULL) != 0 ||
        pthread_cond_init(&crew->is_given, NULL) != 0 ||
        pthread_cond_init(&crew->is_made, NULL) != 0) {
        free(crew);
        return false;
    }
    crew->process = lum_system_process();
    crew->words_max = words;
    crew->member_max = threads;
    crew->members = calloc(threads, sizeof *crew->members);
    if (crew->members == NULL ||
        !lum_column_work_allocate(&crew->work, words)) {
        lum_crew_free(crew);
        return false;
    }
    *out = crew;
    return true;
}

/* A child of fork() has none of the threads, and perhaps a lock that nobody
 * will leave. */
static void stop(lum_crew *crew)
{
    if (!has_threads(crew)) {
        return;
    }
    (void)pthread_mutex_lock(&crew->lock);
    crew->stops = true;
    (void)pthread_cond_broadcast(&crew->is_given);
    (void)pthread_mutex_unlock(&crew->lock);
    for (unsigned i = 0; i < crew->member_count; i++) {
        (void)pthread_join(crew->members[i].thread, NULL);
    }
    (void)pthread_cond_destroy(&crew->is_made);
    (void)pthread_cond_destroy(&crew->is_given);
    (void)pthread_mutex_destroy(&crew->lock);
}

void lum_crew_free(lum_crew *crew)
{
    if (crew == NULL) {
        return;
    }
    stop(crew);
    for (unsigned i = 0; i < JOBS; i++) {
        free(crew->jobs[i].words);
    }
    for (unsigned i = 0; i < crew->member_count; i++) {
        lum_column_work_release(&crew->members[i].work);
    }
    lum_column_work_release(&crew->work);
    free(crew->members);
    free(crew);
}
