/* What is linked for the layout of data packets: layout_any.c, or in its place
 * layout_fixed.c or a file that lumtable wrote. Such a file also holds
 * lum_group_decode(), lum_group_word(), lum_clock_init() and
 * lum_clock_follow(). */
#ifndef LUM_CORE_LAYOUT_H
#define LUM_CORE_LAYOUT_H

#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>

/* Whether data packets of this layout are read as it says. */
bool lum_layout_is_read(const lum_layout *layout);

/* Copies the angles of a packet. angle_order: that of its layout, as
 * lum_angle_order. */
void lum_layout_copy_angles(lum_angle *to, const lum_group *group,
                            uint8_t angle_order);

#endif
