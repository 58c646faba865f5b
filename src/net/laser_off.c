#include "lum/base/time.h"
#include "lum/laser.h"
#include "net/session.h"

/* What a request showed of the laser. */
typedef enum laser_look {
    LOOK_SILENT,
    LOOK_UP,
    LOOK_DOWN
} laser_look;

/* Receives until the request under way ends or a time is reached. */
static void receive_until(lum_sensor *s, int64_t deadline_ns,
                          lum_sensor_event *out)
{
    do {
        lum_session_receive(s, NULL, deadline_ns, out);
    } while ((out->kind == LUM_SENSOR_DATAGRAMS ||
              out->kind == LUM_SENSOR_ALERT || out->kind == LUM_SENSOR_LINK) &&
             lum_time_monotonic_ns() < deadline_ns);
}

/* Makes a request, a command or (NULL) a poll, and reads its own answer. */
static laser_look look(lum_sensor *s, const char *command, uint16_t *status)
{
    lum_sensor_event event;
    lum_sensor_give_up(s);
    if ((command != NULL ? lum_sensor_command(s, command)
                         : lum_sensor_request(s, NULL, 0)) != LUM_OK) {
        return LOOK_SILENT;
    }
    receive_until(s, INT64_MAX, &event);
    if (event.kind != LUM_SENSOR_ANSWER || !event.has_status) {
        return LOOK_SILENT;
    }
    if (status != NULL) {
        *status = event.status;
    }
    return lum_laser_is_down(event.status) ? LOOK_DOWN : LOOK_UP;
}

static void settle(lum_sensor *s)
{
    lum_sensor_event event;
    receive_until(s, lum_time_monotonic_ns() + NS_PER_MS * LUM_SENSOR_SETTLE_MS,
                  &event);
}

static lum_laser_off switch_off(lum_sensor *s, uint16_t *status)
{
    laser_look last = LOOK_SILENT;
    for (uint64_t round = 0; round <= s->retries; round++) {
        last = look(s, "d", status);
        if (last == LOOK_SILENT) {
            break;
        }
        settle(s);
        if (last == LOOK_DOWN) {
            last = look(s, NULL, status);
        }
        if (last == LOOK_DOWN) {
            return LUM_LASER_OFF_SEEN;
        }
    }
    return last == LOOK_UP ? LUM_LASER_OFF_REFUSED : LUM_LASER_OFF_UNKNOWN;
}

lum_laser_off lum_sensor_laser_off(lum_sensor *sensor, uint16_t *status)
{
    const bool told = sensor->link_told;
    const lum_laser_off end = switch_off(sensor, status);
    sensor->link_told = told;
    return end;
}
