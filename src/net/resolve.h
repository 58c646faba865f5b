/* The system's resolver. */
#ifndef LUM_NET_RESOLVE_SYSTEM_H
#define LUM_NET_RESOLVE_SYSTEM_H

#include "lum/base/error.h"

#include <stdint.h>

/* The first IPv4 address of a name. 0; or -1 with the error. */
int lum_system_resolve(const char *name, uint32_t *out, lum_error *error);

#endif
