#define _POSIX_C_SOURCE 200809L
#include "worker.h"

#include "lum/base/time.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#define VIEW_NS  INT64_C(100000000)
#define PIPES_NS INT64_C(20000000)  /* at most so often */
#define BUSY_NS  INT64_C(100000000) /* at least so often */
#define FILES_NS INT64_C(500000000)

/* Datagrams between looks at the clock. */
#define DATAGRAMS_A_LOOK 256u

struct worker {
    struct pass *pass;
    struct ring *ring;
    struct worker_ends ends;
    lum_cancel *cancel;
    pthread_t thread;

    /* the thread's, then of whoever has joined it */
    enum pass_result result;
    uint64_t left_out;
    lum_error error;
    int64_t pipes_ns; /* when they were flushed */
    int64_t files_ns;
    int64_t view_ns; /* when the view was made */

    pthread_mutex_t lock; /* guards what follows */
    struct worker_view view;
    bool keep;
};

static void make_view(struct worker *w, bool has_ended)
{
    const struct summary *s = &w->pass->summary;
    struct worker_view view = {.has_ended = has_ended,
                               .notes = w->pass->notes.count};
    lum_demux_counters c;
    lum_demux_total(w->pass->demux, &c);
    for (size_t i = 0; i < lum_demux_sensor_count(w->pass->demux); i++) {
        view.points += s->sensors[i].points;
    }
    view.lost_words = c.assembly.lost_words;
    view.lost_lines =
        c.assembly.lines_skipped + c.assembly.lines_missing_angles;
    view.refused = c.assembly.late + c.assembly.conflict + c.assembly.no_room +
                   c.assembly.stray + c.packets[LUM_PACKET_MALFORMED] +
                   c.packets[LUM_PACKET_UNKNOWN_TAG] +
                   c.packets[LUM_PACKET_UNKNOWN_TYPE] +
                   c.packets[LUM_PACKET_FOREIGN];
    (void)pthread_mutex_lock(&w->lock);
    w->view = view;
    (void)pthread_mutex_unlock(&w->lock);
}

static enum pass_result flush(struct worker *w, int64_t now_ns, bool is_idle)
{
    const int64_t since_ns = now_ns - w->pipes_ns;
    const bool files = now_ns - w->files_ns >= FILES_NS;
    if (w->pass->outputs == NULL ||
        (!files && since_ns < (is_idle ? PIPES_NS : BUSY_NS))) {
        return PASS_DONE;
    }
    w->pipes_ns = now_ns;
    w->files_ns = files ? now_ns : w->files_ns;
    if (outputs_flush(w->pass->outputs, files, &w->error) != 0) {
        return errno == EPIPE ? PASS_READER_LEFT : PASS_FAILED;
    }
    return PASS_DONE;
}

static enum pass_result look_around(struct worker *w, bool is_idle)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (now_ns - w->view_ns >= VIEW_NS) {
        w->view_ns = now_ns;
        make_view(w, false);
    }
    return flush(w, now_ns, is_idle);
}

/* The sensor's side is always shown as the port that all sensors have, by which
 * captures tell it, whatever port a relay offers it at. */
static lum_record record_of(const struct worker *w,
                            const struct ring_item *item)
{
    return (lum_record){.time_ns = item->time_ns,
                        .payload = item->bytes,
                        .len = item->len,
                        .source = w->ends.sensor.address,
                        .destination = w->ends.client.address,
                        .source_port = w->ends.sensor.port,
                        .destination_port = w->ends.client.port,
                        .kind = item->is_cut_short ? LUM_RECORD_CUT_SHORT
                                                   : LUM_RECORD_DATAGRAM};
}

static enum pass_result work_off(struct worker *w)
{
    enum pass_result result = PASS_DONE;
    struct ring_item item;
    while (result == PASS_DONE && ring_next(w->ring, &item)) {
        const lum_record record = record_of(w, &item);
        result = pass_take(w->pass, &record, &w->error);
        w->pass->summary.records++;
        if (result == PASS_DONE &&
            w->pass->summary.records % DATAGRAMS_A_LOOK == 0) {
            result = look_around(w, false);
        }
    }
    return result;
}

static enum pass_result work(struct worker *w)
{
    enum pass_result result = PASS_DONE;
    while (result == PASS_DONE && ring_take(w->ring)) {
        result = work_off(w);
        if (result == PASS_DONE) {
            result = look_around(w, true);
        }
    }
    return result;
}

/* What has failed has its reason already; the other outputs are finished. */
static enum pass_result close_outputs(struct worker *w)
{
    lum_error others = {""};
    struct outputs *outputs = w->pass->outputs;
    const bool is_fine = w->result == PASS_DONE;
    w->pass->outputs = NULL;
    w->left_out = outputs_left_out(outputs);
    if (outputs_close(outputs, is_fine ? &w->error : &others) == 0 ||
        !is_fine) {
        return w->result;
    }
    return errno == EPIPE ? PASS_READER_LEFT : PASS_FAILED;
}

static bool is_kept(struct worker *w)
{
    (void)pthread_mutex_lock(&w->lock);
    const bool keep = w->keep;
    (void)pthread_mutex_unlock(&w->lock);
    return keep || w->result != PASS_DONE;
}

static void *run(void *argument)
{
    struct worker *w = argument;
    w->result = work(w);
    if (w->result == PASS_DONE) {
        w->result = pass_flush(w->pass, &w->error);
    }
    make_view(w, true);
    if (w->result != PASS_DONE) {
        lum_cancel_raise(w->cancel);
    }
    if (w->pass->outputs != NULL && is_kept(w)) {
        w->result = close_outputs(w);
    }
    outputs_abort(w->pass->outputs);
    w->pass->outputs = NULL;
    return NULL;
}

/* Signals are the session's thread's, so that no write is broken off by one. */
static int start_thread(struct worker *w)
{
    sigset_t all;
    sigset_t mine;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &mine);
    const int code = pthread_create(&w->thread, NULL, run, w);
    (void)pthread_sigmask(SIG_SETMASK, &mine, NULL);
    return code;
}

int worker_start(struct pass *pass, struct ring *ring, struct worker_ends ends,
                 lum_cancel *cancel, struct worker **out, lum_error *error)
{
    struct worker *w = calloc(1, sizeof *w);
    if (w == NULL) {
        return lum_error_set(error, "out of memory");
    }
    w->pass = pass;
    w->ring = ring;
    w->ends = ends;
    w->cancel = cancel;
    (void)pthread_mutex_init(&w->lock, NULL);
    const int code = start_thread(w);
    if (code != 0) {
        (void)pthread_mutex_destroy(&w->lock);
        free(w);
        return lum_error_set(error, "cannot start the writing thread: %s",
                             strerror(code));
    }
    *out = w;
    return 0;
}

void worker_look(struct worker *worker, struct worker_view *out)
{
    (void)pthread_mutex_lock(&worker->lock);
    *out = worker->view;
    (void)pthread_mutex_unlock(&worker->lock);
}

const char *worker_note(const struct worker *worker, size_t i)
{
    return worker->pass->notes.list[i].text;
}

enum pass_result worker_end(struct worker *worker, bool keep,
                            uint64_t *left_out, lum_error *error)
{
    (void)pthread_mutex_lock(&worker->lock);
    worker->keep = keep;
    (void)pthread_mutex_unlock(&worker->lock);
    ring_close(worker->ring);
    (void)pthread_join(worker->thread, NULL);
    const enum pass_result result = worker->result;
    *left_out = worker->left_out;
    if (result == PASS_FAILED) {
        *error = worker->error;
    }
    (void)pthread_mutex_destroy(&worker->lock);
    free(worker);
    return result;
}
