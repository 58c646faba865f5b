#define _POSIX_C_SOURCE 200809L
#include "link.h"

#include "../common/heard.h"
#include "../common/laser_bits.h"
#include "../common/laser_end.h"
#include "../common/misfit.h"
#include "../common/number.h"
#include "../common/ring.h"
#include "lum/base/time.h"
#include "lum/wire.h"
#include "sentry.h"
#include "thread.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)

#define RING_BYTES (64u << 20)
#define TICK_NS    (SECOND_NS / 20)
#define COUNT_NS   (SECOND_NS / 10)

/* After a batch that was not full: more come together then, in fewer calls. */
#define REST_NS (SECOND_NS / 1000)

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
    pthread_t keeper; /* of the session */
    pthread_t maker;  /* of frames */

    /* the keeper's */
    lum_sensor *sensor; /* NULL: its socket broke */
    struct sentry sentry;
    int64_t tick_ns;
    uint64_t received;
    uint64_t bytes;
    uint64_t ring_drops;
    uint64_t kernel_drops; /* of sockets before */
    bool is_over;
    lum_error broken;
    lum_laser_off off;

    /* the maker's */
    int64_t count_ns;
};

/* --- The session and its thread --- */

static int open_session(struct link *l, bool owns, lum_error *error)
{
    lum_sensor_options options;
    lum_sensor_options_default(&options);
    options.sensor = l->options.address;
    options.interface_name = l->options.interface;
    options.layout = *l->options.decoder.layout;
    options.owns = owns;
    options.receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
    options.cancel = l->cancel;
    return lum_sensor_open(&options, &l->sensor, error) == LUM_NET_OK ? 0 : -1;
}

static void look_for_data(struct link *l, const lum_sensor_event *event,
                          int64_t now_ns)
{
    const struct heard heard = heard_in(event, l->options.decoder.layout);
    if (heard.has_data) {
        l->sentry.has_data = true;
        l->sentry.data_ns = now_ns;
    }
    l->sentry.has_unknown |= heard.has_unknown;
}

static void take_datagrams(struct link *l, const lum_sensor_event *event,
                           int64_t now_ns)
{
    for (size_t i = 0; i < event->datagram_count; i++) {
        const lum_received *d = &event->datagrams[i];
        const struct ring_item item = {.bytes = d->bytes,
                                       .len = d->len,
                                       .time_ns = d->utc_ns,
                                       .is_cut_short = d->cut_short};
        l->bytes += d->len;
        l->ring_drops += ring_put(l->ring, &item) ? 0u : 1u;
    }
    ring_publish(l->ring);
    l->received += event->datagram_count;
    look_for_data(l, event, now_ns);
}

static void take_event(struct link *l, const lum_sensor_event *event,
                       int64_t now_ns)
{
    switch (event->kind) {
    case LUM_SENSOR_DATAGRAMS:
        take_datagrams(l, event, now_ns);
        break;
    case LUM_SENSOR_CANCELLED:
        l->is_over = true;
        break;
    case LUM_SENSOR_FAILED:
        l->broken = event->error;
        break;
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_ANSWER:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_NO_ANSWER:
    case LUM_SENSOR_ALERT:
    case LUM_SENSOR_LINK:
    default:
        sentry_take(&l->sentry, event, now_ns);
        break;
    }
}

static void tell(struct link *l, int64_t now_ns)
{
    char message[LUM_ERROR_BYTES];
    lum_sensor_counters c = {.struct_size = sizeof c};
    enum feed_state state = l->sentry.has_data ? FEED_PLAYING : FEED_WAITING;
    if (sentry_is_silent(&l->sentry, now_ns)) {
        state = FEED_SILENT;
    }
    lum_sensor_count(l->sensor, &c);
    stage_set_received(l->stage, l->received, l->bytes,
                       l->kernel_drops + c.kernel_drops, l->ring_drops);
    stage_set_laser(l->stage,
                    l->sentry.laser.has_status && !l->sentry.is_unheard,
                    l->sentry.laser.status);
    stage_set_message(
        l->stage, sentry_message(&l->sentry, now_ns, message, sizeof message));
    stage_set_state(l->stage, state);
}

static void tick(struct link *l, int64_t now_ns)
{
    l->tick_ns = now_ns + TICK_NS;
    ring_wake(l->ring);
    sentry_tick(&l->sentry, now_ns);
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
    l->kernel_drops += c.kernel_drops;
    lum_sensor_close(l->sensor);
    l->sensor = NULL;
}

/* A broken socket is replaced as soon as possible. The laser went down without
 * heartbeats, and must stay down. */
static void mend(struct link *l)
{
    const bool had_laser = l->options.laser;
    const int64_t next_ns = lum_time_monotonic_ns() + REOPEN_NS;
    stage_set_message(l->stage, l->broken.text);
    stage_set_state(l->stage, FEED_FAILED);
    while (!lum_cancel_is_raised(l->cancel) &&
           lum_time_monotonic_ns() < next_ns) {
        lum_time_sleep_until(lum_time_monotonic_ns() + TICK_NS);
    }
    l->is_over = lum_cancel_is_raised(l->cancel);
    if (!l->is_over && open_session(l, true, &l->broken) == 0) {
        sentry_begin(&l->sentry, l->sensor,
                     had_laser ? LASER_DOWN : LASER_UNTOUCHED,
                     lum_time_monotonic_ns());
        l->broken.text[0] = '\0';
    }
}

/* A socket that broke sends nothing more, another may. */
static void switch_off(struct link *l)
{
    lum_error error = {""};
    char address[16];
    char name[40];
    l->off = LUM_LASER_OFF_SEEN;
    if (!l->options.laser) {
        return;
    }
    if (l->sensor == NULL && open_session(l, false, &error) != 0) {
        l->off = LUM_LASER_OFF_UNKNOWN;
        return;
    }
    lum_sensor_give_up(l->sensor);
    (void)snprintf(name, sizeof name, "lumview: udp://%s",
                   number_format_address(l->options.address.address, address));
    l->off = laser_end(l->sensor, name, &l->sentry.laser.status);
}

static void *keep(void *argument)
{
    struct link *l = argument;
    const int64_t now_ns = lum_time_monotonic_ns();
    l->tick_ns = now_ns;
    sentry_begin(&l->sentry, l->sensor,
                 l->options.laser ? LASER_ASKED : LASER_UNTOUCHED, now_ns);
    while (!l->is_over) {
        if (l->sensor == NULL) {
            mend(l);
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
                        .source = l->options.address.address,
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

/* What has been told stays. A recording needs the session. */
static void tell_doubt(struct link *l)
{
    char what[160];
    char source[40] = "udp://";
    char advice[MISFIT_ADVICE_BYTES + sizeof source];
    char text[sizeof what + sizeof advice + 24];
    if (decoder_misfit(l->decoder, what, sizeof what)) {
        (void)number_format_address(l->options.address.address,
                                    source + strlen(source));
        misfit_advise(source, NULL, advice, sizeof advice);
        (void)snprintf(text, sizeof text, "%s: end lumview, then %s", what,
                       advice);
        stage_set_doubt(l->stage, text);
    }
}

static void count(struct link *l)
{
    struct totals totals;
    decoder_count(l->decoder, &totals);
    stage_set_totals(l->stage, &totals);
    tell_doubt(l);
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
    if (thread_start(&l->keeper, keep, l, error) != 0) {
        ring_close(l->ring);
        (void)pthread_join(l->maker, NULL);
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
    char address[16];
    char now_at[16];
    char bits[200];
    (void)number_format_address(l->options.address.address, address);
    (void)laser_end_address(l->sensor, l->options.address, now_at);
    if (l->off == LUM_LASER_OFF_SEEN) {
        return 0;
    }
    if (l->off == LUM_LASER_OFF_UNKNOWN) {
        return lum_error_set(
            error,
            "udp://%s: laser off was not answered: a sensor that lives "
            "switches it off 3 s after the last heartbeat, which has been "
            "sent; make sure by lumctl --host %s laser off",
            address, now_at);
    }
    if (l->off == LUM_LASER_OFF_UNSEEN) {
        return lum_error_set(
            error,
            "udp://%s: laser off was answered without a status TLV, so nothing "
            "shows it off: tlv.status of the profile says %u; a sensor that "
            "lives switches it off 3 s after the last heartbeat, which has "
            "been sent",
            address,
            (unsigned)l->options.decoder.layout->profile.tlv[LUM_TLV_STATUS]);
    }
    (void)laser_bits_name(l->sentry.laser.status, UINT16_MAX, bits,
                          sizeof bits);
    return lum_error_set(error,
                         "udp://%s: %s (status: %s): lumctl --host %s laser "
                         "off, or cut its power",
                         address, laser_end_refused(l->sentry.laser.status),
                         bits, now_at);
}

int link_end(struct link *link, lum_error *error)
{
    if (link == NULL) {
        return 0;
    }
    lum_cancel_raise(link->cancel);
    (void)pthread_join(link->keeper, NULL);
    ring_close(link->ring);
    (void)pthread_join(link->maker, NULL);
    const int result = tell_laser(link, error);
    release(link);
    return result;
}
