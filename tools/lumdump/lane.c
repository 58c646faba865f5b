#include "lane.h"

#include "health.h"
#include "output.h"
#include "targets.h"

#include "../common/file_look.h"
#include "base/thread.h"
#include "lum/base/time.h"

#include <stdlib.h>
#include <string.h>

#define VIEW_NS   INT64_C(100000000)
#define PIPES_NS  INT64_C(20000000)  /* at most so often */
#define BUSY_NS   INT64_C(100000000) /* at least so often */
#define FILES_NS  INT64_C(500000000)
#define HEALTH_NS INT64_C(1000000000)

/* Datagrams between looks at the clock. */
#define DATAGRAMS_A_LOOK 256u

/* --- Opening --- */

/* A name that is not there yet will be a file. */
static enum lane_target target_of(const char *name)
{
    struct file_look look;
    if (!file_look(name, &look) || look.kind == FILE_REGULAR ||
        look.kind == FILE_DIRECTORY) {
        return LANE_FILE;
    }
    return file_look_opens_late(name) ? LANE_LATE_PIPE : LANE_STREAM;
}

static int give_ring(struct lane *lane, size_t size, lum_error *error)
{
    lane->ring = ring_new(size);
    return lane->ring != NULL ? 0
                              : lum_error_set(error,
                                              "no memory for a buffer of %zu "
                                              "bytes; try a smaller --buffer",
                                              size);
}

/* Files that may wait for their disk; a waiting cloud holds blocks, a waiting
 * picture all of its memory. */
static size_t closing_room(const struct lane *lane)
{
    if (lane->kind == LANE_RECORDING) {
        return CLOSER_ROOM_MAX;
    }
    return lane->options.outputs[0].format == (unsigned)LUM_FORMAT_PNG ? 1u
                                                                       : 4u;
}

static int open_here(struct lane *lane, lum_error *error)
{
    if (lane->target == LANE_FILE) {
        lane->closer = closer_new(closing_room(lane), error);
        if (lane->closer == NULL) {
            return -1;
        }
    }
    if (outputs_open(&lane->options, NULL, &lane->pass->notes,
                     &lane->pass->outputs, error) != 0) {
        return -1;
    }
    outputs_finish_by(lane->pass->outputs, lane->closer);
    return 0;
}

static int choose_output(struct lane *lane, const struct pass *run,
                         size_t output, lum_error *error)
{
    lane->options = *run->options;
    lane->options.outputs[0] = run->options->outputs[output];
    lane->options.output_count = 1;
    lane->own = (struct pass){.options = &lane->options,
                              .layout = run->layout,
                              .projector = run->projector};
    lane->pass = &lane->own;
    lane->kind =
        options_is_recording(&lane->options, 0) ? LANE_RECORDING : LANE_POINTS;
    lane->target = target_of(lane->options.outputs[0].name);
    return lane->kind == LANE_RECORDING ||
                   pass_prepare(lane->pass, error) == PASS_DONE
               ? 0
               : -1;
}

struct lane *lane_new(struct pass *run, size_t output, size_t ring_size,
                      lum_error *error)
{
    struct lane *lane = calloc(1, sizeof *lane);
    if (lane == NULL) {
        (void)lum_error_set(error, "out of memory");
        return NULL;
    }
    lane->pass = run;
    if ((output != LANE_OF_SUMMARY &&
         choose_output(lane, run, output, error) != 0) ||
        give_ring(lane, ring_size, error) != 0 ||
        (output != LANE_OF_SUMMARY && lane->target != LANE_LATE_PIPE &&
         open_here(lane, error) != 0)) {
        (void)lane_free(lane);
        return NULL;
    }
    return lane;
}

/* --- Its thread --- */

static void make_view(struct lane *l)
{
    struct lane_view view = {0};
    if (l->kind == LANE_RECORDING) {
        return;
    }
    const lum_demux_counters c = summary_count_packets(&l->pass->summary);
    const lum_framer_counters points = summary_count(&l->pass->summary);
    view.points = points.points;
    view.lost_words = c.assembly.lost_words - points.under_way.words;
    view.lost_lines = c.assembly.lines_skipped + points.lines_in_pauses +
                      c.assembly.lines_missing_angles - points.under_way.lines;
    view.refused = lum_framer_refused(&c, &points);
    view.has_all = l->pass->frames_to_come.are_done;
    (void)pthread_mutex_lock(&l->shared.lock);
    view.taken = l->shared.view.taken;
    l->shared.view = view;
    (void)pthread_mutex_unlock(&l->shared.lock);
}

static bool has_room_for_lost(struct lane *l)
{
    (void)pthread_mutex_lock(&l->shared.lock);
    const bool has_room = l->shared.lost_count < LANE_LOST_MAX;
    (void)pthread_mutex_unlock(&l->shared.lock);
    return has_room;
}

/* Whoever removes a file that is written learns of it before the end. */
static void look_for_files(struct lane *l)
{
    lum_error lost;
    while (has_room_for_lost(l) && outputs_find_lost(l->pass->outputs, &lost)) {
        (void)pthread_mutex_lock(&l->shared.lock);
        l->shared.lost[l->shared.lost_count++] = lost;
        (void)pthread_mutex_unlock(&l->shared.lock);
    }
}

static enum pass_result flush(struct lane *l, int64_t now_ns, bool is_idle)
{
    const int64_t since_ns = now_ns - l->work.pipes_ns;
    const bool files = now_ns - l->work.files_ns >= FILES_NS;
    if (l->pass->outputs == NULL ||
        (!files && since_ns < (is_idle ? PIPES_NS : BUSY_NS))) {
        return PASS_DONE;
    }
    l->work.pipes_ns = now_ns;
    l->work.files_ns = files ? now_ns : l->work.files_ns;
    if (outputs_act(l->pass->outputs,
                    &(struct action){.kind = FLUSH, .number = files},
                    &l->work.failure) != 0) {
        return pass_failure();
    }
    if (files) {
        look_for_files(l);
    }
    return PASS_DONE;
}

static enum pass_result look_around(struct lane *l, bool is_idle)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (now_ns - l->work.view_ns >= VIEW_NS) {
        l->work.view_ns = now_ns;
        make_view(l);
    }
    if (l->kind != LANE_RECORDING && now_ns - l->work.health_ns >= HEALTH_NS) {
        l->work.health_ns = now_ns;
        (void)pthread_mutex_lock(&l->shared.lock);
        l->pass->dropped = l->shared.dropped;
        (void)pthread_mutex_unlock(&l->shared.lock);
        const enum pass_result result = health_tell(l->pass, &l->work.failure);
        if (result != PASS_DONE) {
            return result;
        }
    }
    return flush(l, now_ns, is_idle);
}

/* In captures the sensor's side always has the port of all sensors, because
 * readers find it by that port, even if a relay uses another one. */
static lum_record record_of(const struct lane *l, const struct ring_item *item)
{
    return (lum_record){.time_ns = item->time_ns,
                        .payload = item->bytes,
                        .len = item->len,
                        .source = l->ends.sensor.address,
                        .destination = l->ends.client.address,
                        .source_port = l->ends.sensor.port,
                        .destination_port = l->ends.client.port,
                        .kind = item->is_cut_short ? LUM_RECORD_CUT_SHORT
                                                   : LUM_RECORD_DATAGRAM};
}

/* Says that one more was taken. */
static enum pass_result count_one(struct lane *l)
{
    (void)pthread_mutex_lock(&l->shared.lock);
    l->shared.view.taken++;
    const bool is_dropped = l->shared.is_dropped;
    (void)pthread_mutex_unlock(&l->shared.lock);
    return is_dropped ? PASS_DROPPED : PASS_DONE;
}

static enum pass_result take_one(struct lane *l, const struct ring_item *item)
{
    const lum_record record = record_of(l, item);
    const enum pass_result result =
        l->kind == LANE_RECORDING
            ? pass_record(l->pass, &record, &l->work.failure)
            : pass_take(l->pass, &record, &l->work.failure);
    l->pass->summary.records++;
    return result == PASS_DONE ? count_one(l) : result;
}

static enum pass_result work_off(struct lane *l)
{
    enum pass_result result = PASS_DONE;
    struct ring_item item;
    while (result == PASS_DONE && ring_next(l->ring, &item)) {
        result = take_one(l, &item);
        if (result == PASS_DONE &&
            l->pass->summary.records % DATAGRAMS_A_LOOK == 0) {
            result = look_around(l, false);
        }
    }
    return result;
}

static enum pass_result work(struct lane *l)
{
    enum pass_result result = PASS_DONE;
    while (result == PASS_DONE && ring_take(l->ring)) {
        result = work_off(l);
        if (result == PASS_DONE) {
            result = look_around(l, true);
        }
    }
    return result;
}

static enum pass_result open_outputs(struct lane *l)
{
    struct pass *p = l->pass;
    if (l->target != LANE_LATE_PIPE) {
        return PASS_DONE;
    }
    return outputs_open(p->options, NULL, &p->notes, &p->outputs,
                        &l->work.failure) == 0
               ? PASS_DONE
               : PASS_FAILED;
}

/* What has failed has its reason already; the other outputs are finished. */
static enum pass_result close_outputs(struct lane *l)
{
    lum_error others = {""};
    struct outputs *outputs = l->pass->outputs;
    const bool is_fine = l->work.result == PASS_DONE;
    pass_note_left_out(l->pass);
    l->pass->outputs = NULL;
    if (outputs_close(outputs, is_fine ? &l->work.failure : &others) == 0 ||
        !is_fine) {
        return l->work.result;
    }
    return pass_failure();
}

static bool is_kept(struct lane *l)
{
    (void)pthread_mutex_lock(&l->shared.lock);
    const bool keep = l->shared.keep;
    const bool is_dropped = l->shared.is_dropped;
    (void)pthread_mutex_unlock(&l->shared.lock);
    return !is_dropped && (keep || l->work.result != PASS_DONE);
}

static void tell_end(struct lane *l)
{
    (void)pthread_mutex_lock(&l->shared.lock);
    l->shared.view.has_ended = true;
    (void)pthread_mutex_unlock(&l->shared.lock);
}

static void *run(void *argument)
{
    struct lane *l = argument;
    l->work.result = open_outputs(l);
    if (l->work.result == PASS_DONE) {
        l->work.result = work(l);
    }
    if (l->work.result == PASS_DONE && l->kind != LANE_RECORDING) {
        l->work.result = pass_flush(l->pass, &l->work.failure);
        if (l->work.result == PASS_DONE) {
            l->work.result = health_tell(l->pass, &l->work.failure);
        }
    }
    make_view(l);
    if (l->pass->outputs != NULL && is_kept(l)) {
        l->work.result = close_outputs(l);
    }
    outputs_abort(l->pass->outputs);
    l->pass->outputs = NULL;
    tell_end(l);
    return NULL;
}

/* --- The receiving side --- */

int lane_start(struct lane *lane, struct lane_ends ends, lum_error *error)
{
    lane->ends = ends;
    lane->moves.at_ns = lum_time_monotonic_ns();
    lane->moves.read_ns = lane->moves.at_ns;
    (void)pthread_mutex_init(&lane->shared.lock, NULL);
    const int code = lum_thread_start(&lane->thread, run, lane);
    if (code != 0) {
        (void)pthread_mutex_destroy(&lane->shared.lock);
        return lum_error_set(error, "cannot start the writing thread: %s",
                             strerror(code));
    }
    lane->runs = true;
    return 0;
}

void lane_finish(struct lane *lane, bool keep)
{
    (void)pthread_mutex_lock(&lane->shared.lock);
    lane->shared.keep = keep;
    (void)pthread_mutex_unlock(&lane->shared.lock);
    ring_close(lane->ring);
}

/* As soon as its thread moves again it ends. */
static void drop(struct lane *lane)
{
    (void)pthread_mutex_lock(&lane->shared.lock);
    lane->shared.is_dropped = true;
    (void)pthread_mutex_unlock(&lane->shared.lock);
    ring_close(lane->ring);
}

void lane_put(struct lane *lane, const struct ring_item *item)
{
    if (lane->end == LANE_LIVES && !ring_put(lane->ring, item)) {
        lane->dropped++;
    }
}

const char *lane_name(const struct lane *lane)
{
    return output_title(lane->options.outputs[0].name);
}

static enum lane_end end_of(enum pass_result result)
{
    if (result == PASS_DONE) {
        return LANE_WHOLE;
    }
    if (result == PASS_READER_LEFT) {
        return LANE_READER_LEFT;
    }
    return result == PASS_DROPPED ? LANE_STALLED : LANE_FAILED;
}

static void join(struct lane *lane)
{
    (void)pthread_join(lane->thread, NULL);
    (void)pthread_mutex_destroy(&lane->shared.lock);
    const enum lane_end end = end_of(lane->work.result);
    lane->runs = false;
    if (lane->work.result == PASS_FAILED) {
        lane->error = lane->work.failure;
    }
    if (lane->end == LANE_LIVES) {
        lane->end = end;
    } else if (lane->end == LANE_ABANDONED) {
        lane->end = LANE_STALLED;
    }
}

void lane_stop(struct lane *lane)
{
    if (lane->runs) {
        drop(lane);
        if (lane->target != LANE_LATE_PIPE) {
            join(lane);
        }
    }
}

bool lane_look(struct lane *lane, int64_t now_ns)
{
    const uint64_t taken = lane->view.taken;
    if (!lane->runs) {
        return false;
    }
    (void)pthread_mutex_lock(&lane->shared.lock);
    lane->shared.dropped = lane->dropped;
    lane->view = lane->shared.view;
    lane->view.has_ended = lane->view.has_ended && lane->shared.lost_count == 0;
    (void)pthread_mutex_unlock(&lane->shared.lock);
    if (lane->closer != NULL && closer_is_waited_for(lane->closer)) {
        lane->moves.at_ns = now_ns;
    }
    if (ring_level(lane->ring) == 0) {
        lane->moves.read_ns = now_ns;
    }
    if (lane->view.taken != taken) {
        lane->moves = (struct lane_moves){now_ns, lane->dropped, now_ns};
    }
    if (!lane->view.has_ended) {
        return false;
    }
    const bool is_news = lane->end == LANE_LIVES;
    join(lane);
    lane->ended_ns = is_news ? now_ns : lane->ended_ns;
    return is_news;
}

static bool take_lost(struct lane *lane, lum_error *out)
{
    struct lane_shared *s = &lane->shared;
    (void)pthread_mutex_lock(&s->lock);
    const bool is_there = s->lost_count > 0;
    if (is_there) {
        *out = s->lost[0];
        s->lost_count--;
        memmove(s->lost, s->lost + 1, s->lost_count * sizeof s->lost[0]);
    }
    (void)pthread_mutex_unlock(&s->lock);
    return is_there;
}

bool lane_take_lost(struct lane *lane, lum_error *out)
{
    return (lane->runs && take_lost(lane, out)) ||
           (lane->closer != NULL && closer_take_lost(lane->closer, out));
}

bool lane_stands_still(const struct lane *lane, int64_t now_ns, int64_t limit)
{
    return lane->end == LANE_LIVES && lane->dropped > lane->moves.dropped &&
           now_ns - lane->moves.at_ns >= limit;
}

bool lane_is_unread(const struct lane *lane, int64_t now_ns, int64_t limit)
{
    const bool has_reader =
        lane->target != LANE_FILE && options_has_messages(&lane->options, 0);
    return has_reader && lane->end == LANE_LIVES && lane->view.taken > 0 &&
           now_ns - lane->moves.read_ns >= limit;
}

void lane_drop(struct lane *lane, int64_t now_ns)
{
    lane->end = LANE_ABANDONED;
    lane->ended_ns = now_ns;
    drop(lane);
}

bool lane_free(struct lane *lane)
{
    if (lane == NULL) {
        return true;
    }
    if (lane->runs) {
        return false;
    }
    outputs_abort(lane->own.outputs);
    closer_free(lane->closer);
    pass_free(&lane->own);
    ring_free(lane->ring);
    free(lane);
    return true;
}
