/** @file
 * What keys.c needs to know of the keys of a calibration and of a profile.
 * Internal to host and config. */
#ifndef LUM_HOST_KEYS_INTERNAL_H
#define LUM_HOST_KEYS_INTERNAL_H

#include "key_table.h"
#include "lum/host/keys.h"

/** Kinds of keys. */
enum {
    LUM_KEYS_CALIBRATION,
    LUM_KEYS_PROFILE
};

/** The key "version", which only files need. */
#define LUM_KEYS_VERSION 0u

/** The rule of every version. */
extern const lum_key_rule lum_key_version;

extern const lum_key_table lum_calibration_keys;
extern const lum_key_table lum_profile_keys;

/** The table of some keys. */
const lum_key_table *lum_keys_table(const lum_keys *keys);

/** Begin the message why a value is refused.
 * @param why may be NULL. */
lum_key_text lum_key_refuse(lum_key_refusal *why, const char *key,
                            uint32_t place);

/** Say what is wrong with a key that has no value.
 * @param why may be NULL.
 * @return LUM_E_TYPE. */
lum_result lum_key_refuse_key(const lum_key_table *table, const char *key,
                              uint32_t place, lum_key_refusal *why);

/** Text after a value in a message: where it comes from, if it was not set. */
const char *lum_keys_origin(const lum_keys *keys, uint32_t place);

#endif
