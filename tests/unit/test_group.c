#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC 0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12

/* Two angles of green's line 0x0203 from pixel 0x0104 on. */
static const uint8_t angles[] = {
    MAGIC, 8,    0,    0,    0,    2,    1, 3,    2, 2, 0,    4,   1,
    0x78,  0x56, 0x34, 0x92, 0xff, 0x7f, 0, 0x80, 1, 0, 0xff, 0xff};
/* One word of blue's line 7: index 5, tof -1, rising, pixel 999. */
static const uint8_t ranges[] = {MAGIC, 8, 0, 0, 0, 3, 0,    7,    0,    1,   0,
                                 5,     0, 1, 0, 0, 0, 0xe7, 0xf7, 0xff, 0xff};

static lum_layout standard(void)
{
    lum_layout layout;
    lum_layout_default(&layout);
    return layout;
}

static lum_layout checked(const lum_profile *profile)
{
    lum_layout layout;
    assert_int_equal(lum_layout_init(&layout, profile, NULL, NULL), LUM_OK);
    return layout;
}

static void assert_groups_equal(const lum_group *a, const lum_group *b)
{
    assert_int_equal(a->line, b->line);
    assert_int_equal(a->num_samples, b->num_samples);
    assert_int_equal(a->first_sample_index, b->first_sample_index);
    assert_int_equal(a->clock_raw, b->clock_raw);
    assert_int_equal(a->eye, b->eye);
    assert_int_equal(a->tag, b->tag);
}

static void angles_are_read_as_the_layout_says(void **state)
{
    const lum_layout layout = standard();
    lum_group g;
    (void)state;
    assert_int_equal(lum_group_decode(&layout, angles, sizeof angles, &g),
                     LUM_OK);
    assert_int_equal(g.tag, LUM_TAG_ANGLES);
    assert_int_equal(g.eye, LUM_EYE_GREEN);
    assert_int_equal(g.line, 0x0203);
    assert_int_equal(g.num_samples, 2);
    assert_int_equal(g.first_sample_index, 0x0104);
    assert_int_equal(g.clock_raw, 0x92345678u);
    assert_ptr_equal(g.samples, angles + 24);
    assert_int_equal(lum_group_angle(&layout, &g, 0).azimuth, 32767);
    assert_int_equal(lum_group_angle(&layout, &g, 0).elevation, -32768);
    assert_int_equal(lum_group_angle(&layout, &g, 1).azimuth, 1);
    assert_int_equal(lum_group_angle(&layout, &g, 1).elevation, -1);
}

static void angles_may_bear_the_elevation_first(void **state)
{
    lum_layout layout = standard();
    lum_group g;
    uint8_t bytes[LUM_SAMPLE_BYTES];
    (void)state;
    layout.profile.angle_order = LUM_ELEVATION_AZIMUTH;
    assert_int_equal(lum_group_decode(&layout, angles, sizeof angles, &g),
                     LUM_OK);
    const lum_angle angle = lum_group_angle(&layout, &g, 0);
    assert_int_equal(angle.elevation, 32767);
    assert_int_equal(angle.azimuth, -32768);
    lum_angle_encode(&layout, angle, bytes);
    assert_memory_equal(bytes, angles + 24, sizeof bytes);
}

static void ranges_are_read_as_the_layout_says(void **state)
{
    const lum_layout layout = standard();
    lum_group g;
    (void)state;
    assert_int_equal(lum_group_decode(&layout, ranges, sizeof ranges, &g),
                     LUM_OK);
    assert_int_equal(g.tag, LUM_TAG_RANGES);
    assert_int_equal(g.eye, LUM_EYE_BLUE);
    assert_int_equal(g.line, 7);
    assert_int_equal(g.first_sample_index, 5);
    assert_int_equal(g.clock_raw, 1);
    const uint32_t word = lum_group_word(&g, 0);
    assert_int_equal(word, 0xfffff7e7u);
    assert_int_equal(lum_word_tof(word), -1);
    assert_int_equal(lum_word_pixel(word), 999);
    assert_true(lum_word_is_rising(word));
    assert_true(lum_word_is_good(word));
}

static void the_encoder_writes_the_same_bytes(void **state)
{
    const lum_layout layout = standard();
    lum_group g;
    uint8_t out[sizeof angles];
    size_t len = 0;
    (void)state;
    assert_int_equal(lum_group_decode(&layout, angles, sizeof angles, &g),
                     LUM_OK);
    memset(out, 0xff, sizeof out);
    assert_int_equal(lum_group_encode(&layout, &g, out, sizeof out, &len),
                     LUM_OK);
    assert_int_equal(len, 24);
    lum_angle_encode(&layout, (lum_angle){32767, -32768}, out + 24);
    lum_angle_encode(&layout, (lum_angle){1, -1}, out + 28);
    assert_memory_equal(out, angles, sizeof angles);
    lum_word_encode(lum_word_make(-1, true, 999), out);
    assert_memory_equal(out, ranges + 24, 4);
}

static void bytes_between_the_fields_are_0(void **state)
{
    lum_profile p;
    const lum_group g = {.line = 0xffff,
                         .num_samples = 1,
                         .first_sample_index = 0xffff,
                         .clock_raw = 0xffffffffu,
                         .eye = 1,
                         .tag = LUM_TAG_RANGES};
    uint8_t out[64];
    size_t len = 0;
    (void)state;
    lum_profile_default(&p);
    p.samples_at = 64;
    p.group[LUM_FIELD_TIMESTAMP].at = 32;
    const lum_layout layout = checked(&p);
    memset(out, 0x55, sizeof out);
    assert_int_equal(lum_group_encode(&layout, &g, out, sizeof out, &len),
                     LUM_OK);
    assert_int_equal(len, 64);
    for (size_t i = 20; i < 64; i++) {
        assert_int_equal(out[i], i >= 32 && i < 36 ? 0xff : 0);
    }
}

static void the_clock_is_cut_to_its_field(void **state)
{
    lum_layout layout = standard();
    const lum_group in = {
        .num_samples = 1, .clock_raw = 0x12345678u, .tag = LUM_TAG_RANGES};
    static const struct {
        uint8_t bytes;
        uint32_t clock;
    } rows[] = {{1, 0x78}, {2, 0x5678}, {4, 0x12345678u}};
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        size_t len = 0;
        lum_group out;
        layout.profile.group[LUM_FIELD_TIMESTAMP].bytes = rows[i].bytes;
        uint8_t *packet = encode_packet(&layout, &in, ranges, &len);
        assert_int_equal(lum_group_decode(&layout, packet, len, &out), LUM_OK);
        assert_int_equal(out.clock_raw, rows[i].clock);
        free(packet);
    }
}

static void every_truncation_is_malformed_and_writes_nothing(void **state)
{
    const lum_layout layout = standard();
    (void)state;
    for (size_t n = 0; n < sizeof angles; n++) {
        uint8_t *exact = exact_copy(angles, n);
        lum_group g = {.line = 77, .tag = 99};
        assert_int_equal(lum_group_decode(&layout, exact, n, &g),
                         LUM_E_MALFORMED);
        assert_true(g.line == 77 && g.tag == 99 && g.samples == NULL);
        free(exact);
    }
}

static void bytes_behind_the_last_sample_are_ignored(void **state)
{
    const lum_layout layout = standard();
    uint8_t longer[sizeof angles + 5] = {0};
    lum_group g;
    (void)state;
    memcpy(longer, angles, sizeof angles);
    for (size_t n = sizeof angles; n <= sizeof longer; n++) {
        assert_int_equal(lum_group_decode(&layout, longer, n, &g), LUM_OK);
        assert_int_equal(g.num_samples, 2);
    }
}

static lum_result decode_with(const uint8_t *golden, size_t len, size_t at,
                              unsigned low, unsigned high)
{
    const lum_layout layout = standard();
    uint8_t bytes[sizeof angles];
    lum_group g;
    memcpy(bytes, golden, len);
    bytes[at] = (uint8_t)low;
    bytes[at + 1] = (uint8_t)high;
    return lum_group_decode(&layout, bytes, len, &g);
}

static void no_samples_and_too_many_are_malformed(void **state)
{
    (void)state;
    assert_int_equal(decode_with(angles, sizeof angles, 16, 0, 0),
                     LUM_E_MALFORMED);
    assert_int_equal(decode_with(angles, sizeof angles, 16, 1, 0), LUM_OK);
    assert_int_equal(decode_with(angles, sizeof angles, 16, 2, 0), LUM_OK);
    assert_int_equal(decode_with(angles, sizeof angles, 16, 3, 0),
                     LUM_E_MALFORMED);
    assert_int_equal(decode_with(angles, sizeof angles, 16, 0xff, 0xff),
                     LUM_E_MALFORMED);
}

static void an_eye_is_one_of_two_values(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < 256; eye++) {
        assert_int_equal(decode_with(angles, sizeof angles, 13, eye, 3),
                         eye < 2 ? LUM_OK : LUM_E_MALFORMED);
    }
}

static void a_tag_is_2_or_3(void **state)
{
    (void)state;
    for (unsigned tag = 0; tag < 256; tag++) {
        assert_int_equal(decode_with(ranges, sizeof ranges, 12, tag, 0),
                         tag == 2 || tag == 3 ? LUM_OK : LUM_E_UNKNOWN_TAG);
    }
}

static void a_bad_eye_counts_before_an_unknown_tag(void **state)
{
    (void)state;
    assert_int_equal(decode_with(ranges, sizeof ranges, 12, 9, 9),
                     LUM_E_MALFORMED);
    assert_int_equal(decode_with(ranges, sizeof ranges - 1, 12, 9, 0),
                     LUM_E_MALFORMED);
}

static void angles_end_with_the_lines_last_pixel(void **state)
{
    (void)state;
    assert_int_equal(decode_with(angles, sizeof angles, 18, 0xe6, 3), LUM_OK);
    assert_int_equal(decode_with(angles, sizeof angles, 18, 0xe7, 3),
                     LUM_E_MALFORMED);
    assert_int_equal(decode_with(angles, sizeof angles, 18, 0xff, 0xff),
                     LUM_E_MALFORMED);
}

static void a_range_index_may_be_anything(void **state)
{
    (void)state;
    assert_int_equal(decode_with(ranges, sizeof ranges, 18, 0xff, 0xff),
                     LUM_OK);
}

static void angles_past_every_width_are_malformed(void **state)
{
    lum_profile p;
    uint8_t bytes[64 + 4] = {MAGIC, 8};
    lum_group g;
    (void)state;
    lum_profile_default(&p);
    p.group[LUM_FIELD_FIRST_SAMPLE_INDEX] = (lum_field){.at = 24, .bytes = 4};
    p.samples_at = 28;
    const lum_layout layout = checked(&p);
    bytes[12] = LUM_TAG_ANGLES;
    bytes[16] = 1;
    memset(bytes + 24, 0xff, 4); /* 2^32 - 1, and one sample more is 0 */
    assert_int_equal(lum_group_decode(&layout, bytes, sizeof bytes, &g),
                     LUM_E_MALFORMED);
}

static void each_field_comes_back_at_its_limits(void **state)
{
    static const uint32_t limits[] = {0, 1, 255, 256, 998, 999, 65535};
    const lum_layout layout = standard();
    (void)state;
    for (unsigned i = 0; i < 7; i++) {
        for (unsigned eye = 0; eye < 2; eye++) {
            const lum_group in = {.line = limits[i],
                                  .num_samples = 1,
                                  .first_sample_index = limits[6 - i],
                                  .clock_raw = ~limits[i],
                                  .eye = (uint8_t)eye,
                                  .tag = LUM_TAG_RANGES};
            size_t len = 0;
            uint8_t *packet = encode_packet(&layout, &in, ranges, &len);
            lum_group out;
            assert_int_equal(lum_group_decode(&layout, packet, len, &out),
                             LUM_OK);
            assert_groups_equal(&out, &in);
            free(packet);
        }
    }
}

static lum_result encode(const lum_layout *layout, const lum_group *g,
                         size_t size)
{
    uint8_t *out = malloc(size > 0 ? size : 1u);
    size_t len = 4711;
    assert_non_null(out);
    const lum_result r = lum_group_encode(layout, g, out, size, &len);
    assert_int_equal(len, r == LUM_OK ? layout->profile.samples_at : 4711);
    free(out);
    return r;
}

static void the_encoder_refuses_what_no_decoder_takes(void **state)
{
    const lum_layout layout = standard();
    const lum_group good = {.line = 65535,
                            .num_samples = 1000,
                            .first_sample_index = 0,
                            .eye = 1,
                            .tag = LUM_TAG_ANGLES};
    lum_group g = good;
    (void)state;
    assert_int_equal(encode(&layout, &g, 24), LUM_OK);
    assert_int_equal(encode(&layout, &g, 23), LUM_E_SPACE);
    assert_int_equal(encode(&layout, &g, 0), LUM_E_SPACE);
    g.first_sample_index = 1;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g = good;
    g.num_samples = 1001;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g.num_samples = 0;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g = good;
    g.eye = 2;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g = good;
    g.tag = 4;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g = good;
    g.line = 65536;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
}

static void the_encoder_refuses_what_a_narrow_field_cannot_hold(void **state)
{
    lum_layout layout = standard();
    lum_group g = {.line = 255,
                   .num_samples = 255,
                   .first_sample_index = 255,
                   .clock_raw = 0x1ff,
                   .tag = LUM_TAG_RANGES};
    (void)state;
    layout.profile.group[LUM_FIELD_LINE].bytes = 1;
    layout.profile.group[LUM_FIELD_NUM_SAMPLES].bytes = 1;
    layout.profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].bytes = 1;
    assert_int_equal(encode(&layout, &g, 24), LUM_OK);
    g.line = 256;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g.line = 0;
    g.num_samples = 256;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
    g.num_samples = 1;
    g.first_sample_index = 256;
    assert_int_equal(encode(&layout, &g, 24), LUM_E_VALUE);
}

/* Of all fields that there are, but the tag, of which no larger one is known,
 * and the clock, which is cut. */
static void no_field_is_cut_without_a_word(void **state)
{
    const lum_group g = {.line = 256,
                         .num_samples = 256,
                         .first_sample_index = 256,
                         .tag = LUM_TAG_RANGES};
    (void)state;
    for (unsigned f = LUM_FIELD_TAG + 1; f < LUM_GROUP_FIELDS; f++) {
        lum_layout layout = standard();
        layout.profile.group[LUM_FIELD_EYE].bytes = 2;
        layout.profile.eye_values[g.eye] = 256;
        assert_int_equal(encode(&layout, &g, 24), LUM_OK);
        layout.profile.group[f].bytes = 1;
        assert_int_equal(encode(&layout, &g, 24),
                         f == LUM_FIELD_TIMESTAMP ? LUM_OK : LUM_E_VALUE);
    }
}

static void fields_of_every_width_come_back(void **state)
{
    static const uint8_t widths[] = {1, 2, 4};
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        lum_profile p;
        lum_profile_default(&p);
        for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
            p.group[f] =
                (lum_field){.at = (uint8_t)(60 - 5 * f), .bytes = widths[i]};
        }
        p.samples_at = 64;
        p.data_packet_type = 255;
        p.eye_values[LUM_EYE_BLUE] = 200;
        const lum_layout layout = checked(&p);
        const lum_group in = {.line = 254,
                              .num_samples = 1,
                              .first_sample_index = 253,
                              .clock_raw = 252,
                              .eye = LUM_EYE_BLUE,
                              .tag = LUM_TAG_RANGES};
        size_t len = 0;
        uint8_t *packet = encode_packet(&layout, &in, ranges, &len);
        lum_group out;
        assert_int_equal(packet[8], 255);
        assert_int_equal(packet[60], LUM_TAG_RANGES);
        assert_int_equal(packet[55], 200);
        assert_int_equal(lum_group_decode(&layout, packet, len, &out), LUM_OK);
        assert_groups_equal(&out, &in);
        free(packet);
    }
}

static void with_the_tag_on_the_type_the_tag_is_the_type(void **state)
{
    lum_profile p;
    (void)state;
    lum_profile_default(&p);
    p.group[LUM_FIELD_TAG].at = 8;
    const lum_layout layout = checked(&p);
    for (uint8_t tag = LUM_TAG_ANGLES; tag <= LUM_TAG_RANGES; tag++) {
        const lum_group in = {.num_samples = 1,
                              .eye = LUM_EYE_GREEN,
                              .tag = tag,
                              .sample_order = LUM_ORDER_BIG};
        size_t len = 0;
        uint8_t *packet = encode_packet(&layout, &in, ranges, &len);
        lum_group out;
        assert_int_equal(packet[8], tag);
        assert_int_equal(lum_group_decode(&layout, packet, len, &out), LUM_OK);
        assert_int_equal(out.tag, tag);
        free(packet);
    }
}

static void without_a_timestamp_the_clock_is_0(void **state)
{
    lum_profile p;
    lum_group out;
    size_t len = 0;
    (void)state;
    lum_profile_default(&p);
    p.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 0, .bytes = 0};
    p.samples_at = 20;
    const lum_layout layout = checked(&p);
    const lum_group in = {.num_samples = 1, .clock_raw = 5, .tag = 3};
    uint8_t *packet = encode_packet(&layout, &in, ranges, &len);
    assert_int_equal(len, 24);
    assert_int_equal(lum_group_decode(&layout, packet, len, &out), LUM_OK);
    assert_int_equal(out.clock_raw, 0);
    free(packet);
}

static void each_word_is_read_at_its_place(void **state)
{
    const uint8_t samples[12] = {1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 4};
    const lum_group group = {.samples = samples, .num_samples = 3};
    (void)state;
    assert_int_equal(lum_group_word(&group, 0), 1);
    assert_int_equal(lum_group_word(&group, 1), 2);
    assert_int_equal(lum_group_word(&group, 2), 0x04000003);
}

static void words_hold_every_tof(void **state)
{
    (void)state;
    for (int32_t tof = LUM_TOF_MIN; tof <= LUM_TOF_MAX; tof++) {
        const uint32_t word = lum_word_make(tof, (tof & 1) != 0, 511);
        if (lum_word_tof(word) != tof ||
            lum_word_is_rising(word) != ((tof & 1) != 0) ||
            lum_word_pixel(word) != 511 || !lum_word_is_good(word)) {
            fail_msg("tof %d", (int)tof);
        }
    }
}

static void bit_11_or_a_pixel_past_999_is_bad(void **state)
{
    (void)state;
    for (uint32_t low = 0; low < 0x1000u; low++) {
        const int good = (low & 0x800u) == 0 && (low & 0x3ffu) <= 999;
        assert_int_equal(lum_word_is_good(0xabcde000u | low), good);
    }
}

static void any_alignment_will_do(void **state)
{
    const lum_layout layout = standard();
    uint8_t room[sizeof angles + 8];
    lum_group g;
    (void)state;
    for (size_t shift = 0; shift < 8; shift++) {
        memcpy(room + shift, angles, sizeof angles);
        assert_int_equal(
            lum_group_decode(&layout, room + shift, sizeof angles, &g), LUM_OK);
        assert_int_equal(g.clock_raw, 0x92345678u);
        assert_int_equal(lum_group_angle(&layout, &g, 1).elevation, -1);
        assert_int_equal(lum_group_word(&g, 0), 0x80007fffu);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(angles_are_read_as_the_layout_says),
        ANY_LAYOUT_TEST(angles_may_bear_the_elevation_first),
        cmocka_unit_test(ranges_are_read_as_the_layout_says),
        cmocka_unit_test(the_encoder_writes_the_same_bytes),
        cmocka_unit_test(bytes_between_the_fields_are_0),
        ANY_LAYOUT_TEST(the_clock_is_cut_to_its_field),
        cmocka_unit_test(every_truncation_is_malformed_and_writes_nothing),
        cmocka_unit_test(bytes_behind_the_last_sample_are_ignored),
        cmocka_unit_test(no_samples_and_too_many_are_malformed),
        cmocka_unit_test(an_eye_is_one_of_two_values),
        cmocka_unit_test(a_tag_is_2_or_3),
        cmocka_unit_test(a_bad_eye_counts_before_an_unknown_tag),
        cmocka_unit_test(angles_end_with_the_lines_last_pixel),
        cmocka_unit_test(a_range_index_may_be_anything),
        ANY_LAYOUT_TEST(angles_past_every_width_are_malformed),
        cmocka_unit_test(each_field_comes_back_at_its_limits),
        cmocka_unit_test(the_encoder_refuses_what_no_decoder_takes),
        cmocka_unit_test(the_encoder_refuses_what_a_narrow_field_cannot_hold),
        cmocka_unit_test(no_field_is_cut_without_a_word),
        ANY_LAYOUT_TEST(fields_of_every_width_come_back),
        ANY_LAYOUT_TEST(with_the_tag_on_the_type_the_tag_is_the_type),
        ANY_LAYOUT_TEST(without_a_timestamp_the_clock_is_0),
        cmocka_unit_test(each_word_is_read_at_its_place),
        cmocka_unit_test(words_hold_every_tof),
        cmocka_unit_test(bit_11_or_a_pixel_past_999_is_bad),
        cmocka_unit_test(any_alignment_will_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
