#include "laser_end.h"

#include "interrupt.h"
#include "number.h"
#include "writable.h"

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

static void tell_rest(const char *name, lum_laser_off end)
{
    if (!is_given_up() && writable(stderr, 0)) {
        (void)fprintf(stderr, "%s: %s: laser off is repeated for %u s more%s\n",
                      name,
                      end == LUM_LASER_OFF_REFUSED ? "the laser is still on"
                                                   : "no answer yet",
                      (LUM_SENSOR_OFF_MS - ALONE_MS) / 1000u, way_out());
    }
}

lum_laser_off laser_end(lum_sensor *sensor, const char *name, uint16_t *status)
{
    const lum_laser_off end =
        lum_sensor_laser_off_within(sensor, ALONE_MS, NULL, status);
    if (end == LUM_LASER_OFF_SEEN || end == LUM_LASER_OFF_UNSEEN) {
        return end;
    }
    tell_rest(name, end);
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
