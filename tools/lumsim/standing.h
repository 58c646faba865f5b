/* Where the sensor of a scene stands and how exact it is: the options of that,
 * and whether they can be. */
#ifndef LUMSIM_STANDING_H
#define LUMSIM_STANDING_H

#include "../common/option_table.h"
#include "lum/base/error.h"
#include "options.h"

#include <stdbool.h>

/* What --scene and --walls take. */
extern const struct option_word standing_scenes[];
extern const struct option_word standing_walls[];

/* What --pose and --noise take, for messages. */
#define STANDING_POSE  "X,Y,Z,ROLL,PITCH,YAW, in metres and degrees"
#define STANDING_NOISE "M or M,M,..., from 0 to 1 metre for each return"

/* Read the text of --pose and --noise. False: it is refused; why says the
 * reason, or is empty where it is not of this form. */
bool standing_take_pose(void *options, const char *text, lum_error *why);
bool standing_take_noise(void *options, const char *text, lum_error *why);

/* The name of the scene. */
const char *standing_scene(const struct options *o);

/* Whether these options go together; complains. */
bool standing_check(const struct options *o);

/* Whether both eyes of the calibration are in the open; complains. */
bool standing_is_open(const struct options *o);

/* The same of a place; of one that moves, at a time. time_s: NULL, it
 * stands. */
bool standing_see_eyes(const struct options *o, const lum_place *place,
                       const double *time_s);

#endif
