#define _POSIX_C_SOURCE 200809L
/* Each allocation of a framer and a laser session fails once; built with
 * malloc() and calloc() wrapped. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/frame/framer.h"
#include "lum/live/laser_session.h"

#include <dirent.h>

#define LINES 40u /* so many that threads are started */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);

static long allocations;
static long fails_at; /* 0: none */

/* Threads of the framer allocate too. */
static int is_to_fail(void)
{
    return __atomic_add_fetch(&allocations, 1, __ATOMIC_RELAXED) == fails_at;
}

void *__wrap_malloc(size_t size)
{
    return is_to_fail() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return is_to_fail() ? NULL : __real_calloc(count, size);
}

static uint64_t take(const lum_framer *framer, lum_framer_event event)
{
    return event == LUM_FRAMER_FRAME
               ? lum_frame_count(lum_framer_frame(framer, 0))
               : 0;
}

/* Returns the points of all frames; failures are tried again. */
static uint64_t points_of(lum_framer *framer)
{
    static struct drive_line packets;
    lum_framer_event event = LUM_FRAMER_NONE;
    uint64_t points = 0;
    for (uint32_t i = 0; i < 2u * LINES; i++) {
        drive_pixels(&packets, LUM_EYE_BLUE, i % LINES, 1000000u + 1000u * i, 0,
                     LUM_LINE_PIXELS);
        for (size_t k = 0; k < packets.count; k++) {
            const lum_record record =
                drive_record(&packets, k, DRIVE_SENSOR, i);
            while ((event = lum_framer_push(framer, &record, NULL)) !=
                   LUM_FRAMER_NONE) {
                points += take(framer, event);
            }
        }
    }
    while ((event = lum_framer_flush(framer)) != LUM_FRAMER_NONE) {
        points += take(framer, event);
    }
    return points;
}

/* Of this process. */
static unsigned count_threads(void)
{
    unsigned n = 0;
    DIR *all = opendir("/proc/self/task");
    assert_non_null(all);
    while (readdir(all) != NULL) {
        n++;
    }
    (void)closedir(all);
    return n - 2u; /* . and .. */
}

static void fail_each(uint32_t threads)
{
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .threads = threads};
    const unsigned others = count_threads() - 1u; /* of an emulator */
    long all = 1;
    for (long at = 0; at <= all; at++) {
        lum_framer *framer = NULL;
        allocations = 0;
        fails_at = at;
        if (lum_framer_new(&options, &framer, NULL) != 0) {
            assert_null(framer);
            continue;
        }
        assert_int_equal(points_of(framer), 2u * LINES * LUM_LINE_PIXELS);
        if (at == 0) { /* a directory's memory may be ours, too */
            all = allocations;
            const unsigned count = count_threads() - others;
            assert_true(count <= threads);
            assert_true(threads == 1 || count > 1);
        }
        lum_framer_free(framer);
    }
    assert_true(all > 10);
    fails_at = 0;
}

static void what_failed_for_memory_loses_nothing_when_tried_again(void **state)
{
    (void)state;
    fail_each(1);
}

static void threads_without_memory_leave_their_work_to_the_caller(void **state)
{
    (void)state;
    fail_each(3);
}

static void a_laser_session_without_memory_is_not_begun(void **state)
{
    lum_sensor_options session;
    lum_laser_session_options options;
    lum_laser_session *laser = NULL;
    lum_error error;
    (void)state;
    lum_sensor_options_default(&session);
    session.interface_name = "eth0";
    lum_laser_session_options_default(&options, &session);
    allocations = 0;
    fails_at = 1;
    assert_int_equal(lum_laser_session_new(&options, 0, &laser, &error), -1);
    assert_string_equal(error.text, "out of memory");
    assert_null(laser);
    assert_int_equal(lum_laser_session_new(&options, 0, &laser, &error), 0);
    lum_laser_session_free(laser);
    assert_int_equal(allocations, 2);
    fails_at = 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_failed_for_memory_loses_nothing_when_tried_again),
        cmocka_unit_test(threads_without_memory_leave_their_work_to_the_caller),
        cmocka_unit_test(a_laser_session_without_memory_is_not_begun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
