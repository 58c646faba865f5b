#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../tools/common/arrival.h"

#define NOW     INT64_C(5000)
#define NOW_UTC INT64_C(1900000000000000000)
#define TEN_S   INT64_C(10000000000)

static void a_stamp_tells_how_long_ago_it_was(void **state)
{
    (void)state;
    assert_true(arrival_ns(NOW_UTC - 700, NOW, NOW_UTC) == NOW - 700);
    assert_true(arrival_ns(NOW_UTC, NOW, NOW_UTC) == NOW);
    assert_true(arrival_ns(NOW_UTC - TEN_S, NOW, NOW_UTC) == NOW - TEN_S);
}

static void a_stamp_that_cannot_be_counts_as_now(void **state)
{
    (void)state;
    assert_true(arrival_ns(NOW_UTC + 1, NOW, NOW_UTC) == NOW);
    assert_true(arrival_ns(NOW_UTC - TEN_S - 1, NOW, NOW_UTC) == NOW);
    assert_true(arrival_ns(0, NOW, NOW_UTC) == NOW);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stamp_tells_how_long_ago_it_was),
        cmocka_unit_test(a_stamp_that_cannot_be_counts_as_now),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
