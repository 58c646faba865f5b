#include "live_sensor.h"

#include "../common/interrupt.h"
#include "lum/base/time.h"
#include "lum/wire.h"
#include "moving.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Less is no jump: a round that closes. */
#define JUMP_M       0.01
#define JUMP_DEGREES 0.1

static void warn_of_capture(const struct live *live)
{
    if (live->data.playback.facts.is_cut_off) {
        (void)complain(
            "%s cannot be read to its end; the readable part is replayed",
            live->options->replay.path);
    }
    if (live->data.playback.facts.damage.text[0] != '\0') {
        (void)complain("%s", live->data.playback.facts.damage.text);
    }
    lum_error remark;
    for (size_t i = 0;
         live->data.playback.recording != NULL &&
         recording_remark(live->data.playback.recording, i, &remark);
         i++) {
        (void)complain("%s: %s", live->options->replay.path, remark.text);
    }
}

static void announce(const struct live *live)
{
    const struct options *o = live->options;
    char name[24];
    char port[8] = "";
    char host[24];
    if (o->quiet) {
        return;
    }
    (void)live_name(live->self.address, live->self.port, name);
    (void)snprintf(host, sizeof host, "%s", name);
    *strchr(host, ':') = '\0';
    if (live->self.port != LUM_PORT) {
        (void)snprintf(port, sizeof port, ":%u", (unsigned)live->self.port);
    }
    if (o->mode == MODE_REPLAY) {
        (void)fprintf(stderr, "lumsim: a G2 at %s, %" PRIu64 " packets of %s",
                      name, live->data.playback.facts.packets, o->replay.path);
    } else {
        (void)fprintf(stderr, "lumsim: a G2 at %s, %" PRIu32 " lines at %g Hz",
                      name, o->render.lines, o->render.rate_hz);
    }
    (void)fprintf(stderr,
                  "; try: lumdump udp://%s%s --laser -o cloud.ply; Ctrl-C ends "
                  "it\n",
                  host, port);
}

/* A loop of frames ends elsewhere than it begins. */
static bool has_jumps(const struct live *live, struct moving_jump *out)
{
    const struct options *o = live->options;
    if (o->mode == MODE_REPLAY || o->moving.path == NULL) {
        return false;
    }
    *out = moving_find_jump(o, live_frames(live));
    return out->metres > JUMP_M || out->degrees > JUMP_DEGREES;
}

static void warn_of_jumps(const struct live *live)
{
    struct moving_jump jump;
    if (!live->options->quiet && has_jumps(live, &jump)) {
        (void)complain("--path %s: its frames are played in a loop of %u, and "
                       "at the end of each round the sensor jumps by %.2f m "
                       "and %.1f degrees; more --frames make longer rounds, "
                       "and -o writes a drive without jumps",
                       live->options->moving.path, live_frames(live),
                       jump.metres, jump.degrees);
    }
}

static void sum_up(const struct live *live, int64_t now_ns)
{
    uint64_t others = live->counts.heard[LUM_PACKET_DATA];
    if (live->options->quiet) {
        return;
    }
    for (unsigned k = LUM_PACKET_FOREIGN; k < LUM_PACKET_KINDS; k++) {
        others += live->counts.heard[k];
    }
    (void)fprintf(stderr,
                  "lumsim: %.1f s: heard %" PRIu64 " heartbeats, %" PRIu64
                  " TLV packets, %" PRIu64 " time requests, %" PRIu64
                  " set IP, %" PRIu64 " others; sent %" PRIu64
                  " answers and %" PRIu64 " data packets",
                  (double)(now_ns - live->start_ns) / 1e9,
                  live->counts.heard[LUM_PACKET_HEARTBEAT],
                  live->counts.heard[LUM_PACKET_TLV],
                  live->counts.heard[LUM_PACKET_TIMESTAMP],
                  live->counts.heard[LUM_PACKET_SET_IP], others,
                  live->counts.answers, live->data.sender.sent);
    struct moving_jump jump;
    if (has_jumps(live, &jump)) {
        (void)fprintf(stderr, "; the sensor jumped %" PRIu64 " times",
                      live->data.scene.rounds_again);
    }
    if (live->data.scene.lines_skipped > 0) {
        (void)fprintf(stderr, "; %" PRIu64 " lines skipped: too slow a host",
                      live->data.scene.lines_skipped);
    }
    (void)fputc('\n', stderr);
}

static void apply_fault(struct live *live, const struct timeline_event *event,
                        int64_t now_ns)
{
    struct json *json = live_begin_line(live, now_ns, "fault");
    json_text(json, "name", event->name);
    json_bool(json, "ends", event->ends);
    live_end_line(live);
    switch (event->kind) {
    case FAULT_HAZARD:
        live_set_hazard(live, event->bits, event->ends, now_ns);
        break;
    case FAULT_REBOOT:
        live_reboot(live, now_ns);
        break;
    case FAULT_SILENCE:
        live->is_silent = !event->ends;
        sender_drop(&live->data.sender);
        break;
    }
}

/* A fault on a cue is no later than this. */
#define CUE_NS INT64_C(20000000)

static bool awaits_cue(const struct live *live)
{
    return timeline_awaits(&live->timeline, CUE_USR1) ||
           timeline_awaits(&live->timeline, CUE_USR2);
}

static void apply_faults(struct live *live, int64_t now_ns)
{
    const struct timeline_event *event;
    for (enum cue c = CUE_USR1; c <= CUE_USR2; c++) {
        if (cue_take(c)) {
            timeline_cue(&live->timeline, c, now_ns - live->start_ns);
        }
    }
    while ((event = timeline_take(&live->timeline, now_ns - live->start_ns)) !=
           NULL) {
        apply_fault(live, event, now_ns);
    }
}

static int64_t next_ns(const struct live *live, int64_t now_ns)
{
    const int64_t planned_ns = timeline_next_ns(&live->timeline);
    int64_t next = live_stream_next_ns(live, now_ns);
    next = earlier(next, live->end_ns);
    next = earlier(next, lum_device_next_ns(&live->device));
    next = earlier(next, live_replies_next_ns(live));
    if (awaits_cue(live)) {
        next = earlier(next, now_ns + CUE_NS);
    }
    return planned_ns == INT64_MAX ? next
                                   : earlier(next, live->start_ns + planned_ns);
}

static bool has_failed(const struct live *live)
{
    return live->has_failed || live->log.reason != 0;
}

static bool has_ended(const struct live *live, int64_t now_ns)
{
    return has_failed(live) || now_ns >= live->end_ns ||
           lum_cancel_is_raised(live->cancel);
}

/* What has failed is not waited with for the next datagram. */
static int64_t wait_until_ns(const struct live *live, int64_t now_ns)
{
    return has_failed(live) ? now_ns : next_ns(live, now_ns);
}

static void run(struct live *live)
{
    int64_t now_ns = lum_time_monotonic_ns();
    while (!has_ended(live, now_ns)) {
        apply_faults(live, now_ns);
        live_receive(live);
        live_tick(live, now_ns);
        live_send_replies(live, now_ns);
        live_fetch(live, now_ns);
        live_flush_ignored(live, now_ns);
        live_stream(live, now_ns);
        if (lum_socket_wait(&live->socket, 1, -1, live->cancel,
                            wait_until_ns(live, now_ns)) == LUM_NET_FAILED) {
            (void)lum_error_set(&live->error, "waiting for datagrams failed");
            live->has_failed = true;
        }
        now_ns = lum_time_monotonic_ns();
    }
}

static int open_socket(struct live *live)
{
    const lum_socket_options options = {
        .struct_size = sizeof options,
        .local = live->self,
        .interface_name = live->options->live.interface,
        .sends_joined = live->options->delivery.joined};
    return lum_socket_open(&options, &live->socket, &live->error) == LUM_NET_OK
               ? 0
               : -1;
}

static int open_parts(struct live *live)
{
    live_init_replies(live);
    return live_open_data(live) == 0 &&
                   lum_cancel_new(&live->cancel, &live->error) == 0 &&
                   open_socket(live) == 0 && live_open_log(live) == 0
               ? 0
               : -1;
}

static void start(struct live *live)
{
    const struct options *o = live->options;
    live->start_ns = lum_time_monotonic_ns();
    live->device_ns = live->start_ns;
    live->end_ns = o->live.duration_s > 0.0
                       ? live->start_ns + (int64_t)(o->live.duration_s * 1e9)
                       : INT64_MAX;
    lum_device_init(&live->device, &o->render.layout, (uint16_t)o->render.lines,
                    o->live.boot_status, o->live.clock_us, live->start_ns);
    interrupt_attach(live->cancel);
    warn_of_capture(live);
    announce(live);
    warn_of_jumps(live);
    live_log_start(live);
    live_order(live);
}

static void close_parts(struct live *live)
{
    interrupt_attach(NULL);
    live_close_data(live);
    lum_socket_close(live->socket);
    lum_cancel_free(live->cancel);
}

static int fail(const char *text)
{
    (void)complain("%s", text);
    return EXIT_FAILURE;
}

/* A reader that leaves the log's pipe ends the run quietly. */
static int finish(struct live *live)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    live_log_stop(live, now_ns);
    const int reason = live_close_log(live);
    if (live->has_failed) {
        return fail(live->error.text);
    }
    if (reason != 0 && reason != EPIPE) {
        (void)lum_error_set(&live->error, "--log: %s cannot be written: %s",
                            live->options->live.log, strerror(reason));
        return fail(live->error.text);
    }
    sum_up(live, now_ns);
    return EXIT_SUCCESS;
}

int live_run(const struct options *o)
{
    struct live *live = calloc(1, sizeof *live);
    int status = EXIT_FAILURE;
    if (live == NULL) {
        return fail("not enough memory");
    }
    live->options = o;
    live->timeline = o->timeline;
    live->self = (lum_endpoint){.address = o->sensor, .port = o->live.port};
    interrupt_catch();
    for (enum cue c = CUE_USR1; c <= CUE_USR2; c++) {
        if (timeline_awaits(&live->timeline, c)) {
            cue_catch(c);
        }
    }
    if (open_parts(live) == 0) {
        start(live);
        run(live);
        status = finish(live);
    } else {
        status = fail(live->error.text);
    }
    close_parts(live);
    free(live);
    return status;
}
