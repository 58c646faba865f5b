/* Needs a separate network, which only root may have: two ends of a wire, a0
 * and b0, on one host. */
#define _GNU_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/common/arp.h"
#include "../../tools/common/interfaces.h"

#include "lum/base/time.h"

#include <sched.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define SENSOR  0x0a2a0025u
#define CLIENT  0x0a2a0001u
#define WAIT_NS INT64_C(120000000000)

static bool has_network;

struct wire {
    struct host_interface *all;
    size_t count;
    struct arp *a;
    struct arp *b;
};

static const struct host_interface *end(const struct wire *w, const char *name)
{
    const struct host_interface *i = interfaces_find(w->all, w->count, name);
    assert_non_null(i);
    return i;
}

static struct wire wire_open(void)
{
    struct wire w = {NULL, 0, NULL, NULL};
    lum_error error = {""};
    if (!has_network) {
        (void)puts("skipped: networks of one's own need root and ip");
        skip();
    }
    assert_int_equal(interfaces_list(&w.all, &w.count, &error), 0);
    assert_int_equal(arp_open(end(&w, "a0"), &w.a, &error), ARP_OPENED);
    assert_int_equal(arp_open(end(&w, "b0"), &w.b, &error), ARP_OPENED);
    return w;
}

static void wire_close(struct wire *w)
{
    arp_close(w->a);
    arp_close(w->b);
    free(w->all);
}

/* The next answer; questions of the kernel are passed over. */
static struct arp_speaker hear(struct arp *arp, bool is_answer)
{
    const int64_t deadline = lum_time_monotonic_ns() + WAIT_NS;
    struct arp_speaker who = {0, {0}, false};
    do {
        assert_true(arp_receive(arp, deadline, &who));
    } while (who.is_answer != is_answer);
    return who;
}

static void who_has_an_address_answers_a_probe(void **state)
{
    struct wire w = wire_open();
    (void)state;
    assert_int_equal(arp_ask(w.a, SENSOR, NULL), 0);
    const struct arp_speaker who = hear(w.a, true);
    assert_int_equal(who.address, SENSOR);
    assert_memory_equal(who.mac, end(&w, "b0")->mac, sizeof who.mac);
    wire_close(&w);
}

static void a_question_from_its_subnet_bears_the_interfaces_address(
    void **state)
{
    struct wire w = wire_open();
    (void)state;
    assert_int_equal(arp_ask(w.a, CLIENT + 1u, NULL), 0);
    const struct arp_speaker who = hear(w.b, false);
    assert_int_equal(who.address, CLIENT);
    assert_memory_equal(who.mac, end(&w, "a0")->mac, sizeof who.mac);
    wire_close(&w);
}

static void nobody_speaks_in_a_past_that_ends(void **state)
{
    struct wire w = wire_open();
    struct arp_speaker who = {7, {7}, true};
    (void)state;
    /* a probe, from 0.0.0.0, says nothing of who asks */
    assert_int_equal(arp_ask(w.b, 0x0a630001u, NULL), 0);
    assert_false(arp_receive(w.b, 0, &who));
    assert_false(
        arp_receive(w.a, lum_time_monotonic_ns() + INT64_C(50000000), &who));
    wire_close(&w);
}

static void an_interface_without_a_mac_is_refused(void **state)
{
    struct wire w = wire_open();
    struct arp *arp = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(arp_open(end(&w, "lo"), &arp, &error), ARP_NO_WAY);
    assert_non_null(strstr(error.text, "lo"));
    assert_null(arp);
    arp_close(NULL);
    wire_close(&w);
}

/* The kernel answers every request for an address of b0 that comes to b0. */
static char wiring[] =
    "exec >/dev/null 2>&1; set -e;"
    "ip link add a0 type veth peer name b0;"
    "ip link set lo up; ip link set a0 up; ip link set b0 up;"
    "ip addr add 10.42.0.1/30 dev a0;"
    "ip addr add 10.42.0.37/32 dev b0";

static int make_network(void **state)
{
    static char shell[] = "sh";
    static char flag[] = "-c";
    char *const arguments[] = {shell, flag, wiring, NULL};
    pid_t child = 0;
    int status = 0;
    (void)state;
    has_network =
        unshare(CLONE_NEWNET) == 0 &&
        posix_spawnp(&child, shell, NULL, NULL, arguments, environ) == 0 &&
        waitpid(child, &status, 0) == child && WIFEXITED(status) &&
        WEXITSTATUS(status) == 0;
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_has_an_address_answers_a_probe),
        cmocka_unit_test(
            a_question_from_its_subnet_bears_the_interfaces_address),
        cmocka_unit_test(nobody_speaks_in_a_past_that_ends),
        cmocka_unit_test(an_interface_without_a_mac_is_refused),
    };
    return cmocka_run_group_tests(tests, make_network, NULL);
}
