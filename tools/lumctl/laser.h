/* What a command text wants of the laser, and whether an answer shows it. */
#ifndef LUMCTL_LASER_H
#define LUMCTL_LASER_H

#include "ctl.h"

enum laser_wish {
    LASER_ANY, /* the text does not switch it */
    LASER_ON,
    LASER_OFF
};

/* The last u or d of a text decides. */
enum laser_wish laser_wish_of(const char *text);

/* An answer without a status shows nothing. */
bool laser_is_as(enum laser_wish wish, const struct ctl_answer *answer);

/* It is not: complains, says why. EXIT_HAZARD where a hazard keeps it down,
 * else EXIT_FAILED. wish is not LASER_ANY. */
enum exit_status laser_complain(const struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer);

#endif
