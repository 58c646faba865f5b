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

/* Number of bytes of the UTF-8 sequence with this first byte, and the range of
 * its second byte, which excludes overlong forms, surrogates and values beyond
 * Unicode. */
static const struct {
    unsigned char first;
    unsigned char last;
    unsigned char bytes;
    unsigned char second_min;
    unsigned char second_max;
} sequences[] = {
    {0x00u, 0x7fu, 1, 0x00u, 0xffu}, {0xc2u, 0xdfu, 2, 0x80u, 0xbfu},
    {0xe0u, 0xe0u, 3, 0xa0u, 0xbfu}, {0xe1u, 0xecu, 3, 0x80u, 0xbfu},
    {0xedu, 0xedu, 3, 0x80u, 0x9fu}, {0xeeu, 0xefu, 3, 0x80u, 0xbfu},
    {0xf0u, 0xf0u, 4, 0x90u, 0xbfu}, {0xf1u, 0xf3u, 4, 0x80u, 0xbfu},
    {0xf4u, 0xf4u, 4, 0x80u, 0x8fu},
};

/* The sequence's length, or 0 where it breaks off. */
static size_t continue_utf8(const unsigned char *p, size_t n)
{
    for (size_t i = 2; i < n; i++) {
        if ((p[i] & 0xc0u) != 0x80u) {
            return 0;
        }
    }
    return n;
}

size_t utf8_length(const unsigned char *p)
{
    for (size_t i = 0; i < sizeof sequences / sizeof sequences[0]; i++) {
        if (p[0] >= sequences[i].first && p[0] <= sequences[i].last) {
            return p[1] >= sequences[i].second_min &&
                           p[1] <= sequences[i].second_max
                       ? continue_utf8(p, sequences[i].bytes)
                       : 0;
        }
    }
    return 0;
}

uint32_t utf8_character(const unsigned char *p, size_t length)
{
    if (length == 1) {
        return p[0];
    }
    uint32_t c = p[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        c = c << 6 | (p[i] & 0x3fu);
    }
    return c;
}
