#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/host/keys.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

#define OFFSET "an offset from 8 to 64"
#define WIDTH  "1, 2, 4 or 8"
#define BITS   "all, or [LOW, HIGH], both included, 0 to 63"
#define TYPES  "0 to 255, but not 5, 6 or 7 (set IP, timestamp, TLV)"

/* --- What a key is --- */

/* Of the keys in order. */
static const struct {
    const char *name;
    lum_key_kind kind;
    const char *min;
    const char *max;
    const char *allowed;
    const char *usual;
} rows[] = {
    {"version", LUM_KEY_WHOLE, "1", "1", "1", "1"},
    {"data_packet_type", LUM_KEY_WHOLE, "0", "255", TYPES, "8"},
    {"set_ip_order", LUM_KEY_WORD, "", "", "network or little", "network"},
    {"group.tag", LUM_KEY_WHOLE, "8", "64", OFFSET, "12"},
    {"group.tag.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "12"},
    {"group.tag.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "1"},
    {"group.tag.order", LUM_KEY_WORD, "", "", "little or big", "little"},
    {"group.tag.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]", "[63, 63]", BITS, "all"},
    {"group.eye", LUM_KEY_WHOLE, "8", "64", OFFSET, "13"},
    {"group.eye.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "13"},
    {"group.eye.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "1"},
    {"group.eye.order", LUM_KEY_WORD, "", "", "little or big", "little"},
    {"group.eye.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]", "[63, 63]", BITS, "all"},
    {"group.line", LUM_KEY_WHOLE, "8", "64", OFFSET, "14"},
    {"group.line.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "14"},
    {"group.line.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "2"},
    {"group.line.order", LUM_KEY_WORD, "", "", "little or big", "little"},
    {"group.line.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]", "[63, 63]", BITS,
     "all"},
    {"group.num_samples", LUM_KEY_WORD_OR_WHOLE, "8", "64", "none, or " OFFSET,
     "16"},
    {"group.num_samples.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "16"},
    {"group.num_samples.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "2"},
    {"group.num_samples.order", LUM_KEY_WORD, "", "", "little or big",
     "little"},
    {"group.num_samples.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]", "[63, 63]", BITS,
     "all"},
    {"group.first_sample_index", LUM_KEY_WHOLE, "8", "64", OFFSET, "18"},
    {"group.first_sample_index.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "18"},
    {"group.first_sample_index.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "2"},
    {"group.first_sample_index.order", LUM_KEY_WORD, "", "", "little or big",
     "little"},
    {"group.first_sample_index.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]",
     "[63, 63]", BITS, "all"},
    {"group.timestamp", LUM_KEY_WORD_OR_WHOLE, "8", "64", "none, or " OFFSET,
     "20"},
    {"group.timestamp.at", LUM_KEY_WHOLE, "8", "64", OFFSET, "20"},
    {"group.timestamp.bytes", LUM_KEY_WHOLE, "1", "8", WIDTH, "4"},
    {"group.timestamp.order", LUM_KEY_WORD, "", "", "little or big", "little"},
    {"group.timestamp.bits", LUM_KEY_WORD_OR_PAIR, "[0, 0]", "[63, 63]", BITS,
     "all"},
    {"group.timestamp.unit_ns", LUM_KEY_WHOLE, "1", "1000000000",
     "1 to 1000000000 ns", "1000"},
    {"group.samples", LUM_KEY_WHOLE, "8", "64", OFFSET, "24"},
    {"eye_values.blue", LUM_KEY_WHOLE, "0", "4294967295", "0 to 4294967295",
     "0"},
    {"eye_values.green", LUM_KEY_WHOLE, "0", "4294967295", "0 to 4294967295",
     "1"},
    {"angle_order", LUM_KEY_WORD, "", "",
     "azimuth_elevation or elevation_azimuth", "azimuth_elevation"},
    {"sample_order", LUM_KEY_WORD, "", "", "little or big", "little"},
    {"angle_lsb_deg", LUM_KEY_WORD_OR_DECIMAL, "0.000000000001", "1",
     "span, or above 0, at most 1 deg", "span"},
    {"tlv.command", LUM_KEY_WHOLE, "0", "65535", "0 to 65535", "1"},
    {"tlv.status", LUM_KEY_WHOLE, "0", "65535", "0 to 65535", "2"},
    {"tlv.debug", LUM_KEY_WHOLE, "0", "65535", "0 to 65535", "3"},
    {"tlv.yscan", LUM_KEY_WHOLE, "0", "65535", "0 to 65535", "4"},
    {"line_span_us", LUM_KEY_WHOLE, "0", "1000000000", "0 to 1000000000 us",
     "2000"},
};

static void every_key_of_a_profile_is_described(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key key;
    lum_keys_of_profile(&keys, NULL);
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(lum_keys_describe(&keys, i, &key), LUM_OK);
        assert_string_equal(key.name, rows[i].name);
        assert_int_equal(key.kind, rows[i].kind);
        assert_string_equal(key.min, rows[i].min);
        assert_string_equal(key.max, rows[i].max);
        assert_string_equal(key.allowed, rows[i].allowed);
        assert_string_equal(key.usual, rows[i].usual);
    }
    assert_int_equal(lum_keys_describe(&keys, COUNT(rows), &key), LUM_E_VALUE);
}

static void words_and_units_are_told(void **state)
{
    (void)state;
    lum_keys keys;
    lum_key key;
    lum_keys_of_profile(&keys, NULL);
    for (size_t i = 0; lum_keys_describe(&keys, i, &key) == LUM_OK; i++) {
        const bool is_lsb = strcmp(key.name, "angle_lsb_deg") == 0;
        const bool is_span = strcmp(key.name, "line_span_us") == 0;
        const bool is_tick = strcmp(key.name, "group.timestamp.unit_ns") == 0;
        assert_string_equal(key.unit, is_lsb    ? "deg"
                                      : is_span ? "us"
                                      : is_tick ? "ns"
                                                : "");
        if (strcmp(key.name, "set_ip_order") == 0) {
            assert_string_equal(key.words[0], "network");
            assert_string_equal(key.words[1], "little");
            assert_null(key.words[2]);
        } else if (key.kind == LUM_KEY_WORD_OR_WHOLE) {
            assert_string_equal(key.words[0], "none");
            assert_null(key.words[1]);
        } else if (key.kind == LUM_KEY_WHOLE) {
            assert_null(key.words[0]);
        }
    }
}

/* --- Values and fields --- */

static void set(lum_keys *keys, const char *key, const char *value,
                uint32_t place)
{
    lum_key_refusal why;
    if (lum_keys_set(keys, key, value, place, &why) != LUM_OK) {
        fail_msg("%s=%s: %s", key, value, why.text);
    }
}

static void take(const lum_keys *keys, lum_profile *out)
{
    lum_key_refusal why;
    if (lum_keys_profile(keys, out, &why) != LUM_OK) {
        fail_msg("%s: %s", why.key, why.text);
    }
}

static void assert_same(const lum_profile *a, const lum_profile *b)
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

/* A profile that differs from the default in everything. */
static lum_profile other_profile(void)
{
    return (lum_profile){
        .data_packet_type = 3,
        .group = {{44, 2, LUM_ORDER_BIG, 1, 15},
                  {40, 4, LUM_ORDER_BIG, 24, 8},
                  {36, 4, LUM_ORDER_BIG, 0, 31},
                  {32, 1, LUM_ORDER_BIG, 0, 8},
                  {30, 1, LUM_ORDER_BIG, 2, 3},
                  {16, 8, LUM_ORDER_BIG, 1, 63}},
        .samples_at = 50,
        .set_ip_order = LUM_SET_IP_LITTLE,
        .angle_order = LUM_ELEVATION_AZIMUTH,
        .eye_values = {66, 71},
        .tlv = {11, 12, 13, 14},
        .angle_lsb_pdeg = 500000001,
        .line_span_us = 1999,
        .clock_unit_ns = 999999999,
        .sample_order = LUM_ORDER_BIG,
    };
}

static void a_start_comes_back_field_by_field(void **state)
{
    (void)state;
    const lum_profile start = other_profile();
    lum_profile p;
    lum_keys keys;
    lum_keys_of_profile(&keys, &start);
    take(&keys, &p);
    assert_same(&p, &start);
}

/* Whatever the order of its bytes is. */
static void bits_of_a_start_are_all_or_a_pair(void **state)
{
    lum_profile start;
    lum_keys keys;
    char text[LUM_KEY_VALUE_BYTES];
    (void)state;
    lum_profile_default(&start);
    start.group[LUM_FIELD_EYE].bits = 8;
    start.group[LUM_FIELD_LINE].order = LUM_ORDER_BIG;
    lum_keys_of_profile(&keys, &start);
    assert_int_equal(lum_keys_get(&keys, "group.eye.bits", text), LUM_OK);
    assert_string_equal(text, "[0, 7]");
    assert_int_equal(lum_keys_get(&keys, "group.line.bits", text), LUM_OK);
    assert_string_equal(text, "all");
}

static void each_key_reaches_its_field(void **state)
{
    (void)state;
    static const char *const values[][2] = {
        {"data_packet_type", "3"},
        {"set_ip_order", "little"},
        {"group.tag", "44"},
        {"group.tag.bytes", "2"},
        {"group.eye.at", "40"},
        {"group.eye.bytes", "4"},
        {"group.line", "36"},
        {"group.line.bytes", "4"},
        {"group.num_samples.at", "32"},
        {"group.num_samples.bytes", "1"},
        {"group.first_sample_index", "30"},
        {"group.first_sample_index.bytes", "1"},
        {"group.timestamp", "16"},
        {"group.timestamp.bytes", "8"},
        {"group.tag.order", "big"},
        {"group.tag.bits", "[1, 15]"},
        {"group.eye.order", "big"},
        {"group.eye.bits", "[24, 31]"},
        {"group.line.order", "big"},
        {"group.line.bits", "[0, 30]"},
        {"group.num_samples.order", "big"},
        {"group.num_samples.bits", "[0, 7]"},
        {"group.first_sample_index.order", "big"},
        {"group.first_sample_index.bits", "[2, 4]"},
        {"group.timestamp.order", "big"},
        {"group.timestamp.bits", "[1, 63]"},
        {"group.timestamp.unit_ns", "999999999"},
        {"sample_order", "big"},
        {"group.samples", "50"},
        {"eye_values.blue", "66"},
        {"eye_values.green", "71"},
        {"angle_order", "elevation_azimuth"},
        {"angle_lsb_deg", "0.000500000001"},
        {"tlv.command", "11"},
        {"tlv.status", "12"},
        {"tlv.debug", "13"},
        {"tlv.yscan", "14"},
        {"line_span_us", "1999"},
    };
    const lum_profile expected = other_profile();
    lum_profile p;
    lum_keys keys;
    char text[LUM_KEY_VALUE_BYTES];
    lum_keys_of_profile(&keys, NULL);
    for (size_t i = 0; i < COUNT(values); i++) {
        set(&keys, values[i][0], values[i][1], 1);
    }
    take(&keys, &p);
    assert_same(&p, &expected);
    for (size_t i = 0; i < COUNT(values); i++) {
        assert_int_equal(lum_keys_get(&keys, values[i][0], text), LUM_OK);
        assert_string_equal(text, values[i][1]);
    }
}

/* A width that a field without bytes had is none. */
static void a_field_that_was_none_gets_its_usual_width(void **state)
{
    (void)state;
    lum_profile start;
    lum_profile p;
    lum_keys keys;
    lum_profile_default(&start);
    start.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 30, .bytes = 0};
    lum_keys_of_profile(&keys, &start);
    take(&keys, &p);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].at, 0);
    set(&keys, "group.timestamp", "20", 1);
    take(&keys, &p);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].at, 20);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].bytes, 4);
}

static void each_order_is_its_own(void **state)
{
    (void)state;
    lum_profile start;
    lum_profile p;
    lum_keys keys;
    lum_profile_default(&start);
    start.set_ip_order = LUM_SET_IP_LITTLE;
    lum_keys_of_profile(&keys, &start);
    take(&keys, &p);
    assert_same(&p, &start);
    lum_keys_of_profile(&keys, NULL);
    set(&keys, "angle_order", "elevation_azimuth", 1);
    take(&keys, &p);
    assert_int_equal(p.set_ip_order, LUM_SET_IP_NETWORK);
    assert_int_equal(p.angle_order, LUM_ELEVATION_AZIMUTH);
}

static void words_go_there_and_back(void **state)
{
    (void)state;
    const lum_profile start = other_profile();
    lum_profile p;
    lum_keys keys;
    lum_keys_of_profile(&keys, &start);
    set(&keys, "set_ip_order", "network", 1);
    set(&keys, "angle_order", "azimuth_elevation", 1);
    set(&keys, "angle_lsb_deg", "span", 1);
    set(&keys, "group.timestamp", "none", 1);
    take(&keys, &p);
    assert_int_equal(p.set_ip_order, LUM_SET_IP_NETWORK);
    assert_int_equal(p.angle_order, LUM_AZIMUTH_ELEVATION);
    assert_true(p.angle_lsb_pdeg == 0);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].at, 0);
    assert_int_equal(p.group[LUM_FIELD_TIMESTAMP].bytes, 0);
    assert_int_equal(p.group[LUM_FIELD_TAG].at, 44);
}

/* --- Profiles that are refused --- */

struct change {
    const char *key;
    const char *value;
    uint32_t place;
};

static void assert_blamed(const lum_keys *keys, const char *key, uint32_t place,
                          const char *says)
{
    lum_profile p;
    lum_profile untouched;
    lum_key_refusal why;
    memset(&p, 0x5a, sizeof p);
    untouched = p;
    assert_int_equal(lum_keys_profile(keys, &p, &why), LUM_E_VALUE);
    assert_string_equal(why.text, says);
    assert_string_equal(why.key, key);
    assert_int_equal(why.place, place);
    assert_memory_equal(&p, &untouched, sizeof p);
    assert_int_equal(lum_keys_profile(keys, &p, NULL), LUM_E_VALUE);
}

/* Of the changes up to one without a key, made to the default. */
static void assert_refused(const struct change *changes, const char *key,
                           uint32_t place, const char *says)
{
    lum_keys keys;
    lum_keys_of_profile(&keys, NULL);
    for (const struct change *c = changes; c->key != NULL; c++) {
        set(&keys, c->key, c->value, c->place);
    }
    assert_blamed(&keys, key, place, says);
}

#define REFUSED(key, place, says, ...)                                         \
    assert_refused((const struct change[]){__VA_ARGS__, {NULL, NULL, 0}}, key, \
                   place, says)

static void types_of_other_packets_are_refused(void **state)
{
    (void)state;
    REFUSED("data_packet_type", 2,
            "5 is the type of other packets; allowed: " TYPES,
            {"data_packet_type", "5", 2});
    REFUSED("data_packet_type", 9,
            "7 is the type of other packets; allowed: " TYPES,
            {"data_packet_type", "7", 9});
}

static void three_bytes_are_no_width(void **state)
{
    (void)state;
    static const char *const widths[] = {"group.tag.bytes",
                                         "group.eye.bytes",
                                         "group.line.bytes",
                                         "group.num_samples.bytes",
                                         "group.first_sample_index.bytes",
                                         "group.timestamp.bytes"};
    static const char *const offsets[] = {"group.tag",
                                          "group.eye",
                                          "group.line",
                                          "group.num_samples",
                                          "group.first_sample_index",
                                          "group.timestamp"};
    for (size_t i = 0; i < COUNT(widths); i++) {
        REFUSED(widths[i], 5, "no field has 3 bytes; allowed: " WIDTH,
                {offsets[i], "60", 4}, {widths[i], "3", 5});
    }
}

/* As it is, and not as it would be if its offset were set. */
static void a_start_without_a_field_is_refused_as_it_is(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile start;
    lum_profile_default(&start);
    start.group[LUM_FIELD_LINE].bytes = 0;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "group.line.bytes", 0,
                  "no field has 0 bytes; allowed: " WIDTH);
}

static void fields_on_the_type_are_refused(void **state)
{
    (void)state;
    REFUSED("group.eye", 3,
            "11 lies on the packet type (bytes 8 to 11); allowed: 12 to 64, "
            "or 8 for group.tag alone",
            {"group.eye", "11", 3});
    REFUSED("group.tag", 4,
            "9 lies on the packet type (bytes 8 to 11); allowed: 12 to 64, or "
            "8 for group.tag alone",
            {"group.tag", "9", 4});
}

#define TYPE                                                                   \
    "at 8 it is the packet type; allowed: 1 byte, or order little, with all "  \
    "bits or 2 and more from bit 0 on"

/* The type is 2 or 3, and so is the field. */
static void a_tag_at_8_is_the_type(void **state)
{
    static const char *const fine[][3] = {
        {"1", "little", "all"},    {"1", "big", "all"},
        {"2", "little", "all"},    {"1", "little", "[0, 1]"},
        {"2", "little", "[0, 9]"}, {"1", "big", "[0, 7]"}};
    (void)state;
    for (size_t i = 0; i < COUNT(fine); i++) {
        lum_keys keys;
        lum_profile p;
        lum_keys_of_profile(&keys, NULL);
        set(&keys, "group.tag", "8", 1);
        set(&keys, "group.tag.bytes", fine[i][0], 1);
        set(&keys, "group.tag.order", fine[i][1], 1);
        set(&keys, "group.tag.bits", fine[i][2], 1);
        take(&keys, &p);
        assert_int_equal(p.group[LUM_FIELD_TAG].at, 8);
    }
    REFUSED("group.tag", 5, TYPE, {"group.tag", "8", 4},
            {"group.tag.bits", "[4, 7]", 5});
    REFUSED("group.tag", 5, TYPE, {"group.tag", "8", 4},
            {"group.tag.bits", "[1, 7]", 5});
    REFUSED("group.tag", 5, TYPE, {"group.tag", "8", 4},
            {"group.tag.bits", "[0, 0]", 5});
    REFUSED("group.tag", 6, TYPE, {"group.tag", "8", 4},
            {"group.tag.bytes", "2", 5}, {"group.tag.order", "big", 6});
}

#define SHARE "; fields must not share bytes, unless both name bits"

static void fields_that_overlap_name_each_other(void **state)
{
    (void)state;
    REFUSED("group.eye", 3,
            "bytes 12 to 12 overlap group.tag, 12 to 12 (the default)" SHARE,
            {"group.eye", "12", 3});
    REFUSED("group.timestamp", 3,
            "bytes 19 to 22 overlap group.first_sample_index, 18 to 19 (the "
            "default)" SHARE,
            {"group.timestamp", "19", 3});
    REFUSED("group.timestamp", 3,
            "bytes 17 to 20 overlap group.num_samples, 16 to 17" SHARE,
            {"group.num_samples", "16", 2}, {"group.timestamp", "17", 3});
    REFUSED("group.num_samples", 4,
            "bytes 13 to 16 overlap group.eye, 13 to 13 (the default)" SHARE,
            {"group.num_samples.at", "13", 4},
            {"group.num_samples.bytes", "4", 3});
}

/* The first of the fields before it that shares a byte, be it the last. */
static void fields_that_do_not_overlap_are_not_named(void **state)
{
    (void)state;
    REFUSED("group.timestamp", 3,
            "bytes 15 to 18 overlap group.line, 14 to 15 (the default)" SHARE,
            {"group.tag", "40", 2}, {"group.timestamp", "15", 3});
    REFUSED("group.line", 3, "bytes 14 to 15 overlap group.tag, 15 to 15" SHARE,
            {"group.tag", "15", 2}, {"group.line", "14", 3});
    REFUSED("group.line", 3, "bytes 14 to 15 overlap group.tag, 14 to 14" SHARE,
            {"group.tag", "14", 2}, {"group.line", "14", 3});
    REFUSED("group.line", 3, "bytes 15 to 16 overlap group.tag, 14 to 15" SHARE,
            {"group.tag", "14", 2}, {"group.tag.bytes", "2", 2},
            {"group.line", "15", 3});
}

/* The later one is wrong in order, the earlier one was set. */
static void of_fields_that_overlap_the_one_that_was_set_is_blamed(void **state)
{
    (void)state;
    REFUSED(
        "group.tag", 7,
        "bytes 20 to 20 overlap group.timestamp, 20 to 23 (the default)" SHARE,
        {"group.tag", "20", 7});
    REFUSED("group.line", 8,
            "bytes 14 to 17 overlap group.num_samples, 16 to 17 (the "
            "default)" SHARE,
            {"group.line.bytes", "4", 8});
}

/* Its offset's or its width's place, the later of the two. */
static void a_field_is_of_the_line_that_changed_it_last(void **state)
{
    (void)state;
    REFUSED("group.line", 9,
            "bytes 14 to 17 overlap group.num_samples, 16 to 17 (the "
            "default)" SHARE,
            {"group.line.at", "14", 6}, {"group.line.bytes", "4", 9});
    REFUSED("group.line", 6,
            "bytes 14 to 17 overlap group.num_samples, 16 to 17 (the "
            "default)" SHARE,
            {"group.line.at", "14", 6}, {"group.line.bytes", "4", 5});
}

#define BEHIND "; samples come after all fields"

static void bits_that_are_shared_are_refused(void **state)
{
    (void)state;
    REFUSED("group.eye", 6,
            "bytes 12 to 12 overlap group.tag, 12 to 12; fields that share "
            "bytes must both name bits",
            {"group.tag.bits", "[0, 3]", 5}, {"group.eye", "12", 6});
    REFUSED("group.eye", 7,
            "bytes 12 to 12 overlap group.tag, 12 to 12; fields must not share "
            "a bit",
            {"group.tag.bits", "[0, 3]", 5}, {"group.eye", "12", 6},
            {"group.eye.bits", "[3, 7]", 7});
    REFUSED("group.line", 7,
            "bytes 13 to 14 overlap group.eye, 13 to 13; fields that share "
            "bytes must have the same at, bytes and order",
            {"group.eye.bits", "[0, 0]", 5}, {"group.line", "13", 6},
            {"group.line.bits", "[1, 9]", 7});
    REFUSED("group.eye", 7,
            "bytes 12 to 12 overlap group.tag, 12 to 12 (the default); fields "
            "that share bytes must both name bits",
            {"group.eye", "12", 6}, {"group.eye.bits", "[3, 7]", 7});
}

#define SAME "; fields that share bytes must have the same at, bytes and order"

static void bits_of_other_bytes_are_refused(void **state)
{
    (void)state;
    REFUSED("group.line", 7, "bytes 14 to 15 overlap group.eye, 13 to 14" SAME,
            {"group.eye.bytes", "2", 5}, {"group.eye.bits", "[0, 0]", 5},
            {"group.line.bits", "[1, 9]", 7});
    REFUSED("group.line", 7, "bytes 13 to 14 overlap group.eye, 13 to 14" SAME,
            {"group.eye.bytes", "2", 5}, {"group.eye.bits", "[0, 0]", 5},
            {"group.line", "13", 6}, {"group.line.bits", "[1, 9]", 6},
            {"group.line.order", "big", 7});
}

/* Other bits of the same bytes may be below or above. */
static void fields_whose_bits_are_apart_are_not_named(void **state)
{
    (void)state;
    REFUSED("group.line", 7,
            "bytes 12 to 12 overlap group.eye, 12 to 12; fields must not share "
            "a bit",
            {"group.tag.bits", "[0, 3]", 1}, {"group.eye", "12", 2},
            {"group.eye.bits", "[4, 5]", 3}, {"group.line", "12", 4},
            {"group.line.bytes", "1", 6}, {"group.line.bits", "[5, 6]", 7});
    REFUSED("group.line", 7,
            "bytes 12 to 12 overlap group.eye, 12 to 12; fields must not share "
            "a bit",
            {"group.tag.bits", "[6, 7]", 1}, {"group.eye", "12", 2},
            {"group.eye.bits", "[0, 1]", 3}, {"group.line", "12", 4},
            {"group.line.bytes", "1", 6}, {"group.line.bits", "[1, 5]", 7});
    REFUSED("group.line", 7,
            "bytes 12 to 12 overlap group.tag, 12 to 12; fields must not share "
            "a bit",
            {"group.tag.bits", "[0, 3]", 1}, {"group.line", "12", 4},
            {"group.line.bytes", "1", 6}, {"group.line.bits", "[3, 6]", 7});
}

/* The line's bits begin where the tag's end, and the eye's are among them; then
 * the tag's are. */
static void bits_that_touch_are_apart(void **state)
{
    (void)state;
    REFUSED("group.line", 7,
            "bytes 12 to 13 overlap group.eye, 12 to 13; fields must not share "
            "a bit",
            {"group.tag.bytes", "2", 1}, {"group.tag.bits", "[0, 0]", 1},
            {"group.eye", "12", 2}, {"group.eye.bytes", "2", 2},
            {"group.eye.bits", "[9, 9]", 3}, {"group.line", "12", 4},
            {"group.line.bits", "[1, 9]", 7});
    REFUSED("group.line", 7,
            "bytes 12 to 13 overlap group.tag, 12 to 13; fields must not share "
            "a bit",
            {"group.tag.bytes", "2", 1}, {"group.tag.bits", "[3, 3]", 1},
            {"group.eye", "20", 2}, {"group.timestamp", "none", 2},
            {"group.line", "12", 4}, {"group.line.bits", "[1, 9]", 7});
}

/* It has a place, but no bytes. */
static void a_field_that_is_none_is_not_named(void **state)
{
    (void)state;
    REFUSED("group.timestamp", 3,
            "bytes 16 to 19 overlap group.first_sample_index, 18 to 19 (the "
            "default)" SHARE,
            {"group.num_samples", "none", 2}, {"group.timestamp", "16", 3});
    REFUSED("group.timestamp", 3,
            "bytes 16 to 19 overlap group.first_sample_index, 18 to 19" SHARE,
            {"group.num_samples", "none", 2},
            {"group.first_sample_index", "18", 2},
            {"group.timestamp", "16", 3});
}

#define NOT_NONE "; give it an offset too, or leave this out"

/* In either order. */
static void what_is_said_of_a_field_that_is_none_is_refused(void **state)
{
    (void)state;
    REFUSED("group.timestamp.unit_ns", 3, "group.timestamp is none" NOT_NONE,
            {"group.timestamp", "none", 2},
            {"group.timestamp.unit_ns", "100", 3});
    REFUSED("group.timestamp.unit_ns", 2, "group.timestamp is none" NOT_NONE,
            {"group.timestamp.unit_ns", "1000", 2},
            {"group.timestamp", "none", 3});
    REFUSED("group.timestamp.bits", 3, "group.timestamp is none" NOT_NONE,
            {"group.timestamp", "none", 2},
            {"group.timestamp.bits", "[0, 7]", 3});
    REFUSED("group.num_samples.bytes", 3, "group.num_samples is none" NOT_NONE,
            {"group.num_samples", "none", 2},
            {"group.num_samples.bytes", "1", 3});
    REFUSED("group.num_samples.order", 3, "group.num_samples is none" NOT_NONE,
            {"group.num_samples", "none", 2},
            {"group.num_samples.order", "big", 3});
}

static void a_field_that_was_none_needs_an_offset(void **state)
{
    (void)state;
    lum_profile start;
    lum_profile p;
    lum_keys keys;
    lum_profile_default(&start);
    start.group[LUM_FIELD_TIMESTAMP].bytes = 0;
    lum_keys_of_profile(&keys, &start);
    set(&keys, "group.timestamp.unit_ns", "100", 1);
    assert_blamed(&keys, "group.timestamp.unit_ns", 1,
                  "group.timestamp is none (as it was)" NOT_NONE);
    set(&keys, "group.timestamp", "20", 2);
    take(&keys, &p);
    assert_int_equal(p.clock_unit_ns, 100);
}

static void bits_that_a_width_has_not_are_refused(void **state)
{
    (void)state;
    REFUSED("group.line.bits", 5,
            "bit 16 is not one of group.line.bytes, 2; allowed: 0 to 15",
            {"group.line.bits", "[16, 16]", 5});
    REFUSED("group.line.bits", 6,
            "bit 15 is not one of group.line.bytes, 1; allowed: 0 to 7",
            {"group.line.bits", "[8, 15]", 5}, {"group.line.bytes", "1", 6});
    REFUSED("eye_values.green", 6,
            "4 does not fit group.eye, 2 bits wide; allowed: 0 to 3",
            {"group.eye.bits", "[6, 7]", 5}, {"eye_values.green", "4", 6});
    REFUSED("eye_values.green", 6,
            "2 does not fit group.eye, 1 bit wide; allowed: 0 to 1",
            {"group.eye.bits", "[7, 7]", 5}, {"eye_values.green", "2", 6});
}

static void assert_no_pair(const char *value, const char *says)
{
    lum_keys keys;
    lum_key_refusal why;
    char text[LUM_KEY_MESSAGE_BYTES];
    lum_keys_of_profile(&keys, NULL);
    assert_int_equal(lum_keys_set(&keys, "group.line.bits", value, 1, &why),
                     LUM_E_VALUE);
    (void)snprintf(text, sizeof text, "'%s' %s; allowed: " BITS, value, says);
    assert_string_equal(why.text, text);
}

static void pairs_are_read_as_they_are_written(void **state)
{
    static const char *const none[] = {
        "",       "3",        "[",         "[]",      "[1]",      "[1, 2",
        "1, 2]",  "[1, 2, 3", "[1, 2, 3]", "[1, 2]x", "[1.5, 2]", "[a, b]",
        "[1; 2]", "[, 2]",    "[1, ]",     "[1 , 2]", "some"};
    lum_keys keys;
    char text[LUM_KEY_VALUE_BYTES];
    (void)state;
    for (size_t i = 0; i < COUNT(none); i++) {
        assert_no_pair(none[i], "is not [LOW, HIGH], two whole numbers");
    }
    assert_no_pair("[0, 64]", "is out of range");
    assert_no_pair("[64, 64]", "is out of range");
    assert_no_pair("[-1, 0]", "is out of range");
    assert_no_pair("[3, 2]", "has the higher number first");
    lum_keys_of_profile(&keys, NULL);
    set(&keys, "group.line.bits", "[0,14]", 1);
    assert_int_equal(lum_keys_get(&keys, "group.line.bits", text), LUM_OK);
    assert_string_equal(text, "[0, 14]");
    set(&keys, "group.line.bits", "all", 1);
    assert_int_equal(lum_keys_get(&keys, "group.line.bits", text), LUM_OK);
    assert_string_equal(text, "all");
}

/* A tick's length belongs to a clock. */
static void what_is_none_has_nothing_to_keep(void **state)
{
    lum_keys keys;
    lum_profile p;
    lum_profile start;
    (void)state;
    lum_profile_default(&start);
    start.group[LUM_FIELD_TIMESTAMP].bytes = 0;
    start.group[LUM_FIELD_NUM_SAMPLES].bytes = 0;
    start.clock_unit_ns = 7;
    lum_keys_of_profile(&keys, &start);
    take(&keys, &p);
    assert_int_equal(p.clock_unit_ns, 1000);
    assert_int_equal(p.group[LUM_FIELD_NUM_SAMPLES].bytes, 0);
    set(&keys, "group.num_samples", "16", 1);
    take(&keys, &p);
    assert_int_equal(p.group[LUM_FIELD_NUM_SAMPLES].bytes, 2);
}

static void samples_before_a_field_are_refused(void **state)
{
    (void)state;
    REFUSED("group.samples", 5,
            "23 is not behind group.timestamp, which ends with byte 23 (the "
            "default)" BEHIND,
            {"group.samples", "23", 5});
    REFUSED("group.samples", 5,
            "23 is not behind group.tag, which ends with byte 40" BEHIND,
            {"group.samples", "23", 5}, {"group.tag", "40", 6});
    REFUSED("group.tag", 6,
            "ends with byte 40, but group.samples is 24 (the default)" BEHIND,
            {"group.tag", "40", 6});
}

static void eye_values_fit_their_field(void **state)
{
    (void)state;
    REFUSED("eye_values.green", 2,
            "256 does not fit group.eye, 1 byte wide; allowed: 0 to 255",
            {"eye_values.green", "256", 2});
    REFUSED("eye_values.blue", 2,
            "65536 does not fit group.eye, 2 bytes wide; allowed: 0 to 65535",
            {"eye_values.blue", "65536", 2}, {"group.eye", "30", 3},
            {"group.eye.bytes", "2", 3}, {"group.samples", "32", 3});
}

static void eye_values_differ(void **state)
{
    (void)state;
    REFUSED("eye_values.blue", 4,
            "1 is the value of eye_values.green (the default); they must "
            "differ",
            {"eye_values.blue", "1", 4});
    REFUSED("eye_values.green", 5,
            "0 is the value of eye_values.blue (the default); they must "
            "differ",
            {"eye_values.green", "0", 5});
    REFUSED("eye_values.green", 5,
            "9 is the value of eye_values.blue; they must differ",
            {"eye_values.blue", "9", 4}, {"eye_values.green", "9", 5});
}

static void tlv_numbers_differ(void **state)
{
    (void)state;
    REFUSED("tlv.status", 3,
            "1 is the value of tlv.command (the default); they must differ",
            {"tlv.status", "1", 3});
    REFUSED("tlv.command", 3,
            "2 is the value of tlv.status (the default); they must differ",
            {"tlv.command", "2", 3});
    REFUSED("tlv.yscan", 3,
            "3 is the value of tlv.debug (the default); they must differ",
            {"tlv.yscan", "3", 3});
    REFUSED("tlv.yscan", 4, "9 is the value of tlv.status; they must differ",
            {"tlv.status", "9", 3}, {"tlv.yscan", "9", 4});
    REFUSED("tlv.debug", 3,
            "4 is the value of tlv.yscan (the default); they must differ",
            {"tlv.debug", "4", 3});
}

static void a_start_that_no_key_allows_is_of_none(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile start;
    lum_profile_default(&start);
    start.group[LUM_FIELD_TAG].at = 7;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "", 0, "refused: fault 2 of the profile");
    lum_profile_default(&start);
    start.angle_lsb_pdeg = LUM_ANGLE_LSB_MAX_PDEG + 1;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "", 0, "refused: fault 12 of the profile");
    lum_profile_default(&start);
    start.line_span_us = LUM_LINE_SPAN_MAX_US + 1;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "", 0, "refused: fault 13 of the profile");
    lum_profile_default(&start);
    start.clock_unit_ns = 0;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "", 0, "refused: fault 17 of the profile");
    lum_profile_default(&start);
    start.sample_order = LUM_ORDER_BIG + 1;
    lum_keys_of_profile(&keys, &start);
    assert_blamed(&keys, "", 0, "refused: fault 16 of the profile");
}

static void what_a_start_has_is_told_as_it_was(void **state)
{
    (void)state;
    lum_keys keys;
    const lum_profile start = other_profile();
    lum_keys_of_profile(&keys, &start);
    set(&keys, "group.samples", "40", 3);
    assert_blamed(&keys, "group.samples", 3,
                  "40 is not behind group.tag, which ends with byte 45 (as it "
                  "was)" BEHIND);
}

static void keys_of_a_calibration_give_no_profile(void **state)
{
    (void)state;
    lum_keys keys;
    lum_profile p;
    lum_key_refusal why;
    lum_keys_of_calibration(&keys, NULL);
    assert_int_equal(lum_keys_profile(&keys, &p, &why), LUM_E_TYPE);
    assert_string_equal(why.text, "these are keys of a calibration");
    assert_string_equal(why.key, "");
    assert_int_equal(why.place, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_of_a_profile_is_described),
        cmocka_unit_test(words_and_units_are_told),
        cmocka_unit_test(a_start_comes_back_field_by_field),
        cmocka_unit_test(bits_of_a_start_are_all_or_a_pair),
        cmocka_unit_test(each_key_reaches_its_field),
        cmocka_unit_test(a_field_that_was_none_gets_its_usual_width),
        cmocka_unit_test(each_order_is_its_own),
        cmocka_unit_test(words_go_there_and_back),
        cmocka_unit_test(types_of_other_packets_are_refused),
        cmocka_unit_test(three_bytes_are_no_width),
        cmocka_unit_test(a_start_without_a_field_is_refused_as_it_is),
        cmocka_unit_test(fields_on_the_type_are_refused),
        cmocka_unit_test(a_tag_at_8_is_the_type),
        cmocka_unit_test(fields_that_overlap_name_each_other),
        cmocka_unit_test(fields_that_do_not_overlap_are_not_named),
        cmocka_unit_test(of_fields_that_overlap_the_one_that_was_set_is_blamed),
        cmocka_unit_test(a_field_is_of_the_line_that_changed_it_last),
        cmocka_unit_test(bits_that_are_shared_are_refused),
        cmocka_unit_test(bits_of_other_bytes_are_refused),
        cmocka_unit_test(fields_whose_bits_are_apart_are_not_named),
        cmocka_unit_test(bits_that_touch_are_apart),
        cmocka_unit_test(a_field_that_is_none_is_not_named),
        cmocka_unit_test(what_is_said_of_a_field_that_is_none_is_refused),
        cmocka_unit_test(a_field_that_was_none_needs_an_offset),
        cmocka_unit_test(bits_that_a_width_has_not_are_refused),
        cmocka_unit_test(pairs_are_read_as_they_are_written),
        cmocka_unit_test(what_is_none_has_nothing_to_keep),
        cmocka_unit_test(samples_before_a_field_are_refused),
        cmocka_unit_test(eye_values_fit_their_field),
        cmocka_unit_test(eye_values_differ),
        cmocka_unit_test(tlv_numbers_differ),
        cmocka_unit_test(a_start_that_no_key_allows_is_of_none),
        cmocka_unit_test(what_a_start_has_is_told_as_it_was),
        cmocka_unit_test(keys_of_a_calibration_give_no_profile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
