#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumview/page_guard.h"

#include <string.h>

#define TOKEN "0123456789abcdef0123456789abcdef"

static const struct guard at_home = {0x7f000001u, 8080, ""};
static const struct guard abroad = {0xc0a80105u, 8080, TOKEN};

static void only_the_own_address_is_a_host(void **state)
{
    (void)state;
    assert_true(guard_knows_host(&at_home, "127.0.0.1:8080"));
    assert_true(guard_knows_host(&at_home, "localhost:8080"));
    assert_true(guard_knows_host(&abroad, "192.168.1.5:8080"));
    static const char *const others[] = {
        "",
        "127.0.0.1",
        "127.0.0.1:80801",
        "127.0.0.1:808",
        "127.0.0.1:8081",
        "127.0.0.1:08080",
        "127.0.0.1:8080 ",
        " 127.0.0.1:8080",
        "127.0.0.1:8080,127.0.0.1:8080",
        "127.0.0.1.evil.example:8080",
        "evil.example:8080",
        "localhost",
        "localhost.:8080",
        "0.0.0.0:8080",
        "[::1]:8080",
        "127.1:8080",
        "user@127.0.0.1:8080",
    };
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_false(guard_knows_host(&at_home, others[i]));
        assert_false(guard_knows_host(&abroad, others[i]));
    }
    assert_false(guard_knows_host(&abroad, "127.0.0.1:8080"));
    assert_false(guard_knows_host(&abroad, "localhost:8080"));
}

static void the_port_of_http_may_be_left_out(void **state)
{
    const struct guard guard = {0x7f000001u, 80, ""};
    (void)state;
    assert_true(guard_knows_host(&guard, "127.0.0.1"));
    assert_true(guard_knows_host(&guard, "localhost:80"));
    assert_true(guard_knows_origin(&guard, "http://127.0.0.1"));
    assert_false(guard_knows_host(&guard, "127.0.0.1:8080"));
}

static void only_the_own_page_is_an_origin(void **state)
{
    (void)state;
    assert_true(guard_knows_origin(&at_home, "http://127.0.0.1:8080"));
    assert_true(guard_knows_origin(&at_home, "http://localhost:8080"));
    static const char *const others[] = {
        "",
        "null",
        "file://",
        "http://",
        "127.0.0.1:8080",
        "https://127.0.0.1:8080",
        "HTTP://127.0.0.1:8080",
        "http://127.0.0.1:8080/",
        "http://127.0.0.1",
        "http://127.0.0.1:8081",
        "http://evil.example",
        "http://127.0.0.1:8080.evil.example",
        "http://evil.example/http://127.0.0.1:8080",
    };
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_false(guard_knows_origin(&at_home, others[i]));
    }
}

static void without_a_token_anybody_has_it(void **state)
{
    (void)state;
    assert_true(guard_knows_token(&at_home, NULL, NULL));
    assert_true(guard_knows_token(&at_home, "anything", "a=b"));
}

static void a_token_must_be_all_of_it(void **state)
{
    (void)state;
    assert_true(guard_knows_token(&abroad, TOKEN, NULL));
    assert_false(guard_knows_token(&abroad, NULL, NULL));
    assert_false(guard_knows_token(&abroad, "", NULL));
    assert_false(guard_knows_token(&abroad, TOKEN "0", NULL));
    char wrong[] = TOKEN;
    wrong[31] = '\0';
    assert_false(guard_knows_token(&abroad, wrong, NULL));
    for (size_t i = 0; i < 32; i++) {
        char other[] = TOKEN;
        other[i] = 'x';
        assert_false(guard_knows_token(&abroad, other, NULL));
    }
}

static void a_cookie_counts_where_the_query_has_no_token(void **state)
{
    (void)state;
    assert_true(guard_knows_token(&abroad, NULL, "lumview-8080=" TOKEN));
    assert_true(guard_knows_token(
        &abroad, NULL, "a=b; lumview-8080=" TOKEN "; lumview-8081=x"));
    assert_true(guard_knows_token(&abroad, NULL,
                                  "lumview-8080=old; lumview-8080=" TOKEN));
    static const char *const others[] = {
        "",
        ";",
        "; ; ",
        "lumview-8080",
        "lumview-8080=",
        "lumview-808=" TOKEN,
        "lumview-8081=" TOKEN,
        "lumview=" TOKEN,
        "xlumview-8080=" TOKEN,
        "a=lumview-8080=" TOKEN,
        "lumview-8080=" TOKEN "0",
        "lumview-8080=\"" TOKEN "\"",
    };
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        assert_false(guard_knows_token(&abroad, NULL, others[i]));
    }
    assert_false(guard_knows_token(&abroad, "x", "lumview-8080=" TOKEN));
}

static void url_and_cookie_carry_the_token(void **state)
{
    char text[GUARD_TEXT_BYTES];
    (void)state;
    guard_url(&at_home, text);
    assert_string_equal(text, "http://127.0.0.1:8080/");
    guard_url(&abroad, text);
    assert_string_equal(text, "http://192.168.1.5:8080/?token=" TOKEN);
    guard_cookie(&abroad, text);
    assert_string_equal(text, "lumview-8080=" TOKEN
                              "; Path=/; HttpOnly; SameSite=Lax");
}

static void the_longest_texts_have_room(void **state)
{
    const struct guard longest = {0xffffffffu, 65535, TOKEN};
    char text[GUARD_TEXT_BYTES];
    (void)state;
    guard_url(&longest, text);
    assert_string_equal(text + strlen(text) - 32, TOKEN);
    guard_cookie(&longest, text);
    assert_non_null(strstr(text, "; SameSite=Lax"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_the_own_address_is_a_host),
        cmocka_unit_test(the_port_of_http_may_be_left_out),
        cmocka_unit_test(only_the_own_page_is_an_origin),
        cmocka_unit_test(without_a_token_anybody_has_it),
        cmocka_unit_test(a_token_must_be_all_of_it),
        cmocka_unit_test(a_cookie_counts_where_the_query_has_no_token),
        cmocka_unit_test(url_and_cookie_carry_the_token),
        cmocka_unit_test(the_longest_texts_have_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
