/* Structs of a caller's that begin with their size. */
#ifndef LUM_FRAME_SIZED_H
#define LUM_FRAME_SIZED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Fill a caller's struct as far as the caller knows it; its size stays.
 * out: begins with its size, as from does. False: that is not set; then nothing
 * is written. */
static inline bool lum_sized_fill(void *out, const void *from, size_t from_size)
{
    size_t n = 0;
    memcpy(&n, out, sizeof n);
    n = n < from_size ? n : from_size;
    if (n <= sizeof n) {
        return false;
    }
    memcpy((uint8_t *)out + sizeof n, (const uint8_t *)from + sizeof n,
           n - sizeof n);
    return true;
}

#endif
