/* A clock read again and again: any reading, of any width. The extended clock
 * moves by half a wrap at most, so no addition overflows within 2^62. */
#include "lum/clock.h"
#include "unknown.h"

#define REACH (INT64_C(1) << 62)

void main(void)
{
    const int64_t before = any_i64(-REACH, REACH);
    const uint32_t raw = any_u32(0, UINT32_MAX);
    const uint32_t bytes = any_u32(0, 4);
    if (bytes != 3) {
        //@ split bytes;
        const int64_t after = lum_clock_extend(before, raw, bytes);
        //@ assert -REACH - 0x80000000 <= after <= REACH + 0x7fffffff;
    }
}
