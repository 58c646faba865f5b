#include "set_keys.h"

#include "nearest.h"
#include "printable.h"

#include "lum/host/keys.h"

#include <string.h>

/* Every key of either kind. */
#define NAMES_MAX 128u

/* Bytes of a key that is not known, in a message. */
#define SHOWN_MAX 80u

/* --- One setting --- */

/* A copy of what stands before the '='; empty where that is no key. */
static void copy_key(const char *text, char out[LUM_KEY_BYTES])
{
    const size_t len = strcspn(text, "=");
    const size_t n = len < LUM_KEY_BYTES ? len : 0;
    memcpy(out, text, n);
    out[n] = '\0';
}

static lum_result set(lum_keys *keys, const char *text, uint32_t place,
                      lum_key_refusal *why)
{
    char key[LUM_KEY_BYTES];
    copy_key(text, key);
    return lum_keys_set(keys, key, strchr(text, '=') + 1, place, why);
}

static size_t list_names(const lum_keys *keys, const char **names, size_t n)
{
    lum_key key;
    for (size_t i = 0; lum_keys_describe(keys, i, &key) == LUM_OK; i++) {
        if (n < NAMES_MAX) {
            names[n++] = key.name;
        }
    }
    return n;
}

static const char *find_near(const char *key)
{
    const char *names[NAMES_MAX];
    lum_keys keys;
    lum_keys_of_calibration(&keys, NULL);
    size_t n = list_names(&keys, names, 0);
    lum_keys_of_profile(&keys, NULL);
    n = list_names(&keys, names, n);
    return nearest(key, names, n);
}

/* A key that neither has, or has with keys below it: what they say of it. */
static bool refuse_key(const char *text, const lum_key_refusal *calibration,
                       const lum_key_refusal *profile, lum_error *why)
{
    const lum_key_refusal *known =
        calibration->key[0] != '\0' ? calibration : profile;
    const size_t len = strcspn(text, "=");
    const int shown = (int)(len < SHOWN_MAX ? len : SHOWN_MAX);
    char key[LUM_KEY_BYTES];
    copy_key(text, key);
    const char *near = find_near(key);
    if (near != NULL) {
        (void)lum_error_set(why, "unknown key '%s'; did you mean '%s'?", key,
                            near);
    } else if (known->key[0] != '\0') {
        (void)lum_error_set(why, "%s: %s", known->key, known->text);
    } else {
        (void)lum_error_set(why,
                            "'%.*s' is not a key of a calibration or a "
                            "profile; see calib/typical.yaml and "
                            "calib/profile-default.yaml",
                            shown, text);
    }
    return false;
}

/* What could upset a terminal, or make two lines of a message, is in no key and
 * in no value. */
static bool refuse_bytes(const char *text, lum_error *why)
{
    char shown[SHOWN_MAX + 1u];
    (void)lum_error_set(
        why, "'%s': a key and its value are printable ASCII",
        printable((const uint8_t *)text, strlen(text), shown, sizeof shown));
    return false;
}

static bool is_printable(const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    while (*p >= 0x20 && *p < 0x7f) {
        p++;
    }
    return *p == '\0';
}

static bool refuse_value(const lum_key_refusal *refusal, lum_error *why)
{
    (void)lum_error_set(why, "%s: %s", refusal->key, refusal->text);
    return false;
}

bool set_keys_add(void *to, const char *text, lum_error *why)
{
    struct set_keys *keys = to;
    lum_keys known;
    lum_key_refusal of_calibration;
    lum_key_refusal of_profile;
    if (text[0] == '=' || strchr(text, '=') == NULL) {
        return false;
    }
    if (!is_printable(text)) {
        return refuse_bytes(text, why);
    }
    if (strncmp(text, "version=", 8) == 0) {
        (void)lum_error_set(why, "version is a key of files only");
        return false;
    }
    if (keys->count == SET_KEYS_MAX) {
        (void)lum_error_set(why, "more than %u settings", SET_KEYS_MAX);
        return false;
    }
    lum_keys_of_calibration(&known, NULL);
    lum_result result = set(&known, text, 1, &of_calibration);
    if (result == LUM_E_VALUE) {
        return refuse_value(&of_calibration, why);
    }
    const bool is_of_profile = result != LUM_OK;
    if (is_of_profile) {
        lum_keys_of_profile(&known, NULL);
        result = set(&known, text, 1, &of_profile);
    }
    if (result != LUM_OK) {
        return result == LUM_E_VALUE
                   ? refuse_value(&of_profile, why)
                   : refuse_key(text, &of_calibration, &of_profile, why);
    }
    keys->list[keys->count++] = (struct set_key){text, is_of_profile};
    return true;
}

const char *set_keys_first(const struct set_keys *keys, bool is_of_profile)
{
    for (size_t i = 0; i < keys->count; i++) {
        if (keys->list[i].is_of_profile == is_of_profile) {
            return keys->list[i].text;
        }
    }
    return NULL;
}

/* --- All of a kind --- */

static int refuse(const struct set_keys *keys, const lum_key_refusal *why,
                  lum_error *error)
{
    if (why->place > 0 && why->place <= keys->count) {
        return lum_error_set(error, "--set %.120s: %s",
                             keys->list[why->place - 1u].text, why->text);
    }
    return lum_error_set(error, "--set: %s", why->text);
}

/* What comes later has a higher place. */
static lum_result set_all(const struct set_keys *keys, bool is_of_profile,
                          lum_keys *to, lum_key_refusal *why)
{
    lum_result result = LUM_OK;
    for (size_t i = 0; i < keys->count && result == LUM_OK; i++) {
        if (keys->list[i].is_of_profile == is_of_profile) {
            result = set(to, keys->list[i].text, (uint32_t)i + 1u, why);
        }
    }
    return result;
}

int set_keys_calibration(const struct set_keys *keys, bool is_usual,
                         lum_calibration *calibration, lum_error *error)
{
    lum_keys all;
    lum_key_refusal why;
    if (set_keys_first(keys, false) == NULL) {
        return 0;
    }
    lum_keys_of_calibration(&all, is_usual ? NULL : calibration);
    return set_all(keys, false, &all, &why) == LUM_OK &&
                   lum_keys_calibration(&all, calibration, &why) == LUM_OK
               ? 0
               : refuse(keys, &why, error);
}

int set_keys_profile(const struct set_keys *keys, bool is_usual,
                     lum_profile *profile, lum_error *error)
{
    lum_keys all;
    lum_key_refusal why;
    if (set_keys_first(keys, true) == NULL) {
        return 0;
    }
    lum_keys_of_profile(&all, is_usual ? NULL : profile);
    return set_all(keys, true, &all, &why) == LUM_OK &&
                   lum_keys_profile(&all, profile, &why) == LUM_OK
               ? 0
               : refuse(keys, &why, error);
}
