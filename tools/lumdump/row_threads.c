#include "row_threads.h"

#include "base/thread_pool.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

/* Batches for each thread: one in work, and one that waits. */
#define BATCHES_EACH 2u

struct job {
    struct batch *batch;
    bool ends_frame; /* behind its lines */
    int64_t ended;
    bool is_made; /* and not taken; guarded by the lock */
};

/* Jobs are counted from 0: given - taken is less than job_count, as the next is
 * being filled. */
struct job_counts {
    uint64_t given; /* to be made; only the caller changes it */
    uint64_t taken; /* to the outputs; guarded by the lock, as what follows */
    bool is_taking; /* a thread is at it */
};

/* The first one, after which nothing is taken any more. */
struct failure {
    bool is_there;
    int code;
    lum_error error;
};

struct row_threads {
    struct outputs *outputs; /* of the thread that takes a job */
    struct batch_view view;
    bool wants_samples;
    bool is_pattern; /* a file for each frame */
    struct job *jobs;
    size_t job_count;
    lum_thread_pool *pool; /* makes them */
    pthread_mutex_t lock;  /* guards what follows */
    pthread_cond_t is_taken;
    struct job_counts counts;
    bool stops;
    struct failure failure;
};

static struct job *job_at(struct row_threads *rows, uint64_t number)
{
    return &rows->jobs[number % rows->job_count];
}

/* --- Rows to the outputs --- */

/* Write the rows of a job that is made, and make it ready for others. */
static int take(struct row_threads *rows, struct job *job, lum_error *error)
{
    int result = 0;
    if (!batch_is_empty(job->batch)) {
        const int64_t frame = batch_frame(job->batch);
        lum_writer *part = batch_rows(job->batch, error);
        result = part != NULL ? outputs_act(rows->outputs,
                                            &(struct action){.kind = ADD_ROWS,
                                                             .number = frame,
                                                             .part = part},
                                            error)
                              : -1;
    }
    if (result == 0 && job->ends_frame) {
        result = outputs_act(
            rows->outputs,
            &(struct action){.kind = END_FRAME, .number = job->ended}, error);
    }
    const int code = errno;
    job->ends_frame = false;
    batch_clear(job->batch);
    errno = code;
    return result;
}

static bool can_take(struct row_threads *rows)
{
    return !rows->counts.is_taking && !rows->failure.is_there && !rows->stops &&
           rows->counts.taken < rows->counts.given &&
           job_at(rows, rows->counts.taken)->is_made;
}

/* Write what is made, in its order, if no other thread is at it; the lock is
 * held before and after. */
static void take_made(struct row_threads *rows)
{
    lum_error error = {""};
    while (can_take(rows)) {
        struct job *job = job_at(rows, rows->counts.taken);
        rows->counts.is_taking = true;
        (void)pthread_mutex_unlock(&rows->lock);
        const bool fails = take(rows, job, &error) != 0;
        const int code = errno;
        (void)pthread_mutex_lock(&rows->lock);
        rows->counts.is_taking = false;
        job->is_made = false;
        rows->counts.taken++;
        if (fails) {
            rows->failure = (struct failure){true, code, error};
        }
        (void)pthread_cond_signal(&rows->is_taken);
    }
}

/* --- The threads --- */

static void *begin(void *context)
{
    (void)context;
    return batch_tools_new();
}

static void end(void *tools)
{
    batch_tools_free(tools);
}

static void make(void *context, size_t place, void *tools)
{
    struct row_threads *rows = context;
    struct job *job = &rows->jobs[place];
    batch_make(job->batch, &rows->view, tools);
    (void)pthread_mutex_lock(&rows->lock);
    job->is_made = true;
    take_made(rows);
    (void)pthread_mutex_unlock(&rows->lock);
}

/* --- Jobs --- */

/* Whether more than this number of jobs is under way. */
static bool are_under_way(const struct row_threads *rows, uint64_t count)
{
    return !rows->failure.is_there &&
           rows->counts.given - rows->counts.taken > count;
}

/* Work, or wait, until at most this number of jobs is under way. */
static int work_until(struct row_threads *rows, uint64_t count,
                      lum_error *error)
{
    (void)pthread_mutex_lock(&rows->lock);
    while (are_under_way(rows, count)) {
        (void)pthread_mutex_unlock(&rows->lock);
        const bool has_helped = lum_thread_pool_help(rows->pool);
        (void)pthread_mutex_lock(&rows->lock);
        if (!has_helped && are_under_way(rows, count)) {
            (void)pthread_cond_wait(&rows->is_taken, &rows->lock);
        }
    }
    const bool fails = rows->failure.is_there;
    (void)pthread_mutex_unlock(&rows->lock);
    if (fails) {
        *error = rows->failure.error;
        errno = rows->failure.code;
    }
    return fails ? -1 : 0;
}

static struct job *being_filled(struct row_threads *rows)
{
    return job_at(rows, rows->counts.given);
}

/* Have the job being filled made, and get the next. */
static int give(struct row_threads *rows, lum_error *error)
{
    (void)pthread_mutex_lock(&rows->lock);
    rows->counts.given++;
    (void)pthread_mutex_unlock(&rows->lock);
    lum_thread_pool_give(rows->pool);
    return work_until(rows, rows->job_count - 1u, error);
}

static int fail_memory(lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "out of memory");
}

/* The batch for a line of this frame; NULL with the reason in error. */
static struct batch *batch_for(struct row_threads *rows, int64_t frame,
                               lum_error *error)
{
    const struct batch *filled = being_filled(rows)->batch;
    if (rows->is_pattern && !batch_is_empty(filled) &&
        batch_frame(filled) != frame && give(rows, error) != 0) {
        return NULL;
    }
    return being_filled(rows)->batch;
}

int row_threads_add(struct row_threads *rows, lum_framer *framer,
                    const lum_projector *projector, lum_line_samples *points,
                    lum_error *error)
{
    struct batch *batch = batch_for(rows, points->frame, error);
    int result = 0;
    if (batch == NULL) {
        return -1;
    }
    if (rows->wants_samples) {
        points->count = lum_framer_line_samples(framer, 0, &points->samples);
        result = batch_add_samples(batch, points);
    } else {
        result =
            batch_add_line(batch, lum_framer_line(framer), projector, points);
    }
    if (result != 0) {
        return fail_memory(error);
    }
    return batch_is_full(batch) ? give(rows, error) : 0;
}

int row_threads_end_frame(struct row_threads *rows, int64_t frame,
                          lum_error *error)
{
    struct job *job = being_filled(rows);
    if (!rows->is_pattern) {
        return 0;
    }
    job->ends_frame = true;
    job->ended = frame;
    return give(rows, error);
}

int row_threads_finish(struct row_threads *rows, lum_error *error)
{
    if (!batch_is_empty(being_filled(rows)->batch) && give(rows, error) != 0) {
        return -1;
    }
    return work_until(rows, 0, error);
}

/* --- Making and freeing --- */

/* Whether several threads can work for these options: one cloud, of lines, in a
 * format whose rows do not depend on each other, and no new files after a size
 * or a time. */
static bool can_serve(const struct options *options)
{
    return !options->is_live && options->output_count == 1 &&
           !options_is_capture(options->outputs[0].format) &&
           lum_format_has_parts((lum_format)options->outputs[0].format) &&
           !options_takes_frames(options, 0) && options->cloud.voxel == 0 &&
           !options_rotates(options, 0);
}

/* Where this is not so, the framer makes a line's points to count them. */
static bool counts_words(const lum_selection *s)
{
    return s->returns == LUM_RETURNS_ALL && !s->has_range && !s->has_box;
}

static int set_view(struct row_threads *rows, const struct options *o)
{
    rows->view.selection = o->choice.points;
    rows->view.leaves = options_leaves(o);
    rows->view.smooths = o->points.smooth_window > 1u;
    rows->wants_samples = !counts_words(&o->choice.points);
    return rows->view.smooths &&
                   lum_smooth_init(&rows->view.smooth, o->points.smooth_window,
                                   o->points.smooth_order) != LUM_OK
               ? -1
               : 0;
}

static int make_jobs(struct row_threads *rows, unsigned threads,
                     lum_error *error)
{
    const size_t count = threads * BATCHES_EACH + 1u;
    rows->jobs = calloc(count, sizeof *rows->jobs);
    rows->pool =
        lum_thread_pool_new(&(lum_thread_pool_work){.places = count,
                                                    .threads = threads - 1u,
                                                    .waking = 1,
                                                    .context = rows,
                                                    .begin = begin,
                                                    .work = make,
                                                    .end = end});
    if (rows->jobs == NULL || rows->pool == NULL) {
        return fail_memory(error);
    }
    for (; rows->job_count < count; rows->job_count++) {
        lum_writer *part = NULL;
        if (outputs_open_part(rows->outputs, &part, error) != 0) {
            return -1;
        }
        struct batch *batch = batch_new(part);
        if (batch == NULL) {
            return fail_memory(error);
        }
        rows->jobs[rows->job_count].batch = batch;
    }
    return 0;
}

int row_threads_new(const struct options *options, struct outputs *outputs,
                    struct row_threads **out, lum_error *error)
{
    const unsigned threads = options_threads(options);
    *out = NULL;
    if (threads == 1u || !can_serve(options)) {
        return 0;
    }
    struct row_threads *rows = calloc(1, sizeof *rows);
    if (rows == NULL) {
        return fail_memory(error);
    }
    (void)pthread_mutex_init(&rows->lock, NULL);
    (void)pthread_cond_init(&rows->is_taken, NULL);
    rows->outputs = outputs;
    rows->is_pattern = options_pattern(options->outputs[0].name) == 1;
    if (set_view(rows, options) != 0 || make_jobs(rows, threads, error) != 0) {
        row_threads_free(rows);
        return -1;
    }
    *out = rows;
    return 0;
}

void row_threads_free(struct row_threads *rows)
{
    if (rows == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&rows->lock);
    rows->stops = true;
    (void)pthread_mutex_unlock(&rows->lock);
    lum_thread_pool_free(rows->pool);
    for (size_t i = 0; i < rows->job_count; i++) {
        batch_free(rows->jobs[i].batch);
    }
    (void)pthread_cond_destroy(&rows->is_taken);
    (void)pthread_mutex_destroy(&rows->lock);
    free(rows->jobs);
    free(rows);
}
