/* Where the lines of the simulated sensor point. */
#include "device.h"

#define UDEG 1000000

/* Of a line of the uniform scan, in the middle of its share. */
static int64_t uniform_udeg(const lum_device_settings *s, size_t line)
{
    const int64_t fov = (int64_t)s->fov_deg * UDEG;
    return fov / 2 - fov * (2 * (int64_t)line + 1) / (2 * (int64_t)s->lines);
}

static int64_t raw_udeg(const lum_layout *layout,
                        const lum_eye_calibration *eye, int16_t raw)
{
    const int64_t low = eye->elevation_min_udeg;
    const int64_t high = eye->elevation_max_udeg;
    const int64_t lsb = (int64_t)layout->profile.angle_lsb_pdeg;
    const int64_t center = (low + high) / 2;
    return lsb > 0 ? center + raw * lsb / UDEG
                   : center + raw * (high - low) / 65536;
}

bool lum_device_elevations(const lum_device_settings *settings,
                           const lum_layout *layout,
                           const lum_eye_calibration *eye, int32_t *out_udeg)
{
    const bool has_table = settings->yscan_count > 0;
    if (!has_table && settings->fov_deg == 0) {
        return false;
    }
    for (size_t i = 0; i < settings->lines; i++) {
        int64_t udeg = has_table ? raw_udeg(layout, eye, settings->yscan[i])
                                 : uniform_udeg(settings, i);
        udeg = udeg < eye->elevation_min_udeg ? eye->elevation_min_udeg : udeg;
        udeg = udeg > eye->elevation_max_udeg ? eye->elevation_max_udeg : udeg;
        out_udeg[i] = (int32_t)udeg;
    }
    return true;
}
