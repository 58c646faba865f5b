/* The laser status of the simulated sensor, and how it is told. */
#include "device_internal.h"

#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

bool lum_device_laser_is_up(const lum_device *device)
{
    return lum_laser_is_on(device->status);
}

void lum_device_set_status(lum_device *device, uint16_t status, int64_t now_ns)
{
    const bool was_up = lum_device_laser_is_up(device);
    device->status = status;
    if (!was_up && lum_device_laser_is_up(device)) {
        device->laser_ns = now_ns;
    }
}

void lum_device_note(lum_device_effects *fx, const char *text)
{
    const size_t len = strlen(fx->note);
    (void)snprintf(fx->note + len, sizeof fx->note - len, "%s%s",
                   len > 0 ? "; " : "", text);
}

void lum_device_put_status(const lum_device *device, uint32_t sequence,
                           lum_device_effects *fx, lum_tlv_writer *writer)
{
    const uint16_t type = device->layout.profile.tlv[LUM_TLV_STATUS];
    fx->has_reply = lum_tlv_begin(writer, fx->reply, sizeof fx->reply,
                                  sequence) == LUM_OK &&
                    lum_tlv_add_u16(writer, type, device->status) == LUM_OK;
}
