#include "rig_keys.h"

#include "keys_internal.h"
#include "lum/host/rig.h"
#include "rig_text.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The texts' units are degrees and metres; ours are microdegrees and
 * micrometres. */
#define MICRO(n) ((n)*INT64_C(1000000))

static const lum_key_rule frame = {
    .check = lum_rig_check_frame,
    .allowed = "1 to 63 letters, digits, '_', '-', '.' and '/', a letter "
               "first"};
static const lum_key_rule sensors = {
    .check = lum_rig_check_list,
    .allowed = "a list of 1 to 8 sensors, each begun by '-'"};
static const lum_key_rule name = {
    .check = lum_rig_check_name,
    .allowed = "1 to 31 letters, digits and '_', a letter first"};
static const lum_key_rule address = {
    .check = lum_rig_check_address,
    .allowed = "an IPv4 address such as 10.42.0.37, or with its interface "
               "10.42.0.37%eth1"};
static const lum_key_rule interface = {
    .check = lum_rig_check_interface,
    .allowed = "an interface as the capture names it, such as eth1; 1 to 63 "
               "visible ASCII characters"};
static const lum_key_rule path = {
    .check = lum_rig_check_path,
    .allowed = "the name of a YAML file, beside the rig's or with its folder"};
static const lum_key_rule position = {
    .min = -MICRO(1000), .max = MICRO(1000), .decimals = 6, .unit = "m"};
static const lum_key_rule turn = {
    .min = -MICRO(360), .max = MICRO(360), .decimals = 6, .unit = "deg"};

static const lum_key_entry of_rig[] = {
    {"version", LUM_RIG_VERSION, &lum_key_version},
    {"frame", LUM_RIG_FRAME, &frame},
    {"sensors", LUM_RIG_SENSORS, &sensors},
};
static const lum_key_entry of_sensor[] = {
    {"name", LUM_RIG_NAME, &name},
    {"address", LUM_RIG_ADDRESS, &address},
    {"interface", LUM_RIG_INTERFACE, &interface},
    {"calibration", LUM_RIG_CALIBRATION, &path},
    {"profile", LUM_RIG_PROFILE, &path},
    {"pose.x_m", LUM_RIG_X, &position},
    {"pose.y_m", LUM_RIG_Y, &position},
    {"pose.z_m", LUM_RIG_Z, &position},
    {"pose.roll_deg", LUM_RIG_ROLL, &turn},
    {"pose.pitch_deg", LUM_RIG_PITCH, &turn},
    {"pose.yaw_deg", LUM_RIG_YAW, &turn},
};

/* Else this does not compile. */
typedef char
    every_value_has_its_key[COUNT(of_rig) == LUM_RIG_FILE_VALUES &&
                                    COUNT(of_sensor) == LUM_RIG_SENSOR_VALUES
                                ? 1
                                : -1];

const lum_key_table lum_rig_keys = {of_rig, COUNT(of_rig)};
const lum_key_table lum_rig_sensor_keys = {of_sensor, COUNT(of_sensor)};
