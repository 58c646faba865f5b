/* How old packets are, and what an eye has seen. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "age.h"
#include "look.h"

#define MAX_MS 1000u

static void answer(age *a, int64_t asked_ms, uint32_t clock_us, int64_t now_ms)
{
    const lum_timestamp t = {(uint32_t)((uint64_t)asked_ms), clock_us};
    age_answer(a, &t, now_ms, MAX_MS);
}

static void without_an_answer_no_age_is_known(void **state)
{
    age a;
    (void)state;
    age_init(&a);
    assert_true(age_of(&a, 0, 0) == AGE_UNKNOWN);
    assert_true(age_of(&a, 5000, 5) == AGE_UNKNOWN);
}

static void an_age_is_counted_from_the_asking_and_rounded_up(void **state)
{
    static const struct {
        uint32_t clock_us;
        int64_t now_ms;
        uint32_t age_ms;
    } rows[] = {
        {50000, 1000, 0},      {50000, 1030, 30},         {49999, 1030, 31},
        {50001, 1030, 30},     {49001, 1030, 31},         {49000, 1030, 31},
        {48999, 1030, 32},     {80000, 1030, 0},          {79999, 1030, 1},
        {80001, 1030, 0},      {180000, 1030, 0},         {0, 1030, 80},
        {50000, 11000, 10000}, {0u - 950000, 1000, 1000},
    };
    age a;
    (void)state;
    age_init(&a);
    answer(&a, 1000, 50000, 1030);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        assert_int_equal(age_of(&a, rows[i].clock_us, rows[i].now_ms),
                         rows[i].age_ms);
    }
    assert_true(age_of(&a, 50000, 11001) == AGE_UNKNOWN);
}

static void a_clock_too_far_ahead_is_old(void **state)
{
    age a;
    (void)state;
    age_init(&a);
    answer(&a, 1000, 50000, 1000);
    assert_int_equal(age_of(&a, 150000, 1000), 0);
    assert_true(age_of(&a, 150001, 1000) > AGE_MAX_MS);
    assert_true(age_of(&a, 50000 + 3600000000u, 1000) > AGE_MAX_MS);
}

static void the_clocks_of_both_may_wrap(void **state)
{
    const int64_t asked_ms = INT64_C(0x2ffffff00);
    age a;
    (void)state;
    age_init(&a);
    answer(&a, asked_ms, 0u - 1000u, asked_ms + 0x180);
    assert_int_equal(age_of(&a, 1000, asked_ms + 0x180), 0x180 - 2);
}

static void answers_that_are_old_or_overtaken_are_left_out(void **state)
{
    age a;
    (void)state;
    age_init(&a);
    answer(&a, 1000, 50000, 1000 + MAX_MS);
    assert_true(age_of(&a, 50000, 1000 + MAX_MS) == AGE_UNKNOWN);
    answer(&a, 2001, 50000, 2000); /* of the future */
    assert_true(age_of(&a, 50000, 2000) == AGE_UNKNOWN);
    answer(&a, 2001, 50000, 2000 + MAX_MS);
    assert_int_equal(age_of(&a, 50000, 3000), 999);
    answer(&a, 2000, 60000, 2000 + MAX_MS - 1u);
    assert_int_equal(age_of(&a, 50000, 3000), 999);
    answer(&a, 2001, 60000, 3000); /* the same, once more */
    assert_int_equal(age_of(&a, 60000, 3000), 999);
    answer(&a, 2500, 70000, 3000);
    assert_int_equal(age_of(&a, 70000, 3000), 500);
}

/* Before its first answer, an age has no request that came later. */
static void a_first_answer_may_be_of_long_ago(void **state)
{
    age a;
    (void)state;
    age_init(&a);
    answer(&a, -500, 50000, 400);
    assert_int_equal(age_of(&a, 50000, 400), 900);
}

static lum_line line_of(int64_t frame, uint32_t number)
{
    return (lum_line){
        .frame = frame, .number = number, .angle_count = LUM_LINE_PIXELS};
}

static void take(look *l, int64_t frame, uint32_t number, int64_t ms)
{
    const lum_line line = line_of(frame, number);
    look_take(l, &line, ms, 3);
}

/* How long the newest whole look serves, of 1000. */
static uint32_t serves(look *l, int64_t now_ms)
{
    look_see(l, now_ms);
    return look_lasts(l, 100000, 1000, now_ms);
}

static void nothing_was_seen_at_first(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    assert_int_equal(look_lasts(&l, UINT32_MAX, UINT32_MAX, 0), 0);
    look_see(&l, 5);
    assert_int_equal(look_lasts(&l, UINT32_MAX, UINT32_MAX, 5), 0);
}

static void a_look_serves_from_its_first_line_on(void **state)
{
    look l;
    (void)state;
    for (int64_t frame = 0; frame < 2; frame++) {
        look_init(&l);
        take(&l, frame, 0, 100);
        take(&l, frame, 1, 110);
        assert_int_equal(serves(&l, 120), 0);
        take(&l, frame, 2, 120);
        assert_int_equal(serves(&l, 120), 980);
        take(&l, frame, 3, 130); /* more lines than are needed */
        assert_int_equal(serves(&l, 130), 970);
        assert_int_equal(serves(&l, 1099), 1);
        assert_int_equal(serves(&l, 1100), 0);
        assert_int_equal(serves(&l, 1101), 0);
        take(&l, frame + 1, 0, 1100);
        take(&l, frame + 1, 1, 1110);
        assert_int_equal(serves(&l, 1110), 0);
        take(&l, frame + 1, 5, 1120);
        assert_int_equal(serves(&l, 1120), 980);
    }
}

static void a_look_is_as_old_as_its_oldest_line(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, 100);
    take(&l, 1, 1, 90);
    take(&l, 1, 2, 95);
    assert_int_equal(serves(&l, 100), 990);
    take(&l, 1, 3, 80); /* is not needed for it */
    assert_int_equal(serves(&l, 100), 990);
}

static void a_look_may_be_of_before_the_first_moment(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, -30);
    take(&l, 1, 1, -20);
    take(&l, 1, 2, -10);
    assert_int_equal(serves(&l, 0), 970);
}

static void a_whole_look_without_a_point_is_none(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, 10);
    take(&l, 1, 1, 20);
    take(&l, 1, 2, 30);
    assert_int_equal(look_lasts(&l, 1000, 1000, 30), 0);
}

static void lines_out_of_order_or_of_another_frame_do_not_count(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 5, 1, 100);
    take(&l, 5, 1, 110);
    take(&l, 5, 0, 120);
    take(&l, 5, 2, 130);
    take(&l, 4, 3, 140);
    take(&l, 5u + UINT32_MAX / 2u + 1u, 3, 140); /* 2^31 on: as well before */
    assert_int_equal(serves(&l, 140), 0);
    take(&l, 5, 3, 150);
    assert_int_equal(serves(&l, 150), 950);
    take(&l, 5u + UINT32_MAX / 2u, 0, 160);
    take(&l, 5u + UINT32_MAX / 2u, 1, 160);
    take(&l, 5u + UINT32_MAX / 2u, 2, 160);
    assert_int_equal(serves(&l, 160), 1000);
}

static void a_first_look_may_be_of_any_frame_that_is_next_to_none(void **state)
{
    const int64_t last = UINT32_MAX / 2u - 1u;
    look l;
    (void)state;
    look_init(&l);
    take(&l, last, 0, 100);
    take(&l, last, 1, 100);
    take(&l, last, 2, 100);
    assert_int_equal(serves(&l, 100), 1000);
}

static void a_look_goes_on_behind_the_highest_number_of_a_line(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, UINT32_MAX, 100);
    take(&l, 1, 0, 110);
    take(&l, 1, 1, 120);
    assert_int_equal(serves(&l, 120), 0);
}

static void lines_that_lack_something_do_not_count(void **state)
{
    look l;
    lum_line line;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, 100);
    take(&l, 1, 1, 100);
    line = line_of(1, 2);
    line.angle_count--;
    look_take(&l, &line, 100, 3);
    line = line_of(1, 3);
    line.lost_words = 1;
    look_take(&l, &line, 100, 3);
    assert_int_equal(serves(&l, 100), 0);
    take(&l, 1, 4, 100);
    assert_int_equal(serves(&l, 100), 1000);
}

static void a_frame_may_begin_with_a_line_that_does_not_count(void **state)
{
    look l;
    lum_line line = line_of(1, 0);
    (void)state;
    look_init(&l);
    line.lost_words = 1;
    look_take(&l, &line, 100, 3);
    take(&l, 1, 1, 110);
    take(&l, 1, 2, 120);
    take(&l, 1, 3, 130);
    assert_int_equal(serves(&l, 130), 970);
}

static void what_was_measured_before_a_loss_does_not_count(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, 100);
    look_spoil(&l, 120);
    take(&l, 1, 1, 110);
    take(&l, 1, 2, 120);
    take(&l, 1, 3, 121);
    assert_int_equal(serves(&l, 121), 0);
    take(&l, 1, 4, 122);
    assert_int_equal(serves(&l, 122), 978);
}

static void the_shorter_of_point_and_look_counts(void **state)
{
    look l;
    (void)state;
    look_init(&l);
    take(&l, 1, 0, 100);
    take(&l, 1, 1, 110);
    take(&l, 1, 2, 120);
    look_see(&l, 110);
    look_see(&l, 105); /* older */
    assert_int_equal(look_lasts(&l, 50, 61, 120), 40);
    assert_int_equal(look_lasts(&l, 50, 60, 120), 40);
    assert_int_equal(look_lasts(&l, 50, 59, 120), 39);
    assert_int_equal(look_lasts(&l, 10, 59, 120), 0);
    assert_int_equal(look_lasts(&l, 5, 59, 120), 0);
    assert_int_equal(look_lasts(&l, 50, 15, 120), 0);
    assert_true(look_lasts(&l, UINT32_MAX, UINT32_MAX, 120) == UINT32_MAX - 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_an_answer_no_age_is_known),
        cmocka_unit_test(an_age_is_counted_from_the_asking_and_rounded_up),
        cmocka_unit_test(a_clock_too_far_ahead_is_old),
        cmocka_unit_test(the_clocks_of_both_may_wrap),
        cmocka_unit_test(answers_that_are_old_or_overtaken_are_left_out),
        cmocka_unit_test(a_first_answer_may_be_of_long_ago),
        cmocka_unit_test(nothing_was_seen_at_first),
        cmocka_unit_test(a_look_serves_from_its_first_line_on),
        cmocka_unit_test(a_look_is_as_old_as_its_oldest_line),
        cmocka_unit_test(a_look_may_be_of_before_the_first_moment),
        cmocka_unit_test(a_whole_look_without_a_point_is_none),
        cmocka_unit_test(lines_out_of_order_or_of_another_frame_do_not_count),
        cmocka_unit_test(a_first_look_may_be_of_any_frame_that_is_next_to_none),
        cmocka_unit_test(a_look_goes_on_behind_the_highest_number_of_a_line),
        cmocka_unit_test(lines_that_lack_something_do_not_count),
        cmocka_unit_test(a_frame_may_begin_with_a_line_that_does_not_count),
        cmocka_unit_test(what_was_measured_before_a_loss_does_not_count),
        cmocka_unit_test(the_shorter_of_point_and_look_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
