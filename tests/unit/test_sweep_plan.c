#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "config/sweep_plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Parses a copy that ends where the text ends. */
static int parse_part(const char *text, size_t len, lum_sweep *out,
                      lum_error *error)
{
    uint8_t *copy = exact_copy((const uint8_t *)text, len);
    const int result =
        lum_sweep_parse((const char *)copy, len, "f", out, error);
    free(copy);
    return result;
}

static void parse_fine(const char *text, lum_sweep *out)
{
    lum_error error = {""};
    if (parse_part(text, strlen(text), out, &error) != 0) {
        fail_msg("for <%.60s>: '%s'", text, error.text);
    }
    assert_string_equal(error.text, "");
}

static void assert_refused(const char *text, const char *says)
{
    lum_sweep out;
    lum_error error = {""};
    const int result = parse_part(text, strlen(text), &out, &error);
    if (result != -1 || strcmp(error.text, says) != 0) {
        fail_msg("for <%.80s>: %d, '%s'", text, result, error.text);
    }
    assert_null(out.steps);
    assert_int_equal(out.count, 0);
}

static void assert_has(const lum_settings *s, lum_command_id id, unsigned value)
{
    assert_true(s->has[id]);
    assert_int_equal(s->value[id], value);
}

static const char golden[] = "version: 1\n"
                             "steps:\n"
                             "  - lines: 64\n"
                             "    power: 30\n"
                             "    threshold: {green: 20, blue: 21}\n"
                             "    record: 5\n"
                             "  - threshold: {green: 40}\n"
                             "    record: {seconds: 0.25}\n"
                             "    settle: 1.5\n"
                             "  - record: {frames: 7}\n"
                             "  - power: 60\n";

static void a_plan_has_its_steps_in_order(void **state)
{
    lum_sweep plan;
    (void)state;
    parse_fine(golden, &plan);
    assert_int_equal(plan.count, 4);
    assert_has(&plan.steps[0].settings, LUM_COMMAND_POWER, 30);
    assert_has(&plan.steps[0].settings, LUM_COMMAND_THRESHOLD_BLUE, 21);
    assert_int_equal(plan.steps[0].record_ns, INT64_C(5000000000));
    assert_int_equal(plan.steps[0].frames, 0);
    assert_int_equal(plan.steps[0].settle_ns, 0);
    assert_int_equal(plan.steps[1].record_ns, 250000000);
    assert_int_equal(plan.steps[1].settle_ns, 1500000000);
    assert_false(plan.steps[1].settings.has[LUM_COMMAND_POWER]);
    assert_int_equal(plan.steps[2].frames, 7);
    assert_int_equal(plan.steps[2].record_ns, 0);
    assert_int_equal(plan.steps[3].frames, 0);
    assert_int_equal(plan.steps[3].record_ns, 0);
    lum_sweep_free(&plan);
    assert_null(plan.steps);
}

static void settings_stay_until_a_later_step_changes_them(void **state)
{
    lum_sweep plan;
    (void)state;
    parse_fine(golden, &plan);
    const lum_settings *last = &plan.steps[3].all;
    assert_has(last, LUM_COMMAND_POWER, 60);
    assert_has(last, LUM_COMMAND_THRESHOLD_GREEN, 40);
    assert_has(last, LUM_COMMAND_THRESHOLD_BLUE, 21);
    assert_true(last->has[LUM_COMMAND_LINE_MODE]);
    assert_has(&plan.steps[2].all, LUM_COMMAND_POWER, 30);
    assert_false(plan.steps[0].all.has_shape);
    lum_sweep_free(&plan);
}

/* A table is made for the lines that are in force, and new lines clear it. */
static void a_table_goes_with_its_lines(void **state)
{
    lum_sweep plan;
    (void)state;
    parse_fine("steps:\n"
               "  - lines: 64\n"
               "  - yscan: {shape: uniform, min_deg: -10, max_deg: 2}\n"
               "  - power: 10\n"
               "  - lines: 640\n"
               "  - yscan: 20\n"
               "  - lines: 64\n"
               "  - yscan: {shape: uniform}\n",
               &plan);
    const lum_sweep_step *s = plan.steps;
    assert_has(&s[1].settings, LUM_COMMAND_LINE_MODE,
               s[0].settings.value[LUM_COMMAND_LINE_MODE]);
    assert_true(s[2].all.has_shape);
    assert_false(s[2].settings.has_shape);
    assert_int_equal(s[2].all.shape.min_udeg, -10000000);
    assert_false(s[3].all.has_shape);
    assert_has(&s[4].all, LUM_COMMAND_YSCAN, 20);
    assert_has(&s[5].all, LUM_COMMAND_YSCAN, 20);
    assert_true(s[6].all.has_shape);
    assert_false(s[6].all.has[LUM_COMMAND_YSCAN]);
    lum_sweep_free(&plan);
}

static void what_makes_no_sense_is_refused_with_its_place(void **state)
{
    (void)state;
    assert_refused("steps: []\n",
                   "f:1: steps: the list is empty; give at least one step");
    assert_refused("steps:\n  - settle: 1\n",
                   "f:2: steps.1: neither a setting nor record");
    assert_refused("steps:\n  - record: {seconds: 1, frames: 2}\n",
                   "f:2: steps.1: record.seconds and record.frames: give one");
    assert_refused("steps:\n  - power: 5\n  - power: 101\n",
                   "f:3: steps.2.power: '101' is out of range; allowed: 0 to "
                   "100");
    assert_refused("steps:\n  - record: 0.05\n",
                   "f:2: steps.1.record: '0.05' is out of range; allowed: 0.1 "
                   "to 86400 s, or a mapping of seconds, frames");
    assert_refused("steps:\n  - record: 86400.001\n",
                   "f:2: steps.1.record: '86400.001' is out of range; allowed: "
                   "0.1 to 86400 s, or a mapping of seconds, frames");
    assert_refused(
        "steps:\n  - record: {frames: 0}\n",
        "f:2: steps.1.record.frames: '0' is out of range; allowed: 1 "
        "to 1000000");
    assert_refused(
        "steps:\n  - holdoff: 155\n",
        "f:2: steps.1.holdoff: 155 is not a step; allowed: 150 to 250 "
        "in steps of 10");
    assert_refused("steps:\n  - power: 1\n    laser: on\n",
                   "f:3: steps.1.laser: a file cannot switch the laser; a "
                   "person who watches the sensor does, by 'lumctl laser on' "
                   "or 'lumctl laser off'; leave the key out");
}

static void limits_are_allowed(void **state)
{
    lum_sweep plan;
    (void)state;
    parse_fine("steps:\n  - record: 0.1\n    settle: 0\n  - record: 86400\n"
               "    settle: 3600\n  - record: {frames: 1}\n"
               "  - record: {frames: 1000000}\n",
               &plan);
    assert_int_equal(plan.steps[0].record_ns, 100000000);
    assert_int_equal(plan.steps[1].record_ns, INT64_C(86400000000000));
    assert_int_equal(plan.steps[1].settle_ns, INT64_C(3600000000000));
    assert_int_equal(plan.steps[2].frames, 1);
    assert_int_equal(plan.steps[3].frames, 1000000);
    lum_sweep_free(&plan);
}

static void at_most_1000_steps_are_read(void **state)
{
    static char text[40000];
    lum_sweep plan;
    lum_error error = {""};
    (void)state;
    size_t n = (size_t)snprintf(text, sizeof text, "steps:\n");
    for (unsigned i = 0; i < LUM_SWEEP_STEPS; i++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "  - power: 1\n");
    }
    parse_fine(text, &plan);
    assert_int_equal(plan.count, LUM_SWEEP_STEPS);
    lum_sweep_free(&plan);
    n += (size_t)snprintf(text + n, sizeof text - n, "  - power: 1\n");
    assert_int_equal(parse_part(text, n, &plan, &error), -1);
    assert_non_null(strstr(error.text, "1000"));
}

/* None crashes, and none gives a step that is not there. */
static void every_cut_is_a_plan_or_an_error(void **state)
{
    (void)state;
    for (size_t len = 0; len < sizeof golden; len++) {
        lum_sweep plan;
        lum_error error = {""};
        if (parse_part(golden, len, &plan, &error) == 0) {
            assert_in_range(plan.count, 1, 4);
            lum_sweep_free(&plan);
        } else {
            assert_null(plan.steps);
            assert_int_not_equal(error.text[0], '\0');
        }
    }
}

static void a_file_that_is_not_there_is_named(void **state)
{
    lum_sweep plan;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_sweep_load("/nonexistent/plan.yaml", &plan, &error),
                     -1);
    assert_non_null(strstr(error.text, "/nonexistent/plan.yaml"));
    assert_null(plan.steps);
}

static void the_sample_has_each_threshold_at_two_powers(void **state)
{
    lum_sweep plan;
    lum_error error = {""};
    (void)state;
    if (lum_sweep_load(LUM_SOURCE_DIR "/calib/sweep.yaml", &plan, &error) !=
        0) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(plan.count, 8);
    for (unsigned i = 0; i < 8; i++) {
        const lum_sweep_step *step = &plan.steps[i];
        assert_has(&step->all, LUM_COMMAND_POWER, i < 4 ? 40 : 80);
        assert_has(&step->all, LUM_COMMAND_THRESHOLD_GREEN, 20 + i % 4 * 20);
        assert_has(&step->all, LUM_COMMAND_THRESHOLD_BLUE, 20 + i % 4 * 20);
        assert_int_equal(step->record_ns, INT64_C(5000000000));
    }
    lum_sweep_free(&plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_has_its_steps_in_order),
        cmocka_unit_test(settings_stay_until_a_later_step_changes_them),
        cmocka_unit_test(a_table_goes_with_its_lines),
        cmocka_unit_test(what_makes_no_sense_is_refused_with_its_place),
        cmocka_unit_test(limits_are_allowed),
        cmocka_unit_test(at_most_1000_steps_are_read),
        cmocka_unit_test(every_cut_is_a_plan_or_an_error),
        cmocka_unit_test(a_file_that_is_not_there_is_named),
        cmocka_unit_test(the_sample_has_each_threshold_at_two_powers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
