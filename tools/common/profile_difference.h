/* Where two wire profiles differ, key by key. */
#ifndef LUM_TOOLS_PROFILE_DIFFERENCE_H
#define LUM_TOOLS_PROFILE_DIFFERENCE_H

#include "lum/host/keys.h"

#include <stddef.h>

struct profile_difference {
    const char *key;               /* a constant, such as "eye_values.blue" */
    char one[LUM_KEY_VALUE_BYTES]; /* empty: it has none */
    char other[LUM_KEY_VALUE_BYTES];
};

/* In the order of docs/protocol.md. Returns how many there are. */
size_t profile_differences(const lum_profile *one, const lum_profile *other,
                           struct profile_difference out[LUM_KEYS_MAX]);

#endif
