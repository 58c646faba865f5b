#include "rig_keys.h"

#include "keys_internal.h"
#include "lum/host/rig.h"

#include <stdbool.h>

/* --- Texts: why they are refused, as lum_key_rule_read() says it; NULL: they
 * are not. They need not be terminated. --- */

/* The first addresses beyond those of hosts: multicast. */
#define ADDRESS_END UINT32_C(0xe0000000)

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_one_of(char c, const char *others)
{
    while (*others != '\0' && *others != c) {
        others++;
    }
    return *others != '\0';
}

/* Letters, digits and some others, a letter first. */
static const char *check_word(const char *text, size_t len, size_t size,
                              const char *others)
{
    if (len == 0 || !is_letter(text[0])) {
        return "does not begin with a letter";
    }
    for (size_t i = 0; i < len; i++) {
        if (!is_letter(text[i]) && !is_digit(text[i]) &&
            !is_one_of(text[i], others)) {
            return "has another character";
        }
    }
    return len < size ? NULL : "is too long";
}

static const char *check_frame(const char *text, size_t len)
{
    return check_word(text, len, LUM_RIG_FRAME_BYTES, "_-./");
}

static const char *check_name(const char *text, size_t len)
{
    return check_word(text, len, LUM_RIG_NAME_BYTES, "_");
}

static const char *check_length(size_t len, size_t size)
{
    if (len == 0) {
        return "is empty";
    }
    return len < size ? NULL : "is too long";
}

/* Those of a capture are of these alone. */
static const char *check_interface(const char *text, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        if (text[i] <= ' ' || text[i] > '~') {
            return "has another character";
        }
    }
    return check_length(len, LUM_RIG_INTERFACE_BYTES);
}

static const char *check_path(const char *text, size_t len)
{
    if (len == 1 && text[0] == '-') {
        return "is standard input, which is no file";
    }
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)text[i];
        if (c < 0x20 || c == 0x7f) {
            return "has a control character";
        }
    }
    return check_length(len, LUM_RIG_PATH_BYTES);
}

static const char *check_list(const char *text, size_t len)
{
    (void)text;
    (void)len;
    return "is no list";
}

/* Takes a number of 0 to 255, without zeros before it. */
static bool take_byte(const char **p, const char *end, uint32_t *address)
{
    const char *const from = *p;
    uint32_t value = 0;
    while (*p < end && is_digit(**p) && value < 256u) {
        value = value * 10u + (uint32_t)(**p - '0');
        (*p)++;
    }
    *address = *address << 8 | value;
    return *p > from && value < 256u && (*p == from + 1 || *from != '0');
}

static bool take_dot(const char **p, const char *end)
{
    if (*p < end && **p == '.') {
        (*p)++;
        return true;
    }
    return false;
}

/* Returns where the address ends; NULL: it is none. */
static const char *take_address(const char *text, size_t len, uint32_t *out)
{
    const char *p = text;
    const char *const end = text + len;
    *out = 0;
    bool is_fine = take_byte(&p, end, out);
    for (unsigned i = 1; i < 4u && is_fine; i++) {
        is_fine = take_dot(&p, end) && take_byte(&p, end, out);
    }
    return is_fine ? p : NULL;
}

static const char *check_address(const char *text, size_t len)
{
    uint32_t address = 0;
    const char *const end = text + len;
    const char *const at = take_address(text, len, &address);
    if (at == NULL || (at < end && *at != '%')) {
        return "is not an IPv4 address";
    }
    if (address == 0 || address >= ADDRESS_END) {
        return "is no sensor's address";
    }
    if (at < end && check_interface(at + 1, (size_t)(end - at - 1)) != NULL) {
        return "has no interface behind its '%'";
    }
    return NULL;
}

const char *lum_rig_take_address(const char *text, size_t len, uint32_t *out)
{
    const char *const at = take_address(text, len, out);
    return at < text + len ? at + 1 : at;
}

/* --- Keys --- */

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The texts' units are degrees and metres; ours are microdegrees and
 * micrometres. */
#define MICRO(n) ((n)*INT64_C(1000000))

static const lum_key_rule frame = {
    .check = check_frame,
    .allowed = "1 to 63 letters, digits, '_', '-', '.' and '/', a letter "
               "first"};
static const lum_key_rule sensors = {
    .check = check_list,
    .allowed = "a list of 1 to 8 sensors, each begun by '-'"};
static const lum_key_rule name = {
    .check = check_name,
    .allowed = "1 to 31 letters, digits and '_', a letter first"};
static const lum_key_rule address = {
    .check = check_address,
    .allowed = "an IPv4 address such as 10.42.0.37, or with its interface "
               "10.42.0.37%eth1"};
static const lum_key_rule interface = {
    .check = check_interface,
    .allowed = "an interface as the capture names it, such as eth1; 1 to 63 "
               "visible ASCII characters"};
static const lum_key_rule path = {
    .check = check_path,
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
    file_values_have_keys[COUNT(of_rig) == LUM_RIG_FILE_VALUES ? 1 : -1];
typedef char
    sensor_values_have_keys[COUNT(of_sensor) == LUM_RIG_SENSOR_VALUES ? 1 : -1];

const lum_key_table lum_rig_keys = {of_rig, COUNT(of_rig)};
const lum_key_table lum_rig_sensor_keys = {of_sensor, COUNT(of_sensor)};
