/* A live run: the session with a sensor, its outputs, and their end. */
#define _POSIX_C_SOURCE 200809L
#include "runs.h"

#include "../common/interrupt.h"
#include "../common/laser_end.h"
#include "../common/own_address.h"
#include "lum/base/time.h"
#include "receiving.h"

#include "lum/wire.h"

#include <inttypes.h>
#include <stdio.h>
#include <unistd.h>

/* So long without data at the end is told in the summary: in frames of any rate
 * lines come more often. */
#define PAUSE_NS INT64_C(1000000000)

struct live {
    struct pass *pass;
    const struct options *options;
    lum_cancel *cancel;
    struct session session;
    struct lanes lanes;
    struct live_counts counts;
    lum_laser_off off;
    lum_news end; /* with which the laser was left */
    lum_error error;
};

/* --- Begin and end --- */

static lum_sensor_options describe_session(const struct live *l, bool owns)
{
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = l->options->live.address;
    options.interface_name = l->options->live.interface;
    options.layout = *l->pass->layout;
    options.owns = owns;
    options.receive_buffer = l->options->live.receive_buffer;
    options.takes_joined = true;
    options.cancel = l->cancel;
    return options;
}

static int open_session(const struct live *l, bool owns, lum_sensor **out,
                        lum_error *error)
{
    const lum_sensor_options options = describe_session(l, owns);
    return lum_sensor_open(&options, out, error) == LUM_NET_OK ? 0 : -1;
}

static int open_laser(struct live *l)
{
    const lum_sensor_options session = describe_session(l, true);
    lum_laser_session_options options;
    lum_laser_session_options_default(&options, &session);
    return lum_laser_session_new(&options, lum_time_monotonic_ns(),
                                 &l->session.laser, &l->error);
}

static int start_lanes(struct live *l)
{
    const uint32_t address = l->options->live.address.address;
    struct lane_ends ends = {.sensor = {address, LUM_PORT}};
    lum_socket_local(lum_sensor_socket(l->session.sensor), &ends.client);
    if (ends.client.address == 0) {
        ends.client.address = own_address(address, l->options->live.interface);
    }
    return lanes_start(&l->lanes, ends, &l->error);
}

/* The session comes first: where another program has it, the files that it may
 * be writing stay as they are. A disk may stall while they are opened, and
 * what is told to end meanwhile does not begin. */
static int begin(struct live *l)
{
    if (lum_cancel_new(&l->cancel, &l->error) != 0) {
        return -1;
    }
    interrupt_insist(); /* heartbeats keep a laser on */
    interrupt_attach(l->cancel);
    l->pass->counts_alone = true;
    return open_session(l, true, &l->session.sensor, &l->error) == 0 &&
                   pass_prepare(l->pass, &l->error) == PASS_DONE &&
                   lanes_open(&l->lanes, l->pass, &l->error) == 0 &&
                   interrupt_signal() == 0 && start_lanes(l) == 0 &&
                   open_laser(l) == 0
               ? 0
               : -1;
}

/* A run that did not begin ends by its signal. */
static void die_unbegun(const struct live *l)
{
    if (l->session.end == SESSION_GOES_ON && interrupt_signal() != 0) {
        interrupt_die();
    }
}

/* What stalls keeps its thread, and that its memory: neither outlives the
 * process. */
static void release(struct live *l, enum exit_status status)
{
    interrupt_attach(NULL);
    if (!lanes_free(&l->lanes)) {
        die_unbegun(l);
        _exit((int)status);
    }
    pass_free(l->pass);
    lum_laser_session_free(l->session.laser);
    lum_sensor_close(l->session.sensor);
    lum_cancel_free(l->cancel);
}

static void count(struct live *l)
{
    const struct session *s = &l->session;
    lum_sensor_counters c = {.struct_size = sizeof c};
    const lum_laser_session_view view = session_look(s);
    const int64_t silent_ns = s->ended_ns - view.data_ns;
    session_darkness(s, l->counts.darkness, sizeof l->counts.darkness);
    lum_sensor_count(s->sensor, &c);
    l->counts.received = s->received;
    l->counts.kernel_drops = c.kernel_drops;
    l->counts.kernel_drops_at_least = c.kernel_drops > 0 && c.joined > 0;
    l->counts.ring_drops = l->lanes.summary->dropped;
    l->counts.foreign_source = c.foreign_source;
    l->counts.heartbeats_sent = c.heartbeats;
    if (view.has_data) {
        l->counts.dark_s =
            l->options->live.laser ? (double)s->dark_ns * 1e-9 : 0.0;
        l->counts.silent_s =
            silent_ns >= PAUSE_NS ? (double)silent_ns * 1e-9 : 0.0;
        l->counts.seconds =
            (double)(lum_time_monotonic_ns() - view.first_data_ns) * 1e-9;
    }
}

/* --- The laser --- */

/* A socket that broke sends nothing more, another may. */
static lum_laser_off switch_off_anew(struct live *l)
{
    lum_sensor *fresh = NULL;
    lum_error error = {""};
    (void)open_session(l, false, &fresh, &error);
    const lum_laser_off off =
        laser_end(l->session.laser, fresh, "lumdump", &l->end);
    lum_sensor_close(fresh);
    return off;
}

static void switch_off(struct live *l)
{
    static const char *const names[] = {[LUM_LASER_OFF_SEEN] = "off",
                                        [LUM_LASER_OFF_UNKNOWN] = "unknown",
                                        [LUM_LASER_OFF_REFUSED] = "on",
                                        [LUM_LASER_OFF_UNSEEN] = "unknown"};
    l->counts.laser = "untouched";
    if (!l->options->live.laser && !l->options->live.guards) {
        return;
    }
    if (l->session.end == SESSION_BROKEN) {
        l->off = switch_off_anew(l);
    } else {
        l->off =
            laser_end(l->session.laser, l->session.sensor, "lumdump", &l->end);
    }
    l->counts.laser = names[l->off];
}

/* A laser that was not seen down is always reported; if something failed, a
 * laser that was seen down is reported too. status: the result of the run
 * otherwise. */
static enum exit_status tell_laser(const struct live *l,
                                   enum exit_status status)
{
    char text[LUM_ERROR_BYTES];
    const bool is_off = l->off == LUM_LASER_OFF_SEEN;
    if (!l->options->live.laser && !l->options->live.guards) {
        return EXIT_DONE;
    }
    if (!is_off || status != EXIT_DONE) {
        (void)fprintf(stderr, "lumdump: %s\n",
                      lum_news_tell(&l->end, text, sizeof text));
    }
    return is_off ? EXIT_DONE : EXIT_FAILED;
}

/* --- What is said at the end --- */

/* Packets that may be data, and none that is. */
static bool has_unknown_layout(const struct session *s)
{
    const lum_laser_session_view view = session_look(s);
    return !view.has_data && view.has_unknown;
}

/* The sensor sent none, as far as anybody waited for it. */
static bool lacks_data(const struct session *s)
{
    const lum_laser_session_view view = session_look(s);
    return !view.has_data && !view.has_unknown &&
           (s->end == SESSION_NO_DATA || s->end == SESSION_SIGNAL);
}

/* Before the laser is switched off, which may take long. Waits for no reader.
 */
static void tell_no_data(struct session *s)
{
    char text[LUM_ERROR_BYTES];
    const lum_news news = {.struct_size = sizeof news,
                           .kind = session_look(s).has_answered
                                       ? LUM_NEWS_NO_DATA_YET
                                       : LUM_NEWS_NO_ANSWER_YET,
                           .sensor = s->options->live.address,
                           .interface_name = s->options->live.interface,
                           .ns = s->ended_ns - s->began_ns};
    say_error(&s->say, "%s", lum_news_tell(&news, text, sizeof text));
}

static void tell_notes(struct live *l)
{
    for (size_t i = 0; i < l->lanes.count; i++) {
        if (!l->lanes.list[i]->runs) {
            conclude_notes(l->lanes.list[i]->pass);
        }
    }
}

static void report_outputs(struct live *l)
{
    static const char *const ends[] = {[LANE_LIVES] = "done",
                                       [LANE_WHOLE] = "done",
                                       [LANE_READER_LEFT] = "no reader",
                                       [LANE_FAILED] = "failed",
                                       [LANE_STALLED] = "stalled",
                                       [LANE_ABANDONED] = "stalled"};
    struct live_counts *c = &l->counts;
    c->output_count = l->lanes.count;
    for (size_t i = 0; i < l->lanes.count; i++) {
        const struct lane *lane = l->lanes.list[i];
        const lum_laser_session_view view = session_look(&l->session);
        const int64_t from_ns =
            view.has_data ? view.first_data_ns : l->session.began_ns;
        c->outputs[i] = (struct live_output){
            .name = lane_name(lane),
            .end = ends[lane->end],
            .error = lane->error.text,
            .is_recording = lane->kind == LANE_RECORDING,
            .has_ended_early = lane->end != LANE_WHOLE,
            .datagrams = lane->view.taken,
            .dropped = lane->dropped,
            .seconds = lane->ended_ns > from_ns
                           ? (double)(lane->ended_ns - from_ns) * 1e-9
                           : 0.0};
        c->recording_drops += lane->kind == LANE_RECORDING ? lane->dropped : 0;
    }
}

/* The summary has the losses of a recording; if it is not printed, they are
 * reported here. */
static void tell_missing(const struct live *l)
{
    const struct live_counts *c = &l->counts;
    for (size_t i = 0; i < c->output_count; i++) {
        const struct live_output *o = &c->outputs[i];
        if (l->options->quiet && o->is_recording &&
            o->dropped + c->kernel_drops > 0) {
            (void)fprintf(
                stderr,
                "lumdump: %s: datagrams are missing from this "
                "recording: %" PRIu64 " dropped by its buffer, %s%" PRIu64
                " by the system\n",
                o->name, o->dropped,
                c->kernel_drops_at_least ? "at least " : "", c->kernel_drops);
        }
    }
}

static enum exit_status tell_end(struct live *l)
{
    enum exit_status status =
        lanes_have_failed(&l->lanes) ? EXIT_FAILED : EXIT_DONE;
    tell_notes(l);
    if (has_unknown_layout(&l->session)) {
        char capture[MISFIT_CAPTURE_BYTES];
        diagnosis_print(&l->pass->diagnosis, l->options->source,
                        conclude_capture(l->options, capture), stderr);
        return EXIT_FAILED;
    }
    if (lacks_data(&l->session)) {
        return EXIT_NO_ANSWER;
    }
    if (l->session.end == SESSION_BROKEN) {
        status = conclude_error(&l->session.error, EXIT_FAILED);
    }
    if (lanes_have_no_reader(&l->lanes) ||
        !session_look(&l->session).has_data) {
        return status;
    }
    report_outputs(l);
    l->pass->summary.live = &l->counts;
    lanes_note_left_out(&l->lanes, &l->pass->summary);
    const enum exit_status printed = conclude_summary(l->pass);
    tell_missing(l);
    return status != EXIT_DONE ? status : printed;
}

/* --- The run --- */

/* While the laser may be on, a signal ends the run in good order. After that
 * the outputs get their time, and the final messages come as usual, except that
 * a laser that is not off is reported first. */
static enum exit_status run(struct live *l)
{
    enum exit_status laser = EXIT_DONE;
    interrupt_hold();
    session_run(&l->session);
    if (l->session.end == SESSION_SIGNAL ||
        l->session.end == SESSION_DURATION) {
        lum_sensor_give_up(l->session.sensor);
        session_drain(&l->session, l->cancel);
    }
    count(l);
    if (lacks_data(&l->session)) {
        tell_no_data(&l->session);
    }
    /* They write while the laser goes off, which may take long. */
    lanes_finish(&l->lanes, session_look(&l->session).has_data);
    switch_off(l);
    interrupt_linger();
    const bool is_down = l->off == LUM_LASER_OFF_SEEN;
    if (!is_down) {
        say_end(&l->session.say);
        laser = tell_laser(l, EXIT_DONE);
    }
    lanes_end(&l->lanes, &l->session.say);
    interrupt_release();
    say_end(&l->session.say);
    const enum exit_status status = tell_end(l);
    laser = is_down ? tell_laser(l, status) : laser;
    return status != EXIT_DONE ? status : laser;
}

enum exit_status live_run(struct pass *pass)
{
    struct live l = {.pass = pass, .options = pass->options};
    enum exit_status status = EXIT_FAILED;
    l.session.options = pass->options;
    l.session.layout = pass->layout;
    l.session.lanes = &l.lanes;
    if (begin(&l) == 0) {
        status = run(&l);
    } else if (interrupt_signal() == 0) {
        (void)conclude_error(&l.error, EXIT_FAILED);
    }
    release(&l, status);
    die_unbegun(&l);
    return status;
}
