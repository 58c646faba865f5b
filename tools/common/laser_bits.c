#include "laser_bits.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"

#include <stdbool.h>
#include <stdio.h>

const char *laser_bits_name(uint16_t status, uint16_t mask, char *out,
                            size_t room)
{
    size_t len = 0;
    (void)snprintf(out, room, "none");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if (((unsigned)(status & mask) >> bit & 1u) != 0 && len < room) {
            const int n = snprintf(out + len, room - len, "%s%s",
                                   len > 0 ? " " : "", lum_laser_bit_name(bit));
            len += n > 0 ? (size_t)n : 0;
        }
    }
    return out;
}

const char *laser_bits_cause(uint16_t status)
{
    const bool is_by_command =
        (status & LUM_LASER_TLV_CMD_OFF) != 0 && !lum_laser_has_hazard(status);
    return is_by_command ? ": switched off by another program's command, or "
                           "when no heartbeat came for 3 s"
                         : "";
}
