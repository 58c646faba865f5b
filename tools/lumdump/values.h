/* Values of options, each from its text into its field, for the table of
 * options. */
#ifndef LUMDUMP_VALUES_H
#define LUMDUMP_VALUES_H

#include "lum/base/error.h"

#include "options.h"

#include <stdbool.h>

/* lum_selection */
bool values_take_return(void *points, const char *text, lum_error *why);
bool values_take_range(void *points, const char *text, lum_error *why);
bool values_take_box(void *points, const char *text, lum_error *why);

/* struct choice_options; int64_t */
bool values_take_frames(void *choice, const char *text, lum_error *why);
bool values_take_duration(void *duration_ns, const char *text, lum_error *why);

/* struct rotation, also of --keep; struct point_options */
bool values_take_limit(void *rotation, const char *text, lum_error *why);
bool values_take_smooth(void *points, const char *text, lum_error *why);

/* struct cloud_options; struct picture_options */
bool values_take_columns(void *cloud, const char *text, lum_error *why);
bool values_take_size(void *picture, const char *text, lum_error *why);

/* unsigned; const char * */
bool values_take_mcap(void *contents, const char *text, lum_error *why);
bool values_take_frame_id(void *frame_id, const char *text, lum_error *why);
bool values_take_preset(void *preset, const char *text, lum_error *why);

#endif
