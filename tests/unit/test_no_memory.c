#define _POSIX_C_SOURCE 200809L
/* Each allocation of a framer, a packet writer and a laser session fails once;
 * built with malloc(), calloc() and realloc() wrapped. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/frame/framer.h"
#include "lum/frame/packet_writer.h"
#include "lum/live/laser_session.h"

#include <dirent.h>
#include <string.h>

#define LINES 40u /* so many that threads are started */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *at, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *at, size_t size);

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

void *__wrap_realloc(void *at, size_t size)
{
    return is_to_fail() ? NULL : __real_realloc(at, size);
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

/* --- Raw frames, and packets again --- */

#define RAW_LINES 3u

/* The frame of a few lines, with words in no order; failures are tried again.
 */
static lum_frame *raw_frame(lum_framer *framer)
{
    static struct drive_line packets;
    static uint32_t words[LUM_LINE_PIXELS];
    lum_frame *frame = NULL;
    for (uint32_t i = 0; i < RAW_LINES; i++) {
        for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
            words[p] = lum_word_make(1000, true, 7u * p % LUM_LINE_PIXELS);
        }
        drive_make(&packets, LUM_EYE_BLUE, i, 1000000u + 1000u * i, words,
                   LUM_LINE_PIXELS);
        for (size_t k = 0; k < packets.count; k++) {
            const lum_record record =
                drive_record(&packets, k, DRIVE_SENSOR, 1000 + i);
            while (lum_framer_push(framer, &record, NULL) != LUM_FRAMER_NONE) {
            }
        }
    }
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(framer)) != LUM_FRAMER_NONE) {
        if (event == LUM_FRAMER_FRAME) {
            frame = lum_frame_keep(lum_framer_frame(framer, 0));
        }
    }
    return frame;
}

static void a_raw_line_has_all_packets_or_none(void **state)
{
    const lum_framer_options options = {
        .struct_size = sizeof options, .threads = 1, .keeps_raw = true};
    long all = 1;
    (void)state;
    for (long at = 0; at <= all; at++) {
        lum_framer *framer = NULL;
        lum_frame_raw raw = {.struct_size = sizeof raw};
        allocations = 0;
        fails_at = at;
        if (lum_framer_new(&options, &framer, NULL) != 0) {
            continue;
        }
        lum_frame *frame = raw_frame(framer);
        all = at == 0 ? allocations : all;
        fails_at = 0;
        assert_non_null(frame);
        assert_int_equal(lum_frame_get_raw(frame, &raw), LUM_OK);
        assert_int_equal(raw.line_count, RAW_LINES);
        assert_int_equal(raw.first_word[RAW_LINES],
                         RAW_LINES * LUM_LINE_PIXELS);
        size_t with = 0;
        for (size_t i = 0; i < raw.packet_count; i++) {
            with += i == 0 || raw.packets[i].line != raw.packets[i - 1u].line
                        ? 1u
                        : 0u;
        }
        assert_int_equal(with + raw.lines_without_packets, RAW_LINES);
        assert_true(with == 0 || raw.places != NULL);
        lum_frame_release(frame);
        lum_framer_free(framer);
    }
    assert_true(all > 10);
}

/* As many times as needed: one allocation fails. */
static uint64_t write_all(lum_packet_writer *w, const lum_frame_raw *raw)
{
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    lum_error error = {""};
    const size_t packets = raw->packet_count / raw->line_count;
    unsigned failed = 0;
    for (size_t i = 0; i < raw->line_count; i++) {
        const lum_raw_line line = {.struct_size = sizeof line,
                                   .clock_us = 1000000 + 1000 * (int64_t)i,
                                   .arrival_ns = 1000 + (int64_t)i,
                                   .angles = raw->angles + i * LUM_LINE_PIXELS,
                                   .angle_marks = raw->angle_marks +
                                                  i * LUM_PIXEL_MARK_WORDS,
                                   .words = raw->words + raw->first_word[i],
                                   .word_count = LUM_LINE_PIXELS,
                                   .packets = raw->packets + i * packets,
                                   .packet_count = packets,
                                   .sensor = DRIVE_SENSOR,
                                   .number = (uint32_t)i,
                                   .places = raw->places + raw->first_word[i]};
        while (lum_packet_writer_add(w, &line, &error) != 0) {
            failed++;
        }
    }
    while (lum_packet_writer_flush(w, &error) != 0) {
        failed++;
    }
    assert_true(failed <= 1);
    assert_true(failed == 0 || strcmp(error.text, "out of memory") == 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.lines, raw->line_count);
    assert_int_equal(c.lines_cut_anew + c.repeated, 0);
    assert_int_equal(c.late + c.stray + c.duplicate, 0);
    return c.packets;
}

static void a_packet_writer_loses_nothing_when_tried_again(void **state)
{
    const lum_framer_options framing = {
        .struct_size = sizeof framing, .threads = 1, .keeps_raw = true};
    const lum_packet_writer_options options = {.struct_size = sizeof options};
    lum_framer *framer = NULL;
    lum_frame_raw raw = {.struct_size = sizeof raw};
    long all = 1;
    (void)state;
    fails_at = 0;
    assert_int_equal(lum_framer_new(&framing, &framer, NULL), 0);
    lum_frame *frame = raw_frame(framer);
    assert_int_equal(lum_frame_get_raw(frame, &raw), LUM_OK);
    for (long at = 0; at <= all; at++) {
        lum_packet_writer *w = NULL;
        allocations = 0;
        fails_at = at;
        if (lum_packet_writer_open("no_memory.pcap", &options, &w, NULL) != 0) {
            assert_null(w);
            continue;
        }
        assert_int_equal(write_all(w, &raw), raw.packet_count);
        all = at == 0 ? allocations : all;
        fails_at = 0;
        lum_packet_writer_abort(w);
    }
    assert_true(all > 10);
    lum_frame_release(frame);
    lum_framer_free(framer);
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
        cmocka_unit_test(a_raw_line_has_all_packets_or_none),
        cmocka_unit_test(a_packet_writer_loses_nothing_when_tried_again),
        cmocka_unit_test(a_laser_session_without_memory_is_not_begun),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
