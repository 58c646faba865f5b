/* Code for one layout, beside the layout. */
#ifndef COMPARE_H
#define COMPARE_H

/* Before a file that lumtable --layout wrote: its functions get the number of
 * its layout, so that many and those of layout_any.c are one program. */
#ifdef LAYOUT_NUMBER
#define JOIN(name, number)     name##_##number
#define JOINED(name, number)   JOIN(name, number)
#define NUMBERED(name)         JOINED(name, LAYOUT_NUMBER)
#define lum_layout_is_read     NUMBERED(lum_layout_is_read)
#define lum_group_decode       NUMBERED(lum_group_decode)
#define lum_clock_init         NUMBERED(lum_clock_init)
#define lum_clock_follow       NUMBERED(lum_clock_follow)
#define lum_layout_copy_angles NUMBERED(lum_layout_copy_angles)
#define lum_group_word         NUMBERED(lum_group_word)
#endif

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

/* The functions of a number. */
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

/* Of the file that is linked, builtin.c or one that test_drawn.py wrote. */
extern const struct code codes[];
extern const size_t code_count;

#endif
