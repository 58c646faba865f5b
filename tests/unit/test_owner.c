#define _GNU_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "net/owner.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__linux__)
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#endif

/* What a child says that could not look. */
#define SKIPPED 77

/* A sensor only for this test: 127.61.2.x; several processes may run it at the
 * same time. */
static lum_endpoint sensor(uint8_t last)
{
    const uint32_t own = (uint32_t)getpid();
    return (lum_endpoint){
        .address = UINT32_C(0x7f3d0200) + last,
        .port = (uint16_t)(1024u + own % 60000u),
    };
}

static lum_owner *take(lum_endpoint who, const char *interface)
{
    lum_owner *owner = NULL;
    lum_error error = {""};
    assert_int_equal(lum_owner_take(who, interface, &owner, &error),
                     LUM_NET_OK);
    assert_string_equal(error.text, "");
    assert_non_null(owner);
    return owner;
}

static void expect_busy(lum_endpoint who, const char *interface,
                        const char *says)
{
    lum_owner *owner = NULL;
    lum_error error = {""};
    char address[64];
    snprintf(address, sizeof address, "session with 127.61.2.%u:%u ",
             (unsigned)(who.address & 0xffu), (unsigned)who.port);
    assert_int_equal(lum_owner_take(who, interface, &owner, &error),
                     LUM_NET_BUSY);
    assert_null(owner);
    if (strncmp(error.text, says, strlen(says)) != 0) {
        fail_msg("\"%s\" does not begin with \"%s\"", error.text, says);
    }
    assert_non_null(strstr(error.text, address));
}

static void a_second_session_of_a_program_is_refused(void **state)
{
    (void)state;
    lum_owner *owner = take(sensor(1), NULL);
    expect_busy(sensor(1), NULL, "this program has the session with");
    lum_owner_release(owner);
    lum_owner_release(NULL);
}

static void what_was_released_can_be_taken_again(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        lum_owner *owner = take(sensor(2), NULL);
        lum_owner_release(owner);
    }
}

static void other_sensors_and_ports_are_free(void **state)
{
    (void)state;
    lum_endpoint other_port = sensor(3);
    other_port.port++;
    lum_owner *owner[] = {take(sensor(3), NULL), take(other_port, NULL),
                          take(sensor(4), NULL)};
    for (size_t i = 0; i < 3; i++) {
        lum_owner_release(owner[i]);
    }
}

static void the_interface_of_the_route_is_the_same_as_by_name(void **state)
{
    (void)state;
    lum_owner *owner = take(sensor(5), NULL);
    expect_busy(sensor(5), "lo", "this program");
    lum_owner_release(take(sensor(5), "other0"));
    lum_owner_release(owner);
    owner = take(sensor(5), "lo");
    expect_busy(sensor(5), NULL, "this program");
    lum_owner_release(owner);
}

static void names_of_any_length_are_held(void **state)
{
    char name[300];
    (void)state;
    memset(name, 'x', sizeof name);
    name[2] = '/';
    name[sizeof name - 1u] = '\0';
    lum_owner *owner = take(sensor(6), name);
    expect_busy(sensor(6), name, "this program");
    lum_owner_release(owner);
}

/* A child that owns the sensor until it is killed. */
static pid_t start_owner(lum_endpoint who)
{
    int ready[2];
    char byte = 'n';
    assert_int_equal(pipe(ready), 0);
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        lum_owner *owner = NULL;
        alarm(600);
        const bool owns = lum_owner_take(who, NULL, &owner, NULL) == LUM_NET_OK;
        const ssize_t written = write(ready[1], owns ? "y" : "n", 1);
        if (written == 1) {
            pause();
        }
        _exit(1);
    }
    close(ready[1]);
    assert_int_equal(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    assert_int_equal(byte, 'y');
    return child;
}

static void end(pid_t child)
{
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
}

#if defined(LUM_TEST_PLAIN)

static const char *as_named(pid_t process)
{
    static char text[64];
    snprintf(text, sizeof text, "process %ld", (long)process);
    return text;
}

#else

/* Under valgrind and emulators the program has another name. */
static const char *as_named(pid_t process)
{
    static char text[64];
    char name[32] = "";
    FILE *file = fopen("/proc/self/comm", "r");
    assert_non_null(file);
    assert_non_null(fgets(name, sizeof name, file));
    fclose(file);
    name[strcspn(name, "\n")] = '\0';
    snprintf(text, sizeof text, "%s (process %ld) has", name, (long)process);
    return text;
}

#endif

static void the_other_program_is_named(void **state)
{
    (void)state;
    const lum_endpoint who = sensor(7);
    const pid_t child = start_owner(who);
    for (int i = 0; i < 200; i++) {
        expect_busy(who, NULL, as_named(child));
    }
    end(child);
}

static void looking_finds_the_owner(void **state)
{
    lum_error who = {""};
    (void)state;
    assert_false(lum_owner_look(sensor(12), NULL, &who));
    assert_string_equal(who.text, "");
    const pid_t child = start_owner(sensor(12));
    assert_true(lum_owner_look(sensor(12), NULL, &who));
    assert_non_null(strstr(who.text, as_named(child)));
    assert_true(lum_owner_look(sensor(12), "lo", NULL));
    assert_false(lum_owner_look(sensor(12), "other0", NULL));
    end(child);
    assert_false(lum_owner_look(sensor(12), NULL, &who));
    lum_owner *own = take(sensor(12), NULL);
    assert_true(lum_owner_look(sensor(12), NULL, &who));
    assert_non_null(strstr(who.text, "this program"));
    lum_owner_release(own);
}

/* A child that looks until it is killed; it has looked once. */
static pid_t start_looking(lum_endpoint who)
{
    int looked[2];
    char byte = 0;
    assert_int_equal(pipe(looked), 0);
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        alarm(600);
        (void)lum_owner_look(who, NULL, NULL);
        (void)!write(looked[1], &byte, 1);
        for (;;) {
            (void)lum_owner_look(who, NULL, NULL);
        }
    }
    (void)close(looked[1]);
    assert_int_equal(read(looked[0], &byte, 1), 1);
    (void)close(looked[0]);
    return child;
}

static void who_looks_keeps_nobody_away(void **state)
{
    (void)state;
    const lum_endpoint who = sensor(13);
    const pid_t child = start_looking(who);
    for (int i = 0; i < 200; i++) {
        lum_owner_release(take(who, NULL));
    }
    end(child);
}

static void a_killed_program_owns_nothing(void **state)
{
    (void)state;
    const lum_endpoint who = sensor(8);
    end(start_owner(who));
    lum_owner *owner = take(who, NULL);
    expect_busy(who, NULL, "this program");
    lum_owner_release(owner);
}

static void programs_that_it_starts_do_not_keep_it(void **state)
{
    int open_until_exec[2];
    char byte = 0;
    (void)state;
    lum_owner *owner = take(sensor(9), NULL);
    assert_int_equal(pipe(open_until_exec), 0);
    assert_int_equal(fcntl(open_until_exec[1], F_SETFD, FD_CLOEXEC), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        execlp("sleep", "sleep", "600", (char *)NULL);
        _exit(127);
    }
    close(open_until_exec[1]);
    assert_int_equal(read(open_until_exec[0], &byte, 1), 0);
    close(open_until_exec[0]);
    lum_owner_release(owner);
    owner = take(sensor(9), NULL);
    lum_owner_release(owner);
    end(child);
}

#if defined(LUM_TEST_PLAIN)

static int remove_locks(void **state)
{
    char prefix[] = "lumsdk-session-127.61.2.";
    DIR *directory = opendir("/tmp");
    (void)state;
    for (struct dirent *i = readdir(directory); i != NULL;
         i = readdir(directory)) {
        if (strncmp(i->d_name, prefix, sizeof prefix - 1u) == 0) {
            (void)unlinkat(dirfd(directory), i->d_name, 0);
        }
    }
    return closedir(directory);
}

#else

static int remove_locks(void **state)
{
    (void)state;
    return 0;
}

/* Its own network has its own sensor of that address. */
static int take_in_another_network(lum_endpoint who)
{
    lum_owner *owner = NULL;
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        return SKIPPED;
    }
    return lum_owner_take(who, "lo", &owner, NULL) != LUM_NET_OK;
}

static void another_network_has_another_owner(void **state)
{
    int status = -1;
    (void)state;
    const lum_endpoint who = sensor(10);
    static lum_owner *owner; /* still known in the child */
    owner = take(who, "lo");
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(take_in_another_network(who));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    lum_owner_release(owner);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == SKIPPED) {
        skip();
    }
    assert_int_equal(WEXITSTATUS(status), 0);
}

static bool raise_loopback(void)
{
    struct ifreq request = {.ifr_name = "lo"};
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool is_up = fd >= 0 && ioctl(fd, SIOCGIFFLAGS, &request) == 0;
    request.ifr_flags |= IFF_UP;
    is_up = is_up && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
    close(fd);
    return is_up;
}

/* In a network without a route, which comes then. */
static int take_across_a_route_change(lum_endpoint who)
{
    lum_owner *owner = NULL;
    lum_owner *second = NULL;
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        return SKIPPED;
    }
    if (lum_owner_take(who, NULL, &owner, NULL) != LUM_NET_OK ||
        !raise_loopback()) {
        return 1;
    }
    if (lum_owner_take(who, NULL, &second, NULL) != LUM_NET_BUSY) {
        return 2;
    }
    return lum_owner_take(who, "lo", &second, NULL) == LUM_NET_BUSY ? 0 : 3;
}

static void a_new_route_does_not_make_it_another_sensor(void **state)
{
    int status = -1;
    (void)state;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(take_across_a_route_change(sensor(11)));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == SKIPPED) {
        skip();
    }
    assert_int_equal(WEXITSTATUS(status), 0);
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_second_session_of_a_program_is_refused),
        cmocka_unit_test(what_was_released_can_be_taken_again),
        cmocka_unit_test(other_sensors_and_ports_are_free),
        cmocka_unit_test(the_interface_of_the_route_is_the_same_as_by_name),
        cmocka_unit_test(names_of_any_length_are_held),
        cmocka_unit_test(the_other_program_is_named),
        cmocka_unit_test(looking_finds_the_owner),
        cmocka_unit_test(who_looks_keeps_nobody_away),
        cmocka_unit_test(a_killed_program_owns_nothing),
        cmocka_unit_test(programs_that_it_starts_do_not_keep_it),
#if !defined(LUM_TEST_PLAIN)
        cmocka_unit_test(another_network_has_another_owner),
        cmocka_unit_test(a_new_route_does_not_make_it_another_sensor),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, remove_locks);
}
