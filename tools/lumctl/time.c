/* The command time: the sensor's clock against this host's. */
#include "ctl.h"

#include "ctl_session.h"
#include "status_report.h"
#include "watch.h"

#include "lum/base/time.h"
#include "lum/host/clock_sync.h"

#include <inttypes.h>
#include <stdio.h>

#define EXCHANGES 8
#define APART_NS  INT64_C(10000000)
#define PERIOD_NS INT64_C(1000000000)
#define NS_PER_S  INT64_C(1000000000)

struct timing {
    struct ctl *ctl;
    lum_clock_sync sync;
    int64_t round_trip_ns; /* of the last exchange */
    int64_t least_ns;      /* round trip */
    int64_t most_ns;
    bool has_any;
    bool is_silent;
    uint32_t resets; /* printed so far */
};

static void add(struct timing *t, const lum_sensor_event *event)
{
    const int64_t trip = event->received_ns - event->sent_ns;
    if (lum_clock_sync_add(&t->sync, event->sent_ns, event->received_ns,
                           event->clock_us) != LUM_OK) {
        return;
    }
    t->round_trip_ns = trip;
    t->least_ns = !t->has_any || trip < t->least_ns ? trip : t->least_ns;
    t->most_ns = !t->has_any || trip > t->most_ns ? trip : t->most_ns;
    t->has_any = true;
}

/* Host less sensor by the calendar's clock. */
static int64_t utc_offset(const lum_clock_estimate *e)
{
    return e->offset_ns + (lum_time_utc_ns() - lum_time_monotonic_ns());
}

struct span {
    char text[40];
};

/* 0:12:34.567890 */
static struct span clock_text(int64_t us)
{
    struct span out;
    const int64_t s = us / 1000000;
    (void)snprintf(out.text, sizeof out.text, "%" PRId64 ":%02d:%02d.%06d",
                   s / 3600, (int)(s / 60 % 60), (int)(s % 60),
                   (int)(us % 1000000));
    return out;
}

/* 182 us, or 12.3 ms */
static struct span span_text(int64_t ns)
{
    struct span out;
    if (ns < 1000000) {
        (void)snprintf(out.text, sizeof out.text, "%.0f us", (double)ns / 1e3);
    } else {
        (void)snprintf(out.text, sizeof out.text, "%.2f ms", (double)ns / 1e6);
    }
    return out;
}

static struct span drift_text(const lum_clock_estimate *e)
{
    struct span out;
    if (e->has_drift) {
        (void)snprintf(out.text, sizeof out.text, "%+.3f +-%.3f ppm",
                       (double)e->drift_ppb / 1e3,
                       (double)e->drift_error_ppb / 1e3);
    } else {
        (void)snprintf(out.text, sizeof out.text, "not known yet");
    }
    return out;
}

static void put_json(const struct timing *t, const lum_clock_estimate *e)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "time", report_utc(lum_time_utc_ns()).text);
    json_text(&json, "sensor", session_name(session_host(t->ctl)).text);
    json_int(&json, "clock_us", e->clock_us);
    json_int(&json, "offset_ns", utc_offset(e));
    json_int(&json, "error_ns", e->error_ns);
    json_real(&json, "round_trip_ms", (double)t->round_trip_ns / 1e6, 3);
    json_real(&json, "round_trip_min_ms", (double)t->least_ns / 1e6, 3);
    json_real(&json, "round_trip_max_ms", (double)t->most_ns / 1e6, 3);
    if (e->has_drift) {
        json_int(&json, "drift_ppb", e->drift_ppb);
        json_int(&json, "drift_error_ppb", e->drift_error_ppb);
    } else {
        json_null(&json, "drift_ppb");
        json_null(&json, "drift_error_ppb");
    }
    json_uint(&json, "exchanges", e->exchanges);
    json_uint(&json, "resets", e->resets);
    json_end_line(&json);
}

static void put_all(const struct timing *t, const lum_clock_estimate *e)
{
    (void)printf("%s: clock %s\n", session_name(session_host(t->ctl)).text,
                 clock_text(e->clock_us).text);
    (void)printf("  was 0 at    %s by this host's clock, +-%s\n",
                 report_utc(utc_offset(e)).text, span_text(e->error_ns).text);
    (void)printf("  round trip  %s to %s, %u exchanges\n",
                 span_text(t->least_ns).text, span_text(t->most_ns).text,
                 (unsigned)e->exchanges);
    (void)printf("  drift       %s%s\n", drift_text(e).text,
                 e->has_drift ? "" : ": lumctl time --watch measures it");
    (void)puts("  It counts from boot and returns to 0 every 71.6 minutes.");
}

static void put_line(const struct timing *t, const lum_clock_estimate *e)
{
    const int64_t offset = utc_offset(e);
    (void)printf("%s  clock %s  offset %" PRId64 ".%06d s +-%s  round trip %s  "
                 "drift %s\n",
                 report_utc(lum_time_utc_ns()).text,
                 clock_text(e->clock_us).text, offset / NS_PER_S,
                 (int)(offset % NS_PER_S / 1000), span_text(e->error_ns).text,
                 span_text(t->round_trip_ns).text, drift_text(e).text);
}

static bool show_line(struct timing *t)
{
    lum_clock_estimate e;
    if (lum_clock_sync_estimate(&t->sync, &e) != LUM_OK) {
        return true;
    }
    if (e.resets != t->resets) {
        ctl_note(t->ctl, "the sensor's clock started again: it has restarted");
        t->resets = e.resets;
    }
    if (t->ctl->options.json) {
        put_json(t, &e);
    } else {
        put_line(t, &e);
    }
    return report_flush();
}

static void note_silence(struct timing *t)
{
    if (!t->is_silent) {
        t->is_silent = true;
        ctl_note(t->ctl, "%s does not answer",
                 session_name(session_host(t->ctl)).text);
    }
}

static bool take(void *context, const lum_sensor_event *event)
{
    struct timing *t = context;
    if (event->kind == LUM_SENSOR_TIME) {
        t->is_silent = false;
        add(t, event);
        return show_line(t);
    }
    if (event->kind == LUM_SENSOR_NO_ANSWER) {
        note_silence(t);
    }
    return true;
}

static lum_result ask(struct ctl *ctl, void *context)
{
    (void)context;
    return session_request_time(ctl);
}

static enum exit_status watch(struct timing *t)
{
    const struct watch watch = {
        .period_ns = PERIOD_NS, .ask = ask, .take = take, .context = t};
    const enum exit_status status = watch_run(t->ctl, &watch);
    if (status == EXIT_DONE && (t->is_silent || !t->has_any) &&
        !lum_cancel_is_raised(t->ctl->cancel)) {
        return session_complain_silence(t->ctl, 0);
    }
    return status;
}

static enum exit_status exchange(struct timing *t)
{
    lum_sensor_event event;
    if (session_request_time(t->ctl) != LUM_OK) {
        return ctl_complain(EXIT_FAILED, "the request cannot be made");
    }
    const enum exit_status status = session_finish(t->ctl, &event);
    if (status == EXIT_DONE) {
        add(t, &event);
    }
    return status;
}

static enum exit_status measure(struct timing *t)
{
    lum_clock_estimate e;
    for (int i = 0; i < EXCHANGES; i++) {
        const enum exit_status status = exchange(t);
        if (status != EXIT_DONE) {
            return status;
        }
        session_rest(t->ctl, APART_NS);
    }
    if (lum_clock_sync_estimate(&t->sync, &e) != LUM_OK) {
        return ctl_complain(EXIT_FAILED,
                            "the times in the answers contradict each other");
    }
    if (t->ctl->options.json) {
        put_json(t, &e);
    } else {
        put_all(t, &e);
    }
    return EXIT_DONE;
}

enum exit_status command_time(struct ctl *ctl, int count, char **words)
{
    struct timing t = {.ctl = ctl};
    (void)count;
    (void)words;
    if (ctl->options.dry_run) {
        const lum_timestamp request = {ctl->options.requests.sequence, 0};
        uint8_t packet[LUM_TIMESTAMP_BYTES];
        lum_timestamp_encode(packet, &request);
        return ctl_print_packet(ctl, packet, sizeof packet);
    }
    const enum exit_status opened = ctl_open(ctl, false);
    if (opened != EXIT_DONE) {
        return opened;
    }
    lum_clock_sync_init(&t.sync);
    return ctl->options.repeat.watch ? watch(&t) : measure(&t);
}
