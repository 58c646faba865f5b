#include "lum/group.h"

#include "bytes.h"
#include "lum/wire.h"

#include <string.h>

static uint32_t load_field(const uint8_t *packet, lum_field field)
{
    const uint8_t *p = packet + field.at;
    switch (field.bytes) {
    case 4:
        return load_u32(p);
    case 2:
        return load_u16(p);
    case 1:
        return p[0];
    default:
        return 0;
    }
}

static void store_field(uint8_t *packet, lum_field field, uint32_t value)
{
    for (unsigned i = 0; i < field.bytes; i++) {
        packet[field.at + i] = (uint8_t)((value >> (8u * i)) & 0xffu);
    }
}

static bool find_eye(const lum_profile *p, uint32_t value, uint8_t *eye)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        if (p->eye_values[e] == value) {
            *eye = (uint8_t)e;
            return true;
        }
    }
    return false;
}

static bool angles_end_in_line(uint32_t first, uint32_t n)
{
    return n <= LUM_LINE_PIXELS && first <= LUM_LINE_PIXELS - n;
}

lum_result lum_group_decode(const lum_layout *layout, const void *bytes,
                            size_t len, lum_group *out)
{
    const lum_profile *p = &layout->profile;
    const uint8_t *b = bytes;
    lum_group g = {0};
    if (len < p->samples_at) {
        return LUM_E_MALFORMED;
    }
    g.num_samples = load_field(b, p->group[LUM_FIELD_NUM_SAMPLES]);
    const size_t room = (len - p->samples_at) / LUM_SAMPLE_BYTES;
    if (g.num_samples == 0 || g.num_samples > room ||
        !find_eye(p, load_field(b, p->group[LUM_FIELD_EYE]), &g.eye)) {
        return LUM_E_MALFORMED;
    }
    const uint32_t tag = load_field(b, p->group[LUM_FIELD_TAG]);
    if (tag != LUM_TAG_ANGLES && tag != LUM_TAG_RANGES) {
        return LUM_E_UNKNOWN_TAG;
    }
    g.tag = (uint8_t)tag;
    g.first_sample_index =
        load_field(b, p->group[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (tag == LUM_TAG_ANGLES &&
        !angles_end_in_line(g.first_sample_index, g.num_samples)) {
        return LUM_E_MALFORMED;
    }
    g.line = load_field(b, p->group[LUM_FIELD_LINE]);
    g.clock_raw = load_field(b, p->group[LUM_FIELD_TIMESTAMP]);
    g.samples = b + p->samples_at;
    *out = g;
    return LUM_OK;
}

static bool fits(uint32_t value, lum_field field)
{
    return field.bytes == 0 || field.bytes == 4 ||
           value >> (8u * field.bytes) == 0;
}

static bool is_encodable(const lum_group *g)
{
    if (g->eye >= LUM_EYES || g->num_samples == 0) {
        return false;
    }
    if (g->tag == LUM_TAG_ANGLES) {
        return angles_end_in_line(g->first_sample_index, g->num_samples);
    }
    return g->tag == LUM_TAG_RANGES;
}

/* With the tag on the packet type's byte the tag is the type. */
static uint8_t header_type(const lum_profile *p, const lum_group *g)
{
    return p->group[LUM_FIELD_TAG].at < LUM_HEADER_BYTES
               ? g->tag
               : (uint8_t)p->data_packet_type;
}

lum_result lum_group_encode(const lum_layout *layout, const lum_group *group,
                            void *out, size_t size, size_t *len)
{
    const lum_profile *p = &layout->profile;
    if (!is_encodable(group)) {
        return LUM_E_VALUE;
    }
    const uint32_t values[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = group->tag,
        [LUM_FIELD_EYE] = p->eye_values[group->eye],
        [LUM_FIELD_LINE] = group->line,
        [LUM_FIELD_NUM_SAMPLES] = group->num_samples,
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = group->first_sample_index,
        [LUM_FIELD_TIMESTAMP] = group->clock_raw,
    };
    for (unsigned f = 0; f < LUM_FIELD_TIMESTAMP; f++) {
        if (!fits(values[f], p->group[f])) {
            return LUM_E_VALUE;
        }
    }
    if (size < p->samples_at) {
        return LUM_E_SPACE;
    }
    memset(out, 0, p->samples_at);
    lum_header_encode(out, header_type(p, group));
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        store_field(out, p->group[f], values[f]);
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
