#include "lum/net/live.h"

#include "base/go_on.h"
#include "base/sized.h"
#include "lum/base/time.h"
#include "lum/wire.h"

#include <stdlib.h>

#define NS_PER_MS INT64_C(1000000)

struct live {
    lum_live_options options;
    lum_sensor_event event; /* the last one */
    size_t next;            /* of its datagrams */
    int64_t end_ns;         /* of the stream; INT64_MAX: none */
    int64_t heard_ns;       /* when the sensor was last heard, or the start */
    int64_t told_ns;        /* when on_event last got data */
    bool was_heard;
    lum_endpoint sensor;
    lum_endpoint client;
    lum_go_on go_on;
};

/* The sensor's side is shown as the port that all sensors have, whatever port a
 * relay offers it at. */
static lum_record record_of(const struct live *l, const lum_received *datagram)
{
    return (lum_record){.time_ns = datagram->utc_ns,
                        .payload = datagram->bytes,
                        .len = datagram->len,
                        .source = l->sensor.address,
                        .destination = l->client.address,
                        .source_port = LUM_PORT,
                        .destination_port = l->client.port,
                        .kind = datagram->cut_short ? LUM_RECORD_CUT_SHORT
                                                    : LUM_RECORD_DATAGRAM};
}

static int64_t silent_ns(const struct live *l)
{
    return l->heard_ns + NS_PER_MS * (int64_t)l->options.silence_ms;
}

static int fail_silent(uint32_t ms, lum_error *error)
{
    return lum_error_set(error,
                         "nothing came from the sensor for %u ms; is it on, "
                         "connected, and at this address?",
                         (unsigned)ms);
}

/* 0: the stream is over. */
static int end(const struct live *l, lum_error *error)
{
    return l->was_heard ? 0 : fail_silent(l->options.duration_ms, error);
}

static int idle(const struct live *l, lum_error *error)
{
    const int64_t now_ns = lum_time_monotonic_ns();
    if (now_ns >= l->end_ns) {
        return end(l, error);
    }
    return now_ns < silent_ns(l) ? 1
                                 : fail_silent(l->options.silence_ms, error);
}

static int tell(const struct live *l)
{
    return l->options.on_event == NULL ||
           l->options.on_event(l->options.context, &l->event);
}

static int tell_data(struct live *l)
{
    const int64_t every_ns = NS_PER_MS * (int64_t)l->options.data_ms;
    if (every_ns == 0 || l->heard_ns - l->told_ns < every_ns) {
        return 1;
    }
    l->told_ns = l->heard_ns;
    return tell(l);
}

static int64_t earlier(int64_t a_ns, int64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

/* How long a receive may wait. */
static int64_t limit_of(const struct live *l)
{
    const int64_t limit_ns = earlier(silent_ns(l), l->end_ns);
    return l->go_on.function == NULL
               ? limit_ns
               : earlier(limit_ns, lum_time_monotonic_ns() +
                                       LUM_GO_ON_WAIT_MS * NS_PER_MS);
}

/* As lum_record_source.next, but for the record: 1 is to look again. */
static int receive(struct live *l, lum_error *error)
{
    lum_sensor_receive(l->options.sensor, limit_of(l), &l->event);
    l->next = 0;
    switch (l->event.kind) {
    case LUM_SENSOR_DATAGRAMS:
        l->heard_ns = lum_time_monotonic_ns();
        l->was_heard = true;
        return tell_data(l);
    case LUM_SENSOR_IDLE:
        return idle(l, error);
    case LUM_SENSOR_CANCELLED:
        return 0;
    case LUM_SENSOR_FAILED:
        return lum_error_set(error, "%s", l->event.error.text);
    case LUM_SENSOR_ANSWER:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_NO_ANSWER:
    case LUM_SENSOR_ALERT:
    case LUM_SENSOR_LINK:
    default:
        return tell(l);
    }
}

static bool has_datagram(const struct live *l)
{
    return l->event.kind == LUM_SENSOR_DATAGRAMS &&
           l->next < l->event.datagram_count;
}

/* The end is looked at here too: a sensor that sends without a pause would
 * otherwise never let the wait reach it. */
static int next(void *context, lum_record *out, lum_error *error)
{
    struct live *l = context;
    int status = 1;
    while (status > 0 && !has_datagram(l)) {
        if (!lum_go_on_ask(&l->go_on)) {
            return lum_go_on_fail(error);
        }
        status = lum_time_monotonic_ns() < l->end_ns ? receive(l, error)
                                                     : end(l, error);
    }
    if (status > 0) {
        *out = record_of(l, &l->event.datagrams[l->next++]);
    }
    return status;
}

static void set_go_on(void *context, bool (*go_on)(void *go_on_context),
                      void *go_on_context)
{
    struct live *l = context;
    l->go_on = (lum_go_on){.function = go_on, .context = go_on_context};
}

int lum_live_source(const lum_live_options *options, lum_record_source *out,
                    lum_error *error)
{
    const lum_record_source none = {.struct_size = sizeof none};
    lum_live_options known;
    if (lum_sized_take(&known, sizeof known, options,
                       "the live source's options", "lum_live_options",
                       error) != 0) {
        return -1;
    }
    if (known.sensor == NULL) {
        return lum_error_set(error,
                             "a live source needs the session of a sensor");
    }
    if (!lum_sized_fill(out, &none, sizeof none)) {
        return lum_error_set(error,
                             "struct_size of the source of records is not set; "
                             "set it to sizeof(lum_record_source)");
    }
    struct live *l = calloc(1, sizeof *l);
    if (l == NULL) {
        return lum_error_set(error, "out of memory");
    }
    l->options = known;
    if (l->options.silence_ms == 0) {
        l->options.silence_ms = LUM_SENSOR_SILENCE_MS;
    }
    l->heard_ns = lum_time_monotonic_ns();
    l->end_ns = l->options.duration_ms == 0
                    ? INT64_MAX
                    : l->heard_ns + NS_PER_MS * (int64_t)l->options.duration_ms;
    l->sensor = lum_sensor_endpoint(l->options.sensor);
    lum_socket_local(lum_sensor_socket(l->options.sensor), &l->client);
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next,
                                      .close = free,
                                      .context = l,
                                      .set_go_on = set_go_on};
    (void)lum_sized_fill(out, &source, sizeof source);
    return 0;
}
