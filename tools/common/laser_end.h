/* How tools switch the laser off: they try for LUM_SENSOR_OFF_MS; when it takes
 * long, a message says so and the user may stop it. */
#ifndef LUM_LASER_END_H
#define LUM_LASER_END_H

#include "lum/net/sensor.h"

#include <stdint.h>

/* In the first three seconds nothing stops it; after that a sensor that gets no
 * heartbeats is down by itself. Then a second signal stops it if signals are
 * held (interrupt.h); the first may have come before. A line on standard error
 * says that it continues, and how many signals stop it, unless two have come or
 * the line would have to wait for a reader.
 * name    begins that line, such as "lumctl: 10.42.0.37".
 * status  as lum_sensor_laser_off(). */
lum_laser_off laser_end(lum_sensor *sensor, const char *name, uint16_t *status);

/* What LUM_LASER_OFF_REFUSED means, with the status that it left: begins a
 * message. */
const char *laser_end_refused(uint16_t status);

/* "10.42.0.37": at which address a person is to try it by hand, the new one of
 * a sensor that moved. Laser off itself goes to the session's.
 * sensor  NULL where there is no session any more.
 * own     the session's. */
const char *laser_end_address(const lum_sensor *sensor, lum_endpoint own,
                              char out[16]);

#endif
