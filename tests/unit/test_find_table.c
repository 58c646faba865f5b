#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/beside.h"
#include "../../tools/lumctl/find.h"

#include <stdio.h>
#include <string.h>

#define FIRST 0x0a000001u /* of those that fill the table */

static struct host_interface interfaces[2];
static const struct interface_address address_of[2] = {
    {0x0a2a0001u, 0xffffff00u, 24}, {0x0a090901u, 0xfffffff0u, 28}};
static struct find_plan plan;
static struct find_result result;

static int begin(void **state)
{
    (void)state;
    memset(interfaces, 0, sizeof interfaces);
    memset(&plan, 0, sizeof plan);
    memset(&result, 0, sizeof result);
    for (size_t i = 0; i < 2; i++) {
        (void)snprintf(interfaces[i].name, sizeof interfaces[i].name, "eth%u",
                       (unsigned)i);
        interfaces[i].is_up = true;
    }
    interfaces[0].addresses = &address_of[0];
    interfaces[0].address_count = 1;
    plan.interfaces = interfaces;
    plan.interface_count = 2;
    return 0;
}

static struct find_found *see(uint32_t address, enum find_how how)
{
    const lum_endpoint host = {address, 5517};
    struct find_found *f = find_entry(&result, host, &interfaces[0]);
    if (f != NULL) {
        f->how = how > f->how ? how : f->how;
    }
    return f;
}

static void who_has_no_room_is_told(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < FIND_FOUND_MAX; i++) {
        assert_non_null(see(FIRST + i, FIND_ARP));
    }
    assert_non_null(see(FIRST, FIND_ANSWERS)); /* who is known, is */
    assert_int_equal(result.count, FIND_FOUND_MAX);
    assert_false(result.is_full);
    assert_null(see(FIRST - 1, FIND_ARP));
    assert_true(result.is_full);
    assert_int_equal(result.count, FIND_FOUND_MAX);
}

static void check_reach(const struct find_found *found, const char *wanted)
{
    assert_string_equal(find_reach(&plan, &result, found).text, wanted);
}

static struct find_subnet_beside *ask(void)
{
    find_plan_besides(&plan, &result);
    assert_int_equal(result.beside_count, 1);
    result.besides[0].is_asked = true;
    return &result.besides[0];
}

static void an_address_is_proposed_only_when_it_was_asked_for(void **state)
{
    (void)state;
    struct find_found *f = see(0x0a070707u, FIND_SENDS);
    check_reach(f, "");
    ask()->is_asked = false;
    check_reach(f, "");
    assert_true(find_needs_address(&plan, f));
    result.besides[0].is_asked = true;
    check_reach(f, "ip addr add 10.7.7.1/24 dev eth0");
    f->how = FIND_ANSWERS;
    check_reach(f, "");
    assert_false(find_needs_address(&plan, f));
}

static void what_others_have_is_not_proposed(void **state)
{
    (void)state;
    struct find_found *f = see(0x0a070702u, FIND_SENDS); /* .2 itself */
    struct find_found *other = see(0x0a070703u, FIND_SENDS);
    find_note_taken(&ask()->taken, 0x0a070700u, 0x0a070701u);
    find_note_taken(&result.besides[0].taken, 0x0a070700u, 0x0a080704u);
    find_note_taken(&result.besides[0].taken, 0x0a070700u, 0x0a0707ffu);
    check_reach(f, "ip addr add 10.7.7.4/24 dev eth0");
    check_reach(other, "ip addr add 10.7.7.4/24 dev eth0");
    result.is_full = true; /* others may have any */
    check_reach(f, "");
}

static void this_hosts_own_is_not_proposed(void **state)
{
    (void)state;
    interfaces[0].addresses = &address_of[1]; /* 10.9.9.1/28 */
    struct find_found *f = see(0x0a090963u, FIND_SENDS);
    (void)ask();
    check_reach(f, "ip addr add 10.9.9.2/24 dev eth0");
}

static void where_all_are_taken_none_is_proposed(void **state)
{
    (void)state;
    struct find_found *f = see(0x0a070707u, FIND_SENDS);
    struct find_subnet_beside *b = ask();
    for (uint32_t last = 1; last < BESIDE_LAST; last++) {
        find_note_taken(&b->taken, b->network, b->network | last);
    }
    check_reach(f, "ip addr add 10.7.7.16/24 dev eth0");
    find_note_taken(&b->taken, b->network, b->network | BESIDE_LAST);
    check_reach(f, "");
}

static void another_interface_of_the_subnet_gets_a_route(void **state)
{
    (void)state;
    struct find_found *f = see(0x0a2a0025u, FIND_ARP);
    f->interface = &interfaces[1];
    check_reach(f, "ip route add 10.42.0.37/32 dev eth1");
    assert_false(find_needs_address(&plan, f));
    assert_non_null(see(0x0a2a0025u, FIND_ARP)); /* at eth0, too */
    check_reach(f, "");
}

static void the_mac_of_a_sensor_stands_first(void **state)
{
    static const char a[] = "02:00:00:00:00:01";
    static const char b[] = "02:00:00:00:00:02";
    (void)state;
    struct find_found *f = see(0x0a2a0025u, FIND_ARP);
    find_note_mac(f, a, false);
    find_note_mac(f, a, false);
    assert_string_equal(f->other_mac, "");
    find_note_mac(f, b, false);
    assert_string_equal(f->mac, a);
    assert_string_equal(f->other_mac, b);
    assert_false(f->is_mac_of_sensor);
    find_note_mac(f, b, true);
    find_note_mac(f, a, false);
    assert_true(f->is_mac_of_sensor);
    assert_string_equal(f->mac, b);
    assert_string_equal(f->other_mac, a);
}

/* Takes all up to the address at context. */
static bool is_low(void *context, uint32_t address)
{
    const uint32_t *up_to = context;
    return address <= *up_to;
}

static void the_lowest_free_address_is_found(void **state)
{
    uint32_t up_to = 0x0a2a0000u;
    (void)state;
    assert_int_equal(beside_find(0x0a2a0025u, is_low, &up_to), 0x0a2a0001u);
    up_to = 0x0a2a0008u;
    assert_int_equal(beside_find(0x0a2a0025u, is_low, &up_to), 0x0a2a0009u);
    assert_int_equal(beside_find(0x0a2a0009u, is_low, &up_to), 0x0a2a000au);
    up_to = 0x0a2a000fu;
    assert_int_equal(beside_find(0x0a2a0025u, is_low, &up_to), 0x0a2a0010u);
    assert_int_equal(beside_find(0x0a2a0010u, is_low, &up_to), 0);
    up_to = 0x0a2a0010u;
    assert_int_equal(beside_find(0x0a2a0025u, is_low, &up_to), 0);
}

int main(void)
{
#define FACT(name) cmocka_unit_test_setup(name, begin)
    const struct CMUnitTest tests[] = {
        FACT(who_has_no_room_is_told),
        FACT(an_address_is_proposed_only_when_it_was_asked_for),
        FACT(what_others_have_is_not_proposed),
        FACT(this_hosts_own_is_not_proposed),
        FACT(where_all_are_taken_none_is_proposed),
        FACT(another_interface_of_the_subnet_gets_a_route),
        FACT(the_mac_of_a_sensor_stands_first),
        FACT(the_lowest_free_address_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
