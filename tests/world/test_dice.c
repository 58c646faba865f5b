/* How the dice are thrown, and how a script is made smaller. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "dice/script.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 400

static struct script one;
static struct script two;

/* Nothing is told here. */
const char *script_process(unsigned tool)
{
    (void)tool;
    return "";
}

/* --- Shrinking --- */

/* It fails if it has all of them, and lasts long enough. */
struct cause {
    unsigned count;
    unsigned places[6];
    int64_t least_ends_ms;
    unsigned asked;
};

static bool has(const struct script *script, unsigned place)
{
    unsigned i = 0;
    while (i < script->count && script->steps[i].place != place) {
        i++;
    }
    return i < script->count;
}

static bool fails(const struct script *script, void *context)
{
    struct cause *cause = context;
    cause->asked++;
    for (unsigned i = 0; i < cause->count; i++) {
        if (!has(script, cause->places[i])) {
            return false;
        }
    }
    return script->ends_ms >= cause->least_ends_ms;
}

static void assert_is_smallest(const struct script *script,
                               const struct cause *cause)
{
    assert_int_equal(script->count, cause->count);
    for (unsigned i = 0; i < cause->count; i++) {
        assert_int_equal(script->steps[i].place, cause->places[i]);
    }
}

static void the_steps_that_it_takes_are_left(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 60; seed++) {
        script_draw(&one, seed);
        const unsigned n = one.count;
        struct cause causes[] = {{.count = 0},
                                 {.count = 1, .places = {1}},
                                 {.count = 1, .places = {n}},
                                 {.count = 2, .places = {1, n}},
                                 {.count = 2, .places = {n / 2, n / 2 + 1}}};
        for (size_t i = 0; n >= 4 && i < sizeof causes / sizeof *causes; i++) {
            two = one;
            const unsigned asked = script_shrink(&two, fails, &causes[i], 2000);
            assert_int_equal(asked, causes[i].asked);
            assert_is_smallest(&two, &causes[i]);
        }
    }
}

static void a_script_that_needs_all_of_it_stays(void **state)
{
    (void)state;
    script_draw(&one, 3);
    one.count = 6;
    struct cause all = {.count = 6, .places = {1, 2, 3, 4, 5, 6}};
    for (unsigned i = 0; i < 6; i++) {
        all.places[i] = one.steps[i].place;
    }
    (void)script_shrink(&one, fails, &all, MOST);
    assert_is_smallest(&one, &all);
}

/* With an even number of steps that run something, at least two. */
static bool is_even(const struct script *script, void *context)
{
    unsigned runs = 0;
    (void)context;
    for (unsigned i = 0; i < script->count; i++) {
        runs += script->steps[i].kind == SCRIPT_RUN ? 1 : 0;
    }
    return runs >= 2 && runs % 2 == 0;
}

static void what_is_left_fails_though_some_steps_hide_it(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 60; seed++) {
        script_draw(&one, seed);
        if (is_even(&one, NULL)) {
            (void)script_shrink(&one, is_even, NULL, MOST);
            assert_true(is_even(&one, NULL));
            for (unsigned i = 0; i < one.count; i++) {
                assert_int_equal(one.steps[i].kind, SCRIPT_RUN);
            }
        }
    }
}

static void idle_time_at_the_end_goes_if_it_may(void **state)
{
    struct cause cause = {.count = 1, .places = {1}};
    (void)state;
    script_draw(&one, 5);
    two = one;
    (void)script_shrink(&two, fails, &cause, MOST);
    assert_int_equal(two.ends_ms,
                     one.steps[0].at_ms + one.steps[0].lasts_ms + 5000);
    cause.least_ends_ms = one.ends_ms;
    two = one;
    (void)script_shrink(&two, fails, &cause, MOST);
    assert_int_equal(two.ends_ms, one.ends_ms);
    assert_is_smallest(&two, &cause);
}

static void it_ends_after_so_many_tellings(void **state)
{
    (void)state;
    script_draw(&one, 8);
    struct cause cause = {.count = 1, .places = {one.count}};
    assert_true(script_shrink(&one, fails, &cause, 3) <= 4);
    assert_int_equal(cause.asked, 4);
    assert_true(fails(&one, &cause));
}

static void steps_are_kept_by_their_places(void **state)
{
    const bool wanted[SCRIPT_STEPS + 1] = {[2] = true, [4] = true};
    (void)state;
    script_draw(&one, 2);
    const script_step second = one.steps[1];
    script_keep(&one, wanted);
    assert_int_equal(one.count, 2);
    assert_int_equal(one.steps[0].place, 2);
    assert_int_equal(one.steps[0].at_ms, second.at_ms);
    assert_int_equal(one.steps[1].place, 4);
}

/* --- Drawing --- */

/* What a person reads of it, but for its seed. */
static char *print(uint64_t seed)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    script_draw(&one, seed);
    one.seed = 0;
    script_print(&one, out);
    assert_int_equal(fclose(out), 0);
    return text;
}

static void a_seed_draws_the_same_script_each_time(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 200; seed++) {
        char *first = print(seed);
        char *again = print(seed);
        assert_string_equal(first, again);
        free(first);
        free(again);
    }
}

static uint64_t hash(const char *text)
{
    uint64_t value = UINT64_C(0xcbf29ce484222325);
    for (; *text != '\0'; text++) {
        value = (value ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
    }
    return value;
}

static int by_value(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return left < right ? -1 : left > right ? 1 : 0;
}

#define MANY 20000u

static void no_two_seeds_share_a_script(void **state)
{
    static uint64_t hashes[MANY];
    (void)state;
    for (uint64_t seed = 0; seed < MANY; seed++) {
        char *text = print(seed);
        hashes[seed] = hash(text);
        free(text);
    }
    qsort(hashes, MANY, sizeof hashes[0], by_value);
    for (size_t i = 1; i < MANY; i++) {
        assert_true(hashes[i] != hashes[i - 1]);
    }
}

static bool is_told_of(const struct script *script, const script_step *step)
{
    bool is_there = false;
    for (unsigned i = 0; i < script->count; i++) {
        const script_step *s = &script->steps[i];
        is_there = is_there || (s->kind == SCRIPT_RUN && s->tool == step->tool);
    }
    return is_there;
}

static bool is_of_tool(const script_step *step)
{
    return step->call[0] != '\0' || step->kind == SCRIPT_RUN ||
           step->kind == SCRIPT_TYPE || step->kind == SCRIPT_SIGNAL ||
           step->kind == SCRIPT_STOP;
}

static void check_step(const struct script *script, unsigned i)
{
    const script_step *step = &script->steps[i];
    assert_int_equal(step->place, i + 1);
    assert_true(i == 0 || step->at_ms >= step[-1].at_ms);
    assert_true(step->lasts_ms >= 0);
    if (is_of_tool(step)) {
        assert_true(step->tool > 0);
        /* One that runs too late to have a place is not told of. */
        assert_true(script->count == SCRIPT_STEPS || is_told_of(script, step));
    }
    if (step->call[0] != '\0') {
        assert_true(step->n >= 1 && step->n <= 60);
    }
}

static void scripts_are_in_order_and_name_tools_that_they_run(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 2000; seed++) {
        script_draw(&one, seed);
        assert_true(one.count > 0 && one.count <= SCRIPT_STEPS);
        for (unsigned i = 0; i < one.count; i++) {
            check_step(&one, i);
        }
    }
}

/* --- Weights --- */

#define SEEDS 4000u

/* Words that one scene alone has, and its share of 17 (draw.c). */
static const struct {
    const char *words;
    unsigned share;
} scenes[] = {{" find ", 1}, {" doctor ", 1}, {" shell", 1},
              {" -o - ", 1}, {"lumview ", 1}, {" set-ip ", 2}};

#define SCENES (sizeof scenes / sizeof scenes[0])

static void count_scenes(const struct script *script, unsigned counts[SCENES])
{
    for (unsigned i = 0; i < script->count; i++) {
        const script_step *step = &script->steps[i];
        for (size_t k = 0; step->kind == SCRIPT_RUN && k < SCENES; k++) {
            counts[k] += strstr(step->text, scenes[k].words) != NULL ? 1 : 0;
        }
    }
}

/* A session has 2 to 5 scenes, each of 17 as likely as any other. */
static void scenes_come_as_often_as_their_weight_says(void **state)
{
    unsigned counts[SCENES] = {0};
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        script_draw(&one, seed);
        count_scenes(&one, counts);
    }
    for (size_t k = 0; k < SCENES; k++) {
        const double expected = SEEDS * 3.5 * scenes[k].share / 17.0;
        assert_true(counts[k] > 0.85 * expected);
        assert_true(counts[k] < 1.15 * expected);
    }
}

static void each_kind_of_step_is_drawn(void **state)
{
    unsigned kinds[SCRIPT_BLACKOUT + 1] = {0};
    unsigned ways[SCRIPT_IN + 1] = {0};
    unsigned far = 0;
    unsigned stalled = 0;
    unsigned aimed = 0;
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        script_draw(&one, seed);
        for (unsigned i = 0; i < one.count; i++) {
            const script_step *step = &one.steps[i];
            kinds[step->kind]++;
            ways[step->way] += step->kind == SCRIPT_WIRE ? 1 : 0;
            far += step->is_far ? 1 : 0;
            stalled += step->is_stalled ? 1 : 0;
            aimed += step->call[0] != '\0' && step->kind != SCRIPT_AT_CALL;
        }
    }
    for (size_t i = 0; i <= SCRIPT_BLACKOUT; i++) {
        assert_true(kinds[i] > SEEDS / 20);
    }
    /* Each of the three ways is a third of all. */
    for (size_t i = 0; i <= SCRIPT_IN; i++) {
        assert_true(10 * ways[i] > 3 * kinds[SCRIPT_WIRE]);
        assert_true(10 * ways[i] < 4 * kinds[SCRIPT_WIRE]);
    }
    assert_true(far > SEEDS / 20 && stalled > SEEDS / 20 && aimed > SEEDS / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_steps_that_it_takes_are_left),
        cmocka_unit_test(a_script_that_needs_all_of_it_stays),
        cmocka_unit_test(what_is_left_fails_though_some_steps_hide_it),
        cmocka_unit_test(idle_time_at_the_end_goes_if_it_may),
        cmocka_unit_test(it_ends_after_so_many_tellings),
        cmocka_unit_test(steps_are_kept_by_their_places),
        cmocka_unit_test(a_seed_draws_the_same_script_each_time),
        cmocka_unit_test(no_two_seeds_share_a_script),
        cmocka_unit_test(scripts_are_in_order_and_name_tools_that_they_run),
        cmocka_unit_test(scenes_come_as_often_as_their_weight_says),
        cmocka_unit_test(each_kind_of_step_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
