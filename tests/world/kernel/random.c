#include "random.h"

#include "world.h"

/* splitmix64 (Steele, Lea, Flood 2014): one addition and a mix. */
static uint64_t mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

uint64_t world_random_u64(world_random *random)
{
    random->state += UINT64_C(0x9e3779b97f4a7c15);
    return mix(random->state);
}

/* All is mixed, and not added: a stream is its first state plus a step for each
 * number, so streams that begin a step apart would be one. */
world_random world_stream_under(uint64_t seed, const char *name,
                                uint64_t number)
{
    uint64_t state = mix(seed + 1);
    for (const char *c = name; *c != '\0'; c++) {
        state = mix(state ^ (unsigned char)*c) + 1;
    }
    return (world_random){mix(state ^ number)};
}

world_random world_stream(const char *name, uint64_t number)
{
    return world_stream_under(world_seed(), name, number);
}

/* The remainder's bias is below 2^-32 for all that a story asks. */
uint64_t world_random_below(world_random *random, uint64_t below)
{
    return world_random_u64(random) % below;
}

int64_t world_random_between(world_random *random, int64_t low, int64_t high)
{
    return low +
           (int64_t)world_random_below(random, (uint64_t)(high - low) + 1u);
}

bool world_random_chance(world_random *random, double probability)
{
    const double unit = (double)(world_random_u64(random) >> 11) * 0x1p-53;
    return unit < probability;
}
