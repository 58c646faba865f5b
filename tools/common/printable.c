#include "printable.h"

const char *printable(const uint8_t *bytes, size_t len, char *out, size_t size)
{
    size_t n = 0;
    for (; n < len && n + 1 < size; n++) {
        out[n] = (char)(bytes[n] >= 0x20 && bytes[n] < 0x7f ? bytes[n] : '?');
    }
    out[n] = '\0';
    return out;
}
