/** @file
 * Seeded random numbers: the same on every machine, computed only with
 * integers.
 *
 * The generator is xoshiro256**, its state filled by splitmix64. A stream
 * number makes generators of one seed different, so that any line of any frame
 * can be rendered separately with the same result. */
#ifndef LUM_SIM_RANDOM_H
#define LUM_SIM_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

/** No normal number is further from 0 than this. */
#define LUM_RANDOM_NORMAL_MAX 3.4642f

/** One generator. Private except its size. */
typedef struct lum_random {
    uint64_t s[4]; /**< private; never all 0 */
} lum_random;

/** Begin a stream of a seed, with any two numbers. Cannot fail. */
void lum_random_init(lum_random *out, uint64_t seed, uint64_t stream);

/** The next 64 random bits. */
static inline uint64_t lum_random_next(lum_random *r)
{
    uint64_t *s = r->s;
    const uint64_t five = s[1] * 5u;
    const uint64_t result = ((five << 7) | (five >> 57)) * 9u;
    const uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = (s[3] << 45) | (s[3] >> 19);
    return result;
}

/** A number of [0, 1), in steps of 2^-24. */
static inline float lum_random_unit(lum_random *r)
{
    return (float)(int32_t)(lum_random_next(r) >> 40) * (1.0f / 16777216.0f);
}

/** A number of [low, high). */
float lum_random_between(lum_random *r, float low, float high);

/** An integer of 0..n-1; n at least 1. */
uint32_t lum_random_below(lum_random *r, uint32_t n);

/** True with probability p: never at 0, always at 1. */
bool lum_random_chance(lum_random *r, double p);

/** A nearly normal number of mean 0 and standard deviation 1: the sum of four
 * 16-bit numbers, so it is bounded by ::LUM_RANDOM_NORMAL_MAX. */
static inline float lum_random_normal(lum_random *r)
{
    const uint64_t x = lum_random_next(r);
    const int32_t sum = (int32_t)((x & 0xffffu) + ((x >> 16) & 0xffffu) +
                                  ((x >> 32) & 0xffffu) + (x >> 48));
    /* 4 x 65535 / 2 is the mean, 65536 / sqrt(3) the deviation. */
    return (float)(sum - 131070) * (1.0f / 37837.23f);
}

#endif
