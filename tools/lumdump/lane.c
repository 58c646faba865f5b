#include "lane.h"

#include "closer.h"
#include "output.h"
#include "targets.h"

#include "../common/file_look.h"
#include "lum/base/time.h"

#include <inttypes.h>
#include <stdlib.h>

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

int lane_start(struct lane *lane, struct worker_ends ends, lum_error *error)
{
    const struct worker_setup setup = {.pass = lane->pass,
                                       .ring = lane->ring,
                                       .ends = ends,
                                       .only_records =
                                           lane->kind == LANE_RECORDING,
                                       .opens = lane->target == LANE_LATE_PIPE};
    lane->moves.at_ns = lum_time_monotonic_ns();
    lane->moves.read_ns = lane->moves.at_ns;
    return worker_start(&setup, &lane->worker, error);
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
    const enum lane_end end = end_of(worker_join(lane->worker, &lane->error));
    lane->worker = NULL;
    if (lane->end == LANE_LIVES) {
        lane->end = end;
    } else if (lane->end == LANE_ABANDONED) {
        lane->end = LANE_STALLED;
    }
}

void lane_stop(struct lane *lane)
{
    if (lane->worker != NULL) {
        worker_drop(lane->worker);
        if (lane->target != LANE_LATE_PIPE) {
            join(lane);
        }
    }
}

bool lane_look(struct lane *lane, int64_t now_ns)
{
    const uint64_t taken = lane->view.taken;
    if (lane->worker == NULL) {
        return false;
    }
    worker_look(lane->worker, lane->dropped, &lane->view);
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

bool lane_take_lost(struct lane *lane, lum_error *out)
{
    return (lane->worker != NULL && worker_take_lost(lane->worker, out)) ||
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
    worker_drop(lane->worker);
}

bool lane_free(struct lane *lane)
{
    if (lane == NULL) {
        return true;
    }
    if (lane->worker != NULL) {
        return false;
    }
    outputs_abort(lane->own.outputs);
    closer_free(lane->closer);
    pass_free(&lane->own);
    ring_free(lane->ring);
    free(lane);
    return true;
}
