#define _POSIX_C_SOURCE 200809L
#include "recorder.h"

#include "../common/capture_file.h"
#include "../common/ring.h"

#include "base/thread.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define RING_BYTES (32u << 20) /* some seconds of data */

struct recorder {
    struct ring *ring;
    lum_endpoint sensor;
    lum_endpoint host;
    uint64_t dropped; /* the giving side's */

    /* the thread's, until it has ended */
    char *path;
    struct provenance about;
    lum_capture_writer *writer; /* NULL: it could not be opened */
    struct losses *losses;
    struct recorder_counts counts;

    pthread_mutex_t lock; /* guards what follows */
    enum recorder_state state;
    lum_error error;
    bool drops;
};

/* --- The thread --- */

static int write_item(struct recorder *r, const struct ring_item *item,
                      lum_error *error)
{
    const lum_received datagram = {.bytes = item->bytes,
                                   .len = item->len,
                                   .utc_ns = item->time_ns,
                                   .cut_short = item->is_cut_short};
    const lum_datagram out = {.time_ns = item->time_ns,
                              .payload = item->bytes,
                              .len = item->len,
                              .source = r->sensor.address,
                              .destination = r->host.address,
                              .source_port = LUM_PORT,
                              .destination_port = r->host.port};
    losses_take(r->losses, r->sensor, &datagram);
    const int64_t gap_ns = item->time_ns - r->counts.last_utc_ns;
    if (r->counts.packets++ == 0) {
        r->counts.first_utc_ns = item->time_ns;
    } else if (gap_ns > r->counts.longest_gap_ns) {
        r->counts.longest_gap_ns = gap_ns;
    }
    r->counts.last_utc_ns = item->time_ns;
    return lum_capture_writer_add(r->writer, &out, error);
}

static void set(struct recorder *r, enum recorder_state state,
                const lum_error *error)
{
    (void)pthread_mutex_lock(&r->lock);
    r->state = state;
    r->error = *error;
    (void)pthread_mutex_unlock(&r->lock);
}

/* Nothing of the recorder is the thread's after this. */
static void finish(struct recorder *r, int result, lum_error *error)
{
    (void)pthread_mutex_lock(&r->lock);
    const bool drops = r->drops;
    (void)pthread_mutex_unlock(&r->lock);
    losses_end(r->losses);
    if (r->writer == NULL) {
        result = -1;
    } else if (result != 0 || drops) {
        lum_capture_writer_abort(r->writer);
    } else {
        result = lum_capture_writer_close(r->writer, error);
    }
    set(r, result != 0 || drops ? RECORDER_FAILED : RECORDER_WHOLE, error);
}

static void *run(void *context)
{
    struct recorder *r = context;
    lum_error error = {""};
    int result = capture_file_open(r->path, &r->about, &r->writer, &error);
    if (result != 0) {
        r->writer = NULL;
        set(r, RECORDER_BREAKS, &error);
    }
    while (ring_take(r->ring)) {
        struct ring_item item;
        while (ring_next(r->ring, &item)) {
            if (result == 0 && write_item(r, &item, &error) != 0) {
                result = -1;
                set(r, RECORDER_BREAKS, &error);
            }
        }
    }
    finish(r, result, &error);
    return NULL;
}

/* --- Its user's side --- */

static void free_all(struct recorder *r)
{
    ring_free(r->ring);
    losses_free(r->losses);
    free(r->path);
    free(r);
}

/* All but the thread. */
static int prepare(struct recorder *r, const struct recorder_options *options,
                   lum_error *error)
{
    r->ring = ring_new(RING_BYTES);
    r->losses = losses_new(options->layout, error);
    r->path = strdup(options->path);
    r->about = *options->about;
    return r->ring != NULL && r->losses != NULL && r->path != NULL
               ? 0
               : lum_error_set(error, "out of memory");
}

struct recorder *recorder_new(const struct recorder_options *options,
                              lum_error *error)
{
    struct recorder *r = calloc(1, sizeof *r);
    pthread_t thread;
    if (r == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    r->sensor = options->sensor;
    r->host = options->host;
    if (prepare(r, options, error) == 0) {
        (void)pthread_mutex_init(&r->lock, NULL);
        if (lum_thread_start(&thread, run, r) == 0) {
            (void)pthread_detach(thread);
            return r;
        }
        (void)lum_error_set(error, "%s: no thread to write it", options->path);
    }
    free_all(r);
    return NULL;
}

void recorder_put(struct recorder *recorder, const lum_received *datagram)
{
    const struct ring_item item = {.bytes = datagram->bytes,
                                   .len = datagram->len,
                                   .time_ns = datagram->utc_ns,
                                   .is_cut_short = datagram->cut_short};
    recorder->dropped += ring_put(recorder->ring, &item) ? 0 : 1u;
}

void recorder_publish(struct recorder *recorder)
{
    ring_publish(recorder->ring);
}

void recorder_close(struct recorder *recorder, bool drop)
{
    (void)pthread_mutex_lock(&recorder->lock);
    recorder->drops = drop;
    (void)pthread_mutex_unlock(&recorder->lock);
    ring_close(recorder->ring);
}

enum recorder_state recorder_look(struct recorder *recorder, lum_error *error)
{
    (void)pthread_mutex_lock(&recorder->lock);
    const enum recorder_state state = recorder->state;
    *error = recorder->error;
    (void)pthread_mutex_unlock(&recorder->lock);
    return state;
}

void recorder_discard(struct recorder *recorder)
{
    lum_error error;
    if (recorder != NULL && recorder_look(recorder, &error) == RECORDER_WHOLE) {
        (void)unlink(recorder->path);
    }
    recorder_free(recorder, NULL);
}

void recorder_free(struct recorder *recorder, struct recorder_counts *counts)
{
    lum_error error;
    if (recorder == NULL || recorder_look(recorder, &error) < RECORDER_WHOLE) {
        return;
    }
    if (counts != NULL) {
        *counts = recorder->counts;
        counts->dropped = recorder->dropped;
        losses_count(recorder->losses, &counts->losses);
    }
    (void)pthread_mutex_destroy(&recorder->lock);
    free_all(recorder);
}
