#define _POSIX_C_SOURCE 200809L /* setenv */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/net/resolve.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t address;
static lum_error error;

static int resolve(const char *host)
{
    address = 4711;
    error.text[0] = '\0';
    return lum_resolve(host, &address, &error);
}

static void expect_refused(const char *host, const char *says)
{
    assert_int_equal(resolve(host), -1);
    assert_int_equal(address, 4711);
    if (strstr(error.text, says) == NULL) {
        fail_msg("%s: '%s' does not say '%s'", host, error.text, says);
    }
}

static void an_address_is_taken_as_it_stands(void **state)
{
    (void)state;
    assert_int_equal(resolve("10.42.0.37"), 0);
    assert_int_equal(address, 0x0a2a0025);
    assert_int_equal(resolve("0.0.0.0"), 0);
    assert_int_equal(address, 0);
    assert_int_equal(resolve("255.255.255.255"), 0);
    assert_true(address == UINT32_MAX);
}

/* Resolvers read some of these in other notations, as other addresses. */
static void what_only_looks_like_an_address_is_refused(void **state)
{
    static const char *const hosts[] = {
        "",          "10.42.0",    "10.42.0.037",  "10.42.0.256", "10.42.0.1.1",
        "170524709", "0x0a2a0025", "10.42.0.0x25", "10.42.0.1 ",  " 10.42.0.1",
        "10.42.0.",  "-10.42.0.1", ".localhost",   "a b",         "local/host",
        "a.1",       "10,42,0,37"};
    (void)state;
    for (size_t i = 0; i < sizeof hosts / sizeof hosts[0]; i++) {
        expect_refused(hosts[i], "neither an IPv4 address");
    }
}

static void names_of_any_length_are_harmless(void **state)
{
    char name[512];
    (void)state;
    memset(name, 'a', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    expect_refused(name, "neither an IPv4 address");
    name[253] = '\0'; /* a label is 63 at most */
    assert_int_equal(resolve(name), -1);
}

static void an_ipv6_address_is_told(void **state)
{
    (void)state;
    expect_refused("::1", "not an IPv4 address");
    expect_refused("fe80::1", "not an IPv4 address");
}

/* A name that RFC 6761 keeps from being one. */
static void a_name_that_is_not_known_is_told(void **state)
{
    (void)state;
    expect_refused("sensor.invalid", "'sensor.invalid'");
    expect_refused("sensor.invalid", "give its address");
}

static void a_name_gives_its_address(void **state)
{
    (void)state;
    if (resolve("localhost") != 0) {
        print_message("not run: this host does not know localhost: %s\n",
                      error.text);
        skip();
    }
    assert_int_equal(address >> 24, 127);
}

int main(void)
{
    /* Where no server answers. */
    (void)setenv("RES_OPTIONS", "timeout:1 attempts:1", 0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_address_is_taken_as_it_stands),
        cmocka_unit_test(what_only_looks_like_an_address_is_refused),
        cmocka_unit_test(names_of_any_length_are_harmless),
        cmocka_unit_test(an_ipv6_address_is_told),
        cmocka_unit_test(a_name_that_is_not_known_is_told),
        cmocka_unit_test(a_name_gives_its_address),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
