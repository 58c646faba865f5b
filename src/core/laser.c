#include "lum/laser.h"

bool lum_laser_is_down(uint16_t status)
{
    return (status & LUM_LASER_ALL_DOWN) != 0;
}

bool lum_laser_is_on(uint16_t status)
{
    const unsigned on = LUM_LASER_TLV_CMD_ON;
    return (status & (LUM_LASER_ALL_DOWN | on)) == on;
}

bool lum_laser_has_hazard(uint16_t status)
{
    return (status & LUM_LASER_HAZARDS) != 0;
}
