/* What a command text wants of the laser, and what becomes of it. */
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

/* Switches it off, even during a request, and blocks signals during that
 * time. end: what to say of it. */
lum_laser_off laser_switch_down(struct ctl *ctl, lum_news *end);

/* Whether it was seen off, and will not come up by itself. */
bool laser_is_undone(const lum_news *end);

/* What became of a text that did not do what it was to do, after
 * laser_switch_down(): says so. */
void laser_tell_undo(enum laser_wish wish, const lum_news *end);

/* The answer is not the wanted one: prints the error and the reason, and that
 * it was undone. EXIT_HAZARD if a hazard keeps it down, else EXIT_FAILED. wish
 * is not LASER_ANY. */
enum exit_status laser_complain(const struct ctl *ctl, enum laser_wish wish,
                                const struct ctl_answer *answer,
                                const lum_news *end);

#endif
