#include "laser_end.h"

#include "interrupt.h"
#include "number.h"
#include "writable.h"

#include "lum/laser.h"

#include <stdbool.h>
#include <stdio.h>

#define ALONE_MS 3000u

/* How a person ends it from now on: the signals that came before count. */
static const char *way_out(void)
{
    if (interrupt_second() == NULL) {
        return "";
    }
    return interrupt_signal() != 0 ? "; Ctrl-C gives up"
                                   : "; Ctrl-C twice gives up";
}

static bool is_given_up(void)
{
    const lum_cancel *second = interrupt_second();
    return second != NULL && lum_cancel_is_raised(second);
}

const char *laser_end_refused(uint16_t status)
{
    return lum_laser_is_down(status)
               ? "LASER ON IS STILL IN EFFECT after laser off: the laser comes "
                 "up by itself when what keeps it down ends"
               : "THE LASER IS STILL ON after laser off";
}

static const char *state_of(lum_laser_off end, uint16_t status)
{
    if (end != LUM_LASER_OFF_REFUSED) {
        return "no answer yet";
    }
    return lum_laser_is_down(status) ? "laser on is still in effect"
                                     : "the laser is still on";
}

static void tell_rest(const char *name, const char *state)
{
    if (!is_given_up() && writable(stderr, 0)) {
        (void)fprintf(stderr, "%s: %s: laser off is repeated for %u s more%s\n",
                      name, state, (LUM_SENSOR_OFF_MS - ALONE_MS) / 1000u,
                      way_out());
    }
}

lum_laser_off laser_end(lum_sensor *sensor, const char *name, uint16_t *status)
{
    const lum_laser_off end =
        lum_sensor_laser_off_within(sensor, ALONE_MS, NULL, status);
    if (end == LUM_LASER_OFF_SEEN || end == LUM_LASER_OFF_UNSEEN) {
        return end;
    }
    tell_rest(name, state_of(end, *status));
    return lum_sensor_laser_off_within(sensor, LUM_SENSOR_OFF_MS - ALONE_MS,
                                       interrupt_second(), status);
}

const char *laser_end_address(const lum_sensor *sensor, lum_endpoint own,
                              char out[16])
{
    lum_endpoint at = own;
    if (sensor != NULL) {
        (void)lum_sensor_moved_to(sensor, &at);
    }
    return number_format_address(at.address, out);
}
