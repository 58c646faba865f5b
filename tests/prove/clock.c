/* A clock read again and again: any reading, of any width. The extended clock
 * moves by half a wrap at most, in numbers that do not wrap themselves. Any
 * ticks of any length are microseconds. */
#include "lum/clock.h"
#include "lum/profile.h"
#include "unknown.h"

#define FIRST (UINT64_C(1) << 62)
#define LAST  (UINT64_C(1) << 63)

static void extend(uint32_t bits)
{
    const uint64_t half = bits > 0 ? UINT64_C(1) << (bits - 1u) : 0;
    const uint64_t raw = any_u64(0, UINT64_MAX);
    const uint64_t after = lum_clock_extend(any_u64(FIRST, LAST), raw, bits);
    //@ assert FIRST - half <= after <= LAST + half;
    //@ assert bits == 0 || after < LAST + half;
    (void)lum_clock_extend(any_u64(0, UINT64_MAX), raw, bits);
}

static void convert(void)
{
    const uint64_t few = any_u64(0, FIRST);
    const int64_t us = lum_clock_us(few, 1000);
    //@ assert 0 <= us <= FIRST;
    (void)lum_clock_us(any_u64(0, UINT64_MAX),
                       any_u32(1, LUM_CLOCK_UNIT_MAX_NS));
}

void main(void)
{
    const uint32_t bits = any_u32(0, 63);
    //@ split bits;
    extend(bits);
    //@ merge bits;
    convert();
}
