#include "receiving.h"

#include "../common/interrupt.h"
#include "../common/number.h"
#include "lum/base/time.h"
#include "lum/host/laser_name.h"

#include <inttypes.h>
#include <stdio.h>

#define SECOND_NS INT64_C(1000000000)

#define TICK_NS       (SECOND_NS / 20)
#define STATUS_NS     (SECOND_NS / 2)
#define FIRST_DATA_NS (5 * SECOND_NS) /* longest wait for the first data */

/* After a batch that was not full: more come together then, in fewer calls. */
#define REST_NS (SECOND_NS / 1000)

/* Longest that is spent on what waits in the kernel at the end. */
#define DRAIN_NS (SECOND_NS / 2)

lum_laser_session_view session_look(const struct session *session)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(session->laser, &view);
    return view;
}

/* Before the first data the run says itself what is missing. */
static bool is_told(lum_news_kind kind, bool has_data)
{
    const bool is_missing =
        kind == LUM_NEWS_NO_ANSWER ||
        (kind >= LUM_NEWS_NO_ANSWER_YET && kind <= LUM_NEWS_UNKNOWN_LAYOUT);
    return lum_news_weigh(kind) != LUM_NEWS_INFO && (!is_missing || has_data);
}

static void tell_news(struct session *s)
{
    lum_news news = {.struct_size = sizeof news};
    while (lum_laser_session_next(s->laser, &news)) {
        char text[LUM_ERROR_BYTES];
        if (is_told(news.kind, session_look(s).has_data)) {
            const bool is_error = lum_news_weigh(news.kind) == LUM_NEWS_ERROR;
            (is_error ? say_error : say_warn)(
                &s->say, "%s%s", lum_news_tell(&news, text, sizeof text),
                lum_news_is_dark(news.kind) ? "; the recording continues" : "");
        }
    }
}

void session_darkness(const struct session *session, char *out, size_t room)
{
    lum_news news = {.struct_size = sizeof news};
    if (lum_laser_session_darkness(session->laser, &news)) {
        (void)lum_news_tell(&news, out, room);
    }
}

/* Answers wait in the buffers until data comes: without any, nothing is
 * written, and no recording gets its name. */
static void take_datagrams(struct session *s, const lum_sensor_event *event,
                           int64_t now_ns)
{
    const bool had_data = session_look(s).has_data;
    for (size_t i = 0; i < event->datagram_count; i++) {
        const lum_received *d = &event->datagrams[i];
        const struct ring_item item = {.bytes = d->bytes,
                                       .len = d->len,
                                       .time_ns = d->utc_ns,
                                       .is_cut_short = d->cut_short};
        s->bytes += d->len;
        lanes_put(s->lanes, &item);
    }
    s->received += event->datagram_count;
    lum_laser_session_take(s->laser, event, now_ns);
    const lum_laser_session_view view = session_look(s);
    if (view.has_data && !had_data && s->options->choice.duration_ns != 0) {
        s->end_ns = now_ns + s->options->choice.duration_ns;
    }
    if (view.has_data || view.has_unknown) {
        lanes_publish(s->lanes);
    }
}

static void take_event(struct session *s, const lum_sensor_event *event,
                       int64_t now_ns)
{
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        take_datagrams(s, event, now_ns);
    } else if (event->kind == LUM_SENSOR_CANCELLED) {
        s->end = interrupt_signal() != 0 ? SESSION_SIGNAL : SESSION_GOES_ON;
    } else if (event->kind == LUM_SENSOR_FAILED) {
        s->error = event->error;
        s->end = SESSION_BROKEN;
    } else {
        lum_laser_session_take(s->laser, event, now_ns);
    }
}

struct cause {
    char text[120];
};

/* Why a receive buffer may have been full. */
static struct cause name_cause(const struct session *s)
{
    struct cause out = {"; this machine is too busy"};
    if (!lum_socket_has_room(lum_sensor_socket(s->sensor))) {
        (void)snprintf(out.text, sizeof out.text,
                       ", and is smaller than was asked for: sysctl -w "
                       "net.core.rmem_max=%lu",
                       (unsigned long)s->options->live.receive_buffer);
    }
    return out;
}

static void tell_drops(struct session *s, const lum_sensor_counters *c,
                       int64_t now_ns)
{
    if (say_is_due(&s->told_kernel, c->kernel_drops, now_ns)) {
        say_warn(&s->say,
                 "the system dropped %s%" PRIu64
                 " datagrams so far: they came damaged, with wrong checksums, "
                 "or its receive buffer was full%s",
                 c->joined > 0 ? "at least " : "", c->kernel_drops,
                 name_cause(s).text);
    }
}

static double rate(uint64_t before, uint64_t now, double seconds)
{
    return seconds > 0.0 ? (double)(now - before) / seconds : 0.0;
}

/* At most four characters, so that the line stays short. */
static const char *brief(uint64_t n, char out[24])
{
    static const char units[] = "kMGTPE";
    if (n < 10000) {
        (void)snprintf(out, 24, "%" PRIu64, n);
        return out;
    }
    size_t unit = 0;
    for (n /= 1000; n >= 1000; n /= 1000) {
        unit++;
    }
    (void)snprintf(out, 24, "%" PRIu64 "%c", n, units[unit]);
    return out;
}

/* Rates between two moments, totals of the later. The most important comes
 * first: a narrow terminal cuts the rest. */
static void format_status(const struct status_totals *before,
                          const struct status_totals *now, int64_t began_ns,
                          const char *laser, char *out, size_t room)
{
    const double seconds = (double)(now->time_ns - before->time_ns) * 1e-9;
    const double elapsed = (double)(now->time_ns - began_ns) * 1e-9;
    char n[5][24];
    (void)snprintf(
        out, room,
        "%.2f Mpt/s  lost: wire %sw %sl, kernel %s, ring %s, bad %s  laser %s  "
        "buf %u%%  %.1f s  %.0f packets/s %.1f Mbit/s",
        rate(before->points, now->points, seconds) * 1e-6,
        brief(now->lost_words, n[0]), brief(now->lost_lines, n[1]),
        brief(now->kernel_drops, n[2]), brief(now->ring_drops, n[3]),
        brief(now->refused, n[4]), laser, now->buffer_used, elapsed,
        rate(before->datagrams, now->datagrams, seconds),
        rate(before->bytes, now->bytes, seconds) * 8e-6);
}

static void show_status(struct session *s, const lum_sensor_counters *c,
                        int64_t now_ns)
{
    char line[400];
    const struct lane_view view = s->lanes->summary->view;
    const lum_laser_session_view sensor = session_look(s);
    const struct status_totals now = {.time_ns = now_ns,
                                      .datagrams = s->received,
                                      .bytes = s->bytes,
                                      .points = view.points,
                                      .lost_words = view.lost_words,
                                      .lost_lines = view.lost_lines,
                                      .kernel_drops = c->kernel_drops,
                                      .ring_drops = lanes_dropped(s->lanes),
                                      .refused = view.refused,
                                      .buffer_used = lanes_level(s->lanes)};
    if (sensor.has_data) {
        format_status(&s->before, &now, sensor.first_data_ns,
                      sensor.has_status ? lum_laser_status_name(sensor.status)
                                        : "?",
                      line, sizeof line);
    } else {
        (void)snprintf(
            line, sizeof line, "waiting for data from %s",
            number_address(lum_sensor_endpoint(s->sensor).address).text);
    }
    s->before = now;
    say_status(&s->say, line);
}

/* Since the tick before. */
static void note_dark(struct session *s, int64_t now_ns)
{
    const lum_laser_session_view view = session_look(s);
    if (view.has_data && view.laser != LUM_LASER_UP) {
        s->dark_ns += now_ns - (s->tick_ns - TICK_NS);
    }
}

static void tick(struct session *s, int64_t now_ns)
{
    lum_sensor_counters counters = {.struct_size = sizeof counters};
    note_dark(s, now_ns);
    s->tick_ns = now_ns + TICK_NS;
    lanes_wake(s->lanes);
    say_flush(&s->say);
    lum_laser_session_serve(s->laser, s->sensor, now_ns);
    tell_news(s);
    lum_sensor_count(s->sensor, &counters);
    tell_drops(s, &counters, now_ns);
    if (now_ns >= s->status_ns && say_has_status(&s->say)) {
        s->status_ns = now_ns + STATUS_NS;
        show_status(s, &counters, now_ns);
    }
    if (!session_look(s).has_data && now_ns - s->began_ns >= FIRST_DATA_NS) {
        s->end = SESSION_NO_DATA;
    }
    if (!lanes_watch(s->lanes, &s->say, now_ns)) {
        s->end = SESSION_OUTPUT;
    } else if (s->lanes->summary->view.has_all) {
        s->end = SESSION_DURATION;
    }
}

static void step(struct session *s)
{
    lum_sensor_event event;
    const int64_t deadline_ns = s->tick_ns < s->end_ns ? s->tick_ns : s->end_ns;
    lum_sensor_receive(s->sensor, deadline_ns, &event);
    const int64_t now_ns = lum_time_monotonic_ns();
    take_event(s, &event, now_ns);
    if (s->end != SESSION_GOES_ON) {
        return;
    }
    if (now_ns >= s->tick_ns) {
        tick(s, now_ns);
    }
    if (now_ns >= s->end_ns) {
        s->end = SESSION_DURATION;
    } else if (event.kind == LUM_SENSOR_DATAGRAMS &&
               event.datagram_count < LUM_SOCKET_BATCH) {
        lum_time_sleep_until(now_ns + REST_NS);
    }
}

void session_run(struct session *session)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    session->began_ns = now_ns;
    session->tick_ns = now_ns;
    session->status_ns = now_ns;
    session->end_ns = INT64_MAX;
    session->before = (struct status_totals){.time_ns = now_ns};
    say_init(&session->say, session->options->quiet);
    lum_laser_session_want(session->laser,
                           session->options->live.laser    ? LUM_WANT_ON
                           : session->options->live.guards ? LUM_WANT_GUARD
                                                           : LUM_WANT_LOOK,
                           now_ns);
    while (session->end == SESSION_GOES_ON) {
        step(session);
    }
    session->ended_ns = lum_time_monotonic_ns();
}

void session_drain(struct session *session, lum_cancel *cancel)
{
    const int64_t ended_utc_ns = lum_time_utc_ns();
    const int64_t end_ns = lum_time_monotonic_ns() + DRAIN_NS;
    int64_t now_ns = 0;
    lum_sensor_event event;
    do {
        lum_cancel_reset(cancel); /* also of a signal that comes meanwhile */
        lum_sensor_receive(session->sensor, 0, &event);
        now_ns = lum_time_monotonic_ns();
        if (event.kind == LUM_SENSOR_DATAGRAMS) {
            take_datagrams(session, &event, now_ns);
            if (event.datagrams[event.datagram_count - 1].utc_ns >=
                ended_utc_ns) {
                return;
            }
        }
    } while (event.kind != LUM_SENSOR_IDLE && event.kind != LUM_SENSOR_FAILED &&
             now_ns < end_ns);
}
