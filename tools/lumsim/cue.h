/* Signals that let a fault begin or end. */
#ifndef LUMSIM_CUE_H
#define LUMSIM_CUE_H

#include <stdbool.h>

enum cue {
    CUE_NONE,
    CUE_USR1,
    CUE_USR2
};

/* Whether this system has such signals. */
bool cue_is_possible(void);

/* Note the signal from now on, instead of dying of it. */
void cue_catch(enum cue cue);

/* Whether it came since the last time. */
bool cue_take(enum cue cue);

#endif
