#include "worker.h"

#include "health.h"

#include "base/thread.h"
#include "lum/base/time.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define VIEW_NS   INT64_C(100000000)
#define PIPES_NS  INT64_C(20000000)  /* at most so often */
#define BUSY_NS   INT64_C(100000000) /* at least so often */
#define FILES_NS  INT64_C(500000000)
#define HEALTH_NS INT64_C(1000000000)

/* Files that are found lost between two looks from outside. */
#define LOST_MAX 4u

/* Datagrams between looks at the clock. */
#define DATAGRAMS_A_LOOK 256u

struct worker {
    struct worker_setup setup;
    struct pass *pass; /* of the setup */
    pthread_t thread;

    /* of the thread, then of the caller that joined it */
    enum pass_result result;
    lum_error error;
    int64_t pipes_ns; /* when they were flushed */
    int64_t files_ns;
    int64_t view_ns;   /* when the view was made */
    int64_t health_ns; /* when outputs were told of it */

    pthread_mutex_t lock; /* guards what follows */
    struct worker_view view;
    uint64_t dropped;
    lum_error lost[LOST_MAX]; /* what became of files, to be told */
    size_t lost_count;
    bool keep;
    bool is_dropped;
};

static void make_view(struct worker *w)
{
    struct worker_view view = {0};
    if (w->setup.only_records) {
        return;
    }
    const lum_demux_counters c = summary_count_packets(&w->pass->summary);
    const lum_framer_counters points = summary_count(&w->pass->summary);
    view.points = points.points;
    view.lost_words = c.assembly.lost_words - points.under_way.words;
    view.lost_lines = c.assembly.lines_skipped + points.lines_in_pauses +
                      c.assembly.lines_missing_angles - points.under_way.lines;
    view.refused = lum_framer_refused(&c, &points);
    view.has_all = w->pass->frames_to_come.are_done;
    (void)pthread_mutex_lock(&w->lock);
    view.taken = w->view.taken;
    w->view = view;
    (void)pthread_mutex_unlock(&w->lock);
}

static bool has_room_for_lost(struct worker *w)
{
    (void)pthread_mutex_lock(&w->lock);
    const bool has_room = w->lost_count < LOST_MAX;
    (void)pthread_mutex_unlock(&w->lock);
    return has_room;
}

/* Whoever removes a file that is written learns of it before the end. */
static void look_for_files(struct worker *w)
{
    lum_error lost;
    while (has_room_for_lost(w) && outputs_find_lost(w->pass->outputs, &lost)) {
        (void)pthread_mutex_lock(&w->lock);
        w->lost[w->lost_count++] = lost;
        (void)pthread_mutex_unlock(&w->lock);
    }
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
    if (outputs_act(w->pass->outputs,
                    &(struct action){.kind = FLUSH, .number = files},
                    &w->error) != 0) {
        return pass_failure();
    }
    if (files) {
        look_for_files(w);
    }
    return PASS_DONE;
}

static enum pass_result look_around(struct worker *w, bool is_idle)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (now_ns - w->view_ns >= VIEW_NS) {
        w->view_ns = now_ns;
        make_view(w);
    }
    if (!w->setup.only_records && now_ns - w->health_ns >= HEALTH_NS) {
        w->health_ns = now_ns;
        (void)pthread_mutex_lock(&w->lock);
        w->pass->dropped = w->dropped;
        (void)pthread_mutex_unlock(&w->lock);
        const enum pass_result result = health_tell(w->pass, &w->error);
        if (result != PASS_DONE) {
            return result;
        }
    }
    return flush(w, now_ns, is_idle);
}

/* In captures the sensor's side always has the port of all sensors, because
 * readers find it by that port, even if a relay uses another one. */
static lum_record record_of(const struct worker *w,
                            const struct ring_item *item)
{
    return (lum_record){.time_ns = item->time_ns,
                        .payload = item->bytes,
                        .len = item->len,
                        .source = w->setup.ends.sensor.address,
                        .destination = w->setup.ends.client.address,
                        .source_port = w->setup.ends.sensor.port,
                        .destination_port = w->setup.ends.client.port,
                        .kind = item->is_cut_short ? LUM_RECORD_CUT_SHORT
                                                   : LUM_RECORD_DATAGRAM};
}

/* Says that one more was taken. */
static enum pass_result count_one(struct worker *w)
{
    (void)pthread_mutex_lock(&w->lock);
    w->view.taken++;
    const bool is_dropped = w->is_dropped;
    (void)pthread_mutex_unlock(&w->lock);
    return is_dropped ? PASS_DROPPED : PASS_DONE;
}

static enum pass_result take_one(struct worker *w, const struct ring_item *item)
{
    const lum_record record = record_of(w, item);
    const enum pass_result result =
        w->setup.only_records ? pass_record(w->pass, &record, &w->error)
                              : pass_take(w->pass, &record, &w->error);
    w->pass->summary.records++;
    return result == PASS_DONE ? count_one(w) : result;
}

static enum pass_result work_off(struct worker *w)
{
    enum pass_result result = PASS_DONE;
    struct ring_item item;
    while (result == PASS_DONE && ring_next(w->setup.ring, &item)) {
        result = take_one(w, &item);
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
    while (result == PASS_DONE && ring_take(w->setup.ring)) {
        result = work_off(w);
        if (result == PASS_DONE) {
            result = look_around(w, true);
        }
    }
    return result;
}

static enum pass_result open_outputs(struct worker *w)
{
    struct pass *p = w->pass;
    if (!w->setup.opens) {
        return PASS_DONE;
    }
    return outputs_open(p->options, NULL, &p->notes, &p->outputs, &w->error) ==
                   0
               ? PASS_DONE
               : PASS_FAILED;
}

/* What has failed has its reason already; the other outputs are finished. */
static enum pass_result close_outputs(struct worker *w)
{
    lum_error others = {""};
    struct outputs *outputs = w->pass->outputs;
    const bool is_fine = w->result == PASS_DONE;
    pass_note_left_out(w->pass);
    w->pass->outputs = NULL;
    if (outputs_close(outputs, is_fine ? &w->error : &others) == 0 ||
        !is_fine) {
        return w->result;
    }
    return pass_failure();
}

static bool is_kept(struct worker *w)
{
    (void)pthread_mutex_lock(&w->lock);
    const bool keep = w->keep;
    const bool is_dropped = w->is_dropped;
    (void)pthread_mutex_unlock(&w->lock);
    return !is_dropped && (keep || w->result != PASS_DONE);
}

static void tell_end(struct worker *w)
{
    (void)pthread_mutex_lock(&w->lock);
    w->view.has_ended = true;
    (void)pthread_mutex_unlock(&w->lock);
}

static void *run(void *argument)
{
    struct worker *w = argument;
    w->result = open_outputs(w);
    if (w->result == PASS_DONE) {
        w->result = work(w);
    }
    if (w->result == PASS_DONE && !w->setup.only_records) {
        w->result = pass_flush(w->pass, &w->error);
        if (w->result == PASS_DONE) {
            w->result = health_tell(w->pass, &w->error);
        }
    }
    make_view(w);
    if (w->pass->outputs != NULL && is_kept(w)) {
        w->result = close_outputs(w);
    }
    outputs_abort(w->pass->outputs);
    w->pass->outputs = NULL;
    tell_end(w);
    return NULL;
}

int worker_start(const struct worker_setup *setup, struct worker **out,
                 lum_error *error)
{
    struct worker *w = calloc(1, sizeof *w);
    if (w == NULL) {
        return lum_error_set(error, "out of memory");
    }
    w->setup = *setup;
    w->pass = setup->pass;
    (void)pthread_mutex_init(&w->lock, NULL);
    const int code = lum_thread_start(&w->thread, run, w);
    if (code != 0) {
        (void)pthread_mutex_destroy(&w->lock);
        free(w);
        return lum_error_set(error, "cannot start the writing thread: %s",
                             strerror(code));
    }
    *out = w;
    return 0;
}

void worker_look(struct worker *worker, uint64_t dropped,
                 struct worker_view *out)
{
    (void)pthread_mutex_lock(&worker->lock);
    worker->dropped = dropped;
    *out = worker->view;
    out->has_ended = out->has_ended && worker->lost_count == 0;
    (void)pthread_mutex_unlock(&worker->lock);
}

bool worker_take_lost(struct worker *worker, lum_error *out)
{
    (void)pthread_mutex_lock(&worker->lock);
    const bool is_there = worker->lost_count > 0;
    if (is_there) {
        *out = worker->lost[0];
        worker->lost_count--;
        memmove(worker->lost, worker->lost + 1,
                worker->lost_count * sizeof worker->lost[0]);
    }
    (void)pthread_mutex_unlock(&worker->lock);
    return is_there;
}

void worker_finish(struct worker *worker, bool keep)
{
    (void)pthread_mutex_lock(&worker->lock);
    worker->keep = keep;
    (void)pthread_mutex_unlock(&worker->lock);
    ring_close(worker->setup.ring);
}

void worker_drop(struct worker *worker)
{
    (void)pthread_mutex_lock(&worker->lock);
    worker->is_dropped = true;
    (void)pthread_mutex_unlock(&worker->lock);
    ring_close(worker->setup.ring);
}

enum pass_result worker_join(struct worker *worker, lum_error *error)
{
    (void)pthread_join(worker->thread, NULL);
    const enum pass_result result = worker->result;
    if (result == PASS_FAILED) {
        *error = worker->error;
    }
    (void)pthread_mutex_destroy(&worker->lock);
    free(worker);
    return result;
}
