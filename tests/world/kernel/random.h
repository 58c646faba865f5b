/* Chances of the world. Each has its own stream, so that a step that is taken
 * out of a run does not change what befalls the rest. */
#ifndef WORLD_RANDOM_H
#define WORLD_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct world_random {
    uint64_t state;
} world_random;

/* The stream of a name ("link:eth0", "disk:bench") and a number under the
 * world's seed. */
world_random world_stream(const char *name, uint64_t number);
/* The same under any seed. Streams of two seeds have nothing in common. */
world_random world_stream_under(uint64_t seed, const char *name,
                                uint64_t number);

uint64_t world_random_u64(world_random *random);
/* 0 to below; below > 0. */
uint64_t world_random_below(world_random *random, uint64_t below);
/* low to high, both included. */
int64_t world_random_between(world_random *random, int64_t low, int64_t high);
/* True with a probability, 0 to 1. */
bool world_random_chance(world_random *random, double probability);

#endif
