/* Tellings side by side, with some that take their process with them. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "dice/dice.h"
#include "report.h"
#include "telling.h"
#include "witness.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TELLINGS 60u

/* --- Sessions of our own, in place of the dice --- */

static struct verdict verdict;
static uint64_t runs; /* of this process */

const char *witness_rule(void)
{
    return verdict.count > 0 ? verdict.findings[0].rule : "";
}

const struct verdict *witness_verdict(void)
{
    return &verdict;
}

size_t witness_programs(void)
{
    return 3;
}

const user_story *user_story_at(size_t i)
{
    (void)i;
    return NULL;
}

user_result user_tell(const user_story *story, uint64_t seed)
{
    (void)story;
    return (user_result){.lasted_ns = (int64_t)seed};
}

/* Seed 17 crashes, and 18, which is another process's if there are two; 23 ends
 * its process; every tenth breaks a rule, and 41 differs when it is told again.
 */
user_result dice_run(uint64_t seed)
{
    user_result result = {.failure = "", .lasted_ns = 1000, .digest = seed};
    memset(&verdict, 0, sizeof verdict);
    verdict_asked(&verdict, "limit");
    runs++;
    if (seed == 17 || seed == 18) {
        (void)raise(SIGKILL);
    }
    if (seed == 23) {
        _exit(7);
    }
    if (seed % 10 == 0) {
        verdict_broken(&verdict, seed == 30 ? "tries" : "limit", 5, "made up");
        (void)snprintf(result.failure, sizeof result.failure, "of seed %d",
                       (int)seed);
    }
    result.calls = seed == 41 ? runs : 1;
    return result;
}

/* --- Tests --- */

static telling got[TELLINGS];

static void run(unsigned processes)
{
    telling_of = (telling_plan){.first_seed = 11, .is_dice = true};
    tellings_begin(processes);
    for (unsigned i = 0; i < TELLINGS; i++) {
        tellings_next(&got[i]);
    }
    tellings_end();
}

static void results_come_in_order_whoever_tells_them(void **state)
{
    (void)state;
    for (unsigned processes = 1; processes < 6; processes++) {
        run(processes);
        for (unsigned i = 0; i < TELLINGS; i++) {
            const uint64_t seed = telling_seed(i);
            assert_int_equal(got[i].index, i);
            assert_int_equal(seed, 11 + i);
            if (seed != 17 && seed != 18 && seed != 23) {
                assert_int_equal(got[i].result.digest, seed);
                assert_int_equal(got[i].programs, 3);
                assert_int_equal(got[i].result.failure[0] != '\0',
                                 seed % 10 == 0);
            }
        }
    }
}

static void one_that_takes_its_process_with_it_is_a_finding(void **state)
{
    (void)state;
    for (unsigned processes = 1; processes < 4; processes++) {
        run(processes);
        assert_string_equal(got[17 - 11].rule, "crash");
        assert_string_equal(got[17 - 11].result.failure,
                            "the program ended with signal 9");
        assert_string_equal(got[18 - 11].rule, "crash");
        assert_string_equal(got[23 - 11].result.failure,
                            "the program ended with status 7");
        assert_string_equal(got[19 - 11].rule, "");
        assert_string_equal(got[30 - 11].rule, "tries");
        assert_string_equal(got[30 - 11].result.failure, "of seed 30");
    }
}

static void sum_up(report *r, unsigned processes)
{
    run(processes);
    report_begin(r);
    for (unsigned i = 0; i < TELLINGS; i++) {
        const bool is_first = report_add(r, &got[i]);
        const uint64_t seed = telling_seed(i);
        assert_int_equal(is_first, seed == 17 || seed == 20 || seed == 30);
    }
}

static void a_report_is_the_same_with_more_processes(void **state)
{
    static report alone;
    static report both;
    (void)state;
    sum_up(&alone, 1);
    sum_up(&both, 2);
    assert_int_equal(alone.tellings, TELLINGS);
    assert_int_equal(alone.failures, 9); /* 17 18 20 23 30 40 50 60 70 */
    assert_int_equal(both.failures, alone.failures);
    assert_int_equal(both.lasted_ns, alone.lasted_ns);
    assert_int_equal(both.finding_count, 9);
    for (uint64_t i = 0; i < 9; i++) {
        assert_int_equal(both.findings[i].seed, alone.findings[i].seed);
        assert_string_equal(both.findings[i].rule, alone.findings[i].rule);
    }
    assert_memory_equal(&both.met, &alone.met, sizeof both.met);
    free(alone.findings);
    free(both.findings);
}

static void one_that_differs_when_it_is_told_again_is_a_finding(void **state)
{
    static telling t;
    (void)state;
    telling_of =
        (telling_plan){.first_seed = 40, .is_dice = true, .is_twice = true};
    telling_run(1, &t);
    assert_string_equal(t.rule, "twice");
    telling_run(2, &t);
    assert_string_equal(t.rule, "");
    telling_run(0, &t);
    assert_string_equal(t.rule, "limit");
}

static void what_tells_it_again_is_named(void **state)
{
    char name[64];
    (void)state;
    telling_of = (telling_plan){.first_seed = 11, .is_dice = true};
    telling_name(6, name, sizeof name);
    assert_string_equal(name, "--dice --seed 17");
}

/* Of three tellings: what comes once, and twice near each other. */
static void what_was_met_and_near_each_other_is_counted(void **state)
{
    static coverage sum;
    static coverage_one ones[3];
    (void)state;
    coverage_begin(&sum);
    for (unsigned i = 0; i < 3; i++) {
        ones[i].rule_count = 1;
        (void)strcpy(ones[i].rules[0].name, "limit");
        ones[i].rules[0].asked = i;
        ones[i].rules[0].is_broken = i == 2;
        ones[i].met_count = 2;
        (void)strcpy(ones[i].met[i == 0 ? 1 : 0].name, "step:cut");
        (void)strcpy(ones[i].met[i == 0 ? 0 : 1].name, "fault:of-its-own");
        ones[i].met[0].times = 2;
        ones[i].met[0].near[0] = i == 1 ? 2 : 0;
        ones[i].met[1].near[0] = i == 1 ? 1 : 0;
        coverage_add(&sum, &ones[i]);
    }
    unsigned rule = 0;
    while (strcmp(sum.rules[rule].name, "limit") != 0) {
        rule++;
    }
    assert_int_equal(sum.rules[rule].asked, 3);
    assert_int_equal(sum.rules[rule].asked_in, 2);
    assert_int_equal(sum.rules[rule].broken_in, 1);
    unsigned cut = 0;
    while (strcmp(sum.met[cut].name, "step:cut") != 0) {
        cut++;
    }
    const unsigned own = sum.met_count - 1;
    assert_string_equal(sum.met[own].name, "fault:of-its-own");
    assert_int_equal(sum.met[cut].met_in, 3);
    assert_int_equal(sum.together[cut][own], 3);
    assert_int_equal(sum.near[cut][own], 1);
    assert_int_equal(sum.near[own][cut], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_come_in_order_whoever_tells_them),
        cmocka_unit_test(one_that_takes_its_process_with_it_is_a_finding),
        cmocka_unit_test(a_report_is_the_same_with_more_processes),
        cmocka_unit_test(one_that_differs_when_it_is_told_again_is_a_finding),
        cmocka_unit_test(what_tells_it_again_is_named),
        cmocka_unit_test(what_was_met_and_near_each_other_is_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
