#include "lum/group.h"

#include "bytes.h"
#include "field.h"
#include "group.h"
#include "lum/wire.h"

#include <string.h>

/* Bits of other fields in the same bytes stay as they are. */
static void store_field(uint8_t *packet, const lum_field *field, uint64_t value)
{
    const unsigned flip = field_flip(field);
    uint8_t *to = packet + field->at;
    for (unsigned i = 0; i < field_bits(field); i++) {
        const unsigned bit = field->low + i;
        const unsigned set = (unsigned)(value >> i) & 1u;
        uint8_t *byte = &to[bit / 8u ^ flip];
        *byte = (uint8_t)(*byte | set << bit % 8u);
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

static bool fits(uint64_t value, const lum_field *field)
{
    const unsigned bits = field_bits(field);
    return bits == 0 || value >> (bits - 1u) <= 1u;
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
    if (group->eye >= LUM_EYES ||
        lum_group_check(group->tag, group->num_samples,
                        group->first_sample_index) != LUM_OK) {
        return LUM_E_VALUE;
    }
    const uint64_t values[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = group->tag,
        [LUM_FIELD_EYE] = p->eye_values[group->eye],
        [LUM_FIELD_LINE] = group->line,
        [LUM_FIELD_NUM_SAMPLES] = group->num_samples,
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = group->first_sample_index,
        [LUM_FIELD_TIMESTAMP] = group->clock_raw,
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
    const unsigned low = group->sample_order == LUM_ORDER_LITTLE ? 0 : 1u;
    const int16_t a = signed16((uint16_t)(p[low] | (unsigned)p[low ^ 1u] << 8));
    const int16_t b =
        signed16((uint16_t)(p[low ^ 2u] | (unsigned)p[low ^ 3u] << 8));
    return layout->profile.angle_order == LUM_AZIMUTH_ELEVATION
               ? (lum_angle){a, b}
               : (lum_angle){b, a};
}

/* The first angle is the lower half of a word, or the upper one of a word in
 * the other order. */
void lum_angle_encode(const lum_layout *layout, lum_angle angle,
                      uint8_t out[LUM_SAMPLE_BYTES])
{
    const lum_profile *p = &layout->profile;
    const bool is_first = (p->angle_order == LUM_AZIMUTH_ELEVATION) ==
                          (p->sample_order == LUM_ORDER_LITTLE);
    const int16_t low = is_first ? angle.azimuth : angle.elevation;
    const int16_t high = is_first ? angle.elevation : angle.azimuth;
    lum_group_word_encode(
        layout, ((uint32_t)low & 0xffffu) | (uint32_t)high << 16, out);
}

void lum_word_encode(uint32_t word, uint8_t out[LUM_SAMPLE_BYTES])
{
    store_u32(out, word);
}

void lum_group_word_encode(const lum_layout *layout, uint32_t word,
                           uint8_t out[LUM_SAMPLE_BYTES])
{
    store_u32(out, layout->profile.sample_order == LUM_ORDER_LITTLE
                       ? word
                       : swapped32(word));
}
