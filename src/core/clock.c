#include "lum/clock.h"

int64_t lum_clock_extend(int64_t before, uint32_t raw, unsigned bytes)
{
    if (bytes == 0) {
        return before;
    }
    const uint32_t half = UINT32_C(1) << (8u * bytes - 1u);
    const uint32_t mask = half | (half - 1u);
    const uint32_t ahead = (raw - (uint32_t)((uint64_t)before)) & mask;
    return before + (int64_t)(ahead ^ half) - (int64_t)half;
}
