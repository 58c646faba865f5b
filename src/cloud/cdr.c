#include "cdr.h"

#include "le.h"

lum_cdr lum_cdr_begin(lum_bytes *out)
{
    static const unsigned char plain_le[4] = {0, 1, 0, 0};
    lum_bytes_put(out, plain_le, sizeof plain_le);
    return (lum_cdr){out, out->len};
}

/* Zeros up to a multiple of n. */
static void align(const lum_cdr *cdr, size_t n)
{
    static const unsigned char zeros[8] = {0};
    const size_t over = (cdr->out->len - cdr->base) % n;
    lum_bytes_put(cdr->out, zeros, over == 0 ? 0 : n - over);
}

void lum_cdr_put_u8(lum_cdr *cdr, uint8_t v)
{
    lum_bytes_put_u8(cdr->out, v);
}

void lum_cdr_put_u16(lum_cdr *cdr, uint16_t v)
{
    align(cdr, 2);
    lum_bytes_put_u16(cdr->out, v);
}

void lum_cdr_put_u32(lum_cdr *cdr, uint32_t v)
{
    align(cdr, 4);
    lum_bytes_put_u32(cdr->out, v);
}

void lum_cdr_put_f64(lum_cdr *cdr, double v)
{
    unsigned char number[8];
    align(cdr, 8);
    (void)lum_put_f64(number, v);
    lum_bytes_put(cdr->out, number, sizeof number);
}

void lum_cdr_put_bytes(lum_cdr *cdr, const void *bytes, size_t n)
{
    lum_bytes_put(cdr->out, bytes, n);
}

void lum_cdr_put_string(lum_cdr *cdr, const char *text)
{
    const size_t n = strlen(text) + 1u;
    lum_cdr_put_u32(cdr, (uint32_t)n);
    lum_bytes_put(cdr->out, text, n);
}
