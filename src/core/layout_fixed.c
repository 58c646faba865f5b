/* Packets of one layout alone, in place of layout_any.c: less code, and faster.
 * Made by lumtable 0.1.0; not to be changed by hand.
 *   profile: built in
 */
#include "layout.h"

#include "bytes.h"
#include "clock.h"
#include "group.h"

#include <stddef.h>
#include <string.h>

#if LUM_LAYOUT_VERSION != 2
#error "made for another version of lumsdk: make it again with its lumtable"
#endif

#define SAMPLES_AT 24u
#define BLUE       0u
#define GREEN      1u
#define UNIT_NS    1000u

/* As they stand in a lum_profile. */
static const struct fields {
    lum_field group[LUM_GROUP_FIELDS];
    uint8_t samples_at;
} own = {
    {
        [LUM_FIELD_TAG] = {.at = 12, .bytes = 1},
        [LUM_FIELD_EYE] = {.at = 13, .bytes = 1},
        [LUM_FIELD_LINE] = {.at = 14, .bytes = 2},
        [LUM_FIELD_NUM_SAMPLES] = {.at = 16, .bytes = 2},
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = {.at = 18, .bytes = 2},
        [LUM_FIELD_TIMESTAMP] = {.at = 20, .bytes = 4},
    },
    SAMPLES_AT,
};

bool lum_layout_is_read(const lum_layout *layout)
{
    const lum_profile *p = &layout->profile;
    return p->sample_order == LUM_ORDER_LITTLE &&
           p->angle_order == LUM_AZIMUTH_ELEVATION &&
           p->eye_values[LUM_EYE_BLUE] == BLUE &&
           p->eye_values[LUM_EYE_GREEN] == GREEN &&
           p->clock_unit_ns == UNIT_NS &&
           memcmp((const uint8_t *)p + offsetof(lum_profile, group), &own,
                  sizeof own) == 0;
}

lum_result lum_group_decode(const lum_layout *layout, const void *bytes,
                            size_t len, lum_group *out)
{
    const uint8_t *b = bytes;
    (void)layout;
    if (len < SAMPLES_AT + LUM_SAMPLE_BYTES) {
        return LUM_E_MALFORMED;
    }
    const uint32_t room = (uint32_t)((len - SAMPLES_AT) / LUM_SAMPLE_BYTES);
    const uint32_t tag = b[12];
    const uint32_t eye = b[13];
    const uint32_t n = load_u16(b + 16);
    const uint32_t first = load_u16(b + 18);
    if (n > room || eye > 1u) {
        return LUM_E_MALFORMED;
    }
    const lum_result r = lum_group_check(tag, n, first);
    if (r != LUM_OK) {
        return r;
    }
    out->samples = b + SAMPLES_AT;
    out->clock_raw = load_u32(b + 20);
    out->line = load_u16(b + 14);
    out->num_samples = n;
    out->first_sample_index = first;
    out->eye = (uint8_t)eye;
    out->tag = (uint8_t)tag;
    out->sample_order = LUM_ORDER_LITTLE;
    return LUM_OK;
}

void lum_clock_init(lum_clock *clock, const lum_profile *profile)
{
    (void)profile;
    clock->half = 0x80000000u;
}

int64_t lum_clock_follow(const lum_clock *clock, const lum_group *group,
                         uint64_t *ticks)
{
    const uint64_t lowest = clock->lowest;
    const uint32_t ahead = (uint32_t)group->clock_raw - (uint32_t)lowest;
    *ticks = lowest + ahead;
    return signed64(*ticks);
}

void lum_layout_copy_angles(lum_angle *to, const lum_group *group,
                            uint8_t angle_order)
{
    uint16_t *restrict numbers = (uint16_t *)to;
    const uint8_t *restrict from = group->samples;
    const uint16_t *const end = numbers + (size_t)2 * group->num_samples;
    (void)angle_order;
    for (; numbers != end; numbers += 2) {
        numbers[0] = load_u16(from);
        numbers[1] = load_u16(from + 2);
        from += LUM_SAMPLE_BYTES;
    }
}

uint32_t lum_group_word(const lum_group *group, uint32_t i)
{
    return load_u32(group->samples + (size_t)LUM_SAMPLE_BYTES * i);
}
