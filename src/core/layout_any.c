/* Packets of any layout: where a data packet's fields are is read from its
 * profile. A file that lumtable writes for one layout replaces this one. */
#include "layout.h"

#include "bytes.h"
#include "check.h"
#include "clock.h"
#include "field.h"
#include "group.h"
#include "product.h"

bool lum_layout_is_read(const lum_layout *layout)
{
    (void)layout;
    return true;
}

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

LUM_CHECK_BUILD(the_tag_is_the_first_field, LUM_FIELD_TAG == 0);
LUM_CHECK_BUILD(the_clock_is_the_last_field,
                LUM_FIELD_TIMESTAMP + 1 == LUM_GROUP_FIELDS);

/* All fields but the clock. Returns what is above 32 bits of any but the tag: a
 * longer tag is 0, which is unknown. */
static uint32_t load_fields(const lum_profile *p, const uint8_t *b, size_t len,
                            uint32_t v[LUM_FIELD_TIMESTAMP])
{
    uint32_t excess = 0;
    for (unsigned f = LUM_FIELD_TIMESTAMP; f-- > 0;) {
        const uint64_t value = load_field(b, len, &p->group[f]);
        const uint32_t high = (uint32_t)(value >> 32);
        v[f] = (uint32_t)value;
        if (f != LUM_FIELD_TAG) {
            excess |= high;
        } else if (high != 0) {
            v[f] = 0;
        }
    }
    return excess;
}

lum_result lum_group_decode(const lum_layout *layout, const void *bytes,
                            size_t len, lum_group *out)
{
    const lum_profile *p = &layout->profile;
    const uint8_t *b = bytes;
    uint32_t v[LUM_FIELD_TIMESTAMP];
    if (len < p->samples_at + LUM_SAMPLE_BYTES) {
        return LUM_E_MALFORMED;
    }
    const uint32_t excess = load_fields(p, b, len, v);
    const uint8_t eye = v[LUM_FIELD_EYE] == p->eye_values[LUM_EYE_BLUE]
                            ? LUM_EYE_BLUE
                            : LUM_EYE_GREEN;
    if (excess != 0 || v[LUM_FIELD_EYE] != p->eye_values[eye]) {
        return LUM_E_MALFORMED;
    }
    const uint32_t room = (uint32_t)((len - p->samples_at) / LUM_SAMPLE_BYTES);
    const uint32_t n = p->group[LUM_FIELD_NUM_SAMPLES].bytes == 0
                           ? room
                           : v[LUM_FIELD_NUM_SAMPLES];
    if (n > room) {
        return LUM_E_MALFORMED;
    }
    const lum_result r =
        lum_group_check(v[LUM_FIELD_TAG], n, v[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (r != LUM_OK) {
        return r;
    }
    out->samples = b + p->samples_at;
    out->clock_raw = load_field(b, len, &p->group[LUM_FIELD_TIMESTAMP]);
    out->line = v[LUM_FIELD_LINE];
    out->num_samples = n;
    out->first_sample_index = v[LUM_FIELD_FIRST_SAMPLE_INDEX];
    out->eye = eye;
    out->tag = (uint8_t)v[LUM_FIELD_TAG];
    out->sample_order = p->sample_order;
    return LUM_OK;
}

void lum_clock_init(lum_clock *clock, const lum_profile *profile)
{
    const uint64_t mask =
        lum_low_bits(clock_bits(&profile->group[LUM_FIELD_TIMESTAMP]));
    clock->unit_ns = profile->clock_unit_ns;
    clock->mask = mask;
    clock->half = mask ^ mask >> 1;
}

int64_t lum_clock_follow(const lum_clock *clock, const lum_group *group,
                         uint64_t *ticks)
{
    const uint64_t lowest = clock->lowest;
    *ticks = lowest + ((group->clock_raw - lowest) & clock->mask);
    return lum_clock_us(*ticks, clock->unit_ns);
}

/* An int16_t may be written as its unsigned type, bit by bit as it came. With
 * vectors, angles in the order of lum_angle are copied as one row of numbers.
 */
static void copy_angles(lum_angle *angles, const lum_group *group,
                        uint8_t angle_order)
{
    const unsigned swap = angle_order; /* 0 or 1 */
    uint16_t *restrict to = (uint16_t *)angles;
    const uint8_t *restrict from = group->samples;
    const uint8_t *const end =
        from + (size_t)LUM_SAMPLE_BYTES * group->num_samples;
#if LUM_VECTORS
    if (swap == 0) {
        for (uint32_t i = 0; i < 2u * group->num_samples; i++) {
            to[i] = load_u16(from + (size_t)2 * i);
        }
        return;
    }
#endif
    for (; from != end; from += LUM_SAMPLE_BYTES) {
        to[swap] = load_u16(from);
        to[swap ^ 1u] = load_u16(from + 2);
        to += 2;
    }
}

/* Angles of the other byte order. */
static void swap_bytes(lum_angle *angles, uint32_t n)
{
    uint16_t *restrict numbers = (uint16_t *)angles;
    for (uint32_t i = 0; i < 2u * n; i++) {
        const unsigned bits = numbers[i];
        numbers[i] = (uint16_t)(bits >> 8 | bits << 8);
    }
}

void lum_layout_copy_angles(lum_angle *to, const lum_group *group,
                            uint8_t angle_order)
{
    copy_angles(to, group, angle_order);
    if (group->sample_order != LUM_ORDER_LITTLE) {
        swap_bytes(to, group->num_samples);
    }
}

uint32_t lum_group_word(const lum_group *group, uint32_t i)
{
    return load_sample(group->samples + (size_t)LUM_SAMPLE_BYTES * i,
                       group->sample_order);
}
