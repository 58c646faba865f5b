#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#ifdef LUM_TEST_CONFIG
#include "lum/config/config.h"
#include "lum/host/keys.h"
#endif
#include "lum/group.h"
#include "lum/infer/infer.h"
#include "lum/packet.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define SENSOR   0x0a2a0025u
#define HOST     0x0a2a0001u
#define KEPT_MAX 4000u
#define BYTES    1500u

/* A sensor that sends lines in a layout. */
struct maker {
    lum_profile profile;
    lum_layout layout;
    lum_infer *infer;
    uint32_t seed;
    uint32_t sensor;
    int64_t time_ns;
    uint64_t ticks;        /* of its clock */
    uint64_t ticks_line;   /* from line to line */
    int64_t line_ns;       /* the same in capture time */
    uint64_t ticks_eye;    /* of the green eye's clock, ahead */
    uint64_t ticks_packet; /* from packet to packet of a line */
    int64_t batch_ns;      /* times of capture are multiples of it */
    bool is_interleaved;   /* packets of the eyes take turns */
    bool is_swapped;       /* green comes first in every second pair
                            * of lines */
    unsigned eyes;         /* 1: blue alone */
    unsigned loss;         /* in 1000 packets */
    unsigned disorder;     /* likewise: behind the next packet */
    unsigned corrupt;      /* likewise */
    bool has_laser;        /* ranges come */
    bool is_even;          /* all packets have an even number of samples */
    uint8_t filler;        /* of bytes between fields */
    /* What else stands in a header. */
    void (*add)(struct maker *m, const lum_group *group, uint8_t *bytes);
    uint8_t marks[72]; /* what else stands there; 0: filler */
    uint8_t reserved;  /* of byte 9 */
    /* A field of two bytes, also there, that is num_samples in all but every
     * so-manieth packet; 0: there is none. */
    uint8_t echo_at;
    unsigned echo_fails;
    uint32_t sent;          /* packets */
    uint32_t lines;         /* lines */
    uint8_t held[BYTES];    /* a packet that comes later */
    size_t held_len;        /* 0: none */
    uint8_t (*kept)[BYTES]; /* what was sent, before any fault */
    size_t kept_len[KEPT_MAX];
    size_t kept_count;
};

static uint32_t random_of(struct maker *m, uint32_t below)
{
    m->seed = m->seed * 1664525u + 1013904223u;
    return (m->seed >> 8) % below;
}

static void begin(struct maker *m, const lum_profile *profile)
{
    const lum_infer_options options = {.struct_size = sizeof options};
    memset(m, 0, sizeof *m);
    m->profile = *profile;
    assert_int_equal(lum_layout_init(&m->layout, profile, NULL, NULL), LUM_OK);
    assert_int_equal(lum_infer_create(&options, &m->infer, NULL), 0);
    m->kept = malloc(KEPT_MAX * sizeof *m->kept);
    assert_non_null(m->kept);
    m->seed = 7;
    m->sensor = SENSOR;
    m->time_ns = INT64_C(1767225600000000000);
    m->ticks = 1000000;
    m->ticks_line = 1500;
    m->line_ns = 1500000;
    m->ticks_eye = 7;
    m->batch_ns = 1;
    m->eyes = 2;
    m->has_laser = true;
}

/* Forget what was pushed. */
static void begin_again(struct maker *m)
{
    const lum_infer_options options = {.struct_size = sizeof options};
    lum_infer_free(m->infer);
    assert_int_equal(lum_infer_create(&options, &m->infer, NULL), 0);
    m->time_ns = INT64_C(1767225600000000000);
}

static void end(struct maker *m)
{
    lum_infer_free(m->infer);
    free(m->kept);
}

static void push(struct maker *m, const uint8_t *bytes, size_t len)
{
    const lum_record record = {.time_ns = m->time_ns - m->time_ns % m->batch_ns,
                               .payload = bytes,
                               .len = len,
                               .source = m->sensor,
                               .destination = HOST,
                               .source_port = LUM_PORT,
                               .destination_port = 50000,
                               .kind = LUM_RECORD_DATAGRAM};
    assert_true(lum_infer_push(m->infer, &record, NULL) >= 0);
    m->time_ns += 10000;
}

static void push_held(struct maker *m)
{
    if (m->held_len > 0) {
        push(m, m->held, m->held_len);
        m->held_len = 0;
    }
}

/* Send a packet, with the faults that are due. */
static void post(struct maker *m, uint8_t *bytes, size_t len)
{
    if (m->kept_count < KEPT_MAX) {
        memcpy(m->kept[m->kept_count], bytes, len);
        m->kept_len[m->kept_count] = len;
        m->kept_count++;
    }
    if (random_of(m, 1000) < m->loss) {
        return;
    }
    if (random_of(m, 1000) < m->corrupt) {
        const uint32_t bit = random_of(m, (uint32_t)(8 * len));
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8u);
    }
    if (m->held_len == 0 && random_of(m, 1000) < m->disorder) {
        memcpy(m->held, bytes, len);
        m->held_len = len;
        return;
    }
    push(m, bytes, len);
    push_held(m);
}

/* Bytes of the header that no field has. */
static void fill(const struct maker *m, uint8_t *bytes)
{
    for (unsigned at = 12; at < m->profile.samples_at; at++) {
        bool is_free = true;
        for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
            const lum_field field = m->profile.group[f];
            is_free = is_free &&
                      (at < field.at || at >= (unsigned)field.at + field.bytes);
        }
        const uint8_t mark = m->marks[at] != 0 ? m->marks[at] : m->filler;
        bytes[at] = is_free ? mark : bytes[at];
    }
    bytes[9] = m->reserved;
}

static void echo(struct maker *m, uint32_t n, uint8_t *bytes)
{
    if (m->echo_at != 0) {
        n += m->kept_count % m->echo_fails == 0 ? 1000u : 0u;
        bytes[m->echo_at] = (uint8_t)(n & 0xffu);
        bytes[m->echo_at + 1u] = (uint8_t)(n >> 8);
    }
}

static uint64_t within(const struct maker *m, uint64_t ticks)
{
    const lum_field clock = m->profile.group[LUM_FIELD_TIMESTAMP];
    const unsigned bits = clock.bits != 0 ? clock.bits : 8u * clock.bytes;
    return bits == 0 || bits >= 64 ? ticks
                                   : ticks & ((UINT64_C(1) << bits) - 1u);
}

static size_t head(struct maker *m, lum_group *group, uint8_t *bytes)
{
    size_t len = 0;
    group->clock_raw = within(m, m->ticks + m->ticks_eye * group->eye);
    assert_int_equal(lum_group_encode(&m->layout, group, bytes, BYTES, &len),
                     LUM_OK);
    fill(m, bytes);
    echo(m, group->num_samples, bytes);
    if (m->add != NULL) {
        m->add(m, group, bytes);
    }
    m->ticks += m->ticks_packet;
    m->sent++;
    return len;
}

static void send_angles(struct maker *m, lum_group group, unsigned part,
                        uint32_t lines)
{
    uint8_t bytes[BYTES];
    const uint32_t line = group.line;
    group.tag = LUM_TAG_ANGLES;
    group.first_sample_index = 334 * part;
    group.num_samples = part == 2 ? 332 : 334;
    size_t len = head(m, &group, bytes);
    for (uint32_t k = 0; k < group.num_samples; k++) {
        const int pixel = (int)(334 * part + k);
        const int up = (line & 1) != 0 ? -1 : 1;
        const lum_angle angle = {
            (int16_t)(up * (65 * pixel - 32000) + (int)random_of(m, 9)),
            (int16_t)(30000 - (int)(60000u / lines * line) +
                      (int)random_of(m, 9))};
        lum_angle_encode(&m->layout, angle, bytes + len);
        len += LUM_SAMPLE_BYTES;
    }
    post(m, bytes, len);
}

/* @param first word of the packet; gets that of the next. */
static void send_ranges(struct maker *m, lum_group group, uint32_t *first)
{
    uint8_t bytes[BYTES];
    group.tag = LUM_TAG_RANGES;
    group.first_sample_index = *first;
    group.num_samples = *first == 0 ? 350 - random_of(m, 5) : 50;
    group.num_samples &= m->is_even ? ~1u : ~0u;
    size_t len = head(m, &group, bytes);
    for (uint32_t k = 0; k < group.num_samples; k++) {
        const uint32_t pixel = 2 * (*first + k);
        const uint32_t word = (3000 + pixel + random_of(m, 20)) << 12 |
                              LUM_WORD_RISING | (pixel & LUM_WORD_PIXEL);
        lum_group_word_encode(&m->layout, word, bytes + len);
        len += LUM_SAMPLE_BYTES;
    }
    post(m, bytes, len);
    *first += group.num_samples;
}

#define PARTS 6u

static void send_part(struct maker *m, unsigned eye, unsigned part,
                      uint32_t line, uint32_t lines, uint32_t *first)
{
    const lum_group group = {.line = line, .eye = (uint8_t)eye};
    if (part < 3) {
        send_angles(m, group, part, lines);
    } else if (m->has_laser && *first < 400) {
        send_ranges(m, group, first);
    }
}

static void send_line(struct maker *m, uint32_t line, uint32_t lines)
{
    const int64_t begin_ns = m->time_ns;
    const uint64_t begin_ticks = m->ticks;
    uint32_t first[2] = {0, 0};
    for (unsigned i = 0; i < m->eyes * PARTS; i++) {
        unsigned eye = m->is_interleaved ? i % m->eyes : i / PARTS;
        eye ^= m->is_swapped ? line >> 1 & 1u : 0u;
        const unsigned part = m->is_interleaved ? i / m->eyes : i % PARTS;
        send_part(m, eye, part, line, lines, &first[eye]);
    }
    m->ticks = begin_ticks + m->ticks_line;
    m->time_ns = begin_ns + m->line_ns;
    m->lines++;
}

static void send_frames(struct maker *m, uint32_t frames, uint32_t lines)
{
    for (uint32_t frame = 0; frame < frames; frame++) {
        for (uint32_t line = 0; line < lines; line++) {
            send_line(m, line, lines);
        }
    }
    push_held(m);
}

/* The profile's text loads, and as the profile. */
static void check_yaml(const lum_infer_result *r)
{
    char text[LUM_INFER_YAML_BYTES];
    const size_t len = lum_infer_write_yaml(r, text, sizeof text);
    assert_in_range(len, 1, sizeof text - 1);
#ifdef LUM_TEST_CONFIG
    lum_profile loaded;
    lum_error error = {""};
    lum_keys keys;
    char wanted[LUM_KEYS_WRITE_BYTES];
    char got[LUM_KEYS_WRITE_BYTES];
    if (lum_profile_parse(text, len, "found", &loaded, &error) != 0) {
        fail_msg("%s", error.text);
    }
    lum_keys_of_profile(&keys, &r->profile);
    (void)lum_keys_write(&keys, wanted, sizeof wanted);
    lum_keys_of_profile(&keys, &loaded);
    (void)lum_keys_write(&keys, got, sizeof got);
    assert_string_equal(got, wanted);
#endif
}

/* In how many packets, as they were before any fault, two profiles differ;
 * eyes count up to a swap of their names. */
static size_t differences(const struct maker *m, const lum_profile *one,
                          const lum_profile *two)
{
    size_t other[2] = {0, 0};
    lum_layout a;
    lum_layout b;
    assert_int_equal(lum_layout_init(&a, one, NULL, NULL), LUM_OK);
    assert_int_equal(lum_layout_init(&b, two, NULL, NULL), LUM_OK);
    for (size_t i = 0; i < m->kept_count; i++) {
        lum_group x;
        lum_group y;
        if (lum_group_decode(&a, m->kept[i], m->kept_len[i], &x) != LUM_OK ||
            lum_group_decode(&b, m->kept[i], m->kept_len[i], &y) != LUM_OK) {
            other[0]++;
            other[1]++;
            continue;
        }
        for (unsigned flip = 0; flip < 2; flip++) {
            other[flip] += x.eye != (y.eye ^ flip) || x.line != y.line ||
                           x.tag != y.tag || x.num_samples != y.num_samples ||
                           x.first_sample_index != y.first_sample_index ||
                           x.clock_raw != y.clock_raw;
        }
    }
    return other[0] < other[1] ? other[0] : other[1];
}

/* What holds for each result with a profile. */
static void check_profile_of(const struct maker *m, const lum_infer_result *r)
{
    lum_layout layout;
    assert_int_equal(lum_layout_init(&layout, &r->profile, NULL, NULL), LUM_OK);
    assert_int_equal(r->finding_count, LUM_INFER_KEYS);
    assert_in_range(r->margin_key, LUM_INFER_TAG, LUM_INFER_SAMPLES);
    assert_in_range(r->fit, 1, r->counts.packets);
    assert_true(r->margin >= 0.0 && r->margin <= 100.0);
    if (r->margin < LUM_INFER_MARGIN_SURE) {
        assert_int_equal(r->verdict, LUM_INFER_UNSURE);
    }
    if (r->has_second) {
        assert_true(differences(m, &r->profile, &r->second) * 100 >
                    m->kept_count);
    }
    check_yaml(r);
}

static void solve(struct maker *m, lum_infer_result *out, int expected)
{
    memset(out, 0, sizeof *out);
    out->struct_size = sizeof *out;
    assert_int_equal(lum_infer_solve(m->infer, out, NULL), expected);
    assert_true(out->text[0] != '\0');
    assert_int_equal(out->has_profile, expected == 0);
    assert_true(out->has_profile || !out->has_second);
    if (out->has_profile) {
        check_profile_of(m, out);
    }
}

/* All packets, as they were before any fault, decode alike. */
static void check_profile(const struct maker *m, const lum_profile *found)
{
    lum_layout layout;
    lum_group a;
    lum_group b;
    assert_int_equal(lum_layout_init(&layout, found, NULL, NULL), LUM_OK);
    for (size_t i = 0; i < m->kept_count; i++) {
        assert_int_equal(
            lum_group_decode(&m->layout, m->kept[i], m->kept_len[i], &a),
            LUM_OK);
        assert_int_equal(
            lum_group_decode(&layout, m->kept[i], m->kept_len[i], &b), LUM_OK);
        assert_int_equal(a.tag, b.tag);
        assert_int_equal(a.eye, b.eye);
        assert_int_equal(a.line, b.line);
        assert_int_equal(a.num_samples, b.num_samples);
        assert_int_equal(a.first_sample_index, b.first_sample_index);
        assert_true(a.clock_raw == b.clock_raw);
        if (a.tag == LUM_TAG_ANGLES) {
            const lum_angle x = lum_group_angle(&m->layout, &a, 300);
            const lum_angle y = lum_group_angle(&layout, &b, 300);
            assert_int_equal(x.azimuth, y.azimuth);
            assert_int_equal(x.elevation, y.elevation);
        } else {
            assert_int_equal(lum_group_word(&a, 0), lum_group_word(&b, 0));
        }
    }
}

static void finds_it(struct maker *m)
{
    lum_infer_result r;
    solve(m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_FOUND);
    check_profile(m, &r.profile);
    assert_int_equal(r.profile.clock_unit_ns, m->profile.clock_unit_ns);
}

static lum_profile default_profile(void)
{
    lum_profile profile;
    lum_profile_default(&profile);
    return profile;
}

/* Clocks of eight bytes, counts of the other order, an eye above the line. */
static lum_profile wide_profile(void)
{
    lum_profile p = default_profile();
    p.data_packet_type = 3;
    p.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){.at = 12, .bytes = 8, .order = LUM_ORDER_BIG};
    p.group[LUM_FIELD_LINE] =
        (lum_field){.at = 22, .bytes = 2, .order = LUM_ORDER_BIG, .bits = 15};
    p.group[LUM_FIELD_EYE] = (lum_field){
        .at = 22, .bytes = 2, .order = LUM_ORDER_BIG, .low = 15, .bits = 1};
    p.group[LUM_FIELD_TAG] = (lum_field){.at = 21, .bytes = 1};
    p.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 26, .bytes = 2, .order = LUM_ORDER_BIG};
    p.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.bytes = 0};
    p.samples_at = 29;
    p.sample_order = LUM_ORDER_BIG;
    p.angle_order = LUM_ELEVATION_AZIMUTH;
    p.clock_unit_ns = 100;
    return p;
}

static void one_frame_of_the_default_layout_is_enough(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    finds_it(&m);
    end(&m);
}

static void a_wide_layout_is_found(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = wide_profile();
    begin(&m, &profile);
    m.filler = 0xa5;
    m.ticks_line = 15000;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

static void loss_disorder_and_corruption_do_no_harm(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = wide_profile();
    begin(&m, &profile);
    m.filler = 0xff;
    m.ticks_line = 15000;
    m.loss = 50;
    m.disorder = 50;
    m.corrupt = 20;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

static void the_tag_can_be_the_type(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TAG] = (lum_field){.at = 8, .bytes = 1};
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    finds_it(&m);
    end(&m);
}

static void tag_and_eye_can_share_a_byte(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TAG] =
        (lum_field){.at = 12, .bytes = 1, .low = 4, .bits = 4};
    profile.group[LUM_FIELD_EYE] = (lum_field){.at = 12, .bytes = 1, .bits = 4};
    profile.eye_values[LUM_EYE_BLUE] = 6;
    profile.eye_values[LUM_EYE_GREEN] = 9;
    begin(&m, &profile);
    m.filler = 0x11;
    send_frames(&m, 1, 64);
    finds_it(&m);
    end(&m);
}

static void a_layout_needs_no_clock(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.bytes = 0};
    begin(&m, &profile);
    m.filler = 0x33;
    send_frames(&m, 1, 64);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes, 0);
    end(&m);
}

static void narrow_clocks_and_their_wraps_are_found(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 20, .bytes = 2};
    begin(&m, &profile);
    m.filler = 0x33;
    send_frames(&m, 3, 64);
    finds_it(&m);
    end(&m);
}

/* Of green, 20 us ahead, lines of blue follow 7 us before their time. */
static void a_clock_that_wraps_between_lines_is_not_denied(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 21, .bytes = 1};
    begin(&m, &profile);
    m.ticks_line = 6 * 256 + 13;
    m.ticks_eye = 20;
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_non_null(strstr(r.text, "byte 21 may be a clock"));
    assert_false(r.findings[LUM_INFER_TIMESTAMP].is_told);
    assert_non_null(strstr(r.findings[LUM_INFER_TIMESTAMP].look, "byte 21"));
    end(&m);
}

static void add_noise(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)group;
    bytes[22] = (uint8_t)random_of(m, 256);
}

static void noise_below_a_clock_that_wraps_is_unsure(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 21, .bytes = 1};
    begin(&m, &profile);
    m.add = add_noise;
    m.ticks_line = 6 * 256 + 26;
    m.line_ns = 1562000;
    m.ticks_eye = 3;
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes, 2);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_non_null(strstr(r.text, "no round length"));
    end(&m);
}

/* Their lowest bit, which is always 0, is none of the tag below it, and none of
 * the count. */
static void beginnings_may_be_even(void **state)
{
    (void)state;
    static const unsigned below[] = {LUM_FIELD_TAG, LUM_FIELD_NUM_SAMPLES};
    static const uint8_t bits[] = {2, 10};
    for (size_t i = 0; i < 2; i++) {
        struct maker m;
        const lum_field word = {.at = 26, .bytes = 4};
        lum_profile profile = default_profile();
        profile.samples_at = 30;
        profile.group[below[i]] = word;
        profile.group[below[i]].bits = bits[i];
        profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] = word;
        profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].low =
            (uint8_t)(bits[i] + 1u);
        profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].bits = 17;
        begin(&m, &profile);
        m.is_even = true;
        m.filler = 0x36;
        send_frames(&m, 2, 64);
        finds_it(&m);
        end(&m);
    }
}

static void a_clock_can_wrap(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.ticks = UINT64_C(0xffffffff) - 50000;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

static void frames_of_640_lines_are_read(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.line_ns = 150000;
    m.ticks_line = 150;
    send_frames(&m, 1, 640);
    finds_it(&m);
    end(&m);
}

/* Lines of both eyes, from one in the middle on. */
static void send_middle(struct maker *m, uint32_t lines)
{
    for (uint32_t line = 24; line < 24 + lines; line++) {
        send_line(m, line, 64);
    }
}

static void a_few_lines_in_the_middle_are_enough(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_middle(&m, 16);
    finds_it(&m);
    end(&m);
}

static void too_few_lines_to_exclude_chance_are_unsure(void **state)
{
    (void)state;
    static const uint32_t lines[] = {3, 7, 15};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        struct maker m;
        lum_infer_result r;
        const lum_profile profile = default_profile();
        begin(&m, &profile);
        send_middle(&m, lines[i]);
        solve(&m, &r, 0);
        assert_int_equal(r.verdict, LUM_INFER_UNSURE);
        assert_non_null(strstr(r.text, "lines are too few to be sure"));
        check_profile(&m, &r.profile);
        end(&m);
    }
}

/* Its ticks are multiples of 32, and the line number is beside them. */
static void lowest_bits_of_a_clock_are_none_of_a_line_number(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_EYE] = (lum_field){.at = 16, .bytes = 1};
    profile.group[LUM_FIELD_LINE] =
        (lum_field){.at = 20, .bytes = 2, .order = LUM_ORDER_BIG};
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 22, .bytes = 8};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 33, .bytes = 2};
    profile.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.bytes = 0};
    profile.samples_at = 35;
    profile.clock_unit_ns = 1;
    begin(&m, &profile);
    m.filler = 124;
    m.ticks = UINT64_C(5000000000);
    m.ticks_line = 1500000;
    m.ticks_eye = 20000;
    send_frames(&m, 1, 64);
    finds_it(&m);
    end(&m);
}

/* Read in the order of the counts, the line number would begin with the highest
 * byte of the clock, which is 0. */
static void the_highest_byte_of_a_clock_is_none_of_a_line_number(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_NUM_SAMPLES] =
        (lum_field){.at = 24, .bytes = 4, .order = LUM_ORDER_BIG};
    profile.group[LUM_FIELD_TAG] = (lum_field){.at = 15, .bytes = 1};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 17, .bytes = 4, .order = LUM_ORDER_BIG};
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 30, .bytes = 4};
    profile.group[LUM_FIELD_LINE] = (lum_field){.at = 34, .bytes = 2};
    profile.group[LUM_FIELD_EYE] = (lum_field){.at = 36, .bytes = 1};
    profile.samples_at = 38;
    begin(&m, &profile);
    m.filler = 211;
    m.ticks = 5000000;
    m.ticks_eye = 0;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

/* Two numbers in one word, and zeros above them and beside it. */
static void a_line_number_ends_within_its_word(void **state)
{
    (void)state;
    struct maker m;
    const lum_field word = {.at = 20, .bytes = 8, .order = LUM_ORDER_BIG};
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.at = 12, .bytes = 2};
    profile.group[LUM_FIELD_EYE] = (lum_field){.at = 14, .bytes = 1};
    profile.group[LUM_FIELD_TAG] = (lum_field){.at = 16, .bytes = 1};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] = word;
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].bits = 14;
    profile.group[LUM_FIELD_LINE] = word;
    profile.group[LUM_FIELD_LINE].low = 14;
    profile.group[LUM_FIELD_LINE].bits = 13;
    profile.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){.at = 28, .bytes = 8, .order = LUM_ORDER_BIG};
    profile.samples_at = 40;
    begin(&m, &profile);
    m.filler = 88;
    send_frames(&m, 3, 64);
    finds_it(&m);
    end(&m);
}

/* The line's other neighbour is the highest byte of the clock, which is 0. */
static void an_eye_above_the_line_outweighs_the_order_of_the_counts(
    void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TAG] = (lum_field){.at = 8, .bytes = 1};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 14, .bytes = 4, .order = LUM_ORDER_BIG};
    profile.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.at = 19, .bytes = 2};
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 21, .bytes = 4};
    profile.group[LUM_FIELD_LINE] =
        (lum_field){.at = 25, .bytes = 2, .bits = 15};
    profile.group[LUM_FIELD_EYE] =
        (lum_field){.at = 25, .bytes = 2, .low = 15, .bits = 1};
    profile.samples_at = 29;
    begin(&m, &profile);
    m.ticks = 5000000;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

/* One frame of 64 lines, as short as it is at 10 Hz. */
static void a_unit_that_is_not_round_is_measured(void **state)
{
    (void)state;
    static const uint32_t units[] = {256, 30517};
    for (unsigned i = 0; i < 2; i++) {
        struct maker m;
        lum_infer_result r;
        lum_profile profile = default_profile();
        profile.clock_unit_ns = units[i];
        begin(&m, &profile);
        m.line_ns = 500000;
        m.ticks_line = 500000 / units[i];
        m.line_ns = (int64_t)(m.ticks_line * units[i]);
        send_frames(&m, 1, 64);
        solve(&m, &r, 0);
        assert_int_equal(r.verdict, LUM_INFER_FOUND);
        check_profile(&m, &r.profile);
        assert_in_range(r.profile.clock_unit_ns, units[i] * 99 / 100,
                        units[i] * 101 / 100);
        assert_true(r.findings[LUM_INFER_CLOCK_UNIT].is_told);
        assert_true(r.findings[LUM_INFER_LINE_SPAN].is_told);
        end(&m);
    }
}

/* Packets are handed over every 8 ms. */
static void a_unit_that_varies_is_not_told(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.clock_unit_ns = 30517;
    begin(&m, &profile);
    m.ticks_line = 16;
    m.line_ns = 16 * 30517;
    m.batch_ns = 8000000;
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    check_profile(&m, &r.profile);
    assert_in_range(r.profile.clock_unit_ns, 25000, 36000);
    assert_false(r.findings[LUM_INFER_CLOCK_UNIT].is_told);
    assert_false(r.findings[LUM_INFER_LINE_SPAN].is_told);
    assert_non_null(strstr(r.findings[LUM_INFER_CLOCK_UNIT].look, "again"));
    end(&m);
}

static void without_times_the_clock_is_not_told(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.batch_ns = INT64_C(1000000000000);
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    check_profile(&m, &r.profile);
    const lum_infer_finding *clock = &r.findings[LUM_INFER_TIMESTAMP];
    assert_false(clock->is_told);
    assert_non_null(strstr(clock->evidence, "no times"));
    assert_non_null(strstr(clock->look, "record again"));
    assert_false(r.findings[LUM_INFER_CLOCK_UNIT].is_told);
    assert_false(r.findings[LUM_INFER_LINE_SPAN].is_told);
    assert_int_equal(r.profile.clock_unit_ns, 1000);
    end(&m);
}

/* The clocks of both eyes are 7 us apart, lines 500: some of the clock's bits
 * are the eye and something slow, and others are the eye itself. */
static lum_profile nanoseconds_profile(void)
{
    lum_profile p = default_profile();
    p.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){.at = 12, .bytes = 8, .order = LUM_ORDER_BIG};
    p.group[LUM_FIELD_NUM_SAMPLES] =
        (lum_field){.at = 21, .bytes = 2, .order = LUM_ORDER_BIG};
    p.group[LUM_FIELD_EYE] = (lum_field){.at = 23, .bytes = 1};
    p.group[LUM_FIELD_TAG] = (lum_field){.at = 25, .bytes = 1};
    p.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 26, .bytes = 2, .order = LUM_ORDER_BIG};
    p.group[LUM_FIELD_LINE] =
        (lum_field){.at = 28, .bytes = 2, .order = LUM_ORDER_BIG};
    p.samples_at = 30;
    p.eye_values[LUM_EYE_BLUE] = 65;
    p.eye_values[LUM_EYE_GREEN] = 68;
    p.clock_unit_ns = 1;
    return p;
}

static void send_nanoseconds(struct maker *m)
{
    m->ticks = UINT64_C(100000000000);
    m->ticks_line = 500000;
    m->line_ns = 500000;
    m->ticks_eye = 7000;
    send_frames(m, 1, 64);
}

static void clocks_of_eyes_a_few_us_apart_tell_no_eye(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = nanoseconds_profile();
    begin(&m, &profile);
    send_nanoseconds(&m);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_false(r.has_second);
    assert_null(strstr(r.findings[LUM_INFER_LINE].evidence, "87."));
    end(&m);
}

/* A number in three bits of the eye's byte. */
static void add_in_eye(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)group;
    bytes[23] |= (uint8_t)((m->lines & 7u) << 3);
}

static void a_counter_beside_the_eye_is_not_the_eye(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = nanoseconds_profile();
    begin(&m, &profile);
    m.add = add_in_eye;
    send_nanoseconds(&m);
    profile.group[LUM_FIELD_EYE].bits = 3;
    profile.eye_values[LUM_EYE_BLUE] = 1;
    profile.eye_values[LUM_EYE_GREEN] = 4;
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_FOUND);
    assert_int_equal(r.profile.clock_unit_ns, 1);
    assert_int_equal(differences(&m, &r.profile, &profile), 0);
    end(&m);
}

/* Without round ticks, a clock with the bytes below it follows time as well as
 * the clock alone. */
static void what_stands_below_a_clock_is_not_the_clocks(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct maker m;
        lum_profile profile = default_profile();
        profile.clock_unit_ns = 30517;
        profile.group[LUM_FIELD_NUM_SAMPLES] =
            (lum_field){.at = 14, .bytes = 2};
        profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
            (lum_field){.at = 16, .bytes = 2};
        profile.group[LUM_FIELD_LINE] =
            (lum_field){.at = 18, .bytes = 2, .bits = 15};
        profile.group[LUM_FIELD_EYE] =
            (lum_field){.at = 18, .bytes = 2, .low = 15, .bits = 1};
        if (i == 0) {
            profile.group[LUM_FIELD_LINE] = (lum_field){.at = 27, .bytes = 2};
            profile.group[LUM_FIELD_EYE] = (lum_field){.at = 19, .bytes = 1};
        }
        profile.samples_at = 29;
        lum_infer_result r;
        begin(&m, &profile);
        m.ticks_line = 16;
        m.line_ns = 16 * 30517;
        send_frames(&m, 2, 64);
        solve(&m, &r, 0);
        assert_int_equal(r.verdict, LUM_INFER_FOUND);
        check_profile(&m, &r.profile);
        end(&m);
    }
}

/* --- What packets do not tell apart --- */

/* A number of four bytes behind the usual fields. */
static lum_profile long_profile(void)
{
    lum_profile p = default_profile();
    p.samples_at = 28;
    return p;
}

static void put_32(uint8_t *bytes, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(value >> 8 * i);
    }
}

static void add_lines(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)group;
    put_32(bytes + 24, m->lines + 700000);
}

static void two_line_numbers_are_unsure(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = long_profile();
    begin(&m, &profile);
    m.add = add_lines;
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_non_null(strstr(r.text, "unsure"));
    assert_true(r.has_second);
    assert_int_equal(r.second.group[LUM_FIELD_TIMESTAMP].at, 20);
    check_profile(&m, &r.profile);
    end(&m);
}

static void so_they_are_where_eyes_do_not_take_turns(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = long_profile();
    begin(&m, &profile);
    m.add = add_lines;
    m.is_swapped = true;
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_int_equal(r.margin_key, LUM_INFER_LINE);
    end(&m);
}

static void frames_tell_the_line_number_from_a_count_of_lines(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = long_profile();
    begin(&m, &profile);
    m.add = add_lines;
    send_frames(&m, 3, 64);
    finds_it(&m);
    end(&m);
}

/* It runs faster than the clock, by 1.5 percent. */
static void add_clock(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    put_32(bytes + 24, (uint32_t)(group->clock_raw + m->lines * 22u));
}

static void two_clocks_are_unsure(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = long_profile();
    begin(&m, &profile);
    m.add = add_clock;
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_true(r.has_second);
    assert_true(r.second.group[LUM_FIELD_TIMESTAMP].at !=
                r.profile.group[LUM_FIELD_TIMESTAMP].at);
    end(&m);
}

/* The same number twice. */
static void add_copies(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)m;
    bytes[24] = (uint8_t)(group->line & 0xffu);
    bytes[25] = (uint8_t)(group->line >> 8);
    bytes[26] = (uint8_t)(group->eye + 4u);
}

static void fields_that_tell_the_same_are_equal(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = long_profile();
    begin(&m, &profile);
    m.filler = 0x77;
    m.add = add_copies;
    send_frames(&m, 2, 64);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_string_equal(r.findings[LUM_INFER_LINE].equal, "{at: 24, bytes: 2}");
    assert_string_equal(r.findings[LUM_INFER_EYE].equal, "{at: 26, bytes: 1}");
    end(&m);
}

static void add_count(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)group;
    put_32(bytes + 20, 5000 + m->sent);
}

static void a_count_of_packets_is_no_clock(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.bytes = 0};
    begin(&m, &profile);
    m.add = add_count;
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

/* --- Lines --- */

static void packets_of_eyes_may_take_turns(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.is_interleaved = true;
    m.ticks_line = 5500;
    m.line_ns = 5500000;
    m.ticks_packet = 450;
    m.disorder = 50;
    send_frames(&m, 2, 64);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_in_range(r.profile.line_span_us, 8000, 11000);
    end(&m);
}

static void long_lines_are_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.ticks_line = 140000;
    m.line_ns = 140000000;
    m.ticks_packet = 12000;
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.line_span_us, 99900);
    assert_non_null(
        strstr(r.findings[LUM_INFER_LINE_SPAN].evidence, "less than 100000"));
    end(&m);
}

/* The step is half of 64 bits, and back. */
static void the_top_bit_of_a_clock_may_be_corrupt(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = nanoseconds_profile();
    begin(&m, &profile);
    send_nanoseconds(&m);
    uint8_t *last = m.kept[m.kept_count - 1];
    last[12] ^= 0x80;
    push(&m, last, m.kept_len[m.kept_count - 1]);
    last[12] ^= 0x80;
    push(&m, last, m.kept_len[m.kept_count - 1]);
    finds_it(&m);
    end(&m);
}

/* --- One eye --- */

static void one_eye_alone_is_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.eyes = 1;
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_FOUND);
    assert_non_null(strstr(r.text, "only one eye is seen"));
    assert_false(r.findings[LUM_INFER_EYE].is_told);
    assert_non_null(strstr(r.findings[LUM_INFER_EYE].look, "both eyes"));
    check_profile(&m, &r.profile);
    end(&m);
}

/* Byte 13, where the eye is by default, is the clock's. */
static void one_eye_alone_takes_nothing_of_the_clock(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = nanoseconds_profile();
    begin(&m, &profile);
    m.eyes = 1;
    send_nanoseconds(&m);
    solve(&m, &r, 0);
    const lum_field clock = r.profile.group[LUM_FIELD_TIMESTAMP];
    assert_int_equal(clock.at, 12);
    assert_int_equal(clock.bytes, 8);
    assert_int_equal(r.profile.clock_unit_ns, 1);
    assert_false(r.findings[LUM_INFER_EYE].is_told);
    end(&m);
}

/* Each byte is of a field. */
static void one_eye_alone_may_be_the_line_numbers_top_bit(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_TAG] = (lum_field){.at = 8, .bytes = 1};
    profile.group[LUM_FIELD_LINE] =
        (lum_field){.at = 12, .bytes = 2, .bits = 15};
    profile.group[LUM_FIELD_EYE] =
        (lum_field){.at = 12, .bytes = 2, .low = 15, .bits = 1};
    profile.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.at = 14, .bytes = 2};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 16, .bytes = 2};
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 18, .bytes = 4};
    profile.samples_at = 22;
    begin(&m, &profile);
    m.eyes = 1;
    m.ticks = 100000000;
    send_frames(&m, 2, 64);
    solve(&m, &r, 0);
    check_profile(&m, &r.profile);
    assert_false(r.findings[LUM_INFER_EYE].is_told);
    end(&m);
}

static void sensors_are_kept_apart(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    uint8_t foreign[100] = {1, 2, 3};
    begin(&m, &profile);
    for (uint32_t line = 0; line < 128; line++) {
        m.sensor = SENSOR + line % 2;
        m.ticks += line % 2 == 0 ? 77777777u : (uint64_t)0 - 77777777u;
        send_line(&m, line / 2, 64);
        push(&m, foreign, sizeof foreign);
    }
    solve(&m, &r, 0);
    check_profile(&m, &r.profile);
    assert_int_equal(r.counts.sensors, 2);
    assert_int_equal(r.counts.foreign, 128);
    end(&m);
}

static void what_is_not_told_is_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    char text[LUM_INFER_YAML_BYTES];
    char cut[100];
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    assert_false(r.findings[LUM_INFER_EYE_VALUES].is_told);
    assert_false(r.findings[LUM_INFER_ANGLE_LSB].is_told);
    assert_true(r.findings[LUM_INFER_EYE_VALUES].look[0] != '\0');
    for (unsigned key = 0; key < LUM_INFER_KEYS; key++) {
        assert_int_equal(r.findings[key].key, key);
        assert_non_null(r.findings[key].name);
        assert_true(r.findings[key].value[0] != '\0');
        assert_true(r.findings[key].evidence[0] != '\0');
    }
    assert_string_equal(r.findings[LUM_INFER_NUM_SAMPLES].equal,
                        "\"none\", since the datagram's length tells the same");
    assert_string_equal(r.findings[LUM_INFER_TAG].equal,
                        "{at: 12, bytes: 1, bits: [0, 1]}, since the bits "
                        "above are 0 in 100.0 % of packets");
    const size_t len = lum_infer_write_yaml(&r, text, sizeof text);
    assert_int_equal(len, strlen(text));
    assert_non_null(strstr(text, "\nversion: 1\n"));
    assert_non_null(strstr(text, "\n  samples: 24\n"));
    assert_int_equal(lum_infer_write_yaml(&r, cut, sizeof cut), len);
    assert_int_equal(strlen(cut), sizeof cut - 1);
    assert_int_equal(lum_infer_write_yaml(&r, NULL, 0), len);
    end(&m);
}

/* No profile, with a verdict and a reason. */
static void finds_nothing(struct maker *m, lum_infer_verdict verdict)
{
    lum_infer_result r;
    char text[64];
    solve(m, &r, 1);
    assert_int_equal(r.verdict, verdict);
    assert_false(r.has_profile);
    assert_int_equal(r.finding_count, 0);
    assert_true(r.text[0] != '\0');
    assert_int_equal(lum_infer_write_yaml(&r, text, sizeof text), 0);
}

static void put_head(uint8_t *bytes, uint8_t type)
{
    static const uint8_t magic[] = {0xed, 0xfe, 0xf3, 0xa1,
                                    0xef, 0xbe, 0x34, 0x12};
    memcpy(bytes, magic, sizeof magic);
    memset(bytes + 8, 0, 4);
    bytes[8] = type;
}

static void random_bytes_are_no_layout(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    uint8_t bytes[BYTES];
    begin(&m, &profile);
    for (unsigned i = 0; i < 2000; i++) {
        for (size_t k = 0; k < sizeof bytes; k++) {
            bytes[k] = (uint8_t)random_of(&m, 256);
        }
        put_head(bytes, 8);
        push(&m, bytes, 900 + random_of(&m, 500));
    }
    finds_nothing(&m, LUM_INFER_NOTHING_FITS);
    solve(&m, &r, 1);
    assert_int_equal(r.counts.other_type, 2000);
    end(&m);
}

/* Blocks of an azimuth and 32 ranges with a reflectivity, as other lidars have
 * them. */
static void packets_of_another_maker_are_no_layout(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    uint8_t bytes[BYTES];
    begin(&m, &profile);
    for (unsigned i = 0; i < 2000; i++) {
        put_head(bytes, 8);
        size_t at = 12;
        for (unsigned block = 0; block < 12; block++) {
            const unsigned azimuth = (12 * i + block) * 20 % 36000;
            bytes[at++] = 0xff;
            bytes[at++] = 0xee;
            bytes[at++] = (uint8_t)(azimuth & 0xffu);
            bytes[at++] = (uint8_t)(azimuth >> 8);
            for (unsigned k = 0; k < 32; k++) {
                const unsigned range = 2000 + 100 * k + random_of(&m, 10);
                bytes[at++] = (uint8_t)(range & 0xffu);
                bytes[at++] = (uint8_t)(range >> 8);
                bytes[at++] = (uint8_t)random_of(&m, 100);
            }
        }
        push(&m, bytes, at);
    }
    finds_nothing(&m, LUM_INFER_NOTHING_FITS);
    end(&m);
}

static void control_packets_alone_are_too_little(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    uint8_t bytes[BYTES] = {0};
    begin(&m, &profile);
    for (unsigned i = 0; i < 300; i++) {
        put_head(bytes, (uint8_t)(5 + i % 4));
        push(&m, bytes, i % 4 == 3 ? 12 : 22);
    }
    finds_nothing(&m, LUM_INFER_TOO_LITTLE);
    solve(&m, &r, 1);
    assert_int_equal(r.counts.control, 300);
    end(&m);
}

static void nothing_and_a_few_lines_are_too_little(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    finds_nothing(&m, LUM_INFER_TOO_LITTLE);
    send_line(&m, 0, 64);
    send_line(&m, 1, 64);
    finds_nothing(&m, LUM_INFER_TOO_LITTLE);
    end(&m);
}

static void angles_alone_are_too_little(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.has_laser = false;
    send_frames(&m, 1, 64);
    finds_nothing(&m, LUM_INFER_TOO_LITTLE);
    end(&m);
}

/* Packets of our samples whose headers are random. */
static void headers_without_fields_are_no_layout(void **state)
{
    (void)state;
    struct maker m;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    begin_again(&m);
    for (size_t i = 0; i < m.kept_count; i++) {
        for (size_t at = 12; at < 24; at++) {
            m.kept[i][at] = (uint8_t)random_of(&m, 256);
        }
        push(&m, m.kept[i], m.kept_len[i]);
    }
    finds_nothing(&m, LUM_INFER_NOTHING_FITS);
    end(&m);
}

static void only_the_sensor_that_was_asked_for_counts(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    const lum_infer_options options = {.struct_size = sizeof options,
                                       .has_sensor = true,
                                       .sensor = SENSOR + 1};
    begin(&m, &profile);
    lum_infer_free(m.infer);
    assert_int_equal(lum_infer_create(&options, &m.infer, NULL), 0);
    send_frames(&m, 1, 64);
    solve(&m, &r, 1);
    assert_int_equal(r.verdict, LUM_INFER_TOO_LITTLE);
    assert_int_equal(r.counts.packets, 0);
    end(&m);
}

static void it_says_when_it_has_enough(void **state)
{
    (void)state;
    lum_infer *infer = NULL;
    uint8_t bytes[100] = {0};
    const lum_infer_options options = {.struct_size = sizeof options,
                                       .packets_max = 10};
    lum_record record = {.payload = bytes,
                         .len = sizeof bytes,
                         .source_port = LUM_PORT,
                         .kind = LUM_RECORD_DATAGRAM};
    const lum_record other = {.kind = LUM_RECORD_OTHER};
    assert_int_equal(lum_infer_create(&options, &infer, NULL), 0);
    put_head(bytes, 8);
    for (unsigned i = 0; i < 9; i++) {
        assert_int_equal(lum_infer_push(infer, &record, NULL), 1);
        assert_int_equal(lum_infer_push(infer, &other, NULL), 1);
    }
    assert_int_equal(lum_infer_push(infer, &record, NULL), 0);
    assert_int_equal(lum_infer_push(infer, &record, NULL), 0);
    assert_int_equal(lum_infer_push(infer, &other, NULL), 0);
    record.kind = LUM_RECORD_CUT_SHORT;
    assert_int_equal(lum_infer_push(infer, &record, NULL), 0);
    lum_infer_result r = {.struct_size = sizeof r};
    assert_int_equal(lum_infer_solve(infer, &r, NULL), 1);
    assert_true(r.counts.is_full);
    assert_int_equal(r.counts.left_out, 2);
    assert_int_equal(r.counts.elsewhere, 10);
    assert_int_equal(r.counts.cut_short, 0);
    lum_infer_free(infer);
    lum_infer_free(NULL);
}

static void joined_datagrams_are_looked_at_one_by_one(void **state)
{
    (void)state;
    lum_infer *infer = NULL;
    uint8_t bytes[5u * 100u] = {0};
    const lum_infer_options options = {.struct_size = sizeof options,
                                       .packets_max = 4};
    const lum_record record = {.payload = bytes,
                               .len = sizeof bytes - 20u,
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    assert_int_equal(lum_infer_create(&options, &infer, NULL), 0);
    for (size_t at = 0; at < sizeof bytes; at += 100u) {
        put_head(bytes + at, 8);
    }
    assert_int_equal(lum_infer_push(infer, &record, NULL), 0);
    lum_infer_result r = {.struct_size = sizeof r};
    assert_int_equal(lum_infer_solve(infer, &r, NULL), 1);
    assert_int_equal(r.counts.joined, 4);
    assert_int_equal(r.counts.left_out, 1);
    lum_infer_free(infer);
}

static void wrong_options_are_refused(void **state)
{
    (void)state;
    lum_error error;
    lum_infer *infer = NULL;
    lum_infer_result r = {.struct_size = 0};
    lum_infer_options options = {.struct_size = 0};
    assert_int_equal(lum_infer_create(&options, &infer, &error), -1);
    assert_null(infer);
    options.struct_size = sizeof options;
    options.packets_max = LUM_INFER_PACKETS_MAX + 1;
    assert_int_equal(lum_infer_create(&options, &infer, &error), -1);
    assert_non_null(strstr(error.text, "20000"));
    options.packets_max = 0;
    assert_int_equal(lum_infer_create(&options, &infer, &error), 0);
    assert_int_equal(lum_infer_solve(infer, &r, &error), -1);
    assert_non_null(strstr(error.text, "struct_size"));
    lum_infer_free(infer);
}

/* --- Fields that share bytes --- */

static void two_numbers_in_four_bytes_are_found(void **state)
{
    (void)state;
    for (unsigned order = 0; order < 2; order++) {
        struct maker m;
        lum_profile profile = default_profile();
        profile.group[LUM_FIELD_LINE] = (lum_field){
            .at = 14, .bytes = 4, .order = (uint8_t)order, .bits = 12};
        profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
            (lum_field){.at = 14,
                        .bytes = 4,
                        .order = (uint8_t)order,
                        .low = 12,
                        .bits = 16};
        profile.group[LUM_FIELD_NUM_SAMPLES] =
            (lum_field){.at = 18, .bytes = 2};
        begin(&m, &profile);
        send_frames(&m, 2, 64);
        finds_it(&m);
        end(&m);
    }
}

static void three_numbers_in_eight_bytes_are_found(void **state)
{
    (void)state;
    struct maker m;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_LINE] =
        (lum_field){.at = 14, .bytes = 8, .bits = 13};
    profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX] =
        (lum_field){.at = 14, .bytes = 8, .low = 13, .bits = 14};
    profile.group[LUM_FIELD_NUM_SAMPLES] =
        (lum_field){.at = 14, .bytes = 8, .low = 27, .bits = 14};
    profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 22, .bytes = 4};
    profile.samples_at = 26;
    begin(&m, &profile);
    send_frames(&m, 2, 64);
    finds_it(&m);
    end(&m);
}

/* The line's six bits are those of little-endian bytes, the index's ten those
 * of big-endian ones, and both bytes are the same. */
static void fields_that_no_profile_can_say_are_named(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 2, 64);
    begin_again(&m);
    for (size_t i = 0; i < m.kept_count; i++) {
        uint8_t *p = m.kept[i];
        const unsigned line = p[14];
        const unsigned first = p[18] | (unsigned)p[19] << 8;
        p[14] = (uint8_t)((line & 3u) << 6 | first >> 4);
        p[15] = (uint8_t)((first & 15u) << 4 | line >> 2);
        p[18] = 0;
        p[19] = 0;
        push(&m, p, m.kept_len[i]);
    }
    solve(&m, &r, 1);
    assert_int_equal(r.verdict, LUM_INFER_NOTHING_FITS);
    assert_non_null(
        strstr(r.text, "group.line and group.first_sample_index, as"));
    end(&m);
}

/* --- How sure it is --- */

static void a_field_that_says_nearly_the_same_is_the_second_best(void **state)
{
    (void)state;
    static const struct {
        unsigned fails;
        lum_infer_verdict verdict;
    } all[] = {
        {16, LUM_INFER_FOUND}, {40, LUM_INFER_FOUND}, {70, LUM_INFER_UNSURE}};
    for (unsigned i = 0; i < 3; i++) {
        struct maker m;
        lum_infer_result r;
        lum_profile profile = default_profile();
        profile.samples_at = 28;
        begin(&m, &profile);
        m.echo_at = 25;
        m.echo_fails = all[i].fails;
        send_frames(&m, 2, 64);
        solve(&m, &r, 0);
        check_profile(&m, &r.profile);
        assert_int_equal(r.verdict, all[i].verdict);
        assert_int_equal(r.margin_key, LUM_INFER_NUM_SAMPLES);
        assert_true(r.margin > 80.0 / all[i].fails);
        assert_true(r.margin < 120.0 / all[i].fails);
        assert_true(r.has_second);
        assert_int_equal(r.second.group[LUM_FIELD_NUM_SAMPLES].at, 25);
        assert_non_null(strstr(r.text, "of group.num_samples"));
        end(&m);
    }
}

/* The profile's evidence for a key bears a text. */
static void check_evidence(const lum_infer_result *r, lum_infer_key key,
                           const char *text)
{
    if (strstr(r->findings[key].evidence, text) == NULL) {
        fail_msg("'%s' is not in '%s'", text, r->findings[key].evidence);
    }
}

static void other_fields_for_the_first_index_are_told(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    check_evidence(&r, LUM_INFER_FIRST_SAMPLE_INDEX,
                   "100.0 % of packets; no other field has all three");
    end(&m);
}

static void packets_that_do_not_fit_make_it_unsure(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    /* Too few samples to tell what they are, and a tag that is none. */
    for (size_t i = 0; i < m.kept_count / 2; i++) {
        m.kept[i][12] = 9;
        m.kept[i][16] = 4;
        m.kept[i][17] = 0;
        push(&m, m.kept[i], 24 + 4 * 4);
    }
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_int_equal(r.fit, m.kept_count);
    assert_non_null(strstr(r.text, "packets do not fit"));
    end(&m);
}

static void samples_that_nothing_confirms_are_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_NUM_SAMPLES] = (lum_field){.bytes = 0};
    begin(&m, &profile);
    m.filler = 0x33;
    send_frames(&m, 1, 64);
    begin_again(&m);
    for (size_t i = 0; i < m.kept_count; i++) {
        const bool is_angles = m.kept[i][12] == LUM_TAG_ANGLES;
        push(&m, m.kept[i], m.kept_len[i] - (is_angles ? 80 : 0));
    }
    solve(&m, &r, 0);
    assert_int_equal(r.verdict, LUM_INFER_UNSURE);
    assert_non_null(strstr(r.text, "nothing confirms where samples begin"));
    end(&m);
}

/* --- Bytes that no field needs --- */

static void one_constant_byte_makes_no_clock_wide(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.samples_at = 31;
    begin(&m, &profile);
    m.marks[30] = 7;
    send_frames(&m, 2, 64);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes, 4);
    assert_int_equal(r.profile.group[LUM_FIELD_LINE].bytes, 2);
    assert_non_null(
        strstr(r.findings[LUM_INFER_TIMESTAMP].equal, "{at: 20, bytes: 8}"));
    assert_non_null(strstr(r.findings[LUM_INFER_TIMESTAMP].equal,
                           "0 in 100.0 % of packets"));
    end(&m);
}

/* Eight bytes of which four do not change are a clock of four too, in either
 * order, until those wrap. */
static void an_upper_half_that_stands_is_told(void **state)
{
    (void)state;
    static const uint32_t upper[] = {1, 0x17979cfeu, UINT32_MAX};
    for (unsigned i = 0; i < 12; i++) {
        struct maker m;
        lum_infer_result r;
        const bool is_big = i / 3 % 2 == 1;
        const bool wraps = i >= 6;
        lum_profile profile = default_profile();
        profile.group[LUM_FIELD_TIMESTAMP] = (lum_field){
            .at = 20, .bytes = 8, .order = is_big ? LUM_ORDER_BIG : 0};
        profile.samples_at = 28;
        begin(&m, &profile);
        m.ticks = (uint64_t)upper[i % 3] << 32 |
                  (wraps ? UINT32_MAX - 64 * 1500u : 1000000u);
        send_frames(&m, 2, 64);
        solve(&m, &r, 0);
        const lum_field clock = r.profile.group[LUM_FIELD_TIMESTAMP];
        const char *equal = r.findings[LUM_INFER_TIMESTAMP].equal;
        assert_int_equal(clock.bytes, wraps ? 8 : 4);
        if (!wraps) {
            assert_non_null(strstr(equal, is_big ? "{at: 20, bytes: 8, order"
                                                 : "{at: 20, bytes: 8}"));
            assert_non_null(strstr(equal, "do not change; a recording of more "
                                          "than 4295.0 s shows"));
        } else {
            finds_it(&m);
            assert_null(strstr(equal, "bytes: 4"));
        }
        end(&m);
    }
}

/* A number that stands above a clock, and changes once when the clock does not
 * wrap. */
static void add_other(struct maker *m, const lum_group *group, uint8_t *bytes)
{
    (void)group;
    put_32(bytes + 24, 0x17979cfeu + (m->lines > 20 ? 1u : 0u));
}

static void what_changes_above_a_clock_is_not_the_clocks(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.samples_at = 28;
    begin(&m, &profile);
    m.add = add_other;
    send_frames(&m, 2, 64);
    finds_it(&m);
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes, 4);
    assert_string_equal(r.findings[LUM_INFER_TIMESTAMP].equal, "");
    end(&m);
}

static void filler_widens_a_clock_of_short_ticks_alone(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct maker m;
        lum_infer_result r;
        lum_profile profile = default_profile();
        profile.samples_at = 31;
        profile.clock_unit_ns = i == 0 ? 1000 : 10;
        begin(&m, &profile);
        m.ticks_line = 1500000 / profile.clock_unit_ns;
        m.marks[28] = 0x5a;
        m.marks[29] = 0x5a;
        m.marks[30] = 0x5a;
        send_frames(&m, 2, 64);
        finds_it(&m);
        solve(&m, &r, 0);
        assert_int_equal(r.profile.group[LUM_FIELD_TIMESTAMP].bytes,
                         i == 0 ? 4 : 8);
        assert_non_null(strstr(r.findings[LUM_INFER_TIMESTAMP].equal,
                               i == 0 ? "bytes: 8" : "{at: 20, bytes: 4}"));
        end(&m);
    }
}

/* A corrupt packet in the middle does not hide what the others bear. */
static void filler_is_what_most_packets_bear(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_profile profile = default_profile();
    profile.group[LUM_FIELD_LINE] = (lum_field){.at = 32, .bytes = 4};
    profile.samples_at = 40;
    begin(&m, &profile);
    m.filler = 0x5a;
    send_frames(&m, 2, 64);
    begin_again(&m);
    for (size_t i = 0; i < m.kept_count; i++) {
        const size_t middle = m.kept_count / 2;
        if (i + 3 > middle && i < middle + 3) {
            memset(m.kept[i] + 14, 0x33, 2);
            memset(m.kept[i] + 24, 0x11, 8);
            memset(m.kept[i] + 36, 0x22, 4);
        }
        push(&m, m.kept[i], m.kept_len[i]);
    }
    solve(&m, &r, 0);
    assert_int_equal(r.profile.group[LUM_FIELD_LINE].bytes, 4);
    end(&m);
}

/* --- What was not looked at --- */

static void packets_that_are_cut_are_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    lum_record record = {.source = SENSOR,
                         .destination = HOST,
                         .source_port = LUM_PORT,
                         .destination_port = 50000,
                         .kind = LUM_RECORD_CUT_SHORT};
    begin(&m, &profile);
    for (unsigned i = 0; i < 90; i++) {
        assert_int_equal(lum_infer_push(m.infer, &record, NULL), 1);
    }
    record.source_port = 9;
    assert_int_equal(lum_infer_push(m.infer, &record, NULL), 1);
    solve(&m, &r, 1);
    assert_int_equal(r.verdict, LUM_INFER_TOO_LITTLE);
    assert_int_equal(r.counts.cut_short, 90);
    assert_non_null(strstr(r.text, "90 datagrams"));
    assert_non_null(strstr(r.text, "tcpdump -s 0"));
    end(&m);
}

static void reserved_bytes_that_are_not_0_are_said(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    m.reserved = 1;
    send_frames(&m, 1, 64);
    solve(&m, &r, 1);
    assert_int_equal(r.verdict, LUM_INFER_NOTHING_FITS);
    assert_non_null(strstr(r.text, "bytes 9 to 11 of "));
    assert_int_equal(r.counts.other_type, m.kept_count - r.counts.packets);
    end(&m);
}

static void what_is_left_out_is_counted(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    const lum_profile profile = default_profile();
    uint8_t other[200] = {0};
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    put_head(other, 77);
    push(&m, other, sizeof other);
    for (unsigned i = 0; i < 20; i++) {
        m.sensor = SENSOR + i;
        put_head(other, 8);
        push(&m, other, sizeof other);
    }
    solve(&m, &r, 0);
    assert_int_equal(r.counts.sensors, 16);
    assert_int_equal(r.counts.left_out, 4);
    assert_int_equal(r.counts.other_type, 1);
    assert_false(r.counts.is_full);
    end(&m);
}

/* An elevation of one packet that is far off tells nothing about how far
 * angles reach. */
static void a_corrupt_packet_does_not_stretch_the_angles(void **state)
{
    (void)state;
    struct maker m;
    lum_infer_result r;
    lum_infer_result corrupt;
    const lum_profile profile = default_profile();
    begin(&m, &profile);
    send_frames(&m, 1, 64);
    solve(&m, &r, 0);
    check_evidence(&r, LUM_INFER_ANGLE_LSB, "azimuths reach -3");
    begin_again(&m);
    size_t last = m.kept_count - 1;
    while (m.kept[last][12] != LUM_TAG_ANGLES) {
        last--;
    }
    m.kept[last][24 + 4 * 10 + 3] &= (uint8_t)~0x08u;
    for (size_t i = 0; i < m.kept_count; i++) {
        push(&m, m.kept[i], m.kept_len[i]);
    }
    solve(&m, &corrupt, 0);
    assert_string_equal(corrupt.findings[LUM_INFER_ANGLE_LSB].equal,
                        r.findings[LUM_INFER_ANGLE_LSB].equal);
    end(&m);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(one_frame_of_the_default_layout_is_enough),
    cmocka_unit_test(a_wide_layout_is_found),
    cmocka_unit_test(loss_disorder_and_corruption_do_no_harm),
    cmocka_unit_test(the_tag_can_be_the_type),
    cmocka_unit_test(tag_and_eye_can_share_a_byte),
    cmocka_unit_test(a_layout_needs_no_clock),
    cmocka_unit_test(narrow_clocks_and_their_wraps_are_found),
    cmocka_unit_test(a_clock_that_wraps_between_lines_is_not_denied),
    cmocka_unit_test(noise_below_a_clock_that_wraps_is_unsure),
    cmocka_unit_test(beginnings_may_be_even),
    cmocka_unit_test(a_clock_can_wrap),
    cmocka_unit_test(frames_of_640_lines_are_read),
    cmocka_unit_test(a_few_lines_in_the_middle_are_enough),
    cmocka_unit_test(too_few_lines_to_exclude_chance_are_unsure),
    cmocka_unit_test(lowest_bits_of_a_clock_are_none_of_a_line_number),
    cmocka_unit_test(the_highest_byte_of_a_clock_is_none_of_a_line_number),
    cmocka_unit_test(a_line_number_ends_within_its_word),
    cmocka_unit_test(an_eye_above_the_line_outweighs_the_order_of_the_counts),
    cmocka_unit_test(a_unit_that_is_not_round_is_measured),
    cmocka_unit_test(a_unit_that_varies_is_not_told),
    cmocka_unit_test(without_times_the_clock_is_not_told),
    cmocka_unit_test(clocks_of_eyes_a_few_us_apart_tell_no_eye),
    cmocka_unit_test(a_counter_beside_the_eye_is_not_the_eye),
    cmocka_unit_test(what_stands_below_a_clock_is_not_the_clocks),
    cmocka_unit_test(two_line_numbers_are_unsure),
    cmocka_unit_test(so_they_are_where_eyes_do_not_take_turns),
    cmocka_unit_test(frames_tell_the_line_number_from_a_count_of_lines),
    cmocka_unit_test(two_clocks_are_unsure),
    cmocka_unit_test(fields_that_tell_the_same_are_equal),
    cmocka_unit_test(a_count_of_packets_is_no_clock),
    cmocka_unit_test(packets_of_eyes_may_take_turns),
    cmocka_unit_test(long_lines_are_said),
    cmocka_unit_test(the_top_bit_of_a_clock_may_be_corrupt),
    cmocka_unit_test(one_eye_alone_is_said),
    cmocka_unit_test(one_eye_alone_takes_nothing_of_the_clock),
    cmocka_unit_test(one_eye_alone_may_be_the_line_numbers_top_bit),
    cmocka_unit_test(sensors_are_kept_apart),
    cmocka_unit_test(what_is_not_told_is_said),
    cmocka_unit_test(random_bytes_are_no_layout),
    cmocka_unit_test(packets_of_another_maker_are_no_layout),
    cmocka_unit_test(control_packets_alone_are_too_little),
    cmocka_unit_test(nothing_and_a_few_lines_are_too_little),
    cmocka_unit_test(angles_alone_are_too_little),
    cmocka_unit_test(headers_without_fields_are_no_layout),
    cmocka_unit_test(only_the_sensor_that_was_asked_for_counts),
    cmocka_unit_test(it_says_when_it_has_enough),
    cmocka_unit_test(joined_datagrams_are_looked_at_one_by_one),
    cmocka_unit_test(wrong_options_are_refused),
    cmocka_unit_test(two_numbers_in_four_bytes_are_found),
    cmocka_unit_test(three_numbers_in_eight_bytes_are_found),
    cmocka_unit_test(fields_that_no_profile_can_say_are_named),
    cmocka_unit_test(a_field_that_says_nearly_the_same_is_the_second_best),
    cmocka_unit_test(other_fields_for_the_first_index_are_told),
    cmocka_unit_test(packets_that_do_not_fit_make_it_unsure),
    cmocka_unit_test(samples_that_nothing_confirms_are_said),
    cmocka_unit_test(one_constant_byte_makes_no_clock_wide),
    cmocka_unit_test(an_upper_half_that_stands_is_told),
    cmocka_unit_test(what_changes_above_a_clock_is_not_the_clocks),
    cmocka_unit_test(filler_widens_a_clock_of_short_ticks_alone),
    cmocka_unit_test(filler_is_what_most_packets_bear),
    cmocka_unit_test(packets_that_are_cut_are_said),
    cmocka_unit_test(reserved_bytes_that_are_not_0_are_said),
    cmocka_unit_test(what_is_left_out_is_counted),
    cmocka_unit_test(a_corrupt_packet_does_not_stretch_the_angles),
};

int main(void)
{
    return cmocka_run_group_tests(tests, NULL, NULL);
}
