/* compare [COUNT]: so many datagrams of each layout by the code for it alone,
 * and by layout_any.c: the same, bit for bit, as are clocks, angles and words.
 * On boards too, so text goes through examples/firmware/port. */
#include "compare.h"

#include "port/port.h"
#include "port/text.h"

#include <string.h>

#define HEAD    LUM_GROUP_HEAD_MAX
#define SAMPLES 40u
#define BYTES   (HEAD + LUM_SAMPLE_BYTES * (SAMPLES + 1u))
#define CLOCKS  40u /* packets that a clock follows */

static uint64_t random_state;

/* xorshift64* */
static uint64_t draw(void)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return random_state * UINT64_C(0x2545f4914f6cdd1d);
}

static uint32_t below(uint32_t n)
{
    return (uint32_t)(draw() >> 40) % n;
}

/* Once in eight. */
static bool is_rare(void)
{
    return below(8) == 0;
}

static void fail(size_t number, const char *what)
{
    text t = {{0}, 0};
    text_put(&t, "FAIL layout ");
    text_put_number(&t, number);
    text_put(&t, ": ");
    text_put(&t, what);
    text_end(&t);
}

/* --- Datagrams --- */

static unsigned bits_of(const lum_field *field)
{
    return field->bits > 0 ? field->bits : 8u * field->bytes;
}

static void set_field(uint8_t *b, const lum_field *field, uint64_t value)
{
    for (unsigned i = 0; i < bits_of(field); i++) {
        const unsigned bit = field->low + i;
        const unsigned byte = field->order == LUM_ORDER_BIG
                                  ? field->bytes - 1u - bit / 8u
                                  : bit / 8u;
        const unsigned mask = 1u << bit % 8u;
        const unsigned rest = b[field->at + byte] & ~mask;
        b[field->at + byte] =
            (uint8_t)(rest | ((value >> i & 1u) != 0 ? mask : 0));
    }
}

static uint32_t draw_count(uint32_t room)
{
    return is_rare() ? room + 1u - below(3) : 1u + below(room + 1u);
}

static void set_fields(uint8_t *b, const lum_profile *p, uint32_t room)
{
    const uint32_t n = draw_count(room);
    uint64_t values[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = is_rare() ? below(4) : LUM_TAG_ANGLES + below(2),
        [LUM_FIELD_EYE] = p->eye_values[below(LUM_EYES)] + is_rare(),
        [LUM_FIELD_LINE] = below(1u << 16),
        [LUM_FIELD_NUM_SAMPLES] = n,
        [LUM_FIELD_FIRST_SAMPLE_INDEX] =
            is_rare() ? LUM_LINE_PIXELS - n + below(3) : below(64),
        [LUM_FIELD_TIMESTAMP] = draw(),
    };
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        if (below(32) == 0) {
            values[f] = draw() >> below(64);
        }
        if (below(64) == 0) {
            values[f] ^= UINT64_C(1) << below(64);
        }
        if (p->group[f].bytes > 0) {
            set_field(b, &p->group[f], values[f]);
        }
    }
}

/* Bytes of no field are of any value. Returns its length. */
static size_t make_datagram(uint8_t *b, const lum_profile *p)
{
    const uint32_t room = below(SAMPLES + 1u);
    for (size_t i = 0; i < BYTES; i++) {
        b[i] = (uint8_t)(draw() >> 56);
    }
    if (is_rare()) {
        return below(BYTES + 1u);
    }
    set_fields(b, p, room);
    return p->samples_at + LUM_SAMPLE_BYTES * room + below(LUM_SAMPLE_BYTES);
}

/* --- Comparisons, each true where both agree --- */

static bool are_same(const lum_group *a, const lum_group *b)
{
    return a->samples == b->samples && a->clock_raw == b->clock_raw &&
           a->line == b->line && a->num_samples == b->num_samples &&
           a->first_sample_index == b->first_sample_index && a->eye == b->eye &&
           a->tag == b->tag && a->sample_order == b->sample_order;
}

/* What neither writes stays. The datagram ends where its array does. */
static bool agree_on_datagram(const struct code *code, lum_result *result)
{
    static uint8_t made[BYTES];
    static uint8_t bytes[BYTES];
    const lum_profile *p = &code->layout->profile;
    const size_t len = make_datagram(made, p);
    uint8_t *b = bytes + BYTES - len;
    lum_group is = {made, 1, 2, 3, 4, 5, 6, 7};
    lum_group should = is;
    memcpy(b, made, len);
    *result = lum_group_decode(code->layout, b, len, &should);
    return code->decode(code->layout, b, len, &is) == *result &&
           are_same(&is, &should);
}

/* NULL, or what is wrong. */
static const char *differ_on_datagrams(const struct code *code, uint32_t count)
{
    uint32_t good = 0;
    uint32_t unknown = 0;
    for (uint32_t i = 0; i < count; i++) {
        lum_result result = LUM_OK;
        if (!agree_on_datagram(code, &result)) {
            return "a datagram";
        }
        good += result == LUM_OK;
        unknown += result == LUM_E_UNKNOWN_TAG;
    }
    return good > count / 20u && unknown > 0 && good + unknown < count
               ? NULL
               : "too few datagrams of a kind were drawn";
}

static uint64_t draw_step(uint64_t half)
{
    switch (below(5)) {
    case 0:
        return draw();
    case 1:
        return half + below(3) - 1u;
    case 2:
        return 0 - (uint64_t)below(1000);
    default:
        return below(100000);
    }
}

/* From 0, or with a clock also from anywhere, as far as ticks go. */
static bool agree_on_clock(const struct code *code)
{
    const lum_profile *p = &code->layout->profile;
    const unsigned bits = bits_of(&p->group[LUM_FIELD_TIMESTAMP]);
    lum_clock is = {0, 0, 0, 0};
    lum_clock should = {0, 0, 0, 0};
    lum_group group = {NULL, 0, 0, 0, 0, 0, 0, 0};
    lum_clock_init(&should, p);
    code->clock_init(&is, p);
    if (bits > 0 && below(2) == 0) {
        should.lowest = draw();
        is.lowest = should.lowest;
    }
    uint64_t at = draw();
    for (unsigned i = 0; i < CLOCKS; i++) {
        uint64_t ticks = 1;
        uint64_t ticks_should = 2;
        at += draw_step(should.half);
        group.clock_raw = bits > 0 ? at & UINT64_MAX >> (64u - bits) : 0;
        const int64_t us = lum_clock_follow(&should, &group, &ticks_should);
        if (code->clock_follow(&is, &group, &ticks) != us ||
            ticks != ticks_should) {
            return false;
        }
        if (!is_rare()) {
            clock_take(&is, &ticks);
            clock_take(&should, &ticks);
        }
    }
    return is.half == should.half && is.lowest == should.lowest;
}

/* Angles behind the last stay as they are. */
static bool agree_on_samples(const struct code *code)
{
    static uint8_t bytes[BYTES];
    lum_angle is[SAMPLES + 1u];
    lum_angle should[SAMPLES + 1u];
    const lum_profile *p = &code->layout->profile;
    lum_group group = {bytes + below(8), 0, 0, 1u + below(SAMPLES), 0, 0, 0,
                       p->sample_order};
    for (size_t i = 0; i < BYTES; i++) {
        bytes[i] = (uint8_t)(draw() >> 56);
    }
    memset(is, 1, sizeof is);
    memset(should, 1, sizeof should);
    lum_layout_copy_angles(should, &group, p->angle_order);
    code->copy_angles(is, &group, p->angle_order);
    for (uint32_t i = 0; i < group.num_samples; i++) {
        if (code->word(&group, i) != lum_group_word(&group, i)) {
            return false;
        }
    }
    return memcmp(is, should, sizeof is) == 0;
}

/* --- Which layouts are read --- */

static uint8_t other(void)
{
    return (uint8_t)(1u + below(255));
}

static bool are_refused(const struct code *code)
{
    const lum_layout *own = code->layout;
    bool are = true;
    lum_layout l = *own;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        uint8_t *const bytes[] = {
            &l.profile.group[f].at, &l.profile.group[f].bytes,
            &l.profile.group[f].order, &l.profile.group[f].low,
            &l.profile.group[f].bits};
        for (unsigned i = 0; i < sizeof bytes / sizeof bytes[0]; i++) {
            *bytes[i] ^= other();
            are = are && !code->is_read(&l);
            l = *own;
        }
    }
    uint8_t *const bytes[] = {&l.profile.samples_at, &l.profile.angle_order,
                              &l.profile.sample_order};
    for (unsigned i = 0; i < sizeof bytes / sizeof bytes[0]; i++) {
        *bytes[i] ^= 1u;
        are = are && !code->is_read(&l);
        l = *own;
    }
    uint32_t *const words[] = {&l.profile.eye_values[LUM_EYE_BLUE],
                               &l.profile.eye_values[LUM_EYE_GREEN],
                               &l.profile.clock_unit_ns};
    for (unsigned i = 0; i < sizeof words / sizeof words[0]; i++) {
        *words[i] ^= UINT32_C(1) << below(32);
        are = are && !code->is_read(&l);
        l = *own;
    }
    return are;
}

/* With other values of what no data packet is read by. */
static bool is_read(const struct code *code)
{
    lum_layout l = *code->layout;
    lum_profile *p = &l.profile;
    if (!code->is_read(&l)) {
        return false;
    }
    p->data_packet_type ^= 1u;
    p->set_ip_order ^= 1u;
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        p->tlv[i] ^= other();
    }
    p->angle_lsb_pdeg++;
    p->line_span_us++;
    return code->is_read(&l) && lum_layout_is_read(&l);
}

/* --- All layouts --- */

static bool agree(size_t number, uint32_t count)
{
    const struct code *code = &codes[number];
    const char *what = NULL;
    random_state = UINT64_C(0x9e3779b97f4a7c15) + number;
    if (!is_read(code)) {
        what = "its own layout is not read";
    } else if (!are_refused(code)) {
        what = "another layout is read";
    } else {
        what = differ_on_datagrams(code, count);
    }
    for (uint32_t i = 0; i <= count / 20u && what == NULL; i++) {
        if (!agree_on_clock(code)) {
            what = "a clock";
        } else if (!agree_on_samples(code)) {
            what = "samples";
        }
    }
    if (what != NULL) {
        fail(number, what);
    }
    return what == NULL;
}

/* COUNT is in digits. */
static uint32_t number_of(const char *digits)
{
    uint32_t number = 0;
    for (; *digits >= '0' && *digits <= '9'; digits++) {
        number = 10u * number + (uint32_t)(*digits - '0');
    }
    return number;
}

int main(int argc, char **argv)
{
    const uint32_t count = argc > 1 ? number_of(argv[1]) : 20000u;
    size_t good = 0;
    text t = {{0}, 0};
    for (size_t i = 0; i < code_count; i++) {
        good += agree(i, count);
    }
    text_put_number(&t, good);
    text_put(&t, " of ");
    text_put_number(&t, code_count);
    text_put(&t, " layouts agree on ");
    text_put_number(&t, count);
    text_put(&t, " datagrams each");
    text_end(&t);
    return good == code_count && code_count > 0 && count > 0 ? 0 : 1;
}
