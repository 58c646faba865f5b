/* The connections there are, by the address at their other end: one host cannot
 * take them all. */
#ifndef LUMVIEW_CROWD_H
#define LUMVIEW_CROWD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CROWD_MAX      100u
#define CROWD_PEER_MAX 30u /* of one address */

struct crowd_place {
    uint32_t address;
    bool is_taken;
};

struct crowd {
    struct crowd_place places[CROWD_MAX];
};

/* Whether there is room for one more of this address. */
bool crowd_has_room(const struct crowd *crowd, uint32_t address);

/* The place that a connection has until it is not taken any more; NULL: there
 * is none. */
struct crowd_place *crowd_enter(struct crowd *crowd, uint32_t address);

#endif
