#include "coverage.h"

#include <inttypes.h>
#include <string.h>

/* Lines that a short report has for pairs that never met. */
#define APART_LINES 16
#define LINE_WIDTH  118

/* The table of docs/internals/testing.md, "The judges". */
static const char *const known_rules[] = {"laser-late",
                                          "heartbeat-late",
                                          "laser-asked",
                                          "laser-again",
                                          "laser-back",
                                          "off-asked",
                                          "move-asked",
                                          "no-flood",
                                          "done-true",
                                          "on-true",
                                          "off-true",
                                          "off-seen-twice",
                                          "taken-back",
                                          "move-true",
                                          "status-true",
                                          "done-as-status",
                                          "line-in-time",
                                          "line-typed",
                                          "line-in-calm",
                                          "time-true",
                                          "found-true",
                                          "found-all",
                                          "found-in-calm",
                                          "status-of-find",
                                          "show-true",
                                          "doctor-true",
                                          "limit",
                                          "limit-after-signal",
                                          "one-fate",
                                          "counts",
                                          "counts-of-outputs",
                                          "counts-of-recording",
                                          "counts-of-lines",
                                          "points-written",
                                          "recording",
                                          "recording-whole",
                                          "file-whole",
                                          "file-synced",
                                          "file-there",
                                          "file-left",
                                          "status-known",
                                          "status-0",
                                          "status-2",
                                          "status-3",
                                          "status-4",
                                          "status-of-outputs",
                                          "status-in-calm",
                                          "status-of-signal",
                                          "answers-in-calm",
                                          "ends-by-signal",
                                          "one-owner",
                                          "owner-told",
                                          "owner-invented",
                                          "one-number",
                                          "tries",
                                          "pause-of-tries",
                                          "heartbeat-gap",
                                          "leave-needed",
                                          "room-for-all"};

/* What the dice draw (dice/tell.c), and what comes of it in the kernel. */
static const char *const known_met[] = {"step:run",
                                        "step:far",
                                        "step:type",
                                        "step:plan",
                                        "step:signal",
                                        "step:stop",
                                        "step:at-call",
                                        "step:wire",
                                        "step:cut",
                                        "step:cable",
                                        "step:address",
                                        "step:disk",
                                        "step:clock",
                                        "step:drift",
                                        "step:slow-host",
                                        "step:hazard",
                                        "step:reboot",
                                        "step:silence",
                                        "step:power",
                                        "step:blackout",
                                        "fault:lose",
                                        "fault:repeat",
                                        "fault:corrupt",
                                        "fault:reorder",
                                        "fault:cut",
                                        "fault:clock-step",
                                        "fault:clock-drift",
                                        "fault:power-cut",
                                        "fault:disk-full",
                                        "fault:disk-slow-write",
                                        "fault:disk-slow-sync",
                                        "fault:disk-slow-rename",
                                        "fault:disk-slow-open",
                                        "fault:disk-slow-close",
                                        "fault:disk-stall-write",
                                        "fault:disk-stall-sync",
                                        "fault:disk-stall-rename",
                                        "fault:disk-stall-open",
                                        "fault:disk-stall-close",
                                        "fault:disk-fail-write",
                                        "fault:disk-fail-sync",
                                        "fault:disk-fail-rename",
                                        "fault:disk-fail-open",
                                        "fault:reader-stalls",
                                        "fault:reader-slow",
                                        "fault:reader-closes",
                                        "call:clock_gettime",
                                        "call:close",
                                        "call:fclose",
                                        "call:fflush",
                                        "call:fsync",
                                        "call:ftruncate",
                                        "call:fwrite",
                                        "call:open",
                                        "call:poll",
                                        "call:ppoll",
                                        "call:recvmmsg",
                                        "call:rename",
                                        "call:sendmmsg",
                                        "call:unlink",
                                        "call:write",
                                        "net:buffer-full",
                                        "net:checksum",
                                        "net:foreign",
                                        "net:no-answer-to-arp",
                                        "net:refused"};

#define COUNT(list) ((unsigned)(sizeof(list) / sizeof(list)[0]))

static void name(char out[COVERAGE_NAME], const char *text)
{
    (void)snprintf(out, COVERAGE_NAME, "%s", text);
}

/* --- Of one telling --- */

static unsigned rule_of_one(coverage_one *one, const char *rule)
{
    unsigned i = 0;
    while (i < one->rule_count &&
           strncmp(one->rules[i].name, rule, COVERAGE_NAME - 1) != 0) {
        i++;
    }
    if (i == one->rule_count && i + 1 < COVERAGE_RULES) {
        name(one->rules[one->rule_count++].name, rule);
    }
    return i;
}

static void take_rules(coverage_one *out, const struct verdict *verdict)
{
    for (unsigned i = 0; i < verdict->rule_count; i++) {
        const unsigned at = rule_of_one(out, verdict->rules[i].rule);
        out->rules[at].asked += verdict->rules[i].asked;
    }
    for (unsigned i = 0; i < verdict->count; i++) {
        out->rules[rule_of_one(out, verdict->findings[i].rule)].is_broken =
            true;
    }
}

void coverage_take(coverage_one *out, const struct verdict *verdict)
{
    memset(out, 0, sizeof *out);
    take_rules(out, verdict);
    out->met_count = world_met_count();
    for (unsigned i = 0; i < out->met_count; i++) {
        name(out->met[i].name, world_met_name(i));
        out->met[i].times = world_met_times(i);
        for (unsigned j = 0; j < out->met_count; j++) {
            out->met[i].near[j / 64] |= (uint64_t)(world_met_near(i, j) ? 1 : 0)
                                        << j % 64;
        }
    }
}

/* --- The sum --- */

static unsigned rule_of(coverage *sum, const char *rule)
{
    unsigned i = 0;
    while (i < sum->rule_count && strcmp(sum->rules[i].name, rule) != 0) {
        i++;
    }
    if (i == sum->rule_count && i + 1 < COVERAGE_RULES) {
        name(sum->rules[sum->rule_count++].name, rule);
    }
    return i;
}

static unsigned met_of(coverage *sum, const char *what)
{
    unsigned i = 0;
    while (i < sum->met_count && strcmp(sum->met[i].name, what) != 0) {
        i++;
    }
    if (i == sum->met_count && i + 1 < WORLD_MET_MAX) {
        name(sum->met[sum->met_count++].name, what);
    }
    return i;
}

void coverage_begin(coverage *sum)
{
    memset(sum, 0, sizeof *sum);
    for (unsigned i = 0; i < COUNT(known_rules); i++) {
        (void)rule_of(sum, known_rules[i]);
    }
    for (unsigned i = 0; i < COUNT(known_met); i++) {
        (void)met_of(sum, known_met[i]);
    }
}

void coverage_add(coverage *sum, const coverage_one *one)
{
    unsigned at[WORLD_MET_MAX];
    for (unsigned i = 0; i < one->rule_count; i++) {
        struct coverage_rule *rule =
            &sum->rules[rule_of(sum, one->rules[i].name)];
        rule->asked += one->rules[i].asked;
        rule->asked_in += one->rules[i].asked > 0 ? 1 : 0;
        rule->broken_in += one->rules[i].is_broken ? 1 : 0;
    }
    for (unsigned i = 0; i < one->met_count; i++) {
        at[i] = met_of(sum, one->met[i].name);
        sum->met[at[i]].times += one->met[i].times;
        sum->met[at[i]].met_in++;
    }
    for (unsigned i = 0; i < one->met_count; i++) {
        for (unsigned j = 0; j < one->met_count; j++) {
            sum->together[at[i]][at[j]]++;
            sum->near[at[i]][at[j]] += one->met[i].near[j / 64] >> j % 64 & 1u;
        }
    }
}

/* --- For people --- */

static bool was_met(const coverage *sum, unsigned i)
{
    return sum->met[i].met_in > 0;
}

static void print_rules(const coverage *sum, FILE *out)
{
    unsigned asked = 0;
    for (unsigned i = 0; i < sum->rule_count; i++) {
        asked += sum->rules[i].asked_in > 0 ? 1 : 0;
    }
    (void)fprintf(out, "%-38s %12s %12s %8s\n", "rules", "asked in", "cases",
                  "broken");
    for (unsigned i = 0; i < sum->rule_count; i++) {
        const struct coverage_rule *rule = &sum->rules[i];
        (void)fprintf(out, "  %-36s %12" PRIu64 " %12" PRIu64 " %8" PRIu64 "\n",
                      rule->name, rule->asked_in, rule->asked, rule->broken_in);
    }
    (void)fprintf(out, "%u of %u rules were asked\n\n", asked, sum->rule_count);
}

static void print_met(const coverage *sum, FILE *out)
{
    unsigned met = 0;
    (void)fprintf(out, "%-38s %12s %12s\n", "steps and faults", "met in",
                  "times");
    for (unsigned i = 0; i < sum->met_count; i++) {
        met += was_met(sum, i) ? 1 : 0;
        (void)fprintf(out, "  %-36s %12" PRIu64 " %12" PRIu64 "\n",
                      sum->met[i].name, sum->met[i].met_in, sum->met[i].times);
    }
    (void)fprintf(out, "%u of %u were met\n\n", met, sum->met_count);
}

/* Of those that were met at all. */
static bool is_apart(const coverage *sum, unsigned i, unsigned j)
{
    return i != j && was_met(sum, i) && was_met(sum, j) && sum->near[i][j] == 0;
}

static unsigned count_apart(const coverage *sum, unsigned i, const bool *done)
{
    unsigned count = 0;
    for (unsigned j = 0; j < sum->met_count; j++) {
        count += !done[i] && !done[j] && is_apart(sum, i, j) ? 1 : 0;
    }
    return count;
}

/* One line: as many as fit. Each pair stands once. */
static void print_apart_from(const coverage *sum, unsigned i, const bool *done,
                             FILE *out)
{
    unsigned left = count_apart(sum, i, done);
    int used = fprintf(out, "  %s and %u:", sum->met[i].name, left);
    for (unsigned j = 0; j < sum->met_count && left > 0; j++) {
        if (done[j] || !is_apart(sum, i, j)) {
            continue;
        }
        if (used > LINE_WIDTH - COVERAGE_NAME) {
            (void)fputs(" ...", out);
            break;
        }
        left--;
        used += fprintf(out, " %s%s", sum->met[j].name, left > 0 ? "," : "");
    }
    (void)fputc('\n', out);
}

static void print_apart(const coverage *sum, FILE *out)
{
    bool done[WORLD_MET_MAX] = {false};
    for (unsigned lines = 0; lines < APART_LINES; lines++) {
        unsigned most = 0;
        for (unsigned i = 1; i < sum->met_count; i++) {
            if (count_apart(sum, i, done) > count_apart(sum, most, done)) {
                most = i;
            }
        }
        if (count_apart(sum, most, done) == 0) {
            return;
        }
        print_apart_from(sum, most, done, out);
        done[most] = true;
    }
    for (unsigned i = 0; i < sum->met_count; i++) {
        if (count_apart(sum, i, done) > 0) {
            (void)fputs("  ... and more; --report has all\n", out);
            return;
        }
    }
}

static void print_pairs(const coverage *sum, FILE *out)
{
    unsigned all = 0;
    unsigned together = 0;
    unsigned near = 0;
    for (unsigned i = 0; i < sum->met_count; i++) {
        for (unsigned j = 0; j < i; j++) {
            all += was_met(sum, i) && was_met(sum, j) ? 1 : 0;
            together += sum->together[i][j] > 0 ? 1 : 0;
            near += sum->near[i][j] > 0 ? 1 : 0;
        }
    }
    (void)fprintf(out,
                  "pairs of steps and faults that were met: %u; %u of them in "
                  "one session, %u within %d s\n",
                  all, together, near, (int)(WORLD_MET_NEAR_NS / 1000000000));
    if (near < all) {
        (void)fputs("never so near each other:\n", out);
        print_apart(sum, out);
    }
    (void)fputc('\n', out);
}

void coverage_print(const coverage *sum, FILE *out)
{
    print_rules(sum, out);
    print_met(sum, out);
    print_pairs(sum, out);
}

/* --- For programs --- */

static const char *comma(unsigned i)
{
    return i > 0 ? "," : "";
}

static void print_pairs_json(const coverage *sum, FILE *out)
{
    unsigned count = 0;
    (void)fputs(" \"pairs\": [", out);
    for (unsigned i = 0; i < sum->met_count; i++) {
        for (unsigned j = 0; j < i; j++) {
            (void)fprintf(out,
                          "%s\n  {\"of\": [\"%s\", \"%s\"], \"together\": "
                          "%" PRIu32 ", \"near\": %" PRIu32 "}",
                          comma(count++), sum->met[j].name, sum->met[i].name,
                          sum->together[i][j], sum->near[i][j]);
        }
    }
    (void)fputs("\n ]", out);
}

void coverage_print_json(const coverage *sum, FILE *out)
{
    (void)fputs(" \"rules\": {", out);
    for (unsigned i = 0; i < sum->rule_count; i++) {
        const struct coverage_rule *rule = &sum->rules[i];
        (void)fprintf(out,
                      "%s\n  \"%s\": {\"sessions\": %" PRIu64
                      ", \"cases\": %" PRIu64 ", \"broken\": %" PRIu64 "}",
                      comma(i), rule->name, rule->asked_in, rule->asked,
                      rule->broken_in);
    }
    (void)fputs("\n },\n \"met\": {", out);
    for (unsigned i = 0; i < sum->met_count; i++) {
        (void)fprintf(
            out,
            "%s\n  \"%s\": {\"sessions\": %" PRIu64 ", \"times\": %" PRIu64 "}",
            comma(i), sum->met[i].name, sum->met[i].met_in, sum->met[i].times);
    }
    (void)fputs("\n },\n", out);
    print_pairs_json(sum, out);
}
