#include "lum/live/laser_off.h"
#include "lum/base/time.h"
#include "lum/laser.h"
#include "net/session.h"

/* Longest wait for the second look, before the command is sent again. A slow
 * sensor may have repeats of the command to answer before it. */
#define LOOK_NS (2000 * NS_PER_MS)

/* What a request showed of the laser; from LOOK_WAITING on it is down. */
typedef enum laser_look {
    LOOK_SILENT,
    LOOK_BLIND, /* an answer without a status */
    LOOK_UP,
    LOOK_WAITING, /* down, but a command to be on is in effect */
    LOOK_UNCLEAR, /* down, and commands to be on and off are in effect */
    LOOK_DOWN
} laser_look;

typedef struct attempt {
    lum_sensor *sensor;
    int64_t end_ns;
    const lum_cancel *cancel;
    uint16_t *status; /* may be NULL */
} attempt;

static bool is_ended(const attempt *a)
{
    return a->sensor->has_failed || lum_cancel_is_raised(a->cancel);
}

/* What had come before is given out first. */
static bool is_unsent(const attempt *a)
{
    const lum_exchange *x = &a->sensor->exchange;
    return x->ask != LUM_ASK_NOTHING && x->tries == 0 && !a->sensor->has_failed;
}

/* Receives until the request under way ends or a time is reached, but not
 * before it was sent. */
static void receive_until(const attempt *a, int64_t end_ns,
                          lum_sensor_event *out)
{
    int64_t now_ns = lum_time_monotonic_ns();
    do {
        const int64_t slice_ns = now_ns + NS_PER_MS * LUM_SENSOR_OFF_EVERY_MS;
        lum_session_receive(a->sensor, NULL,
                            slice_ns < end_ns ? slice_ns : end_ns, out);
        now_ns = lum_time_monotonic_ns();
    } while (out->kind != LUM_SENSOR_ANSWER &&
             out->kind != LUM_SENSOR_NO_ANSWER &&
             (is_unsent(a) || (now_ns < end_ns && !is_ended(a))));
}

/* A `u` that came behind the `d` brings the laser back when a hazard ends. */
static laser_look look_at(uint16_t status)
{
    if (!lum_laser_is_down(status)) {
        return LOOK_UP;
    }
    if ((status & LUM_LASER_TLV_CMD_ON) == 0) {
        return LOOK_DOWN;
    }
    return (status & LUM_LASER_TLV_CMD_OFF) != 0 ? LOOK_UNCLEAR : LOOK_WAITING;
}

/* Makes a request, a command or (NULL) a poll, and reads its own answer. */
static laser_look look(const attempt *a, const char *command, int64_t end_ns)
{
    lum_sensor_event event;
    lum_sensor_give_up(a->sensor);
    const lum_result begun = command != NULL
                                 ? lum_sensor_command(a->sensor, command)
                                 : lum_sensor_request(a->sensor, NULL, 0);
    receive_until(a, end_ns, &event);
    /* mcdc: nothing else was under way */
    if (begun != LUM_OK || event.kind != LUM_SENSOR_ANSWER) {
        return LOOK_SILENT;
    }
    if (!event.has_status) {
        return LOOK_BLIND;
    }
    if (a->status != NULL) {
        *a->status = event.status;
    }
    return look_at(event.status);
}

/* The command and, if its answer shows the laser down, a second look. */
static laser_look look_twice(const attempt *a)
{
    lum_sensor_event event;
    const laser_look first = look(a, "d", a->end_ns);
    if (first == LOOK_SILENT) {
        return first;
    }
    receive_until(a, lum_time_monotonic_ns() + NS_PER_MS * LUM_SENSOR_SETTLE_MS,
                  &event);
    return first >= LOOK_WAITING
               ? look(a, NULL, lum_time_monotonic_ns() + LOOK_NS)
               : first;
}

static lum_laser_off switch_off(const attempt *a)
{
    laser_look last = LOOK_SILENT;
    uint64_t vain = 0;
    do {
        last = look_twice(a);
        /* It may never show a status, or show any `u` as in effect for ever. */
        vain += last == LOOK_BLIND || last == LOOK_UNCLEAR;
    } while (last != LOOK_DOWN && vain <= a->sensor->retries && !is_ended(a) &&
             lum_time_monotonic_ns() < a->end_ns);
    return last >= LOOK_UNCLEAR  ? LUM_LASER_OFF_SEEN
           : last >= LOOK_UP     ? LUM_LASER_OFF_REFUSED
           : last == LOOK_SILENT ? LUM_LASER_OFF_UNKNOWN
                                 : LUM_LASER_OFF_UNSEEN;
}

lum_laser_off lum_sensor_laser_off(lum_sensor *sensor, uint32_t ms,
                                   const lum_cancel *cancel, uint16_t *status)
{
    const bool told = sensor->link.told;
    const lum_exchange_config config = sensor->exchange.config;
    const attempt a = {sensor, lum_time_monotonic_ns() + NS_PER_MS * ms, cancel,
                       status};
    sensor->exchange.config.owns = false;
    sensor->exchange.config.timeout_ns = NS_PER_MS * LUM_SENSOR_OFF_EVERY_MS;
    sensor->exchange.config.retries = UINT32_MAX;
    const lum_laser_off end = switch_off(&a);
    lum_sensor_give_up(sensor);
    sensor->exchange.config = config;
    sensor->link.told = told;
    return end;
}
