/* Links the session of an installed copy, and no third-party library. */
#include <lum/net/sensor.h>
#include <lum/version.h>

#include <stdio.h>

int main(void)
{
    lum_sensor_options options;
    lum_sensor *sensor = NULL;
    lum_error error;

    lum_sensor_options_default(&options);
    if (lum_sensor_open(&options, &sensor, &error) != LUM_NET_OK) {
        (void)fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    lum_sensor_close(sensor);
    (void)puts("net " LUM_VERSION);
    return 0;
}
