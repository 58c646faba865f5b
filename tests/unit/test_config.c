#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host/key_rule.h"
#include "lum/config/config.h"
#include "lum/host/keys.h"

#include <locale.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define V1           "version: 1\n"

typedef enum kind {
    CALIBRATION,
    PROFILE
} kind;

/* Either output, filled with a pattern that no parser writes. */
typedef union output {
    lum_calibration calibration;
    lum_profile profile;
    unsigned char bytes[sizeof(lum_calibration) + sizeof(lum_profile)];
} output;

static void fill(output *out)
{
    memset(out, 0xa5, sizeof *out);
}

static void assert_untouched(const output *out)
{
    for (size_t i = 0; i < sizeof out->bytes; i++) {
        assert_int_equal(out->bytes[i], 0xa5);
    }
}

static void assert_single_line(const lum_error *error)
{
    assert_true(error->text[0] != '\0');
    assert_true(strlen(error->text) < sizeof error->text);
    for (const char *p = error->text; *p != '\0'; p++) {
        assert_true((unsigned char)*p >= 0x20 && *p != 0x7f);
    }
}

/* Parses a copy that ends where the text ends, so that a sanitizer sees a read
 * beyond it. */
static int parse(kind k, const char *text, size_t len, output *out,
                 lum_error *error)
{
    char *copy = malloc(len > 0 ? len : 1);
    assert_non_null(copy);
    memcpy(copy, text, len);
    const int result =
        k == CALIBRATION
            ? lum_calibration_parse(copy, len, "f", &out->calibration, error)
            : lum_profile_parse(copy, len, "f", &out->profile, error);
    free(copy);
    return result;
}

static void assert_refused_bytes(kind k, const char *text, size_t len,
                                 const char *where, const char *says)
{
    output out;
    lum_error error = {""};
    fill(&out);
    const int result = parse(k, text, len, &out, &error);
    if (result != -1 || strncmp(error.text, where, strlen(where)) != 0 ||
        strstr(error.text, says) == NULL) {
        fail_msg("for <%.60s>: %d '%s', want '%s' ... '%s'", text, result,
                 error.text, where, says);
    }
    assert_single_line(&error);
    assert_untouched(&out);
}

static void assert_refused(kind k, const char *text, const char *where,
                           const char *says)
{
    assert_refused_bytes(k, text, strlen(text), where, says);
}

static void parse_fine(kind k, const char *text, output *out)
{
    lum_error error = {""};
    fill(out);
    if (parse(k, text, strlen(text), out, &error) != 0) {
        fail_msg("for <%.60s>: '%s'", text, error.text);
    }
    assert_string_equal(error.text, "");
}

static void assert_same_eye(const lum_eye_calibration *a,
                            const lum_eye_calibration *b)
{
    assert_true(a->tof_offset_fs == b->tof_offset_fs);
    assert_int_equal(a->azimuth_center_udeg, b->azimuth_center_udeg);
    assert_int_equal(a->azimuth_width_udeg, b->azimuth_width_udeg);
    assert_int_equal(a->elevation_min_udeg, b->elevation_min_udeg);
    assert_int_equal(a->elevation_max_udeg, b->elevation_max_udeg);
    assert_memory_equal(a->mount_um, b->mount_um, sizeof a->mount_um);
    assert_int_equal(a->mount_roll_udeg, b->mount_roll_udeg);
    assert_int_equal(a->mount_pitch_udeg, b->mount_pitch_udeg);
    assert_int_equal(a->mount_yaw_udeg, b->mount_yaw_udeg);
}

static void assert_same_calibration(const lum_calibration *a,
                                    const lum_calibration *b)
{
    assert_int_equal(a->speed_of_light, b->speed_of_light);
    assert_int_equal(a->tof_lsb_fs, b->tof_lsb_fs);
    assert_same_eye(&a->eye[LUM_EYE_BLUE], &b->eye[LUM_EYE_BLUE]);
    assert_same_eye(&a->eye[LUM_EYE_GREEN], &b->eye[LUM_EYE_GREEN]);
}

static void assert_same_profile(const lum_profile *a, const lum_profile *b)
{
    assert_int_equal(a->data_packet_type, b->data_packet_type);
    assert_memory_equal(a->group, b->group, sizeof a->group);
    assert_int_equal(a->samples_at, b->samples_at);
    assert_int_equal(a->set_ip_order, b->set_ip_order);
    assert_int_equal(a->angle_order, b->angle_order);
    assert_memory_equal(a->eye_values, b->eye_values, sizeof a->eye_values);
    assert_memory_equal(a->tlv, b->tlv, sizeof a->tlv);
    assert_true(a->angle_lsb_pdeg == b->angle_lsb_pdeg);
    assert_int_equal(a->line_span_us, b->line_span_us);
    assert_int_equal(a->clock_unit_ns, b->clock_unit_ns);
    assert_int_equal(a->sample_order, b->sample_order);
}

static void the_sample_files_equal_what_is_built_in(void **state)
{
    (void)state;
    output out;
    lum_error error = {""};
    lum_calibration calibration;
    lum_profile profile;
    lum_calibration_default(&calibration);
    lum_profile_default(&profile);
    fill(&out);
    assert_int_equal(lum_calibration_load(LUM_SOURCE_DIR "/calib/typical.yaml",
                                          &out.calibration, &error),
                     0);
    assert_same_calibration(&out.calibration, &calibration);
    fill(&out);
    assert_int_equal(lum_profile_load(LUM_SOURCE_DIR
                                      "/calib/profile-default.yaml",
                                      &out.profile, &error),
                     0);
    assert_same_profile(&out.profile, &profile);
    assert_string_equal(error.text, "");
}

static void a_partial_calibration_keeps_the_other_defaults(void **state)
{
    (void)state;
    output out;
    lum_calibration want;
    lum_calibration_default(&want);
    parse_fine(CALIBRATION, "{}", &out);
    assert_same_calibration(&out.calibration, &want);
    parse_fine(CALIBRATION, V1, &out);
    assert_same_calibration(&out.calibration, &want);
    parse_fine(CALIBRATION, "eyes: {green: {}, blue: {mount: {}}}", &out);
    assert_same_calibration(&out.calibration, &want);
    parse_fine(CALIBRATION,
               "eyes:\n  green:\n    elevation: {max_deg: 3.5}\n"
               "    mount: {z_m: -0.25}\n",
               &out);
    want.eye[LUM_EYE_GREEN].elevation_max_udeg = 3500000;
    want.eye[LUM_EYE_GREEN].mount_um[2] = -250000;
    assert_same_calibration(&out.calibration, &want);
}

static void every_key_of_a_calibration_reaches_its_field(void **state)
{
    (void)state;
    static const char text[] =
        "speed_of_light: 299792458.0\ntof_lsb_ps: 12.5\neyes:\n"
        "  blue:\n    tof_offset_ps: -1557.4603191587444\n"
        "    azimuth: {center_deg: 0.6905691623716558, width_deg: 61.5}\n"
        "    elevation: {min_deg: -16.25, max_deg: 3.5}\n"
        "    mount: {x_m: 1, y_m: 2, z_m: 3, roll_deg: 4, pitch_deg: 5, "
        "yaw_deg: 6}\n"
        "  green:\n    tof_offset_ps: 8.5\n"
        "    azimuth: {center_deg: -1, width_deg: 7}\n"
        "    elevation: {min_deg: 8, max_deg: 9}\n"
        "    mount: {x_m: 10, y_m: 11, z_m: 12, roll_deg: 13, pitch_deg: 14, "
        "yaw_deg: 15}\n";
    static const lum_calibration want = {299792458u,
                                         12500u,
                                         {{-1557460,
                                           690569,
                                           61500000,
                                           -16250000,
                                           3500000,
                                           {1000000, 2000000, 3000000},
                                           4000000,
                                           5000000,
                                           6000000},
                                          {8500,
                                           -1000000,
                                           7000000,
                                           8000000,
                                           9000000,
                                           {10000000, 11000000, 12000000},
                                           13000000,
                                           14000000,
                                           15000000}}};
    output out;
    parse_fine(CALIBRATION, text, &out);
    assert_same_calibration(&out.calibration, &want);
}

static void a_partial_profile_keeps_the_other_defaults(void **state)
{
    (void)state;
    output out;
    lum_profile want;
    lum_profile_default(&want);
    parse_fine(PROFILE, V1, &out);
    assert_same_profile(&out.profile, &want);
    parse_fine(PROFILE, V1 "group: {line: {}, tag: {}}\ntlv: {}\n", &out);
    assert_same_profile(&out.profile, &want);
    parse_fine(PROFILE,
               V1 "group: {timestamp: {bytes: 2}, eye: {at: 40}, line: 42, "
                  "samples: 48}\ntlv: {yscan: 9}\n",
               &out);
    want.group[LUM_FIELD_TIMESTAMP].bytes = 2;
    want.group[LUM_FIELD_EYE].at = 40;
    want.group[LUM_FIELD_LINE].at = 42;
    want.samples_at = 48;
    want.tlv[LUM_TLV_YSCAN] = 9;
    assert_same_profile(&out.profile, &want);
}

static void every_key_of_a_profile_reaches_its_field(void **state)
{
    (void)state;
    static const char text[] =
        "version: 1\ndata_packet_type: 3\nset_ip_order: little\n"
        "group: {line: {at: 12, bytes: 4}, num_samples: {at: 18, bytes: 1},\n"
        "  timestamp: {at: 20, bytes: 2}, first_sample_index: {at: 24, "
        "bytes: 4},\n"
        "  eye: {at: 30, bytes: 2}, tag: {at: 33, bytes: 2}, samples: 40}\n"
        "eye_values: {blue: 1000, green: 48}\n"
        "angle_order: \"elevation_azimuth\"\nangle_lsb_deg: 0.0009155\n"
        "tlv: {command: 65535, status: 0, debug: 7, yscan: 8}\n"
        "line_span_us: 5000\n";
    static const lum_profile want = {3,
                                     {{33, 2, 0, 0, 0},
                                      {30, 2, 0, 0, 0},
                                      {12, 4, 0, 0, 0},
                                      {18, 1, 0, 0, 0},
                                      {24, 4, 0, 0, 0},
                                      {20, 2, 0, 0, 0}},
                                     40,
                                     LUM_SET_IP_LITTLE,
                                     LUM_ELEVATION_AZIMUTH,
                                     LUM_ORDER_LITTLE,
                                     {1000, 48},
                                     {65535, 0, 7, 8},
                                     UINT64_C(915500000),
                                     5000,
                                     1000};
    output out;
    parse_fine(PROFILE, text, &out);
    assert_same_profile(&out.profile, &want);
}

static void a_profile_can_do_without_a_clock(void **state)
{
    (void)state;
    output out;
    parse_fine(PROFILE, V1 "group: {timestamp: none, samples: 20}", &out);
    assert_int_equal(out.profile.group[LUM_FIELD_TIMESTAMP].bytes, 0);
    assert_int_equal(out.profile.samples_at, 20);
}

static void the_tag_can_be_the_packet_type(void **state)
{
    (void)state;
    output out;
    parse_fine(PROFILE, V1 "group: {tag: 8}", &out);
    assert_int_equal(out.profile.group[LUM_FIELD_TAG].at, 8);
}

/* Texts that are refused by both kinds of file alike. */
static void what_is_no_plain_mapping_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *where;
        const char *says;
    } rows[] = {
        {"", "f:1: ", "nothing but blanks"},
        {" \n\n", "f:1: ", "nothing but blanks"},
        {"# nothing\n# here\n", "f:1: ", "begin with 'version: 1'"},
        {"---\n", "f:1: ", "nothing but blanks"},
        {"---\n...\n", "f:1: ", "nothing but blanks"},
        {"\n- 1\n", "f:2: ", "not a mapping of keys; allowed here: version"},
        {"hello\n", "f:1: ", "not a mapping of keys"},
        {"~\n", "f:1: ", "not a mapping of keys"},
        {"&a {version: 1}\n", "f:1: ", "anchors"},
        {"!!map {version: 1}\n", "f:1: ", "tags"},
        {"*a\n", "f:1: ", "aliases"},
        {V1 "---\n" V1, "f:2: ", "a second document begins"},
        {V1 "...\n---\n", "f:3: ", "a second document begins"},
        {V1 "\nversion: 1\n",
         "f:3: version: ", "repeated; it is already on line 1"},
        {V1 "'version': 1\n", "f:2: version: ", "repeated"},
        {V1 "verison: 1\n",
         "f:2: ", "unknown key 'verison'; did you mean 'version'?"},
        {"x: &a [*a, *a]\n", "f:1: ", "unknown key 'x'; allowed here: version"},
        {"<<: {version: 1}\n", "f:1: ", "unknown key '<<'"},
        {V1 "? [a, b]\n: 1\n", "f:2: ", "a key must be a single word"},
        {V1 "{a: b}: 1\n", "f:2: ", "a key must be a single word"},
        {V1 "&k version: 1\n", "f:2: ", "anchors"},
        {V1 "!!str version: 1\n", "f:2: ", "tags"},
        {"version: &a 1\n", "f:1: version: ", "anchors (&) are not accepted"},
        {"version: !!int 1\n", "f:1: version: ", "tags (!) are not accepted"},
        {"version: ! 1\n", "f:1: version: ", "tags (!) are not accepted"},
        {"version: *a\n", "f:1: version: ", "aliases (*) are not accepted"},
        {"version: &a [1]\n", "f:1: version: ", "anchors"},
        {"version: !!seq [1]\n", "f:1: version: ", "tags"},
        {"version: [1]\n", "f:1: version: ", "a sequence"},
        {"version:\n- 1\n", "f:1: version: ", "a sequence"},
        {"version: {a: 1}\n", "f:1: version: ", "a mapping does not belong"},
        {"version:\n", "f:1: version: ", "no value; allowed: 1"},
        {"version\n: 1\n", "f:1: ", "not a mapping of keys"},
        {"{version: 1", "f:", "not valid YAML"},
        {V1 "\tversion: 1\n", "f:2: ", "a tab indents this line"},
        {"version: 'x\n", "f:", "not valid YAML"},
        {V1 "%TAG\n", "f:2: ", "not valid YAML"},
        {"\nversion: @x\n", "f:2: ", "not valid YAML"},
        {V1 "\n# caf\xe9\n", "f:3: ", "not plain UTF-8 text"},
        {V1 "# \xc0\xaf\n", "f:2: ", "not plain UTF-8 text"},
        {V1 "# \xed\xa0\x80\n", "f:2: ", "not plain UTF-8 text"},
        {V1 "# \x01\n", "f:2: ", "not plain UTF-8 text: control"},
        {"\xff\xfev", "f:1: ", "not plain UTF-8 text"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_refused(CALIBRATION, rows[i].text, rows[i].where, rows[i].says);
        assert_refused(PROFILE, rows[i].text, rows[i].where, rows[i].says);
    }
}

static void a_nul_byte_is_refused(void **state)
{
    (void)state;
    static const char text[] = V1 "# \0\n";
    assert_refused_bytes(CALIBRATION, text, sizeof text - 1,
                         "f:2: ", "not plain UTF-8 text");
    assert_refused_bytes(PROFILE, text, 3, "f:1: ", "not a mapping");
    assert_refused_bytes(PROFILE, "\0", 1, "f:1: ", "not plain UTF-8 text");
}

static void what_a_message_shows_of_the_file_is_plain_and_short(void **state)
{
    (void)state;
    char text[5000];
    static const char key[] = "\"\\n\\e[2J\\u2028\\0\": 1";
    assert_refused(CALIBRATION, key,
                   "f:1: ", "unknown key '\\x0a\\x1b[2J\\xe2\\x80\\xa8\\x00'");
    assert_refused(CALIBRATION, "tof_lsb_ps: \"\\n\"",
                   "f:1: tof_lsb_ps: ", "'\\x0a' is text");
    memset(text, 'k', sizeof text);
    memcpy(text, "tof_lsb_ps: ", 12);
    text[sizeof text - 1] = '\0';
    assert_refused(CALIBRATION, text, "f:1: tof_lsb_ps: ",
                   "k...' is not a decimal number; allowed: above 0, at most "
                   "1000 ps");
    memcpy(text + 900, ": 1", 4);
    assert_refused(CALIBRATION, text + 12, "f:1: ", "k...'; allowed here: ");
}

static void a_long_name_of_a_file_leaves_room_for_the_message(void **state)
{
    (void)state;
    char name[4000];
    output out;
    lum_error error = {""};
    memset(name, 'd', sizeof name);
    memcpy(name + sizeof name - 8, "/f.yaml", 8);
    name[sizeof name - 20] = '\n';
    fill(&out);
    assert_int_equal(
        lum_calibration_parse("a: 1", 4, name, &out.calibration, &error), -1);
    assert_single_line(&error);
    assert_non_null(strstr(error.text, "/f.yaml:1: unknown key 'a'"));
    assert_non_null(strstr(error.text, "eyes"));
    assert_int_equal(
        lum_calibration_parse("a: 1", 4, name, &out.calibration, NULL), -1);
    assert_untouched(&out);
}

static void numbers_are_plain_decimals(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *says;
    } rows[] = {
        {".nan", "is not a decimal number"},
        {"NaN", "is not a decimal number"},
        {".inf", "is not a decimal number"},
        {"-.inf", "is not a decimal number"},
        {"inf", "is not a decimal number"},
        {"1e999", "is out of range"},
        {"-1e999", "is out of range"},
        {"1e99999999999999999999", "is out of range"},
        {"99999999999999999999999999", "is out of range"},
        {"~", "is not a decimal number"},
        {"null", "is not a decimal number"},
        {"true", "is not a decimal number"},
        {"yes", "is not a decimal number"},
        {"0x10", "is not a decimal number"},
        {"0o17", "is not a decimal number"},
        {"017", "begins with 0"},
        {"-007.5", "begins with 0"},
        {"1_000", "is not a decimal number"},
        {"1:30", "is not a decimal number"},
        {"1,5", "is not a decimal number"},
        {"1.5.", "is not a decimal number"},
        {"1.5 m", "is not a decimal number"},
        {"1 2", "is not a decimal number"},
        {"1e", "is not a decimal number"},
        {"1e+", "is not a decimal number"},
        {"1e1.5", "is not a decimal number"},
        {"e5", "is not a decimal number"},
        {".", "is not a decimal number"},
        {"+-1", "is not a decimal number"},
        {"--1", "is not a decimal number"},
        {"1f", "is not a decimal number"},
        {"\"1\"", "is text; write a number, without quotes"},
        {"'1'", "is text"},
        {"|\n    1", "is text"},
        {"\xd9\xa1", "is not a decimal number"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[128];
        (void)snprintf(text, sizeof text,
                       V1 "eyes:\n  blue: \n   tof_offset_ps: %s",
                       rows[i].text);
        assert_refused(CALIBRATION, text,
                       "f:4: eyes.blue.tof_offset_ps: ", rows[i].says);
        (void)snprintf(text, sizeof text, V1 "\nangle_lsb_deg: %s",
                       rows[i].text);
        assert_refused(PROFILE, text, "f:3: angle_lsb_deg: ", rows[i].says);
    }
}

static void whole_numbers_take_no_point(void **state)
{
    (void)state;
    static const char *const rows[] = {"8.0", "8.5", "8e0", "8.", ".8"};
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[64];
        (void)snprintf(text, sizeof text, V1 "data_packet_type: %s\n", rows[i]);
        assert_refused(PROFILE, text,
                       "f:2: data_packet_type: ", "is not a whole number");
    }
}

static void every_level_of_a_calibration_names_its_keys(void **state)
{
    (void)state;
    assert_refused(CALIBRATION, "\n\nspeed_of_ligth: 3", "f:3: ",
                   "unknown key 'speed_of_ligth'; did you mean "
                   "'speed_of_light'? allowed here: version, speed_of_light, "
                   "tof_lsb_ps, eyes");
    assert_refused(CALIBRATION, "eyes:\n  red: {}", "f:2: eyes: ",
                   "unknown key 'red'; allowed here: blue, green");
    assert_refused(CALIBRATION, "eyes:\n  blue:\n    azimut: {}",
                   "f:3: eyes.blue: ",
                   "did you mean 'azimuth'? allowed here: tof_offset_ps, "
                   "azimuth, elevation, mount");
    assert_refused(CALIBRATION, "eyes: {green: {azimuth: {\n center: 3}}}",
                   "f:2: eyes.green.azimuth: ",
                   "unknown key 'center'; allowed here: center_deg, width_deg");
    assert_refused(CALIBRATION, "eyes: {green: {elevation: {man_deg: 3}}}",
                   "f:1: eyes.green.elevation: ",
                   "did you mean 'min_deg'? allowed here: min_deg, max_deg");
    assert_refused(CALIBRATION, "eyes: {blue: {mount: {y_um: 3}}}",
                   "f:1: eyes.blue.mount: ", "did you mean 'y_m'?");
    assert_refused(CALIBRATION, "eyes: {blue: {mount: {x_m: 3, x_m: 3}}}",
                   "f:1: eyes.blue.mount.x_m: ", "repeated");
    assert_refused(CALIBRATION, "eyes:\n  blue: {}\n  green: {}\n  blue: {}",
                   "f:4: eyes.blue: ", "is already on line 2");
}

static void every_level_of_a_profile_names_its_keys(void **state)
{
    (void)state;
    assert_refused(PROFILE, V1 "groups: 3", "f:2: ", "did you mean 'group'?");
    assert_refused(PROFILE, V1 "group:\n  sample: 3", "f:3: group: ",
                   "did you mean 'samples'? allowed here: tag, eye, line, "
                   "num_samples, first_sample_index, timestamp, samples");
    assert_refused(
        PROFILE, V1 "group:\n  line:\n    byte: 3",
        "f:4: group.line: ", "did you mean 'bytes'? allowed here: at, bytes");
    assert_refused(PROFILE, V1 "group:\n  line: {at: 40, at: 40}",
                   "f:3: group.line.at: ", "repeated");
    assert_refused(PROFILE, V1 "eye_values: {red: 3}", "f:2: eye_values: ",
                   "unknown key 'red'; allowed here: blue, green");
    assert_refused(PROFILE, V1 "tlv: {comand: 3}",
                   "f:2: tlv: ", "did you mean 'command'?");
    assert_refused(PROFILE, V1 "tlv: 3", "f:2: tlv: ",
                   "a single value does not belong here; allowed: a mapping "
                   "of command, status, debug, yscan");
    assert_refused(PROFILE, V1 "group: ", "f:2: group: ",
                   "no value; allowed: a mapping of tag");
    assert_refused(PROFILE, V1 "group: {samples: {at: 24}}",
                   "f:2: group.samples: ",
                   "a mapping does not belong here; allowed: an offset from 8 "
                   "to 64");
    assert_refused(PROFILE, V1 "group: {line: []}", "f:2: group.line: ",
                   "a sequence does not belong here; allowed: an offset from "
                   "8 to 64, or a mapping of at, bytes");
    assert_refused(PROFILE, V1 "group: {line: none}",
                   "f:2: group.line: ", "'none' is not a decimal number");
    assert_refused(PROFILE, V1 "group: {timestamp: {at: none}}",
                   "f:2: group.timestamp.at: ", "not a decimal number");
    assert_refused(PROFILE, V1 "group: {timestamp: no}", "f:2: group.timestamp",
                   "allowed: none, or an offset from 8 to 64");
}

/* A key's limits: min and max are accepted, below and above are not. */
typedef struct limit {
    const char *before; /* the number */
    const char *after;
    const char *where;
    const char *min;
    const char *max;
    const char *below;
    const char *above;
    const char *allowed;
} limit;

static void check_limit(kind k, const limit *l)
{
    const char *const fine[] = {l->min, l->max};
    const char *const refused[] = {l->below, l->above};
    char text[256];
    output out;
    for (size_t i = 0; i < 2; i++) {
        (void)snprintf(text, sizeof text, "%s%s%s", l->before, fine[i],
                       l->after);
        parse_fine(k, text, &out);
        (void)snprintf(text, sizeof text, "%s%s%s", l->before, refused[i],
                       l->after);
        assert_refused(k, text, l->where, "is out of range");
        assert_refused(k, text, l->where, l->allowed);
    }
}

#define TURN(key)                                                              \
    {                                                                          \
        "eyes: {blue: {mount: {" key ": ", "}}}",                              \
            "f:1: eyes.blue.mount." key ": ", "-360", "360.0000004",           \
            "-360.0000005", "360.000001", "allowed: -360 to 360 deg"           \
    }
#define PLACE(key)                                                             \
    {                                                                          \
        "eyes: {green: {mount: {" key ": ", "}}}",                             \
            "f:1: eyes.green.mount." key ": ", "-1000", "1000",                \
            "-1000.000001", "1e3001", "allowed: -1000 to 1000 m"               \
    }

static void every_limit_of_a_calibration_holds(void **state)
{
    (void)state;
    static const limit limits[] = {
        {"version: ", "", "f:1: version: ", "1", "1", "0", "2", "allowed: 1"},
        {"speed_of_light: ", "", "f:1: speed_of_light: ", "200000000", "3.1e8",
         "199999999", "310000001", "allowed: 200000000 to 310000000 m/s"},
        {"tof_lsb_ps: ", "", "f:1: tof_lsb_ps: ", "0.001", "1000", "0.0004",
         "1000.001", "allowed: above 0, at most 1000 ps"},
        {"eyes: {green: {tof_offset_ps: ", "}}",
         "f:1: eyes.green.tof_offset_ps: ", "-1e7", "10000000", "-10000000.001",
         "10000000.001", "allowed: -10000000 to 10000000 ps"},
        {"eyes: {blue: {azimuth: {center_deg: ", "}}}",
         "f:1: eyes.blue.azimuth.center_deg: ", "-180", "180", "-180.000001",
         "180.000001", "allowed: -180 to 180 deg"},
        {"eyes: {blue: {azimuth: {width_deg: ", "}}}",
         "f:1: eyes.blue.azimuth.width_deg: ", "0.000001", "360", "-0.0",
         "4294.967297", "allowed: above 0, at most 360 deg"},
        {"eyes: {blue: {elevation: {max_deg: 90, min_deg: ", "}}}",
         "f:1: eyes.blue.elevation.min_deg: ", "-90", "89.999999", "-90.000001",
         "90.000001", "allowed: -90 to 90 deg"},
        {"eyes: {blue: {elevation: {min_deg: -90, max_deg: ", "}}}",
         "f:1: eyes.blue.elevation.max_deg: ", "-89.999999", "90", "-90.000001",
         "90.000001", "allowed: -90 to 90 deg"},
        PLACE("x_m"),
        PLACE("y_m"),
        PLACE("z_m"),
        TURN("roll_deg"),
        TURN("pitch_deg"),
        TURN("yaw_deg"),
    };
    for (size_t i = 0; i < COUNT(limits); i++) {
        check_limit(CALIBRATION, &limits[i]);
    }
}

static void elevations_out_of_order_are_refused(void **state)
{
    (void)state;
    assert_refused(CALIBRATION,
                   "eyes:\n  green:\n    elevation:\n      max_deg: 2\n"
                   "      min_deg: 2.0\n",
                   "f:5: eyes.green.elevation.min_deg: ",
                   "min_deg must be below max_deg; they are 2 and 2");
    assert_refused(CALIBRATION, "eyes: {blue: {elevation: {min_deg: 4.25}}}",
                   "f:1: eyes.blue.elevation.min_deg: ",
                   "they are 4.25 and 3 (the default)");
    assert_refused(CALIBRATION, "eyes: {blue: {elevation: {max_deg: -17}}}",
                   "f:1: eyes.blue.elevation.max_deg: ",
                   "they are -17 (the default) and -17");
}

#define TLV_LIMIT(key)                                                         \
    {                                                                          \
        V1 "tlv: {" key ": ", "}", "f:2: tlv." key ": ", "0", "65535", "-1",   \
            "65536", "allowed: 0 to 65535"                                     \
    }
#define OFFSET_LIMIT(key)                                                      \
    {                                                                          \
        V1 "group: {samples: 64, " key ": ", "}", "f:2: group." key ": ",      \
            "32", "60", "7", "65", "an offset from 8 to 64"                    \
    }

static void bits_are_a_sequence(void **state)
{
    static const char *const wrong[] = {
        "[]",
        "[1]",
        "[1, 2, 3]",
        "[a, b]",
        "[1.0, 2]",
        "[1, ]",
        "[01, 2]",
        "[1234567890, 1234567890, 1234567890, 1234567890, 1234567890, 12]"};
    output out;
    (void)state;
    parse_fine(PROFILE, V1 "group:\n  line:\n    bits:\n    - 2\n    - 9\n",
               &out);
    assert_int_equal(out.profile.group[LUM_FIELD_LINE].low, 2);
    assert_int_equal(out.profile.group[LUM_FIELD_LINE].bits, 8);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char text[256];
        (void)snprintf(text, sizeof text, V1 "group: {line: {bits: %s}}",
                       wrong[i]);
        assert_refused(PROFILE, text, "f:2: group.line.bits: ",
                       "is not [LOW, HIGH], two whole numbers; allowed: all");
    }
    assert_refused(PROFILE, V1 "group: {line: {bits: [[0], 1]}}",
                   "f:2: group.line.bits: ", "only numbers belong in [ ]");
    assert_refused(PROFILE, V1 "group: {line: {bits: ['0', 1]}}",
                   "f:2: group.line.bits: ", "only numbers belong in [ ]");
    assert_refused(PROFILE, V1 "group: {line: {bits: [&a 0, 1]}}",
                   "f:2: group.line.bits: ", "anchors (&) are not accepted");
    assert_refused(PROFILE, V1 "group: {line: {bits: [0, 1}}",
                   "f:2: ", "not valid YAML");
    assert_refused(
        PROFILE, V1 "group: {line: {bits: '[0, 1]'}}",
        "f:2: group.line.bits: ", "is text; write [LOW, HIGH], without quotes");
    assert_refused(PROFILE, V1 "group: {line: {bits: 3}}",
                   "f:2: group.line.bits: ", "'3' is not [LOW, HIGH]");
    assert_refused(PROFILE, V1 "group: {line: {bytes: [1, 2]}}",
                   "f:2: group.line.bytes: ", "a sequence does not belong");
}

static void every_limit_of_a_profile_holds(void **state)
{
    (void)state;
    static const limit limits[] = {
        {"version: ", "", "f:1: version: ", "1", "1", "0", "2", "allowed: 1"},
        {V1 "data_packet_type: ", "", "f:2: data_packet_type: ", "0", "255",
         "-1", "256", "allowed: 0 to 255, but not 5, 6 or 7"},
        {V1 "angle_lsb_deg: ", "", "f:2: angle_lsb_deg: ", "0.0000000000005",
         "1", "0.00000000000049", "1.000000000001",
         "allowed: span, or above 0, at most 1 deg"},
        {V1 "line_span_us: ", "", "f:2: line_span_us: ", "0", "1000000000",
         "-1", "1000000001", "allowed: 0 to 1000000000 us"},
        {V1 "group: {eye: {at: 32, bytes: 4}, samples: 36}\n"
            "eye_values: {green: 7, blue: ",
         "}", "f:3: eye_values.blue: ", "0", "4294967295", "-1", "4294967296",
         "allowed: 0 to 4294967295"},
        {V1 "group: {eye: {at: 32, bytes: 4}, samples: 36}\n"
            "eye_values: {blue: 7, green: ",
         "}", "f:3: eye_values.green: ", "0", "4294967295", "-1", "4294967296",
         "allowed: 0 to 4294967295"},
        {V1 "group: {line: {at: 32, bytes: ", "}, samples: 40}",
         "f:2: group.line.bytes: ", "1", "8", "0", "9",
         "allowed: 1, 2, 4 or 8"},
        {V1 "group: {timestamp: {unit_ns: ", "}}",
         "f:2: group.timestamp.unit_ns: ", "1", "1000000000", "0", "1000000001",
         "allowed: 1 to 1000000000 ns"},
        {V1 "group: {samples: 40, line: {at: 32, bytes: 8, bits: ", "}}",
         "f:2: group.line.bits: ", "[0, 0]", "[63, 63]", "[0, 64]", "[-1, 3]",
         "allowed: all, or [LOW, HIGH], both included, 0 to 63"},
        {V1 "group: {samples: ", "}", "f:2: group.samples: ", "24", "64", "7",
         "65", "an offset from 8 to 64"},
        {V1 "group: {samples: 64, line: {at: ", "}}", "f:2: group.line.at: ",
         "32", "62", "7", "4294967328", "an offset from 8 to 64"},
        OFFSET_LIMIT("tag"),
        OFFSET_LIMIT("eye"),
        OFFSET_LIMIT("line"),
        OFFSET_LIMIT("num_samples"),
        OFFSET_LIMIT("first_sample_index"),
        OFFSET_LIMIT("timestamp"),
        TLV_LIMIT("command"),
        TLV_LIMIT("status"),
        TLV_LIMIT("debug"),
        TLV_LIMIT("yscan"),
    };
    for (size_t i = 0; i < COUNT(limits); i++) {
        check_limit(PROFILE, &limits[i]);
    }
}

static void words_are_those_of_the_table(void **state)
{
    (void)state;
    assert_refused(PROFILE, V1 "set_ip_order: big", "f:2: set_ip_order: ",
                   "'big' is not known; allowed: network or little");
    assert_refused(PROFILE, V1 "set_ip_order: 0", "f:2: set_ip_order: ",
                   "'0' is not known; allowed: network or little");
    assert_refused(PROFILE, V1 "set_ip_order: Network",
                   "f:2: set_ip_order: ", "'Network' is not known");
    assert_refused(PROFILE, V1 "set_ip_order: \"net\\0work\"",
                   "f:2: set_ip_order: ", "'net\\x00work' is not known");
    assert_refused(PROFILE, V1 "angle_order: azimuth", "f:2: angle_order: ",
                   "allowed: azimuth_elevation or elevation_azimuth");
    assert_refused(PROFILE, V1 "angle_order: ''",
                   "f:2: angle_order: ", "'' is not known");
    assert_refused(PROFILE, V1 "angle_lsb_deg: 0", "f:2: angle_lsb_deg: ",
                   "'0' is out of range; allowed: span, or above 0");
    assert_refused(PROFILE, V1 "angle_lsb_deg: spam", "f:2: angle_lsb_deg: ",
                   "allowed: span, or above 0, at most 1 deg");
}

static void a_profile_needs_a_version(void **state)
{
    (void)state;
    assert_refused(PROFILE, "{}", "f:1: version: ", "missing");
    assert_refused(PROFILE, "# x\ndata_packet_type: 8",
                   "f:1: version: ", "missing; a profile needs 'version: 1'");
}

static void what_the_core_refuses_bears_the_line_of_its_key(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *where;
        const char *says;
    } rows[] = {
        {"data_packet_type: 5", "f:2: data_packet_type: ",
         "5 is the type of other packets; allowed: 0 to 255, but not 5"},
        {"data_packet_type: 6", "f:2: data_packet_type: ", "6 is the type"},
        {"data_packet_type: 7", "f:2: data_packet_type: ", "7 is the type"},
        {"group:\n  line: {at: 40,\n    bytes: 3}", "f:4: group.line.bytes: ",
         "no field has 3 bytes; allowed: 1, 2, 4 or 8"},
        {"group: {eye: 8}", "f:2: group.eye: ",
         "8 lies on the packet type (bytes 8 to 11); allowed: 12 to 64, or 8 "
         "for group.tag"},
        {"group: {tag: 9}", "f:2: group.tag: ", "9 lies on the packet type"},
        {"group:\n  samples: 30\n  timestamp: 11",
         "f:4: group.timestamp: ", "11 lies on the packet type"},
        {"group:\n  eye: 12", "f:3: group.eye: ",
         "bytes 12 to 12 overlap group.tag, 12 to 12 (the default)"},
        {"group:\n  tag: 13", "f:3: group.tag: ",
         "bytes 13 to 13 overlap group.eye, 13 to 13 (the default)"},
        {"group:\n  line: 40\n  num_samples: 41\n  samples: 50",
         "f:4: group.num_samples: ",
         "bytes 41 to 42 overlap group.line, 40 to 41; fields must not share"},
        {"group:\n  line: {bytes: 4}", "f:3: group.line: ",
         "bytes 14 to 17 overlap group.num_samples, 16 to 17 (the default)"},
        {"group:\n  first_sample_index: 22", "f:3: group.first_sample_index: ",
         "bytes 22 to 23 overlap group.timestamp, 20 to 23 (the default)"},
        {"group:\n  samples: 23", "f:3: group.samples: ",
         "23 is not behind group.timestamp, which ends with byte 23 (the "
         "default)"},
        {"group:\n  samples: 40\n  eye: 44", "f:3: group.samples: ",
         "40 is not behind group.eye, which ends with byte 44; samples come"},
        {"group:\n  eye: 64", "f:3: group.eye: ",
         "ends with byte 64, but group.samples is 24 (the default)"},
        {"eye_values:\n  blue: 3\n  green: 3", "f:4: eye_values.green: ",
         "3 is the value of eye_values.blue; they must differ"},
        {"eye_values: {blue: 1}", "f:2: eye_values.blue: ",
         "1 is the value of eye_values.green (the default)"},
        {"eye_values: {green: 0}", "f:2: eye_values.green: ",
         "0 is the value of eye_values.blue (the default)"},
        {"eye_values: {blue: 256}", "f:2: eye_values.blue: ",
         "256 does not fit group.eye, 1 byte wide; allowed: 0 to 255"},
        {"group: {eye: {at: 30, bytes: 2}, samples: 40}\n"
         "eye_values: {green: 65536}",
         "f:3: eye_values.green: ",
         "65536 does not fit group.eye, 2 bytes wide; allowed: 0 to 65535"},
        {"tlv: {command: 4}",
         "f:2: tlv.command: ", "4 is the value of tlv.yscan (the default)"},
        {"tlv:\n  debug: 9\n  status: 9",
         "f:3: tlv.debug: ", "9 is the value of tlv.status; they must differ"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[256];
        (void)snprintf(text, sizeof text, V1 "%s", rows[i].text);
        assert_refused(PROFILE, text, rows[i].where, rows[i].says);
    }
}

static void decimals_become_the_nearest_integers(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int decimals;
        int64_t number;
    } rows[] = {
        {"0", 0, 0},
        {"-0", 6, 0},
        {"+5", 0, 5},
        {"1.5", 0, 2},
        {"-1.5", 0, -2},
        {"1.49999999999999999999999999", 0, 1},
        {"-1.4999", 0, -1},
        {"0.5", 0, 1},
        {"0.05", 0, 0},
        {"0.05", 1, 1},
        {"5e-2", 0, 0},
        {".25", 3, 250},
        {"7.", 3, 7000},
        {"3.0e8", 0, 300000000},
        {"2997924580e-1", 0, 299792458},
        {"1e-12", 12, 1},
        {"4e-13", 12, 0},
        {"5E-13", 12, 1},
        {"1e-99999999999", 12, 0},
        {"0e99999999999", 12, 0},
        {"0.000000000000000000000001e24", 0, 1},
        {"0.1", 12, INT64_C(100000000000)},
        {"9223372036854775799", 0, INT64_C(9223372036854775799)},
        {"-9223372036854775799", 0, -INT64_C(9223372036854775799)},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        int64_t number = 77;
        assert_int_equal(lum_key_number_parse(rows[i].text,
                                              strlen(rows[i].text),
                                              rows[i].decimals, false, &number),
                         LUM_KEY_NUMBER_FINE);
        assert_true(number == rows[i].number);
    }
}

static void numbers_beyond_64_bits_are_too_large(void **state)
{
    (void)state;
    static const char *const rows[] = {"9223372036854775808", "1e19",
                                       "18446744073709551617",
                                       "-9223372036854775809"};
    for (size_t i = 0; i < COUNT(rows); i++) {
        int64_t number = 77;
        assert_int_equal(
            lum_key_number_parse(rows[i], strlen(rows[i]), 0, false, &number),
            LUM_KEY_NUMBER_TOO_LARGE);
        assert_true(number == 77);
    }
}

static void numbers_are_shown_without_idle_zeros(void **state)
{
    (void)state;
    static const struct {
        int64_t number;
        int decimals;
        const char *text;
    } rows[] = {
        {0, 0, "0"},
        {0, 6, "0"},
        {100, 0, "100"},
        {-360000000, 6, "-360"},
        {4250000, 6, "4.25"},
        {-1, 12, "-0.000000000001"},
        {INT64_C(1000000000000), 12, "1"},
        {INT64_MIN, 0, "-9223372036854775808"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[40];
        lum_key_text out = lum_key_text_begin(text, sizeof text);
        lum_key_text_add_number(&out, rows[i].number, rows[i].decimals);
        assert_string_equal(text, rows[i].text);
    }
}

/* As far from the defaults as the ranges go. */
static void move_all(lum_keys *keys, bool to_max)
{
    lum_key key;
    for (size_t i = 0; lum_keys_describe(keys, i, &key) == LUM_OK; i++) {
        const char *value = to_max ? key.max : key.min;
        if (strncmp(key.name, "group.", 6) != 0 && value[0] != '\0' &&
            strstr(key.name, to_max ? "min_deg" : "max_deg") == NULL &&
            strncmp(key.name, to_max ? "tlv.d" : "tlv.", 4) != 0 &&
            strstr(key.name, "_values.") == NULL) {
            assert_int_equal(lum_keys_set(keys, key.name, value, 1, NULL),
                             LUM_OK);
        }
    }
}

static void what_keys_write_reads_back_exactly(void **state)
{
    (void)state;
    char text[LUM_KEYS_WRITE_BYTES];
    lum_keys keys;
    output out;
    for (int to_max = 0; to_max < 2; to_max++) {
        lum_calibration calibration;
        lum_profile profile;
        lum_keys_of_calibration(&keys, NULL);
        move_all(&keys, to_max != 0);
        assert_int_equal(lum_keys_set(&keys, "eyes.blue.tof_offset_ps",
                                      "-1557.4603191587444", 1, NULL),
                         LUM_OK);
        assert_true(lum_keys_write(&keys, text, sizeof text) < sizeof text);
        assert_int_equal(lum_keys_calibration(&keys, &calibration, NULL),
                         LUM_OK);
        parse_fine(CALIBRATION, text, &out);
        assert_same_calibration(&out.calibration, &calibration);
        lum_keys_of_profile(&keys, NULL);
        move_all(&keys, to_max != 0);
        assert_int_equal(lum_keys_set(&keys, "group.timestamp",
                                      to_max != 0 ? "none" : "20", 1, NULL),
                         LUM_OK);
        assert_true(lum_keys_write(&keys, text, sizeof text) < sizeof text);
        assert_int_equal(lum_keys_profile(&keys, &profile, NULL), LUM_OK);
        parse_fine(PROFILE, text, &out);
        assert_same_profile(&out.profile, &profile);
    }
}

static void the_locale_changes_nothing(void **state)
{
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE",
                                        "fr_FR.UTF-8"};
    output out;
    bool found = false;
    for (size_t i = 0; i < COUNT(names) && !found; i++) {
        found = setlocale(LC_ALL, names[i]) != NULL;
    }
    if (found) {
        assert_string_equal(localeconv()->decimal_point, ",");
    } else {
        print_message("no locale with a decimal comma is installed\n");
    }
    parse_fine(CALIBRATION, "tof_lsb_ps: 12.5", &out);
    assert_int_equal(out.calibration.tof_lsb_fs, 12500);
    assert_refused(CALIBRATION, "tof_lsb_ps: 12,5",
                   "f:1: tof_lsb_ps: ", "is not a decimal number");
    assert_refused(CALIBRATION, "eyes: {blue: {elevation: {min_deg: 4.25}}}",
                   "f:1: ", "4.25 and 3");
    assert_non_null(setlocale(LC_ALL, "C"));
}

static void other_spellings_of_yaml_are_understood(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "%YAML 1.1\n---\nversion: 1\ndata_packet_type: 9\n...\n",
        "\xef\xbb\xbfversion: 1\ndata_packet_type: 9\n",
        "version: 1\r\ndata_packet_type: 9\r\n",
        "{\"version\": 1, \"data_packet_type\": 9}",
        "version: 1 # caf\xc3\xa9\n'data_packet_type': +9",
        "? version\n: 1\n? data_packet_type\n: 9\n",
    };
    for (size_t i = 0; i < COUNT(texts); i++) {
        output out;
        parse_fine(PROFILE, texts[i], &out);
        assert_int_equal(out.profile.data_packet_type, 9);
    }
}

/* LUM_CONFIG_BYTES_MAX bytes at most, made of one piece again and again. */
static void assert_heap_refused(const char *head, const char *piece,
                                const char *says)
{
    const size_t step = strlen(piece);
    size_t len = strlen(head);
    char *text = malloc(LUM_CONFIG_BYTES_MAX);
    assert_non_null(text);
    memcpy(text, head, len);
    while (len + step <= LUM_CONFIG_BYTES_MAX) {
        memcpy(text + len, piece, step);
        len += step;
    }
    assert_refused_bytes(CALIBRATION, text, len, "f:", says);
    assert_refused_bytes(PROFILE, text, len, "f:", says);
    free(text);
}

static void deep_and_long_texts_are_refused_at_once(void **state)
{
    (void)state;
    assert_heap_refused("", "[", "");
    assert_heap_refused("", "[\n", "not a mapping");
    assert_heap_refused("", "{", "");
    assert_heap_refused("", "{\n", "a key must be");
    assert_heap_refused("", "{a: ", "unknown key 'a'");
    assert_heap_refused("version: ", "[\n", "a sequence");
    assert_heap_refused("version: ", "{a: \n", "a mapping");
    assert_heap_refused("", "- ", "not a mapping");
    assert_heap_refused("", "? ", "a key must be");
    assert_heap_refused("", "a: &a\n", "");
    assert_heap_refused("version: ", "1", "is out of range");
    assert_heap_refused("version: '", "1", "not valid YAML");
    assert_heap_refused("version: 1\n", "version: 1\n", "repeated");
    assert_heap_refused("a: &a [x, x]\nb: &b [*a, *a]\n", "c: [*b, *b, *b]\n",
                        "unknown key 'a'");
}

static void the_size_limit_is_exact(void **state)
{
    (void)state;
    const size_t len = LUM_CONFIG_BYTES_MAX + 1u;
    char *text = malloc(len);
    output out;
    lum_error error = {""};
    assert_non_null(text);
    memset(text, '#', len);
    memcpy(text, V1, sizeof V1 - 1);
    assert_int_equal(parse(PROFILE, text, len - 1, &out, &error), 0);
    assert_refused_bytes(PROFILE, text, len, "f: ", "65536");
    assert_refused_bytes(CALIBRATION, text, len, "f: ", "longer than");
    free(text);
}

/* Loads and expects the message. */
static void assert_load_refused(const char *path, const char *says)
{
    output out;
    lum_error error = {""};
    fill(&out);
    assert_int_equal(lum_calibration_load(path, &out.calibration, &error), -1);
    assert_single_line(&error);
    assert_non_null(strstr(error.text, says));
    error.text[0] = '\0';
    assert_int_equal(lum_profile_load(path, &out.profile, &error), -1);
    assert_non_null(strstr(error.text, says));
    assert_untouched(&out);
}

static void make_file(char path[64], const void *bytes, size_t len)
{
    (void)snprintf(path, 64, "/tmp/lum-config-XXXXXX");
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, len), len);
    assert_int_equal(close(fd), 0);
}

static void files_that_cannot_be_read_are_refused(void **state)
{
    (void)state;
    char path[64];
    char below[80];
    assert_load_refused("/nonexistent/f.yaml",
                        "/nonexistent/f.yaml: cannot be read: No such file");
    assert_load_refused("", "cannot be read: No such file");
    assert_load_refused("/tmp", "/tmp: is a directory");
    assert_load_refused("/dev/null", "/dev/null:1: nothing but blanks");
    assert_load_refused("/dev/zero", "/dev/zero: longer than the 65536 bytes");
    make_file(path, V1, sizeof V1 - 1);
    assert_int_equal(chmod(path, 0), 0);
    if (access(path, R_OK) != 0) {
        assert_load_refused(path, "cannot be read: Permission denied");
    }
    (void)snprintf(below, sizeof below, "%s/f", path);
    assert_load_refused(below, "cannot be read: Not a directory");
    assert_int_equal(unlink(path), 0);
}

static void a_huge_file_is_refused_without_reading_it(void **state)
{
    (void)state;
    char path[64];
    make_file(path, V1, sizeof V1 - 1);
    assert_int_equal(truncate(path, (off_t)1 << 33), 0);
    assert_load_refused(path, "longer than");
    assert_int_equal(unlink(path), 0);
}

static void a_fault_in_a_file_names_the_file(void **state)
{
    (void)state;
    static const char text[] = V1 "\nversoin: 1\n";
    char path[64];
    char says[128];
    make_file(path, text, sizeof text - 1);
    (void)snprintf(says, sizeof says, "%s:3: unknown key 'versoin'", path);
    assert_load_refused(path, says);
    assert_int_equal(unlink(path), 0);
}

/* Puts text behind standard input. */
static void feed_stdin(const char *text)
{
    char path[64];
    make_file(path, text, strlen(text));
    assert_non_null(freopen(path, "rb", stdin));
    assert_int_equal(unlink(path), 0);
}

static void a_dash_is_standard_input(void **state)
{
    (void)state;
    output out;
    lum_error error = {""};
    feed_stdin("tof_lsb_ps: 12.5\n");
    assert_int_equal(lum_calibration_load("-", &out.calibration, &error), 0);
    assert_int_equal(out.calibration.tof_lsb_fs, 12500);
    feed_stdin(V1 "data_packet_type: 9\n");
    assert_int_equal(lum_profile_load("-", &out.profile, &error), 0);
    assert_int_equal(out.profile.data_packet_type, 9);
    feed_stdin("\nx: 1\n");
    fill(&out);
    assert_int_equal(lum_profile_load("-", &out.profile, &error), -1);
    assert_non_null(strstr(error.text, "<stdin>:2: unknown key 'x'"));
    assert_untouched(&out);
}

static char *read_whole(const char *path, size_t *len)
{
    char *text = malloc(LUM_CONFIG_BYTES_MAX);
    FILE *file = fopen(path, "rb");
    assert_non_null(text);
    assert_non_null(file);
    *len = fread(text, 1, LUM_CONFIG_BYTES_MAX, file);
    assert_true(*len > 1000 && *len < LUM_CONFIG_BYTES_MAX);
    assert_int_equal(fclose(file), 0);
    return text;
}

static void check_prefix(kind k, const char *text, size_t len)
{
    output out;
    lum_layout layout;
    lum_error error = {""};
    fill(&out);
    if (parse(k, text, len, &out, &error) != 0) {
        assert_single_line(&error);
        assert_untouched(&out);
    } else if (k == CALIBRATION) {
        assert_int_equal(lum_calibration_check(&out.calibration, NULL, NULL),
                         LUM_OK);
    } else {
        assert_int_equal(lum_layout_init(&layout, &out.profile, NULL, NULL),
                         LUM_OK);
    }
}

static void every_prefix_of_the_sample_files_is_read_or_refused(void **state)
{
    (void)state;
    static const struct {
        kind k;
        const char *path;
    } files[] = {
        {CALIBRATION, LUM_SOURCE_DIR "/calib/typical.yaml"},
        {PROFILE, LUM_SOURCE_DIR "/calib/profile-default.yaml"},
    };
    for (size_t i = 0; i < COUNT(files); i++) {
        size_t len = 0;
        char *text = read_whole(files[i].path, &len);
        for (size_t n = 0; n <= len; n++) {
            check_prefix(files[i].k, text, n);
        }
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sample_files_equal_what_is_built_in),
        cmocka_unit_test(a_partial_calibration_keeps_the_other_defaults),
        cmocka_unit_test(every_key_of_a_calibration_reaches_its_field),
        cmocka_unit_test(a_partial_profile_keeps_the_other_defaults),
        cmocka_unit_test(every_key_of_a_profile_reaches_its_field),
        cmocka_unit_test(a_profile_can_do_without_a_clock),
        cmocka_unit_test(the_tag_can_be_the_packet_type),
        cmocka_unit_test(what_is_no_plain_mapping_is_refused),
        cmocka_unit_test(a_nul_byte_is_refused),
        cmocka_unit_test(what_a_message_shows_of_the_file_is_plain_and_short),
        cmocka_unit_test(a_long_name_of_a_file_leaves_room_for_the_message),
        cmocka_unit_test(numbers_are_plain_decimals),
        cmocka_unit_test(whole_numbers_take_no_point),
        cmocka_unit_test(every_level_of_a_calibration_names_its_keys),
        cmocka_unit_test(every_level_of_a_profile_names_its_keys),
        cmocka_unit_test(every_limit_of_a_calibration_holds),
        cmocka_unit_test(elevations_out_of_order_are_refused),
        cmocka_unit_test(bits_are_a_sequence),
        cmocka_unit_test(every_limit_of_a_profile_holds),
        cmocka_unit_test(words_are_those_of_the_table),
        cmocka_unit_test(a_profile_needs_a_version),
        cmocka_unit_test(what_the_core_refuses_bears_the_line_of_its_key),
        cmocka_unit_test(decimals_become_the_nearest_integers),
        cmocka_unit_test(numbers_beyond_64_bits_are_too_large),
        cmocka_unit_test(numbers_are_shown_without_idle_zeros),
        cmocka_unit_test(what_keys_write_reads_back_exactly),
        cmocka_unit_test(the_locale_changes_nothing),
        cmocka_unit_test(other_spellings_of_yaml_are_understood),
        cmocka_unit_test(deep_and_long_texts_are_refused_at_once),
        cmocka_unit_test(the_size_limit_is_exact),
        cmocka_unit_test(files_that_cannot_be_read_are_refused),
        cmocka_unit_test(a_huge_file_is_refused_without_reading_it),
        cmocka_unit_test(a_fault_in_a_file_names_the_file),
        cmocka_unit_test(a_dash_is_standard_input),
        cmocka_unit_test(every_prefix_of_the_sample_files_is_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
