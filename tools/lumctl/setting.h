/* The settings of a sensor, all but its laser. */
#ifndef LUMCTL_SETTING_H
#define LUMCTL_SETTING_H

#include "lum/command.h"

#include <stdint.h>

#define SETTINGS       (LUM_COMMANDS - 2u) /* all but laser on and off */
#define SETTING_SHAPES 3u

struct setting {
    lum_command_id id;
    const char *name; /* for people, such as "threshold green" */
};

/* In the order in which they are sent and shown: a change of the line mode
 * clears a table, so it comes first. */
extern const struct setting settings[SETTINGS];

/* NULL for the laser's. */
const char *setting_name(lum_command_id id);

/* Lines of a frame in a line mode. */
unsigned setting_lines(uint16_t mode);

/* The names of shapes, by lum_yscan_kind. */
extern const char *const setting_shapes[SETTING_SHAPES];

#endif
