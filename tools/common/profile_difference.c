#include "profile_difference.h"

#include <stdbool.h>
#include <string.h>

static void get(const lum_keys *keys, const char *key,
                char out[LUM_KEY_VALUE_BYTES])
{
    if (lum_keys_get(keys, key, out) != LUM_OK) {
        out[0] = '\0';
    }
}

/* A field's offset has a key of its own, and what is none has nothing else. */
static bool is_said(const lum_keys *keys, const char *key)
{
    char field[LUM_KEY_BYTES];
    char value[LUM_KEY_VALUE_BYTES];
    const char *last = strrchr(key, '.');
    if (strncmp(key, "group.", 6) != 0 || last == key + 5) {
        return true;
    }
    const size_t len = (size_t)(last - key);
    memcpy(field, key, len);
    field[len] = '\0';
    get(keys, field, value);
    return strcmp(last, ".at") != 0 && strcmp(value, "none") != 0;
}

size_t profile_differences(const lum_profile *one, const lum_profile *other,
                           struct profile_difference out[LUM_KEYS_MAX])
{
    lum_keys keys[2];
    lum_key key;
    size_t count = 0;
    lum_keys_of_profile(&keys[0], one);
    lum_keys_of_profile(&keys[1], other);
    for (size_t i = 0; lum_keys_describe(&keys[0], i, &key) == LUM_OK; i++) {
        struct profile_difference *d = &out[count];
        d->key = key.name;
        get(&keys[0], key.name, d->one);
        get(&keys[1], key.name, d->other);
        const bool differs = strcmp(d->one, d->other) != 0;
        count += differs && is_said(&keys[1], key.name) ? 1u : 0u;
    }
    return count;
}
