#include "lum/laser.h"

bool lum_laser_is_down(uint16_t status)
{
    return (status & LUM_LASER_ALL_DOWN) != 0;
}

bool lum_laser_has_hazard(uint16_t status)
{
    return (status & LUM_LASER_HAZARDS) != 0;
}
