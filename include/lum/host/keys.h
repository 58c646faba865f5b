/** @file
 * Calibrations and wire profiles, set and read key by key as texts, for YAML
 * files, command lines and other languages. docs/protocol.md, section 8, lists
 * the keys of a profile, calib/typical.yaml has those of a calibration.
 *
 * @code
 * lum_keys keys;
 * lum_keys_of_profile(&keys, NULL);
 * if (lum_keys_set(&keys, "group.line.at", "14", 1, &why) != LUM_OK ||
 *     lum_keys_profile(&keys, &profile, &why) != LUM_OK) {
 *     puts(why.text);
 * }
 * @endcode
 *
 * Each value is checked when it is set; all of them are checked together when
 * they are taken. Freestanding and reentrant; nothing is allocated or kept. */
#ifndef LUM_HOST_KEYS_H
#define LUM_HOST_KEYS_H

#include "lum/calibration.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Bytes that hold any key, with its NUL. */
#define LUM_KEY_BYTES 48

/** Bytes that hold any value's text, with its NUL. */
#define LUM_KEY_VALUE_BYTES 40

/** Bytes of a message, its NUL included. */
#define LUM_KEY_MESSAGE_BYTES 384

/** Bytes that hold the text of lum_keys_write(), with its NUL. */
#define LUM_KEYS_WRITE_BYTES 2048

/** Most values of a set of keys. */
#define LUM_KEYS_MAX 40

/** A value. Private. */
typedef struct lum_key_value {
    int64_t number; /**< in units of its rule */
    uint32_t place; /**< where it was set; 0: it was not */
} lum_key_value;

/** The keys of a calibration or of a wire profile with their values. About 640
 * bytes, caller-owned, freely copied. Private: only the functions below read
 * and write it. */
typedef struct lum_keys {
    uint8_t kind;                       /**< what they are keys of */
    uint8_t is_default;                 /**< they started from the defaults */
    lum_key_value values[LUM_KEYS_MAX]; /**< by index */
} lum_keys;

/** Why a value is refused. */
typedef struct lum_key_refusal {
    char key[LUM_KEY_BYTES];          /**< the key; empty: no key */
    uint32_t place;                   /**< where it was set; 0: nowhere */
    char text[LUM_KEY_MESSAGE_BYTES]; /**< what is wrong, and the fix; one
                                           line for a person */
} lum_key_refusal;

/** What a key's value may be. */
typedef enum lum_key_kind {
    LUM_KEY_WHOLE,           /**< a whole number in digits */
    LUM_KEY_DECIMAL,         /**< a decimal number */
    LUM_KEY_WORD,            /**< one of some words */
    LUM_KEY_WORD_OR_WHOLE,   /**< one of some words, or a whole number */
    LUM_KEY_WORD_OR_DECIMAL, /**< one of some words, or a decimal number */
    LUM_KEY_WORD_OR_PAIR     /**< one of some words, or two whole numbers such
                                  as "[0, 14]" */
} lum_key_kind;

/** The description of a key. */
typedef struct lum_key {
    const char *name;                /**< such as "eyes.blue.mount.x_m" */
    lum_key_kind kind;               /**< what its value may be */
    const char *unit;                /**< such as "deg"; empty: none */
    const char *words[3];            /**< the words, NULL after the last */
    char min[LUM_KEY_VALUE_BYTES];   /**< smallest number; empty: none */
    char max[LUM_KEY_VALUE_BYTES];   /**< largest number; empty: none */
    char allowed[128];               /**< all that is allowed, for a person */
    char usual[LUM_KEY_VALUE_BYTES]; /**< its default */
} lum_key;

/** The keys of a calibration.
 * @param out   caller-owned, overwritten.
 * @param start their first values; NULL: the defaults. Not kept. */
void lum_keys_of_calibration(lum_keys *out, const lum_calibration *start);

/** The keys of a wire profile. As lum_keys_of_calibration(). */
void lum_keys_of_profile(lum_keys *out, const lum_profile *start);

/** Set a value.
 * @param key   a path such as "group.line.at".
 * @param value as it would stand in a YAML file, such as "14" or "none".
 * @param place where it comes from, such as a line's number, from 1 on; a
 *              message about several values names the place of one that has a
 *              place.
 * @param why   may be NULL; written only on failure.
 * @return LUM_OK; LUM_E_TYPE if there is no such key or it has no value;
 *         LUM_E_VALUE if its value is not allowed, or place is 0. On failure
 *         nothing is set. */
LUM_MUST_CHECK lum_result lum_keys_set(lum_keys *keys, const char *key,
                                       const char *value, uint32_t place,
                                       lum_key_refusal *why);

/** Get a value's text, as lum_keys_set() takes it.
 * @param out written only on success.
 * @return LUM_OK; LUM_E_TYPE if there is no such key or it has no value. */
LUM_MUST_CHECK lum_result lum_keys_get(const lum_keys *keys, const char *key,
                                       char out[LUM_KEY_VALUE_BYTES]);

/** Describe the i-th key, for documentation, completion and other languages.
 * @param out written only on success; its strings are constants.
 * @return LUM_OK; LUM_E_VALUE if there are i keys or fewer. */
LUM_MUST_CHECK lum_result lum_keys_describe(const lum_keys *keys, size_t i,
                                            lum_key *out);

/** Check all values together, and take the calibration.
 * @param out written only on LUM_OK.
 * @param why may be NULL; written only on failure.
 * @return LUM_OK; LUM_E_TYPE if the keys are of a profile; LUM_E_VALUE. */
LUM_MUST_CHECK lum_result lum_keys_calibration(const lum_keys *keys,
                                               lum_calibration *out,
                                               lum_key_refusal *why);

/** Check all values together, and take the wire profile, which
 * lum_layout_init() then accepts. As lum_keys_calibration(). */
LUM_MUST_CHECK lum_result lum_keys_profile(const lum_keys *keys,
                                           lum_profile *out,
                                           lum_key_refusal *why);

/** Write all values as YAML text, which reads back exactly.
 * @param out  size bytes, gets a terminated text, cut where it is full; may be
 *             NULL if size is 0.
 * @return bytes of the whole text without its NUL, as snprintf() does. */
size_t lum_keys_write(const lum_keys *keys, char *out, size_t size);

#ifdef __cplusplus
}
#endif

#endif
