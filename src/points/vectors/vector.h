/* The words of vector code, for vectors of LUM_LANES numbers: 4, 8 or 16. They
 * are made of what gcc and clang offer for every processor, so that no
 * instruction has to be named. Included by a file that has chosen its
 * processor. */
#ifndef LUM_POINTS_VECTOR_H
#define LUM_POINTS_VECTOR_H

#include "lum/points.h"

#include <stdint.h>
#include <string.h>

#define LUM_VECTOR_BYTES (4 * LUM_LANES)

typedef float number __attribute__((vector_size(LUM_VECTOR_BYTES)));
typedef int32_t whole __attribute__((vector_size(LUM_VECTOR_BYTES)));
typedef uint32_t bits __attribute__((vector_size(LUM_VECTOR_BYTES)));

#if defined(LUM_HAS_NEON)
#include <arm_neon.h>
#else
#include <immintrin.h>
#endif

#include "../arithmetic.h"

/* Four neighbours of a vector are a group. A point or a direction, which has
 * four numbers, is a group too. */
#define GROUPS (LUM_LANES / 4)

/* Within each group: the lower numbers of a and b in turn, and the higher. */
#if LUM_LANES == 4
#define LOWER(a, b)       __builtin_shufflevector(a, b, 0, 4, 1, 5)
#define HIGHER(a, b)      __builtin_shufflevector(a, b, 2, 6, 3, 7)
#define LOWER_PAIR(a, b)  __builtin_shufflevector(a, b, 0, 1, 4, 5)
#define HIGHER_PAIR(a, b) __builtin_shufflevector(a, b, 2, 3, 6, 7)
#elif LUM_LANES == 8
#define LOWER(a, b)      __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define HIGHER(a, b)     __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define LOWER_PAIR(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define HIGHER_PAIR(a, b)                                                      \
    __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#else
#define LOWER(a, b)                                                            \
    __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25,    \
                            12, 28, 13, 29)
#define HIGHER(a, b)                                                           \
    __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27,  \
                            14, 30, 15, 31)
#define LOWER_PAIR(a, b)                                                       \
    __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25,    \
                            12, 13, 28, 29)
#define HIGHER_PAIR(a, b)                                                      \
    __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27,  \
                            14, 15, 30, 31)
#endif

/* Numbers in the order in which turn_groups() needs them: group g of the result
 * has number GROUPS * r + g of v in its place r. */
#if LUM_LANES == 4
#define SPREAD(v) (v)
#elif LUM_LANES == 8
#define SPREAD(v) __builtin_shufflevector(v, v, 0, 2, 4, 6, 1, 3, 5, 7)
#else
#define SPREAD(v)                                                              \
    __builtin_shufflevector(v, v, 0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3,   \
                            7, 11, 15)
#endif

LUM_IN_LOOP whole load_whole(const void *from)
{
    whole v;
    memcpy(&v, from, sizeof v);
    return v;
}

LUM_IN_LOOP number load_number(const void *from)
{
    number v;
    memcpy(&v, from, sizeof v);
    return v;
}

LUM_IN_LOOP void store_number(void *to, number v)
{
    memcpy(to, &v, sizeof v);
}

LUM_IN_LOOP number to_number(whole v)
{
    return __builtin_convertvector(v, number);
}

#if LUM_LANES == 4
/* The direction of a word. */
LUM_IN_LOOP number load_directions(const lum_direction *directions,
                                   const uint32_t *words, unsigned step)
{
    (void)step;
    return load_number(&directions[lum_word_pixel(words[0])]);
}
#else
LUM_IN_LOOP __m128 load_direction(const lum_direction *directions,
                                  uint32_t word)
{
    return _mm_loadu_ps(&directions[lum_word_pixel(word)].x);
}

/* The directions of GROUPS words, of which one in step counts. */
LUM_IN_LOOP number load_directions(const lum_direction *directions,
                                   const uint32_t *words, unsigned step)
{
    const __m128 a = load_direction(directions, words[0]);
    const __m128 b = load_direction(directions, words[step]);
    const __m256 ab = _mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1);
#if LUM_LANES == 8
    return (number)ab;
#else
    const __m128 c = load_direction(directions, words[2u * step]);
    const __m128 d = load_direction(directions, words[3u * step]);
    const __m256 cd = _mm256_insertf128_ps(_mm256_castps128_ps256(c), d, 1);
    return (number)_mm512_insertf32x8(_mm512_castps256_ps512(ab), cd, 1);
#endif
}

typedef int32_t eight __attribute__((vector_size(32)));

LUM_IN_LOOP eight load_eight(const uint32_t *from)
{
    eight v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* The places of the bits that are set in m, the lowest first, a byte each: row
 * m of a table of 256. */
#define PLACE(m, bit)                                                          \
    (((m) >> (bit)&1u) != 0                                                    \
         ? UINT64_C(bit) << 8 * __builtin_popcount((m) & ((1u << (bit)) - 1u)) \
         : 0)
#define ROW(m)                                                                 \
    (PLACE(m, 0) | PLACE(m, 1) | PLACE(m, 2) | PLACE(m, 3) | PLACE(m, 4) |     \
     PLACE(m, 5) | PLACE(m, 6) | PLACE(m, 7))
#define ROWS_4(m) ROW(m), ROW((m) + 1u), ROW((m) + 2u), ROW((m) + 3u)
#define ROWS_16(m)                                                             \
    ROWS_4(m), ROWS_4((m) + 4u), ROWS_4((m) + 8u), ROWS_4((m) + 12u)
#define ROWS_64(m)                                                             \
    ROWS_16(m), ROWS_16((m) + 16u), ROWS_16((m) + 32u), ROWS_16((m) + 48u)
static const uint64_t places[256] = {ROWS_64(0u), ROWS_64(64u), ROWS_64(128u),
                                     ROWS_64(192u)};

/* Writes eight words, those first whose place in chosen is not 0; their number.
 */
LUM_IN_LOOP uint32_t store_chosen(uint32_t *to, eight words, eight chosen)
{
    const unsigned set = (unsigned)_mm256_movemask_ps((__m256)chosen);
    const void *row = &places[set];
    const __m256i order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(row));
    const __m256i v = _mm256_permutevar8x32_epi32((__m256i)words, order);
    memcpy(to, &v, sizeof v);
    return (uint32_t)__builtin_popcount(set);
}

/* GROUPS words, each in all places of its group. */
LUM_IN_LOOP whole load_to_groups(const uint32_t *words)
{
#if LUM_LANES == 8
    uint64_t both;
    memcpy(&both, words, sizeof both);
    const whole w = (whole)_mm256_set1_epi64x((int64_t)both);
    return __builtin_shufflevector(w, w, 0, 0, 0, 0, 5, 5, 5, 5);
#else
    const void *from = words;
    const whole w = (whole)_mm512_broadcast_i32x4(_mm_loadu_si128(from));
    return __builtin_shufflevector(w, w, 0, 0, 0, 0, 5, 5, 5, 5, 10, 10, 10, 10,
                                   15, 15, 15, 15);
#endif
}

/* a, with the fourth number of each group from b. */
#if LUM_LANES == 8
#define WITH_FOURTH(a, b)                                                      \
    __builtin_shufflevector(a, b, 0, 1, 2, 11, 4, 5, 6, 15)
#else
#define WITH_FOURTH(a, b)                                                      \
    __builtin_shufflevector(a, b, 0, 1, 2, 19, 4, 5, 6, 23, 8, 9, 10, 27, 12,  \
                            13, 14, 31)
#endif
#endif

/* Four columns to rows of four, or the other way: number r of each group of
 * column c becomes number c of the same group of row r. */
LUM_IN_LOOP void turn_groups(number v[4])
{
    const number a = LOWER(v[0], v[1]);
    const number b = LOWER(v[2], v[3]);
    const number c = HIGHER(v[0], v[1]);
    const number d = HIGHER(v[2], v[3]);
    v[0] = LOWER_PAIR(a, b);
    v[1] = HIGHER_PAIR(a, b);
    v[2] = LOWER_PAIR(c, d);
    v[3] = HIGHER_PAIR(c, d);
}

#endif
