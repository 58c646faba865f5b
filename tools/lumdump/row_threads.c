#include "row_threads.h"

#include "base/grow.h"
#include "base/thread_pool.h"
#include "cloud/part.h"
#include "lum/smooth.h"
#include "points/columns.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* Batches for each thread: one in work, and one that waits. */
#define BATCHES_EACH 2u

#define LINES_MAX 16u

/* Rows of a batch that is full: they fit the second cache of a core. */
#define ROWS_BYTES  (UINT64_C(3) << 18)
#define WORDS_FIRST 8192u /* until it is known how many words make these */
#define WORDS_MAX   65536u

/* How lines become points; only read. */
struct batch_view {
    lum_selection selection;
    unsigned leaves; /* what nobody reads: options_leaves() */
    bool smooths;
    lum_smooth smooth;
};

/* A line without room of its own for what is long. */
struct batch_line {
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    size_t at;        /* of its words, or of its samples */
    bool has_samples; /* these are known, */
    size_t count;     /* so many */
    int64_t timestamp_us;
    const void *const *extra; /* as of its samples */
    const lum_projector *projector;
};

/* Some lines of one pass, and their rows in a cloud: what one thread hands to
 * another. Lines are copied, since those of a framer live until its next
 * call. */
struct batch {
    struct batch_line lines[LINES_MAX];
    size_t count;
    uint32_t *words; /* of all lines */
    size_t word_count;
    size_t word_room;
    lum_sample *samples; /* likewise */
    size_t sample_count;
    size_t sample_room;
    size_t full; /* words, or samples, with which it is full */
    lum_writer *part;
    bool has_failed;
    int failure_code;
    lum_error failure;
};

/* What batch_make() works with, one for each thread. */
struct batch_tools {
    lum_sample_workspace work;
    lum_angle angles[LUM_LINE_PIXELS];
    lum_return returns[LUM_LINE_WORDS_MAX];
    lum_sample samples[LUM_LINE_WORDS_MAX];
};

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

/* --- The batch --- */

/* part: makes the rows; the batch's from now on, also without memory. */
static struct batch *batch_new(lum_writer *part)
{
    struct batch *batch = calloc(1, sizeof *batch);
    if (batch == NULL) {
        lum_writer_abort(part);
        return NULL;
    }
    batch->part = part;
    batch->full = WORDS_FIRST;
    return batch;
}

static void batch_free(struct batch *batch)
{
    if (batch == NULL) {
        return;
    }
    lum_writer_abort(batch->part);
    free(batch->words);
    free(batch->samples);
    free(batch);
}

static bool batch_is_empty(const struct batch *batch)
{
    return batch->count == 0;
}

static bool batch_is_full(const struct batch *batch)
{
    return batch->count == LINES_MAX ||
           batch->word_count + batch->sample_count >= batch->full;
}

static int64_t batch_frame(const struct batch *batch)
{
    return batch->lines[0].line.frame;
}

static void batch_clear(struct batch *batch)
{
    batch->count = 0;
    batch->word_count = 0;
    batch->sample_count = 0;
    batch->has_failed = false;
    lum_writer_clear_part(batch->part);
}

/* --- Lines --- */

/* A line whose points are not known. projector: makes them; about: its
 * timestamp and its extra columns. Kept: the projector, and what extra points
 * to. */
static int batch_add_line(struct batch *batch, const lum_line *line,
                          const lum_projector *projector,
                          const lum_line_samples *about)
{
    struct batch_line *to = &batch->lines[batch->count];
    const size_t n = line->word_count;
    uint32_t *words = lum_grown(batch->words, batch->word_count, n,
                                sizeof *words, &batch->word_room);
    if (words == NULL) {
        return -1;
    }
    batch->words = words;
    memcpy(words + batch->word_count, line->words, n * sizeof *words);
    memcpy(to->angles, line->angles, sizeof to->angles);
    memcpy(to->marks, line->angle_marks, sizeof to->marks);
    to->line = *line;
    to->at = batch->word_count;
    to->has_samples = false;
    to->timestamp_us = about->timestamp_us;
    to->extra = about->extra;
    to->projector = projector;
    batch->word_count += n;
    batch->count++;
    return 0;
}

static int batch_add_samples(struct batch *batch, const lum_line_samples *line)
{
    struct batch_line *to = &batch->lines[batch->count];
    lum_sample *samples =
        lum_grown(batch->samples, batch->sample_count, line->count,
                  sizeof *samples, &batch->sample_room);
    if (samples == NULL) {
        return -1;
    }
    batch->samples = samples;
    memcpy(samples + batch->sample_count, line->samples,
           line->count * sizeof *samples);
    to->line = (lum_line){
        .frame = line->frame, .number = line->line, .eye = line->eye};
    to->at = batch->sample_count;
    to->has_samples = true;
    to->count = line->count;
    to->timestamp_us = line->timestamp_us;
    to->extra = line->extra;
    batch->sample_count += line->count;
    batch->count++;
    return 0;
}

/* --- Rows --- */

static struct batch_tools *batch_tools_new(void)
{
    struct batch_tools *tools = malloc(sizeof *tools);
    if (tools != NULL) {
        tools->work.returns = tools->returns;
    }
    return tools;
}

static void batch_tools_free(struct batch_tools *tools)
{
    free(tools);
}

/* The points of a line. Returns how many there are. */
static size_t project(const struct batch *batch, const struct batch_line *from,
                      const struct batch_view *view, struct batch_tools *tools)
{
    lum_line line = from->line;
    line.angles = from->angles;
    line.angle_marks = from->marks;
    line.words = batch->words + from->at;
    if (view->smooths) {
        lum_smooth_line(&view->smooth, &line, tools->angles);
        line.angles = tools->angles;
    }
    return lum_samples_make(from->projector, &line, &view->selection,
                            view->leaves, &tools->work, tools->samples);
}

static int make_line(struct batch *batch, const struct batch_line *from,
                     const struct batch_view *view, struct batch_tools *tools)
{
    lum_line_samples line = {.struct_size = sizeof line,
                             .frame = from->line.frame,
                             .timestamp_us = from->timestamp_us,
                             .line = from->line.number,
                             .eye = from->line.eye,
                             .extra = from->extra};
    if (from->has_samples) {
        line.samples = batch->samples + from->at;
        line.count = from->count;
    } else {
        line.samples = tools->samples;
        line.count = project(batch, from, view, tools);
    }
    return lum_writer_add(batch->part, &line, &batch->failure);
}

/* As many words as the rows are to have bytes, if the next are alike. */
static void find_full(struct batch *batch)
{
    const uint64_t words = batch->word_count + batch->sample_count;
    const uint64_t bytes = lum_writer_bytes(batch->part);
    const uint64_t full = bytes > 0 ? words * ROWS_BYTES / bytes : WORDS_MAX;
    batch->full = (size_t)(full < WORDS_MAX ? full : WORDS_MAX);
}

/* A failure waits for batch_rows(). */
static void batch_make(struct batch *batch, const struct batch_view *view,
                       struct batch_tools *tools)
{
    for (size_t i = 0; i < batch->count && !batch->has_failed; i++) {
        if (make_line(batch, &batch->lines[i], view, tools) != 0) {
            batch->has_failed = true;
            batch->failure_code = errno;
        }
    }
    find_full(batch);
}

static lum_writer *batch_rows(struct batch *batch, lum_error *error)
{
    if (!batch->has_failed) {
        return batch->part;
    }
    *error = batch->failure;
    errno = batch->failure_code;
    return NULL;
}

/* --- Jobs --- */

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
