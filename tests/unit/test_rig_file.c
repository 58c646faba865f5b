#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/config/config.h"
#include "lum/config/rig.h"

#include <stdio.h>
#include <string.h>

#define CALIB  LUM_SOURCE_DIR "/calib/"
#define SENSOR "version: 1\nsensors:\n  - {name: a, address: 10.0.0.1"

static lum_rig_files files;

static void parse(const char *text, const char *name)
{
    lum_error error = {""};
    if (lum_rig_parse(text, strlen(text), name, &files, &error) != 0) {
        fail_msg("%s", error.text);
    }
}

static void assert_refused(const char *text, const char *why)
{
    lum_error error = {""};
    assert_int_equal(
        lum_rig_parse(text, strlen(text), "rig.yaml", &files, &error), -1);
    assert_string_equal(error.text, why);
}

static void a_rig_is_read_with_its_files(void **state)
{
    lum_calibration calibration;
    (void)state;
    lum_calibration_default(&calibration);
    parse("version: 1\n"
          "frame: car\n"
          "sensors:\n"
          "  - {name: front, address: 10.42.0.37, calibration: typical.yaml,\n"
          "     pose: {x_m: 1.2, z_m: 1.8}}\n"
          "  - name: left\n"
          "    address: \"10.42.0.37\"\n"
          "    profile: '" CALIB "profile-default.yaml'\n"
          "    pose: {yaw_deg: -90}\n"
          "    interface: eth1\n"
          "  - {name: back, address: 10.42.0.38%eth1}\n",
          CALIB "rig.yaml");
    assert_int_equal(files.rig.count, 3);
    assert_string_equal(files.rig.frame, "car");
    assert_string_equal(files.rig.sensor[0].name, "front");
    assert_int_equal(files.rig.sensor[0].at_um[0], 1200000);
    assert_int_equal(files.rig.sensor[0].at_um[2], 1800000);
    assert_string_equal(files.sensor[0].calibration_path, CALIB "typical.yaml");
    assert_string_equal(files.sensor[0].profile_path, "");
    assert_memory_equal(&files.sensor[0].calibration, &calibration,
                        sizeof calibration);
    assert_int_equal(files.rig.sensor[1].yaw_udeg, -90000000);
    assert_string_equal(files.rig.sensor[1].interface, "eth1");
    assert_string_equal(files.sensor[1].profile_path,
                        CALIB "profile-default.yaml");
    assert_string_equal(files.rig.sensor[2].interface, "eth1");
    assert_int_equal(files.rig.sensor[2].address, 0x0a2a0026);
    assert_string_equal(files.sensor[2].calibration_path, "");
}

static void the_example_is_a_rig(void **state)
{
    lum_error error = {""};
    (void)state;
    if (lum_rig_load(CALIB "rig.yaml", &files, &error) != 0) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(files.rig.count, 3);
}

/* Another line of a sensor, or what stands in its place. */
static void what_is_wrong_bears_its_line(void **state)
{
    (void)state;
    assert_refused("sensors:\n  - {name: a, address: 10.0.0.1}\n",
                   "rig.yaml:1: version: missing; a rig needs 'version: 1'");
    assert_refused("version: 1\n", "rig.yaml: sensors: missing; a rig has 1 to "
                                   "8 sensors");
    assert_refused("version: 1\nsensors: []\n",
                   "rig.yaml: sensors: missing; a rig has 1 to 8 sensors");
    assert_refused("version: 1\nsensors: 5\n",
                   "rig.yaml:2: sensors: '5' is no list; allowed: a list of 1 "
                   "to 8 sensors, each begun by '-'");
    assert_refused("version: 1\nsensors:\n  - {}\n",
                   "rig.yaml:3: sensors.1: has no keys; each sensor needs a "
                   "name and its address");
    assert_refused(SENSOR ", pose: {x_m: \"1\"}}\n",
                   "rig.yaml:3: sensors.1.pose.x_m: '1' is text; write a "
                   "number, without quotes; allowed: -1000 to 1000 m");
    assert_refused(SENSOR ", adress: 1}\n",
                   "rig.yaml:3: sensors.1: unknown key 'adress'; did you mean "
                   "'address'? allowed here: name, address, interface, "
                   "calibration, profile, pose");
    assert_refused(SENSOR "}\n  -\n    name: b\n    address: 10.0.0.1\n",
                   "rig.yaml:6: sensors.2.address: 10.0.0.1 is already that of "
                   "'a'; to tell them apart, give each an interface of its "
                   "own");
    assert_refused(SENSOR "}\n  - {name: b}\n",
                   "rig.yaml:4: sensors.2.address: missing; each sensor needs "
                   "its address");
    assert_refused(
        SENSOR ",\n     interface: eth0,\n     interface: eth1}\n",
        "rig.yaml:5: sensors.1.interface: repeated; it is already on "
        "line 4");
    assert_refused(SENSOR "%eth0, interface: eth1}\n",
                   "rig.yaml:3: sensors.1.interface: the interface is 'eth1' "
                   "here and 'eth0' before; name it once");
}

static void there_are_at_most_eight(void **state)
{
    char text[1024] = "version: 1\nsensors:\n";
    (void)state;
    for (unsigned i = 0; i < 9; i++) {
        const size_t used = strlen(text);
        (void)snprintf(text + used, sizeof text - used,
                       "  - {name: s%u, address: 10.0.0.%u}\n", i, i + 1u);
        if (i == 7) {
            parse(text, "rig.yaml");
            assert_int_equal(files.rig.count, 8);
        }
    }
    assert_refused(text,
                   "rig.yaml:11: sensors.9: more than the 8 that are accepted");
}

static void files_that_cannot_be_read_are_named_with_their_place(void **state)
{
    char text[1200];
    char path[1025];
    (void)state;
    assert_refused(SENSOR ",\n     calibration: none.yaml}\n",
                   "rig.yaml:4: sensors.1.calibration: none.yaml: cannot be "
                   "read: No such file or directory");
    assert_refused(SENSOR ", profile: none.yaml}\n",
                   "rig.yaml:3: sensors.1.profile: none.yaml: cannot be read: "
                   "No such file or directory");
    memset(path, 'p', sizeof path);
    path[1020] = '\0';
    (void)snprintf(text, sizeof text, SENSOR ", profile: %s}\n", path);
    lum_error error = {""};
    assert_int_equal(
        lum_rig_parse(text, strlen(text), "folder/rig.yaml", &files, &error),
        -1);
    assert_string_equal(error.text,
                        "folder/rig.yaml:3: sensors.1.profile: with the folder "
                        "of the rig it is longer than 1023 bytes");
    path[1020] = 'p';
    path[1024] = '\0';
    (void)snprintf(text, sizeof text, SENSOR ", profile: %s}\n", path);
    assert_int_equal(
        lum_rig_parse(text, strlen(text), "rig.yaml", &files, &error), -1);
    assert_non_null(strstr(error.text, "is too long; allowed: the name"));
}

static void a_rig_that_is_not_there_is_told(void **state)
{
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_rig_load("none.yaml", &files, &error), -1);
    assert_string_equal(error.text, "none.yaml: cannot be read: No such file "
                                    "or directory");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rig_is_read_with_its_files),
        cmocka_unit_test(the_example_is_a_rig),
        cmocka_unit_test(what_is_wrong_bears_its_line),
        cmocka_unit_test(there_are_at_most_eight),
        cmocka_unit_test(files_that_cannot_be_read_are_named_with_their_place),
        cmocka_unit_test(a_rig_that_is_not_there_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
