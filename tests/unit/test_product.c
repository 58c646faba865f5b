#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/product.h"

#include "support.h"

/* Products by parts against those of 64 bits. */

static void check(int32_t a, int32_t b)
{
    const int64_t all = (int64_t)a * b;
    assert_true(lum_product_by_parts(a, b) == all);
    /* rounded down */
    int64_t high = all / INT64_C(4294967296);
    high -= all % INT64_C(4294967296) < 0 ? 1 : 0;
    assert_true(lum_high_by_parts(a, b, 0) == high);
    assert_true(lum_high_by_parts(a, b, -7) == high - 7);
    assert_true(high_product(a, b, 0) == high);
    assert_true(product(a, b) == all);
    const uint64_t natural = (uint64_t)(uint32_t)a * (uint32_t)b;
    assert_true(lum_unsigned_by_parts((uint32_t)a, (uint32_t)b) == natural);
    assert_true(product_unsigned((uint32_t)a, (uint32_t)b) == natural);
}

static void limits_are_multiplied(void **state)
{
    static const int32_t limits[] = {
        0,          1,          -1,          2,         -2,       0x7fff,
        0x8000,     0x8001,     -0x7fff,     -0x8000,   -0x8001,  0xffff,
        0x10000,    0x10001,    -0xffff,     -0x10000,  -0x10001, 0x7fff0000,
        0x7fff8000, 0x7fffffff, -0x7fffffff, INT32_MIN, 1 << 30,  -(1 << 30)};
    const unsigned n = sizeof limits / sizeof limits[0];
    (void)state;
    for (unsigned i = 0; i < n; i++) {
        for (unsigned k = 0; k < n; k++) {
            check(limits[i], limits[k]);
        }
    }
}

static void numbers_of_chance_are_multiplied(void **state)
{
    uint64_t seed = 1;
    (void)state;
    for (unsigned i = 0; i < 1000000u; i++) {
        const unsigned shift = i % 31u;
        const uint32_t a = next_random(&seed) << 1 ^ next_random(&seed);
        const uint32_t b = next_random(&seed) << 1 ^ next_random(&seed);
        check((int32_t)(a >> 1) >> shift, (int32_t)(b >> 1) - (1 << 30));
        check(-(int32_t)(a >> 1) >> shift, -(int32_t)(b >> 1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_are_multiplied),
        cmocka_unit_test(numbers_of_chance_are_multiplied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
