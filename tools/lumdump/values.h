/* Values of options. Each function says on standard error what is wrong with
 * the text it is given, and what would be right. */
#ifndef LUMDUMP_VALUES_H
#define LUMDUMP_VALUES_H

#include "options.h"

#include <stdbool.h>

/* A word an option takes, and what it stands for; the last has no text. */
struct word {
    const char *text;
    unsigned value;
};

bool values_choose(const char *option, const struct word *words,
                   const char *text, unsigned *out);

bool values_parse_return(const char *text, lum_selection *out);
bool values_parse_frames(const char *text, struct options *out);
bool values_parse_range(const char *text, lum_selection *out);
bool values_parse_box(const char *text, lum_selection *out);
bool values_parse_sensor(const char *text, struct options *out);
bool values_parse_duration(const char *text, struct options *out);
bool values_parse_rotation(const char *text, struct rotation *out);
bool values_parse_smooth(const char *text, struct options *out);
bool values_parse_buffer(const char *text, uint64_t *out);

/* udp://ADDRESS[:PORT] */
bool values_parse_url(const char *text, lum_endpoint *out);

/* Whether the name of a capture is none: neither an address without udp:// nor
 * udp: with other slashes, unless there is such a file. */
bool values_is_no_url(const char *text);

#endif
