/* What the folder of a sweep says, held against what the sensors did and what
 * the network brought. A story has one plan in one folder. */
#ifndef STORIES_SWEEP_JUDGE_H
#define STORIES_SWEEP_JUDGE_H

#include "user.h"

#define SWEEP_STEPS    8
#define SWEEP_SETTINGS 9 /* as sweep_letters */

/* The letters of commands, and 'T' for a Y-scan table. */
extern const char sweep_letters[SWEEP_SETTINGS + 1];

/* A step of the plan. in_force: what it and the steps before it have set, as a
 * sensor notes it: "40p"; "" is nothing, "T" any table. */
typedef struct sweep_plan_step {
    char in_force[SWEEP_SETTINGS][8];
    bool records;
} sweep_plan_step;

typedef struct sweep_plan {
    unsigned count;
    sweep_plan_step steps[SWEEP_STEPS];
} sweep_plan;

/* Begins to look at the network and the disk of a bench. */
void sweep_judge_begin(const user_bench *bench, const char *folder,
                       const sweep_plan *plan, bool has_laser);

/* A sensor that was switched on. */
void sweep_judge_sensor(const user_sensor *sensor);

/* A run of the program is about to begin, and has ended. had_disk_fault: what
 * it could not write is no fault of its own. */
void sweep_judge_start(void);
void sweep_judge_run(user_tool *tool, bool had_disk_fault);

/* The sensor of the manifest; NULL: there is none. */
const char *sweep_judge_address(void);

/* How many steps the manifest says are done. */
unsigned sweep_judge_done(void);

/* The laser of no sensor is on later than 3.2 s after a moment: waits. */
void sweep_judge_dark(int64_t since_ns);

#endif
