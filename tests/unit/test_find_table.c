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
    struct find_found *f = find_entry(&result, host, &interfaces[0], how);
    if (f != NULL) {
        f->how = how > f->how ? how : f->how;
    }
    return f;
}

static void fill(enum find_how how)
{
    for (uint32_t i = 0; i < FIND_FOUND_MAX; i++) {
        assert_non_null(see(FIRST + i, how));
    }
    assert_int_equal(result.count, FIND_FOUND_MAX);
    assert_int_equal(result.lost_count, 0);
}

static void who_has_no_room_is_counted_once(void **state)
{
    (void)state;
    fill(FIND_ARP);
    assert_non_null(see(FIRST, FIND_ARP)); /* who is known, is */
    assert_null(see(FIRST - 1, FIND_ARP));
    assert_null(see(FIRST - 1, FIND_ARP));
    assert_null(see(FIRST - 2, FIND_ARP));
    assert_int_equal(result.lost_count, 2);
    assert_int_equal(result.count, FIND_FOUND_MAX);
}

static void a_sensor_takes_the_place_of_one_that_is_less_sure(void **state)
{
    (void)state;
    fill(FIND_SENDS);
    result.found[7].how = FIND_ARP;
    result.found[9].how = FIND_OTHER;
    assert_null(see(1, FIND_ARP));
    assert_ptr_equal(see(1, FIND_ANSWERS), &result.found[7]);
    assert_int_equal(result.found[7].host.address, 1);
    assert_int_equal(result.lost_count, 1); /* 1 is there now, and 7 is not */
    assert_int_equal(result.lost[0], FIRST + 7);
    assert_ptr_equal(see(2, FIND_SENDS), &result.found[9]);
    assert_null(see(3, FIND_SENDS));
    assert_int_equal(result.lost_count, 3);
}

static void more_than_can_be_counted_are_more(void **state)
{
    (void)state;
    fill(FIND_ANSWERS);
    for (uint32_t i = 0; i < FIND_LOST_MAX; i++) {
        assert_null(see(i + 1, FIND_ANSWERS));
    }
    assert_false(result.has_lost_more);
    assert_null(see(FIND_LOST_MAX + 1, FIND_ANSWERS));
    assert_true(result.has_lost_more);
    assert_int_equal(result.lost_count, FIND_LOST_MAX);
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

static void what_others_have_or_are_sent_is_not_proposed(void **state)
{
    (void)state;
    struct find_found *f = see(0x0a070702u, FIND_SENDS); /* .2 itself */
    find_note_taken(&f->sends_to, 0x0a070700u, 0x0a070701u);
    find_note_taken(&f->sends_to, 0x0a070700u, 0x0a080703u); /* elsewhere */
    find_note_taken(&f->sends_to, 0x0a070700u, 0x0a0707ffu);
    struct find_found *other = see(0x0a070703u, FIND_SENDS);
    find_note_taken(&other->sends_to, 0x0a070700u, 0x0a070704u);
    find_note_taken(&ask()->taken, 0x0a070700u, 0x0a070705u);
    check_reach(f, "ip addr add 10.7.7.6/24 dev eth0");
    check_reach(other, "ip addr add 10.7.7.6/24 dev eth0");
    result.lost[result.lost_count++] = 0x0a070706u;
    check_reach(f, "ip addr add 10.7.7.7/24 dev eth0");
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
    static const uint8_t a[INTERFACE_MAC_BYTES] = {2, 0, 0, 0, 0, 1};
    static const uint8_t b[INTERFACE_MAC_BYTES] = {2, 0, 0, 0, 0, 2};
    (void)state;
    struct find_found *f = see(0x0a2a0025u, FIND_ARP);
    find_note_mac(f, a, false);
    find_note_mac(f, a, false);
    assert_false(f->has_other_mac);
    find_note_mac(f, b, false);
    assert_true(f->has_other_mac);
    assert_memory_equal(f->mac, a, sizeof a);
    assert_memory_equal(f->other_mac, b, sizeof b);
    assert_false(f->is_mac_of_sensor);
    find_note_mac(f, b, true);
    find_note_mac(f, a, false);
    assert_true(f->is_mac_of_sensor);
    assert_memory_equal(f->mac, b, sizeof b);
    assert_memory_equal(f->other_mac, a, sizeof a);
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
        FACT(who_has_no_room_is_counted_once),
        FACT(a_sensor_takes_the_place_of_one_that_is_less_sure),
        FACT(more_than_can_be_counted_are_more),
        FACT(an_address_is_proposed_only_when_it_was_asked_for),
        FACT(what_others_have_or_are_sent_is_not_proposed),
        FACT(this_hosts_own_is_not_proposed),
        FACT(where_all_are_taken_none_is_proposed),
        FACT(another_interface_of_the_subnet_gets_a_route),
        FACT(the_mac_of_a_sensor_stands_first),
        FACT(the_lowest_free_address_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
