/* Functions for values of options, called by the table of options, and for
 * names of sources. They print errors on standard error. */
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
bool values_take_smooth(void *options, const char *text, lum_error *why);
bool values_take_buffer(void *options, const char *text, lum_error *why);

/* udp://ADDRESS[:PORT] */
bool values_parse_url(const char *text, lum_endpoint *out);

/* Whether the name of a capture is not a mistyped URL of a sensor, for example
 * an address without udp:// or udp: with other slashes. The name of an existing
 * file never is one. */
bool values_is_no_url(const char *text);

#endif
