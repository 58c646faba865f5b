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
#include <immintrin.h>

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
