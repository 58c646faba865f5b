#include "lum/host/rig.h"

#include "keys_internal.h"
#include "rig_keys.h"

#include <stdbool.h>
#include <string.h>

/* Copies a text that fits. */
static void put_text(char *out, const char *text, size_t len)
{
    memcpy(out, text, len);
    out[len] = '\0';
}

void lum_rig_init(lum_rig *out)
{
    static const char usual[] = "base_link";
    memset(out, 0, sizeof *out);
    put_text(out->frame, usual, sizeof usual - 1u);
}

/* "sensors.2", and behind it a key of that sensor. */
static lum_key_text refuse_sensor(lum_key_refusal *why, size_t i,
                                  const char *key)
{
    char path[LUM_KEY_BYTES];
    lum_key_text text = lum_key_text_begin(path, sizeof path);
    lum_key_text_add(&text, "sensors.");
    lum_key_text_add_number(&text, (int64_t)i + 1, 0);
    lum_key_text_add(&text, key[0] != '\0' ? "." : "");
    lum_key_text_add(&text, key);
    return lum_key_refuse(why, path, (uint32_t)i + 1u);
}

/* Reads a value; NULL: it is refused. */
static const lum_key_entry *read_value(const lum_key_table *table,
                                       const char *key, const char *value,
                                       int64_t *number, lum_key_refusal *why,
                                       lum_result *result)
{
    const lum_key_entry *entry = lum_key_table_entry(table, key);
    const lum_key_given given = {value, lum_key_text_length(value), false};
    if (entry == NULL) {
        *result = lum_key_refuse_key(table, key, 0, why);
        return NULL;
    }
    lum_key_text text = lum_key_refuse(why, key, 0);
    *result = LUM_E_VALUE;
    return lum_key_table_read(table, entry, given, number, &text) ? entry
                                                                  : NULL;
}

lum_result lum_rig_set(lum_rig *rig, const char *key, const char *value,
                       lum_key_refusal *why)
{
    lum_key_refusal refused;
    lum_result result = LUM_OK;
    int64_t number = 0;
    const lum_key_entry *entry =
        read_value(&lum_rig_keys, key, value, &number, &refused, &result);
    if (entry != NULL) {
        if (entry->index == LUM_RIG_FRAME) {
            put_text(rig->frame, value, lum_key_text_length(value));
        }
        return LUM_OK;
    }
    if (why != NULL) {
        *why = refused;
    }
    return result;
}

static bool is_same(const char *text, size_t len, const char *other)
{
    return lum_key_text_length(other) == len && memcmp(text, other, len) == 0;
}

/* An address may name the interface too, and then it is the same. */
static bool set_interface(lum_rig_sensor *sensor, const char *name, size_t len,
                          lum_key_text *text)
{
    const bool is_new = sensor->interface[0] == '\0';
    if (is_new) {
        put_text(sensor->interface, name, len);
        return true;
    }
    if (is_same(name, len, sensor->interface)) {
        return true;
    }
    lum_key_text_add(text, "the interface is '");
    lum_key_text_add_quoted(text, name, len);
    lum_key_text_add(text, "' here and '");
    lum_key_text_add(text, sensor->interface);
    lum_key_text_add(text, "' before; name it once");
    return false;
}

static bool set_address(lum_rig_sensor *sensor, const char *value, size_t len,
                        lum_key_text *text)
{
    uint32_t address = 0;
    const char *name = lum_rig_take_address(value, len, &address);
    const size_t left = (size_t)(value + len - name);
    if (left > 0 && !set_interface(sensor, name, left, text)) {
        return false;
    }
    sensor->address = address;
    return true;
}

static void set_number(lum_rig_sensor *sensor, unsigned index, int32_t number)
{
    switch (index) {
    case LUM_RIG_ROLL:
        sensor->roll_udeg = number;
        break;
    case LUM_RIG_PITCH:
        sensor->pitch_udeg = number;
        break;
    case LUM_RIG_YAW:
        sensor->yaw_udeg = number;
        break;
    default:
        sensor->at_um[index - LUM_RIG_X] = number;
        break;
    }
}

/* Keeps a value that its rule allows. */
static bool set_value(lum_rig_sensor *sensor, unsigned index, const char *value,
                      int64_t number, lum_key_text *text)
{
    const size_t len = lum_key_text_length(value);
    switch (index) {
    case LUM_RIG_NAME:
        put_text(sensor->name, value, len);
        return true;
    case LUM_RIG_ADDRESS:
        return set_address(sensor, value, len, text);
    case LUM_RIG_INTERFACE:
        return set_interface(sensor, value, len, text);
    case LUM_RIG_CALIBRATION:
    case LUM_RIG_PROFILE:
        return true;
    default:
        set_number(sensor, index, (int32_t)number);
        return true;
    }
}

static lum_result refuse_count(size_t i, lum_key_refusal *why)
{
    lum_key_text text = refuse_sensor(why, i, "");
    if (i < LUM_RIG_SENSORS_MAX) {
        lum_key_text_add(&text, "there is none before it");
    } else {
        lum_key_text_add(&text, "a rig has 1 to ");
        lum_key_text_add_number(&text, LUM_RIG_SENSORS_MAX, 0);
        lum_key_text_add(&text, " sensors");
    }
    return LUM_E_SPACE;
}

lum_result lum_rig_set_sensor(lum_rig *rig, size_t i, const char *key,
                              const char *value, lum_key_refusal *why)
{
    lum_key_refusal refused;
    lum_result result = LUM_OK;
    int64_t number = 0;
    if (i >= LUM_RIG_SENSORS_MAX || i > rig->count) {
        return refuse_count(i, why);
    }
    const lum_key_entry *entry = read_value(&lum_rig_sensor_keys, key, value,
                                            &number, &refused, &result);
    if (entry != NULL) {
        lum_key_text new_text =
            lum_key_text_begin(refused.text, sizeof refused.text);
        if (set_value(&rig->sensor[i], entry->index, value, number,
                      &new_text)) {
            rig->count += i == rig->count;
            return LUM_OK;
        }
    }
    lum_key_text text = refuse_sensor(why, i, refused.key);
    lum_key_text_add(&text, refused.text);
    return result;
}

/* --- All values together --- */

static lum_result refuse_missing(lum_key_refusal *why, size_t i,
                                 const char *key, const char *what)
{
    lum_key_text text = refuse_sensor(why, i, key);
    lum_key_text_add(&text, what);
    return LUM_E_VALUE;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

/* Names are used for files, where case does not count everywhere. */
static bool is_same_name(const char *a, const char *b)
{
    while (*a != '\0' && lower(*a) == lower(*b)) {
        a++;
        b++;
    }
    return lower(*a) == lower(*b);
}

static void add_address(lum_key_text *text, uint32_t address)
{
    for (unsigned i = 0; i < 4u; i++) {
        lum_key_text_add(text, i > 0 ? "." : "");
        lum_key_text_add_number(text, address >> (24u - 8u * i) & 0xffu, 0);
    }
}

static lum_result refuse_address(const lum_rig *rig, size_t i, size_t before,
                                 lum_key_refusal *why)
{
    lum_key_text text = refuse_sensor(why, i, "address");
    add_address(&text, rig->sensor[i].address);
    lum_key_text_add(&text, " is already that of '");
    lum_key_text_add(&text, rig->sensor[before].name);
    lum_key_text_add(&text, "'; to tell them apart, give each an interface of "
                            "its own");
    return LUM_E_VALUE;
}

static lum_result check_pair(const lum_rig *rig, size_t i, size_t before,
                             lum_key_refusal *why)
{
    const lum_rig_sensor *a = &rig->sensor[before];
    const lum_rig_sensor *b = &rig->sensor[i];
    if (is_same_name(a->name, b->name)) {
        return refuse_missing(why, i, "name",
                              "another sensor has this name; upper and lower "
                              "case count as the same");
    }
    const bool is_apart =
        a->address != b->address ||
        !is_same(a->interface, lum_key_text_length(a->interface), b->interface);
    return is_apart ? LUM_OK : refuse_address(rig, i, before, why);
}

static lum_result check_sensor(const lum_rig *rig, size_t i,
                               lum_key_refusal *why)
{
    const lum_rig_sensor *sensor = &rig->sensor[i];
    if (sensor->name[0] == '\0') {
        return refuse_missing(why, i, "name",
                              "missing; each sensor needs a name");
    }
    if (sensor->address == 0) {
        return refuse_missing(why, i, "address",
                              "missing; each sensor needs its address");
    }
    if (is_same_name(sensor->name, rig->frame)) {
        return refuse_missing(why, i, "name",
                              "the vehicle's frame has this name; a sensor has "
                              "a frame of its own");
    }
    for (size_t before = 0; before < i; before++) {
        const lum_result result = check_pair(rig, i, before, why);
        if (result != LUM_OK) {
            return result;
        }
    }
    return LUM_OK;
}

lum_result lum_rig_check(const lum_rig *rig, lum_key_refusal *why)
{
    if (rig->count == 0) {
        lum_key_text text = lum_key_refuse(why, "sensors", 0);
        lum_key_text_add(&text, "missing; a rig has 1 to ");
        lum_key_text_add_number(&text, LUM_RIG_SENSORS_MAX, 0);
        lum_key_text_add(&text, " sensors");
        return LUM_E_VALUE;
    }
    for (size_t i = 0; i < rig->count; i++) {
        const lum_result result = check_sensor(rig, i, why);
        if (result != LUM_OK) {
            return result;
        }
    }
    return LUM_OK;
}
