/* The keys of a calibration, and the messages for values that clash. */
#include "keys_internal.h"

#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The values in order; those of an eye count from the eye's first. */
enum {
    VERSION = LUM_KEYS_VERSION,
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

/* The texts' units are degrees, metres and picoseconds; ours are microdegrees,
 * micrometres and femtoseconds. */
#define MICRO(n) ((n)*INT64_C(1000000))
#define MILLI(n) ((n)*INT64_C(1000))

static const lum_key_rule speed = {
    .min = 200000000, .max = 310000000, .unit = "m/s"};
static const lum_key_rule lsb = {
    .min = 1, .max = MILLI(1000), .decimals = 3, .unit = "ps"};
static const lum_key_rule offset = {.min = -MILLI(10000000),
                                    .max = MILLI(10000000),
                                    .decimals = 3,
                                    .unit = "ps"};
static const lum_key_rule half_turn = {
    .min = -MICRO(180), .max = MICRO(180), .decimals = 6, .unit = "deg"};
static const lum_key_rule width = {
    .min = 1, .max = MICRO(360), .decimals = 6, .unit = "deg"};
static const lum_key_rule quarter_turn = {
    .min = -MICRO(90), .max = MICRO(90), .decimals = 6, .unit = "deg"};
static const lum_key_rule turn = {
    .min = -MICRO(360), .max = MICRO(360), .decimals = 6, .unit = "deg"};
static const lum_key_rule position = {
    .min = -MICRO(1000), .max = MICRO(1000), .decimals = 6, .unit = "m"};

#define EYE(name, first)                                                       \
    {"eyes." name ".tof_offset_ps", (first) + TOF_OFFSET, &offset},            \
        {"eyes." name ".azimuth.center_deg", (first) + AZIMUTH_CENTER,         \
         &half_turn},                                                          \
        {"eyes." name ".azimuth.width_deg", (first) + AZIMUTH_WIDTH, &width},  \
        {"eyes." name ".elevation.min_deg", (first) + ELEVATION_MIN,           \
         &quarter_turn},                                                       \
        {"eyes." name ".elevation.max_deg", (first) + ELEVATION_MAX,           \
         &quarter_turn},                                                       \
        {"eyes." name ".mount.x_m", (first) + MOUNT_X, &position},             \
        {"eyes." name ".mount.y_m", (first) + MOUNT_Y, &position},             \
        {"eyes." name ".mount.z_m", (first) + MOUNT_Z, &position},             \
        {"eyes." name ".mount.roll_deg", (first) + MOUNT_ROLL, &turn},         \
        {"eyes." name ".mount.pitch_deg", (first) + MOUNT_PITCH, &turn},       \
    {                                                                          \
        "eyes." name ".mount.yaw_deg", (first) + MOUNT_YAW, &turn              \
    }

static const lum_key_entry entries[] = {
    {"version", VERSION, &lum_key_version},
    {"speed_of_light", SPEED_OF_LIGHT, &speed},
    {"tof_lsb_ps", TOF_LSB, &lsb},
    EYE("blue", BLUE),
    EYE("green", GREEN),
};
const lum_key_table lum_calibration_keys = {entries, COUNT(entries)};

/* Else this does not compile. */
typedef char every_value_has_its_key[COUNT(entries) == VALUES ? 1 : -1];

/* The first value of each eye, by lum_eye. */
static const unsigned eyes[LUM_EYES] = {BLUE, GREEN};

static void put_eye(lum_key_value *v, const lum_eye_calibration *e)
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

static void take_eye(const lum_key_value *v, lum_eye_calibration *e)
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

void lum_keys_of_calibration(lum_keys *out, const lum_calibration *start)
{
    lum_calibration usual;
    const lum_calibration *c = start != NULL ? start : &usual;
    lum_calibration_default(&usual);
    memset(out, 0, sizeof *out);
    out->kind = LUM_KEYS_CALIBRATION;
    out->is_default = start == NULL;
    out->values[VERSION].number = 1;
    out->values[SPEED_OF_LIGHT].number = c->speed_of_light;
    out->values[TOF_LSB].number = c->tof_lsb_fs;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        put_eye(out->values + eyes[eye], &c->eye[eye]);
    }
}

static void take(const lum_key_value *v, lum_calibration *c)
{
    memset(c, 0, sizeof *c);
    c->speed_of_light = (uint32_t)v[SPEED_OF_LIGHT].number;
    c->tof_lsb_fs = (uint32_t)v[TOF_LSB].number;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        take_eye(v + eyes[eye], &c->eye[eye]);
    }
}

/* The rules check the range of every value; their order is checked here. */
static void refuse_elevation(const lum_keys *keys, unsigned eye,
                             lum_key_refusal *why)
{
    static const char *const paths[LUM_EYES][2] = {
        {"eyes.blue.elevation.min_deg", "eyes.blue.elevation.max_deg"},
        {"eyes.green.elevation.min_deg", "eyes.green.elevation.max_deg"},
    };
    const lum_key_value *low = &keys->values[eyes[eye] + ELEVATION_MIN];
    const lum_key_value *high = &keys->values[eyes[eye] + ELEVATION_MAX];
    const bool is_low = low->place != 0;
    lum_key_text text = lum_key_refuse(why, paths[eye][is_low ? 0 : 1],
                                       is_low ? low->place : high->place);
    lum_key_text_add(&text, "min_deg must be below max_deg; they are ");
    lum_key_text_add_number(&text, low->number, quarter_turn.decimals);
    lum_key_text_add(&text, lum_keys_origin(keys, low->place));
    lum_key_text_add(&text, " and ");
    lum_key_text_add_number(&text, high->number, quarter_turn.decimals);
    lum_key_text_add(&text, lum_keys_origin(keys, high->place));
}

lum_result lum_keys_calibration(const lum_keys *keys, lum_calibration *out,
                                lum_key_refusal *why)
{
    lum_calibration c;
    lum_calibration_fault fault = LUM_CALIBRATION_FINE;
    unsigned eye = 0;
    if (keys->kind != LUM_KEYS_CALIBRATION) {
        lum_key_text text = lum_key_refuse(why, "", 0);
        lum_key_text_add(&text, "these are keys of a profile");
        return LUM_E_TYPE;
    }
    take(keys->values, &c);
    if (lum_calibration_check(&c, &fault, &eye) == LUM_OK) {
        *out = c;
        return LUM_OK;
    }
    if (fault == LUM_CALIBRATION_ELEVATION_ORDER) {
        refuse_elevation(keys, eye, why);
        return LUM_E_VALUE;
    }
    lum_key_text text = lum_key_refuse(why, "", 0);
    lum_key_text_add(&text, "refused: value ");
    lum_key_text_add_number(&text, fault, 0);
    lum_key_text_add(&text, " is out of range");
    return LUM_E_VALUE;
}
