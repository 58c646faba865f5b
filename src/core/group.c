#include "lum/group.h"

#include "bytes.h"
#include "check.h"
#include "field.h"
#include "group.h"
#include "lum/wire.h"
#include "product.h"

#include <string.h>

static inline uint64_t cut_bits(uint64_t value, const lum_field *field)
{
    return field->bits == 0
               ? value
               : shift_down(value, field->low) & lum_low_bits(field->bits);
}

/* Of a width that is a power of 2, the byte at i in the other order is at i ^
 * (width - 1). */
static LUM_ONE_COPY uint64_t load_bytes(const uint8_t *packet,
                                        const lum_field *field)
{
    const uint8_t *from = packet + field->at;
    const unsigned flip = field_flip(field);
    uint32_t high = 0;
    uint32_t low = 0;
    for (unsigned i = field->bytes; i-- > 0;) {
        high = high << 8 | low >> 24;
        low = low << 8 | from[i ^ flip];
    }
    return cut_bits((uint64_t)high << 32 | low, field);
}

/* Where flash is not dear, a field of the usual order is cut out of eight
 * bytes. A field that there is ends within the packet. */
static inline uint64_t load_field(const uint8_t *packet, size_t len,
                                  const lum_field *field)
{
#if LUM_VECTORS
    if (field->bytes > 0 && field->order == LUM_ORDER_LITTLE &&
        len - field->at >= sizeof(uint64_t)) {
        const uint64_t eight = load_u64(packet + field->at);
        return cut_bits(eight & UINT64_MAX >> (64u - 8u * field->bytes), field);
    }
#else
    (void)len;
#endif
    return load_bytes(packet, field);
}

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

LUM_CHECK_BUILD(the_tag_is_the_first_field, LUM_FIELD_TAG == 0);
LUM_CHECK_BUILD(the_clock_is_the_last_field,
                LUM_FIELD_TIMESTAMP + 1 == LUM_GROUP_FIELDS);

/* All but the tag and the clock have to fit 32 bits, or there is no eye of such
 * a value; a longer tag is unknown. */
lum_result lum_group_decode(const lum_layout *layout, const void *bytes,
                            size_t len, lum_group *out)
{
    const lum_profile *p = &layout->profile;
    const uint8_t *b = bytes;
    uint32_t v[LUM_FIELD_TIMESTAMP];
    uint32_t excess = 0;
    if (len < p->samples_at + LUM_SAMPLE_BYTES) {
        return LUM_E_MALFORMED;
    }
    for (unsigned f = LUM_FIELD_EYE; f < LUM_FIELD_TIMESTAMP; f++) {
        const uint64_t value = load_field(b, len, &p->group[f]);
        v[f] = (uint32_t)value;
        excess |= (uint32_t)(value >> 32);
    }
    const uint32_t room = (uint32_t)((len - p->samples_at) / LUM_SAMPLE_BYTES);
    const uint32_t n = p->group[LUM_FIELD_NUM_SAMPLES].bytes == 0
                           ? room
                           : v[LUM_FIELD_NUM_SAMPLES];
    const uint8_t eye = v[LUM_FIELD_EYE] == p->eye_values[LUM_EYE_BLUE]
                            ? LUM_EYE_BLUE
                            : LUM_EYE_GREEN;
    if (excess != 0 || n > room || v[LUM_FIELD_EYE] != p->eye_values[eye]) {
        return LUM_E_MALFORMED;
    }
    const uint64_t tag = load_field(b, len, &p->group[LUM_FIELD_TAG]);
    const uint32_t known = tag >> 32 == 0 ? (uint32_t)tag : 0;
    const lum_result r =
        lum_group_check(known, n, v[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (r != LUM_OK) {
        return r;
    }
    out->samples = b + p->samples_at;
    out->clock_raw = load_field(b, len, &p->group[LUM_FIELD_TIMESTAMP]);
    out->line = v[LUM_FIELD_LINE];
    out->num_samples = n;
    out->first_sample_index = v[LUM_FIELD_FIRST_SAMPLE_INDEX];
    out->eye = eye;
    out->tag = (uint8_t)known;
    out->sample_order = p->sample_order;
    return LUM_OK;
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

uint32_t lum_group_word(const lum_group *group, uint32_t i)
{
    return load_sample(group->samples + (size_t)LUM_SAMPLE_BYTES * i,
                       group->sample_order);
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
