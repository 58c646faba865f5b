#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/clock.h"
#include "lum/group.h"
#include "lum/packet.h"
#include "lum/receiver.h"
#include "support.h"

#include <stdlib.h>
#include <string.h>

/* What a profile can say beyond the default: widths, orders and bits of fields,
 * no count, ticks, and the order of samples. */

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static lum_profile usual(void)
{
    lum_profile p;
    lum_profile_default(&p);
    return p;
}

static lum_layout checked(const lum_profile *p)
{
    lum_layout layout;
    assert_int_equal(lum_layout_init(&layout, p, NULL, NULL), LUM_OK);
    return layout;
}

/* --- Fields --- */

/* The line of a packet that has these bytes from 24 on, where it stands. */
static lum_packet_kind line_of(lum_field field, const uint8_t bytes[8],
                               uint32_t *line)
{
    uint8_t packet[44] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8,
                          0,    0,    0,    3,    0,    0,    0,    1,    0};
    lum_profile p = usual();
    lum_group g;
    p.samples_at = 40;
    p.group[LUM_FIELD_LINE] = field;
    memcpy(packet + 24, bytes, 8);
    const lum_layout layout = checked(&p);
    const lum_packet_kind kind =
        lum_packet_decode(&layout, packet, sizeof packet, &g);
    *line = kind == LUM_PACKET_DATA ? g.line : 0;
    return kind;
}

static void each_kind_of_field_has_its_value(void **state)
{
    static const struct {
        lum_field field;
        uint32_t line;
    } rows[] = {
        {{24, 1, LUM_ORDER_LITTLE, 0, 0}, 0x81},
        {{24, 1, LUM_ORDER_BIG, 0, 0}, 0x81},
        {{24, 2, LUM_ORDER_LITTLE, 0, 0}, 0x9281},
        {{24, 2, LUM_ORDER_BIG, 0, 0}, 0x8192},
        {{25, 2, LUM_ORDER_BIG, 0, 0}, 0x92a3},
        {{24, 4, LUM_ORDER_LITTLE, 0, 0}, 0xb4a39281u},
        {{24, 4, LUM_ORDER_BIG, 0, 0}, 0x8192a3b4u},
        {{24, 1, LUM_ORDER_LITTLE, 0, 4}, 0x1},
        {{24, 1, LUM_ORDER_LITTLE, 7, 1}, 0x1},
        {{24, 1, LUM_ORDER_LITTLE, 0, 7}, 0x1},
        {{24, 1, LUM_ORDER_LITTLE, 0, 8}, 0x81},
        {{24, 2, LUM_ORDER_LITTLE, 0, 15}, 0x1281},
        {{24, 2, LUM_ORDER_LITTLE, 7, 2}, 0x1},
        {{24, 2, LUM_ORDER_LITTLE, 4, 9}, 0x128},
        {{24, 2, LUM_ORDER_BIG, 4, 9}, 0x19},
        {{24, 4, LUM_ORDER_LITTLE, 31, 1}, 0x1},
        {{24, 4, LUM_ORDER_BIG, 1, 31}, 0x40c951da},
        {{24, 8, LUM_ORDER_LITTLE, 0, 32}, 0xb4a39281u},
        {{24, 8, LUM_ORDER_LITTLE, 32, 32}, 0xf8e7d6c5u},
        {{24, 8, LUM_ORDER_LITTLE, 28, 8}, 0x5b},
        {{24, 8, LUM_ORDER_LITTLE, 63, 1}, 0x1},
        {{24, 8, LUM_ORDER_BIG, 0, 32}, 0xc5d6e7f8u},
        {{24, 8, LUM_ORDER_BIG, 32, 32}, 0x8192a3b4u},
        {{24, 8, LUM_ORDER_BIG, 28, 8}, 0x4c},
        {{24, 8, LUM_ORDER_BIG, 63, 1}, 0x1},
    };
    static const uint8_t bytes[8] = {0x81, 0x92, 0xa3, 0xb4,
                                     0xc5, 0xd6, 0xe7, 0xf8};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t line = 0;
        assert_int_equal(line_of(rows[i].field, bytes, &line), LUM_PACKET_DATA);
        assert_int_equal(line, rows[i].line);
    }
}

static void a_line_of_more_than_32_bits_is_malformed(void **state)
{
    static const lum_field all = {24, 8, LUM_ORDER_LITTLE, 0, 0};
    static const lum_field part = {24, 8, LUM_ORDER_BIG, 2, 34};
    uint8_t bytes[8] = {0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0};
    uint32_t line = 0;
    (void)state;
    assert_int_equal(line_of(all, bytes, &line), LUM_PACKET_DATA);
    assert_int_equal(line, UINT32_MAX);
    for (unsigned i = 4; i < 8; i++) {
        bytes[i] = 1;
        assert_int_equal(line_of(all, bytes, &line), LUM_PACKET_MALFORMED);
        bytes[i] = 0;
    }
    memcpy(bytes,
           (const uint8_t[]){0xff, 0xff, 0xff, 0xf3, 0xff, 0xff, 0xff, 0xff},
           8);
    assert_int_equal(line_of(part, bytes, &line), LUM_PACKET_DATA);
    assert_int_equal(line, UINT32_MAX);
    bytes[3] = 0xf7;
    assert_int_equal(line_of(part, bytes, &line), LUM_PACKET_MALFORMED);
}

/* The same of each field that has to fit 32 bits, and of a tag. */
static void other_values_of_more_than_32_bits(void **state)
{
    static const struct {
        unsigned field;
        uint8_t value;
        lum_packet_kind kind;
    } rows[] = {
        {LUM_FIELD_EYE, 1, LUM_PACKET_MALFORMED},
        {LUM_FIELD_NUM_SAMPLES, 1, LUM_PACKET_MALFORMED},
        {LUM_FIELD_FIRST_SAMPLE_INDEX, 7, LUM_PACKET_MALFORMED},
        {LUM_FIELD_TAG, 3, LUM_PACKET_UNKNOWN_TAG},
        {LUM_FIELD_TIMESTAMP, 9, LUM_PACKET_DATA},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint8_t packet[44] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe,
                              0x34, 0x12, 8,    0,    0,    0,
                              3,    0,    0,    0,    1,    0};
        lum_profile p = usual();
        lum_group g;
        p.samples_at = 40;
        p.group[rows[i].field] = (lum_field){.at = 32, .bytes = 8};
        const lum_layout layout = checked(&p);
        packet[32] = rows[i].value;
        assert_int_equal(lum_packet_decode(&layout, packet, 44, &g),
                         LUM_PACKET_DATA);
        packet[36] = 1;
        assert_int_equal(lum_packet_decode(&layout, packet, 44, &g),
                         rows[i].kind);
        if (rows[i].kind == LUM_PACKET_DATA) {
            assert_true(g.clock_raw == UINT64_C(0x100000009));
        }
    }
}

static void a_long_line_behind_a_long_tag_is_malformed(void **state)
{
    uint8_t packet[44] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8,
                          0,    0,    0,    3,    0,    0,    0,    1,    0};
    lum_profile p = usual();
    lum_group g;
    (void)state;
    p.samples_at = 40;
    p.group[LUM_FIELD_TAG] = (lum_field){.at = 24, .bytes = 8};
    p.group[LUM_FIELD_LINE] = (lum_field){.at = 32, .bytes = 8};
    const lum_layout layout = checked(&p);
    packet[28] = 1;
    assert_int_equal(lum_packet_decode(&layout, packet, 44, &g),
                     LUM_PACKET_UNKNOWN_TAG);
    packet[39] = 0xff;
    assert_int_equal(lum_packet_decode(&layout, packet, 44, &g),
                     LUM_PACKET_MALFORMED);
}

static void without_a_count_the_length_tells(void **state)
{
    uint8_t packet[64] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34,
                          0x12, 8,    0,    0,    0,    3};
    lum_profile p = usual();
    lum_group g;
    (void)state;
    p.group[LUM_FIELD_NUM_SAMPLES].bytes = 0;
    const lum_layout layout = checked(&p);
    for (size_t len = 0; len <= sizeof packet; len++) {
        const lum_packet_kind kind =
            lum_packet_decode(&layout, packet, len, &g);
        if (len >= 28) {
            assert_int_equal(kind, LUM_PACKET_DATA);
            assert_int_equal(g.num_samples, (len - 24) / 4);
        } else {
            assert_int_not_equal(kind, LUM_PACKET_DATA);
        }
    }
    packet[12] = LUM_TAG_ANGLES;
    packet[18] = 0xe0; /* 992 */
    packet[19] = 3;
    assert_int_equal(lum_packet_decode(&layout, packet, 24 + 4 * 8 + 3, &g),
                     LUM_PACKET_DATA);
    assert_int_equal(lum_packet_decode(&layout, packet, 24 + 4 * 9, &g),
                     LUM_PACKET_MALFORMED);
}

/* --- Checks --- */

static void assert_fault(const lum_profile *p, lum_profile_fault fault,
                         unsigned index)
{
    lum_layout layout;
    lum_profile_fault found = LUM_PROFILE_FINE;
    unsigned at = 99;
    assert_int_equal(lum_layout_init(&layout, p, &found, &at),
                     fault == LUM_PROFILE_FINE ? LUM_OK : LUM_E_VALUE);
    assert_int_equal(found, fault);
    assert_int_equal(at, index);
}

static void assert_bits(uint8_t bytes, unsigned low, unsigned bits)
{
    const int fine = bits == 0 ? low == 0 : low + bits <= 8u * bytes;
    lum_profile p = usual();
    p.samples_at = 40;
    p.group[LUM_FIELD_LINE] =
        (lum_field){30, bytes, 0, (uint8_t)low, (uint8_t)bits};
    assert_fault(&p, fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELD_BITS,
                 fine ? 0 : LUM_FIELD_LINE);
}

static void bits_lie_in_their_bytes(void **state)
{
    (void)state;
    for (unsigned low = 0; low < 66; low++) {
        for (unsigned bits = 0; bits < 66; bits++) {
            assert_bits(1, low, bits);
            assert_bits(2, low, bits);
            assert_bits(4, low, bits);
            assert_bits(8, low, bits);
        }
    }
}

static void fields_share_bytes_only_as_different_bits(void **state)
{
    static const struct {
        lum_field line;
        lum_field eye;
        int fine;
    } rows[] = {
        {{30, 2, 0, 0, 15}, {30, 2, 0, 15, 1}, 1},
        {{30, 2, 1, 0, 15}, {30, 2, 1, 15, 1}, 1},
        {{30, 2, 0, 1, 15}, {30, 2, 0, 0, 1}, 1},
        {{30, 2, 0, 0, 15}, {30, 2, 0, 14, 2}, 0},
        {{30, 2, 0, 0, 15}, {30, 2, 0, 0, 1}, 0},
        {{30, 2, 0, 0, 15}, {30, 2, 1, 15, 1}, 0},
        {{30, 2, 0, 0, 15}, {30, 4, 0, 31, 1}, 0},
        {{30, 2, 0, 0, 8}, {31, 1, 0, 7, 1}, 0},
        {{30, 2, 0, 0, 8}, {31, 2, 0, 15, 1}, 0},
        {{30, 2, 0, 0, 15}, {30, 2, 0, 0, 0}, 0},
        {{30, 2, 0, 0, 0}, {30, 2, 0, 15, 1}, 0},
        {{30, 2, 0, 0, 8}, {32, 1, 0, 0, 8}, 1},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        lum_profile p = usual();
        p.samples_at = 40;
        p.group[LUM_FIELD_LINE] = rows[i].line;
        p.group[LUM_FIELD_EYE] = rows[i].eye;
        assert_fault(
            &p, rows[i].fine ? LUM_PROFILE_FINE : LUM_PROFILE_FIELDS_OVERLAP,
            rows[i].fine ? 0 : LUM_FIELD_LINE);
    }
}

static void a_field_that_is_nowhere_overlaps_none(void **state)
{
    lum_profile p = usual();
    (void)state;
    p.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.at = 18, .bytes = 0};
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.group[LUM_FIELD_NUM_SAMPLES].at = 200;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.group[LUM_FIELD_NUM_SAMPLES].bits = 1;
    assert_fault(&p, LUM_PROFILE_FIELD_BITS, LUM_FIELD_NUM_SAMPLES);
}

static void orders_and_ticks_have_their_limits(void **state)
{
    lum_profile p = usual();
    (void)state;
    p.sample_order = 2;
    assert_fault(&p, LUM_PROFILE_SAMPLE_ORDER, 0);
    p.sample_order = LUM_ORDER_BIG;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.group[LUM_FIELD_EYE].order = 2;
    assert_fault(&p, LUM_PROFILE_FIELD_ORDER, LUM_FIELD_EYE);
    p.group[LUM_FIELD_EYE].order = LUM_ORDER_BIG;
    p.clock_unit_ns = 0;
    assert_fault(&p, LUM_PROFILE_CLOCK_UNIT, 0);
    p.clock_unit_ns = LUM_CLOCK_UNIT_MAX_NS + 1;
    assert_fault(&p, LUM_PROFILE_CLOCK_UNIT, 0);
    p.clock_unit_ns = LUM_CLOCK_UNIT_MAX_NS;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.clock_unit_ns = 1;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
}

static void an_eyes_value_fits_its_bits(void **state)
{
    lum_profile p = usual();
    (void)state;
    p.group[LUM_FIELD_EYE] = (lum_field){13, 1, 0, 5, 2};
    p.eye_values[LUM_EYE_GREEN] = 3;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
    p.eye_values[LUM_EYE_GREEN] = 4;
    assert_fault(&p, LUM_PROFILE_EYE_VALUE_WIDTH, LUM_EYE_GREEN);
    p.group[LUM_FIELD_EYE] = (lum_field){32, 8, 0, 0, 0};
    p.samples_at = 40;
    p.eye_values[LUM_EYE_GREEN] = UINT32_MAX;
    assert_fault(&p, LUM_PROFILE_FINE, 0);
}

/* --- There and back, over random layouts --- */

static uint32_t below(uint64_t *random, uint32_t n)
{
    return next_random(random) % n;
}

/* Fields side by side in any order, some as bits of the same bytes. */
static lum_profile random_profile(uint64_t *random)
{
    static const uint8_t widths[] = {1, 2, 4, 8};
    lum_profile p = usual();
    unsigned at = 12;
    const unsigned turn = below(random, LUM_GROUP_FIELDS);
    for (unsigned i = 0; i < LUM_GROUP_FIELDS; i++) {
        const unsigned f = (i + turn) % LUM_GROUP_FIELDS;
        const uint8_t bytes = widths[below(random, 4)];
        lum_field *field = &p.group[f];
        *field =
            (lum_field){(uint8_t)at, bytes, (uint8_t)below(random, 2), 0, 0};
        if (below(random, 2) == 0) {
            field->bits = (uint8_t)(2 + below(random, 8u * bytes - 1u));
            field->low = (uint8_t)below(random, 8u * bytes - field->bits + 1u);
        }
        at += bytes + below(random, 2);
    }
    if (below(random, 3) == 0) {
        lum_field *line = &p.group[LUM_FIELD_LINE];
        line->low = 0;
        line->bits = (uint8_t)(8u * line->bytes - 1u);
        p.group[LUM_FIELD_EYE] = *line;
        p.group[LUM_FIELD_EYE].low = line->bits;
        p.group[LUM_FIELD_EYE].bits = 1;
    }
    if (below(random, 4) == 0) {
        p.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.bytes = 0};
    }
    p.samples_at = (uint8_t)at;
    p.sample_order = (uint8_t)below(random, 2);
    p.angle_order = (uint8_t)below(random, 2);
    return p;
}

static uint64_t mask_of(const lum_field *field)
{
    const unsigned bits = field->bits > 0 ? field->bits : 8u * field->bytes;
    return bits == 0 ? 0 : UINT64_MAX >> (64u - bits);
}

static uint32_t random_value(uint64_t *random, const lum_field *field)
{
    return next_random(random) & (uint32_t)mask_of(field);
}

static void assert_samples(const lum_layout *layout, uint8_t *at,
                           const lum_group *g)
{
    const lum_angle angle = {-12345, 23456};
    lum_group_word_encode(layout, 0x12345678, at);
    assert_int_equal(lum_group_word(g, 0), 0x12345678);
    lum_angle_encode(layout, angle, at);
    assert_int_equal(lum_group_angle(layout, g, 0).azimuth, -12345);
    assert_int_equal(lum_group_angle(layout, g, 0).elevation, 23456);
}

static void there_and_back(const lum_profile *p, uint64_t *random)
{
    const lum_layout layout = checked(p);
    const uint64_t clock =
        (uint64_t)next_random(random) << 32 | next_random(random);
    lum_group in = {.line = random_value(random, &p->group[LUM_FIELD_LINE]),
                    .num_samples = 1,
                    .first_sample_index = random_value(
                        random, &p->group[LUM_FIELD_FIRST_SAMPLE_INDEX]),
                    .clock_raw = clock,
                    .eye = (uint8_t)below(random, 2),
                    .tag = LUM_TAG_RANGES};
    uint8_t packet[LUM_GROUP_HEAD_MAX + 4] = {0};
    size_t len = 0;
    lum_group out;
    assert_int_equal(
        lum_group_encode(&layout, &in, packet, sizeof packet, &len), LUM_OK);
    assert_int_equal(len, p->samples_at);
    for (size_t cut = 0; cut < len + 4; cut++) {
        uint8_t *exact = exact_copy(packet, cut);
        const lum_packet_kind kind =
            lum_packet_decode(&layout, exact, cut, &out);
        assert_true(kind == LUM_PACKET_MALFORMED ||
                    kind == LUM_PACKET_FOREIGN || kind == LUM_PACKET_HEARTBEAT);
        free(exact);
    }
    assert_int_equal(lum_packet_decode(&layout, packet, len + 4, &out),
                     LUM_PACKET_DATA);
    assert_int_equal(out.line, in.line);
    assert_int_equal(out.num_samples, 1);
    assert_int_equal(out.first_sample_index, in.first_sample_index);
    assert_true(out.clock_raw ==
                (clock & mask_of(&p->group[LUM_FIELD_TIMESTAMP])));
    assert_int_equal(out.eye, in.eye);
    assert_int_equal(out.tag, in.tag);
    assert_int_equal(out.sample_order, p->sample_order);
    assert_samples(&layout, packet + len, &out);
}

static void what_is_encoded_is_decoded(void **state)
{
    uint64_t random = 7;
    (void)state;
    for (unsigned i = 0; i < 2000; i++) {
        const lum_profile p = random_profile(&random);
        lum_layout layout;
        if (p.samples_at <= 64 &&
            lum_layout_init(&layout, &p, NULL, NULL) == LUM_OK) {
            there_and_back(&p, &random);
        }
    }
}

static void what_does_not_fit_its_bits_is_not_encoded(void **state)
{
    lum_profile p = usual();
    lum_group g = {.line = 7, .num_samples = 1, .tag = LUM_TAG_RANGES};
    uint8_t out[64];
    size_t len = 0;
    (void)state;
    p.group[LUM_FIELD_LINE].bits = 3;
    const lum_layout layout = checked(&p);
    assert_int_equal(lum_group_encode(&layout, &g, out, sizeof out, &len),
                     LUM_OK);
    assert_int_equal(out[14], 7);
    g.line = 8;
    assert_int_equal(lum_group_encode(&layout, &g, out, sizeof out, &len),
                     LUM_E_VALUE);
}

static void samples_in_the_other_order(void **state)
{
    static const uint8_t word[] = {0xab, 0xcd, 0xe4, 0x07};
    static const uint8_t angle[] = {0x80, 0x01, 0x7f, 0xfe};
    lum_profile p = usual();
    lum_group g = {.samples = word,
                   .num_samples = 1,
                   .tag = LUM_TAG_RANGES,
                   .sample_order = LUM_ORDER_BIG};
    uint8_t out[4];
    (void)state;
    p.sample_order = LUM_ORDER_BIG;
    lum_layout layout = checked(&p);
    assert_int_equal(lum_group_word(&g, 0), 0xabcde407u);
    lum_group_word_encode(&layout, 0xabcde407u, out);
    assert_memory_equal(out, word, 4);
    g.samples = angle;
    assert_int_equal(lum_group_angle(&layout, &g, 0).azimuth, -32767);
    assert_int_equal(lum_group_angle(&layout, &g, 0).elevation, 32766);
    lum_angle_encode(&layout, (lum_angle){-32767, 32766}, out);
    assert_memory_equal(out, angle, 4);
    p.angle_order = LUM_ELEVATION_AZIMUTH;
    layout = checked(&p);
    assert_int_equal(lum_group_angle(&layout, &g, 0).azimuth, 32766);
    lum_angle_encode(&layout, (lum_angle){32766, -32767}, out);
    assert_memory_equal(out, angle, 4);
}

/* --- Lines, the same in any order of samples --- */

static void send_mixed(struct stream *s)
{
    static const uint32_t first[] = {0x00001400 | 5, 0x00002400 | 9,
                                     0xfffff400 | 9};
    static const uint32_t second[] = {0x00003400 | 7, 0x00004c00 | 8,
                                      0x00005400 | 6};
    static const uint32_t third[] = {0x00003400 | 7};
    /* in order behind the others, in either order of bytes */
    static const uint32_t fourth[] = {0x10000400 | 40, 0x11000400 | 41};
    /* behind the others, and not in order */
    static const uint32_t fifth[] = {0x10000400 | 60, 0x11000400 | 70,
                                     0x12000400 | 65};
    assert_int_equal(send_words(s, LUM_EYE_BLUE, 1, 1000, 0, first, 3), LUM_OK);
    assert_int_equal(send_words(s, LUM_EYE_BLUE, 1, 1000, 3, second, 3),
                     LUM_OK);
    assert_int_equal(send_words(s, LUM_EYE_BLUE, 1, 1000, 3, third, 1),
                     LUM_E_DUPLICATE);
    assert_int_equal(send_words(s, LUM_EYE_BLUE, 1, 1000, 6, fourth, 2),
                     LUM_OK);
    assert_int_equal(send_words(s, LUM_EYE_BLUE, 1, 1000, 8, fifth, 3), LUM_OK);
    assert_int_equal(send_angles(s, LUM_EYE_BLUE, 1, 1000, 334, 334), LUM_OK);
    assert_int_equal(send_angles(s, LUM_EYE_BLUE, 1, 1000, 0, 334), LUM_OK);
    stream_end(s);
}

/* Words by their pixels, whatever they were sent in. */
static void assert_mixed(const lum_line *line)
{
    static const uint32_t words[] = {
        0x00001400 | 5,  0x00005400 | 6,  0x00003400 | 7,  0x00002400 | 9,
        0xfffff400 | 9,  0x10000400 | 40, 0x11000400 | 41, 0x10000400 | 60,
        0x12000400 | 65, 0x11000400 | 70};
    assert_int_equal(line->word_count, COUNT(words));
    assert_memory_equal(line->words, words, sizeof words);
}

static void lines_are_the_same_in_either_order(void **state)
{
    struct stream *plain = stream_open();
    (void)state;
    send_mixed(plain);
    const lum_line *want = nth_line(plain, 0);
    assert_mixed(want);
    for (unsigned i = 0; i < 4; i++) {
        struct stream *s = stream_new();
        s->layout.profile.sample_order = (uint8_t)(i & 1u);
        s->layout.profile.angle_order = (uint8_t)(i >> 1);
        stream_begin(s);
        send_mixed(s);
        const lum_line *line = nth_line(s, 0);
        assert_mixed(line);
        assert_memory_equal(line->angles, want->angles,
                            668 * sizeof(lum_angle));
        assert_int_equal(counters(s)->bad_words, 1);
        stream_free(s);
    }
    stream_free(plain);
}

/* --- Clocks --- */

/* In parts that fit 64 bits: a tick below 2^63, and its floor. */
static int64_t slow_us(uint64_t ticks, uint32_t unit_ns)
{
    const uint64_t rest = ticks % 1000u * unit_ns;
    return (int64_t)(ticks / 1000u * unit_ns + rest / 1000u);
}

static void ticks_are_floored(void **state)
{
    static const uint32_t units[] = {
        1, 2, 7, 10, 100, 333, 999, 1000, 1001, 1000000, 999999999, 1000000000};
    uint64_t random = 3;
    (void)state;
    for (size_t i = 0; i < COUNT(units); i++) {
        const uint32_t unit = units[i];
        for (uint64_t ticks = 0; ticks < 3000; ticks++) {
            const int64_t us = lum_clock_us(ticks, unit);
            assert_true(us == slow_us(ticks, unit));
            /* below 0, the next whole number below */
            const int64_t under = lum_clock_us(0u - ticks, unit);
            const bool is_whole = ticks * unit % 1000u == 0;
            assert_true(under == (is_whole ? -us : -us - 1));
        }
        for (unsigned k = 0; k < 2000; k++) {
            const uint64_t ticks =
                ((uint64_t)next_random(&random) << 32 | next_random(&random)) >>
                (4u + k % 60u);
            if (ticks / 1000u <= (UINT64_C(1) << 61) / unit) {
                assert_true(lum_clock_us(ticks, unit) == slow_us(ticks, unit));
            }
        }
    }
}

/* From 2^64 - 1000 x 2^52 on. */
static void the_lowest_ticks_are_those_that_still_are_below_0(void **state)
{
    const uint64_t lowest = 0u - (UINT64_C(1000) << 52);
    (void)state;
    assert_true(lum_clock_us(lowest, 1) == -(INT64_C(1) << 52));
    assert_true(lum_clock_us(lowest + 1000u, 1) == 1 - (INT64_C(1) << 52));
    assert_true(lum_clock_us(lowest - 1u, 1) ==
                (int64_t)((lowest - 1u) / 1000u));
    assert_true(lum_clock_us(lowest, 999) == -999 * (INT64_C(1) << 52));
}

static void a_clock_goes_on_past_2_to_63_ticks(void **state)
{
    const uint64_t before = (UINT64_C(1) << 63) - 500;
    const uint64_t after = lum_clock_extend(before, 700, 63);
    (void)state;
    assert_true(after == (UINT64_C(1) << 63) + 700);
    assert_true(lum_clock_us(after, 1) - lum_clock_us(before, 1) == 1);
    assert_true(lum_clock_us(after, 1) == INT64_C(9223372036854776));
}

static void each_width_wraps_at_its_own_bits(void **state)
{
    (void)state;
    for (unsigned bits = 2; bits < 64; bits++) {
        const uint64_t span = UINT64_C(1) << bits;
        const uint64_t half = span / 2;
        assert_true(lum_clock_extend(span, span - 1, bits) == span - 1);
        assert_true(lum_clock_extend(span - 1, 0, bits) == span);
        assert_true(lum_clock_extend(span, half - 1, bits) == span + half - 1);
        assert_true(lum_clock_extend(span, half, bits) == half);
        assert_true(lum_clock_extend(span, UINT64_MAX, bits) == span - 1);
    }
}

/* Sends words of a line whose packets have this clock. */
static lum_result tick(struct stream *s, uint32_t line, uint64_t ticks)
{
    const uint32_t word = lum_word_make(9, true, 1 + (uint32_t)(line % 900u));
    uint8_t sample[4];
    const lum_group g = {.line = line,
                         .num_samples = 1,
                         .clock_raw = ticks,
                         .tag = LUM_TAG_RANGES};
    lum_group_word_encode(&s->layout, word, sample);
    return send_group(s, &g, sample);
}

static struct stream *open_clock(lum_field field, uint32_t unit_ns)
{
    struct stream *s = stream_new();
    lum_profile p = usual();
    p.samples_at = 40;
    p.group[LUM_FIELD_TIMESTAMP] = field;
    p.clock_unit_ns = unit_ns;
    s->layout = checked(&p);
    stream_begin(s);
    return s;
}

static void an_assembler_hands_out_microseconds(void **state)
{
    struct stream *s = open_clock((lum_field){32, 8, 1, 0, 0}, 1);
    const uint64_t start = UINT64_MAX - 999;
    (void)state;
    for (uint32_t line = 0; line < 6; line++) {
        assert_int_equal(tick(s, line, start + line * 250u), LUM_OK);
    }
    stream_end(s);
    for (size_t i = 0; i < 6; i++) {
        const int64_t want =
            i < 4 ? INT64_C(9223372036854774) : INT64_C(9223372036854775);
        const uint64_t ticks = (UINT64_C(1) << 63) - 1000 + i * 250u;
        assert_true(nth_line(s, i)->clock_us == (int64_t)(ticks / 1000u));
        assert_true(nth_line(s, i)->clock_us >= want);
    }
    stream_free(s);
}

static void bits_of_a_clock_wrap_with_their_width(void **state)
{
    struct stream *s = open_clock((lum_field){32, 2, 0, 3, 10}, 10000);
    (void)state;
    assert_int_equal(tick(s, 1, 1020), LUM_OK);
    assert_int_equal(tick(s, 2, 1023), LUM_OK);
    assert_int_equal(tick(s, 3, 1), LUM_OK);
    stream_end(s);
    assert_true(nth_line(s, 0)->clock_us == 10200);
    assert_true(nth_line(s, 1)->clock_us == 10230);
    assert_true(nth_line(s, 2)->clock_us == 10250);
    stream_free(s);
}

/* A jump from near the last tick of 63 bits to the first, and beyond 2^61 us:
 * nothing overflows, and the clock is believed again. */
static void far_clocks_are_strays_and_harm_nothing(void **state)
{
    static const uint64_t far[] = {0, UINT64_MAX >> 1, UINT64_C(1) << 62,
                                   UINT64_C(3) << 61};
    (void)state;
    for (size_t i = 0; i < COUNT(far); i++) {
        struct stream *s = open_clock((lum_field){32, 8, 0, 0, 0}, 1000000000);
        assert_int_equal(tick(s, 1, 1000), LUM_OK);
        assert_int_equal(tick(s, 2, far[i]), LUM_E_STRAY);
        assert_int_equal(tick(s, 1, 1000), LUM_E_DUPLICATE);
        stream_free(s);
    }
}

static void a_receiver_takes_ticks_and_the_other_order(void **state)
{
    static lum_receiver r;
    static uint32_t room[4];
    uint8_t sample[4];
    lum_profile p = usual();
    (void)state;
    p.samples_at = 40;
    p.sample_order = LUM_ORDER_BIG;
    p.group[LUM_FIELD_TIMESTAMP] = (lum_field){32, 8, 1, 0, 0};
    p.clock_unit_ns = 1;
    const lum_layout layout = checked(&p);
    assert_int_equal(
        lum_receiver_init(&r, &layout, LUM_RECEIVER_GAP_US, room, COUNT(room)),
        LUM_OK);
    lum_group_word_encode(&layout, lum_word_make(9, true, 3), sample);
    lum_group g = {.samples = sample,
                   .line = 1,
                   .num_samples = 1,
                   .clock_raw = UINT64_C(5000000999),
                   .tag = LUM_TAG_RANGES,
                   .sample_order = LUM_ORDER_BIG};
    assert_int_equal(lum_receiver_push(&r, &g), LUM_OK);
    assert_int_equal(lum_receiver_line(&r)->words[0],
                     lum_word_make(9, true, 3));
    assert_true(lum_receiver_line(&r)->clock_us == 5000000);
    g.clock_raw += UINT64_C(100002000);
    assert_int_equal(lum_receiver_push(&r, &g), LUM_E_STRAY);
}

/* The clock of a receiver's first line, of 16 bits. */
static uint32_t first_clock(uint64_t raw)
{
    static lum_receiver r;
    static uint32_t room[4];
    uint8_t sample[4];
    lum_profile p = usual();
    p.samples_at = 40;
    p.group[LUM_FIELD_TIMESTAMP] = (lum_field){32, 2, 0, 0, 0};
    const lum_layout layout = checked(&p);
    assert_int_equal(
        lum_receiver_init(&r, &layout, LUM_RECEIVER_GAP_US, room, COUNT(room)),
        LUM_OK);
    lum_group_word_encode(&layout, lum_word_make(9, true, 3), sample);
    const lum_group g = {.samples = sample,
                         .line = 1,
                         .num_samples = 1,
                         .clock_raw = raw,
                         .tag = LUM_TAG_RANGES};
    assert_int_equal(lum_receiver_push(&r, &g), LUM_OK);
    return (uint32_t)lum_receiver_line(&r)->clock_us;
}

static void a_receivers_first_clock_is_as_sent(void **state)
{
    (void)state;
    assert_int_equal(first_clock(0), 0);
    assert_int_equal(first_clock(0x7fff), 0x7fff);
    assert_int_equal(first_clock(0x8000), 0x8000);
    assert_int_equal(first_clock(0xffff), 0xffff);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_of_field_has_its_value),
        cmocka_unit_test(a_line_of_more_than_32_bits_is_malformed),
        cmocka_unit_test(other_values_of_more_than_32_bits),
        cmocka_unit_test(a_long_line_behind_a_long_tag_is_malformed),
        cmocka_unit_test(without_a_count_the_length_tells),
        cmocka_unit_test(bits_lie_in_their_bytes),
        cmocka_unit_test(fields_share_bytes_only_as_different_bits),
        cmocka_unit_test(a_field_that_is_nowhere_overlaps_none),
        cmocka_unit_test(orders_and_ticks_have_their_limits),
        cmocka_unit_test(an_eyes_value_fits_its_bits),
        cmocka_unit_test(what_is_encoded_is_decoded),
        cmocka_unit_test(what_does_not_fit_its_bits_is_not_encoded),
        cmocka_unit_test(samples_in_the_other_order),
        cmocka_unit_test(lines_are_the_same_in_either_order),
        cmocka_unit_test(ticks_are_floored),
        cmocka_unit_test(the_lowest_ticks_are_those_that_still_are_below_0),
        cmocka_unit_test(a_clock_goes_on_past_2_to_63_ticks),
        cmocka_unit_test(each_width_wraps_at_its_own_bits),
        cmocka_unit_test(an_assembler_hands_out_microseconds),
        cmocka_unit_test(bits_of_a_clock_wrap_with_their_width),
        cmocka_unit_test(far_clocks_are_strays_and_harm_nothing),
        cmocka_unit_test(a_receiver_takes_ticks_and_the_other_order),
        cmocka_unit_test(a_receivers_first_clock_is_as_sent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
