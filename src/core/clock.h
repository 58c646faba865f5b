/* Clocks that wrap. */
#ifndef LUM_CORE_CLOCK_H
#define LUM_CORE_CLOCK_H

#include "lum/clock.h"

/* All bits of a clock, 0..63. */
uint64_t lum_clock_mask(unsigned bits);

/* The same as lum_clock_extend(), for its mask. */
uint64_t lum_clock_follow(uint64_t before, uint64_t raw, uint64_t mask);

#endif
