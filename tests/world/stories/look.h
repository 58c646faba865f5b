/* What stories of lumctl doctor share. */
#ifndef STORIES_LOOK_H
#define STORIES_LOOK_H

#include "help.h"

#define SENSOR "10.42.0.37"

/* Its checks, in their order. */
#define LOOK_NAMES 15
extern const char *const look_names[LOOK_NAMES];

/* A bench whose system grants large buffers. */
user_bench tuned_bench(void);

/* `lumctl doctor --json`, to its end. */
user_tool *examine(const user_bench *bench);

/* "result", "text" or "fix" of a check; "" for null. */
const char *look_of(const user_tool *doctor, const char *check,
                    const char *what);

#define expect_check(DOCTOR, CHECK, RESULT)                                    \
    user_expect_same(look_of(DOCTOR, CHECK, "result"), RESULT)
#define expect_text(DOCTOR, CHECK, TEXT)                                       \
    user_expect_has(look_of(DOCTOR, CHECK, "text"), TEXT)
#define expect_fix(DOCTOR, CHECK, FIX)                                         \
    user_expect_same(look_of(DOCTOR, CHECK, "fix"), FIX)

/* Nothing at all. */
void expect_fine(user_tool *doctor);

#endif
