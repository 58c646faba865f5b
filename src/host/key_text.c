#include "key_text.h"

#include <stdbool.h>

#define QUOTED_MAX   55 /* bytes after which a quotation is cut */
#define DIGITS_MAX   20 /* of 64 bits */
#define DECIMALS_MAX 12

lum_key_text lum_key_text_begin(char *out, size_t size)
{
    const lum_key_text text = {out, size, 0};
    if (size > 0) {
        out[0] = '\0';
    }
    return text;
}

static void add_char(lum_key_text *text, char c)
{
    if (text->len + 1 < text->size) {
        text->out[text->len] = c;
        text->out[text->len + 1] = '\0';
    }
    text->len++;
}

void lum_key_text_add(lum_key_text *text, const char *string)
{
    for (; *string != '\0'; string++) {
        add_char(text, *string);
    }
}

void lum_key_text_add_bytes(lum_key_text *text, const char *bytes, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        add_char(text, bytes[i]);
    }
}

void lum_key_text_add_number(lum_key_text *text, int64_t number, int decimals)
{
    uint64_t rest =
        number < 0 ? UINT64_C(0) - (uint64_t)number : (uint64_t)number;
    char digits[DIGITS_MAX + DECIMALS_MAX]; /* the last one first */
    int count = 0;
    int end = 0;
    while (count <= decimals || rest > 0) {
        digits[count++] = (char)('0' + (char)(rest % 10));
        rest /= 10;
    }
    while (end < decimals && digits[end] == '0') {
        end++;
    }
    lum_key_text_add(text, number < 0 ? "-" : "");
    for (int i = count - 1; i >= end; i--) {
        lum_key_text_add(text, i == decimals - 1 ? "." : "");
        add_char(text, digits[i]);
    }
}

void lum_key_text_add_quoted(lum_key_text *text, const char *bytes, size_t len)
{
    static const char hex[] = "0123456789abcdef";
    const size_t start = text->len;
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)bytes[i];
        if (text->len - start > QUOTED_MAX) {
            lum_key_text_add(text, "...");
            return;
        }
        if (c >= 0x20 && c < 0x7f) {
            add_char(text, (char)c);
        } else {
            lum_key_text_add(text, "\\x");
            add_char(text, hex[c >> 4]);
            add_char(text, hex[c & 15u]);
        }
    }
}

size_t lum_key_text_length(const char *string)
{
    const char *end = string;
    while (*end != '\0') {
        end++;
    }
    return (size_t)(end - string);
}
