#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/random.h"
#include "kernel/world.h"

#include <stdlib.h>

#define SEEDS  200u
#define VALUES 500u

static int by_value(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return left < right ? -1 : left > right ? 1 : 0;
}

/* A value that comes twice would be that of a stream which goes on where
 * another one began. */
static void assert_all_differ(uint64_t *values, size_t count)
{
    qsort(values, count, sizeof *values, by_value);
    for (size_t i = 1; i < count; i++) {
        assert_true(values[i] != values[i - 1]);
    }
}

static void streams_of_neighbouring_seeds_have_nothing_in_common(void **state)
{
    static uint64_t values[SEEDS * VALUES];
    (void)state;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        world_random random = world_stream_under(seed, "dice", 0);
        for (uint64_t i = 0; i < VALUES; i++) {
            values[seed * VALUES + i] = world_random_u64(&random);
        }
    }
    assert_all_differ(values, SEEDS * VALUES);
}

static void streams_of_neighbouring_numbers_have_nothing_in_common(void **state)
{
    static uint64_t values[SEEDS * VALUES];
    (void)state;
    world_begin(1);
    for (uint64_t number = 0; number < SEEDS; number++) {
        world_random random = world_stream("link", number);
        for (uint64_t i = 0; i < VALUES; i++) {
            values[number * VALUES + i] = world_random_u64(&random);
        }
    }
    world_end();
    assert_all_differ(values, SEEDS * VALUES);
}

static void a_stream_is_that_of_its_seed_and_name(void **state)
{
    (void)state;
    world_begin(7);
    world_random ours = world_stream("link", 3);
    world_random same = world_stream_under(7, "link", 3);
    world_random other = world_stream_under(7, "disk", 3);
    const uint64_t value = world_random_u64(&ours);
    assert_true(value == world_random_u64(&same));
    assert_true(value != world_random_u64(&other));
    world_end();
}

static void bounds_are_included(void **state)
{
    unsigned seen = 0;
    (void)state;
    world_random random = world_stream_under(1, "bounds", 0);
    for (unsigned i = 0; i < 1000; i++) {
        const int64_t value = world_random_between(&random, -1, 2);
        assert_in_range(value + 1, 0, 3);
        seen |= 1u << (value + 1);
    }
    assert_int_equal(seen, 15);
    assert_false(world_random_chance(&random, 0));
    assert_true(world_random_chance(&random, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(streams_of_neighbouring_seeds_have_nothing_in_common),
        cmocka_unit_test(
            streams_of_neighbouring_numbers_have_nothing_in_common),
        cmocka_unit_test(a_stream_is_that_of_its_seed_and_name),
        cmocka_unit_test(bounds_are_included),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
