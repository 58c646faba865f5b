/* What tellings met: rules that were asked, steps of users, faults, and pairs
 * of steps and faults. */
#ifndef WORLD_COVERAGE_H
#define WORLD_COVERAGE_H

#include "judges/verdict.h"
#include "kernel/trace.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define COVERAGE_NAME  32
#define COVERAGE_RULES 64
#define COVERAGE_WORDS ((WORLD_MET_MAX + 63) / 64)

/* Of one telling. */
typedef struct coverage_one {
    unsigned rule_count, met_count;
    struct {
        char name[COVERAGE_NAME];
        uint64_t asked;
        bool is_broken;
    } rules[COVERAGE_RULES];
    struct {
        char name[COVERAGE_NAME];
        uint64_t times;
        uint64_t near[COVERAGE_WORDS]; /* a bit for each that was met near it */
    } met[WORLD_MET_MAX];
} coverage_one;

/* Of many. */
typedef struct coverage {
    unsigned rule_count, met_count;
    struct coverage_rule {
        char name[COVERAGE_NAME];
        uint64_t asked;               /* cases */
        uint64_t asked_in, broken_in; /* tellings */
    } rules[COVERAGE_RULES];
    struct coverage_met {
        char name[COVERAGE_NAME];
        uint64_t times, met_in;
    } met[WORLD_MET_MAX];
    /* Tellings that met both; those that met them near each other. */
    uint32_t together[WORLD_MET_MAX][WORLD_MET_MAX];
    uint32_t near[WORLD_MET_MAX][WORLD_MET_MAX];
} coverage;

/* Of the telling that has just ended. */
void coverage_take(coverage_one *out, const struct verdict *verdict);

/* With the names of all that the dice can meet, so that it shows what they did
 * not. */
void coverage_begin(coverage *sum);
void coverage_add(coverage *sum, const coverage_one *one);

/* Tables for people; the short form of the pairs. */
void coverage_print(const coverage *sum, FILE *out);
/* All of it: members of a JSON object, without its brackets. */
void coverage_print_json(const coverage *sum, FILE *out);

#endif
