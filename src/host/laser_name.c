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
