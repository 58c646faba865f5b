/* A sensor that moves: the options of that, and whether they can be. */
#ifndef LUMSIM_MOVING_H
#define LUMSIM_MOVING_H

#include "lum/base/error.h"
#include "options.h"

#include <stdbool.h>

/* What --path takes, for messages. */
#define MOVING_PATH "straight, circle, eight, stop-and-go or the name of a file"

/* Read the text of --path. False: it is refused. */
bool moving_take_path(void *options, const char *text, lum_error *why);

/* Whether these options go together; complains. Sets the usual velocity. */
bool moving_check(struct options *o);

/* Read the text of --labels. False: it is refused. */
bool moving_take_labels(void *options, const char *text, lum_error *why);

/* Read the poses of --path FILE; complains, also where they have gaps, or where
 * a run is longer than they are. */
bool moving_load(struct options *o);

/* Free what it read. */
void moving_free(struct options *o);

/* Whether both eyes are in the open all the way of a run; complains. */
bool moving_is_open(const struct options *o);

/* By how much the sensor jumps when so many frames of a path begin again. */
struct moving_jump {
    double metres;
    double degrees;
};
struct moving_jump moving_find_jump(const struct options *o, unsigned frames);

#endif
