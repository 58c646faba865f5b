#include "text.h"

#include "port.h"

#define DECIMALS_MAX 20u
#define HEX_DIGITS   16u

static void put_char(text *t, char c)
{
    if (t->len < TEXT_MAX - 1u) {
        t->line[t->len++] = c;
    }
}

void text_put(text *t, const char *s)
{
    while (*s != '\0') {
        put_char(t, *s++);
    }
}

void text_put_number(text *t, uint64_t value)
{
    char digits[DECIMALS_MAX];
    size_t n = 0;

    do {
        digits[n++] = (char)('0' + (int)(value % 10u));
        value /= 10u;
    } while (value > 0);
    while (n > 0) {
        put_char(t, digits[--n]);
    }
}

void text_put_signed(text *t, int64_t value)
{
    if (value < 0) {
        put_char(t, '-');
    }
    text_put_number(t, value < 0 ? 0u - (uint64_t)value : (uint64_t)value);
}

void text_put_hex(text *t, uint64_t value)
{
    static const char digits[] = "0123456789abcdef";

    for (unsigned i = HEX_DIGITS; i-- > 0;) {
        put_char(t, digits[(value >> (4u * i)) & 0xfu]);
    }
}

void text_pad(text *t, size_t column)
{
    while (t->len < column && t->len < TEXT_MAX - 1u) {
        put_char(t, ' ');
    }
}

void text_end(text *t)
{
    t->line[t->len++] = '\n';
    (void)port_write(t->line, t->len);
    t->len = 0;
}
