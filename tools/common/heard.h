/* What datagrams of a session show of a sensor. */
#ifndef LUM_TOOLS_HEARD_H
#define LUM_TOOLS_HEARD_H

#include "lum/net/sensor.h"

#include <stdbool.h>

struct heard {
    bool has_data;
    bool has_unknown; /* packets that do not fit the layout came before any data
                       */
};

/* The first packet tells most often: nearly all that comes is data. */
struct heard heard_in(const lum_sensor_event *event, const lum_layout *layout);

#endif
