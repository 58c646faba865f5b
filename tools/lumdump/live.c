#include "live.h"

#include "../common/interrupt.h"
#include "../common/laser_bits.h"
#include "../common/number.h"
#include "lum/base/time.h"
#include "own_address.h"
#include "session.h"

#include "lum/wire.h"

#include <inttypes.h>
#include <stdio.h>

#define BUFFER_BYTES (UINT64_C(64) << 20)

struct live {
    struct pass *pass;
    const struct options *options;
    lum_cancel *cancel;
    struct session session;
    struct live_counts counts;
    lum_laser_off off;
    uint16_t status; /* with which the laser was left */
    lum_error error;
};

static int open_session(const struct live *l, bool owns, lum_sensor **out,
                        lum_error *error)
{
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = l->options->address;
    options.interface_name = l->options->interface;
    options.layout = *l->pass->layout;
    options.owns = owns;
    options.receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    options.cancel = l->cancel;
    return lum_sensor_open(&options, out, error) == LUM_NET_OK ? 0 : -1;
}

static int open_ring(struct live *l)
{
    const uint64_t size =
        l->options->buffer != 0 ? l->options->buffer : BUFFER_BYTES;
    l->session.ring = ring_new((size_t)size);
    return l->session.ring != NULL
               ? 0
               : lum_error_set(&l->error,
                               "no memory for a buffer of %" PRIu64
                               " bytes; try a smaller --buffer",
                               size);
}

static int open_outputs(struct live *l)
{
    return l->options->output_count == 0
               ? 0
               : outputs_open(l->options, l->pass->projector, NULL,
                              &l->pass->notes, &l->pass->outputs, &l->error);
}

static int start_worker(struct live *l)
{
    const uint32_t address = l->options->address.address;
    struct worker_ends ends = {.sensor = {address, LUM_PORT}};
    lum_socket_local(lum_sensor_socket(l->session.sensor), &ends.client);
    if (ends.client.address == 0) {
        ends.client.address =
            own_address(l->options->address, l->options->interface);
    }
    return worker_start(l->pass, l->session.ring, ends, l->cancel,
                        &l->session.worker, &l->error);
}

/* The session comes first: where another program has it, the files that it may
 * be writing stay as they are. */
static int begin(struct live *l)
{
    if (lum_cancel_new(&l->cancel, &l->error) != 0) {
        return -1;
    }
    interrupt_insist(); /* heartbeats keep a laser on */
    interrupt_attach(l->cancel);
    return open_session(l, true, &l->session.sensor, &l->error) == 0 &&
                   pass_prepare(l->pass, &l->error) == PASS_DONE &&
                   open_ring(l) == 0 && open_outputs(l) == 0 &&
                   start_worker(l) == 0
               ? 0
               : -1;
}

static void release(struct live *l)
{
    interrupt_attach(NULL);
    outputs_abort(l->pass->outputs);
    pass_free(l->pass);
    ring_free(l->session.ring);
    lum_sensor_close(l->session.sensor);
    lum_cancel_free(l->cancel);
}

static void count(struct live *l)
{
    const struct session *s = &l->session;
    lum_sensor_counters c;
    (void)watch_darkness(&s->watch, l->counts.darkness,
                         sizeof l->counts.darkness);
    lum_sensor_count(s->sensor, &c);
    l->counts.received = s->received;
    l->counts.kernel_drops = c.kernel_drops;
    l->counts.ring_drops = s->ring_drops;
    l->counts.foreign_source = c.foreign_source;
    l->counts.heartbeats_sent = c.heartbeats;
    if (s->watch.has_data) {
        l->counts.seconds =
            (double)(lum_time_monotonic_ns() - s->first_data_ns) * 1e-9;
    }
}

/* A socket that broke sends nothing more, another may. */
static lum_laser_off switch_off_anew(struct live *l)
{
    lum_sensor *fresh = NULL;
    lum_error error = {""};
    if (open_session(l, false, &fresh, &error) != 0) {
        return LUM_LASER_OFF_UNKNOWN;
    }
    const lum_laser_off off = lum_sensor_laser_off(fresh, &l->status);
    lum_sensor_close(fresh);
    return off;
}

static void switch_off(struct live *l)
{
    static const char *const names[] = {[LUM_LASER_OFF_SEEN] = "off",
                                        [LUM_LASER_OFF_UNKNOWN] = "unknown",
                                        [LUM_LASER_OFF_REFUSED] = "on"};
    l->counts.laser = "untouched";
    if (!l->options->laser) {
        return;
    }
    if (l->session.end == SESSION_BROKEN) {
        l->off = switch_off_anew(l);
    } else {
        lum_sensor_give_up(l->session.sensor);
        l->off = lum_sensor_laser_off(l->session.sensor, &l->status);
    }
    l->counts.laser = names[l->off];
}

/* A laser that was not seen down is told of whatever else there is; where
 * something has failed, one that was is too.
 * status: how the run ended otherwise. */
static enum exit_status tell_laser(const struct live *l,
                                   enum exit_status status)
{
    char address[16];
    char bits[256];
    if (!l->options->laser) {
        return EXIT_DONE;
    }
    if (l->off == LUM_LASER_OFF_SEEN) {
        if (status != EXIT_DONE) {
            (void)fprintf(stderr, "lumdump: %s: the laser is off\n",
                          l->options->source);
        }
        return EXIT_DONE;
    }
    (void)number_format_address(l->options->address.address, address);
    if (l->off == LUM_LASER_OFF_UNKNOWN) {
        (void)fprintf(stderr,
                      "lumdump: %s: laser off was not answered: a sensor that "
                      "lives switches it off 3 s after the last heartbeat, "
                      "which has been sent; make sure by lumctl --host %s "
                      "laser off\n",
                      l->options->source, address);
    } else {
        (void)fprintf(stderr,
                      "lumdump: %s: THE LASER IS STILL ON after laser off "
                      "(status: %s): lumctl --host %s laser off, or cut its "
                      "power\n",
                      l->options->source,
                      laser_bits_name(l->status, UINT16_MAX, bits, sizeof bits),
                      address);
    }
    return EXIT_FAILED;
}

static enum exit_status tell_no_data(const struct live *l)
{
    const struct watch *w = &l->session.watch;
    (void)fprintf(stderr,
                  "lumdump: %s: no data from %s within 5 s%s; look with lumctl "
                  "--host %s doctor\n",
                  l->options->source, w->address,
                  w->laser.has_status
                      ? ", though it answers: is a profile needed, or "
                        "does a firewall drop what is not an answer?"
                      : ", nor any answer: is it on, connected and "
                        "at this address? It boots at 10.42.0.37",
                  w->address);
    return EXIT_NO_ANSWER;
}

/* Packets that may be data, and none that is. */
static bool has_unknown_layout(const struct session *s)
{
    return !s->watch.has_data && s->has_unknown;
}

static bool keeps_outputs(const struct session *s)
{
    return s->end != SESSION_NO_DATA && !has_unknown_layout(s);
}

static enum exit_status tell_end(struct live *l, enum pass_result result,
                                 uint64_t left_out)
{
    enum exit_status status = EXIT_DONE;
    l->pass->notes_told = l->session.notes_told;
    conclude_notes(l->pass);
    if (result == PASS_FAILED) {
        return conclude_error(&l->error, EXIT_FAILED);
    }
    if (has_unknown_layout(&l->session)) {
        diagnosis_print(&l->pass->diagnosis, l->options->source, stderr);
        return EXIT_FAILED;
    }
    if (l->session.end == SESSION_NO_DATA) {
        return tell_no_data(l);
    }
    if (l->session.end == SESSION_BROKEN) {
        status = conclude_error(&l->session.error, EXIT_FAILED);
    }
    if (result == PASS_READER_LEFT) {
        return status;
    }
    l->pass->summary.live = &l->counts;
    const enum exit_status printed = conclude_summary(l->pass, left_out);
    return status != EXIT_DONE ? status : printed;
}

/* From the laser's first moment to its last a signal ends the run in good
 * order; what comes then may take the usual time only. */
static enum exit_status run(struct live *l)
{
    uint64_t left_out = 0;
    interrupt_hold();
    session_run(&l->session);
    if (l->session.end == SESSION_SIGNAL ||
        l->session.end == SESSION_DURATION) {
        lum_cancel_reset(l->cancel);
        lum_sensor_give_up(l->session.sensor);
        session_drain(&l->session);
    }
    count(l);
    switch_off(l);
    interrupt_release();
    say_end(&l->session.say);
    const enum pass_result result = worker_end(
        l->session.worker, keeps_outputs(&l->session), &left_out, &l->error);
    const enum exit_status status = tell_end(l, result, left_out);
    const enum exit_status laser = tell_laser(l, status);
    return status != EXIT_DONE ? status : laser;
}

enum exit_status live_run(struct pass *pass)
{
    struct live l = {.pass = pass, .options = pass->options};
    enum exit_status status = EXIT_FAILED;
    l.session.options = pass->options;
    l.session.layout = pass->layout;
    if (begin(&l) == 0) {
        status = run(&l);
    } else if (interrupt_signal() == 0) {
        (void)conclude_error(&l.error, EXIT_FAILED);
    }
    release(&l);
    if (l.session.end == SESSION_GOES_ON && interrupt_signal() != 0) {
        interrupt_die(); /* before it began */
    }
    return status;
}
