/* What resolvers say, in the same words everywhere. All return -1. */
#ifndef LUM_NET_RESOLVE_MESSAGES_H
#define LUM_NET_RESOLVE_MESSAGES_H

#include "lum/base/error.h"

int lum_resolve_say_unknown(const char *name, lum_error *error);
int lum_resolve_say_no_address(const char *name, lum_error *error);
int lum_resolve_say_failed(const char *name, const char *why, lum_error *error);

#endif
