#include "counter.h"

void lum_counter_add(uint64_t *counter, uint32_t n)
{
    *counter += n;
}
