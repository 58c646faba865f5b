#define _GNU_SOURCE /* fopencookie */

#include "readahead.h"

#include <stddef.h>

#if defined(__GLIBC__)

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#define BLOCK_BYTES ((size_t)256 * 1024)

/* The kernel copies to a page's start several times as fast as to 16 bytes
 * behind it, where malloc() begins. */
#define BLOCK_ALIGN 4096u

/* Of the stream: fits the first-level cache, since all bytes pass it. */
#define BUFFER_BYTES 16384u

#define BLOCKS 2u

struct block {
    char *bytes;
    ssize_t len; /* 0 at the end, -1 with error set */
    int error;
    bool full; /* the reader's while true, the thread's while false */
};

struct readahead {
    struct block blocks[BLOCKS];
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    pthread_t thread;
    int fd;
    bool stop;
    unsigned current; /* the reader's block */
    size_t at;        /* how much of it was read */
    char buffer[BUFFER_BYTES];
};

static bool wait_until(struct readahead *r, const struct block *block,
                       bool full)
{
    (void)pthread_mutex_lock(&r->mutex);
    while (block->full != full && !r->stop) {
        (void)pthread_cond_wait(&r->changed, &r->mutex);
    }
    const bool go_on = !r->stop;
    (void)pthread_mutex_unlock(&r->mutex);
    return go_on;
}

static void hand_over(struct readahead *r, struct block *block, bool full)
{
    (void)pthread_mutex_lock(&r->mutex);
    block->full = full;
    (void)pthread_cond_signal(&r->changed);
    (void)pthread_mutex_unlock(&r->mutex);
}

static void *read_blocks(void *context)
{
    struct readahead *r = context;
    ssize_t len = 1;
    for (unsigned i = 0; len > 0; i = (i + 1u) % BLOCKS) {
        struct block *block = &r->blocks[i];
        if (!wait_until(r, block, false)) {
            break;
        }
        do {
            len = read(r->fd, block->bytes, BLOCK_BYTES);
        } while (len < 0 && errno == EINTR);
        block->len = len;
        block->error = errno;
        hand_over(r, block, true);
    }
    return NULL;
}

/* The block that holds the next byte. */
static const struct block *next_block(struct readahead *r)
{
    struct block *block = &r->blocks[r->current];
    if (block->full && block->len > 0 && r->at == (size_t)block->len) {
        hand_over(r, block, false);
        r->current = (r->current + 1u) % BLOCKS;
        r->at = 0;
        block = &r->blocks[r->current];
    }
    (void)wait_until(r, block, true);
    return block;
}

static ssize_t cookie_read(void *cookie, char *out, size_t size)
{
    struct readahead *r = cookie;
    const struct block *block = next_block(r);
    if (block->len <= 0) {
        errno = block->error;
        return block->len;
    }
    const size_t left = (size_t)block->len - r->at;
    const size_t n = size < left ? size : left;
    memcpy(out, block->bytes + r->at, n);
    r->at += n;
    return (ssize_t)n;
}

static void release(struct readahead *r)
{
    for (unsigned i = 0; i < BLOCKS; i++) {
        free(r->blocks[i].bytes);
    }
    (void)pthread_cond_destroy(&r->changed);
    (void)pthread_mutex_destroy(&r->mutex);
    free(r);
}

static void stop(struct readahead *r)
{
    (void)pthread_mutex_lock(&r->mutex);
    r->stop = true;
    (void)pthread_cond_signal(&r->changed);
    (void)pthread_mutex_unlock(&r->mutex);
    (void)pthread_join(r->thread, NULL);
    release(r);
}

static int cookie_close(void *cookie)
{
    struct readahead *r = cookie;
    const int fd = r->fd;
    stop(r);
    return close(fd);
}

static bool allocate(struct readahead *r)
{
    for (unsigned i = 0; i < BLOCKS; i++) {
        void *bytes = NULL;
        if (posix_memalign(&bytes, BLOCK_ALIGN, BLOCK_BYTES) != 0) {
            return false;
        }
        r->blocks[i].bytes = bytes;
    }
    return true;
}

/* Signals are for the caller's thread. */
static bool start_thread(struct readahead *r)
{
    sigset_t all;
    sigset_t before;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    const int failed = pthread_create(&r->thread, NULL, read_blocks, r);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return failed == 0;
}

FILE *lum_readahead_open(int fd)
{
    const cookie_io_functions_t functions = {.read = cookie_read,
                                             .close = cookie_close};
    struct readahead *r = calloc(1, sizeof *r);
    if (r == NULL) {
        return NULL;
    }
    r->fd = fd;
    (void)pthread_mutex_init(&r->mutex, NULL);
    (void)pthread_cond_init(&r->changed, NULL);
    if (!allocate(r) || !start_thread(r)) {
        release(r);
        return NULL;
    }
    FILE *file = fopencookie(r, "rb", functions);
    if (file == NULL) {
        stop(r);
        return NULL;
    }
    (void)setvbuf(file, r->buffer, _IOFBF, sizeof r->buffer);
    return file;
}

#else

FILE *lum_readahead_open(int fd)
{
    (void)fd;
    return NULL;
}

#endif
