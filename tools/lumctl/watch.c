#include "watch.h"

#include "ctl_session.h"

#include "lum/base/time.h"

#define LOOK_NS INT64_C(500000000)

static int64_t earlier(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static int64_t end_of(const struct ctl *ctl, int64_t now)
{
    const double s = ctl->options.repeat.duration_s;
    return s > 0.0 ? now + (int64_t)(s * 1e9) : INT64_MAX;
}

/* Laser off comes first, then the next request, once it is due; missed requests
 * are not repeated. */
static void ask_when_due(struct ctl *ctl, const struct watch *watch,
                         int64_t now, int64_t *due)
{
    if (watch->looks) {
        lum_laser_session_serve(ctl->laser, ctl->sensor, now);
    } else if (session_serve_off(ctl)) {
        return;
    }
    if (watch->ask == NULL || now < *due ||
        lum_sensor_is_waiting(ctl->sensor)) {
        return;
    }
    (void)!watch->ask(ctl, watch->context);
    *due += watch->period_ns;
    if (*due <= now) {
        *due = now + watch->period_ns;
    }
}

/* When take is called at the latest. */
static int64_t next_look(const struct watch *watch, int64_t now, int64_t due)
{
    int64_t look = now + LOOK_NS;
    if (due > now) {
        look = earlier(look, due);
    }
    if (watch->wake_ns != NULL && *watch->wake_ns > now) {
        look = earlier(look, *watch->wake_ns);
    }
    return look;
}

enum exit_status watch_run(struct ctl *ctl, const struct watch *watch)
{
    int64_t now = lum_time_monotonic_ns();
    int64_t due = now;
    const int64_t end = end_of(ctl, now);
    lum_sensor_give_up(ctl->sensor);
    for (; now < end; now = lum_time_monotonic_ns()) {
        lum_sensor_event event;
        ask_when_due(ctl, watch, now, &due);
        session_receive(ctl, earlier(end, next_look(watch, now, due)), &event);
        if (event.kind == LUM_SENSOR_CANCELLED) {
            break;
        }
        if (event.kind == LUM_SENSOR_FAILED) {
            return ctl_complain(EXIT_FAILED, "%s", event.error.text);
        }
        session_tell(ctl, &event, watch->looks);
        if (!watch->take(watch->context, &event)) {
            break;
        }
    }
    lum_sensor_give_up(ctl->sensor);
    return EXIT_DONE;
}
