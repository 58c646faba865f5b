#include "random.h"

static uint64_t splitmix(uint64_t *x)
{
    uint64_t z = (*x += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

void lum_random_init(lum_random *out, uint64_t seed, uint64_t stream)
{
    uint64_t mixed = stream;
    uint64_t x = seed ^ splitmix(&mixed);
    for (unsigned i = 0; i < 4; i++) {
        out->s[i] = splitmix(&x);
    }
}

float lum_random_between(lum_random *r, float low, float high)
{
    return low + (high - low) * lum_random_unit(r);
}

uint32_t lum_random_below(lum_random *r, uint32_t n)
{
    return (uint32_t)(((lum_random_next(r) >> 32) * n) >> 32);
}

bool lum_random_chance(lum_random *r, double p)
{
    return (double)(lum_random_next(r) >> 11) * 0x1p-53 < p;
}
