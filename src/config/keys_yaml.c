#include "host/keys_internal.h"
#include "lum/config/config.h"
#include "yaml.h"

static int read_keys(const lum_yaml_source *source, lum_keys *keys,
                     lum_error *error)
{
    return lum_yaml_read(source, lum_keys_table(keys), keys->values, error);
}

static int refuse(const lum_yaml_source *source, const lum_key_refusal *why,
                  lum_error *error)
{
    return lum_yaml_fail(error, source->name, why->place, why->key, "%s",
                         why->text);
}

int lum_calibration_parse(const char *text, size_t len, const char *name,
                          lum_calibration *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_keys keys;
    lum_key_refusal why;
    lum_keys_of_calibration(&keys, NULL);
    if (read_keys(&source, &keys, error) != 0) {
        return -1;
    }
    return lum_keys_calibration(&keys, out, &why) == LUM_OK
               ? 0
               : refuse(&source, &why, error);
}

int lum_profile_parse(const char *text, size_t len, const char *name,
                      lum_profile *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_keys keys;
    lum_key_refusal why;
    lum_keys_of_profile(&keys, NULL);
    if (read_keys(&source, &keys, error) != 0) {
        return -1;
    }
    if (keys.values[LUM_KEYS_VERSION].place == 0) {
        return lum_yaml_fail(error, name, 1, "version",
                             "missing; a profile needs 'version: 1'");
    }
    return lum_keys_profile(&keys, out, &why) == LUM_OK
               ? 0
               : refuse(&source, &why, error);
}
