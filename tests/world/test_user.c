#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "user.h"
#include "user/internal.h"

#include <stdio.h>
#include <string.h>

/* --- stories --- */

static unsigned steps;
static int64_t chosen;

STORY(one_that_holds, "what holds is no failure")
{
    user_expect(2 > 1);
    user_expect_equal(2, 2);
    user_expect_at_least(3, 2);
    user_expect_at_most(2, 3);
    user_expect_has("a text", "tex");
    user_expect_lacks("a text", "test");
    user_expect_same("a", user_format("%c", 'a'));
    user_expect_like("12 rows", "^[0-9]+ rows$");
    user_pause_ms(1500);
    steps++;
}

STORY(one_that_fails_early, "nothing is told behind what does not hold")
{
    steps++;
    user_expect_equal(steps + 1, 7);
    steps++;
}

STORY(one_that_waits_in_vain, "what never comes is waited for until the limit")
{
    user_limit(5, 1000);
    user_until(steps > 100);
}

static void add_a_step(void *unused)
{
    (void)unused;
    steps++;
}

STORY(one_that_waits, "a condition is looked at again and again")
{
    (void)world_at(2 * WORLD_S, add_a_step, NULL);
    user_until(steps > 0);
}

STORY(one_that_differs, "chance is that of the seed")
{
    chosen = user_any(0, INT64_C(1) << 60);
}

STORY(one_on_a_bench, "computers, their wire and their files")
{
    const user_bench b = user_bench_new();
    user_expect_same(user_address_of(b.host), "10.42.0.1");
    user_expect_same(user_address_of(b.sensor), "10.42.0.37");
    user_expect_equal(user_ip("10.42.0.37"), 0x0a2a0025);
    user_expect_same(user_names(b.host), "");
    user_write_file(b.host, "b.txt", "two\nrows\n");
    user_write_file(b.host, "a.txt", "");
    user_expect_same(user_names(b.host), "a.txt b.txt ");
    user_expect_same(user_file(b.host, "b.txt"), "two\nrows\n");
    user_expect_equal(user_size(b.host, "/home/b.txt"), 9);
    user_expect_equal(user_size(b.host, "c.txt"), -1);
    user_expect_equal(user_size(b.sensor, "b.txt"), -1);
    user_expect_equal(user_files(b.host, "", ".txt"), 2);
    user_expect_equal(user_size_of(b.host, "b"), 9);
    (void)user_file(b.host, "c.txt");
}

STORY(one_with_mail, "programs of the user's own hear each other")
{
    const user_bench b = user_bench_new();
    user_peer *here = user_peer_new(b.host, "10.42.0.1", 0, NULL, NULL);
    user_peer *there = user_peer_new(b.sensor, "10.42.0.37", 5517, NULL, NULL);
    user_send(here, user_ip("10.42.0.37"), 5517, "hello", 5);
    user_until(user_mails(there) == 1);
    user_expect_equal(user_mail_at(there, 0)->from, user_ip("10.42.0.1"));
    user_expect_equal(user_mail_at(there, 0)->port, user_port_of(here));
    user_expect(memcmp(user_mail_at(there, 0)->bytes, "hello", 5) == 0);
    user_peer_leave(there);
    user_fault(b.eth0, (user_faults){.lose = 1});
    user_send(there, user_ip("10.42.0.1"), user_port_of(here), "late", 4);
    user_pause_ms(100);
    user_expect_equal(user_mails(here), 0);
}

static user_result tell(const char *name, uint64_t seed)
{
    steps = 0;
    return user_tell(user_story_find(name), seed);
}

/* --- facts --- */

static void stories_enter_the_table(void **state)
{
    (void)state;
    assert_string_equal(user_story_at(0)->name, "one_that_holds");
    assert_string_equal(user_story_at(0)->fact, "what holds is no failure");
    assert_null(user_story_find("one_that_is_not_there"));
    size_t count = 0;
    while (user_story_at(count) != NULL) {
        count++;
    }
    assert_int_equal(count, 7);
}

static void what_holds_is_no_failure(void **state)
{
    (void)state;
    const user_result result = tell("one_that_holds", 1);
    assert_string_equal(result.failure, "");
    assert_int_equal(steps, 1);
    assert_int_equal(result.lasted_ns, 1500 * WORLD_MS);
}

static void what_does_not_hold_ends_the_story_and_says_where(void **state)
{
    (void)state;
    const user_result result = tell("one_that_fails_early", 1);
    assert_int_equal(steps, 1);
    assert_non_null(strstr(result.failure, "test_user.c:"));
    assert_non_null(strstr(result.failure, "steps + 1 is 2 and not 7"));
}

static void what_never_comes_fails_at_the_limit(void **state)
{
    (void)state;
    const user_result result = tell("one_that_waits_in_vain", 1);
    assert_non_null(strstr(result.failure, "waited in vain for steps > 100"));
    assert_int_equal(result.lasted_ns, 5 * WORLD_S);
}

static void what_comes_is_seen(void **state)
{
    (void)state;
    const user_result result = tell("one_that_waits", 1);
    assert_string_equal(result.failure, "");
    assert_true(result.lasted_ns >= 2 * WORLD_S &&
                result.lasted_ns < 3 * WORLD_S);
}

static void a_seed_decides(void **state)
{
    (void)state;
    const user_result one = tell("one_that_differs", 1);
    const int64_t first = chosen;
    const user_result again = tell("one_that_differs", 1);
    assert_int_equal(chosen, first);
    assert_int_equal(one.digest, again.digest);
    (void)tell("one_that_differs", 2);
    assert_int_not_equal(chosen, first);
}

static void a_bench_has_files(void **state)
{
    (void)state;
    const user_result result = tell("one_on_a_bench", 1);
    assert_non_null(
        strstr(result.failure, "there is no file c.txt, but: a.txt b.txt "));
}

static void programs_of_the_user_hear_each_other(void **state)
{
    (void)state;
    assert_string_equal(tell("one_with_mail", 1).failure, "");
}

static void values_of_json_have_a_path(void **state)
{
    static const char json[] =
        "{\"a\": 1, \"b\": {\"c\": [true, {\"d\": \"x, \\\"y\\\"\"}, null]},\n"
        " \"e\": -2.5}\n";
    (void)state;
    assert_string_equal(user_value(json, "a"), "1");
    assert_string_equal(user_value(json, "b.c.0"), "true");
    assert_string_equal(user_value(json, "b.c.1.d"), "x, \\\"y\\\"");
    assert_string_equal(user_value(json, "b.c"),
                        "[true, {\"d\": \"x, \\\"y\\\"\"}, null]");
    assert_true(user_number(json, "e") < -2.4);
    assert_int_equal(user_length(json, "b.c"), 3);
    assert_int_equal(user_length(json, "b"), 0);
    assert_null(user_value(json, "b.c.3"));
    assert_null(user_value(json, "c"));
    assert_null(user_value("", "a"));
    user_text_reset();
}

static void words_are_as_in_a_shell(void **state)
{
    size_t count = 0;
    (void)state;
    const char **words =
        user_words("lumctl  send '50p u' --x='a b'c '' ", &count);
    assert_int_equal(count, 5);
    assert_string_equal(words[0], "lumctl");
    assert_string_equal(words[2], "50p u");
    assert_string_equal(words[3], "--x=a bc");
    assert_string_equal(words[4], "");
    assert_null(words[5]);
    user_text_reset();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stories_enter_the_table),
        cmocka_unit_test(what_holds_is_no_failure),
        cmocka_unit_test(what_does_not_hold_ends_the_story_and_says_where),
        cmocka_unit_test(what_never_comes_fails_at_the_limit),
        cmocka_unit_test(what_comes_is_seen),
        cmocka_unit_test(a_seed_decides),
        cmocka_unit_test(a_bench_has_files),
        cmocka_unit_test(programs_of_the_user_hear_each_other),
        cmocka_unit_test(values_of_json_have_a_path),
        cmocka_unit_test(words_are_as_in_a_shell)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
