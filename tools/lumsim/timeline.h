/* Faults of the sensor at given times or signals: hazards, a reboot,
 * silence. */
#ifndef LUMSIM_TIMELINE_H
#define LUMSIM_TIMELINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TIMELINE_MAX 64

/* Signals that let a fault begin or end. */
enum cue {
    CUE_NONE,
    CUE_USR1,
    CUE_USR2
};

enum fault_kind {
    FAULT_HAZARD,
    FAULT_REBOOT,
    FAULT_SILENCE
};

struct timeline_event {
    int64_t at_ns; /* after the start; INT64_MAX: at a signal to come */
    enum cue cue;  /* that signal */
    const char *name;
    enum fault_kind kind;
    uint16_t bits; /* of a hazard */
    bool ends;     /* it goes away again */
};

/* In order of time. */
struct timeline {
    struct timeline_event events[TIMELINE_MAX];
    size_t count;
    size_t next; /* the first that has not happened */
};

/* Add the fault NAME@T[s][-T2[s]] or NAME@USR1[-USR2]. False if the text is
 * wrong; *why then says what would be right. */
bool timeline_add(struct timeline *timeline, const char *text,
                  const char **why);

/* When the next one happens, after the start; INT64_MAX: never. */
int64_t timeline_next_ns(const struct timeline *timeline);

/* Whether something waits for a signal. */
bool timeline_awaits(const struct timeline *timeline, enum cue cue);

/* The signal came: what waits for it happens now. */
void timeline_cue(struct timeline *timeline, enum cue cue, int64_t now_ns);

/* The next one that has happened by then, or NULL. */
const struct timeline_event *timeline_take(struct timeline *timeline,
                                           int64_t now_ns);

/* Note the signal from now on, instead of dying of it. */
void cue_catch(enum cue cue);

/* Whether it came since the last time. */
bool cue_take(enum cue cue);

#endif
