#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumview/page_status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MS INT64_C(1000000)

/* No eye is asked for here. */
void feed_geometry(const struct feed *feed, unsigned eye, float mount[3],
                   float rotation[9])
{
    (void)feed;
    (void)eye;
    memset(mount, 0, 3 * sizeof *mount);
    memset(rotation, 0, 9 * sizeof *rotation);
}

const lum_profile *feed_profile(const struct feed *feed, bool is_second)
{
    (void)feed;
    (void)is_second;
    return NULL;
}

/* Looks at a sensor of 10 frames a second, half a second apart. */
static void look(struct status *status, unsigned ticks, int64_t first_frame_ns)
{
    memset(status, 0, sizeof *status);
    for (unsigned i = 0; i < ticks; i++) {
        const int64_t now_ns = 1000 * MS + i * 500 * MS;
        const int64_t frames = (now_ns - first_frame_ns) / (100 * MS) + 1;
        const struct feed_status feed = {.frames = (uint64_t)frames,
                                         .frame_ns = first_frame_ns +
                                                     (frames - 1) * 100 * MS};
        status_update(status, &feed, now_ns, true);
    }
}

static void assert_rate(const struct status *status, const char *rate)
{
    char expected[64];
    struct text text;
    (void)snprintf(expected, sizeof expected, "\"frames_per_second\": %s,",
                   rate);
    assert_int_equal(status_text(status, 0, true, 0, &text), 0);
    char *copy = strndup(text.bytes, text.len);
    assert_non_null(copy);
    if (strstr(copy, expected) == NULL) {
        fail_msg("%s is not in %s", expected, copy);
    }
    free(copy);
    free(text.memory);
}

static void whole_frames_alone_tell_the_rate(void **state)
{
    struct status status;
    (void)state;
    for (int64_t phase_ms = 0; phase_ms < 100; phase_ms += 9) {
        look(&status, 3, phase_ms * MS + 1);
        assert_rate(&status, "10.000");
    }
}

static void one_look_tells_no_rate(void **state)
{
    struct status status;
    (void)state;
    look(&status, 1, 0);
    assert_rate(&status, "0.000");
}

static void the_first_frame_tells_no_rate(void **state)
{
    struct status status;
    const struct feed_status before = {.frames = 0};
    const struct feed_status first = {.frames = 1, .frame_ns = 5000 * MS};
    (void)state;
    memset(&status, 0, sizeof status);
    status_update(&status, &before, 4900 * MS, true);
    status_update(&status, &first, 5400 * MS, true);
    assert_rate(&status, "0.000");
}

static void no_new_frame_is_no_rate(void **state)
{
    struct status status;
    const struct feed_status feed = {.frames = 7, .frame_ns = 100 * MS};
    (void)state;
    memset(&status, 0, sizeof status);
    status_update(&status, &feed, 500 * MS, true);
    status_update(&status, &feed, 1000 * MS, true);
    assert_rate(&status, "0.000");
}

static void marks_are_told_where_they_are_new(void **state)
{
    static struct status status;
    struct text text;
    (void)state;
    status.marks = (struct feed_marks){
        .at = {{.frame = 4, .loss = {7, 2, 1}}}, .count = 1, .frames = 2};
    for (unsigned has_marks = 0; has_marks < 2; has_marks++) {
        assert_int_equal(status_text(&status, 0, has_marks == 1, 0, &text), 0);
        char *copy = strndup(text.bytes, text.len);
        assert_non_null(copy);
        assert_true((strstr(copy, "\"mark_frames\": 2, \"marks\": "
                                  "[[4, 7, 1, 2]]") != NULL) ==
                    (has_marks == 0));
        assert_true((strstr(copy, "marks") == NULL) == (has_marks == 1));
        free(copy);
        free(text.memory);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_frames_alone_tell_the_rate),
        cmocka_unit_test(one_look_tells_no_rate),
        cmocka_unit_test(the_first_frame_tells_no_rate),
        cmocka_unit_test(no_new_frame_is_no_rate),
        cmocka_unit_test(marks_are_told_where_they_are_new),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
