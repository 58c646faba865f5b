/** @file
 * The keys of settings, for files that have them beside their own keys.
 * Internal to config. */
#ifndef LUM_CONFIG_SETTINGS_KEYS_H
#define LUM_CONFIG_SETTINGS_KEYS_H

#include "host/key_table.h"
#include "lum/config/settings.h"

/** The values of settings; other keys are indexes from here on. */
#define LUM_SETTINGS_VALUES 64u

/** Text of what a command's spec allows, such as "150 to 250 in steps of 10".
 */
typedef char lum_settings_allowed[40];

/** A table of the settings' keys, and the rules that it points to. */
typedef struct lum_settings_keys {
    lum_key_entry entries[LUM_KEY_ENTRIES_MAX]; /**< its first ones are used */
    size_t count;                               /**< how many */
    lum_key_rule rules[LUM_COMMANDS];           /**< by ::lum_command_id */
    lum_settings_allowed allowed[LUM_COMMANDS]; /**< by the same */
} lum_settings_keys;

/** Fill in the table; it may not be moved then. Entries may be added. */
void lum_settings_keys_init(lum_settings_keys *out);

/** Check the values that were read, and take them.
 * @param name of the file, for messages.
 * @param at   of a mapping in a list, such as "steps.3"; "" for a whole file.
 * @return 0, or -1 with the error set. */
LUM_MUST_CHECK int lum_settings_keys_take(const lum_settings_keys *keys,
                                          const char *name, const char *at,
                                          const lum_key_value *values,
                                          lum_settings *out, lum_error *error);

#endif
