/* A sensor with its laser on for five seconds, and what is to be said of both.
 * own_laser ADDRESS. Needs lumsdk::live. */
#include "lum/base/time.h"
#include "lum/live/laser_session.h"
#include "lum/net/resolve.h"

#include <signal.h>
#include <stdio.h>

#define RUN_NS   (5 * INT64_C(1000000000))
#define SERVE_NS (INT64_C(50) * 1000000)

static volatile sig_atomic_t is_over;

static void on_signal(int number)
{
    (void)number;
    is_over = 1;
}

/* Whether the laser was as it was asked to be. */
static bool tell(lum_laser_session *laser)
{
    lum_news news = {.struct_size = sizeof news};
    char text[LUM_ERROR_BYTES];
    bool is_good = true;
    while (lum_laser_session_next(laser, &news)) {
        (void)puts(lum_news_tell(&news, text, sizeof text));
        is_good &= lum_news_weigh(news.kind) != LUM_NEWS_ERROR;
    }
    return is_good;
}

static bool run(lum_sensor *sensor, lum_laser_session *laser)
{
    const int64_t end_ns = lum_time_monotonic_ns() + RUN_NS;
    int64_t now_ns = 0;
    uint64_t datagrams = 0;
    bool is_good = true;
    lum_sensor_event event = {0};
    lum_sensor *last = sensor;
    while ((now_ns = lum_time_monotonic_ns()) < end_ns && is_over == 0) {
        lum_laser_session_serve(laser, sensor, now_ns);
        lum_sensor_receive(sensor, now_ns + SERVE_NS, &event);
        lum_laser_session_take(laser, &event, lum_time_monotonic_ns());
        is_good &= tell(laser);
        if (event.kind == LUM_SENSOR_DATAGRAMS) {
            datagrams += event.datagram_count; /* to decode, or to record */
        } else if (event.kind == LUM_SENSOR_FAILED) {
            (void)puts(event.error.text);
            is_good = false;
            last = NULL; /* its sensor can be asked nothing any more */
            break;
        }
    }
    (void)lum_laser_session_end(laser, last, LUM_SENSOR_OFF_MS, 0, NULL);
    (void)printf("%llu datagrams\n", (unsigned long long)datagrams);
    return tell(laser) && is_good;
}

static bool open_both(const char *host, lum_sensor **sensor,
                      lum_laser_session **laser, lum_error *error)
{
    lum_sensor_options options;
    lum_laser_session_options wants;
    lum_sensor_options_default(&options);
    options.owns = true; /* heartbeats, without which the laser goes off */
    if (lum_resolve(host, &options.sensor.address, error) != 0 ||
        lum_sensor_open(&options, sensor, error) != LUM_NET_OK) {
        return false;
    }
    lum_laser_session_options_default(&wants, &options);
    wants.laser = LUM_WANT_ON;
    return lum_laser_session_new(&wants, lum_time_monotonic_ns(), laser,
                                 error) == 0;
}

int main(int argc, char **argv)
{
    lum_sensor *sensor = NULL;
    lum_laser_session *laser = NULL;
    lum_error error;
    if (argc != 2) {
        (void)fputs("usage: own_laser ADDRESS\n", stderr);
        return 2;
    }
    (void)signal(SIGINT, on_signal);
    (void)signal(SIGTERM, on_signal);
    const bool is_open = open_both(argv[1], &sensor, &laser, &error);
    if (!is_open) {
        (void)fprintf(stderr, "own_laser: %s\n", error.text);
    }
    const bool is_good = is_open && run(sensor, laser);
    lum_laser_session_free(laser);
    lum_sensor_close(sensor);
    return is_good ? 0 : 1;
}
