#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gather.h"

#include "drive.h"

#include <stdio.h>
#include <string.h>

#define TEXT_BYTES 512u

static const struct feed_view rising = {LUM_EDGES_RISING, 0};
static const struct feed_view both = {LUM_EDGES_BOTH, 0};

/* A gather, the frames that each sensor sent so far, and its pictures. */
struct play {
    struct gather gather;
    int64_t sent[PICTURE_PARTS_MAX];
    int64_t arrival_ns;
    char text[TEXT_BYTES];
};

static void note(struct play *p, const struct picture *picture)
{
    size_t len = strlen(p->text);
    assert_int_equal(picture->frame, p->gather.count);
    for (size_t i = 0; i < picture->parts; i++) {
        len += (size_t)snprintf(p->text + len, TEXT_BYTES - len, "%c%d",
                                'A' + picture->part[i].sensor,
                                (int)picture->part[i].frame);
    }
    (void)snprintf(p->text + len, TEXT_BYTES - len, " ");
}

static void take_all(struct play *p, bool is_end)
{
    struct picture picture = {0};
    while (gather_take(&p->gather, is_end, &picture)) {
        note(p, &picture);
        picture_drop(&picture);
    }
}

/* Letters are frames of sensors in the order in which they are complete. */
static void send(struct play *p, const char *frames)
{
    for (const char *at = frames; *at != '\0'; at++) {
        const size_t member = (size_t)(*at - 'A');
        struct picture picture = {.frame = ++p->sent[member],
                                  .arrival_ns = ++p->arrival_ns};
        gather_put(&p->gather, member, &picture);
        take_all(p, false);
    }
}

static void assert_pictures(size_t members, const char *frames,
                            const char *pictures)
{
    struct play p = {.gather.members = members};
    send(&p, frames);
    take_all(&p, true);
    assert_string_equal(p.text, pictures);
    gather_end(&p.gather);
}

static void each_picture_has_the_newest_frame_of_each(void **state)
{
    (void)state;
    assert_pictures(3, "ABCABCABC", "A1B1C1 A2B2C2 A3B3C3 ");
    assert_pictures(3, "ABCCBABAC", "A1B1C1 A2B2C2 A3B3C3 ");
    assert_pictures(1, "AAA", "A1 A2 A3 ");
    assert_pictures(3, "", "");
}

static void a_frame_that_is_lost_holds_nobody_up(void **state)
{
    (void)state;
    assert_pictures(3, "ABCABABCABC", "A1B1C1 A2B2C1 A3B3C2 A4B4C3 ");
    assert_pictures(2, "ABABA", "A1B1 A2B2 A3B2 ");
}

static void a_faster_sensor_sets_the_pace(void **state)
{
    (void)state;
    assert_pictures(2, "ABAABAABAA", "A1B1 A2B1 A3B2 A4B2 A5B3 A6B3 A7B3 ");
}

static void one_that_has_stopped_is_left_out_and_comes_back(void **state)
{
    (void)state;
    assert_pictures(
        2, "ABAAAAAAAAAAA",
        "A1B1 A2B1 A3B1 A4B1 A5B1 A6B1 A7B1 A8B1 A9B1 A10 A11 A12 ");
    assert_pictures(2, "ABAAAAAAAAAABAAB",
                    "A1B1 A2B1 A3B1 A4B1 A5B1 A6B1 A7B1 A8B1 A9B1 A10 A11 "
                    "A12B2 A13B3 ");
}

static void one_that_never_sends_holds_up_only_the_beginning(void **state)
{
    (void)state;
    struct play p = {.gather.members = 2};
    send(&p, "AA");
    assert_string_equal(p.text, "A1 ");
    send(&p, "AAAAAAA");
    assert_string_equal(p.text, "A1 A2 A3 A4 A5 A6 A7 A8 A9 ");
    send(&p, "A");
    assert_string_equal(p.text, "A1 A2 A3 A4 A5 A6 A7 A8 A9 A10 ");
    gather_end(&p.gather);
}

/* The end of the source or of a pause completes it. */
static void what_began_long_before_is_left_out_and_counted(void **state)
{
    (void)state;
    struct play p = {.gather.members = 2};
    struct picture old = {.frame = 2, .arrival_ns = 3};
    struct picture next = {.frame = 3, .arrival_ns = 4};
    send(&p, "ABAAAAAAAAA");
    assert_int_equal(p.gather.count, 10);
    gather_put(&p.gather, 1, &old);
    take_all(&p, false);
    assert_int_equal(p.gather.late, 1);
    assert_int_equal(p.gather.late_member, 1);
    assert_int_equal(p.gather.count, 10);
    gather_put(&p.gather, 1, &next);
    send(&p, "A");
    assert_int_equal(p.gather.late, 1);
    assert_string_equal(p.text, "A1B1 A2B1 A3B1 A4B1 A5B1 A6B1 A7B1 A8B1 A9B1 "
                                "A10 A11B3 ");
    gather_end(&p.gather);
}

static void the_time_is_that_of_the_new_frame_that_began_first(void **state)
{
    (void)state;
    struct gather g = {.members = 2};
    struct picture a = {.frame = 7, .arrival_ns = 200, .lines = 3, .sensor = 1};
    struct picture b = {.frame = 4,
                        .arrival_ns = 100,
                        .clock_us = 5,
                        .begin_utc_ns = 90,
                        .utc_error_ns = 6,
                        .lines = 4,
                        .lost_words = 2,
                        .sensor = 2,
                        .cut = 8};
    struct picture out = {0};
    gather_put(&g, 0, &a);
    assert_false(gather_take(&g, false, &out));
    gather_put(&g, 1, &b);
    assert_true(gather_take(&g, false, &out));
    assert_int_equal(out.arrival_ns, 100);
    assert_int_equal(out.clock_us, 5);
    assert_int_equal(out.begin_utc_ns, 90);
    assert_int_equal(out.utc_error_ns, 6);
    assert_int_equal(out.sensor, 2);
    assert_int_equal(out.lines, 7);
    assert_int_equal(out.lost_words, 2);
    assert_int_equal(out.cut, 8);
    gather_end(&g);
}

/* --- Views --- */

static lum_frame *make_points(void)
{
    static struct drive_line line;
    const lum_framer_options options = {.struct_size = sizeof options};
    lum_framer *framer = NULL;
    assert_int_equal(lum_framer_new(&options, &framer, NULL), 0);
    drive_pixels(&line, LUM_EYE_BLUE, 1, 1000, 0, 3);
    for (size_t i = 0; i < line.count; i++) {
        const lum_record record = drive_record(&line, i, DRIVE_SENSOR, 1);
        assert_int_equal(lum_framer_push(framer, &record, NULL),
                         LUM_FRAMER_NONE);
    }
    assert_int_equal(lum_framer_flush(framer), LUM_FRAMER_FRAME);
    lum_frame *points = lum_frame_keep(lum_framer_frame(framer, 0));
    lum_framer_free(framer);
    return points;
}

static void put_with(struct gather *g, size_t member, lum_frame *points,
                     const struct feed_views *views)
{
    struct picture picture = {.frame = 1, .views = *views};
    for (size_t i = 0; i < views->count; i++) {
        picture.points[0][i] = lum_frame_keep(points);
    }
    gather_put(g, member, &picture);
}

static void assert_views(const struct feed_views *one,
                         const struct feed_views *other,
                         const struct feed_views *wanted, size_t parts)
{
    struct gather g = {.members = 2};
    struct picture out = {0};
    lum_frame *points = make_points();
    put_with(&g, 0, points, one);
    put_with(&g, 1, points, other);
    assert_true(gather_take(&g, false, &out));
    assert_int_equal(out.parts, parts);
    assert_int_equal(out.views.count, wanted->count);
    for (size_t i = 0; i < wanted->count; i++) {
        assert_int_equal(feed_views_find(&out.views, &wanted->at[i]), i);
        for (size_t k = 0; k < parts; k++) {
            assert_ptr_equal(out.points[k][i], points);
        }
    }
    picture_drop(&out);
    gather_end(&g);
    lum_frame_release(points);
}

static void all_have_the_views_that_each_has(void **state)
{
    const struct feed_views none = {.count = 0};
    const struct feed_views one = {.at = {rising}, .count = 1};
    const struct feed_views other = {.at = {both}, .count = 1};
    const struct feed_views two = {.at = {rising, both}, .count = 2};
    (void)state;
    assert_views(&two, &two, &two, 2);
    assert_views(&two, &other, &other, 2);
    assert_views(&one, &two, &one, 2);
    assert_views(&one, &other, &none, 2);
    assert_views(&none, &none, &none, 2);
}

static void a_frame_that_began_before_any_view_is_left_out(void **state)
{
    const struct feed_views none = {.count = 0};
    const struct feed_views one = {.at = {rising}, .count = 1};
    (void)state;
    assert_views(&none, &one, &one, 1);
    assert_views(&one, &none, &one, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_picture_has_the_newest_frame_of_each),
        cmocka_unit_test(a_frame_that_is_lost_holds_nobody_up),
        cmocka_unit_test(a_faster_sensor_sets_the_pace),
        cmocka_unit_test(one_that_has_stopped_is_left_out_and_comes_back),
        cmocka_unit_test(one_that_never_sends_holds_up_only_the_beginning),
        cmocka_unit_test(what_began_long_before_is_left_out_and_counted),
        cmocka_unit_test(the_time_is_that_of_the_new_frame_that_began_first),
        cmocka_unit_test(all_have_the_views_that_each_has),
        cmocka_unit_test(a_frame_that_began_before_any_view_is_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
