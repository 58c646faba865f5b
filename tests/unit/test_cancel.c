#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/base/time.h"
#include "lum/net/cancel.h"
#include "lum/net/socket.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#define NS_PER_MS INT64_C(1000000)

/* Long enough to be seen as a hang. */
#define A_MINUTE (60000 * NS_PER_MS)

static lum_cancel *in_handler;
static volatile sig_atomic_t handled;

static void raise_it(int signal)
{
    const int kept = errno;
    (void)signal;
    errno = EDOM;
    lum_cancel_raise(in_handler);
    handled = errno == EDOM ? 1 : 2;
    errno = kept;
}

static void only_count(int signal)
{
    (void)signal;
    handled = 1;
}

/* SIGALRM soon, and again and again if `every`. */
static void alarm_in(int ms, bool every, void (*handler)(int))
{
    struct sigaction action;
    struct itimerval timer = {.it_value = {.tv_usec = ms * 1000}};
    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    handled = 0;
    if (every) {
        timer.it_interval = timer.it_value;
    }
    assert_int_equal(sigaction(SIGALRM, &action, NULL), 0);
    assert_int_equal(setitimer(ITIMER_REAL, &timer, NULL), 0);
}

/* Under valgrind one that has come may still wait to be handled. */
static void no_alarm(void)
{
    const struct itimerval none = {.it_value = {0}};
    assert_int_equal(setitimer(ITIMER_REAL, &none, NULL), 0);
    signal(SIGALRM, SIG_IGN);
}

static lum_cancel *make(void)
{
    lum_cancel *cancel = NULL;
    lum_error error = {""};
    assert_int_equal(lum_cancel_new(&cancel, &error), 0);
    assert_string_equal(error.text, "");
    return cancel;
}

static lum_net_result wait_on(const lum_cancel *cancel, int64_t ns)
{
    return lum_socket_wait(NULL, 0, -1, cancel, lum_time_monotonic_ns() + ns);
}

static void a_cancel_stays_raised_until_it_is_reset(void **state)
{
    (void)state;
    lum_cancel *cancel = make();
    assert_false(lum_cancel_is_raised(cancel));
    assert_int_equal(wait_on(cancel, 0), LUM_NET_TIMEOUT);
    lum_cancel_raise(cancel);
    for (int i = 0; i < 3; i++) {
        assert_true(lum_cancel_is_raised(cancel));
        assert_int_equal(wait_on(cancel, A_MINUTE), LUM_NET_CANCELLED);
    }
    lum_cancel_reset(cancel);
    assert_false(lum_cancel_is_raised(cancel));
    assert_int_equal(wait_on(cancel, 0), LUM_NET_TIMEOUT);
    lum_cancel_raise(cancel);
    assert_true(lum_cancel_is_raised(cancel));
    lum_cancel_free(cancel);
}

static void a_deadline_that_has_passed_does_not_hide_a_cancel(void **state)
{
    (void)state;
    lum_cancel *cancel = make();
    lum_cancel_raise(cancel);
    assert_int_equal(lum_socket_wait(NULL, 0, -1, cancel, 0),
                     LUM_NET_CANCELLED);
    assert_int_equal(lum_socket_wait(NULL, 0, -1, cancel, INT64_MIN),
                     LUM_NET_CANCELLED);
    lum_cancel_free(cancel);
}

static void it_can_be_raised_more_often_than_a_pipe_holds(void **state)
{
    (void)state;
    lum_cancel *cancel = make();
    errno = EDOM;
    for (int i = 0; i < 200000; i++) {
        lum_cancel_raise(cancel);
    }
    assert_int_equal(errno, EDOM);
    assert_true(lum_cancel_is_raised(cancel));
    lum_cancel_reset(cancel);
    assert_false(lum_cancel_is_raised(cancel));
    lum_cancel_free(cancel);
}

static void no_cancel_is_never_raised(void **state)
{
    (void)state;
    lum_cancel_raise(NULL);
    assert_false(lum_cancel_is_raised(NULL));
    assert_int_equal(wait_on(NULL, 0), LUM_NET_TIMEOUT);
    lum_cancel_free(NULL);
}

static void a_signal_handler_ends_a_wait(void **state)
{
    (void)state;
    in_handler = make();
    alarm_in(30, false, raise_it);
    assert_int_equal(wait_on(in_handler, A_MINUTE), LUM_NET_CANCELLED);
    assert_int_equal(handled, 1);
    no_alarm();
    lum_cancel_free(in_handler);
}

static void a_signal_before_the_wait_ends_it_too(void **state)
{
    (void)state;
    in_handler = make();
    alarm_in(900, false, raise_it);
    assert_int_equal(raise(SIGALRM), 0);
    assert_int_equal(handled, 1);
    no_alarm();
    assert_int_equal(wait_on(in_handler, A_MINUTE), LUM_NET_CANCELLED);
    lum_cancel_free(in_handler);
}

static void signals_that_raise_nothing_do_not_shorten_a_wait(void **state)
{
    (void)state;
    lum_cancel *cancel = make();
    alarm_in(10, true, only_count);
    /* A slow host may be late for all of a wait. */
    for (int i = 0; i < 1000 && handled == 0; i++) {
        const int64_t deadline = lum_time_monotonic_ns() + 40 * NS_PER_MS;
        assert_int_equal(lum_socket_wait(NULL, 0, -1, cancel, deadline),
                         LUM_NET_TIMEOUT);
        assert_true(lum_time_monotonic_ns() >= deadline);
    }
    assert_int_equal(handled, 1);
    no_alarm();
    lum_cancel_free(cancel);
}

static void *raise_later(void *cancel)
{
    lum_time_sleep_until(lum_time_monotonic_ns() + 20 * NS_PER_MS);
    lum_cancel_raise(cancel);
    return NULL;
}

static void another_thread_ends_a_wait(void **state)
{
    pthread_t thread;
    (void)state;
    lum_cancel *cancel = make();
    assert_int_equal(pthread_create(&thread, NULL, raise_later, cancel), 0);
    assert_int_equal(wait_on(cancel, A_MINUTE), LUM_NET_CANCELLED);
    assert_true(lum_cancel_is_raised(cancel));
    assert_int_equal(pthread_join(thread, NULL), 0);
    lum_cancel_free(cancel);
}

static void programs_that_are_started_do_not_get_its_descriptors(void **state)
{
    (void)state;
    const int first = dup(STDIN_FILENO);
    close(first);
    lum_cancel *cancel = make();
    const int after = dup(STDIN_FILENO);
    close(after);
    assert_true(after > first);
    for (int fd = first; fd < after; fd++) {
        assert_int_equal(fcntl(fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
    }
    lum_cancel_free(cancel);
}

static void without_descriptors_there_is_a_message(void **state)
{
    struct rlimit old;
    lum_cancel *cancel = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &old), 0);
    const struct rlimit none = {.rlim_cur = 0, .rlim_max = old.rlim_max};
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    const int result = lum_cancel_new(&cancel, &error);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &old), 0);
    assert_int_equal(result, -1);
    assert_null(cancel);
    assert_non_null(strstr(error.text, "cannot make a pipe for a cancel: "));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cancel_stays_raised_until_it_is_reset),
        cmocka_unit_test(a_deadline_that_has_passed_does_not_hide_a_cancel),
        cmocka_unit_test(it_can_be_raised_more_often_than_a_pipe_holds),
        cmocka_unit_test(no_cancel_is_never_raised),
        cmocka_unit_test(a_signal_handler_ends_a_wait),
        cmocka_unit_test(a_signal_before_the_wait_ends_it_too),
        cmocka_unit_test(signals_that_raise_nothing_do_not_shorten_a_wait),
        cmocka_unit_test(another_thread_ends_a_wait),
        cmocka_unit_test(programs_that_are_started_do_not_get_its_descriptors),
        cmocka_unit_test(without_descriptors_there_is_a_message),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
