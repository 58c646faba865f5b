#include "crew.h"

#include "base/thread.h"

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

/* Jobs are counted from 0: taken <= claimed <= given, and given - taken is less
 * than job_count: the next is being filled. Guarded by the lock. */
struct job_counts {
    uint64_t given;   /* to be made; only the caller changes it */
    uint64_t claimed; /* by who makes them */
    uint64_t taken;   /* to the outputs */
    bool is_taking;   /* a thread is at it */
};

/* The first one, after which nothing is taken any more. */
struct failure {
    bool is_there;
    int code;
    lum_error error;
};

/* Of the caller, who starts them. */
struct threads {
    pthread_t list[CREW_MAX - 1];
    size_t count;
    size_t max;
};

struct crew {
    struct outputs *outputs; /* of the thread that takes a job */
    struct batch_view view;
    bool wants_samples;
    bool is_pattern; /* a file for each frame */
    struct job *jobs;
    size_t job_count;
    struct batch_tools *tools; /* of the caller */
    struct threads threads;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t is_given;
    pthread_cond_t is_taken;
    struct job_counts counts;
    bool stops;
    struct failure failure;
};

static struct job *job_at(struct crew *crew, uint64_t number)
{
    return &crew->jobs[number % crew->job_count];
}

/* --- Rows to the outputs --- */

/* Write the rows of a job that is made, and make it ready for others. */
static int take(struct crew *crew, struct job *job, lum_error *error)
{
    int result = 0;
    if (!batch_is_empty(job->batch)) {
        const int64_t frame = batch_frame(job->batch);
        lum_writer *rows = batch_rows(job->batch, error);
        result = rows != NULL ? outputs_act(crew->outputs,
                                            &(struct action){.kind = ADD_ROWS,
                                                             .number = frame,
                                                             .part = rows},
                                            error)
                              : -1;
    }
    if (result == 0 && job->ends_frame) {
        result = outputs_act(
            crew->outputs,
            &(struct action){.kind = END_FRAME, .number = job->ended}, error);
    }
    const int code = errno;
    job->ends_frame = false;
    batch_clear(job->batch);
    errno = code;
    return result;
}

static bool can_take(struct crew *crew)
{
    return !crew->counts.is_taking && !crew->failure.is_there && !crew->stops &&
           crew->counts.taken < crew->counts.given &&
           job_at(crew, crew->counts.taken)->is_made;
}

/* Write what is made, in its order, if no other thread is at it; the lock is
 * held before and after. */
static void take_made(struct crew *crew)
{
    lum_error error = {""};
    while (can_take(crew)) {
        struct job *job = job_at(crew, crew->counts.taken);
        crew->counts.is_taking = true;
        (void)pthread_mutex_unlock(&crew->lock);
        const bool fails = take(crew, job, &error) != 0;
        const int code = errno;
        (void)pthread_mutex_lock(&crew->lock);
        crew->counts.is_taking = false;
        job->is_made = false;
        crew->counts.taken++;
        if (fails) {
            crew->failure = (struct failure){true, code, error};
        }
        (void)pthread_cond_signal(&crew->is_taken);
    }
}

/* --- The threads --- */

/* Make the next job; the lock is held before and after. */
static void make_next(struct crew *crew, struct batch_tools *tools)
{
    struct job *job = job_at(crew, crew->counts.claimed++);
    (void)pthread_mutex_unlock(&crew->lock);
    batch_make(job->batch, &crew->view, tools);
    (void)pthread_mutex_lock(&crew->lock);
    job->is_made = true;
    take_made(crew);
}

static void work(struct crew *crew, struct batch_tools *tools)
{
    (void)pthread_mutex_lock(&crew->lock);
    while (!crew->stops) {
        if (crew->counts.claimed < crew->counts.given) {
            make_next(crew, tools);
        } else {
            (void)pthread_cond_wait(&crew->is_given, &crew->lock);
        }
    }
    (void)pthread_mutex_unlock(&crew->lock);
}

/* Without memory the others do its work. */
static void *run(void *argument)
{
    struct batch_tools *tools = batch_tools_new();
    if (tools != NULL) {
        work(argument, tools);
    }
    batch_tools_free(tools);
    return NULL;
}

/* Small captures need no thread, so one more comes with each job. If the system
 * has none, the caller does the work. */
static void start_another(struct crew *crew)
{
    struct threads *t = &crew->threads;
    if (t->count == t->max) {
        return;
    }
    if (lum_thread_start(&t->list[t->count], run, crew) == 0) {
        t->count++;
    } else {
        t->max = t->count;
    }
}

/* --- Jobs --- */

/* Work, or wait, until at most this number of jobs is under way. */
static int work_until(struct crew *crew, uint64_t under_way, lum_error *error)
{
    (void)pthread_mutex_lock(&crew->lock);
    while (!crew->failure.is_there &&
           crew->counts.given - crew->counts.taken > under_way) {
        if (crew->counts.claimed < crew->counts.given) {
            make_next(crew, crew->tools);
        } else {
            (void)pthread_cond_wait(&crew->is_taken, &crew->lock);
        }
    }
    const bool fails = crew->failure.is_there;
    (void)pthread_mutex_unlock(&crew->lock);
    if (fails) {
        *error = crew->failure.error;
        errno = crew->failure.code;
    }
    return fails ? -1 : 0;
}

static struct job *being_filled(struct crew *crew)
{
    return job_at(crew, crew->counts.given);
}

/* Have the job being filled made, and get the next. */
static int give(struct crew *crew, lum_error *error)
{
    (void)pthread_mutex_lock(&crew->lock);
    crew->counts.given++;
    (void)pthread_cond_signal(&crew->is_given);
    (void)pthread_mutex_unlock(&crew->lock);
    return work_until(crew, crew->job_count - 1u, error);
}

static int give_full(struct crew *crew, lum_error *error)
{
    if (!batch_is_full(being_filled(crew)->batch)) {
        return 0;
    }
    start_another(crew);
    return give(crew, error);
}

static int fail_memory(lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "out of memory");
}

/* The batch for a line of this frame; NULL with the reason in error. */
static struct batch *batch_for(struct crew *crew, int64_t frame,
                               lum_error *error)
{
    const struct batch *filled = being_filled(crew)->batch;
    if (crew->is_pattern && !batch_is_empty(filled) &&
        batch_frame(filled) != frame && give(crew, error) != 0) {
        return NULL;
    }
    return being_filled(crew)->batch;
}

int crew_add(struct crew *crew, lum_framer *framer,
             const lum_projector *projector, lum_line_samples *points,
             lum_error *error)
{
    struct batch *batch = batch_for(crew, points->frame, error);
    int result = 0;
    if (batch == NULL) {
        return -1;
    }
    if (crew->wants_samples) {
        points->count = lum_framer_line_samples(framer, 0, &points->samples);
        result = batch_add_samples(batch, points);
    } else {
        result =
            batch_add_line(batch, lum_framer_line(framer), projector, points);
    }
    return result == 0 ? give_full(crew, error) : fail_memory(error);
}

int crew_end_frame(struct crew *crew, int64_t frame, lum_error *error)
{
    struct job *job = being_filled(crew);
    if (!crew->is_pattern) {
        return 0;
    }
    job->ends_frame = true;
    job->ended = frame;
    return give(crew, error);
}

int crew_finish(struct crew *crew, lum_error *error)
{
    if (!batch_is_empty(being_filled(crew)->batch) && give(crew, error) != 0) {
        return -1;
    }
    return work_until(crew, 0, error);
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

static int set_view(struct crew *crew, const struct options *o)
{
    crew->view.selection = o->choice.points;
    crew->view.leaves = options_leaves(o);
    crew->view.smooths = o->points.smooth_window > 1u;
    crew->wants_samples = !counts_words(&o->choice.points);
    return crew->view.smooths &&
                   lum_smooth_init(&crew->view.smooth, o->points.smooth_window,
                                   o->points.smooth_order) != LUM_OK
               ? -1
               : 0;
}

static int make_jobs(struct crew *crew, size_t count, lum_error *error)
{
    crew->jobs = calloc(count, sizeof *crew->jobs);
    crew->tools = batch_tools_new();
    if (crew->jobs == NULL || crew->tools == NULL) {
        return fail_memory(error);
    }
    for (; crew->job_count < count; crew->job_count++) {
        lum_writer *part = NULL;
        if (outputs_open_part(crew->outputs, &part, error) != 0) {
            return -1;
        }
        struct batch *batch = batch_new(part);
        if (batch == NULL) {
            return fail_memory(error);
        }
        crew->jobs[crew->job_count].batch = batch;
    }
    return 0;
}

int crew_new(const struct options *options, struct outputs *outputs,
             struct crew **out, lum_error *error)
{
    const unsigned threads = options_threads(options);
    *out = NULL;
    if (threads == 1u || !can_serve(options)) {
        return 0;
    }
    struct crew *crew = calloc(1, sizeof *crew);
    if (crew == NULL) {
        return fail_memory(error);
    }
    (void)pthread_mutex_init(&crew->lock, NULL);
    (void)pthread_cond_init(&crew->is_given, NULL);
    (void)pthread_cond_init(&crew->is_taken, NULL);
    crew->outputs = outputs;
    crew->threads.max = threads - 1u;
    crew->is_pattern = options_pattern(options->outputs[0].name) == 1;
    if (set_view(crew, options) != 0 ||
        make_jobs(crew, threads * BATCHES_EACH + 1u, error) != 0) {
        crew_free(crew);
        return -1;
    }
    *out = crew;
    return 0;
}

void crew_free(struct crew *crew)
{
    if (crew == NULL) {
        return;
    }
    (void)pthread_mutex_lock(&crew->lock);
    crew->stops = true;
    (void)pthread_cond_broadcast(&crew->is_given);
    (void)pthread_mutex_unlock(&crew->lock);
    for (size_t i = 0; i < crew->threads.count; i++) {
        (void)pthread_join(crew->threads.list[i], NULL);
    }
    for (size_t i = 0; i < crew->job_count; i++) {
        batch_free(crew->jobs[i].batch);
    }
    (void)pthread_cond_destroy(&crew->is_taken);
    (void)pthread_cond_destroy(&crew->is_given);
    (void)pthread_mutex_destroy(&crew->lock);
    batch_tools_free(crew->tools);
    free(crew->jobs);
    free(crew);
}
