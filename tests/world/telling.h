/* A telling: a story, or what the dice make up, under a seed; and what came of
 * it, as processes of this program hand it on. */
#ifndef WORLD_TELLING_H
#define WORLD_TELLING_H

#include "coverage.h"
#include "user.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct telling {
    uint64_t index; /* from 0 */
    char rule[48];  /* that was broken first, or what else went wrong; "" */
    user_result result;
    int64_t cpu_ns;
    uint64_t programs; /* that its user started */
    coverage_one met;
} telling;

/* What is to be told: all stories, or one (story), or the dice; each under the
 * first seed, then under the next one. */
typedef struct telling_plan {
    const user_story *story;
    uint64_t first_seed;
    bool is_dice;
    bool is_twice; /* and has to be the same */
} telling_plan;

extern telling_plan telling_of;

/* Tellings of one seed. */
uint64_t telling_each(void);
uint64_t telling_seed(uint64_t index);
/* The options that tell it again: "--dice --seed 7". */
void telling_name(uint64_t index, char *out, size_t room);

/* Here, in this process. */
void telling_run(uint64_t index, telling *out);

/* Processes side by side, which tell what is planned in turns. Any of them may
 * die by what it tells. */
void tellings_begin(unsigned processes);
/* The results come in the order of the indexes, whoever tells them. */
void tellings_next(telling *out);
void tellings_end(void);

/* A process of its own runs it and ends; its wait status. */
int telling_apart(void (*run)(void *argument), void *argument);

#endif
