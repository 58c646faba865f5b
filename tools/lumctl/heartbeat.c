/* The command heartbeat: owns the session, and shows what comes. */
#include "ctl.h"

#include "../common/terminal.h"
#include "ctl_session.h"
#include "laser_outcome.h"
#include "monitor.h"
#include "status_report.h"

#include "lum/base/time.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>

#define SHOW_NS INT64_C(500000000)

/* Never write where that has to wait for a reader: heartbeats would wait too. A
 * later line reports what was left out. */
struct beating {
    struct ctl *ctl;
    struct monitor monitor;
    bool shows_line; /* a line of progress, where there is a terminal */
    bool has_any;    /* something came from the sensor */
    bool has_logged; /* a status was printed */
    uint16_t logged; /* the last one */
    int64_t begun_ns;
    int64_t shown_ns;
    lum_sensor_counters shown; /* as they stood then */
    lum_sensor_counters begun; /* and at first: a shell has counted before */
};

static void clear_line(const struct beating *b)
{
    if (b->shows_line && terminal_is_foreground(stderr)) {
        (void)fputs("\r\033[K", stderr);
    }
}

static void show_line(struct beating *b, int64_t now)
{
    lum_sensor_counters c = {.struct_size = sizeof c};
    if (!b->shows_line || now < b->shown_ns + SHOW_NS ||
        !terminal_is_foreground(stderr) || !writable(stderr, 0)) {
        return;
    }
    const double s = (double)(now - b->shown_ns) / 1e9;
    lum_sensor_count(b->ctl->sensor, &c);
    (void)fprintf(stderr,
                  "\r\033[K%s: %" PRIu64 " heartbeats, %.0f packets/s, "
                  "%.1f MB/s",
                  session_name(session_host(b->ctl)).text,
                  c.heartbeats - b->begun.heartbeats,
                  (double)(c.datagrams - b->shown.datagrams) / s,
                  (double)(c.bytes - b->shown.bytes) / s / 1e6);
    b->shown = c;
    b->shown_ns = now;
}

static bool show_status(struct beating *b, const lum_sensor_event *event)
{
    struct ctl *ctl = b->ctl;
    const bool was_up = b->has_logged && lum_laser_is_on(b->logged);
    const bool is_news = !b->has_logged || b->logged != event->status;
    ctl->has_status = true;
    ctl->status = event->status;
    if (!is_news || ctl->options.repeat.every_s > 0.0 || !writable(stdout, 0)) {
        return true; /* --every has lines of its own */
    }
    b->has_logged = true;
    b->logged = event->status;
    if (writable(stderr, 0)) {
        clear_line(b);
    }
    return status_log(ctl, was_up, true, event->status);
}

/* There is a session only once something has come from the sensor. */
static void welcome(struct beating *b)
{
    if (!b->has_any && writable(stderr, 0)) {
        clear_line(b);
        ctl_note(b->ctl, "this is now the session of %s: its data comes here",
                 session_name(session_host(b->ctl)).text);
    }
    b->has_any = true;
}

static bool take(void *context, const lum_sensor_event *event)
{
    struct beating *b = context;
    const bool is_heard = event->kind == LUM_SENSOR_DATAGRAMS ||
                          event->kind == LUM_SENSOR_ANSWER ||
                          event->kind == LUM_SENSOR_ALERT;
    if (is_heard) {
        welcome(b);
    }
    const bool goes_on = monitor_take(&b->monitor, event) &&
                         (!event->has_status || show_status(b, event));
    show_line(b, lum_time_monotonic_ns());
    return goes_on && !monitor_is_met(&b->monitor);
}

static lum_result ask(struct ctl *ctl, void *context)
{
    struct beating *b = context;
    return monitor_ask(ctl, &b->monitor);
}

static void sum_up(const struct beating *b)
{
    const struct ctl *ctl = b->ctl;
    const double s = (double)(lum_time_monotonic_ns() - b->begun_ns) / 1e9;
    struct json json;
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_sensor_count(ctl->sensor, &c);
    if (!ctl->options.json) {
        ctl_note(ctl,
                 "%" PRIu64 " heartbeats in %.1f s, %" PRIu64
                 " packets came, %" PRIu64 " dropped by the kernel",
                 c.heartbeats - b->begun.heartbeats, s,
                 c.datagrams - b->begun.datagrams,
                 c.kernel_drops - b->begun.kernel_drops);
        return;
    }
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", session_name(session_host(ctl)).text);
    json_real(&json, "duration_s", s, 3);
    json_uint(&json, "heartbeats", c.heartbeats - b->begun.heartbeats);
    json_uint(&json, "packets", c.datagrams - b->begun.datagrams);
    json_uint(&json, "bytes", c.bytes - b->begun.bytes);
    json_uint(&json, "kernel_drops", c.kernel_drops - b->begun.kernel_drops);
    if (ctl->has_status) {
        report_json(&json, ctl->status, true);
    }
    json_end_line(&json);
}

static void announce(const struct ctl *ctl)
{
    const double usual_hz = 1000.0 / LUM_SENSOR_HEARTBEAT_MS;
    ctl_note(ctl, "heartbeats go to %s, %.3g a second; %s",
             session_name(session_host(ctl)).text,
             ctl->options.owner.rate_hz > 0.0 ? ctl->options.owner.rate_hz
                                              : usual_hz,
             ctl->options.repeat.duration_s > 0.0 ? "Ctrl-C ends it sooner"
                                                  : "Ctrl-C ends it");
}

/* The laser that was to be on, and is not. */
static enum exit_status judge_laser(const struct beating *b)
{
    const struct ctl *ctl = b->ctl;
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(ctl->laser, &view);
    return !ctl->options.owner.laser || view.laser == LUM_LASER_UP ||
                   ctl->options.repeat.until == UNTIL_DOWN
               ? EXIT_DONE
           : b->monitor.hazards.ever != 0 ? EXIT_HAZARD
                                          : EXIT_FAILED;
}

/* What becomes of the laser, and with what it ends. */
static enum exit_status conclude(struct beating *b, enum exit_status status)
{
    struct ctl *ctl = b->ctl;
    const bool was_heard = b->has_any;
    if (status == EXIT_DONE && !was_heard &&
        !lum_cancel_is_raised(ctl->cancel)) {
        status = session_complain_silence(ctl, 0);
    }
    status = status == EXIT_DONE ? judge_laser(b) : status;
    if (ctl->options.owner.laser) {
        const enum exit_status left = laser_leave(ctl);
        return left != EXIT_DONE ? left : status;
    }
    if (ctl->has_status && !lum_laser_is_down(ctl->status)) {
        ctl_note(ctl,
                 "the laser %s; without heartbeats the sensor switches it off "
                 "in 3 s",
                 lum_laser_is_on(ctl->status) ? "is up" : "may be up");
    }
    return status;
}

/* A plain heartbeat is done when it has ended, whatever the sensor says. */
static bool judges_hazards(const struct ctl *ctl)
{
    const struct ctl_options *o = &ctl->options;
    return o->owner.laser || o->repeat.every_s > 0.0 ||
           o->repeat.until != UNTIL_NOTHING;
}

static enum exit_status beat(struct ctl *ctl)
{
    const int64_t now = lum_time_monotonic_ns();
    struct beating b = {.ctl = ctl,
                        .shows_line = !ctl->options.quiet,
                        .begun_ns = now,
                        .shown_ns = now,
                        .begun.struct_size = sizeof b.begun};
    const struct watch watch = {.looks = true,
                                .period_ns = MONITOR_ASK_NS,
                                .wake_ns = &b.monitor.rows.due_ns,
                                .ask = ask,
                                .take = take,
                                .context = &b};
    lum_sensor_count(ctl->sensor, &b.begun);
    b.shown = b.begun;
    if (writable(stderr, 0)) {
        announce(ctl);
    }
    ctl->has_status = false;
    enum exit_status status = monitor_begin(&b.monitor, ctl, false);
    if (status == EXIT_DONE && ctl->options.owner.laser) {
        lum_laser_session_want(ctl->laser, LUM_WANT_ON, now);
    }
    status = status == EXIT_DONE ? watch_run(ctl, &watch) : status;
    clear_line(&b);
    status = conclude(&b, status);
    const enum exit_status seen = monitor_end(&b.monitor, status);
    sum_up(&b);
    return judges_hazards(ctl) || seen != EXIT_HAZARD ? seen : status;
}

enum exit_status command_heartbeat(struct ctl *ctl, int count, char **words)
{
    (void)count;
    (void)words;
    if (ctl->options.dry_run) {
        uint8_t packet[LUM_HEARTBEAT_BYTES];
        lum_heartbeat_encode(packet);
        return ctl_print_packet(ctl, packet, sizeof packet);
    }
    const enum exit_status opened = ctl_open(ctl, true);
    return opened == EXIT_DONE ? beat(ctl) : opened;
}
