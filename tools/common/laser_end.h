/* How tools switch the laser off: they try for LUM_SENSOR_OFF_MS; when it takes
 * long, a message says so and the user may stop it. */
#ifndef LUM_LASER_END_H
#define LUM_LASER_END_H

#include "lum/live/laser_session.h"

/* For LUM_LASER_SESSION_ALONE_MS nothing stops it. Then a second signal does if
 * signals are held (interrupt.h); the first may have come before. A line on
 * standard error, which program begins, says that it continues, and how many
 * signals stop it, unless two have come or the line would have to wait for a
 * reader. sensor: as lum_laser_session_end(). out: gets what to say at the end;
 * may be NULL. Earlier news is lost. */
lum_laser_off laser_end(lum_laser_session *session, lum_sensor *sensor,
                        const char *program, lum_news *out);

#endif
