/* The names of laser status bits and states. */
#include "lum/host/laser_name.h"

#include <stddef.h>

const char *lum_laser_bit_name(unsigned bit)
{
    static const char *const names[LUM_LASER_BITS] = {
        "GALVO_AMP_BX_BAD",
        "GALVO_AMP_BY_BAD",
        "GALVO_AMP_GX_BAD",
        "GALVO_AMP_GY_BAD",
        "HEARTBEAT_TIMEOUT",
        "BOARD_OVER_105",
        "FAN_PWM_BAD",
        "HW_SAFETY_BAD",
        "SYS_ON_SW_OFF",
        "TLV_CMD_OFF",
        "BIT_10",
        "TLV_CMD_ON",
        "BIT_12",
        "BIT_13",
        "BIT_14",
        "BIT_15",
    };
    return bit < LUM_LASER_BITS ? names[bit] : NULL;
}

const char *lum_laser_status_name(uint16_t status)
{
    return lum_laser_is_down(status) ? "down"
           : lum_laser_is_on(status) ? "up"
                                     : "may be up";
}

static size_t add(char *out, size_t room, size_t at, const char *text)
{
    while (*text != '\0' && at < room - 1u) {
        out[at++] = *text++;
    }
    out[at] = '\0';
    return at;
}

const char *lum_laser_bits_name(uint16_t bits, const char *between, char *out,
                                size_t room)
{
    size_t at = add(out, room, 0, bits == 0 ? "none" : "");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if (((unsigned)bits >> bit & 1u) != 0) {
            at = add(out, room, at, at > 0 ? between : "");
            at = add(out, room, at, lum_laser_bit_name(bit));
        }
    }
    return out;
}
