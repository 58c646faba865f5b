/* Counters that never wrap, for targets where 64 bits are expensive. */
#ifndef LUM_CORE_COUNTER_H
#define LUM_CORE_COUNTER_H

#include <stdint.h>

void lum_counter_add(uint64_t *counter, uint32_t n);

#endif
