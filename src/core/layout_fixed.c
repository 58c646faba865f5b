/* Packets of the built-in layout alone: shorter and faster than layout_any.c,
 * which it replaces. */
#include "layout.h"

#include "bytes.h"
#include "clock.h"
#include "group.h"

#include <string.h>

#define SAMPLES_AT 24u

/* As they stand in a lum_profile, up to samples_at. */
static const uint8_t group[] = {
    12, 1, 0, 0, 0,  13, 1, 0, 0, 0,  14, 2, 0, 0, 0,  16,
    2,  0, 0, 0, 18, 2,  0, 0, 0, 20, 4,  0, 0, 0, 24,
};

bool lum_layout_is_read(const lum_layout *layout)
{
    const lum_profile *p = &layout->profile;
    return p->sample_order == LUM_ORDER_LITTLE &&
           p->angle_order == LUM_AZIMUTH_ELEVATION &&
           p->eye_values[LUM_EYE_BLUE] == 0 &&
           p->eye_values[LUM_EYE_GREEN] == 1u && p->clock_unit_ns == 1000u &&
           memcmp(p->group, group, sizeof group) == 0;
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
    clock->half = UINT32_C(1) << 31;
}

int64_t lum_clock_follow(const lum_clock *clock, const lum_group *g,
                         uint64_t *ticks)
{
    const uint64_t lowest = clock->lowest;
    *ticks = lowest + ((uint32_t)g->clock_raw - (uint32_t)lowest);
    return signed64(*ticks);
}

void lum_layout_copy_angles(lum_angle *angles, const lum_group *g,
                            uint8_t angle_order)
{
    uint16_t *restrict to = (uint16_t *)angles;
    const uint8_t *restrict from = g->samples;
    const uint16_t *const end = to + (size_t)2 * g->num_samples;
    (void)angle_order;
    for (; to != end; to += 2) {
        to[0] = load_u16(from);
        to[1] = load_u16(from + 2);
        from += LUM_SAMPLE_BYTES;
    }
}

uint32_t lum_group_word(const lum_group *g, uint32_t i)
{
    return load_u32(g->samples + (size_t)LUM_SAMPLE_BYTES * i);
}
