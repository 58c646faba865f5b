#define _POSIX_C_SOURCE 200809L
#include "../common/capture_file.h"
#include "../common/interrupt.h"
#include "../common/terminal.h"
#include "files.h"
#include "labels.h"
#include "layout.h"
#include "lum/wire.h"
#include "sim/fault.h"
#include "sim/packets.h"
#include "sim/render.h"
#include "standing.h"
#include "truth.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A system is woken up to so much too late. */
#define WAKING_NS 9973

/* The recording begins on the first of January 2026, UTC. */
#define EPOCH_NS (INT64_C(1767225600) * 1000000000)

/* What a receiving Linux joins at most. */
#define JOINED_MAX       64u
#define JOINED_BYTES_MAX 65507u

/* Datagrams of one length on their way into the capture as one. */
struct joined {
    lum_datagram whole; /* its payload is in bytes */
    size_t each;        /* length of the first */
    size_t count;
    uint8_t bytes[JOINED_BYTES_MAX];
};

/* Too large for a stack. */
struct run {
    const struct options *options;
    lum_render render;
    lum_sim_line line;
    lum_packet_batch batches[LUM_EYES];
    lum_fault fault;
    struct joined joined;
    lum_capture_writer *output;
    struct truth *truth;          /* NULL: not requested */
    lum_outfile true_calibration; /* likewise; a fd of -1 */
    lum_sink *poses;              /* likewise */
    struct labels *labels;        /* likewise */
    lum_error error;
    int64_t frames;
    uint64_t packets;
    uint64_t points;
    bool progress; /* shown */
};

/* --- Times --- */

/* The capture's clock after the sensor's clock has advanced by this much. */
static int64_t utc_of(const struct options *o, int64_t sensor_ns)
{
    return EPOCH_NS + sensor_ns +
           (int64_t)((double)sensor_ns * o->capture.drift_ppm * 1e-6);
}

/* A system that looks at its packets now and then stamps all at once; nobody is
 * woken to the microsecond. */
static int64_t stamp_of(const struct options *o, int64_t sensor_ns)
{
    const int64_t batch_ns = (int64_t)(o->capture.batch_ms * 1e6);
    const int64_t utc_ns = utc_of(o, sensor_ns);
    if (batch_ns <= 0) {
        return utc_ns;
    }
    const int64_t batch = (utc_ns + batch_ns - 1) / batch_ns;
    return batch * batch_ns + batch * 7919 % WAKING_NS % batch_ns;
}

/* --- Into the capture --- */

static int write_joined(struct run *run)
{
    struct joined *j = &run->joined;
    const size_t count = j->count;
    j->count = 0;
    return count != 0
               ? lum_capture_writer_add(run->output, &j->whole, &run->error)
               : 0;
}

/* As a receiving Linux does: a longer one is not added, and behind a shorter
 * one comes no other. The time is that of the last, because Linux takes it when
 * it hands them up. */
static int join(struct run *run, const lum_datagram *datagram)
{
    struct joined *j = &run->joined;
    const bool fits = j->count < JOINED_MAX && datagram->len <= j->each &&
                      datagram->len <= JOINED_BYTES_MAX - j->whole.len;
    if (!fits && write_joined(run) != 0) {
        return -1;
    }
    const size_t at = j->count != 0 ? j->whole.len : 0;
    j->each = at != 0 ? j->each : datagram->len;
    memcpy(j->bytes + at, datagram->payload, datagram->len);
    j->whole = *datagram;
    j->whole.payload = j->bytes;
    j->whole.len = at + datagram->len;
    j->count++;
    return datagram->len < j->each ? write_joined(run) : 0;
}

static int write_packet(struct run *run, const lum_sim_packet *packet)
{
    const struct options *o = run->options;
    const lum_datagram datagram = {.time_ns = stamp_of(o, packet->time_ns),
                                   .payload = packet->bytes,
                                   .len = packet->len,
                                   .source = o->sensor,
                                   .destination = o->capture.client,
                                   .source_port = LUM_PORT,
                                   .destination_port = o->capture.client_port};
    run->packets++;
    return o->delivery.joined
               ? join(run, &datagram)
               : lum_capture_writer_add(run->output, &datagram, &run->error);
}

static int write_what_leaves(struct run *run)
{
    const lum_sim_packet *packet;
    while ((packet = lum_fault_pull(&run->fault)) != NULL) {
        if (write_packet(run, packet) != 0) {
            return -1;
        }
    }
    return 0;
}

static int send_line(struct run *run)
{
    const lum_render_options *r = &run->options->render;
    lum_sim_packet *order[LUM_EYES * LUM_PACKETS_LINE_MAX];
    const size_t n =
        lum_packets_spread(run->batches, 1e9 / r->rate_hz / r->lines, order);
    for (size_t i = 0; i < n; i++) {
        lum_fault_push(&run->fault, order[i]);
        if (write_what_leaves(run) != 0) {
            return -1;
        }
    }
    return write_joined(run);
}

/* --- Simulating --- */

static int simulate_eye(struct run *run, int64_t frame, uint32_t number,
                        unsigned eye)
{
    lum_sim_line *line = &run->line;
    if (lum_render_line(&run->render, frame, number, eye, line) != LUM_OK) {
        return lum_error_set(&run->error, "not enough memory for the scene");
    }
    run->points += line->truth_count;
    if (lum_packets_build(&run->options->render.layout, line,
                          &run->batches[eye]) != LUM_OK) {
        return lum_error_set(&run->error,
                             "a line does not fit the profile's packets");
    }
    if (run->labels != NULL &&
        labels_add(run->labels, line, &run->error) != 0) {
        return -1;
    }
    const int64_t utc_us = utc_of(run->options, line->clock_us * 1000) / 1000;
    return run->truth != NULL ? truth_add(run->truth, line, utc_us, &run->error)
                              : 0;
}

/* Of the start of a line, if requested; both eyes' start at once. */
static int write_pose(struct run *run, const lum_sim_line *line)
{
    const struct options *o = run->options;
    if (run->poses == NULL) {
        return 0;
    }
    const lum_pose pose =
        lum_render_pose(&run->render, line->frame, line->number);
    const int64_t time_ns =
        o->truth.is_utc ? utc_of(o, line->clock_us * 1000)
                        : lum_packets_clock_us(&o->render.layout, line) * 1000;
    return truth_poses_add(run->poses, time_ns, &pose, &run->error);
}

static int simulate_line(struct run *run, int64_t frame, uint32_t number)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (simulate_eye(run, frame, number, eye) != 0) {
            return -1;
        }
    }
    return write_pose(run, &run->line) == 0 ? send_line(run) : -1;
}

/* Without the first, the pixels of the last line would have no pose; without
 * the second, those of its last pixels whose UTC a reader estimates some
 * microseconds too late. */
static int write_last_poses(struct run *run)
{
    const uint32_t lines = run->options->render.lines;
    lum_sim_line *end = &run->line;
    int result = 0;
    for (end->number = lines; end->number <= lines + 1 && result == 0;
         end->number++) {
        end->clock_us =
            lum_render_clock_us(&run->render, end->frame, end->number);
        result = write_pose(run, end);
    }
    return result;
}

static void show_progress(const struct run *run, int64_t frame)
{
    if (run->progress && terminal_is_foreground(stderr)) {
        (void)fprintf(stderr, "\r\033[Kframe %" PRId64 " of %" PRId64, frame,
                      run->frames);
    }
}

static void clear_progress(const struct run *run)
{
    if (run->progress && terminal_is_foreground(stderr)) {
        (void)fputs("\r\033[K", stderr);
    }
}

/* 0, or -1 when it failed or a signal came. */
static int simulate(struct run *run)
{
    for (int64_t frame = 1; frame <= run->frames; frame++) {
        show_progress(run, frame);
        for (uint32_t i = 0; i < run->options->render.lines; i++) {
            if (simulate_line(run, frame, i) != 0 || interrupt_signal() != 0) {
                return -1;
            }
        }
    }
    lum_fault_flush(&run->fault);
    return write_what_leaves(run) == 0 && write_joined(run) == 0
               ? write_last_poses(run)
               : -1;
}

/* --- Ends --- */

static bool has_truth(const struct options *o)
{
    return o->truth.points != NULL || o->truth.calibration != NULL ||
           o->moving.poses != NULL || o->moving.labels != NULL;
}

/* The reader of a pipe that has seen enough is no failure. */
static int fail(const struct run *run, int reason)
{
    if (reason == EPIPE && !has_truth(run->options)) {
        return EXIT_SUCCESS;
    }
    (void)fprintf(stderr, "lumsim: %s\n", run->error.text);
    return EXIT_FAILURE;
}

static void abort_truth(struct run *run)
{
    truth_abort(run->truth);
    lum_sink_abort(run->poses);
    labels_abort(run->labels);
}

static int give_up(struct run *run)
{
    const int reason = errno;
    clear_progress(run);
    abort_truth(run);
    lum_capture_writer_abort(run->output);
    if (interrupt_signal() != 0) {
        lum_outfile_discard(&run->true_calibration);
        interrupt_die();
    }
    return fail(run, reason);
}

static void sum_up(const struct run *run)
{
    static const char *const names[LUM_FAULT_KINDS] = {
        "lost", "repeated", "reordered", "corrupted"};
    const struct options *o = run->options;
    if (o->quiet) {
        return;
    }
    (void)fprintf(stderr,
                  "%s: %" PRId64 " frames of %" PRIu32 " lines, %" PRIu64
                  " points in %" PRIu64 " packets",
                  strcmp(o->capture.output, "-") == 0 ? "standard output"
                                                      : o->capture.output,
                  run->frames, o->render.lines, run->points, run->packets);
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        if (o->delivery.faults[k] > 0.0) {
            (void)fprintf(stderr, "; %" PRIu64 " %s", run->fault.count[k],
                          names[k]);
        }
    }
    (void)fputc('\n', stderr);
}

static int close_truth(struct run *run)
{
    struct truth *truth = run->truth;
    lum_sink *poses = run->poses;
    run->truth = NULL;
    if (truth != NULL && truth_close(truth, &run->error) != 0) {
        return -1;
    }
    struct labels *labels = run->labels;
    run->labels = NULL;
    if (labels != NULL && labels_close(labels, &run->error) != 0) {
        return -1;
    }
    run->poses = NULL;
    if (poses != NULL && lum_sink_close(poses, &run->error) != 0) {
        return -1;
    }
    return run->options->truth.calibration != NULL
               ? lum_outfile_finish(&run->true_calibration, &run->error)
               : 0;
}

static int finish(struct run *run)
{
    clear_progress(run);
    if (close_truth(run) != 0) {
        const int reason = errno;
        abort_truth(run);
        lum_capture_writer_abort(run->output);
        return fail(run, reason);
    }
    if (lum_capture_writer_close(run->output, &run->error) != 0) {
        return fail(run, errno);
    }
    sum_up(run);
    return EXIT_SUCCESS;
}

/* --- Beginning --- */

/* A scene is its own source. */
static int open_capture(struct run *run)
{
    const struct options *o = run->options;
    char source[32];
    const struct provenance_run about = {.program = "lumsim", .source = source};
    const struct geometry geometry = {
        .calibration = o->render.calibration,
        .profile = o->render.layout.profile,
        .has_calibration =
            o->calibration != NULL || set_keys_first(&o->set, false) != NULL,
        .has_profile =
            o->profile != NULL || set_keys_first(&o->set, true) != NULL};
    struct provenance *said = NULL;
    (void)snprintf(source, sizeof source, "a simulated %s", standing_scene(o));
    const size_t n = strlen(o->capture.output);
    if (n > 7 && strcmp(o->capture.output + n - 7, ".pcapng") == 0) {
        said = malloc(sizeof *said);
        if (said == NULL) {
            return lum_error_set(&run->error, "not enough memory");
        }
        provenance_make(&about, &geometry, NULL, said);
    }
    const int result =
        capture_file_open(o->capture.output, said, &run->output, &run->error);
    const int code = errno;
    free(said);
    errno = code;
    return result;
}

static int open_truth(struct run *run)
{
    const struct options *o = run->options;
    if (o->truth.points != NULL &&
        truth_open(o->truth.points, &o->render.layout, o->truth.is_utc,
                   &run->truth, &run->error) != 0) {
        return -1;
    }
    if (o->moving.poses != NULL &&
        truth_poses_open(o->moving.poses, &run->poses, &run->error) != 0) {
        return -1;
    }
    if (o->moving.labels != NULL &&
        labels_open(o->moving.labels, &run->labels, &run->error) != 0) {
        return -1;
    }
    return o->truth.calibration != NULL
               ? truth_yaml_begin(o, &run->true_calibration, &run->error)
               : 0;
}

static int open_outputs(struct run *run)
{
    if (open_capture(run) != 0) {
        return fail(run, 0);
    }
    if (open_truth(run) != 0) {
        abort_truth(run);
        lum_capture_writer_abort(run->output);
        return fail(run, 0);
    }
    return 0;
}

static int execute(struct run *run)
{
    const struct options *o = run->options;
    if (lum_render_init(&run->render, &o->render) != LUM_OK) {
        (void)fprintf(stderr,
                      "lumsim: %s: angle_lsb_deg is too small: 16 bits do not "
                      "reach the ends of the calibrated span\n",
                      layout_source(o));
        return 2;
    }
    lum_fault_init(&run->fault, o->delivery.faults, o->render.seed);
    if (open_outputs(run) != 0) {
        return EXIT_FAILURE;
    }
    run->progress = !o->quiet;
    return simulate(run) == 0 ? finish(run) : give_up(run);
}

/* With nothing to tidy up a signal may end the run at once, even while it waits
 * for the reader of a pipe. */
static void prepare_for_signals(const struct options *o)
{
    if (!has_truth(o) && capture_file_is_in_place(o->capture.output)) {
        interrupt_catch_none();
    } else {
        interrupt_catch();
    }
}

int offline_run(const struct options *o)
{
    struct run *run = calloc(1, sizeof *run);
    if (run == NULL) {
        (void)fputs("lumsim: not enough memory\n", stderr);
        return EXIT_FAILURE;
    }
    run->options = o;
    run->true_calibration = (lum_outfile){.fd = -1, .claim = LUM_CLAIM_NONE};
    run->frames = o->frames > 0 ? o->frames : FRAMES_USUAL;
    prepare_for_signals(o);
    const int status = execute(run);
    lum_outfile_discard(&run->true_calibration);
    lum_render_free(&run->render);
    free(run);
    return status;
}
