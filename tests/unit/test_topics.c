#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumros2/schedule.h"
#include "lumros2/topics.h"

#include <string.h>

#define S INT64_C(1000000000)

/* --- Names --- */

static void names_are_words_between_slashes(void **state)
{
    static const char *const good[] = {"a", "/a", "/left/points", "a_1/B2/_c"};
    static const char *const bad[] = {"",   "/",    "a/",  "//a", "a//b",
                                      "1a", "/a/1", "a-b", "~/a", "a b"};
    char long_name[400];
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        assert_true(names_is(good[i]));
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(names_is(bad[i]));
    }
    memset(long_name, 'a', sizeof long_name);
    long_name[NAMES_BYTES / 2u] = '\0';
    assert_false(names_is(long_name));
    long_name[NAMES_BYTES / 2u - 1u] = '\0';
    assert_true(names_is(long_name));
}

static void expect_topic(const struct names *names, const char *topic,
                         const char *published)
{
    char out[NAMES_BYTES];
    assert_true(names_topic(names, topic, out));
    assert_string_equal(out, published);
}

static void a_namespace_is_in_front_of_a_nodes_own_topics(void **state)
{
    const struct names none = {.prefix = NULL};
    const struct names left = {.prefix = "left"};
    const struct names deep = {.prefix = "/car/left"};
    char out[NAMES_BYTES];
    (void)state;
    expect_topic(&none, "/points", "/points");
    expect_topic(&none, "points", "/points");
    expect_topic(&left, "/points", "/left/points");
    expect_topic(&deep, "points", "/car/left/points");
    expect_topic(&left, "/tf_static", "/tf_static");
    expect_topic(&left, "/tf", "/tf");
    expect_topic(&left, "/diagnostics", "/diagnostics");
    expect_topic(&left, "/my/tf", "/left/my/tf");
    assert_false(names_topic(&left, "/no name", out));
}

static void a_remap_gives_another_name(void **state)
{
    struct names names = {.prefix = "left"};
    lum_error why = {""};
    (void)state;
    assert_true(names_add_remap(&names, "points:=cloud", &why));
    assert_true(names_add_remap(&names, "/diagnostics:=/left/health", &why));
    assert_true(names_add_remap(&names, "/a:=/points", &why));
    expect_topic(&names, "/points", "/left/cloud");
    expect_topic(&names, "points", "/left/cloud");
    expect_topic(&names, "/diagnostics", "/left/health");
    expect_topic(&names, "/a", "/points");
    expect_topic(&names, "/pointsx", "/left/pointsx");
    expect_topic(&names, "/point", "/left/point");
}

static void what_is_no_remap_is_refused(void **state)
{
    static const char *const bad[] = {"",    "a",      "a:=",  ":=b",
                                      "a=b", "a:=b c", "1:=b", "a:=b:=c"};
    struct names names = {.prefix = NULL};
    lum_error why = {""};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(names_add_remap(&names, bad[i], &why));
    }
    for (unsigned i = 0; i < NAMES_REMAPS_MAX; i++) {
        assert_true(names_add_remap(&names, "a:=b", &why));
    }
    assert_string_equal(why.text, "");
    assert_false(names_add_remap(&names, "a:=b", &why));
    assert_string_equal(why.text, "more than 32 of them");
}

static void dds_has_names_of_its_own(void **state)
{
    static const char *const bad[] = {"",
                                      "sensor_msgs/PointCloud2",
                                      "sensor_msgs/srv/Set",
                                      "/msg/A",
                                      "a/msg/",
                                      "a/msg/B/C",
                                      "a/msg/B C"};
    char out[NAMES_BYTES];
    (void)state;
    names_dds_topic("/left/points", out);
    assert_string_equal(out, "rt/left/points");
    assert_true(names_dds_type("sensor_msgs/msg/PointCloud2", out));
    assert_string_equal(out, "sensor_msgs::msg::dds_::PointCloud2_");
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(names_dds_type(bad[i], out));
    }
}

/* --- How topics are sent --- */

static void static_frames_are_latched_and_others_reliable(void **state)
{
    const struct qos qos = {.depth = 5};
    (void)state;
    assert_int_equal(qos_of(&qos, "/points"), QOS_RELIABLE);
    assert_int_equal(qos_of(&qos, "/tf_static"), QOS_LATCHED);
}

static void the_last_rule_of_a_topic_holds(void **state)
{
    struct qos qos = {.depth = 5};
    lum_error why = {""};
    (void)state;
    assert_true(qos_add(&qos, "sensor", &why));
    assert_true(qos_add(&qos, "/diagnostics=latched", &why));
    assert_true(qos_add(&qos, "left/points=sensor", &why));
    assert_true(qos_add(&qos, "left/points=reliable", &why));
    assert_int_equal(qos_of(&qos, "/points"), QOS_SENSOR);
    assert_int_equal(qos_of(&qos, "/tf_static"), QOS_LATCHED);
    assert_int_equal(qos_of(&qos, "/diagnostics"), QOS_LATCHED);
    assert_int_equal(qos_of(&qos, "/left/points"), QOS_RELIABLE);
    assert_int_equal(qos_of(&qos, "/left/point"), QOS_SENSOR);
    assert_true(qos_add(&qos, "tf_static=reliable", &why));
    assert_int_equal(qos_of(&qos, "/tf_static"), QOS_RELIABLE);
}

static void what_is_no_rule_is_refused(void **state)
{
    static const char *const bad[] = {"", "best", "=sensor", "a=", "a=best"};
    struct qos qos = {.depth = 5};
    lum_error why = {""};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_false(qos_add(&qos, bad[i], &why));
    }
    for (unsigned i = 0; i < QOS_RULES_MAX; i++) {
        assert_true(qos_add(&qos, "a=sensor", &why));
    }
    assert_false(qos_add(&qos, "a=sensor", &why));
    assert_string_equal(why.text, "more than 32 of them");
}

/* --- Times --- */

static void messages_keep_their_distances(void **state)
{
    struct schedule schedule;
    (void)state;
    schedule_begin(&schedule, 1.0, 100 * S);
    assert_int_equal(schedule_due(&schedule, 5000u * (uint64_t)S), 100 * S);
    assert_int_equal(schedule_due(&schedule, 5002u * (uint64_t)S), 102 * S);
    assert_int_equal(schedule_due(&schedule, 5001u * (uint64_t)S), 101 * S);
    schedule_begin(&schedule, 4.0, 100 * S);
    assert_int_equal(schedule_due(&schedule, 5000u * (uint64_t)S), 100 * S);
    assert_int_equal(schedule_due(&schedule, 5002u * (uint64_t)S),
                     100 * S + S / 2);
}

/* The host's clock was set, or there was none. */
static void times_of_another_clock_begin_again(void **state)
{
    const uint64_t year = UINT64_C(31536000000000000);
    struct schedule schedule;
    (void)state;
    schedule_begin(&schedule, 0.5, 100 * S);
    assert_int_equal(schedule_due(&schedule, 0), 100 * S);
    assert_int_equal(schedule_due(&schedule, 3), 100 * S + 6);
    assert_int_equal(schedule_due(&schedule, 50 * year), 100 * S + 6);
    assert_int_equal(schedule_due(&schedule, 50 * year + 1), 100 * S + 8);
    assert_int_equal(schedule_due(&schedule, 7), 100 * S + 8);
    assert_int_equal(schedule_due(&schedule, UINT64_MAX), 100 * S + 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_words_between_slashes),
        cmocka_unit_test(a_namespace_is_in_front_of_a_nodes_own_topics),
        cmocka_unit_test(a_remap_gives_another_name),
        cmocka_unit_test(what_is_no_remap_is_refused),
        cmocka_unit_test(dds_has_names_of_its_own),
        cmocka_unit_test(static_frames_are_latched_and_others_reliable),
        cmocka_unit_test(the_last_rule_of_a_topic_holds),
        cmocka_unit_test(what_is_no_rule_is_refused),
        cmocka_unit_test(messages_keep_their_distances),
        cmocka_unit_test(times_of_another_clock_begin_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
