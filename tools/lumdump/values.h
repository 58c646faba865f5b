/* Functions for values of options, called by the table of options. They print
 * errors on standard error. */
#ifndef LUMDUMP_VALUES_H
#define LUMDUMP_VALUES_H

#include "options.h"

#include <stdbool.h>

bool values_take_return(void *options, const char *text, lum_error *why);
bool values_take_frames(void *options, const char *text, lum_error *why);
bool values_take_range(void *options, const char *text, lum_error *why);
bool values_take_box(void *options, const char *text, lum_error *why);
bool values_take_sensor(void *options, const char *text, lum_error *why);
bool values_take_duration(void *options, const char *text, lum_error *why);
bool values_take_rotation(void *options, const char *text, lum_error *why);
bool values_take_keep(void *options, const char *text, lum_error *why);
bool values_take_set(void *options, const char *text, lum_error *why);
bool values_take_smooth(void *options, const char *text, lum_error *why);
bool values_take_buffer(void *options, const char *text, lum_error *why);
bool values_take_receive_buffer(void *options, const char *text,
                                lum_error *why);
bool values_take_columns(void *options, const char *text, lum_error *why);
bool values_take_size(void *options, const char *text, lum_error *why);
bool values_take_mcap(void *options, const char *text, lum_error *why);
bool values_take_frame_id(void *options, const char *text, lum_error *why);
bool values_take_preset(void *options, const char *text, lum_error *why);
bool values_take_check_preset(void *options, const char *text, lum_error *why);

#endif
