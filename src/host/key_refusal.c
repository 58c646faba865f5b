/* How the message begins that refuses a value. */
#include "keys_internal.h"

const lum_key_rule lum_key_version = {
    .min = 1, .max = 1, .whole = true, .allowed = "1"};

lum_key_text lum_key_refuse(lum_key_refusal *why, const char *key,
                            uint32_t place)
{
    if (why == NULL) {
        return lum_key_text_begin(NULL, 0);
    }
    lum_key_text name = lum_key_text_begin(why->key, sizeof why->key);
    lum_key_text_add(&name, key);
    why->place = place;
    return lum_key_text_begin(why->text, sizeof why->text);
}

const char *lum_keys_origin(const lum_keys *keys, uint32_t place)
{
    if (place != 0) {
        return "";
    }
    return keys->is_default != 0 ? " (the default)" : " (as it was)";
}
