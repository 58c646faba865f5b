/* A world from its first moment to its end. Only one exists at a time. */
#ifndef WORLD_WORLD_H
#define WORLD_WORLD_H

#include <stdint.h>

/* Empties everything: time 0, no hosts, no processes, the chances of a seed. */
void world_begin(uint64_t seed);

/* Frees what the world holds. */
void world_end(void);

uint64_t world_seed(void);

#endif
