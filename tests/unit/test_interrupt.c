#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/interrupt.h"

#include <signal.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    AS_EXPECTED = 41
};

/* Signals are for a whole process: each fact has its own. The status with which
 * it ends, or the signal's number and 128. */
static int in_process(bool (*fact)(void))
{
    int status = 0;
    const pid_t child = fork();
    if (child == 0) {
        interrupt_catch();
        interrupt_insist();
        _exit(fact() ? AS_EXPECTED : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

/* What ends by itself was never held. */
static bool give_up_before_a_hold(void)
{
    const lum_cancel *second = interrupt_second();
    if (second == NULL) {
        return false;
    }
    (void)raise(SIGINT);
    interrupt_hold();
    const bool is_early = lum_cancel_is_raised(second);
    (void)raise(SIGINT);
    return !is_early && second == interrupt_second() &&
           lum_cancel_is_raised(second);
}

static void what_was_never_held_can_be_given_up(void **state)
{
    (void)state;
    assert_int_equal(in_process(give_up_before_a_hold), AS_EXPECTED);
}

static bool linger_after_none(void)
{
    interrupt_linger();
    const unsigned before = interrupt_count();
    (void)raise(SIGINT);
    return interrupt_signal() != 0 && interrupt_count() == before + 1u;
}

static bool linger_after_one(void)
{
    interrupt_hold();
    (void)raise(SIGTERM);
    interrupt_linger();
    return linger_after_none();
}

static void the_first_signal_of_what_lingers_is_noted(void **state)
{
    (void)state;
    assert_int_equal(in_process(linger_after_none), AS_EXPECTED);
    assert_int_equal(in_process(linger_after_one), AS_EXPECTED);
}

static bool linger_until_the_next(void)
{
    (void)linger_after_one();
    (void)raise(SIGTERM);
    return false;
}

static bool release_and_come_again(void)
{
    (void)raise(SIGINT);
    interrupt_linger();
    interrupt_release();
    (void)raise(SIGTERM);
    return false;
}

static void the_next_one_ends_the_process(void **state)
{
    (void)state;
    assert_int_equal(in_process(linger_until_the_next), 128 + SIGTERM);
    assert_int_equal(in_process(release_and_come_again), 128 + SIGINT);
}

static bool come_after_one_another(void)
{
    interrupt_hold();
    (void)raise(SIGINT);
    (void)raise(SIGTERM);
    (void)raise(SIGINT);
    return interrupt_signal() == SIGTERM;
}

static void a_ctrl_c_hides_no_other_signal(void **state)
{
    (void)state;
    assert_int_equal(in_process(come_after_one_another), AS_EXPECTED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_never_held_can_be_given_up),
        cmocka_unit_test(the_first_signal_of_what_lingers_is_noted),
        cmocka_unit_test(the_next_one_ends_the_process),
        cmocka_unit_test(a_ctrl_c_hides_no_other_signal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
