/* Any bytes as a calibration, a wire profile or settings, by the first byte
 * modulo 3. */
#include "lum/config/config.h"
#include "lum/config/settings.h"
#include "lum/host/keys.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static void require_message(const lum_error *error)
{
    const size_t len = strlen(error->text);
    require(len > 0 && len < sizeof error->text);
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)error->text[i];
        require(c >= 0x20 && c < 0x7f);
    }
}

static void require_untouched(const void *out, size_t size)
{
    const unsigned char *bytes = out;
    for (size_t i = 0; i < size; i++) {
        require(bytes[i] == 0xa5);
    }
}

/* What was read is written, and reads back as the same. */
static size_t write_keys(const lum_keys *keys, char text[LUM_KEYS_WRITE_BYTES])
{
    const size_t len = lum_keys_write(keys, text, LUM_KEYS_WRITE_BYTES);
    require(len < LUM_KEYS_WRITE_BYTES && len == strlen(text));
    return len;
}

static void rewrite_calibration(const lum_calibration *c)
{
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    lum_calibration again;
    lum_keys_of_calibration(&keys, c);
    const size_t len = write_keys(&keys, text);
    require(lum_calibration_parse(text, len, "fuzz", &again, NULL) == 0);
    require(memcmp(c, &again, sizeof again) == 0);
}

static void rewrite_profile(const lum_profile *p)
{
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    lum_profile again;
    lum_keys_of_profile(&keys, p);
    const size_t len = write_keys(&keys, text);
    require(lum_profile_parse(text, len, "fuzz", &again, NULL) == 0);
    require(memcmp(p, &again, sizeof again) == 0);
}

static void try_calibration(const char *text, size_t len)
{
    lum_calibration c;
    lum_error error = {""};
    memset(&c, 0xa5, sizeof c);
    if (lum_calibration_parse(text, len, "fuzz", &c, &error) == 0) {
        require(lum_calibration_check(&c, NULL, NULL) == LUM_OK);
        rewrite_calibration(&c);
        require(error.text[0] == '\0');
    } else {
        require_message(&error);
        require_untouched(&c, sizeof c);
    }
}

static void try_profile(const char *text, size_t len)
{
    lum_profile p;
    lum_layout layout;
    lum_error error = {""};
    memset(&p, 0xa5, sizeof p);
    if (lum_profile_parse(text, len, "fuzz", &p, &error) == 0) {
        require(lum_layout_init(&layout, &p, NULL, NULL) == LUM_OK);
        rewrite_profile(&p);
        require(error.text[0] == '\0');
    } else {
        require_message(&error);
        require_untouched(&p, sizeof p);
    }
}

static void require_commands(const lum_settings *s)
{
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command command = {(lum_command_id)id, s->value[id]};
        char text[LUM_COMMAND_TEXT_BYTES];
        size_t len = 0;
        require(!s->has[id] ||
                lum_command_format(&command, text, &len) == LUM_OK);
    }
    require(!s->has[LUM_COMMAND_LASER_ON] && !s->has[LUM_COMMAND_LASER_OFF]);
    require(!s->has_shape || !s->has[LUM_COMMAND_YSCAN]);
}

static void require_shape(const lum_yscan_shape *shape)
{
    enum {
        LINES = 64,
        MARGIN = 90000001
    };
    int32_t udeg[LINES];
    require(lum_yscan_make(shape, -MARGIN, MARGIN, udeg, LINES) == LUM_OK);
    for (unsigned i = 1; i < LINES; i++) {
        require(udeg[i] <= udeg[i - 1]);
    }
}

static void try_settings(const char *text, size_t len)
{
    lum_settings s;
    lum_error error = {""};
    memset(&s, 0xa5, sizeof s);
    if (lum_settings_parse(text, len, "fuzz", &s, &error) == 0) {
        require_commands(&s);
        require(error.text[0] == '\0');
        if (s.has_shape) {
            require_shape(&s.shape);
        }
    } else {
        require_message(&error);
        require_untouched(&s, sizeof s);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    static void (*const tries[])(const char *text, size_t len) = {
        try_calibration, try_profile, try_settings};
    tries[data[0] % 3u]((const char *)data + 1, size - 1);
    return 0;
}
