/* What a command text wants of the laser, and what becomes of it. */
#ifndef LUMCTL_LASER_OUTCOME_H
#define LUMCTL_LASER_OUTCOME_H

#include "ctl.h"

/* Whether the laser session saw the laser go as a text wants it. An answer
 * without a status shows nothing. */
bool laser_is_as(const struct ctl *ctl, lum_laser_want want);

/* Switches it off, even during a request, and blocks signals during that
 * time. end: what to say of it. */
lum_laser_off laser_switch_down(struct ctl *ctl, lum_news *end);

/* The end of a command that has switched it on: as laser_switch_down(), also
 * where the session is broken, and says what came of it. EXIT_FAILED if it was
 * not seen off. */
enum exit_status laser_leave(struct ctl *ctl);

/* Whether it was seen off, and will not come up by itself. */
bool laser_is_undone(const lum_news *end);

/* What became of a text that did not do what it was to do, after
 * laser_switch_down(): says so. */
void laser_tell_undo(lum_laser_want want, const lum_news *end);

/* The answer is not the wanted one: prints the error and the reason, and that
 * it was undone. EXIT_HAZARD if a hazard keeps it down, else EXIT_FAILED. want
 * is not LUM_WANT_LOOK. */
enum exit_status laser_complain(const struct ctl *ctl, lum_laser_want want,
                                const struct ctl_answer *answer,
                                const lum_news *end);

#endif
