#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/memory.h"
#include "../../tools/lumctl/setting.h"

#include <stdlib.h>
#include <string.h>

#define S     INT64_C(1000000000)
#define HOUR  (3600 * S)
#define DAY   (24 * HOUR)
#define START (INT64_C(1795000000) * S)
#define WRAP  (INT64_C(0x100000000) * 1000)

static const struct memory_key key = {0x0a2a0025u, 5517, "Ethernet 2"};

/* A reading of a sensor that booted at START, whose clock is fast by ppm. */
static struct memory_clock reading(int64_t after_ns, int64_t ppm)
{
    const int64_t us = after_ns / 1000 + after_ns / 1000 / 1000000 * ppm;
    return (struct memory_clock){true, START + after_ns, (uint32_t)(uint64_t)us,
                                 100000};
}

static enum memory_run compare(struct memory_clock a, struct memory_clock b)
{
    double missed = -1.0;
    const enum memory_run run = memory_compare(&a, &b, &missed);
    assert_true(missed > 0.0 && missed <= 1.0);
    return run;
}

static void a_clock_that_runs_on_is_the_same_run(void **state)
{
    static const int64_t after[] = {0,        S,       HOUR,           WRAP - S,
                                    WRAP + S, DAY / 2, 2 * DAY + 12345};
    (void)state;
    for (size_t i = 0; i < sizeof after / sizeof after[0]; i++) {
        for (int64_t ppm = -400; ppm <= 400; ppm += 100) {
            const struct memory_clock first = reading(10 * S, 0);
            struct memory_clock then = reading(10 * S + after[i], ppm);
            assert_int_equal(compare(first, then), MEMORY_SAME_RUN);
        }
    }
}

static void a_clock_that_began_anew_is_another_run(void **state)
{
    (void)state;
    for (int64_t after = 10 * S; after < 2 * DAY; after += HOUR / 7) {
        const struct memory_clock first = reading(HOUR, 0);
        struct memory_clock then = reading(HOUR + after, 0);
        then.clock_us -= 90u * 1000000u + (uint32_t)(after / 2000 / 1000);
        assert_int_equal(compare(first, then), MEMORY_OTHER_RUN);
        then.clock_us += 2u * (90u * 1000000u + (uint32_t)(after / 2000000));
        assert_int_equal(compare(first, then), MEMORY_OTHER_RUN);
    }
}

static void a_second_is_the_bound_just_after(void **state)
{
    const struct memory_clock first = reading(HOUR, 0);
    struct memory_clock then = reading(HOUR + S / 1000, 0);
    (void)state;
    then.clock_us -= 990000;
    assert_int_equal(compare(first, then), MEMORY_SAME_RUN);
    then.clock_us -= 30000;
    assert_int_equal(compare(first, then), MEMORY_OTHER_RUN);
}

static void what_the_clock_cannot_tell_is_unknown(void **state)
{
    const struct memory_clock none = {false, 0, 0, 0};
    (void)state;
    assert_int_equal(compare(none, reading(S, 0)), MEMORY_RUN_UNKNOWN);
    assert_int_equal(compare(reading(S, 0), none), MEMORY_RUN_UNKNOWN);
    assert_int_equal(compare(reading(S, 0), reading(6 * DAY, 0)),
                     MEMORY_RUN_UNKNOWN);
    assert_int_equal(compare(reading(S, 0), reading(400 * DAY, 0)),
                     MEMORY_RUN_UNKNOWN);
    /* The host's calendar was set back. */
    assert_int_equal(compare(reading(HOUR, 0), reading(HOUR - 2 * S, 0)),
                     MEMORY_RUN_UNKNOWN);
    assert_int_equal(compare(reading(HOUR, 0), reading(HOUR - S / 2, 0)),
                     MEMORY_SAME_RUN);
}

static void the_chance_to_miss_a_restart_grows_with_time(void **state)
{
    double before = 0.0;
    (void)state;
    for (int64_t after = S; after < 30 * DAY; after *= 2) {
        const struct memory_clock a = reading(S, 0);
        const struct memory_clock b = reading(S + after, 0);
        double missed = 0.0;
        (void)memory_compare(&a, &b, &missed);
        assert_true(missed > before || missed == 1.0);
        before = missed;
    }
}

static void take(struct memory *m, lum_command_id id, uint16_t value,
                 enum memory_standing standing)
{
    const lum_command command = {id, value};
    memory_take(m, &command, standing, START);
}

static void a_restart_leaves_nothing_but_its_times(void **state)
{
    struct memory m = {.clock = reading(HOUR, 0)};
    struct memory_clock now = reading(HOUR + HOUR, 0);
    double missed = 0.0;
    (void)state;
    take(&m, LUM_COMMAND_POWER, 60, MEMORY_DONE);
    now.clock_us = 5;
    assert_int_equal(memory_see_clock(&m, &now, &missed), MEMORY_OTHER_RUN);
    assert_false(memory_has_any(&m));
    assert_int_equal(m.restart_from_ns, START + HOUR);
    assert_int_equal(m.restart_to_ns, START + 2 * HOUR);
    assert_int_equal(m.clock.clock_us, 5);
}

static void what_could_not_be_seen_makes_settings_old(void **state)
{
    const struct memory_clock none = {false, 0, 0, 0};
    const struct memory_clock late = reading(20 * DAY, 0);
    struct memory m = {.clock = reading(HOUR, 0)};
    double missed = 0.0;
    (void)state;
    take(&m, LUM_COMMAND_POWER, 60, MEMORY_DONE);
    take(&m, LUM_COMMAND_HOLDOFF, 200, MEMORY_UNSURE);
    (void)memory_see_clock(&m, &none, &missed);
    assert_int_equal(m.entries[LUM_COMMAND_POWER].standing, MEMORY_DONE);
    assert_true(m.clock.is_known);
    (void)memory_see_clock(&m, &late, &missed);
    assert_int_equal(m.entries[LUM_COMMAND_POWER].standing, MEMORY_OLD);
    assert_int_equal(m.entries[LUM_COMMAND_HOLDOFF].standing, MEMORY_UNSURE);
    assert_int_equal(m.clock.utc_ns, late.utc_ns);
}

static void lines_clear_a_table_and_no_degrees(void **state)
{
    const struct memory_table table = {.scan = MEMORY_TABLE};
    struct memory known = {.clock = {0}};
    struct memory changes = {.begun_ns = START + 1};
    (void)state;
    memory_take_table(&known, &table, 640, MEMORY_DONE, START);
    take(&changes, LUM_COMMAND_LINE_MODE, 1, MEMORY_DONE);
    memory_merge(&known, &changes, START + S);
    assert_int_equal(known.entries[LUM_COMMAND_YSCAN].standing, MEMORY_NOTHING);
    take(&known, LUM_COMMAND_YSCAN, 15, MEMORY_DONE);
    memory_merge(&known, &changes, START + S);
    assert_int_equal(known.entries[LUM_COMMAND_YSCAN].value, 15);
    /* Lines first, then a table: the table stays. */
    memory_take_table(&changes, &table, 64, MEMORY_DONE, START);
    memory_merge(&known, &changes, START + S);
    assert_int_equal(known.entries[LUM_COMMAND_YSCAN].value, 64);
    assert_int_equal(known.table.scan, MEMORY_TABLE);
}

/* Of a command that was under way from START + 5 to START + 9: power 31. */
static enum memory_standing merged_with(enum memory_standing standing,
                                        int64_t utc_ns, uint16_t value,
                                        int64_t now_ns)
{
    const lum_command before = {LUM_COMMAND_POWER, value};
    const lum_command after = {LUM_COMMAND_POWER, 31};
    struct memory known = {.clock = {0}};
    struct memory changes = {.begun_ns = START + 5};
    memory_take(&known, &before, standing, utc_ns);
    memory_take(&known, &(lum_command){LUM_COMMAND_HOLDOFF, 200}, MEMORY_DONE,
                utc_ns);
    memory_take(&changes, &after, MEMORY_DONE, START + 9);
    memory_merge(&known, &changes, now_ns);
    assert_int_equal(known.entries[LUM_COMMAND_POWER].value, 31);
    assert_int_equal(known.entries[LUM_COMMAND_HOLDOFF].standing, MEMORY_DONE);
    return known.entries[LUM_COMMAND_POWER].standing;
}

static enum memory_standing merged(int64_t utc_ns, uint16_t value,
                                   int64_t now_ns)
{
    return merged_with(MEMORY_DONE, utc_ns, value, now_ns);
}

static void what_two_commands_set_at_once_is_unsure(void **state)
{
    (void)state;
    assert_int_equal(merged(START + 4, 21, START + 20), MEMORY_DONE);
    assert_int_equal(merged(START + 5, 21, START + 20), MEMORY_UNSURE);
    assert_int_equal(merged(START + 15, 21, START + 20), MEMORY_UNSURE);
    assert_int_equal(merged(START + 15, 31, START + 20), MEMORY_DONE);
    assert_int_equal(merged(START + 21, 21, START + 20), MEMORY_DONE);
    /* of three, the file has two already */
    assert_int_equal(merged_with(MEMORY_UNSURE, START + 15, 31, START + 20),
                     MEMORY_UNSURE);
}

static void lines_and_a_table_at_once_are_unsure(void **state)
{
    const struct memory_table table = {.scan = MEMORY_TABLE};
    struct memory known = {.clock = {0}};
    struct memory changes = {.begun_ns = START};
    (void)state;
    memory_take_table(&known, &table, 640, MEMORY_DONE, START + 1);
    take(&changes, LUM_COMMAND_LINE_MODE, 1, MEMORY_DONE);
    memory_merge(&known, &changes, START + 2);
    assert_int_equal(known.entries[LUM_COMMAND_YSCAN].standing, MEMORY_UNSURE);
    known = (struct memory){.clock = {0}};
    changes = (struct memory){.begun_ns = START};
    take(&known, LUM_COMMAND_LINE_MODE, 1, MEMORY_DONE);
    memory_take_table(&changes, &table, 640, MEMORY_DONE, START + 1);
    memory_merge(&known, &changes, START + 2);
    assert_int_equal(known.entries[LUM_COMMAND_YSCAN].standing, MEMORY_UNSURE);
    assert_int_equal(known.entries[LUM_COMMAND_LINE_MODE].standing,
                     MEMORY_DONE);
}

static void the_laser_is_not_taken(void **state)
{
    struct memory m = {.clock = {0}};
    (void)state;
    take(&m, LUM_COMMAND_LASER_ON, 0, MEMORY_DONE);
    take(&m, LUM_COMMAND_LASER_OFF, 0, MEMORY_DONE);
    assert_false(memory_has_any(&m));
}

static void fill(struct memory *m)
{
    static const lum_yscan_shape shape = {
        .kind = LUM_YSCAN_REGIONS,
        .region_count = 2,
        .regions = {{-2000000, 2000000, 3}, {-17000000, -3000001, 1000000}}};
    struct memory_table table = {.scan = MEMORY_SHAPE, .shape = shape};
    memset(m, 0, sizeof *m);
    m->clock = reading(DAY, 0);
    m->restart_from_ns = 1;
    m->restart_to_ns = START;
    (void)memcpy(table.from, "my cal.yaml", 12);
    take(m, LUM_COMMAND_POWER, 0, MEMORY_DONE);
    take(m, LUM_COMMAND_THRESHOLD_GREEN, 100, MEMORY_UNSURE);
    take(m, LUM_COMMAND_THRESHOLD_BLUE, 1, MEMORY_OLD);
    take(m, LUM_COMMAND_LINE_MODE, 1, MEMORY_DONE);
    take(m, LUM_COMMAND_OFFSET_BLUE, 30, MEMORY_DONE);
    memory_take_table(m, &table, 64, MEMORY_DONE, START + 5);
}

static void a_file_is_read_as_it_was_written(void **state)
{
    struct memory before;
    struct memory after;
    char text[MEMORY_TEXT_BYTES];
    char again[MEMORY_TEXT_BYTES];
    lum_error error = {""};
    (void)state;
    fill(&before);
    const size_t len = memory_write(&key, &before, text);
    assert_int_equal(memory_read(text, &key, &after, &error), 0);
    assert_int_equal(memory_write(&key, &after, again), len);
    assert_string_equal(text, again);
    assert_memory_equal(before.entries, after.entries, sizeof before.entries);
    assert_memory_equal(&before.table.shape.regions, &after.table.shape.regions,
                        sizeof before.table.shape.regions);
    assert_string_equal(after.table.from, "my cal.yaml");
    assert_int_equal(after.restart_to_ns, START);
}

static void the_longest_file_has_room(void **state)
{
    struct memory m;
    struct memory after;
    struct memory_key long_key = key;
    char text[MEMORY_TEXT_BYTES];
    lum_error error = {""};
    (void)state;
    fill(&m);
    memset(long_key.interface, 'i', sizeof long_key.interface - 1);
    memset(m.table.from, 'f', sizeof m.table.from - 1);
    m.table.shape.region_count = LUM_YSCAN_REGIONS_MAX;
    for (int32_t i = 0; i < (int32_t)LUM_YSCAN_REGIONS_MAX; i++) {
        m.table.shape.regions[i] = (lum_yscan_region){
            -1234567 - i * 2000000, -234568 - i * 2000000, 1000000};
    }
    assert_true(memory_write(&long_key, &m, text) < MEMORY_TEXT_BYTES / 2);
    assert_int_equal(memory_read(text, &long_key, &after, &error), 0);
}

static void every_truncation_is_refused(void **state)
{
    struct memory m;
    char text[MEMORY_TEXT_BYTES];
    (void)state;
    fill(&m);
    const size_t len = memory_write(&key, &m, text);
    for (size_t n = 0; n < len; n++) {
        lum_error error = {""};
        char *exact = malloc(n + 1); /* ASan guards what is behind the NUL */
        assert_non_null(exact);
        memcpy(exact, text, n);
        exact[n] = '\0';
        assert_int_equal(memory_read(exact, &key, &m, &error), -1);
        assert_true(error.text[0] != '\0');
        free(exact);
    }
}

/* With any content of a file, the result of reading it can be printed. */
static void every_changed_byte_is_refused_or_sound(void **state)
{
    struct memory m;
    char text[MEMORY_TEXT_BYTES];
    char again[MEMORY_TEXT_BYTES];
    (void)state;
    fill(&m);
    const size_t len = memory_write(&key, &m, text);
    for (size_t i = 0; i < len; i++) {
        const char was = text[i];
        for (int c = 1; c < 256; c += i % 3 == 0 ? 1 : 7) {
            lum_error error = {""};
            text[i] = (char)c;
            if (memory_read(text, &key, &m, &error) != 0) {
                continue;
            }
            (void)memory_write(&key, &m, again);
            for (int id = 0; id < LUM_COMMANDS; id++) {
                assert_true(strlen(memory_value(&m, (lum_command_id)id).text) >
                            0);
            }
        }
        text[i] = was;
    }
}

static void a_file_of_another_sensor_is_refused(void **state)
{
    const struct memory_key others[] = {{0x0a2a0026u, 5517, "Ethernet 2"},
                                        {0x0a2a0025u, 5518, "Ethernet 2"},
                                        {0x0a2a0025u, 5517, "Ethernet"},
                                        {0x0a2a0025u, 5517, ""}};
    struct memory m;
    char text[MEMORY_TEXT_BYTES];
    (void)state;
    fill(&m);
    (void)memory_write(&key, &m, text);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        lum_error error = {""};
        assert_int_equal(memory_read(text, &others[i], &m, &error), -1);
    }
}

static void every_command_but_the_laser_s_is_one_setting(void **state)
{
    (void)state;
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const bool is_laser =
            id == LUM_COMMAND_LASER_ON || id == LUM_COMMAND_LASER_OFF;
        unsigned found = 0;
        for (size_t i = 0; i < SETTINGS; i++) {
            if (settings[i].id == id && settings[i].name != NULL) {
                found++;
            }
        }
        assert_int_equal(found, is_laser ? 0 : 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_command_but_the_laser_s_is_one_setting),
        cmocka_unit_test(a_clock_that_runs_on_is_the_same_run),
        cmocka_unit_test(a_clock_that_began_anew_is_another_run),
        cmocka_unit_test(a_second_is_the_bound_just_after),
        cmocka_unit_test(what_the_clock_cannot_tell_is_unknown),
        cmocka_unit_test(the_chance_to_miss_a_restart_grows_with_time),
        cmocka_unit_test(a_restart_leaves_nothing_but_its_times),
        cmocka_unit_test(what_could_not_be_seen_makes_settings_old),
        cmocka_unit_test(lines_clear_a_table_and_no_degrees),
        cmocka_unit_test(what_two_commands_set_at_once_is_unsure),
        cmocka_unit_test(lines_and_a_table_at_once_are_unsure),
        cmocka_unit_test(the_laser_is_not_taken),
        cmocka_unit_test(a_file_is_read_as_it_was_written),
        cmocka_unit_test(the_longest_file_has_room),
        cmocka_unit_test(every_truncation_is_refused),
        cmocka_unit_test(every_changed_byte_is_refused_or_sound),
        cmocka_unit_test(a_file_of_another_sensor_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
