/* Clocks that wrap. */
#ifndef LUM_CORE_CLOCK_H
#define LUM_CORE_CLOCK_H

#include "lum/clock.h"

/* The same as lum_clock_extend(), for the lum_low_bits() of a clock. */
uint64_t lum_clock_follow(uint64_t before, uint64_t raw, uint64_t mask);

#endif
