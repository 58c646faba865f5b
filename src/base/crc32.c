#include "base/crc32.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define POLYNOMIAL UINT32_C(0xedb88320)

/* --- By multiplication without carries, where the processor has it --- */

/* Bytes that it takes at least, and a multiple of which. */
#define CLMUL_LEAST 64u
#define CLMUL_STEP  16u

/* 64 bytes are kept as a polynomial of four parts of 16 bytes. Each step
 * multiplies a part by what x^512 (or x^128, for one part) leaves when it is
 * divided by the polynomial of the CRC, and adds the next bytes to it. What is
 * left at the end is divided by Barrett's method. (V. Gopal and others, Fast
 * CRC Computation Using PCLMULQDQ Instruction, Intel 2009.) All numbers have
 * their lowest power in the highest bit. */
#if defined(__x86_64__)

#define CLMUL __attribute__((target("pclmul,sse4.1")))

static bool has_clmul(void)
{
    return __builtin_cpu_supports("pclmul") != 0 &&
           __builtin_cpu_supports("sse4.1") != 0;
}

/* A part, multiplied by the factors of its lower and its upper half. */
CLMUL static __m128i move_up(__m128i part, __m128i factors)
{
    return _mm_xor_si128(_mm_clmulepi64_si128(part, factors, 0x00),
                         _mm_clmulepi64_si128(part, factors, 0x11));
}

CLMUL static __m128i load(const unsigned char *p)
{
    return _mm_loadu_si128((const __m128i *)(const void *)p);
}

/* 128 bits to the 32 of the CRC. */
CLMUL static uint32_t reduce(__m128i part, __m128i by_128)
{
    const __m128i low_32 = _mm_setr_epi32(-1, 0, 0, 0);
    const __m128i by_64 = _mm_set_epi64x(0, 0x163cd6124);
    const __m128i barrett = _mm_set_epi64x(0x1f7011641, 0x1db710641);
    /* To 96 bits, to 64. */
    part = _mm_xor_si128(_mm_srli_si128(part, 8),
                         _mm_clmulepi64_si128(part, by_128, 0x10));
    part = _mm_xor_si128(
        _mm_srli_si128(part, 4),
        _mm_clmulepi64_si128(_mm_and_si128(part, low_32), by_64, 0x00));
    const __m128i quotient =
        _mm_clmulepi64_si128(_mm_and_si128(part, low_32), barrett, 0x10);
    const __m128i product =
        _mm_clmulepi64_si128(_mm_and_si128(quotient, low_32), barrett, 0x00);
    return (uint32_t)_mm_extract_epi32(_mm_xor_si128(part, product), 1);
}

CLMUL static uint32_t add_by_clmul(uint32_t value, const void *bytes, size_t n)
{
    const __m128i by_512 = _mm_set_epi64x(0x1c6e41596, 0x154442bd4);
    const __m128i by_128 = _mm_set_epi64x(0x0ccaa009e, 0x1751997d0);
    const unsigned char *p = bytes;
    __m128i parts[4];
    for (int i = 0; i < 4; i++) {
        parts[i] = load(p + 16 * i);
    }
    parts[0] = _mm_xor_si128(parts[0], _mm_cvtsi32_si128((int)value));
    for (p += 64, n -= 64u; n >= 64u; p += 64, n -= 64u) {
        for (int i = 0; i < 4; i++) {
            parts[i] =
                _mm_xor_si128(move_up(parts[i], by_512), load(p + 16 * i));
        }
    }
    __m128i one = parts[0];
    for (int i = 1; i < 4; i++) {
        one = _mm_xor_si128(move_up(one, by_128), parts[i]);
    }
    for (; n >= 16u; p += 16, n -= 16u) {
        one = _mm_xor_si128(move_up(one, by_128), load(p));
    }
    return reduce(one, by_128);
}

#else

static bool has_clmul(void)
{
    return false;
}

static uint32_t add_by_clmul(uint32_t value, const void *bytes, size_t n)
{
    (void)bytes;
    (void)n;
    return value;
}

#endif

/* --- By tables --- */

void lum_crc32_init(lum_crc32 *crc)
{
    crc->has_clmul = has_clmul();
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
    if (crc->has_clmul && n >= CLMUL_LEAST) {
        const size_t most = n - n % CLMUL_STEP;
        v = add_by_clmul(v, p, most);
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
