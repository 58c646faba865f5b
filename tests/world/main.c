/* The program `world`: tells stories under seeds, and what the dice make up. */
#define _GNU_SOURCE
#include "dice/dice.h"
#include "report.h"
#include "telling.h"
#include "user.h"
#include "witness.h"

#include "image/images.h"
#include "kernel/crash.h"
#include "kernel/trace.h"

#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define JOBS_MAX 64

typedef struct options {
    uint64_t last_seed;
    double hours; /* above 0: of the dice, at least */
    unsigned jobs;
    const char *steps;
    int64_t end_ms;
    const char *report;
    bool is_list, is_trace, is_verbose, has_seeds;
    bool traces_all;
} options;

static options wanted = {.last_seed = 3, .jobs = 1};

static const char help[] =
    "world [OPTION]...: tells stories of tools, sensors and users in a "
    "simulated world\n"
    "  --list            the stories, and what they show\n"
    "  --story NAME      this one alone\n"
    "  --seed N          under this seed alone\n"
    "  --seeds A..B      under these; 1..3 if not said\n"
    "  --dice            what the dice make up, under these seeds\n"
    "  --hours H         what the dice make up, from the first seed on, for at "
    "least\n"
    "                    so many simulated hours, and all of --seeds\n"
    "  --steps LIST      with --dice --seed: only these steps of its script, "
    "as "
    "1,5,7\n"
    "  --end S           with --dice --seed: it ends at this second\n"
    "  --trace           with a log of what happens, on standard error\n"
    "  --trace=all       with each datagram of data too\n"
    "  --twice           each twice, which has to be the same\n"
    "  --verbose         names each telling\n"
    "  --report FILE     all that a run of the dice met and found, as JSON\n"
    "  -j N              so many processes side by side; what is told is the "
    "same\n"
    "  --help\n"
    "Status: 0 if all held, 1 if not, 2 for wrong arguments.\n";

/* --- arguments --- */

__attribute__((noreturn)) static void refuse(const char *what,
                                             const char *value)
{
    (void)fprintf(stderr, "world: %s '%s'; see --help\n", what, value);
    exit(2);
}

static uint64_t number(const char *text, const char **end)
{
    char *behind = NULL;
    const uint64_t value = strtoull(text, &behind, 10);
    if (behind == text) {
        refuse("no number:", text);
    }
    *end = behind;
    return value;
}

static uint64_t whole_number(const char *text)
{
    const char *end = NULL;
    const uint64_t value = number(text, &end);
    if (*end != '\0') {
        refuse("no number:", text);
    }
    return value;
}

static void take_seeds(const char *text)
{
    const char *end = NULL;
    telling_of.first_seed = number(text, &end);
    if (strncmp(end, "..", 2) != 0) {
        refuse("seeds are A..B, not", text);
    }
    wanted.last_seed = whole_number(end + 2);
    wanted.has_seeds = true;
    if (wanted.last_seed < telling_of.first_seed) {
        refuse("no seeds:", text);
    }
}

static void take_hours(const char *text)
{
    char *end = NULL;
    wanted.hours = strtod(text, &end);
    if (end == text || *end != '\0' || !(wanted.hours > 0)) {
        refuse("no hours:", text);
    }
    telling_of.is_dice = true;
}

enum {
    LIST = 256,
    STORY_NAME,
    SEED,
    SEEDS,
    HOURS,
    DICE,
    TRACE,
    TWICE,
    VERBOSE,
    STEPS,
    END,
    REPORT
};

static void take_end(const char *text)
{
    char *end = NULL;
    const double seconds = strtod(text, &end);
    if (end == text || *end != '\0' || !(seconds > 0 && seconds < 1e6)) {
        refuse("no second to end at:", text);
    }
    wanted.end_ms = (int64_t)llround(seconds * 1000.0);
}

static void take_jobs(const char *text)
{
    const uint64_t jobs = whole_number(text);
    if (jobs == 0 || jobs > JOBS_MAX) {
        refuse("-j takes 1 to 64, not", text);
    }
    wanted.jobs = (unsigned)jobs;
}

static void take_story(const char *name)
{
    telling_of.story = user_story_find(name);
    if (telling_of.story == NULL) {
        refuse("there is no story", name);
    }
}

/* Those of a run as a whole. */
static void take_value_of_run(int option, const char *value)
{
    if (option == STEPS) {
        wanted.steps = value;
    } else if (option == END) {
        take_end(value);
    } else if (option == REPORT) {
        wanted.report = value;
    } else if (option == 'j') {
        take_jobs(value);
    }
}

static void take_value(int option, const char *value)
{
    if (option == STORY_NAME) {
        take_story(value);
    } else if (option == SEED) {
        telling_of.first_seed = whole_number(value);
        wanted.last_seed = telling_of.first_seed;
    } else if (option == SEEDS) {
        take_seeds(value);
    } else if (option == HOURS) {
        take_hours(value);
    } else if (option == TRACE) {
        if (strcmp(value, "all") != 0) {
            refuse("--trace or --trace=all, not", value);
        }
        wanted.traces_all = true;
    } else {
        take_value_of_run(option, value);
    }
}

static void take(int option, const char *value)
{
    wanted.is_list = wanted.is_list || option == LIST;
    telling_of.is_dice = telling_of.is_dice || option == DICE;
    wanted.is_trace = wanted.is_trace || option == TRACE;
    telling_of.is_twice = telling_of.is_twice || option == TWICE;
    wanted.is_verbose = wanted.is_verbose || option == VERBOSE;
    if (option == 'h') {
        (void)fputs(help, stdout);
        exit(0);
    }
    if (option == '?') {
        exit(2);
    }
    if (value != NULL) {
        take_value(option, value);
    }
}

static void check_arguments(void)
{
    const bool is_one =
        telling_of.is_dice && wanted.last_seed == telling_of.first_seed;
    if (telling_of.is_dice && telling_of.story != NULL) {
        refuse("no dice in a story:", telling_of.story->name);
    }
    if ((wanted.steps != NULL || wanted.end_ms > 0) && !is_one) {
        refuse("a part of a session is of --dice --seed:",
               wanted.steps != NULL ? wanted.steps : "--end");
    }
    if (!dice_only(wanted.steps, wanted.end_ms)) {
        refuse("no steps:", wanted.steps);
    }
}

static void take_arguments(int argc, char **argv)
{
    static const struct option long_options[] = {
        {"list", no_argument, NULL, LIST},
        {"story", required_argument, NULL, STORY_NAME},
        {"seed", required_argument, NULL, SEED},
        {"seeds", required_argument, NULL, SEEDS},
        {"hours", required_argument, NULL, HOURS},
        {"dice", no_argument, NULL, DICE},
        {"trace", optional_argument, NULL, TRACE},
        {"twice", no_argument, NULL, TWICE},
        {"verbose", no_argument, NULL, VERBOSE},
        {"steps", required_argument, NULL, STEPS},
        {"end", required_argument, NULL, END},
        {"report", required_argument, NULL, REPORT},
        {"help", no_argument, NULL, 'h'},
        {NULL, 0, NULL, 0}};
    int option = 0;
    while ((option = getopt_long(argc, argv, "j:", long_options, NULL)) != -1) {
        take(option, optarg);
    }
    if (optind < argc) {
        refuse("not an option:", argv[optind]);
    }
    check_arguments();
}

/* --- a run --- */

static report sum;
static double begun_s;

static double now_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec / 1e9;
}

static double hours_of(int64_t ns)
{
    return (double)ns / 3600e9;
}

/* One line that is written over, where somebody looks. */
static void tell_progress(bool is_end)
{
    static double told_s;
    if (wanted.is_trace || isatty(STDERR_FILENO) == 0 ||
        (!is_end && now_s() < told_s + 0.2)) {
        return;
    }
    told_s = now_s();
    (void)fprintf(stderr, "\r\033[K");
    if (!is_end) {
        (void)fprintf(
            stderr, "%.1f hours, %" PRIu64 " told, %" PRIu64 " failed, %.0f s ",
            hours_of(sum.lasted_ns), sum.tellings, sum.failures,
            told_s - begun_s);
    }
    (void)fflush(stderr);
}

static void tell_result(const telling *t)
{
    char name[160];
    telling_name(t->index, name, sizeof name);
    if (t->rule[0] == '\0' && !wanted.is_verbose) {
        return;
    }
    tell_progress(true);
    if (t->rule[0] != '\0') {
        printf("FAIL %s: %s\n     replay: script/world %s --trace\n", name,
               t->result.failure, name);
    } else {
        printf("ok   %s: %.1f s, %" PRIu64 " calls, digest %016" PRIx64 "\n",
               name, (double)t->result.lasted_ns / 1e9, t->result.calls,
               t->result.digest);
    }
    (void)fflush(stdout);
}

static void print_smallest(void *argument)
{
    const telling *t = argument;
    dice_print_smallest(telling_seed(t->index), strcmp(t->rule, "crash") == 0);
}

/* Of each rule, one failure of the dice is made small. */
static void take_result(telling *t)
{
    const bool is_first = report_add(&sum, t);
    tell_result(t);
    if (is_first && telling_of.is_dice && !wanted.is_trace &&
        strcmp(t->rule, "no-end") != 0 && strcmp(t->rule, "twice") != 0) {
        (void)telling_apart(print_smallest, t);
    }
    tell_progress(false);
}

static bool has_more(void)
{
    const uint64_t seeds = wanted.last_seed - telling_of.first_seed + 1;
    if (wanted.hours > 0 && hours_of(sum.lasted_ns) < wanted.hours) {
        return true;
    }
    return (wanted.hours > 0 && !wanted.has_seeds)
               ? false
               : sum.tellings < seeds * telling_each();
}

/* With a trace here, for a debugger too. */
static void tell_all(void)
{
    static telling t;
    if (!wanted.is_trace) {
        tellings_begin(wanted.jobs);
    }
    while (has_more()) {
        if (wanted.is_trace) {
            telling_run(sum.tellings, &t);
        } else {
            tellings_next(&t);
        }
        take_result(&t);
    }
    tell_progress(true);
    if (!wanted.is_trace) {
        tellings_end();
    }
}

static int conclude(void)
{
    const double seconds = now_s() - begun_s;
    report_print(&sum, seconds,
                 (telling_of.is_dice && sum.tellings > 1) || wanted.is_verbose);
    if (wanted.report != NULL && !report_write(&sum, seconds, wanted.report)) {
        (void)fprintf(stderr, "world: %s: %s\n", wanted.report,
                      strerror(errno));
        return 1;
    }
    return sum.failures == 0 && sum.tellings > 0 ? 0 : 1;
}

static int list(void)
{
    for (size_t i = 0; user_story_at(i) != NULL; i++) {
        const user_story *story = user_story_at(i);
        printf("%-40s %s\n", story->name, story->fact);
    }
    return 0;
}

int main(int argc, char **argv)
{
    world_images();
    take_arguments(argc, argv);
    if (wanted.is_list) {
        return list();
    }
    begun_s = now_s();
    witness_install();
    world_crash_tell();
    world_traces = wanted.is_trace;
    user_trace_datagrams(wanted.traces_all);
    report_begin(&sum);
    tell_all();
    return conclude();
}
