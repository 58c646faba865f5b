/* What a command text wants of the laser, and whether an answer shows it. */
#ifndef LUMCTL_LASER_H
#define LUMCTL_LASER_H

#include "ctl.h"

enum laser_wish {
    LASER_ANY, /* the text does not switch it */
    LASER_ON,
    LASER_OFF
};

/* Switches it off, even during a request, and blocks signals during that
 * time. end: what to say of it. */
lum_laser_off laser_switch_down(struct ctl *ctl, lum_news *end);

/* The last u or d of a text decides. */
enum laser_wish laser_wish_of(const char *text);

/* An answer without a status shows nothing. */
bool laser_is_as(enum laser_wish wish, const struct ctl_answer *answer);

/* What has become of a command for the laser on that did not show it up. */
enum laser_undo {
    LASER_STANDS,      /* there was nothing to take back */
    LASER_TAKEN_BACK,  /* the laser will not come up by itself */
    LASER_MAY_COME_UP, /* it has not answered the taking back */
    LASER_IS_ON        /* it has come up since, and stays up */
};

/* If a text wanted the laser on and the answer (NULL: none came) does not show
 * it up, switches it off: otherwise the laser would come up by itself when its
 * hazard ends. */
enum laser_undo laser_take_back(struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer);

/* The answer is not the wanted one: prints the error, the reason and the
 * result. EXIT_HAZARD if a hazard keeps it down, else EXIT_FAILED. wish is not
 * LASER_ANY. */
enum exit_status laser_complain(const struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer,
                                enum laser_undo undo);

/* The request ended with a status other than EXIT_DONE: cancels a command that
 * may still have reached the sensor, or switches off a laser that should be
 * off, says so, and returns the status. */
enum exit_status laser_give_up(struct ctl *ctl, enum laser_wish wish,
                               enum exit_status status, bool was_sent);

#endif
