#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"

#include <stdlib.h>
#include <string.h>

#define BLUE  LUM_EYE_BLUE
#define GREEN LUM_EYE_GREEN
#define GAP   100000u

/* Calls in any order: the answer to each, and what it must not change. */

static const uint8_t samples[4u * LUM_SAMPLE_BYTES];

/* A packet of n angles of the first pixels. */
static lum_group packet(unsigned eye, uint32_t line, uint32_t clock, uint32_t n)
{
    return (lum_group){.samples = samples,
                       .line = line,
                       .num_samples = n,
                       .clock_raw = clock,
                       .eye = (uint8_t)eye,
                       .tag = LUM_TAG_ANGLES};
}

static lum_result push(struct stream *s, const lum_group *g)
{
    return lum_assembler_push(&s->assembler, g, s->arrival);
}

/* An answer that says that nothing was done. */
static void assert_untouched(struct stream *s, const lum_assembler *before,
                             lum_result r, lum_result expected)
{
    lum_assembler now = s->assembler;
    assert_int_equal(r, expected);
    if (r == LUM_E_ORDER) {
        assert_int_equal(now.counters.refused, before->counters.refused + 1u);
        now.counters.refused--;
    }
    assert_memory_equal(&now, before, sizeof now);
}

static struct stream *open_lines(uint8_t n)
{
    struct stream *s = stream_new();
    s->config.open_lines = n;
    stream_begin(s);
    return s;
}

/* One open line of an eye, and a packet that it has to close for. */
static struct stream *open_waiting(lum_group *g)
{
    struct stream *s = open_lines(1);
    send_line(s, BLUE, 1);
    *g = packet(BLUE, 2, s->clock, 1);
    assert_int_equal(push(s, g), LUM_LINE_READY);
    return s;
}

/* Lengths */

static lum_result init_short(unsigned slots, unsigned words, unsigned reach)
{
    const lum_assembler_config c = {3, 5, 7, GAP};
    struct stream *s = stream_new();
    lum_assembler before;
    lum_line_slot *const slot = malloc((6u - slots) * sizeof *slot);
    uint32_t *const word = malloc((42u - words) * sizeof *word);
    lum_reach *const of = malloc((10u - reach) * sizeof *of);
    assert_true(slot != NULL && word != NULL && of != NULL);
    const lum_assembler_storage storage = {
        slot, word, of, 6u - slots, 42u - words, 10u - reach};
    before = s->assembler;
    const lum_result r =
        lum_assembler_init(&s->assembler, &c, &s->layout, &storage);
    if (r != LUM_OK) {
        assert_memory_equal(&s->assembler, &before, sizeof before);
    }
    free(slot);
    free(word);
    free(of);
    stream_free(s);
    return r;
}

static void arrays_too_short_by_one_are_refused(void **state)
{
    (void)state;
    assert_int_equal(init_short(0, 0, 0), LUM_OK);
    assert_int_equal(init_short(1, 0, 0), LUM_E_SPACE);
    assert_int_equal(init_short(0, 1, 0), LUM_E_SPACE);
    assert_int_equal(init_short(0, 0, 1), LUM_E_SPACE);
}

static void an_initialiser_knows_its_arrays(void **state)
{
    static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(3)];
    static uint32_t words[LUM_ASSEMBLER_WORDS(3, 7)];
    static lum_reach reach[LUM_ASSEMBLER_REACH(5)];
    const lum_assembler_storage s = LUM_ASSEMBLER_STORAGE(slots, words, reach);
    (void)state;
    assert_int_equal(s.slot_count, 6);
    assert_int_equal(s.word_count, 42);
    assert_int_equal(s.reach_count, 10);
}

/* Before init */

static void all_zero_refuses_all_calls(void **state)
{
    static lum_assembler a;
    const lum_group g = packet(BLUE, 1, 1, 1);
    (void)state;
    assert_int_equal(lum_assembler_push(&a, &g, 0), LUM_E_ORDER);
    assert_int_equal(lum_assembler_close_idle(&a, 0), LUM_E_ORDER);
    assert_int_equal(lum_assembler_flush(&a), LUM_E_ORDER);
    assert_int_equal(lum_assembler_counters(&a)->refused, 3);
    assert_null(lum_assembler_line(&a));
}

/* Another packet after an event */

/* Every member, without their names: the build fails for one more, which then
 * has to be among those that are compared, and to be changed below. */
static const lum_group one_of_each = {
    NULL, 0, 1, 1, 0, BLUE, LUM_TAG_ANGLES, LUM_ORDER_LITTLE};

static void an_event_waits_for_its_packet(void **state)
{
    lum_group g;
    struct stream *s = open_waiting(&g);
    const lum_assembler before = s->assembler;
    lum_group others[7];
    (void)state;
    (void)one_of_each;
    for (unsigned i = 0; i < 7; i++) {
        others[i] = g;
    }
    others[0].line++;
    others[1].num_samples++;
    others[2].first_sample_index++;
    others[3].clock_raw++;
    others[4].eye = GREEN;
    others[5].tag = LUM_TAG_RANGES;
    others[6].sample_order = LUM_ORDER_BIG;
    for (unsigned i = 0; i < 7; i++) {
        s->assembler = before;
        assert_untouched(s, &before, push(s, &others[i]), LUM_E_ORDER);
        assert_ptr_equal(lum_assembler_line(&s->assembler),
                         lum_assembler_line(&before));
    }
    assert_int_equal(push(s, &g), LUM_OK);
    assert_int_equal(counters(s)->refused, 1);
    stream_free(s);
}

static void its_samples_may_have_moved(void **state)
{
    const uint8_t moved[LUM_SAMPLE_BYTES] = {1, 2, 3, 4};
    lum_group g;
    struct stream *s = open_waiting(&g);
    (void)state;
    g.samples = moved;
    assert_int_equal(push(s, &g), LUM_OK);
    stream_end(s);
    assert_int_equal(nth_line(s, 0)->angles[0].azimuth, 0x201);
    stream_free(s);
}

static void a_frames_event_waits_too(void **state)
{
    struct stream *s = stream_open();
    lum_group g;
    lum_result r = LUM_OK;
    (void)state;
    send_lines(s, BLUE, 20, 40);
    send_lines(s, BLUE, 0, 7);
    for (uint32_t line = 8; r != LUM_FRAME_READY; line++) {
        g = packet(BLUE, line, s->clock, 1);
        s->clock += s->step;
        while ((r = push(s, &g)) == LUM_LINE_READY) {
        }
        assert_true(r == LUM_OK || r == LUM_FRAME_READY);
    }
    lum_group other = g;
    other.line++;
    const lum_assembler before = s->assembler;
    assert_untouched(s, &before, push(s, &other), LUM_E_ORDER);
    while ((r = push(s, &g)) > 0) {
        assert_int_equal(r, LUM_LINE_READY);
    }
    assert_int_equal(r, LUM_OK);
    stream_free(s);
}

/* As firmware has it that takes one event and goes on. */
static void an_if_in_place_of_while_shows(void **state)
{
    struct stream *s = open_lines(1);
    uint64_t refused = 0;
    (void)state;
    for (uint32_t line = 0; line < 20; line++) {
        const lum_group g = packet(BLUE, line, line * 3000u, 1);
        refused += push(s, &g) == LUM_E_ORDER ? 1u : 0u;
    }
    assert_int_equal(refused, 18);
    assert_int_equal(counters(s)->refused, 18);
    stream_free(s);
}

static void after_a_jump_the_packet_is_waited_for_line_by_line(void **state)
{
    struct stream *s = open_lines(4);
    (void)state;
    send_lines(s, BLUE, 1, 3);
    lum_group g = packet(BLUE, 9, s->clock + 10 * GAP, 1);
    assert_int_equal(push(s, &g), LUM_E_STRAY);
    for (unsigned i = 1; i <= 3; i++) {
        assert_int_equal(push(s, &g), LUM_LINE_READY);
        assert_int_equal(lum_assembler_line(&s->assembler)->number, i);
        lum_group other = packet(GREEN, 1, (uint32_t)g.clock_raw, 1);
        const lum_assembler before = s->assembler;
        assert_untouched(s, &before, push(s, &other), LUM_E_ORDER);
    }
    assert_int_equal(push(s, &g), LUM_OK);
    stream_free(s);
}

/* Groups that no decoder gives */

static void a_group_that_no_decoder_gives_is_refused(void **state)
{
    lum_group g;
    struct stream *s = open_waiting(&g);
    const lum_assembler before = s->assembler;
    lum_group bad[7];
    (void)state;
    for (unsigned i = 0; i < 7; i++) {
        bad[i] = g;
    }
    bad[0].eye = LUM_EYES;
    bad[1].tag = 1;
    bad[2].tag = 4;
    bad[3].num_samples = 0;
    bad[4].num_samples = LUM_LINE_PIXELS + 1u;
    bad[5].first_sample_index = LUM_LINE_PIXELS;
    bad[6].first_sample_index = UINT32_MAX;
    for (unsigned i = 0; i < 7; i++) {
        assert_untouched(s, &before, push(s, &bad[i]), LUM_E_VALUE);
    }
    assert_int_equal(push(s, &g), LUM_OK);
    stream_free(s);
}

/* Flush */

static void a_flush_gives_up_the_packet_that_waits(void **state)
{
    lum_group g;
    struct stream *s = open_waiting(&g);
    (void)state;
    stream_end(s);
    assert_int_equal(counters(s)->refused, 1);
    assert_int_equal(counters(s)->lines, 1);
    assert_int_equal(push(s, &g), LUM_OK); /* anew */
    assert_int_equal(counters(s)->refused, 1);
    stream_end(s);
    assert_int_equal(counters(s)->lines, 2);
    stream_free(s);
}

static void a_flush_gives_up_a_packet_that_proved_a_jump(void **state)
{
    struct stream *s = open_lines(4);
    (void)state;
    send_lines(s, BLUE, 1, 3);
    lum_group g = packet(BLUE, 9, s->clock + 10 * GAP, 1);
    assert_int_equal(push(s, &g), LUM_E_STRAY);
    assert_int_equal(push(s, &g), LUM_LINE_READY);
    stream_end(s);
    send_line(s, BLUE, 4); /* of the clock before: any may come */
    stream_end(s);
    assert_int_equal(counters(s)->lines, 4);
    assert_int_equal(counters(s)->stray, 1);
    stream_free(s);
}

static void a_flush_need_not_be_ended(void **state)
{
    struct stream *s = open_lines(4);
    (void)state;
    send_lines(s, BLUE, 1, 3);
    assert_int_equal(lum_assembler_flush(&s->assembler), LUM_LINE_READY);
    send_line(s, BLUE, 4);
    stream_end(s);
    assert_int_equal(counters(s)->lines, 4);
    stream_free(s);
}

static void packets_after_a_flush_begin_a_frame(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    for (unsigned i = 1; i <= 3; i++) {
        send_lines(s, BLUE, 10, 12);
        send_lines(s, GREEN, 10, 12);
        stream_end(s);
        assert_int_equal(counters(s)->frames, i);
        assert_int_equal(count_events(s, LUM_FRAME_READY), i);
        assert_int_equal(frame_of(s, BLUE, 12, i - 1u), i);
        assert_int_equal(frame_of(s, GREEN, 12, i - 1u), i);
        assert_int_equal(lum_assembler_frame(&s->assembler), i);
    }
    assert_int_equal(counters(s)->lines, 18);
    assert_int_equal(counters(s)->late, 0);
    assert_int_equal(counters(s)->lines_skipped, 0);
    stream_free(s);
}

static void nothing_of_before_a_flush_is_known_after_it(void **state)
{
    (void)state;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct stream *s = stream_open();
        const uint32_t clock = s->clock;
        send_lines(s, eye, 1, 3);
        stream_end(s);
        s->clock = clock;
        send_lines(s, eye, 1, 3); /* the same once more: not late */
        stream_end(s);
        s->clock = clock + 10 * GAP;
        send_lines(s, eye, 1, 3); /* and far off: no stray */
        stream_end(s);
        assert_int_equal(counters(s)->lines, 9);
        stream_free(s);
    }
}

/* Two lines had still to close for it. */
static void a_packet_given_up_closes_nothing_later(void **state)
{
    struct stream *s = open_lines(4);
    (void)state;
    send_lines(s, BLUE, 1, 4);
    lum_group g = packet(BLUE, 3, s->clock, 1);
    assert_int_equal(push(s, &g), LUM_LINE_READY);
    assert_int_equal(lum_assembler_flush(&s->assembler), LUM_LINE_READY);
    assert_int_equal(send_angles(s, BLUE, 4, s->clock - s->step, 500, 1),
                     LUM_OK);
    assert_int_equal(s->event_count, 0);
    stream_end(s);
    ASSERT_LINES(s, 3, 4);
    stream_free(s);
}

static void an_eye_left_behind_comes_up_at_a_flush(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, GREEN, 0, 1);
    for (unsigned i = 0; i < 3; i++) {
        send_lines(s, BLUE, 0, 40);
    }
    stream_end(s);
    const int64_t last = lum_assembler_frame(&s->assembler);
    assert_true(last >= 3);
    send_line(s, GREEN, 900);
    stream_end(s);
    assert_true(frame_of(s, GREEN, 900, 0) == last + 1);
    stream_free(s);
}

static void a_flush_of_nothing_changes_nothing(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    stream_end(s);
    send_line(s, GREEN, 0);
    send_line(s, BLUE, 900);
    stream_end(s);
    assert_int_equal(frame_of(s, GREEN, 0, 0), 1);
    assert_int_equal(frame_of(s, BLUE, 900, 0), 0);
    stream_free(s);
}

static void an_eye_that_comes_first_after_a_flush_is_behind_all(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 20, 30);
    stream_end(s);
    send_lines(s, GREEN, 900, 903); /* far above: else the frame before */
    stream_end(s);
    assert_int_equal(frame_of(s, GREEN, 900, 0), 2);
    assert_int_equal(frame_of(s, GREEN, 903, 0), 2);
    stream_free(s);
}

static void any_clock_may_come_after_a_flush(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 1, 2);
    stream_end(s);
    s->clock += 3000000000u;
    send_lines(s, BLUE, 1, 2);
    stream_end(s);
    assert_int_equal(counters(s)->stray, 0);
    assert_int_equal(counters(s)->lines, 4);
    assert_true(nth_line(s, 3)->clock_us - nth_line(s, 2)->clock_us == s->step);
    stream_free(s);
}

/* The flush was stopped before its end, and the eye that comes then counts as
 * late. */
static void a_frame_before_one_that_was_announced_is_counted(void **state)
{
    struct stream *s = stream_open();
    lum_result r = LUM_OK;
    (void)state;
    send_lines(s, GREEN, 0, 1);
    do {
        r = lum_assembler_flush(&s->assembler);
    } while (r == LUM_LINE_READY);
    assert_int_equal(r, LUM_FRAME_READY);
    assert_int_equal(lum_assembler_frame(&s->assembler), 1);
    send_line(s, BLUE, 900);
    stream_end(s);
    assert_int_equal(frame_of(s, BLUE, 900, 0), 0);
    assert_int_equal(counters(s)->frames, 2);
    assert_int_equal(count_events(s, LUM_FRAME_READY), 0);
    stream_free(s);
}

/* Idle lines */

/* Lines 1, 2 ... n of blue, whose packets came with arrivals 10, 20 ... */
static struct stream *open_idle(uint8_t slots, uint32_t n)
{
    struct stream *s = open_lines(slots);
    for (uint32_t line = 1; line <= n; line++) {
        s->arrival = 10 * (int64_t)line;
        assert_int_equal(send_angles(s, BLUE, line, line * 3000u, 0, 1),
                         LUM_OK);
    }
    return s;
}

static lum_result idle(struct stream *s, int64_t before)
{
    return lum_assembler_close_idle(&s->assembler, before);
}

static void assert_idle(struct stream *s, int64_t before, uint32_t number)
{
    assert_int_equal(idle(s, before), LUM_LINE_READY);
    assert_int_equal(lum_assembler_line(&s->assembler)->number, number);
}

static void lines_before_an_arrival_are_closed(void **state)
{
    struct stream *s = open_idle(4, 3);
    (void)state;
    assert_int_equal(idle(s, 10), LUM_OK); /* not before */
    assert_idle(s, 21, 1);
    assert_idle(s, 21, 2);
    assert_int_equal(idle(s, 21), LUM_OK);
    assert_int_equal(counters(s)->lines_idle, 2);
    assert_int_equal(counters(s)->lines, 2);
    assert_int_equal(send_angles(s, BLUE, 2, 6000, 1, 1), LUM_E_LATE);
    assert_int_equal(send_angles(s, BLUE, 3, 9000, 1, 1), LUM_OK);
    stream_free(s);
}

static void the_last_accepted_packet_counts(void **state)
{
    struct stream *s = open_idle(4, 2);
    (void)state;
    s->arrival = 50;
    assert_int_equal(send_angles(s, BLUE, 1, 3000, 1, 1), LUM_OK);
    s->arrival = 60;
    assert_int_equal(send_angles(s, BLUE, 2, 6000, 0, 1), LUM_E_DUPLICATE);
    assert_idle(s, 50, 2); /* not the oldest */
    assert_int_equal(idle(s, 50), LUM_OK);
    assert_idle(s, 51, 1);
    stream_free(s);
}

static void a_line_whose_first_packet_was_dropped_is_as_old_as_that(
    void **state)
{
    const uint32_t words[] = {1, 2};
    struct stream *s = stream_new();
    (void)state;
    s->config.words_per_line = 1;
    stream_begin(s);
    s->arrival = 7;
    assert_int_equal(send_words(s, BLUE, 1, 5000, 0, words, 2), LUM_E_NO_ROOM);
    assert_int_equal(idle(s, 7), LUM_OK);
    assert_idle(s, 8, 1);
    stream_free(s);
}

static void arrivals_may_be_0_and_below(void **state)
{
    static const int64_t arrivals[] = {INT64_MIN, -1, 0, INT64_MAX - 1};
    (void)state;
    for (unsigned i = 0; i < 4; i++) {
        struct stream *s = stream_open();
        s->arrival = arrivals[i];
        assert_int_equal(send_angles(s, GREEN, 5, 5000, 0, 1), LUM_OK);
        assert_int_equal(idle(s, arrivals[i]), LUM_OK);
        assert_idle(s, arrivals[i] + 1, 5);
        assert_true(lum_assembler_line(&s->assembler)->arrival == arrivals[i]);
        stream_free(s);
    }
}

static void both_eyes_may_be_idle(void **state)
{
    struct stream *s = open_idle(4, 2);
    (void)state;
    assert_int_equal(send_angles(s, GREEN, 7, 6000, 0, 1), LUM_OK);
    assert_idle(s, 100, 1);
    assert_idle(s, 100, 2);
    assert_idle(s, 100, 7);
    assert_int_equal(idle(s, 100), LUM_OK);
    assert_int_equal(counters(s)->lines_idle, 3);
    stream_free(s);
}

/* n lines of two packets, of which one has become idle. */
static struct stream *open_one_idle(uint8_t slots, uint32_t n, uint32_t which)
{
    struct stream *s = open_idle(slots, n);
    for (uint32_t line = 1; line <= n; line++) {
        s->arrival = line == which ? 100 : 200;
        assert_int_equal(send_angles(s, BLUE, line, line * 3000u, 1, 1),
                         LUM_OK);
    }
    return s;
}

/* All other lines stay, in order, and each slot can be used again. */
static void check_one_idle(uint8_t slots, uint32_t n, uint32_t which)
{
    struct stream *s = open_one_idle(slots, n, which);
    uint32_t number = 0;
    assert_idle(s, 200, which);
    assert_int_equal(idle(s, 200), LUM_OK);
    for (uint32_t line = n + 1u; line <= n + 9u; line++) {
        send_angles(s, BLUE, line, line * 3000u, 0, 1);
    }
    stream_end(s);
    assert_int_equal(counters(s)->lines, n + 9u);
    for (size_t i = 0; i + 1u < n + 9u; i++) {
        number += number + 1u == which ? 2u : 1u;
        assert_int_equal(nth_line(s, i)->number, number);
        assert_int_equal(nth_line(s, i)->angle_count, number <= n ? 2 : 1);
    }
    stream_free(s);
}

/* Every line of every number of slots, with any number of them open. */
static void any_line_may_be_idle(void **state)
{
    (void)state;
    for (uint8_t slots = 1; slots <= 5; slots++) {
        for (uint32_t n = 1; n <= slots; n++) {
            for (uint32_t which = 1; which <= n; which++) {
                check_one_idle(slots, n, which);
            }
        }
    }
}

static void idle_lines_are_not_closed_while_an_event_waits(void **state)
{
    lum_group g;
    struct stream *s = open_waiting(&g);
    const lum_assembler before = s->assembler;
    (void)state;
    assert_untouched(s, &before, idle(s, INT64_MAX), LUM_E_ORDER);
    assert_int_equal(push(s, &g), LUM_OK);
    assert_idle(s, INT64_MAX, 2);
    stream_free(s);
}

static void nothing_is_idle_where_nothing_is_open(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    assert_int_equal(idle(s, INT64_MAX), LUM_OK);
    stream_free(s);
}

/* Frame numbers go round. */
static void frames_go_round_32_bits(void **state)
{
    struct stream *s = stream_open();
    (void)state;
    send_lines(s, BLUE, 20, 21);
    send_lines(s, GREEN, 20, 21);
    stream_end(s);
    /* as if four thousand million frames had come */
    s->assembler.frames.next = UINT32_MAX - 1u;
    s->assembler.frames.highest = UINT32_MAX - 2u;
    for (unsigned e = 0; e < LUM_EYES; e++) {
        s->assembler.eye[e].frames.frame = UINT32_MAX - 2u;
        for (unsigned i = 0; i < s->config.reorder_lines; i++) {
            s->assembler.eye[e].reach[i].frame = UINT32_MAX - 1u;
        }
    }
    static const int64_t numbers[] = {INT64_C(0xfffffffe), INT64_C(0xffffffff),
                                      0, 1};
    for (unsigned i = 0; i < 4; i++) {
        for (uint32_t line = 0; line <= 40; line++) {
            send_line(s, BLUE, line);
            send_line(s, GREEN, line);
        }
    }
    stream_end(s);
    for (unsigned i = 0; i < 4; i++) {
        assert_true(frame_of(s, BLUE, 40, i) == numbers[i]);
    }
    size_t n = 0;
    for (size_t i = 0; i < s->event_count; i++) {
        if (s->events[i]->what == LUM_FRAME_READY && n++ > 0) {
            assert_true(s->events[i]->frame == numbers[n - 2u]);
        }
    }
    assert_int_equal(n, 5);
    stream_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_too_short_by_one_are_refused),
        cmocka_unit_test(an_initialiser_knows_its_arrays),
        cmocka_unit_test(all_zero_refuses_all_calls),
        cmocka_unit_test(an_event_waits_for_its_packet),
        cmocka_unit_test(its_samples_may_have_moved),
        cmocka_unit_test(a_frames_event_waits_too),
        cmocka_unit_test(an_if_in_place_of_while_shows),
        cmocka_unit_test(after_a_jump_the_packet_is_waited_for_line_by_line),
        cmocka_unit_test(a_group_that_no_decoder_gives_is_refused),
        cmocka_unit_test(a_flush_gives_up_the_packet_that_waits),
        cmocka_unit_test(a_flush_gives_up_a_packet_that_proved_a_jump),
        cmocka_unit_test(a_flush_need_not_be_ended),
        cmocka_unit_test(packets_after_a_flush_begin_a_frame),
        cmocka_unit_test(nothing_of_before_a_flush_is_known_after_it),
        cmocka_unit_test(a_packet_given_up_closes_nothing_later),
        cmocka_unit_test(an_eye_left_behind_comes_up_at_a_flush),
        cmocka_unit_test(a_flush_of_nothing_changes_nothing),
        cmocka_unit_test(an_eye_that_comes_first_after_a_flush_is_behind_all),
        cmocka_unit_test(any_clock_may_come_after_a_flush),
        cmocka_unit_test(a_frame_before_one_that_was_announced_is_counted),
        cmocka_unit_test(lines_before_an_arrival_are_closed),
        cmocka_unit_test(the_last_accepted_packet_counts),
        cmocka_unit_test(
            a_line_whose_first_packet_was_dropped_is_as_old_as_that),
        cmocka_unit_test(arrivals_may_be_0_and_below),
        cmocka_unit_test(both_eyes_may_be_idle),
        cmocka_unit_test(any_line_may_be_idle),
        cmocka_unit_test(idle_lines_are_not_closed_while_an_event_waits),
        cmocka_unit_test(nothing_is_idle_where_nothing_is_open),
        cmocka_unit_test(frames_go_round_32_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
