#define _DEFAULT_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/common/interfaces.h"

#include <net/if.h>
#include <stdlib.h>
#include <string.h>

static const struct host_interface *loopback(struct host_interface *all,
                                             size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (all[i].is_loopback) {
            return &all[i];
        }
    }
    fail_msg("no loopback interface");
    return NULL;
}

static void loopback_is_listed_with_its_address(void **state)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    lum_error error = {""};
    (void)state;
    assert_int_equal(interfaces_list(&all, &count, &error), 0);
    const struct host_interface *lo = loopback(all, count);
    assert_true(lo->is_up && !lo->is_ethernet && !lo->has_mac);
    const struct interface_address *a = interfaces_subnet(lo, 0x7f000102u);
    assert_non_null(a);
    assert_int_equal(a->address, 0x7f000001u);
    assert_int_equal(a->mask, 0xff000000u);
    assert_int_equal(a->prefix, 8);
    assert_ptr_equal(interfaces_find(all, count, lo->name), lo);
    assert_null(interfaces_find(all, count, "nowhere0"));
    free(all);
}

static void every_interface_is_there_once(void **state)
{
    struct host_interface *all = NULL;
    size_t count = 0;
    size_t n = 0;
    lum_error error = {""};
    struct if_nameindex *names = if_nameindex();
    (void)state;
    assert_non_null(names);
    assert_int_equal(interfaces_list(&all, &count, &error), 0);
    for (; names[n].if_index != 0; n++) {
        const struct host_interface *i =
            interfaces_find(all, count, names[n].if_name);
        assert_non_null(i);
        assert_int_equal(i->index, names[n].if_index);
    }
    assert_int_equal(count, n);
    if_freenameindex(names);
    free(all);
}

static void the_narrowest_subnet_holds_an_address(void **state)
{
    static const struct interface_address addresses[] = {
        {0x0a000001u, 0x00000000u, 0},
        {0x0a2a0001u, 0xffff0000u, 16},
        {0x0a2a0002u, 0xffffff00u, 24},
        {0x0a2a0003u, 0xffff0000u, 16},
    };
    const struct host_interface i = {.addresses = addresses,
                                     .address_count = 4};
    (void)state;
    assert_ptr_equal(interfaces_subnet(&i, 0x0a2a0025u), &addresses[2]);
    assert_ptr_equal(interfaces_subnet(&i, 0x0a2a0125u), &addresses[1]);
    assert_null(interfaces_subnet(&i, 0x0a2b0025u));
}

static void an_address_has_its_owner(void **state)
{
    static const struct interface_address addresses[] = {
        {0x7f000001u, 0xff000000u, 8},
        {0x0a2a0001u, 0xffffff00u, 24},
        {0x0a2b0001u, 0xffffff00u, 24},
    };
    const struct host_interface all[] = {
        {.addresses = addresses, .address_count = 1},
        {.address_count = 0},
        {.addresses = addresses + 1, .address_count = 2},
    };
    const struct interface_address *at = NULL;
    (void)state;
    assert_ptr_equal(interfaces_owner(all, 3, 0x0a2b0001u, &at), &all[2]);
    assert_ptr_equal(at, &addresses[2]);
    assert_null(interfaces_owner(all, 3, 0x0a2a0002u, &at));
    assert_ptr_equal(at, &addresses[2]);
    assert_ptr_equal(interfaces_owner(all, 3, 0x7f000001u, NULL), &all[0]);
    assert_null(interfaces_owner(all, 2, 0x0a2b0001u, NULL));
    assert_null(interfaces_owner(NULL, 0, 0x7f000001u, NULL));
}

static void masks_and_macs_have_their_text(void **state)
{
    const uint8_t mac[INTERFACE_MAC_BYTES] = {0x9a, 0x62, 0xcd, 8, 0xa4, 1};
    char text[INTERFACE_MAC_TEXT_BYTES];
    (void)state;
    assert_int_equal(interfaces_mask_bits(0), 0);
    assert_int_equal(interfaces_mask_bits(0x80000000u), 1);
    assert_int_equal(interfaces_mask_bits(0xffffff00u), 24);
    assert_int_equal(interfaces_mask_bits(0xffffffffu), 32);
    assert_string_equal(interfaces_format_mac(mac, text), "9a:62:cd:08:a4:01");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loopback_is_listed_with_its_address),
        cmocka_unit_test(every_interface_is_there_once),
        cmocka_unit_test(the_narrowest_subnet_holds_an_address),
        cmocka_unit_test(an_address_has_its_owner),
        cmocka_unit_test(masks_and_macs_have_their_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
