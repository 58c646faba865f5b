/* The command status: once, or again and again. */
#include "monitor.h"

#include "../common/terminal.h"
#include "ctl_session.h"
#include "status_report.h"

#include "lum/base/time.h"
#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <stdio.h>

#define POLL_NS INT64_C(500000000)

static void log_json(const char *when, const char *name, bool has_status,
                     uint16_t status, bool is_owned)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "time", when);
    json_text(&json, "sensor", name);
    json_bool(&json, "answers", has_status);
    if (has_status) {
        report_json(&json, status, is_owned);
    }
    json_end_line(&json);
}

bool status_log(const struct ctl *ctl, bool was_up, bool has_status,
                uint16_t status)
{
    const struct session_name name = session_name(session_host(ctl));
    const struct report_utc when = report_utc(lum_time_utc_ns());
    const bool is_owned = has_status && session_is_owned(ctl, status);
    if (ctl->options.json) {
        log_json(when.text, name.text, has_status, status, is_owned);
    } else {
        (void)printf("%s %s: %s%s\n", when.text, name.text,
                     has_status ? report_line(status, is_owned).text
                                : "does not answer",
                     has_status ? report_cause(status, was_up) : "");
    }
    return report_flush();
}

struct watching {
    struct ctl *ctl;
    struct monitor monitor;
    bool redraws;
    bool has_shown;
    bool is_silent;
    uint16_t status;
};

/* Whose heartbeats do not come. */
static void print_owner(const struct ctl *ctl)
{
    lum_error who = {""};
    if (!ctl->owns &&
        lum_sensor_is_owned(session_host(ctl), ctl->options.interface, &who)) {
        (void)printf("  %s\n", who.text);
    }
}

static void print_status(const struct ctl *ctl, uint16_t status, bool is_owned,
                         int64_t round_trip_ns)
{
    (void)printf("%s: laser %s%s, status 0x%04x",
                 session_name(session_host(ctl)).text,
                 lum_laser_status_name(status), report_aside(status, is_owned),
                 (unsigned)status);
    if (round_trip_ns > 0) {
        (void)printf(", round trip %.2f ms", (double)round_trip_ns / 1e6);
    }
    (void)putchar('\n');
    if (!lum_laser_is_down(status) && !lum_laser_is_on(status)) {
        (void)puts("  nothing keeps the laser down, and TLV_CMD_ON does not "
                   "show it on");
    }
    report_status(stdout, status, is_owned, report_may_colour(stdout));
    if (!is_owned && *report_cause(status, false) != '\0') {
        (void)printf("  laser on is in effect%s\n",
                     report_cause(status, false));
    }
    if (is_owned) {
        print_owner(ctl);
    }
}

static bool redraw(const struct watching *w)
{
    (void)printf("\033[H\033[J%s  Ctrl-C ends\n",
                 report_utc(lum_time_utc_ns()).text);
    if (!w->monitor.answers) {
        (void)printf("%s: does not answer\n",
                     session_name(session_host(w->ctl)).text);
    } else {
        print_status(w->ctl, w->status, session_is_owned(w->ctl, w->status),
                     w->monitor.round_trip_ns);
    }
    return report_flush();
}

static bool show(struct watching *w)
{
    const bool is_silent = !w->monitor.answers;
    const uint16_t status = w->monitor.status;
    const bool was_up =
        w->has_shown && !w->is_silent && lum_laser_is_on(w->status);
    const bool is_news =
        !w->has_shown || w->is_silent != is_silent || w->status != status;
    w->has_shown = true;
    w->is_silent = is_silent;
    w->status = status;
    if (w->redraws && terminal_is_foreground(stdout)) {
        return redraw(w);
    }
    return !is_news || status_log(w->ctl, was_up, !is_silent, status);
}

static bool show_change(struct watching *w, const lum_sensor_event *event)
{
    if (event->has_status) {
        w->ctl->has_status = true;
        w->ctl->status = event->status;
    }
    return (!event->has_status && event->kind != LUM_SENSOR_NO_ANSWER) ||
           show(w);
}

static bool take(void *context, const lum_sensor_event *event)
{
    struct watching *w = context;
    const bool goes_on =
        monitor_take(&w->monitor, event) &&
        (!w->ctl->options.repeat.watch || show_change(w, event));
    return goes_on && !monitor_is_met(&w->monitor);
}

static lum_result ask(struct ctl *ctl, void *context)
{
    struct watching *w = context;
    return monitor_ask(ctl, &w->monitor);
}

/* With what it ends, but for hazards. */
static enum exit_status conclude(struct watching *w)
{
    struct ctl *ctl = w->ctl;
    if (w->monitor.answers || lum_cancel_is_raised(ctl->cancel)) {
        return EXIT_DONE;
    }
    if (ctl->options.repeat.watch && !w->has_shown) {
        (void)show(w);
    }
    return session_complain_silence(ctl, 0);
}

/* --watch, --every. */
static enum exit_status watch(struct ctl *ctl)
{
    struct watching w = {.ctl = ctl,
                         .redraws =
                             !ctl->options.json && report_is_terminal(stdout)};
    const struct watch watch = {.period_ns = POLL_NS,
                                .wake_ns = &w.monitor.rows.due_ns,
                                .ask = ask,
                                .take = take,
                                .context = &w};
    enum exit_status status = ctl_open(ctl, false);
    status =
        status == EXIT_DONE ? monitor_begin(&w.monitor, ctl, true) : status;
    if (status != EXIT_DONE) {
        return status;
    }
    status = watch_run(ctl, &watch);
    return monitor_end(&w.monitor, status == EXIT_DONE ? conclude(&w) : status);
}

static void print_json(const struct ctl *ctl, const struct ctl_answer *answer,
                       bool is_owned)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", session_name(session_host(ctl)).text);
    report_json(&json, answer->status, is_owned);
    report_json_lines(&json, "debug", answer->debug);
    json_uint(&json, "tries", answer->tries);
    report_json_trip(&json, answer->round_trip_ns);
    json_end_line(&json);
}

enum exit_status command_status(struct ctl *ctl, int count, char **words)
{
    struct ctl_answer answer;
    bool was_sent = false;
    (void)count;
    (void)words;
    if ((ctl->options.repeat.watch || ctl->options.repeat.every_s > 0.0) &&
        !ctl->options.dry_run) {
        return watch(ctl);
    }
    const enum exit_status status =
        ctl_request(ctl, NULL, 0, &answer, &was_sent);
    if (status != EXIT_DONE || !was_sent) {
        return status;
    }
    if (!answer.has_status) {
        return ctl_complain(EXIT_FAILED,
                            "the answer had no status; if this sensor's number "
                            "of it differs, write it in a profile (tlv: "
                            "{status: N}); lumctl tlv shows what it sends");
    }
    const bool is_owned = session_is_owned(ctl, answer.status);
    if (ctl->options.json) {
        print_json(ctl, &answer, is_owned);
    } else {
        print_status(ctl, answer.status, is_owned, answer.round_trip_ns);
        report_debug(stdout, answer.debug);
    }
    return report_has_hazard(answer.status, is_owned) ? EXIT_HAZARD : EXIT_DONE;
}
