/* A simulated sensor's packets, written into a capture. */
#define _POSIX_C_SOURCE 200809L
#include "../common/capture_file.h"
#include "../common/interrupt.h"
#include "../common/terminal.h"
#include "lum/wire.h"
#include "named_files.h"
#include "rig_capture.h"
#include "sim/fault.h"
#include "simulated.h"
#include "standing.h"
#include "truth.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A system is woken up to so much too late. */
#define WAKING_NS 9973

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

struct run {
    const struct options *options;
    struct simulated *sensors;
    size_t count; /* of these */
    lum_fault fault;
    struct joined joined;
    lum_capture_writer *output;
    lum_sink *poses; /* NULL: not requested */
    lum_error error;
    int64_t frames;
    bool progress; /* shown */
};

/* A system that looks at its packets now and then stamps all at once; nobody is
 * woken to the microsecond. */
static int64_t stamp_of(const struct options *o, int64_t time_ns)
{
    const int64_t batch_ns = (int64_t)(o->capture.batch_ms * 1e6);
    const int64_t utc_ns = simulated_utc(o, time_ns);
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
    struct simulated *sensor = &run->sensors[packet->sender];
    const lum_datagram datagram = {.time_ns = stamp_of(o, packet->time_ns),
                                   .payload = packet->bytes,
                                   .len = packet->len,
                                   .source = sensor->options->sensor,
                                   .destination = o->capture.client,
                                   .source_port = LUM_PORT,
                                   .destination_port = o->capture.client_port};
    sensor->packets++;
    return o->delivery.joined
               ? join(run, &datagram)
               : lum_capture_writer_add_from(run->output, sensor->interface,
                                             &datagram, &run->error);
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

/* What befalls a packet is drawn when it is put in. */
static void push(struct run *run, struct simulated *sensor,
                 const lum_sim_packet *packet)
{
    uint64_t before[LUM_FAULT_KINDS];
    memcpy(before, run->fault.count, sizeof before);
    lum_fault_push(&run->fault, packet);
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        sensor->faults[k] += run->fault.count[k] - before[k];
    }
}

static int send_next(struct run *run, struct simulated *sensor)
{
    push(run, sensor, sensor->order[sensor->next++]);
    if (write_what_leaves(run) != 0) {
        return -1;
    }
    return sensor->next == sensor->count ? write_joined(run) : 0;
}

/* --- Poses --- */

/* Of the start of a line of the first sensor, if requested; both eyes' start at
 * once. */
static int write_pose(struct run *run, const lum_sim_line *line)
{
    const struct options *o = run->options;
    const struct simulated *s = &run->sensors[0];
    const int64_t clock_ns = line->clock_us * 1000;
    if (run->poses == NULL) {
        return 0;
    }
    const lum_pose pose =
        lum_render_pose(&s->render, line->frame, line->number);
    const int64_t time_ns =
        o->truth.is_utc ? simulated_utc(o, simulated_time_ns(s, clock_ns))
                        : lum_packets_clock_us(&o->render.layout, line) * 1000;
    return truth_poses_add(run->poses, time_ns, &pose, &run->error);
}

/* Without the first, the pixels of the last line would have no pose; without
 * the second, those of its last pixels whose UTC a reader estimates some
 * microseconds too late. Other sensors may end later. */
static int write_last_poses(struct run *run)
{
    const struct options *o = run->options;
    const uint32_t lines = o->render.lines;
    const double late_s = rig_late_s(o, run->frames);
    const uint32_t more = (uint32_t)(late_s * o->render.rate_hz * lines + 1.0);
    const uint32_t last = lines + 1 + (late_s > 0.0 ? more : 0);
    struct simulated *s = &run->sensors[0];
    lum_sim_line *end = &s->line;
    int result = 0;
    for (end->number = lines; end->number <= last && result == 0;
         end->number++) {
        end->clock_us =
            lum_render_clock_us(&s->render, end->frame, end->number);
        result = write_pose(run, end);
    }
    return result;
}

/* --- Simulating --- */

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

static int render(struct run *run, struct simulated *sensor)
{
    const bool is_first = sensor == &run->sensors[0];
    if (is_first && sensor->number == 0) {
        show_progress(run, sensor->frame);
    }
    if (simulated_render(sensor, (unsigned)(sensor - run->sensors),
                         &run->error) != 0 ||
        (is_first && write_pose(run, &sensor->line) != 0)) {
        return -1;
    }
    return interrupt_signal() == 0 ? 0 : -1;
}

/* The one whose next packet leaves first; of several, the first of the rig.
 * NULL: all have ended. */
static struct simulated *find_next(const struct run *run)
{
    struct simulated *found = NULL;
    for (size_t i = 0; i < run->count; i++) {
        struct simulated *s = &run->sensors[i];
        if (s->next < s->count &&
            (found == NULL ||
             s->order[s->next]->time_ns < found->order[found->next]->time_ns)) {
            found = s;
        }
    }
    return found;
}

/* So that each has a packet to come, up to its end. */
static int render_all(struct run *run)
{
    for (size_t i = 0; i < run->count; i++) {
        struct simulated *s = &run->sensors[i];
        if (s->next == s->count && s->frame <= run->frames &&
            render(run, s) != 0) {
            return -1;
        }
    }
    return 0;
}

/* 0, or -1 when it failed or a signal came. */
static int simulate(struct run *run)
{
    struct simulated *next = NULL;
    do {
        if (render_all(run) != 0) {
            return -1;
        }
        next = find_next(run);
        if (next != NULL && send_next(run, next) != 0) {
            return -1;
        }
    } while (next != NULL);
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
    (void)complain("%s", run->error.text);
    return EXIT_FAILURE;
}

static void abort_truth(struct run *run)
{
    for (size_t i = 0; i < run->count; i++) {
        simulated_abort(&run->sensors[i]);
    }
    lum_sink_abort(run->poses);
}

static void free_sensors(struct run *run)
{
    for (size_t i = 0; i < run->count; i++) {
        simulated_free(&run->sensors[i]);
    }
    free(run->sensors);
    run->sensors = NULL;
    run->count = 0;
}

static int give_up(struct run *run)
{
    const int reason = errno;
    clear_progress(run);
    abort_truth(run);
    lum_capture_writer_abort(run->output);
    if (interrupt_signal() != 0) {
        free_sensors(run);
        interrupt_die();
    }
    return fail(run, reason);
}

static void sum_faults(const struct options *o,
                       const uint64_t faults[LUM_FAULT_KINDS])
{
    static const char *const names[LUM_FAULT_KINDS] = {
        "lost", "repeated", "reordered", "corrupted"};
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        if (o->delivery.faults[k] > 0.0) {
            (void)fprintf(stderr, "; %" PRIu64 " %s", faults[k], names[k]);
        }
    }
    (void)fputc('\n', stderr);
}

static void sum_up(const struct run *run)
{
    const struct options *o = run->options;
    uint64_t points = 0;
    uint64_t packets = 0;
    for (size_t i = 0; i < run->count; i++) {
        points += run->sensors[i].points;
        packets += run->sensors[i].packets;
    }
    (void)fprintf(stderr,
                  "%s: %" PRId64 " frame%s of %" PRIu32 " lines%s, %" PRIu64
                  " points in %" PRIu64 " packets",
                  strcmp(o->capture.output, "-") == 0 ? "standard output"
                                                      : o->capture.output,
                  run->frames, run->frames == 1 ? "" : "s", o->render.lines,
                  o->rig.path != NULL ? " of each sensor" : "", points,
                  packets);
    sum_faults(o, run->fault.count);
    for (size_t i = 0; o->rig.path != NULL && i < run->count; i++) {
        const struct simulated *s = &run->sensors[i];
        (void)fprintf(stderr, "  %s: %" PRIu64 " points in %" PRIu64 " packets",
                      s->options->rig.name, s->points, s->packets);
        sum_faults(o, s->faults);
    }
}

static int close_truth(struct run *run)
{
    lum_sink *poses = run->poses;
    for (size_t i = 0; i < run->count; i++) {
        if (simulated_close(&run->sensors[i], &run->error) != 0) {
            return -1;
        }
    }
    run->poses = NULL;
    return poses != NULL ? lum_sink_close(poses, &run->error) : 0;
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
    if (!run->options->quiet) {
        sum_up(run);
    }
    return EXIT_SUCCESS;
}

/* --- Beginning --- */

/* The names of the rig's interfaces, "" among them for sensors without one, and
 * the place of each sensor's; 0: no sensor has one. */
static size_t find_interfaces(struct run *run,
                              const char *names[LUM_RIG_SENSORS_MAX])
{
    bool has_name = false;
    size_t count = 0;
    for (size_t i = 0; run->options->rig.path != NULL && i < run->count; i++) {
        struct simulated *s = &run->sensors[i];
        s->interface = 0;
        while (s->interface < count &&
               strcmp(names[s->interface], s->options->rig.interface) != 0) {
            s->interface++;
        }
        names[s->interface] = s->options->rig.interface;
        count += s->interface == count;
        has_name = has_name || names[s->interface][0] != '\0';
    }
    return has_name ? count : 0;
}

/* A scene is its own source. */
static void describe(const struct run *run, struct provenance *out)
{
    const struct options *o = run->options;
    char source[32];
    const char *sensors[LUM_RIG_SENSORS_MAX];
    struct provenance_run about = {.program = "lumsim", .source = source};
    const struct geometry geometry = {
        .calibration = o->render.calibration,
        .profile = o->render.layout.profile,
        .has_calibration =
            o->calibration != NULL || set_keys_first(&o->set, false) != NULL,
        .has_profile =
            o->profile != NULL || set_keys_first(&o->set, true) != NULL};
    (void)snprintf(source, sizeof source, "a simulated %s", standing_scene(o));
    for (size_t i = 0; o->rig.path != NULL && i < run->count; i++) {
        sensors[i] = run->sensors[i].options->rig.name;
        about.sensors = sensors;
        about.sensor_count = run->count;
    }
    provenance_make(&about, &geometry, NULL, out);
}

static int open_capture(struct run *run)
{
    const struct options *o = run->options;
    const char *names[LUM_RIG_SENSORS_MAX];
    struct provenance *said = NULL;
    if (capture_file_is_pcapng(o->capture.output)) {
        said = malloc(sizeof *said);
        if (said == NULL) {
            return lum_error_set(&run->error, "not enough memory");
        }
        describe(run, said);
    }
    const size_t count = find_interfaces(run, names);
    const int result = capture_file_open_from(o->capture.output, said, names,
                                              count, &run->output, &run->error);
    const int code = errno;
    free(said);
    errno = code;
    return result;
}

static int open_truth(struct run *run)
{
    const struct options *o = run->options;
    for (size_t i = 0; i < run->count; i++) {
        if (simulated_open(&run->sensors[i], &run->error) != 0) {
            return -1;
        }
    }
    return o->moving.poses != NULL
               ? truth_poses_open(o, &run->poses, &run->error)
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

/* 0, or the exit status. */
static int init_sensors(struct run *run)
{
    const struct options *o = run->options;
    const size_t count = o->rig.path != NULL ? o->rig.count : 1;
    run->sensors = calloc(count, sizeof *run->sensors);
    if (run->sensors == NULL) {
        (void)complain("not enough memory");
        return EXIT_FAILURE;
    }
    while (run->count < count) {
        const struct options *one =
            o->rig.path != NULL ? &o->rig.sensors[run->count] : o;
        if (simulated_init(&run->sensors[run->count++], one) != 0) {
            (void)complain("%s: angle_lsb_deg is too small: 16 bits do not "
                           "reach the ends of the calibrated span",
                           layout_source(one));
            return 2;
        }
    }
    return 0;
}

static int execute(struct run *run)
{
    const struct options *o = run->options;
    const int status = init_sensors(run);
    if (status != 0) {
        return status;
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
        (void)complain("not enough memory");
        return EXIT_FAILURE;
    }
    run->options = o;
    run->frames = o->frames > 0 ? o->frames : FRAMES_USUAL;
    prepare_for_signals(o);
    const int status = execute(run);
    free_sensors(run);
    free(run);
    return status;
}
