#include "lum/group.h"

#include "bytes.h"
#include "check.h"
#include "group.h"
#include "lum/wire.h"

#include <string.h>

/* Four bytes can be read at any field: a sample at least is behind them. */
static uint32_t load_field(const uint8_t *packet, const lum_field *field)
{
    if (field->bytes == 0) {
        return 0;
    }
    const unsigned spare = 32u - 8u * field->bytes;
    return load_u32(packet + field->at) << spare >> spare;
}

static void store_field(uint8_t *packet, const lum_field *field, uint32_t value)
{
    for (unsigned i = 0; i < field->bytes; i++) {
        packet[field->at + i] = (uint8_t)(value & 0xffu);
        value >>= 8;
    }
}

lum_result lum_group_check(uint32_t tag, uint32_t n, uint32_t first)
{
    if (n == 0) {
        return LUM_E_MALFORMED;
    }
    if (tag == LUM_TAG_ANGLES) {
        return n <= LUM_LINE_PIXELS && first <= LUM_LINE_PIXELS - n
                   ? LUM_OK
                   : LUM_E_MALFORMED;
    }
    return tag == LUM_TAG_RANGES ? LUM_OK : LUM_E_UNKNOWN_TAG;
}

lum_result lum_group_decode(const lum_layout *layout, const void *bytes,
                            size_t len, lum_group *out)
{
    const lum_profile *p = &layout->profile;
    const uint8_t *b = bytes;
    uint32_t v[LUM_GROUP_FIELDS];
    if (len < p->samples_at + LUM_SAMPLE_BYTES) {
        return LUM_E_MALFORMED;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        v[f] = load_field(b, &p->group[f]);
    }
    const uint32_t n = v[LUM_FIELD_NUM_SAMPLES];
    const uint8_t eye = v[LUM_FIELD_EYE] == p->eye_values[LUM_EYE_BLUE]
                            ? LUM_EYE_BLUE
                            : LUM_EYE_GREEN;
    if (n > (len - p->samples_at) / LUM_SAMPLE_BYTES ||
        v[LUM_FIELD_EYE] != p->eye_values[eye]) {
        return LUM_E_MALFORMED;
    }
    const lum_result r =
        lum_group_check(v[LUM_FIELD_TAG], n, v[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (r != LUM_OK) {
        return r;
    }
    out->samples = b + p->samples_at;
    out->line = v[LUM_FIELD_LINE];
    out->num_samples = n;
    out->first_sample_index = v[LUM_FIELD_FIRST_SAMPLE_INDEX];
    out->clock_raw = v[LUM_FIELD_TIMESTAMP];
    out->eye = eye;
    out->tag = (uint8_t)v[LUM_FIELD_TAG];
    return LUM_OK;
}

static bool fits(uint32_t value, const lum_field *field)
{
    return field->bytes == 4 || value >> (8u * field->bytes) == 0;
}

/* With the tag on the packet type's byte the tag is the type. */
static uint8_t header_type(const lum_profile *p, const lum_group *g)
{
    return p->group[LUM_FIELD_TAG].at < LUM_HEADER_BYTES
               ? g->tag
               : (uint8_t)p->data_packet_type;
}

LUM_CHECK_BUILD(the_clock_is_the_last_field,
                LUM_FIELD_TIMESTAMP + 1 == LUM_GROUP_FIELDS);

lum_result lum_group_encode(const lum_layout *layout, const lum_group *group,
                            void *out, size_t size, size_t *len)
{
    const lum_profile *p = &layout->profile;
    if (group->eye >= LUM_EYES ||
        lum_group_check(group->tag, group->num_samples,
                        group->first_sample_index) != LUM_OK) {
        return LUM_E_VALUE;
    }
    const uint32_t values[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = group->tag,
        [LUM_FIELD_EYE] = p->eye_values[group->eye],
        [LUM_FIELD_LINE] = group->line,
        [LUM_FIELD_NUM_SAMPLES] = group->num_samples,
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = group->first_sample_index,
        [LUM_FIELD_TIMESTAMP] = (uint32_t)group->clock_raw,
    };
    for (unsigned f = 0; f < LUM_FIELD_TIMESTAMP; f++) {
        if (!fits(values[f], &p->group[f])) {
            return LUM_E_VALUE;
        }
    }
    if (size < p->samples_at) {
        return LUM_E_SPACE;
    }
    memset(out, 0, p->samples_at);
    lum_header_encode(out, header_type(p, group));
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        store_field(out, &p->group[f], values[f]);
    }
    *len = p->samples_at;
    return LUM_OK;
}

lum_angle lum_group_angle(const lum_layout *layout, const lum_group *group,
                          uint32_t i)
{
    const uint8_t *p = group->samples + (size_t)LUM_SAMPLE_BYTES * i;
    const int16_t a = signed16(load_u16(p));
    const int16_t b = signed16(load_u16(p + 2));
    return layout->profile.angle_order == LUM_AZIMUTH_ELEVATION
               ? (lum_angle){a, b}
               : (lum_angle){b, a};
}

void lum_angle_encode(const lum_layout *layout, lum_angle angle,
                      uint8_t out[LUM_SAMPLE_BYTES])
{
    const bool swapped = layout->profile.angle_order == LUM_ELEVATION_AZIMUTH;
    const int16_t a = swapped ? angle.elevation : angle.azimuth;
    const int16_t b = swapped ? angle.azimuth : angle.elevation;
    store_u16(out, (uint32_t)a & 0xffffu);
    store_u16(out + 2, (uint32_t)b & 0xffffu);
}

uint32_t lum_group_word(const lum_group *group, uint32_t i)
{
    return load_u32(group->samples + (size_t)LUM_SAMPLE_BYTES * i);
}

void lum_word_encode(uint32_t word, uint8_t out[LUM_SAMPLE_BYTES])
{
    store_u32(out, word);
}
