#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/frames.h"
#include "support.h"

#include <string.h>

/* frames_none.c is linked in place of frames.c. That lines are the same is
 * shown by the tests of the assembler with it. */

#define BLUE  LUM_EYE_BLUE
#define GREEN LUM_EYE_GREEN

static void no_line_has_a_frame(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (unsigned frame = 0; frame < 3; frame++) {
        for (uint32_t line = 10; line < 30; line++) {
            send_line(s, BLUE, line);
            send_line(s, GREEN, line);
        }
    }
    stream_end(s);
    assert_int_equal(counters(s)->lines, 120);
    assert_int_equal(s->event_count, 120);
    for (size_t i = 0; i < 120; i++) {
        assert_int_equal(s->events[i]->what, LUM_LINE_READY);
        assert_true(nth_line(s, i)->frame == 0);
    }
    assert_int_equal(counters(s)->frames, 0);
    assert_int_equal(counters(s)->lines_skipped, 0);
    stream_free(s);
}

static void nothing_is_touched_and_nothing_is_due(void **state)
{
    struct stream *s = stream_open();
    lum_assembler *a = &s->assembler;
    (void)state;
    send_line(s, BLUE, 5);
    stream_end(s);
    const lum_assembler before = *a;
    for (uint32_t line = 0; line < 40; line += 13) {
        assert_int_equal(lum_frames_decide(a, &a->eye[GREEN], line % 27), 0);
        lum_frames_note(a, line);
    }
    lum_frames_break(a, &a->eye[BLUE]);
    assert_false(lum_frames_are_due(a));
    assert_false(lum_frames_remain(a));
    lum_frames_announce(a);
    lum_frames_count_gaps(a);
    lum_frames_end(a);
    assert_memory_equal(a, &before, sizeof before);
    stream_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_line_has_a_frame),
        cmocka_unit_test(nothing_is_touched_and_nothing_is_due),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
