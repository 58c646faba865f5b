#include "both.h"

#include "core/clock.h"
#include "core/layout.h"

#include <string.h>

bool fixed_layout_is_read(const lum_layout *layout);
lum_result fixed_group_decode(const lum_layout *layout, const void *bytes,
                              size_t len, lum_group *out);
uint32_t fixed_group_word(const lum_group *group, uint32_t i);
void fixed_layout_copy_angles(lum_angle *to, const lum_group *group,
                              uint8_t angle_order);
void fixed_clock_init(lum_clock *clock, const lum_profile *profile);
int64_t fixed_clock_follow(const lum_clock *clock, const lum_group *group,
                           uint64_t *ticks);

static bool groups_agree(const lum_group *a, const lum_group *b)
{
    return a->samples == b->samples && a->clock_raw == b->clock_raw &&
           a->line == b->line && a->num_samples == b->num_samples &&
           a->first_sample_index == b->first_sample_index && a->eye == b->eye &&
           a->tag == b->tag && a->sample_order == b->sample_order;
}

static bool samples_agree(const lum_layout *layout, const lum_group *g)
{
    static lum_angle any[LUM_LINE_PIXELS];
    static lum_angle fixed[LUM_LINE_PIXELS];
    for (uint32_t i = 0; i < g->num_samples; i++) {
        if (lum_group_word(g, i) != fixed_group_word(g, i)) {
            return false;
        }
    }
    if (g->tag != LUM_TAG_ANGLES) {
        return true;
    }
    lum_layout_copy_angles(any, g, layout->profile.angle_order);
    fixed_layout_copy_angles(fixed, g, layout->profile.angle_order);
    return memcmp(any, fixed, g->num_samples * sizeof *any) == 0;
}

/* The clock before it is any number that the packet's bytes make. */
static bool clocks_agree(const lum_layout *layout, const lum_group *g)
{
    lum_clock any = {0};
    lum_clock fixed = {0};
    uint64_t ticks = 0;
    uint64_t fixed_ticks = 0;
    const uint64_t before =
        (g->clock_raw ^ lum_group_word(g, 0)) * UINT64_C(0x9e3779b97f4a7c15);
    lum_clock_init(&any, &layout->profile);
    fixed_clock_init(&fixed, &layout->profile);
    for (unsigned turn = 0; turn < 2; turn++) {
        if (lum_clock_follow(&any, g, &ticks) !=
                fixed_clock_follow(&fixed, g, &fixed_ticks) ||
            ticks != fixed_ticks) {
            return false;
        }
        clock_take(&any, &before);
        clock_take(&fixed, &before);
    }
    return any.lowest == fixed.lowest;
}

bool layouts_agree(const uint8_t *data, size_t len)
{
    lum_layout layout;
    lum_group any = {0};
    lum_group fixed = {0};
    lum_layout_default(&layout);
    if (!fixed_layout_is_read(&layout) ||
        lum_group_decode(&layout, data, len, &any) !=
            fixed_group_decode(&layout, data, len, &fixed) ||
        !groups_agree(&any, &fixed)) {
        return false;
    }
    return any.num_samples == 0 ||
           (samples_agree(&layout, &any) && clocks_agree(&layout, &any));
}
