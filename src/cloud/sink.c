#define _POSIX_C_SOURCE 200809L
#include "sink.h"

#include "base/outfile_io.h"
#include "base/thread.h"
#include "lum/base/time.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define BLOCKS       3u
#define BLOCK_PAGE   4096u
#define MOVE_MIN     ((size_t)1 << 18) /* bytes; fewer are copied */
#define LEND_MIN     ((size_t)8 << 20) /* likewise */
#define PATIENCE_MS  50 /* how often a waiting thread looks around */
#define BREAK_OFF_NS INT64_C(2000000)

typedef struct block {
    char *memory; /* to be freed */
    char *bytes;  /* within, where a page begins; or what the caller lent */
    size_t used;
    size_t room; /* bytes that it holds; 0: it has no memory of its own */
} block;

struct lum_sink {
    lum_outfile file;
    block blocks[BLOCKS];
    unsigned filling; /* the caller's block */
    uint64_t bytes;   /* appended so far */
    bool has_lent;    /* the caller, since lum_sink_settle() */
    bool is_memory;   /* there is no file, and one block that grows */
    bool owes_name;   /* the thread gives it, behind the first block */
    pthread_t thread;
    bool threaded;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t changed;
    unsigned writing; /* the oldest block that is queued */
    unsigned queued;  /* blocks not written yet */
    bool stop;        /* the thread shall end once the queue is empty */
    bool cancelled;   /* and what is queued need not be written */
    bool has_ended;   /* the thread writes no more */
    int failure;      /* errno of the first write that failed; sticky */
    lum_error naming; /* why the file got no name; "": that did not fail */
    bool is_watched;  /* somebody asks what became of the file */
    lum_error lost;   /* as the thread last saw it; "": nothing */
};

/* --- Writing to the file --- */

static int fail(const lum_sink *sink, int code, const char *doing,
                lum_error *error)
{
    return lum_outfile_fail(&sink->file, code, doing, error);
}

static int fail_write(const lum_sink *sink, int failure, lum_error *error)
{
    if (sink->naming.text[0] == '\0') {
        return fail(sink, failure, "cannot write", error);
    }
    errno = failure;
    return lum_error_set(error, "%s", sink->naming.text);
}

/* One of the sink's flags. */
static bool is_set(lum_sink *sink, const bool *flag)
{
    (void)pthread_mutex_lock(&sink->lock);
    const bool value = *flag;
    (void)pthread_mutex_unlock(&sink->lock);
    return value;
}

/* Wait for a reader who takes his time, but not after lum_sink_abort(). */
static int wait_writable(lum_sink *sink)
{
    int answer = 0;
    while (answer == 0) {
        if (is_set(sink, &sink->cancelled)) {
            return ECANCELED;
        }
        answer = lum_outfile_wait(&sink->file, PATIENCE_MS);
    }
    return answer > 0 ? 0 : errno;
}

static int write_all(lum_sink *sink, const char *bytes, size_t n)
{
    int failure = 0;
    while (n > 0 && failure == 0) {
        const size_t most = n < LUM_SINK_BLOCK_BYTES ? n : LUM_SINK_BLOCK_BYTES;
        size_t written = 0;
        failure = sink->file.may_block ? wait_writable(sink) : 0;
        if (failure == 0) {
            failure = lum_outfile_put(&sink->file, bytes, most, &written);
        }
        if (written > 0) {
            lum_outfile_wrote(&sink->file, written);
        }
        bytes += written;
        n -= written;
    }
    return failure;
}

static int give_name(lum_sink *sink)
{
    if (!sink->owes_name) {
        return 0;
    }
    sink->owes_name = false;
    return lum_outfile_show(&sink->file, &sink->naming) == 0 ? 0 : errno;
}

static int wait_for_disk(const lum_sink *sink)
{
    const int copy = lum_outfile_copy(&sink->file);
    return copy >= 0 ? lum_outfile_sync_copy(copy) : 0;
}

/* A file that has its name has a beginning, too, also if the power fails. An
 * older one that cannot be replaced is emptied first. */
static int put_block(lum_sink *sink, const block *from)
{
    int failure = sink->file.is_older ? give_name(sink) : 0;
    if (failure == 0) {
        failure = write_all(sink, from->bytes, from->used);
    }
    if (failure == 0 && sink->owes_name) {
        failure = wait_for_disk(sink);
    }
    return failure == 0 ? give_name(sink) : failure;
}

/* Write the oldest block; lock is held before and after. A caller who keeps
 * this thread busy cannot look at the file himself. */
static void write_oldest(lum_sink *sink)
{
    const block *oldest = &sink->blocks[sink->writing];
    const bool looks = sink->is_watched;
    lum_error lost = {""};
    int failure = sink->cancelled ? ECANCELED : sink->failure;
    (void)pthread_mutex_unlock(&sink->lock);
    if (failure == 0) {
        failure = put_block(sink, oldest);
    }
    if (failure == 0 && looks) {
        (void)!lum_outfile_check(&sink->file, &lost);
    }
    (void)pthread_mutex_lock(&sink->lock);
    sink->failure = failure;
    sink->lost = lost;
    sink->writing = (sink->writing + 1u) % BLOCKS;
    sink->queued--;
    (void)pthread_cond_broadcast(&sink->changed);
}

/* --- The thread and its queue --- */

static void *run(void *argument)
{
    lum_sink *sink = argument;
    (void)pthread_mutex_lock(&sink->lock);
    while (sink->queued > 0 || !sink->stop) {
        if (sink->queued > 0) {
            write_oldest(sink);
        } else {
            (void)pthread_cond_wait(&sink->changed, &sink->lock);
        }
    }
    sink->has_ended = true;
    (void)pthread_mutex_unlock(&sink->lock);
    return NULL;
}

/* Files smaller than a block are common, so the thread comes with the first
 * block that is full. */
static int start_thread(lum_sink *sink, lum_error *error)
{
    if (sink->threaded) {
        return 0;
    }
    const int code = lum_thread_start(&sink->thread, run, sink);
    if (code != 0) {
        return fail(sink, code, "cannot start the writing thread", error);
    }
    sink->threaded = true;
    return 0;
}

static void stop_thread(lum_sink *sink, bool cancel)
{
    if (!sink->threaded) {
        return;
    }
    (void)pthread_mutex_lock(&sink->lock);
    sink->stop = true;
    sink->cancelled = cancel;
    (void)pthread_cond_broadcast(&sink->changed);
    (void)pthread_mutex_unlock(&sink->lock);
    while (cancel && !is_set(sink, &sink->has_ended) &&
           lum_thread_break_off(sink->thread)) {
        lum_time_sleep_until(lum_time_monotonic_ns() + BREAK_OFF_NS);
    }
    (void)pthread_join(sink->thread, NULL);
    sink->threaded = false;
}

/* Wait until at most n blocks are queued. */
static int wait_queued(lum_sink *sink, unsigned n, lum_error *error)
{
    (void)pthread_mutex_lock(&sink->lock);
    while (sink->queued > n) {
        (void)pthread_cond_wait(&sink->changed, &sink->lock);
    }
    const int failure = sink->failure;
    (void)pthread_mutex_unlock(&sink->lock);
    return failure == 0 ? 0 : fail_write(sink, failure, error);
}

/* Hand the block being filled to the thread and take the next. */
static int submit(lum_sink *sink, lum_error *error)
{
    if (start_thread(sink, error) != 0) {
        return -1;
    }
    (void)pthread_mutex_lock(&sink->lock);
    sink->queued++;
    (void)pthread_cond_broadcast(&sink->changed);
    (void)pthread_mutex_unlock(&sink->lock);
    sink->filling = (sink->filling + 1u) % BLOCKS;
    const int result = wait_queued(sink, BLOCKS - 1u, error);
    sink->blocks[sink->filling].used = 0;
    return result;
}

static int drain(lum_sink *sink, lum_error *error)
{
    if (sink->blocks[sink->filling].used > 0 && submit(sink, error) != 0) {
        return -1;
    }
    return wait_queued(sink, 0, error);
}

/* --- Blocks of the caller --- */

static int allocate(lum_sink *sink, size_t room, block *out, lum_error *error)
{
    char *memory = malloc(room + BLOCK_PAGE);
    if (memory == NULL) {
        return fail(sink, ENOMEM, "no memory for a block", error);
    }
    *out =
        (block){.memory = memory,
                .bytes = memory + BLOCK_PAGE - (uintptr_t)memory % BLOCK_PAGE,
                .room = room};
    return 0;
}

/* Of a sink in memory. */
static int grow(lum_sink *sink, block *full, size_t n, lum_error *error)
{
    block larger;
    if (allocate(sink, 2u * full->room + n, &larger, error) != 0) {
        return -1;
    }
    memcpy(larger.bytes, full->bytes, full->used);
    larger.used = full->used;
    free(full->memory);
    *full = larger;
    return 0;
}

/* Have room for n bytes more in the block being filled, or take the next. */
static block *make_room(lum_sink *sink, size_t n, lum_error *error)
{
    block *filled = &sink->blocks[sink->filling];
    if (filled->room != 0 && filled->room - filled->used < n &&
        (sink->is_memory ? grow(sink, filled, n, error)
                         : submit(sink, error)) != 0) {
        return NULL;
    }
    filled = &sink->blocks[sink->filling];
    return filled->room != 0 ||
                   allocate(sink, LUM_SINK_BLOCK_BYTES, filled, error) == 0
               ? filled
               : NULL;
}

char *lum_sink_reserve(lum_sink *sink, size_t n, lum_error *error)
{
    const block *filled = make_room(sink, n, error);
    return filled != NULL ? filled->bytes + filled->used : NULL;
}

void lum_sink_commit(lum_sink *sink, size_t n)
{
    sink->blocks[sink->filling].used += n;
    sink->bytes += n;
}

uint64_t lum_sink_bytes(const lum_sink *sink)
{
    return sink->bytes;
}

int lum_sink_flush(lum_sink *sink, lum_error *error)
{
    (void)pthread_mutex_lock(&sink->lock);
    const bool is_busy = sink->queued > 0;
    const int failure = sink->failure;
    (void)pthread_mutex_unlock(&sink->lock);
    if (failure != 0) {
        return fail_write(sink, failure, error);
    }
    if (sink->file.may_block && lum_outfile_is_unread(&sink->file)) {
        return fail(sink, EPIPE, "cannot write", error);
    }
    return is_busy || sink->blocks[sink->filling].used == 0
               ? 0
               : submit(sink, error);
}

int lum_sink_check(lum_sink *sink, lum_error *error)
{
    (void)pthread_mutex_lock(&sink->lock);
    const bool is_busy = sink->queued > 0;
    const lum_error lost = sink->lost;
    sink->is_watched = true;
    (void)pthread_mutex_unlock(&sink->lock);
    if (!is_busy) {
        return lum_outfile_check(&sink->file, error);
    }
    if (lost.text[0] == '\0') {
        return 0;
    }
    errno = ENOENT;
    return lum_error_set(error, "%s", lost.text);
}

int lum_sink_write(lum_sink *sink, const void *bytes, size_t n,
                   lum_error *error)
{
    const char *from = bytes;
    while (n > 0) {
        const size_t now = n < BLOCK_PAGE ? n : BLOCK_PAGE;
        char *to = lum_sink_reserve(sink, now, error);
        if (to == NULL) {
            return -1;
        }
        memcpy(to, from, now);
        lum_sink_commit(sink, now);
        from += now;
        n -= now;
    }
    return 0;
}

/* A block without memory of its own stands for them in the queue. */
int lum_sink_lend(lum_sink *sink, void *bytes, size_t n, lum_error *error)
{
    if (n < LEND_MIN || sink->is_memory) {
        return lum_sink_write(sink, bytes, n, error);
    }
    if (sink->blocks[sink->filling].used > 0 && submit(sink, error) != 0) {
        return -1;
    }
    block *lent = &sink->blocks[sink->filling];
    free(lent->memory);
    *lent = (block){.bytes = bytes, .used = n};
    sink->has_lent = true;
    sink->bytes += n;
    return submit(sink, error);
}

int lum_sink_settle(lum_sink *sink, lum_error *error)
{
    const bool has_lent = sink->has_lent;
    sink->has_lent = false;
    return has_lent ? wait_queued(sink, 0, error) : 0;
}

/* The thread writes a part's block, and the part gets an empty one. None holds
 * less than LUM_SINK_BLOCK_BYTES. */
static int hand_over(lum_sink *sink, block *moved, lum_error *error)
{
    block *filled = &sink->blocks[sink->filling];
    if (filled->used > 0 && submit(sink, error) != 0) {
        return -1;
    }
    filled = &sink->blocks[sink->filling];
    const block empty = *filled;
    *filled = *moved;
    *moved = empty;
    return 0;
}

/* What is in memory is written by this thread, which has it in its cache. */
static int put_now(lum_sink *sink, block *full, lum_error *error)
{
    const int failure = full->used > 0 ? put_block(sink, full) : 0;
    full->used = 0;
    if (failure == 0) {
        return 0;
    }
    (void)pthread_mutex_lock(&sink->lock);
    sink->failure = failure;
    (void)pthread_mutex_unlock(&sink->lock);
    return fail_write(sink, failure, error);
}

int lum_sink_move(lum_sink *sink, lum_sink *from, lum_error *error)
{
    block *moved = &from->blocks[from->filling];
    size_t n = moved->used; /* not counted yet */
    int result = 0;
    if (n < MOVE_MIN) {
        result = lum_sink_write(sink, moved->bytes, n, error);
        n = 0;
    } else if (sink->file.may_block) {
        result = hand_over(sink, moved, error);
    } else if (wait_queued(sink, 0, error) != 0 ||
               put_now(sink, &sink->blocks[sink->filling], error) != 0 ||
               put_now(sink, moved, error) != 0) {
        result = -1;
    }
    sink->bytes += result == 0 ? n : 0;
    lum_sink_clear(from);
    return result;
}

void lum_sink_clear(lum_sink *sink)
{
    sink->blocks[sink->filling].used = 0;
    sink->bytes = 0;
}

/* --- Header, name, end --- */

int lum_sink_patch(lum_sink *sink, uint64_t offset, const void *bytes, size_t n,
                   lum_error *error)
{
    if (drain(sink, error) != 0) {
        return -1;
    }
    const int code = lum_outfile_put_at(&sink->file, offset, bytes, n);
    return code == 0 ? 0 : fail(sink, code, "cannot write the header", error);
}

bool lum_sink_seekable(const lum_sink *sink)
{
    return sink->file.seekable;
}

const char *lum_sink_name(const lum_sink *sink)
{
    return sink->file.name;
}

/* errno stays. */
static void destroy(lum_sink *sink)
{
    const int code = errno;
    for (unsigned i = 0; i < BLOCKS; i++) {
        free(sink->blocks[i].memory);
    }
    (void)pthread_cond_destroy(&sink->changed);
    (void)pthread_mutex_destroy(&sink->lock);
    lum_outfile_discard(&sink->file);
    free(sink);
    errno = code;
}

int lum_sink_no_memory(const char *path, lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "%s: no memory to open it", path);
}

static lum_sink *new_sink(const char *path, lum_error *error)
{
    lum_sink *sink = calloc(1, sizeof *sink);
    if (sink == NULL) {
        (void)lum_sink_no_memory(path, error);
        return NULL;
    }
    (void)pthread_mutex_init(&sink->lock, NULL);
    (void)pthread_cond_init(&sink->changed, NULL);
    sink->file.fd = -1;
    sink->file.claim = LUM_CLAIM_NONE;
    return sink;
}

static int open_as(const char *path, lum_outfile_kind kind, lum_sink **out,
                   lum_error *error)
{
    lum_sink *sink = new_sink(path, error);
    if (sink == NULL) {
        return -1;
    }
    if (lum_outfile_open(path, kind, &sink->file, error) != 0) {
        destroy(sink);
        return -1;
    }
    lum_outfile_never_wait(&sink->file);
    sink->owes_name = kind == LUM_OUTFILE_GROWS;
    *out = sink;
    return 0;
}

int lum_sink_open(const char *path, lum_sink **out, lum_error *error)
{
    return open_as(path, LUM_OUTFILE_WHOLE, out, error);
}

int lum_sink_open_growing(const char *path, lum_sink **out, lum_error *error)
{
    return open_as(path, LUM_OUTFILE_GROWS, out, error);
}

int lum_sink_open_memory(const char *path, lum_sink **out, lum_error *error)
{
    lum_sink *sink = new_sink(path, error);
    if (sink == NULL) {
        return -1;
    }
    sink->is_memory = true;
    sink->file.name = strdup(path);
    if (sink->file.name == NULL) {
        destroy(sink);
        return lum_sink_no_memory(path, error);
    }
    *out = sink;
    return 0;
}

void lum_sink_abort(lum_sink *sink)
{
    if (sink != NULL) {
        const int code = errno;
        stop_thread(sink, true);
        errno = code;
        destroy(sink);
    }
}

int lum_sink_close(lum_sink *sink, lum_error *error)
{
    if (drain(sink, error) != 0 ||
        lum_outfile_finish(&sink->file, error) != 0) {
        lum_sink_abort(sink);
        return -1;
    }
    stop_thread(sink, false);
    destroy(sink);
    return 0;
}
