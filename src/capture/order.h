/** @file
 * Whether a stream's records stand out of order by their own times, as queues
 * of a network card or joined files leave them. Internal to capture. */
#ifndef LUM_CAPTURE_ORDER_H
#define LUM_CAPTURE_ORDER_H

#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stdint.h>

/** The latest record of a sensor's data. All bytes 0: there was none. */
typedef struct lum_order {
    bool has_newest;
    int64_t newest_ns;
    uint64_t newest_ticks;
    uint64_t ahead;  /**< records since time last went on by a break */
    uint64_t behind; /**< in a row, in order, each a break behind those */
    int64_t last_ns; /**< of the last one behind */
} lum_order;

/** Follow a record of data. Where some records stand a break or more ahead of
 * more others that follow them, these others are in order: the few that stand
 * too early are counted by as many of those.
 * @param field    of the sensor's clock.
 * @param unit_ns  of its ticks.
 * @param break_ns how long no data comes in a break.
 * @return how far it stands behind a later one, in ns, where it is behind by
 *         about as much by the sensor's clock: a step of the host's clock, or
 *         the network, leaves these apart. Without a sensor's clock by its time
 *         alone. 0: it is in order. */
int64_t lum_order_behind_ns(lum_order *order, const lum_field *field,
                            uint32_t unit_ns, int64_t break_ns, int64_t time_ns,
                            const lum_group *group);

#endif
