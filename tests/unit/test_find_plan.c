#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/find.h"

#include <stdio.h>
#include <string.h>

#define MAX 80u

static struct host_interface interfaces[MAX];
static struct interface_address addresses[MAX];
static struct find_plan plan;

static int begin(void **state)
{
    (void)state;
    memset(interfaces, 0, sizeof interfaces);
    memset(addresses, 0, sizeof addresses);
    memset(&plan, 0, sizeof plan);
    plan.interfaces = interfaces;
    return 0;
}

/* An interface that is up, with an address if bits is not 0. */
static struct host_interface *add(const char *name, uint32_t address,
                                  unsigned bits)
{
    struct host_interface *i = &interfaces[plan.interface_count];
    struct interface_address *a = &addresses[plan.interface_count++];
    (void)snprintf(i->name, sizeof i->name, "%s", name);
    i->is_up = true;
    i->has_link = true;
    i->has_mac = true;
    i->is_ethernet = true;
    if (bits != 0) {
        *a = (struct interface_address){address, UINT32_MAX << (32u - bits),
                                        bits};
        i->addresses = a;
        i->address_count = 1;
    }
    return i;
}

static void check(size_t i, const char *name, uint32_t first, uint32_t last,
                  bool by_arp)
{
    const struct find_range *r = &plan.ranges[i];
    assert_true(i < plan.range_count);
    if (name == NULL) {
        assert_null(r->interface);
    } else {
        assert_string_equal(r->interface->name, name);
    }
    assert_int_equal(r->first, first);
    assert_int_equal(r->last, last);
    assert_int_equal(r->by_arp, by_arp);
}

static void a_subnet_is_asked_without_its_ends(void **state)
{
    (void)state;
    add("eth0", 0x0a2a0001u, 24);
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 1);
    check(0, "eth0", 0x0a2a0001u, 0x0a2a00feu, false);
    assert_int_equal(plan.left_out.count, 0);
}

static void a_wide_one_is_asked_around_the_own_address(void **state)
{
    (void)state;
    add("eth0", 0x0a2a1005u, 8);
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 2);
    check(0, "eth0", 0x0a2a1001u, 0x0a2a13feu, false);
    check(1, "eth0", 0x0a2a0025u, 0x0a2a0025u, false);
    assert_non_null(strstr(plan.left_out.texts[0], "and 10.42.0.37"));
    assert_int_equal(plan.left_out.count, 1);
    assert_non_null(strstr(plan.left_out.texts[0], "10.0.0.0/8"));
    assert_non_null(strstr(plan.left_out.texts[0], "10.42.16.0/22"));
}

static void a_22_is_asked_whole_and_a_21_is_not(void **state)
{
    (void)state;
    add("eth0", 0x0a2a0001u, 22);
    find_make_plan(&plan, NULL, NULL);
    check(0, "eth0", 0x0a2a0001u, 0x0a2a03feu, false);
    assert_int_equal(plan.left_out.count, 0);
    (void)begin(state);
    add("eth0", 0x0a2a0001u, 21);
    find_make_plan(&plan, NULL, NULL);
    check(0, "eth0", 0x0a2a0001u, 0x0a2a03feu, false);
    assert_int_equal(plan.left_out.count, 1);
}

static void two_ends_of_a_link_are_both_asked_and_one_alone_is_not(void **state)
{
    (void)state;
    add("ptp0", 0x0a2a0024u, 31);
    find_make_plan(&plan, NULL, NULL);
    check(0, "ptp0", 0x0a2a0024u, 0x0a2a0025u, false);
    (void)begin(state);
    add("tun0", 0x64400001u, 32)->has_mac = false;
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 0);
    assert_int_equal(plan.left_out.count, 1);
}

static void the_boot_subnet_is_asked_by_arp_where_no_address_fits(void **state)
{
    (void)state;
    add("eth0", 0, 0);
    add("eth1", 0xc0a80705u, 24);
    add("tun0", 0, 0)->has_mac = false;
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 3);
    check(0, "eth0", 0x0a2a0001u, 0x0a2a00feu, true);
    check(1, "eth1", 0xc0a80701u, 0xc0a807feu, false);
    check(2, "eth1", 0x0a2a0001u, 0x0a2a00feu, true);
}

static void the_loopback_is_asked_only_by_name(void **state)
{
    (void)state;
    add("lo", 0x7f000001u, 8)->is_loopback = true;
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 0);
    find_make_plan(&plan, "lo", NULL);
    assert_int_equal(plan.range_count, 1);
    check(0, "lo", 0x7f000001u, 0x7f0003feu, false);
}

static void what_is_down_or_has_no_link_is_said(void **state)
{
    (void)state;
    add("eth0", 0x0a2a0001u, 24)->is_up = false;
    add("eth1", 0x0a2a0001u, 24)->is_up = false;
    add("eth2", 0x0a2a0001u, 24)->has_link = false;
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 0);
    assert_int_equal(plan.left_out.count, 2);
    assert_non_null(strstr(plan.left_out.texts[0], "eth0, eth1: down"));
    assert_non_null(strstr(plan.left_out.texts[1], "eth2: no link"));
}

static void a_named_subnet_is_asked_on_each_interface_that_has_it(void **state)
{
    const struct find_subnet subnet = {0x0a2a0000u, 25};
    (void)state;
    add("eth0", 0x0a2a0001u, 24);
    add("eth1", 0x0a2a0002u, 16);
    add("eth2", 0xc0a80705u, 24);
    find_make_plan(&plan, NULL, &subnet);
    assert_int_equal(plan.range_count, 2);
    check(0, "eth0", 0x0a2a0001u, 0x0a2a007eu, false);
    check(1, "eth1", 0x0a2a0001u, 0x0a2a007eu, false);
    (void)begin(state);
    add("eth0", 0x0a2a0001u, 24);
    add("eth1", 0x0a2a0002u, 16);
    find_make_plan(&plan, "eth1", &subnet);
    assert_int_equal(plan.range_count, 1);
    check(0, "eth1", 0x0a2a0001u, 0x0a2a007eu, false);
}

static void a_subnet_that_no_interface_has_is_asked_both_ways(void **state)
{
    const struct find_subnet subnet = {0x0a070700u, 24};
    (void)state;
    add("lo", 0x7f000001u, 8)->is_loopback = true;
    add("eth0", 0x0a2a0001u, 24);
    add("eth1", 0x0a2a0001u, 24)->has_link = false;
    find_make_plan(&plan, NULL, &subnet);
    assert_int_equal(plan.range_count, 2);
    check(0, NULL, 0x0a070701u, 0x0a0707feu, false);
    check(1, "eth0", 0x0a070701u, 0x0a0707feu, true);
    assert_int_equal(plan.left_out.count, 0);
    (void)begin(state);
    add("eth0", 0x0a2a0001u, 24);
    find_make_plan(&plan, "eth0", &subnet);
    assert_int_equal(plan.range_count, 1);
    check(0, "eth0", 0x0a070701u, 0x0a0707feu, true);
}

static void the_same_subnet_twice_on_an_interface_is_asked_once(void **state)
{
    (void)state;
    struct host_interface *eth0 = add("eth0", 0x0a2a0001u, 24);
    addresses[1] = addresses[0];
    addresses[1].address = 0x0a2a0007u;
    eth0->address_count = 2;
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 1);
}

static void what_is_asked_before_is_repeated(void **state)
{
    (void)state;
    add("eth0", 0x0a2a0001u, 25);
    add("eth1", 0x0a2a0002u, 24);
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, 2);
    assert_false(find_is_repeated(&plan, 1, 0x0a2a0001u));
    plan.ranges[0].is_askable = true;
    assert_false(find_is_repeated(&plan, 0, 0x0a2a0001u));
    assert_true(find_is_repeated(&plan, 1, 0x0a2a0001u));
    assert_true(find_is_repeated(&plan, 1, 0x0a2a007eu));
    assert_false(find_is_repeated(&plan, 1, 0x0a2a007fu));
}

static void too_many_are_said(void **state)
{
    (void)state;
    for (unsigned i = 0; i < MAX; i++) {
        char name[16];
        (void)snprintf(name, sizeof name, "veth%u", i);
        add(name, 0x0b000001u + (i << 8), 24)->has_mac = false;
    }
    find_make_plan(&plan, NULL, NULL);
    assert_int_equal(plan.range_count, FIND_RANGES_MAX);
    assert_int_equal(plan.left_out.count, MAX - FIND_RANGES_MAX);
    for (unsigned i = 0; i < FIND_LEFT_OUT_MAX; i++) {
        (void)snprintf(find_leave_out(&plan.left_out), FIND_LEFT_OUT_BYTES,
                       "%u", i);
    }
    assert_int_equal(plan.left_out.count, FIND_LEFT_OUT_MAX);
    assert_int_equal(plan.left_out.more, MAX - FIND_RANGES_MAX);
}

static void a_list_of_names_that_is_full_ends_with_dots(void **state)
{
    char names[FIND_NAMES_BYTES] = "";
    char one[MAX * 4];
    (void)state;
    find_add_name(names, "eth0");
    find_add_name(names, "eth1");
    assert_string_equal(names, "eth0, eth1");
    for (unsigned i = 0; i < MAX; i++) {
        find_add_name(names, "wlp0s20f3");
    }
    assert_true(strlen(names) < sizeof names);
    assert_string_equal(names + strlen(names) - 14, "wlp0s20f3, ...");
    memset(one, 'x', sizeof one - 1);
    one[sizeof one - 1] = '\0';
    names[0] = '\0';
    find_add_name(names, one);
    find_add_name(names, "eth1");
    assert_string_equal(names + strlen(names) - 6, "x, ...");
}

static void subnets_are_read_strictly(void **state)
{
    static const char *const bad[] = {"",
                                      "10.42.0.0",
                                      "10.42.0.0/",
                                      "/24",
                                      "10.42.0/24",
                                      "10.42.0.0/33",
                                      "10.42.0.0/-1",
                                      "10.42.0.0/24 ",
                                      "10.42.0.0/x",
                                      "010.42.0.256/24",
                                      "10.42.0.0.0.0.0.0.0/24"};
    struct find_subnet subnet = {0, 0};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(find_parse_subnet(bad[i], &subnet));
    }
    assert_true(find_parse_subnet("10.42.7.9/22", &subnet));
    assert_string_equal(find_show_subnet(&subnet).text, "10.42.4.0/22");
    assert_true(find_parse_subnet("0.0.0.0/0", &subnet));
    assert_int_equal(subnet.bits, 0);
    assert_true(find_parse_subnet("255.255.255.255/32", &subnet));
    assert_string_equal(find_show_subnet(&subnet).text, "255.255.255.255/32");
}

int main(void)
{
#define FACT(name) cmocka_unit_test_setup(name, begin)
    const struct CMUnitTest tests[] = {
        FACT(a_subnet_is_asked_without_its_ends),
        FACT(a_wide_one_is_asked_around_the_own_address),
        FACT(a_22_is_asked_whole_and_a_21_is_not),
        FACT(two_ends_of_a_link_are_both_asked_and_one_alone_is_not),
        FACT(the_boot_subnet_is_asked_by_arp_where_no_address_fits),
        FACT(the_loopback_is_asked_only_by_name),
        FACT(what_is_down_or_has_no_link_is_said),
        FACT(a_named_subnet_is_asked_on_each_interface_that_has_it),
        FACT(a_subnet_that_no_interface_has_is_asked_both_ways),
        FACT(the_same_subnet_twice_on_an_interface_is_asked_once),
        FACT(what_is_asked_before_is_repeated),
        FACT(too_many_are_said),
        FACT(a_list_of_names_that_is_full_ends_with_dots),
        FACT(subnets_are_read_strictly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
