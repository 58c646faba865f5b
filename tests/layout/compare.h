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

/* Its functions, where their names begin with this in place of lum_. */
#define DECLARE(begin)                                                         \
    bool begin##layout_is_read(const lum_layout *layout);                      \
    lum_result begin##group_decode(const lum_layout *layout,                   \
                                   const void *bytes, size_t len,              \
                                   lum_group *out);                            \
    void begin##clock_init(lum_clock *clock, const lum_profile *profile);      \
    int64_t begin##clock_follow(const lum_clock *clock,                        \
                                const lum_group *group, uint64_t *ticks);      \
    void begin##layout_copy_angles(lum_angle *to, const lum_group *group,      \
                                   uint8_t angle_order);                       \
    uint32_t begin##group_word(const lum_group *group, uint32_t i)

#define CODE(begin, layout)                                                    \
    {                                                                          \
        layout, begin##layout_is_read, begin##group_decode, begin##clock_init, \
            begin##clock_follow, begin##layout_copy_angles, begin##group_word  \
    }

/* Of the file that is linked, builtin.c or one that test_drawn.py wrote. */
extern const struct code codes[];
extern const size_t code_count;

#endif
