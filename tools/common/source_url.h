/* Names of sources: captures, and sensors as udp://HOST[:PORT]. */
#ifndef LUM_TOOLS_SOURCE_URL_H
#define LUM_TOOLS_SOURCE_URL_H

#include "lum/base/error.h"
#include "lum/net/socket.h"

#include <stdbool.h>

/* Whether a name stands for a sensor. */
bool source_url_is_sensor(const char *text);

/* The address and port of one that does; the host is looked up now. False: why
 * tells, with the name. */
bool source_url_parse(const char *text, lum_endpoint *out, lum_error *why);

/* Whether the name of a capture is none: neither an address without udp:// nor
 * udp: with other slashes, unless there is such a file. Else why tells. */
bool source_url_is_none(const char *text, lum_error *why);

#endif
