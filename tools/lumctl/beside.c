#include "beside.h"

uint32_t beside_find(uint32_t device, beside_is_taken is_taken, void *context)
{
    for (uint32_t last = 1; last <= BESIDE_LAST; last++) {
        const uint32_t address = (device & BESIDE_MASK) | last;
        if (address != device && !is_taken(context, address)) {
            return address;
        }
    }
    return 0;
}
