/* Links the configuration files of an installed copy. */
#include <lum/config/config.h>
#include <lum/config/settings.h>

#include <stdio.h>
#include <string.h>

int main(void)
{
    static const char text[] = "version: 1\n";
    lum_calibration calibration;
    lum_settings settings;
    lum_error error;

    (void)puts("config");
    return lum_calibration_parse(text, strlen(text), "text", &calibration,
                                 &error) != 0 ||
           lum_settings_load("no-such-file", &settings, &error) == 0;
}
