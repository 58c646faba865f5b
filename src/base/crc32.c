#include "base/crc32.h"

#include "crc32_clmul.h"

#define POLYNOMIAL UINT32_C(0xedb88320)

void lum_crc32_init(lum_crc32 *crc)
{
    crc->has_clmul = lum_crc32_has_clmul();
    for (uint32_t b = 0; b < 256u; b++) {
        uint32_t v = b;
        for (unsigned bit = 0; bit < 8u; bit++) {
            v = v >> 1 ^ ((v & 1u) != 0 ? POLYNOMIAL : 0u);
        }
        crc->table[0][b] = v;
    }
    for (unsigned k = 1; k < 16u; k++) {
        for (unsigned b = 0; b < 256u; b++) {
            const uint32_t v = crc->table[k - 1u][b];
            crc->table[k][b] = v >> 8 ^ crc->table[0][v & 0xffu];
        }
    }
}

static uint32_t word_at(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

/* Four bytes, the first of them with k more behind them in the step. */
static uint32_t fold(const uint32_t (*t)[256], unsigned k, uint32_t word)
{
    return t[k][word & 0xffu] ^ t[k - 1u][word >> 8 & 0xffu] ^
           t[k - 2u][word >> 16 & 0xffu] ^ t[k - 3u][word >> 24];
}

/* Sixteen bytes a step: each waits for the one before. */
uint32_t lum_crc32_add(const lum_crc32 *crc, uint32_t value, const void *bytes,
                       size_t n)
{
    const uint32_t(*t)[256] = crc->table;
    const unsigned char *p = bytes;
    uint32_t v = ~value;
    if (crc->has_clmul && n >= LUM_CRC32_CLMUL_LEAST) {
        const size_t most = n - n % LUM_CRC32_CLMUL_STEP;
        v = lum_crc32_clmul(v, p, most);
        p += most;
        n -= most;
    }
    for (; n >= 16u; n -= 16u, p += 16) {
        v = fold(t, 15, v ^ word_at(p)) ^ fold(t, 11, word_at(p + 4)) ^
            fold(t, 7, word_at(p + 8)) ^ fold(t, 3, word_at(p + 12));
    }
    for (; n > 0; n--, p++) {
        v = v >> 8 ^ t[0][(v ^ *p) & 0xffu];
    }
    return ~v;
}
