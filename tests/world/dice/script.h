/* A script: what a user made of dice does, step by step. It can be read, told
 * in a world, and made smaller. */
#ifndef WORLD_SCRIPT_H
#define WORLD_SCRIPT_H

#include "../user.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define SCRIPT_STEPS 96
#define SCRIPT_TOOLS 48
#define SCRIPT_TEXT  176

typedef enum script_kind {
    SCRIPT_RUN,     /* text: the command; tool: its number here */
    SCRIPT_TYPE,    /* text, into a tool's input; "": its end */
    SCRIPT_SIGNAL,  /* number, to a tool */
    SCRIPT_STOP,    /* a tool, SIGSTOP, and SIGCONT at the end */
    SCRIPT_AT_CALL, /* number, to a tool, right before its n-th call of `call`;
                       SIGSTOP holds for value ms */
    SCRIPT_WIRE,    /* faults, of the bench's cable */
    SCRIPT_CUT,     /* one way of it, or both: nothing goes */
    SCRIPT_CABLE,   /* it is pulled */
    SCRIPT_ADDRESS, /* the bench loses its address */
    SCRIPT_DISK,    /* text: stall, slow, full, fail */
    SCRIPT_CLOCK,   /* the bench's calendar is set by value ms */
    SCRIPT_DRIFT,   /* its clocks are fast by value ppm */
    SCRIPT_SLOW,    /* its calls take value times as long */
    SCRIPT_SENSOR,  /* text: a fault of the sensor's own, as lumsim --fault */
    SCRIPT_POWER,   /* the sensor's is off */
    SCRIPT_PLAN,    /* text: steps of a sweep, into plan<n>.yaml */
    SCRIPT_BLACKOUT /* that of the bench is cut, value % of what was not
                       synced are kept */
} script_kind;

typedef enum script_way {
    SCRIPT_BOTH,
    SCRIPT_OUT, /* from the bench */
    SCRIPT_IN
} script_way;

typedef struct script_step {
    script_kind kind;
    unsigned place; /* from 1, as the dice drew it: --steps */
    int64_t at_ms, lasts_ms;
    unsigned tool;
    int number;
    unsigned n;
    int64_t value;
    script_way way;
    bool is_wrong;   /* has to be refused */
    bool is_stalled; /* its standard output is a pipe whose reader takes
                        value bytes a second, and goes after lasts_ms */
    bool is_far;     /* it runs on the other computer */
    bool ignores_int;
    user_faults faults;
    char text[SCRIPT_TEXT];
    char call[24]; /* "": it begins at its time. Else it waits from then on for
                      the n-th such call of its tool: SCRIPT_AT_CALL, and what
                      befalls network, disk and power */
} script_step;

struct script {
    uint64_t seed;
    int64_t ends_ms;
    char sensor[SCRIPT_TEXT]; /* options of lumsim */
    unsigned count;
    script_step steps[SCRIPT_STEPS]; /* in the order of their times */
};

/* Throws the dice. */
void script_draw(struct script *out, uint64_t seed);

void script_print(const struct script *script, FILE *out);

/* Tells it. */
user_result script_tell(const struct script *script);

/* In the last telling: "lumdump[1003]"; "": it was not started. */
const char *script_process(unsigned tool);

/* Leaves out all steps but those. */
void script_keep(struct script *script, const bool has[SCRIPT_STEPS + 1]);

/* Takes steps away as long as it fails. Returns how often that was asked. */
unsigned script_shrink(struct script *script,
                       bool (*fails)(const struct script *script,
                                     void *context),
                       void *context, unsigned tellings_max);

#endif
