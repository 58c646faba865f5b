#include "lum/config/config.h"
#include "yaml.h"
#include "yaml_number.h"

#include <stdio.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The values of a file in order; those of an eye count from the eye's first. */
enum {
    VERSION,
    SPEED_OF_LIGHT,
    TOF_LSB,
    BLUE
};
enum {
    TOF_OFFSET,
    AZIMUTH_CENTER,
    AZIMUTH_WIDTH,
    ELEVATION_MIN,
    ELEVATION_MAX,
    MOUNT_X,
    MOUNT_Y,
    MOUNT_Z,
    MOUNT_ROLL,
    MOUNT_PITCH,
    MOUNT_YAW,
    EYE_VALUES
};
enum {
    GREEN = BLUE + EYE_VALUES,
    VALUES = GREEN + EYE_VALUES
};

/* The file's units are degrees, metres and picoseconds; ours are microdegrees,
 * micrometres and femtoseconds. */
#define MICRO(n) ((n)*INT64_C(1000000))
#define MILLI(n) ((n)*INT64_C(1000))

static const lum_yaml_rule version = {
    .min = 1, .max = 1, .whole = true, .allowed = "1"};
static const lum_yaml_rule speed = {
    .min = 200000000, .max = 310000000, .unit = " m/s"};
static const lum_yaml_rule lsb = {
    .min = 1, .max = MILLI(1000), .decimals = 3, .unit = " ps"};
static const lum_yaml_rule offset = {.min = -MILLI(10000000),
                                     .max = MILLI(10000000),
                                     .decimals = 3,
                                     .unit = " ps"};
static const lum_yaml_rule half_turn = {
    .min = -MICRO(180), .max = MICRO(180), .decimals = 6, .unit = " deg"};
static const lum_yaml_rule width = {
    .min = 1, .max = MICRO(360), .decimals = 6, .unit = " deg"};
static const lum_yaml_rule quarter_turn = {
    .min = -MICRO(90), .max = MICRO(90), .decimals = 6, .unit = " deg"};
static const lum_yaml_rule turn = {
    .min = -MICRO(360), .max = MICRO(360), .decimals = 6, .unit = " deg"};
static const lum_yaml_rule place = {
    .min = -MICRO(1000), .max = MICRO(1000), .decimals = 6, .unit = " m"};

static const lum_yaml_key azimuth_keys[] = {
    {"center_deg", AZIMUTH_CENTER, &half_turn, NULL},
    {"width_deg", AZIMUTH_WIDTH, &width, NULL},
};
static const lum_yaml_table azimuth = {azimuth_keys, COUNT(azimuth_keys)};

static const lum_yaml_key elevation_keys[] = {
    {"min_deg", ELEVATION_MIN, &quarter_turn, NULL},
    {"max_deg", ELEVATION_MAX, &quarter_turn, NULL},
};
static const lum_yaml_table elevation = {elevation_keys, COUNT(elevation_keys)};

static const lum_yaml_key mount_keys[] = {
    {"x_m", MOUNT_X, &place, NULL},
    {"y_m", MOUNT_Y, &place, NULL},
    {"z_m", MOUNT_Z, &place, NULL},
    {"roll_deg", MOUNT_ROLL, &turn, NULL},
    {"pitch_deg", MOUNT_PITCH, &turn, NULL},
    {"yaw_deg", MOUNT_YAW, &turn, NULL},
};
static const lum_yaml_table mount = {mount_keys, COUNT(mount_keys)};

static const lum_yaml_key eye_keys[] = {
    {"tof_offset_ps", TOF_OFFSET, &offset, NULL},
    {"azimuth", 0, NULL, &azimuth},
    {"elevation", 0, NULL, &elevation},
    {"mount", 0, NULL, &mount},
};
static const lum_yaml_table eye_table = {eye_keys, COUNT(eye_keys)};

static const lum_yaml_key eyes_keys[] = {
    {"blue", BLUE, NULL, &eye_table},
    {"green", GREEN, NULL, &eye_table},
};
static const lum_yaml_table eyes = {eyes_keys, COUNT(eyes_keys)};

static const lum_yaml_key root_keys[] = {
    {"version", VERSION, &version, NULL},
    {"speed_of_light", SPEED_OF_LIGHT, &speed, NULL},
    {"tof_lsb_ps", TOF_LSB, &lsb, NULL},
    {"eyes", 0, NULL, &eyes},
};
static const lum_yaml_table root = {root_keys, COUNT(root_keys)};

static void put_eye(lum_yaml_value *v, const lum_eye_calibration *e)
{
    v[TOF_OFFSET].number = e->tof_offset_fs;
    v[AZIMUTH_CENTER].number = e->azimuth_center_udeg;
    v[AZIMUTH_WIDTH].number = e->azimuth_width_udeg;
    v[ELEVATION_MIN].number = e->elevation_min_udeg;
    v[ELEVATION_MAX].number = e->elevation_max_udeg;
    v[MOUNT_X].number = e->mount_um[0];
    v[MOUNT_Y].number = e->mount_um[1];
    v[MOUNT_Z].number = e->mount_um[2];
    v[MOUNT_ROLL].number = e->mount_roll_udeg;
    v[MOUNT_PITCH].number = e->mount_pitch_udeg;
    v[MOUNT_YAW].number = e->mount_yaw_udeg;
}

static void take_eye(const lum_yaml_value *v, lum_eye_calibration *e)
{
    e->tof_offset_fs = v[TOF_OFFSET].number;
    e->azimuth_center_udeg = (int32_t)v[AZIMUTH_CENTER].number;
    e->azimuth_width_udeg = (int32_t)v[AZIMUTH_WIDTH].number;
    e->elevation_min_udeg = (int32_t)v[ELEVATION_MIN].number;
    e->elevation_max_udeg = (int32_t)v[ELEVATION_MAX].number;
    e->mount_um[0] = (int32_t)v[MOUNT_X].number;
    e->mount_um[1] = (int32_t)v[MOUNT_Y].number;
    e->mount_um[2] = (int32_t)v[MOUNT_Z].number;
    e->mount_roll_udeg = (int32_t)v[MOUNT_ROLL].number;
    e->mount_pitch_udeg = (int32_t)v[MOUNT_PITCH].number;
    e->mount_yaw_udeg = (int32_t)v[MOUNT_YAW].number;
}

static void put(lum_yaml_value *v, const lum_calibration *c)
{
    v[SPEED_OF_LIGHT].number = c->speed_of_light;
    v[TOF_LSB].number = c->tof_lsb_fs;
    put_eye(v + BLUE, &c->eye[LUM_EYE_BLUE]);
    put_eye(v + GREEN, &c->eye[LUM_EYE_GREEN]);
}

static void take(const lum_yaml_value *v, lum_calibration *c)
{
    c->speed_of_light = (uint32_t)v[SPEED_OF_LIGHT].number;
    c->tof_lsb_fs = (uint32_t)v[TOF_LSB].number;
    take_eye(v + BLUE, &c->eye[LUM_EYE_BLUE]);
    take_eye(v + GREEN, &c->eye[LUM_EYE_GREEN]);
}

/* The rules hold every value to its range; what is left is their order. */
static int refuse_elevation(const lum_yaml_value *v, const char *eye,
                            const char *name, lum_error *error)
{
    const lum_yaml_value *low = &v[ELEVATION_MIN];
    const lum_yaml_value *high = &v[ELEVATION_MAX];
    char min[LUM_YAML_NUMBER_BYTES];
    char max[LUM_YAML_NUMBER_BYTES];
    char key[64];
    lum_yaml_number_format(min, low->number, 6);
    lum_yaml_number_format(max, high->number, 6);
    (void)snprintf(key, sizeof key, "eyes.%s.elevation.%s", eye,
                   low->line != 0 ? "min_deg" : "max_deg");
    return lum_yaml_fail(error, name, low->line != 0 ? low->line : high->line,
                         key,
                         "min_deg must be below max_deg; they are %s%s and "
                         "%s%s",
                         min, low->line != 0 ? "" : " (the default)", max,
                         high->line != 0 ? "" : " (the default)");
}

int lum_calibration_parse(const char *text, size_t len, const char *name,
                          lum_calibration *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_yaml_value values[VALUES] = {{0, 0}};
    lum_calibration c;
    lum_calibration_fault fault = LUM_CALIBRATION_FINE;
    unsigned eye = 0;
    lum_calibration_default(&c);
    put(values, &c);
    if (lum_yaml_read(&source, &root, values, error) != 0) {
        return -1;
    }
    take(values, &c);
    if (lum_calibration_check(&c, &fault, &eye) == LUM_OK) {
        *out = c;
        return 0;
    }
    if (fault == LUM_CALIBRATION_ELEVATION_ORDER) {
        return refuse_elevation(values + eyes_keys[eye].index,
                                eyes_keys[eye].name, name, error);
    }
    return lum_yaml_fail(error, name, 0, NULL,
                         "refused: value %d is out of range", (int)fault);
}
