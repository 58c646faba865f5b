/* Any bytes as a calibration (first byte even) or a wire profile (odd). */
#include "lum/io/config.h"

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

static void try_calibration(const char *text, size_t len)
{
    lum_calibration c;
    lum_error error = {""};
    memset(&c, 0xa5, sizeof c);
    if (lum_calibration_parse(text, len, "fuzz", &c, &error) == 0) {
        require(lum_calibration_check(&c, NULL, NULL) == LUM_OK);
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
        require(error.text[0] == '\0');
    } else {
        require_message(&error);
        require_untouched(&p, sizeof p);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    if (data[0] % 2u == 0) {
        try_calibration((const char *)data + 1, size - 1);
    } else {
        try_profile((const char *)data + 1, size - 1);
    }
    return 0;
}
