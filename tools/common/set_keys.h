/* Settings by key from a command line, on top of files: --set KEY=VALUE, with a
 * key of a calibration or of a wire profile (lum/host/keys.h). */
#ifndef LUM_TOOLS_SET_KEYS_H
#define LUM_TOOLS_SET_KEYS_H

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>

#define SET_KEYS_MAX 64u

/* What --set takes, for messages. */
#define SET_KEYS_ALLOWED "KEY=VALUE, such as eyes.blue.mount.yaw_deg=-30.5"

/* A setting, of a command line's text. */
struct set_key {
    const char *text;
    bool is_of_profile; /* else of a calibration */
};

/* Settings, in the order of the command line: the last of a key holds. All 0:
 * none. */
struct set_keys {
    struct set_key list[SET_KEYS_MAX];
    size_t count;
};

/* Add KEY=VALUE to a struct set_keys; the text is kept. False: it is refused;
 * why says the reason, or is empty where it is not of this form. */
bool set_keys_add(void *to, const char *text, lum_error *why);

/* The first of a kind; NULL: there is none. */
const char *set_keys_first(const struct set_keys *keys, bool is_of_profile);

/* Set those of a kind. is_usual: so far it is the built-in one. 0, or -1 with
 * the reason in error: together the values cannot be; then nothing is set. */
int set_keys_calibration(const struct set_keys *keys, bool is_usual,
                         lum_calibration *calibration, lum_error *error);
int set_keys_profile(const struct set_keys *keys, bool is_usual,
                     lum_profile *profile, lum_error *error);

#endif
