#define _POSIX_C_SOURCE 200809L
#include "sensor_link.h"

#include "../common/laser_end.h"
#include "../common/number.h"
#include "../common/ring.h"
#include "base/text.h"
#include "lum/base/time.h"
#include "lum/wire.h"
#include "thread_monitor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

#define RING_BYTES (64u << 20)
#define TICK_NS    (SECOND_NS / 20)
#define COUNT_NS   (SECOND_NS / 10)

/* After a batch that was not full: more come together then, in fewer calls. */
#define REST_NS (SECOND_NS / 1000)

#define STANDING_MAX 3u

/* For so long news is shown that does not stand. */
#define SHOWN_NS (10 * SECOND_NS)

/* Between attempts to replace a socket that broke. */
#define REOPEN_NS SECOND_NS

/* Longest that a datagram can have been under way from the kernel. */
#define LAG_MAX_NS (10 * SECOND_NS)

/* Datagrams between looks at the clock. */
#define DATAGRAMS_A_LOOK 256u

struct link {
    struct link_options options;
    struct stage *stage;
    lum_cancel *cancel;
    struct ring *ring;
    struct decoder *decoder;
    struct thread *session_thread;
    struct thread *maker; /* of frames */

    /* the session thread's */
    lum_sensor *sensor;       /* NULL: its socket broke */
    lum_laser_session *laser; /* of the sensor */
    int64_t tick_ns;
    struct feed_received received;
    struct feed_dropped dropped; /* by the kernel: of sockets before */
    bool is_over;
    lum_error broken;
    lum_news end;  /* with which the laser was left */
    lum_news last; /* that does not stand, and when it came */
    int64_t last_ns;

    /* the maker's */
    int64_t count_ns;
};

/* --- The session and its thread --- */

static int open_session(struct link *l, bool owns, lum_error *error)
{
    lum_sensor_options options;
    lum_laser_session_options laser;
    lum_sensor_options_default(&options);
    options.sensor = l->options.live.address;
    options.interface_name = l->options.live.interface;
    options.layout = *l->options.decoder.layout;
    options.owns = owns;
    options.receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    options.cancel = l->cancel;
    if (lum_sensor_open(&options, &l->sensor, error) != LUM_NET_OK) {
        return -1;
    }
    lum_laser_session_options_default(&laser, &options);
    return l->laser != NULL
               ? 0
               : lum_laser_session_new(&laser, lum_time_monotonic_ns(),
                                       &l->laser, error);
}

static void take_datagrams(struct link *l, const lum_sensor_event *event)
{
    for (size_t i = 0; i < event->datagram_count; i++) {
        const lum_received *d = &event->datagrams[i];
        const struct ring_item item = {.bytes = d->bytes,
                                       .len = d->len,
                                       .time_ns = d->utc_ns,
                                       .is_cut_short = d->cut_short};
        l->received.bytes += d->len;
        l->dropped.ring += ring_put(l->ring, &item) ? 0u : 1u;
    }
    ring_publish(l->ring);
    l->received.packets += event->datagram_count;
}

static void take_event(struct link *l, const lum_sensor_event *event,
                       int64_t now_ns)
{
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        take_datagrams(l, event);
    }
    l->is_over = event->kind == LUM_SENSOR_CANCELLED;
    if (event->kind == LUM_SENSOR_FAILED) {
        l->broken = event->error;
    }
    lum_laser_session_take(l->laser, event, now_ns);
}

static void add_news(const lum_news *news, char *out, size_t room)
{
    char text[LUM_ERROR_BYTES];
    lum_text_list(out, room, "; ", lum_news_tell(news, text, sizeof text));
}

static bool is_among(const lum_news *news, const lum_news *all, size_t count)
{
    bool is_there = false;
    for (size_t i = 0; i < count; i++) {
        is_there |= all[i].kind == news->kind;
    }
    return is_there;
}

/* All that holds, and what happened last, as one message. */
static void make_message(const struct link *l, int64_t now_ns, char *out,
                         size_t room)
{
    lum_news all[STANDING_MAX] = {{.struct_size = sizeof all[0]}};
    const size_t count =
        lum_laser_session_standing(l->laser, now_ns, all, STANDING_MAX);
    *out = '\0';
    for (size_t i = 0; i < count; i++) {
        add_news(&all[i], out, room);
    }
    if (lum_news_weigh(l->last.kind) != LUM_NEWS_INFO &&
        now_ns - l->last_ns < SHOWN_NS && !is_among(&l->last, all, count)) {
        add_news(&l->last, out, room);
    }
}

static void tell(struct link *l, int64_t now_ns)
{
    char message[LUM_ERROR_BYTES];
    lum_news news = {.struct_size = sizeof news};
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(l->laser, &view);
    lum_sensor_count(l->sensor, &c);
    while (lum_laser_session_next(l->laser, &news)) {
        l->last = news;
        l->last_ns = now_ns;
    }
    const struct feed_dropped dropped = {l->dropped.kernel + c.kernel_drops,
                                         l->dropped.ring};
    stage_set_received(l->stage, &l->received, &dropped);
    stage_set_laser(l->stage, view.has_status && !view.is_unheard, view.status);
    make_message(l, now_ns, message, sizeof message);
    stage_set_text(l->stage, FEED_MESSAGE, message);
    stage_set_state(l->stage, view.is_silent  ? FEED_SILENT
                              : view.has_data ? FEED_PLAYING
                                              : FEED_WAITING);
}

static void tick(struct link *l, int64_t now_ns)
{
    l->tick_ns = now_ns + TICK_NS;
    ring_wake(l->ring);
    lum_laser_session_serve(l->laser, l->sensor, now_ns);
    tell(l, now_ns);
}

static void step(struct link *l)
{
    lum_sensor_event event;
    lum_sensor_receive(l->sensor, l->tick_ns, &event);
    const int64_t now_ns = lum_time_monotonic_ns();
    take_event(l, &event, now_ns);
    if (l->is_over || event.kind == LUM_SENSOR_FAILED) {
        return;
    }
    if (now_ns >= l->tick_ns) {
        tick(l, now_ns);
    }
    if (event.kind == LUM_SENSOR_DATAGRAMS &&
        event.datagram_count < LUM_SOCKET_BATCH) {
        lum_time_sleep_until(now_ns + REST_NS);
    }
}

static void close_broken(struct link *l)
{
    lum_sensor_counters c = {.struct_size = sizeof c};
    lum_sensor_count(l->sensor, &c);
    l->dropped.kernel += c.kernel_drops;
    lum_sensor_close(l->sensor);
    l->sensor = NULL;
}

/* A broken socket is replaced as soon as possible. The laser went down without
 * heartbeats, and must stay down. */
static void replace_socket(struct link *l)
{
    const int64_t next_ns = lum_time_monotonic_ns() + REOPEN_NS;
    stage_set_text(l->stage, FEED_MESSAGE, l->broken.text);
    stage_set_state(l->stage, FEED_FAILED);
    while (!lum_cancel_is_raised(l->cancel) &&
           lum_time_monotonic_ns() < next_ns) {
        lum_time_sleep_until(lum_time_monotonic_ns() + TICK_NS);
    }
    l->is_over = lum_cancel_is_raised(l->cancel);
    if (!l->is_over && open_session(l, true, &l->broken) == 0) {
        lum_laser_session_want(
            l->laser, l->options.live.laser ? LUM_WANT_OFF : LUM_WANT_LOOK,
            lum_time_monotonic_ns());
        l->broken.text[0] = '\0';
    }
}

/* A socket that broke sends nothing more, another may. */
static void switch_off(struct link *l)
{
    lum_error error = {""};
    if (l->options.live.laser) {
        if (l->sensor == NULL) {
            (void)open_session(l, false, &error);
        }
        (void)laser_end(l->laser, l->sensor, "lumview", &l->end);
    }
}

static void *keep(void *argument)
{
    struct link *l = argument;
    const int64_t now_ns = lum_time_monotonic_ns();
    l->tick_ns = now_ns;
    lum_laser_session_want(
        l->laser, l->options.live.laser ? LUM_WANT_ON : LUM_WANT_LOOK, now_ns);
    while (!l->is_over) {
        if (l->sensor == NULL) {
            replace_socket(l);
        } else {
            step(l);
        }
        if (l->sensor != NULL && l->broken.text[0] != '\0') {
            close_broken(l);
        }
    }
    switch_off(l);
    return NULL;
}

/* --- Decoding and its thread --- */

/* In captures the sensor's side always has the port of all sensors, because
 * readers find it by that port, even if a relay uses another one. */
static lum_record record_of(const struct link *l, const struct ring_item *item)
{
    return (lum_record){.time_ns = item->time_ns,
                        .payload = item->bytes,
                        .len = item->len,
                        .source = l->options.live.address.address,
                        .source_port = LUM_PORT,
                        .kind = item->is_cut_short ? LUM_RECORD_CUT_SHORT
                                                   : LUM_RECORD_DATAGRAM};
}

/* A frame is complete when the datagram that shows it came. */
static int64_t completion_ns(const struct ring_item *item)
{
    const int64_t lag_ns = lum_time_utc_ns() - item->time_ns;
    return lum_time_monotonic_ns() -
           (lag_ns > 0 && lag_ns < LAG_MAX_NS ? lag_ns : 0);
}

static void count(struct link *l)
{
    struct totals totals;
    char source[40] = "udp://";
    (void)number_format_address(l->options.live.address.address,
                                source + strlen(source));
    decoder_count(l->decoder, &totals);
    stage_set_totals(l->stage, &totals);
    decoder_tell_doubt(l->decoder, NULL, source);
}

static bool take(struct link *l, const struct ring_item *item)
{
    const lum_record record = record_of(l, item);
    enum decoded decoded = DECODED_ALL;
    while ((decoded = decoder_push(l->decoder, &record)) == DECODED_FRAME) {
        count(l);
        stage_show(l->stage, decoder_picture(l->decoder), completion_ns(item));
    }
    return decoded == DECODED_ALL;
}

static bool work_off(struct link *l)
{
    struct ring_item item;
    bool goes_on = true;
    while (goes_on && ring_next(l->ring, &item)) {
        goes_on = take(l, &item);
    }
    const int64_t now_ns = lum_time_monotonic_ns();
    if (now_ns - l->count_ns >= COUNT_NS) {
        l->count_ns = now_ns;
        count(l);
    }
    return goes_on;
}

/* Without memory for a frame all ends, in good order. */
static void *make(void *argument)
{
    struct link *l = argument;
    bool goes_on = true;
    while (ring_take(l->ring)) {
        if (goes_on && !work_off(l)) {
            goes_on = false;
            stage_fail(l->stage, "out of memory");
            lum_cancel_raise(l->cancel);
        }
    }
    return NULL;
}

/* --- Starting and ending --- */

static void release(struct link *l)
{
    lum_laser_session_free(l->laser);
    lum_sensor_close(l->sensor);
    decoder_free(l->decoder);
    ring_free(l->ring);
    lum_cancel_free(l->cancel);
    free(l);
}

static int open_all(struct link *l, lum_error *error)
{
    if (lum_cancel_new(&l->cancel, error) != 0 ||
        open_session(l, true, error) != 0) {
        return -1;
    }
    l->ring = ring_new(RING_BYTES);
    l->decoder = decoder_new(&l->options.decoder);
    return l->ring != NULL && l->decoder != NULL
               ? 0
               : lum_error_set(error, "out of memory");
}

static int start_threads(struct link *l, lum_error *error)
{
    if (thread_start(&l->maker, make, l, error) != 0) {
        return -1;
    }
    if (thread_start(&l->session_thread, keep, l, error) != 0) {
        ring_close(l->ring);
        thread_join(l->maker);
        return -1;
    }
    return 0;
}

int link_start(const struct link_options *options, struct link **out,
               lum_error *error)
{
    struct link *l = calloc(1, sizeof *l);
    if (l == NULL) {
        return lum_error_set(error, "out of memory");
    }
    l->options = *options;
    l->stage = options->decoder.stage;
    if (open_all(l, error) != 0 || start_threads(l, error) != 0) {
        release(l);
        return -1;
    }
    *out = l;
    return 0;
}

/* What became of the laser. */
static int tell_laser(const struct link *l, lum_error *error)
{
    char text[LUM_ERROR_BYTES];
    return lum_news_weigh(l->end.kind) == LUM_NEWS_INFO
               ? 0
               : lum_error_set(error, "%s",
                               lum_news_tell(&l->end, text, sizeof text));
}

int link_end(struct link *link, lum_error *error)
{
    if (link == NULL) {
        return 0;
    }
    lum_cancel_raise(link->cancel);
    thread_join(link->session_thread);
    ring_close(link->ring);
    thread_join(link->maker);
    const int result = tell_laser(link, error);
    release(link);
    return result;
}
