#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/rig.h"

#include <stdbool.h>
#include <string.h>

#define A31 "abcdefghijklmnopqrstuvwxyz_1234"
#define A63 A31 "_" A31

/* A rig of two. */
static lum_rig make(void)
{
    lum_rig rig;
    lum_rig_init(&rig);
    assert_int_equal(lum_rig_set_sensor(&rig, 0, "name", "front", NULL),
                     LUM_OK);
    assert_int_equal(lum_rig_set_sensor(&rig, 0, "address", "10.42.0.37", NULL),
                     LUM_OK);
    assert_int_equal(
        lum_rig_set_sensor(&rig, 1, "address", "10.42.0.38%eth1", NULL),
        LUM_OK);
    assert_int_equal(lum_rig_set_sensor(&rig, 1, "name", "left", NULL), LUM_OK);
    return rig;
}

static void set(lum_rig *rig, size_t i, const char *key, const char *value)
{
    lum_key_refusal why;
    if (lum_rig_set_sensor(rig, i, key, value, &why) != LUM_OK) {
        fail_msg("%s: %s", why.key, why.text);
    }
}

static void assert_kept(const lum_rig *a, const lum_rig *b)
{
    assert_memory_equal(a, b, sizeof *a);
}

/* A value of the second sensor is refused, and nothing is set. */
static void assert_refused(const char *key, const char *value,
                           lum_result result, const char *its_key,
                           const char *text)
{
    lum_rig rig = make();
    const lum_rig before = rig;
    lum_key_refusal why = {.place = 77};
    assert_int_equal(lum_rig_set_sensor(&rig, 1, key, value, NULL), result);
    assert_int_equal(lum_rig_set_sensor(&rig, 1, key, value, &why), result);
    assert_string_equal(why.key, its_key);
    assert_int_equal(why.place, 2);
    assert_string_equal(why.text, text);
    assert_kept(&rig, &before);
}

static void assert_value_refused(const char *key, const char *value,
                                 const char *its_key, const char *begin)
{
    lum_rig rig = make();
    lum_key_refusal why;
    assert_int_equal(lum_rig_set_sensor(&rig, 1, key, value, &why),
                     LUM_E_VALUE);
    assert_string_equal(why.key, its_key);
    if (strncmp(why.text, begin, strlen(begin)) != 0) {
        fail_msg("<%s> is not <%s>", why.text, begin);
    }
}

/* --- Values --- */

static void a_rig_begins_without_sensors(void **state)
{
    lum_rig rig;
    lum_key_refusal why;
    (void)state;
    lum_rig_init(&rig);
    assert_string_equal(rig.frame, "base_link");
    assert_int_equal(rig.count, 0);
    assert_int_equal(lum_rig_check(&rig, &why), LUM_E_VALUE);
    assert_string_equal(why.key, "sensors");
    assert_string_equal(why.text, "missing; a rig has 1 to 8 sensors");
}

static void every_key_of_a_sensor_reaches_its_field(void **state)
{
    lum_rig rig = make();
    const lum_rig_sensor *s = &rig.sensor[1];
    (void)state;
    set(&rig, 1, "name", A31);
    set(&rig, 1, "address", "10.42.0.39");
    set(&rig, 1, "interface", "eth1"); /* that is what it is already */
    set(&rig, 1, "calibration", "left.yaml");
    set(&rig, 1, "profile", "folder/g2.yaml");
    set(&rig, 1, "pose.x_m", "1.2");
    set(&rig, 1, "pose.y_m", "-1000");
    set(&rig, 1, "pose.z_m", "1e3");
    set(&rig, 1, "pose.roll_deg", "0.000001");
    set(&rig, 1, "pose.pitch_deg", "-360");
    set(&rig, 1, "pose.yaw_deg", "360");
    assert_string_equal(s->name, A31);
    assert_int_equal(s->address, 0x0a2a0027);
    assert_string_equal(s->interface, "eth1");
    assert_int_equal(s->at_um[0], 1200000);
    assert_int_equal(s->at_um[1], -1000000000);
    assert_int_equal(s->at_um[2], 1000000000);
    assert_int_equal(s->roll_udeg, 1);
    assert_int_equal(s->pitch_udeg, -360000000);
    assert_int_equal(s->yaw_udeg, 360000000);
    assert_int_equal(rig.count, 2);
    assert_int_equal(lum_rig_check(&rig, NULL), LUM_OK);
}

static void the_rig_itself_has_a_frame(void **state)
{
    lum_rig rig = make();
    lum_key_refusal why;
    (void)state;
    assert_int_equal(lum_rig_set(&rig, "frame", "Car-1/base.link_", &why),
                     LUM_OK);
    assert_string_equal(rig.frame, "Car-1/base.link_");
    assert_int_equal(lum_rig_set(&rig, "frame", A63, &why), LUM_OK);
    assert_int_equal(lum_rig_set(&rig, "version", "1", &why), LUM_OK);
    assert_string_equal(rig.frame, A63);
    assert_int_equal(lum_rig_set(&rig, "version", "2", NULL), LUM_E_VALUE);
    assert_int_equal(lum_rig_set(&rig, "frame", "/car", &why), LUM_E_VALUE);
    assert_string_equal(why.key, "frame");
    assert_int_equal(why.place, 0);
    assert_string_equal(why.text,
                        "'/car' does not begin with a letter; allowed: 1 to 63 "
                        "letters, digits, '_', '-', '.' and '/', a letter "
                        "first");
    assert_int_equal(lum_rig_set(&rig, "frame", A63 "x", &why), LUM_E_VALUE);
    assert_int_equal(lum_rig_set(&rig, "frames", "x", &why), LUM_E_TYPE);
    assert_string_equal(why.text,
                        "unknown key 'frames'; did you mean 'frame'? allowed "
                        "here: version, frame, sensors");
    assert_int_equal(lum_rig_set(&rig, "sensors", "3", &why), LUM_E_VALUE);
    assert_string_equal(why.text, "'3' is no list; allowed: a list of 1 to 8 "
                                  "sensors, each begun by '-'");
    assert_string_equal(rig.frame, A63);
}

static void keys_that_are_not_there_are_refused(void **state)
{
    (void)state;
    assert_refused("names", "x", LUM_E_TYPE, "sensors.2",
                   "unknown key 'names'; did you mean 'name'? allowed here: "
                   "name, address, interface, calibration, profile, pose");
    assert_refused("pose", "1", LUM_E_TYPE, "sensors.2.pose",
                   "a single value does not belong here; allowed: a mapping of "
                   "x_m, y_m, z_m, roll_deg, pitch_deg, yaw_deg");
    assert_refused("pose.x", "1", LUM_E_TYPE, "sensors.2.pose",
                   "unknown key 'x'; allowed here: x_m, y_m, z_m, roll_deg, "
                   "pitch_deg, yaw_deg");
}

static void a_name_is_of_letters_digits_and_underscores(void **state)
{
    static const char *const fine[] = {"a", "z", "A", "Z", "a0", "a9", "aZ_"};
    static const char *const wrong[] = {"1a", "_a", "@a", "[a", "`a", "{a"};
    static const char *const other[] = {"a b", "a/", "a:", "a-", "a.", "a%"};
    lum_rig rig = make();
    (void)state;
    for (size_t i = 0; i < sizeof fine / sizeof fine[0]; i++) {
        set(&rig, 1, "name", fine[i]);
        assert_string_equal(rig.sensor[1].name, fine[i]);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_value_refused("name", other[i], "sensors.2.name", "'a");
        lum_key_refusal why;
        assert_int_equal(lum_rig_set_sensor(&rig, 1, "name", wrong[i], &why),
                         LUM_E_VALUE);
        assert_non_null(strstr(why.text, "does not begin with a letter"));
    }
    assert_value_refused("name", "", "sensors.2.name",
                         "'' does not begin with a letter");
    assert_refused("name", A31 "x", LUM_E_VALUE, "sensors.2.name",
                   "'" A31 "x' is too long; allowed: 1 to 31 letters, digits "
                   "and '_', a letter first");
}

static void addresses_are_those_of_hosts(void **state)
{
    static const struct {
        const char *text;
        uint32_t address;
    } fine[] = {
        {"0.0.0.1", 1},
        {"223.255.255.255", 0xdfffffff},
        {"1.20.30.0", 0x01141e00},
    };
    static const char *const wrong[] = {
        "",          "1",        "1.",        "1.2.3",      "1.2.3.",
        "1.2.3.256", "1.2.3.-1", "1.2.3.4.5", "01.2.3.4",   "1.2.3.00",
        "1.2.3.4 ",  "a.2.3.4",  "1.2.3./",   "2560.2.3.4", "1,2.3.4",
    };
    lum_rig rig = make();
    (void)state;
    for (size_t i = 0; i < sizeof fine / sizeof fine[0]; i++) {
        set(&rig, 1, "address", fine[i].text);
        assert_int_equal(rig.sensor[1].address, fine[i].address);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        lum_key_refusal why;
        assert_int_equal(lum_rig_set_sensor(&rig, 1, "address", wrong[i], &why),
                         LUM_E_VALUE);
        if (strstr(why.text, "is not an IPv4 address") == NULL) {
            fail_msg("<%s> %s", wrong[i], why.text);
        }
    }
    assert_value_refused("address", "0.0.0.0", "sensors.2.address",
                         "'0.0.0.0' is no sensor's address");
    assert_value_refused("address", "224.0.0.0", "sensors.2.address",
                         "'224.0.0.0' is no sensor's address");
    assert_value_refused("address", "1.2.3.4%", "sensors.2.address",
                         "'1.2.3.4%' has no interface behind its '%'");
}

static void an_interface_is_named_once(void **state)
{
    lum_rig rig = make();
    (void)state;
    set(&rig, 0, "interface", "!~");
    assert_string_equal(rig.sensor[0].interface, "!~");
    set(&rig, 0, "address", "1.2.3.4%!~");
    assert_int_equal(rig.sensor[0].address, 0x01020304);
    assert_refused("interface", "eth10", LUM_E_VALUE, "sensors.2.interface",
                   "the interface is 'eth10' here and 'eth1' before; name it "
                   "once");
    assert_refused("address", "10.42.0.39%eth0", LUM_E_VALUE,
                   "sensors.2.address",
                   "the interface is 'eth0' here and 'eth1' before; name it "
                   "once");
    assert_value_refused("interface", "", "sensors.2.interface",
                         "'' is empty; allowed: an interface as the capture "
                         "names it");
    assert_value_refused("interface", "a b", "sensors.2.interface",
                         "'a b' has another character");
    assert_value_refused("interface", "a\x7f", "sensors.2.interface",
                         "'a\\x7f' has another character");
    assert_value_refused("interface", A63 "x", "sensors.2.interface",
                         "'abcdefghijklmnopqrstuvwxyz_1234_abcdefghijklmnopqrst"
                         "uvwx...' is too long");
}

static void files_have_names(void **state)
{
    char path[LUM_RIG_PATH_BYTES + 1u];
    lum_rig rig = make();
    lum_key_refusal why;
    (void)state;
    memset(path, 'p', sizeof path);
    path[LUM_RIG_PATH_BYTES] = '\0';
    assert_int_equal(lum_rig_set_sensor(&rig, 0, "profile", path, &why),
                     LUM_E_VALUE);
    assert_non_null(strstr(why.text, "' is too long; allowed: the name of a "
                                     "YAML file, beside the rig's or with its "
                                     "folder"));
    path[LUM_RIG_PATH_BYTES - 1u] = '\0';
    set(&rig, 0, "profile", path);
    set(&rig, 0, "profile", "p");
    set(&rig, 0, "profile", "-p\xc3\xa4 ");
    assert_value_refused("calibration", "-", "sensors.2.calibration",
                         "'-' is standard input, which is no file");
    assert_value_refused("calibration", "", "sensors.2.calibration",
                         "'' is empty");
    assert_value_refused("calibration", "a\nb", "sensors.2.calibration",
                         "'a\\x0ab' has a control character");
    assert_value_refused("calibration", "a\x7f", "sensors.2.calibration",
                         "'a\\x7f' has a control character");
}

static void sensors_follow_each_other(void **state)
{
    lum_rig rig = make();
    lum_key_refusal why;
    (void)state;
    assert_int_equal(lum_rig_set_sensor(&rig, 3, "name", "x", &why),
                     LUM_E_SPACE);
    assert_string_equal(why.key, "sensors.4");
    assert_string_equal(why.text, "there is none before it");
    assert_int_equal(lum_rig_set_sensor(&rig, 2, "name", "1", NULL),
                     LUM_E_VALUE);
    assert_int_equal(rig.count, 2);
    for (size_t i = 2; i < LUM_RIG_SENSORS_MAX; i++) {
        set(&rig, i, "name", "x");
    }
    assert_int_equal(rig.count, LUM_RIG_SENSORS_MAX);
    assert_int_equal(
        lum_rig_set_sensor(&rig, LUM_RIG_SENSORS_MAX, "name", "x", &why),
        LUM_E_SPACE);
    assert_string_equal(why.key, "sensors.9");
    assert_string_equal(why.text, "a rig has 1 to 8 sensors");
}

/* --- All together --- */

static void put(char *out, const char *text)
{
    memcpy(out, text, strlen(text) + 1u);
}

static void assert_unfit(const lum_rig *rig, const char *key, const char *text)
{
    lum_key_refusal why;
    assert_int_equal(lum_rig_check(rig, NULL), LUM_E_VALUE);
    assert_int_equal(lum_rig_check(rig, &why), LUM_E_VALUE);
    assert_string_equal(why.key, key);
    assert_int_equal(why.place, 2);
    assert_string_equal(why.text, text);
}

static void each_sensor_has_a_name_and_an_address(void **state)
{
    lum_rig rig = make();
    (void)state;
    rig.sensor[1].address = 0;
    assert_unfit(&rig, "sensors.2.address",
                 "missing; each sensor needs its address");
    rig.sensor[1].name[0] = '\0';
    assert_unfit(&rig, "sensors.2.name", "missing; each sensor needs a name");
}

static void names_are_not_the_same(void **state)
{
    static const char *const apart[] = {"fron", "frontx", "fro[t", "zront",
                                        "a_b"};
    static const char *const same[] = {"front", "FRONT", "fRONt"};
    lum_rig rig = make();
    (void)state;
    for (size_t i = 0; i < sizeof apart / sizeof apart[0]; i++) {
        put(rig.sensor[1].name, apart[i]);
        assert_int_equal(lum_rig_check(&rig, NULL), LUM_OK);
    }
    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) {
        put(rig.sensor[1].name, same[i]);
        assert_unfit(&rig, "sensors.2.name",
                     "another sensor has this name; upper and lower case count "
                     "as the same");
    }
    put(rig.sensor[1].name, "Base_Link");
    assert_unfit(&rig, "sensors.2.name",
                 "the vehicle's frame has this name; a sensor has a frame of "
                 "its own");
}

static void one_address_needs_two_interfaces(void **state)
{
    static const char shared[] =
        "10.42.0.37 is already that of 'front'; to tell them apart, give each "
        "an interface of its own";
    lum_rig rig = make();
    (void)state;
    set(&rig, 1, "address", "10.42.0.37");
    assert_int_equal(lum_rig_check(&rig, NULL), LUM_OK);
    set(&rig, 0, "interface", "eth1");
    assert_unfit(&rig, "sensors.2.address", shared);
    put(rig.sensor[0].interface, "eth2");
    assert_int_equal(lum_rig_check(&rig, NULL), LUM_OK);
    put(rig.sensor[0].interface, "eth10");
    assert_int_equal(lum_rig_check(&rig, NULL), LUM_OK);
    rig.sensor[0].interface[0] = '\0';
    rig.sensor[1].interface[0] = '\0';
    assert_unfit(&rig, "sensors.2.address", shared);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rig_begins_without_sensors),
        cmocka_unit_test(every_key_of_a_sensor_reaches_its_field),
        cmocka_unit_test(the_rig_itself_has_a_frame),
        cmocka_unit_test(keys_that_are_not_there_are_refused),
        cmocka_unit_test(a_name_is_of_letters_digits_and_underscores),
        cmocka_unit_test(addresses_are_those_of_hosts),
        cmocka_unit_test(an_interface_is_named_once),
        cmocka_unit_test(files_have_names),
        cmocka_unit_test(sensors_follow_each_other),
        cmocka_unit_test(each_sensor_has_a_name_and_an_address),
        cmocka_unit_test(names_are_not_the_same),
        cmocka_unit_test(one_address_needs_two_interfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
