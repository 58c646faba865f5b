/* Frames whose points several threads make are those of one thread. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"
#include "support.h"

#include "lum/frame/framer.h"

#include <stdlib.h>
#include <string.h>
#if !defined(_WIN32)
#include <sys/wait.h>
#include <unistd.h>
#endif

#define LINES     60u /* of a frame and eye: more than wait at once */
#define FRAMES    4u
#define WORDS_MAX 3000u
#define VIEWS     4u

/* The same records to a framer of one thread and to one of several. */
struct pair {
    lum_framer *one;
    lum_framer *several;
    size_t frames;
    uint64_t points;
    uint64_t random;
    int64_t time_ns;
    uint32_t clock;
    struct drive_line line;
};

static lum_framer *framer_new(const lum_framer_options *options,
                              uint32_t threads)
{
    lum_framer_options own = *options;
    lum_framer *framer = NULL;
    lum_error error = {""};
    own.threads = threads;
    if (lum_framer_new(&own, &framer, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return framer;
}

static struct pair *pair_new(const lum_framer_options *options,
                             uint32_t threads)
{
    struct pair *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->one = framer_new(options, 1);
    p->several = framer_new(options, threads);
    p->random = threads;
    p->clock = 1000000;
    p->time_ns = INT64_C(1700000000000000000);
    return p;
}

static void pair_free(struct pair *p)
{
    lum_framer_free(p->one);
    lum_framer_free(p->several);
    free(p);
}

static size_t bytes_of(lum_column column)
{
    static const size_t bytes[] = {[LUM_TYPE_FLOAT] = 4,
                                   [LUM_TYPE_UINT32] = 4,
                                   [LUM_TYPE_UINT16] = 2,
                                   [LUM_TYPE_UINT8] = 1};
    return bytes[lum_column_get_type(column)];
}

/* Field by field: what lies between them has no value. */
#define assert_same(a, b, field)                                               \
    assert_memory_equal(&(a)->field, &(b)->field, sizeof(a)->field)

static void assert_same_info(const lum_frame_info *a, const lum_frame_info *b)
{
    assert_same(a, b, number);
    assert_same(a, b, sensor);
    assert_same(a, b, is_complete);
    assert_same(a, b, is_first);
    assert_same(a, b, is_last);
    assert_same(a, b, times.begin_clock_us);
    assert_same(a, b, times.end_clock_us);
    assert_same(a, b, times.begin_arrival_ns);
    assert_same(a, b, times.end_arrival_ns);
    assert_same(a, b, points);
    assert_same(a, b, lines);
    assert_same(a, b, lines_missing);
    assert_same(a, b, lines_missing_angles);
    assert_same(a, b, lines_in_pauses);
    assert_same(a, b, has_pause);
    assert_same(a, b, lost_words);
    assert_same(a, b, losses);
    assert_same(a, b, points_cut);
    assert_same(a, b, lines_cut);
    assert_same(a, b, lines_late);
    assert_same(a, b, lines_dark);
    assert_same(a, b, times.begin_utc_ns);
    assert_same(a, b, times.utc_error_ns);
}

static void assert_same_line(const lum_frame_line *a, const lum_frame_line *b)
{
    assert_same(a, b, clock_us);
    assert_same(a, b, arrival_ns);
    assert_same(a, b, number);
    assert_same(a, b, first_point);
    assert_same(a, b, point_count);
    assert_same(a, b, lost_words);
    assert_same(a, b, angle_count);
    assert_same(a, b, eye);
}

static void assert_same_frame(const lum_frame *a, const lum_frame *b)
{
    lum_frame_info of_a = {.struct_size = sizeof of_a};
    lum_frame_info of_b = {.struct_size = sizeof of_b};
    assert_int_equal(lum_frame_get_info(a, &of_a), LUM_OK);
    assert_int_equal(lum_frame_get_info(b, &of_b), LUM_OK);
    assert_same_info(&of_a, &of_b);
    assert_int_equal(lum_frame_count(a), lum_frame_count(b));
    assert_int_equal(lum_frame_columns(a), lum_frame_columns(b));
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        if ((lum_frame_columns(a) & LUM_COLUMN_BIT(c)) != 0) {
            assert_memory_equal(lum_frame_column(a, (lum_column)c),
                                lum_frame_column(b, (lum_column)c),
                                lum_frame_count(a) * bytes_of((lum_column)c));
        }
    }
    assert_int_equal(lum_frame_line_count(a), lum_frame_line_count(b));
    for (size_t i = 0; i < lum_frame_line_count(a); i++) {
        lum_frame_line x = {.struct_size = sizeof x};
        lum_frame_line y = {.struct_size = sizeof y};
        assert_true(lum_frame_get_line(a, i, &x));
        assert_true(lum_frame_get_line(b, i, &y));
        assert_same_line(&x, &y);
    }
}

/* The first frame of the pair has its points, too. */
static void take(struct pair *p, lum_framer_event one, lum_framer_event several)
{
    assert_int_equal(one, several);
    if (one != LUM_FRAMER_FRAME) {
        assert_int_equal(one, LUM_FRAMER_NONE);
        return;
    }
    for (size_t view = 0; view < VIEWS; view++) {
        const lum_frame *a = lum_framer_frame(p->one, view);
        const lum_frame *b = lum_framer_frame(p->several, view);
        assert_int_equal(a == NULL, b == NULL);
        if (a != NULL) {
            assert_same_frame(a, b);
            p->points += lum_frame_count(a);
        }
    }
    p->frames++;
}

static void push(struct pair *p, const lum_record *record)
{
    lum_framer_event one = LUM_FRAMER_NONE;
    do {
        one = lum_framer_push(p->one, record, NULL);
        take(p, one, lum_framer_push(p->several, record, NULL));
    } while (one != LUM_FRAMER_NONE);
}

static void flush(struct pair *p)
{
    lum_framer_event one = LUM_FRAMER_NONE;
    do {
        one = lum_framer_flush(p->one);
        take(p, one, lum_framer_flush(p->several));
    } while (one != LUM_FRAMER_NONE);
}

/* Up to five words a pixel of both edges, some without a range; one line in
 * eight loses a packet, and so angles or words. */
static void feed_line(struct pair *p, unsigned eye, uint32_t number)
{
    uint32_t words[WORDS_MAX];
    uint32_t n = 0;
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        for (uint32_t k = next_random(&p->random) % 6u; k > 0 && n < WORDS_MAX;
             k--) {
            const uint32_t r = next_random(&p->random);
            words[n++] = lum_word_make(r % 16u == 0 ? -5 : (int32_t)(r >> 14),
                                       r >> 1 & 1u, pixel);
        }
    }
    drive_make(&p->line, eye, number, p->clock, words, n);
    const uint32_t lost = next_random(&p->random) % (8u * DRIVE_PACKETS);
    for (size_t i = 0; i < p->line.count; i++) {
        const lum_record record =
            drive_record(&p->line, i, DRIVE_SENSOR, p->time_ns);
        p->time_ns += 1000;
        if (i != lost) {
            push(p, &record);
        }
    }
}

static void feed_lines(struct pair *p, uint32_t count)
{
    for (uint32_t line = 0; line < count; line++) {
        feed_line(p, LUM_EYE_BLUE, line);
        feed_line(p, LUM_EYE_GREEN, line);
        p->clock += 1000;
    }
}

static void make_views(lum_view views[VIEWS])
{
    for (size_t i = 0; i < VIEWS; i++) {
        lum_view_default(&views[i]);
    }
    views[1].columns = LUM_COLUMNS_ALL;
    views[1].selection.edges = LUM_EDGES_BOTH;
    views[1].smooth_window = 9;
    views[1].smooth_order = 2;
    views[2].columns = LUM_COLUMN_BIT(LUM_COLUMN_TIME) |
                       LUM_COLUMN_BIT(LUM_COLUMN_EYE) |
                       LUM_COLUMN_BIT(LUM_COLUMN_STRONGEST);
    views[2].selection.edges = LUM_EDGES_FALLING;
    views[3].selection.has_range = true; /* by the caller's thread alone */
    views[3].selection.range_min = 10.0f;
    views[3].selection.range_max = 300.0f;
}

static void frames_are_the_same_with_any_number_of_threads(void **state)
{
    static const uint32_t threads[] = {2, 3, LUM_FRAMER_THREADS_MAX};
    (void)state;
    lum_view views[VIEWS];
    make_views(views);
    const lum_framer_options options = {
        .struct_size = sizeof options, .views = views, .view_count = VIEWS};
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        struct pair *p = pair_new(&options, threads[i]);
        for (unsigned frame = 0; frame < FRAMES; frame++) {
            feed_lines(p, LINES);
        }
        flush(p);
        assert_int_equal(p->frames, FRAMES);
        assert_true(p->points > (uint64_t)FRAMES * LINES * LUM_LINE_PIXELS);
        pair_free(p);
    }
}

/* Frames that grow move while lines of them are under way; a frame that is full
 * has its last line cut. */
static void a_frame_that_grows_or_is_full_is_the_same(void **state)
{
    (void)state;
    for (uint32_t most = 70000; most <= 270000; most += 100000) {
        const lum_framer_options options = {.struct_size = sizeof options,
                                            .points_max = most};
        struct pair *p = pair_new(&options, 4);
        feed_lines(p, 2u * LINES);
        feed_lines(p, 3u * LINES);
        flush(p);
        assert_int_equal(p->frames, 2);
        assert_true(p->points > most && p->points <= 2u * (uint64_t)most);
        pair_free(p);
    }
}

static void a_jump_drops_what_others_make(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options};
    struct pair *p = pair_new(&options, 2);
    feed_lines(p, LINES);
    lum_framer_skip_to(p->one, 2);
    lum_framer_skip_to(p->several, 2);
    feed_lines(p, LINES);
    flush(p);
    assert_int_equal(p->frames, 1);
    assert_true(p->points > LINES * LUM_LINE_PIXELS);
    pair_free(p);
}

static void a_framer_can_be_freed_in_the_middle_of_a_frame(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options};
    for (uint32_t lines = 1; lines < LINES; lines += 7) {
        struct pair *p = pair_new(&options, 3);
        feed_lines(p, lines);
        assert_int_equal(p->frames, 0);
        pair_free(p);
    }
}

#if !defined(_WIN32)
/* What its parent's threads were making is under way for ever there. */
static void a_child_of_fork_can_free_a_framer(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options};
    for (uint32_t lines = 20; lines < LINES; lines++) {
        struct pair *p = pair_new(&options, 3);
        feed_lines(p, lines);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            (void)alarm(300); /* one that hangs ends by it */
            lum_framer_free(p->several);
            _exit(0);
        }
        int status = -1;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_int_equal(status, 0);
        flush(p);
        assert_int_equal(p->frames, 1);
        pair_free(p);
    }
}
#endif

static void more_threads_than_there_can_be_are_refused(void **state)
{
    (void)state;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .threads = LUM_FRAMER_THREADS_MAX + 1u};
    lum_framer *framer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_framer_new(&options, &framer, &error), -1);
    assert_null(framer);
    assert_string_equal(error.text, "65 threads; at most 64 are possible");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_the_same_with_any_number_of_threads),
        cmocka_unit_test(a_frame_that_grows_or_is_full_is_the_same),
        cmocka_unit_test(a_jump_drops_what_others_make),
        cmocka_unit_test(a_framer_can_be_freed_in_the_middle_of_a_frame),
#if !defined(_WIN32)
        cmocka_unit_test(a_child_of_fork_can_free_a_framer),
#endif
        cmocka_unit_test(more_threads_than_there_can_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
