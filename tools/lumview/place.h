/* Where the server is to listen. */
#ifndef LUMVIEW_PLACE_H
#define LUMVIEW_PLACE_H

#include "options.h"

#include "lum/base/error.h"

#include <stdint.h>

/* An address of this host and a free port of it. 0, or -1 with the program that
 * has it in the error. */
int place_find(const struct listen_options *options, uint32_t *address,
               uint16_t *port, lum_error *error);

#endif
