#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include "lum/config/config.h"
#include "lum/config/settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static void fill(lum_settings *out)
{
    memset(out, 0xa5, sizeof *out);
}

static void assert_untouched(const lum_settings *out)
{
    const unsigned char *bytes = (const unsigned char *)out;
    for (size_t i = 0; i < sizeof *out; i++) {
        assert_int_equal(bytes[i], 0xa5);
    }
}

/* Parses a copy that ends where the text ends. */
static int parse(const char *text, lum_settings *out, lum_error *error)
{
    uint8_t *copy = exact_copy((const uint8_t *)text, strlen(text));
    const int result =
        lum_settings_parse((const char *)copy, strlen(text), "f", out, error);
    free(copy);
    return result;
}

static void parse_fine(const char *text, lum_settings *out)
{
    lum_error error = {""};
    fill(out);
    if (parse(text, out, &error) != 0) {
        fail_msg("for <%.60s>: '%s'", text, error.text);
    }
    assert_string_equal(error.text, "");
}

static void assert_refused(const char *text, const char *where,
                           const char *says)
{
    lum_settings out;
    lum_error error = {""};
    fill(&out);
    const int result = parse(text, &out, &error);
    if (result != -1 || strncmp(error.text, where, strlen(where)) != 0 ||
        strstr(error.text, says) == NULL) {
        fail_msg("for <%.60s>: %d '%s', want '%s' ... '%s'", text, result,
                 error.text, where, says);
    }
    assert_null(strchr(error.text, '\n'));
    assert_untouched(&out);
}

/* The commands that are set, as the text of one packet. */
static void assert_commands(const lum_settings *s, const char *want)
{
    char text[LUM_COMMANDS * (LUM_COMMAND_TEXT_BYTES + 1) + 1];
    size_t len = 0;
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command command = {(lum_command_id)id, s->value[id]};
        size_t used = 0;
        if (s->has[id]) {
            assert_int_equal(lum_command_format(&command, text + len, &used),
                             LUM_OK);
            len += used;
            text[len++] = ' ';
        }
    }
    text[len] = '\0';
    assert_string_equal(text, want);
}

static void every_key_reaches_its_command(void **state)
{
    lum_settings s;
    (void)state;
    parse_fine("version: 1\nlines: 64\nyscan: 20\npower: 51\n"
               "threshold: {green: 41, blue: 42}\nholdoff: 210\n"
               "offset: {green: 11, blue: 12}\n",
               &s);
    assert_commands(&s, "51p 41g 42b 1f 20y 210h 11G 12B ");
    assert_false(s.has_shape);
}

static void what_a_file_does_not_name_is_not_set(void **state)
{
    static const char *const nothing[] = {"{}", "version: 1", "threshold: {}",
                                          "yscan: {}"};
    lum_settings s;
    (void)state;
    for (size_t i = 0; i < COUNT(nothing); i++) {
        parse_fine(nothing[i], &s);
        assert_commands(&s, "");
        assert_false(s.has_shape);
    }
    parse_fine("threshold: {blue: 0}\nlines: 640", &s);
    assert_commands(&s, "0b 0f ");
}

static void the_sample_file_sets_everything(void **state)
{
    lum_settings s;
    lum_error error = {""};
    (void)state;
    if (lum_settings_load(LUM_SOURCE_DIR "/calib/settings.yaml", &s, &error) !=
        0) {
        fail_msg("%s", error.text);
    }
    for (unsigned id = LUM_COMMAND_POWER; id < LUM_COMMANDS; id++) {
        assert_int_equal(s.has[id], id != LUM_COMMAND_YSCAN);
    }
    assert_true(s.has_shape);
}

static void every_limit_holds(void **state)
{
    static const struct {
        const char *before;
        const char *key;
        unsigned min, max;
    } cases[] = {
        {"power: ", "power", 0, 100},
        {"threshold:\n  green: ", "threshold.green", 0, 100},
        {"threshold:\n  blue: ", "threshold.blue", 0, 100},
        {"yscan: ", "yscan", 11, 30},
        {"holdoff: ", "holdoff", 150, 250},
        {"offset:\n  green: ", "offset.green", 0, 30},
        {"offset:\n  blue: ", "offset.blue", 0, 30},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const unsigned lines = strchr(cases[i].before, '\n') != NULL ? 2 : 1;
        char where[64];
        char allowed[64];
        char text[64];
        lum_settings s;
        (void)snprintf(where, sizeof where, "f:%u: %s: ", lines, cases[i].key);
        (void)snprintf(allowed, sizeof allowed, "allowed: %u to %u",
                       cases[i].min, cases[i].max);
        (void)snprintf(text, sizeof text, "%s%u", cases[i].before,
                       cases[i].min);
        parse_fine(text, &s);
        (void)snprintf(text, sizeof text, "%s%u", cases[i].before,
                       cases[i].max);
        parse_fine(text, &s);
        (void)snprintf(text, sizeof text, "%s%d", cases[i].before,
                       (int)cases[i].min - 1);
        assert_refused(text, where, allowed);
        (void)snprintf(text, sizeof text, "%s%u", cases[i].before,
                       cases[i].max + 1);
        assert_refused(text, where, allowed);
        (void)snprintf(text, sizeof text, "%s%u.5", cases[i].before,
                       cases[i].min);
        assert_refused(text, where, "is not a whole number");
    }
}

static void what_lies_between_steps_is_refused(void **state)
{
    lum_settings s;
    (void)state;
    assert_refused("holdoff: 155",
                   "f:1: holdoff: ", "allowed: 150 to 250 in steps of 10");
    assert_refused("holdoff: 260",
                   "f:1: holdoff: ", "allowed: 150 to 250 in steps of 10");
    parse_fine("holdoff: 160", &s);
    assert_commands(&s, "160h ");
}

static void only_the_two_line_modes_are_known(void **state)
{
    (void)state;
    assert_refused("lines: 320", "f:1: lines: ", "allowed: 640 or 64");
    assert_refused("lines: 1", "f:1: lines: ", "allowed: 640 or 64");
}

static void the_laser_is_refused_and_the_reason_told(void **state)
{
    static const char *const says = "a file cannot switch the laser";
    (void)state;
    assert_refused("power: 5\nlaser: on", "f:2: laser: ", says);
    assert_refused("laser: off", "f:1: laser: ", says);
    assert_refused("laser:", "f:1: laser: ", says);
    assert_refused("laser: {state: on}", "f:1: laser: ", says);
}

static void the_laser_is_not_among_the_keys_that_are_offered(void **state)
{
    lum_settings out;
    lum_error error = {""};
    (void)state;
    assert_int_equal(parse("lasr: on", &out, &error), -1);
    assert_string_equal(error.text,
                        "f:1: unknown key 'lasr'; allowed here: version, "
                        "lines, yscan, power, threshold, holdoff, offset");
}

static void keys_unknown_or_repeated_are_refused(void **state)
{
    (void)state;
    assert_refused("powr: 5", "f:1: ", "did you mean 'power'?");
    assert_refused("power: 5\npower: 5", "f:2: power: ", "already on line 1");
    assert_refused("threshold: {red: 1}",
                   "f:1: threshold: ", "allowed here: green, blue");
    assert_refused("yscan: {fov: 1}", "f:1: yscan: ",
                   "allowed here: shape, min_deg, max_deg, center_deg, "
                   "sigma_deg, regions");
    assert_refused("yscan: {shape: regions, regions: {17: {}}}",
                   "f:1: yscan.regions: ", "unknown key '17'");
    assert_refused("version: 2", "f:1: version: ", "allowed: 1");
    assert_refused("threshold: 5", "f:1: threshold: ", "green, blue");
    assert_refused("", "f:1: ", "version: 1");
}

static void assert_shape(const char *text, const lum_yscan_shape *want)
{
    lum_settings s;
    parse_fine(text, &s);
    assert_commands(&s, "");
    assert_true(s.has_shape);
    assert_int_equal(s.shape.kind, want->kind);
    assert_int_equal(s.shape.min_udeg, want->min_udeg);
    assert_int_equal(s.shape.max_udeg, want->max_udeg);
    assert_int_equal(s.shape.center_udeg, want->center_udeg);
    assert_int_equal(s.shape.sigma_udeg, want->sigma_udeg);
    assert_int_equal(s.shape.region_count, want->region_count);
    assert_memory_equal(s.shape.regions, want->regions,
                        want->region_count * sizeof want->regions[0]);
}

static void a_shape_takes_its_keys(void **state)
{
    const lum_yscan_shape whole = {
        LUM_YSCAN_UNIFORM, INT32_MIN, INT32_MAX, 0, 0, 0, {{0, 0, 0}}};
    const lum_yscan_shape part = {
        LUM_YSCAN_UNIFORM, -10500000, 2000000, 0, 0, 0, {{0, 0, 0}}};
    const lum_yscan_shape bell = {LUM_YSCAN_GAUSSIAN, INT32_MIN, INT32_MAX,
                                  -2000000,           3250000,   0,
                                  {{0, 0, 0}}};
    const lum_yscan_shape cut = {LUM_YSCAN_GAUSSIAN, -9000000, -1, -1, 10000, 0,
                                 {{0, 0, 0}}};
    (void)state;
    assert_shape("yscan: {shape: uniform}", &whole);
    assert_shape("yscan: {shape: uniform, min_deg: -10.5, max_deg: 2}", &part);
    assert_shape("yscan: {sigma_deg: 3.25, center_deg: -2, shape: gaussian}",
                 &bell);
    assert_shape("yscan: {shape: gaussian, center_deg: -1e-6, sigma_deg: 0.01, "
                 "max_deg: -0.000001, min_deg: -9}",
                 &cut);
}

static void regions_come_in_any_order_and_leave_sorted(void **state)
{
    const lum_yscan_shape want = {LUM_YSCAN_REGIONS,
                                  0,
                                  0,
                                  0,
                                  0,
                                  3,
                                  {{1000000, 3000000, 1},
                                   {-2000000, 1000000, 1000000},
                                   {-17000000, -9000000, 3}}};
    (void)state;
    assert_shape("yscan:\n  shape: regions\n  regions:\n"
                 "    7: {min_deg: -2, max_deg: 1, weight: 1000000}\n"
                 "    16: {max_deg: 3, min_deg: 1}\n"
                 "    1: {weight: 3, min_deg: -17, max_deg: -9}\n",
                 &want);
}

static void all_sixteen_regions_fit(void **state)
{
    char text[1024] = "yscan: {shape: regions, regions: {";
    lum_settings s;
    (void)state;
    for (int i = 1; i <= 16; i++) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used,
                       "%d: {min_deg: %d, max_deg: %d, weight: %d}%s", i, i,
                       i + 1, i, i < 16 ? ", " : "}}");
    }
    parse_fine(text, &s);
    assert_int_equal(s.shape.region_count, 16);
    assert_int_equal(s.shape.regions[0].max_udeg, 17000000);
    assert_int_equal(s.shape.regions[15].weight, 1);
}

static void a_shape_that_contradicts_itself_is_refused(void **state)
{
    static const struct {
        const char *text;
        const char *where;
        const char *says;
    } cases[] = {
        {"yscan:\n  min_deg: 3", "f:2: yscan: ", "needs a shape: uniform"},
        {"yscan:\n  regions: {1: {weight: 1}}", "f:2: yscan: ", "a shape"},
        {"yscan:\n  shape: bell",
         "f:2: yscan.shape: ", "allowed: uniform or gaussian or regions"},
        {"yscan:\n  shape: uniform\n  sigma_deg: 3", "f:3: yscan.sigma_deg: ",
         "does not belong to the shape uniform, line 2"},
        {"yscan: {shape: uniform, center_deg: 3}",
         "f:1: yscan.center_deg: ", "does not belong"},
        {"yscan: {shape: uniform, regions: {1: {min_deg: 0}}}",
         "f:1: yscan.regions: ", "does not belong"},
        {"yscan: {shape: regions, min_deg: 3}",
         "f:1: yscan.min_deg: ", "does not belong"},
        {"yscan: {shape: regions, max_deg: 3}",
         "f:1: yscan.max_deg: ", "does not belong"},
        {"yscan:\n  shape: gaussian\n  center_deg: 3",
         "f:2: yscan.shape: ", "gaussian needs sigma_deg"},
        {"yscan: {shape: gaussian, sigma_deg: 3}",
         "f:1: yscan.shape: ", "gaussian needs center_deg"},
        {"yscan: {shape: regions}",
         "f:1: yscan.shape: ", "regions needs regions"},
        {"yscan: {shape: regions, regions: {}}",
         "f:1: yscan.shape: ", "regions needs regions"},
        {"yscan:\n  shape: uniform\n  min_deg: 2\n  max_deg: 2",
         "f:3: yscan.min_deg: ", "must be below max_deg; they are 2 and 2"},
        {"yscan: {shape: gaussian, center_deg: 3, sigma_deg: 1, max_deg: 2}",
         "f:1: yscan.center_deg: ", "outside min_deg to max_deg"},
        {"yscan: {shape: gaussian, center_deg: 1, sigma_deg: 1, min_deg: 2}",
         "f:1: yscan.center_deg: ", "outside min_deg to max_deg"},
        {"yscan: {shape: gaussian, center_deg: 1, sigma_deg: 0.009}",
         "f:1: yscan.sigma_deg: ", "allowed: 0.01 to 90 deg"},
        {"yscan: {shape: uniform, min_deg: -90.1}",
         "f:1: yscan.min_deg: ", "allowed: -90 to 90 deg"},
        {"yscan:\n  shape: regions\n  regions:\n    2: {min_deg: 1}",
         "f:4: yscan.regions.2: ", "needs max_deg"},
        {"yscan: {shape: regions, regions: {2: {weight: 1}}}",
         "f:1: yscan.regions.2: ", "needs min_deg"},
        {"yscan: {shape: regions, regions: {2: {min_deg: 1, max_deg: 1}}}",
         "f:1: yscan.regions.2: ", "must be below max_deg"},
        {"yscan: {shape: regions, regions: {1: {min_deg: 1, max_deg: 3}, "
         "2: {min_deg: 2.5, max_deg: 4}}}",
         "f:1: yscan.regions: ",
         "one reaches up to 3, the next higher begins "
         "at 2.5"},
        {"yscan: {shape: regions, regions: {1: {min_deg: 1, max_deg: 3}, "
         "2: {min_deg: 1, max_deg: 3}}}",
         "f:1: yscan.regions: ", "overlap"},
        {"yscan: {shape: regions, regions: {1: {weight: 0}}}",
         "f:1: yscan.regions.1.weight: ", "allowed: 1 to 1000000"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        assert_refused(cases[i].text, cases[i].where, cases[i].says);
    }
}

static void a_file_that_cannot_be_read_is_named(void **state)
{
    lum_settings s;
    lum_error error = {""};
    (void)state;
    fill(&s);
    assert_int_equal(lum_settings_load("/nonexistent/s.yaml", &s, &error), -1);
    assert_ptr_equal(strstr(error.text, "/nonexistent/s.yaml: cannot be read"),
                     error.text);
    assert_untouched(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_command),
        cmocka_unit_test(what_a_file_does_not_name_is_not_set),
        cmocka_unit_test(the_sample_file_sets_everything),
        cmocka_unit_test(every_limit_holds),
        cmocka_unit_test(what_lies_between_steps_is_refused),
        cmocka_unit_test(only_the_two_line_modes_are_known),
        cmocka_unit_test(the_laser_is_refused_and_the_reason_told),
        cmocka_unit_test(the_laser_is_not_among_the_keys_that_are_offered),
        cmocka_unit_test(keys_unknown_or_repeated_are_refused),
        cmocka_unit_test(a_shape_takes_its_keys),
        cmocka_unit_test(regions_come_in_any_order_and_leave_sorted),
        cmocka_unit_test(all_sixteen_regions_fit),
        cmocka_unit_test(a_shape_that_contradicts_itself_is_refused),
        cmocka_unit_test(a_file_that_cannot_be_read_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
