/* Code for one layout, beside the layout. */
#ifndef COMPARE_H
#define COMPARE_H

#include "core/clock.h"
#include "core/layout.h"
#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct code {
    const lum_layout *layout;
    bool (*is_read)(const lum_layout *layout);
    lum_result (*decode)(const lum_layout *layout, const void *bytes,
                         size_t len, lum_group *out);
    void (*clock_init)(lum_clock *clock, const lum_profile *profile);
    int64_t (*clock_follow)(const lum_clock *clock, const lum_group *group,
                            uint64_t *ticks);
    void (*copy_angles)(lum_angle *to, const lum_group *group,
                        uint8_t angle_order);
    uint32_t (*word)(const lum_group *group, uint32_t i);
};

/* What renamed.h calls the functions of a number. */
#define DECLARE(n)                                                             \
    bool lum_layout_is_read_##n(const lum_layout *layout);                     \
    lum_result lum_group_decode_##n(const lum_layout *layout,                  \
                                    const void *bytes, size_t len,             \
                                    lum_group *out);                           \
    void lum_clock_init_##n(lum_clock *clock, const lum_profile *profile);     \
    int64_t lum_clock_follow_##n(const lum_clock *clock,                       \
                                 const lum_group *group, uint64_t *ticks);     \
    void lum_layout_copy_angles_##n(lum_angle *to, const lum_group *group,     \
                                    uint8_t angle_order);                      \
    uint32_t lum_group_word_##n(const lum_group *group, uint32_t i)

#define CODE(n, layout)                                                        \
    {                                                                          \
        layout, lum_layout_is_read_##n, lum_group_decode_##n,                  \
            lum_clock_init_##n, lum_clock_follow_##n,                          \
            lum_layout_copy_angles_##n, lum_group_word_##n                     \
    }

/* Of the file that is linked: builtin.c, or one that test_drawn.py wrote. */
extern const struct code codes[];
extern const size_t code_count;

#endif
