/* What this host knows of a sensor's settings, because a sensor cannot be
 * asked: the last acknowledged ones, as a value and as the text of a state
 * file. */
#ifndef LUMCTL_MEMORY_H
#define LUMCTL_MEMORY_H

#include "lum/base/error.h"
#include "lum/command.h"
#include "lum/host/yscan_plan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MEMORY_TEXT_BYTES 8192 /* longest state file */
#define MEMORY_FROM_BYTES 512
#define MEMORY_NAME_BYTES 256 /* of an interface */

/* How sure a setting is. */
enum memory_standing {
    MEMORY_NOTHING, /* none is known */
    MEMORY_DONE,    /* the sensor acknowledged it */
    MEMORY_UNSURE,  /* it was sent, and no answer says whether it holds */
    MEMORY_OLD,     /* acknowledged, but a restart since could not be seen */
    MEMORY_STANDINGS
};
extern const char *const memory_standings[MEMORY_STANDINGS]; /* their words */

/* How the Y scan was set. */
enum memory_scan {
    MEMORY_DEGREES, /* by the command, whose value it has */
    MEMORY_SHAPE,   /* by a table that a shape made */
    MEMORY_TABLE,   /* by a table that no settings file can hold */
    MEMORY_SCANS
};

/* One setting. */
struct memory_entry {
    enum memory_standing standing;
    uint16_t value; /* of its command; of a table: its lines */
    int64_t utc_ns; /* when it was answered, or given up */
};

/* A Y-scan table and its source. */
struct memory_table {
    enum memory_scan scan;
    lum_yscan_shape shape;        /* MEMORY_SHAPE */
    char from[MEMORY_FROM_BYTES]; /* the file of a table, or the calibration
                                     that a shape was laid over; may be empty */
};

/* A reading of the sensor's clock against this host's calendar. */
struct memory_clock {
    bool is_known;
    int64_t utc_ns;
    uint32_t clock_us;
    int64_t error_ns;
};

/* A sensor, or the changes to one. */
struct memory {
    struct memory_entry entries[LUM_COMMANDS]; /* never the laser's */
    struct memory_table table;                 /* of the Y scan's entry */
    struct memory_clock clock;                 /* of its present run */
    int64_t restart_from_ns; /* a restart was seen: between these two times,  */
    int64_t restart_to_ns;   /* UTC; 0: none */
    int64_t begun_ns;        /* changes: before the first was sent, UTC */
    bool is_lines_set;       /* changes: a table from before has gone */
    bool is_unclear;         /* changes: something was sent that may have set
                                anything */
};

/* Takes a command that was sent. Commands of the laser are ignored, because the
 * sensor can be asked for its state. */
void memory_take(struct memory *memory, const lum_command *command,
                 enum memory_standing standing, int64_t utc_ns);

/* Takes a table that was sent. */
void memory_take_table(struct memory *memory, const struct memory_table *table,
                       uint16_t lines, enum memory_standing standing,
                       int64_t utc_ns);

/* Whether there is any setting, or a change. */
bool memory_has_any(const struct memory *memory);

/* Adds later changes to what is known. now_ns: UTC. What another command set
 * differently while these were under way becomes MEMORY_UNSURE: the sensor may
 * have taken either last. */
void memory_merge(struct memory *memory, const struct memory *changes,
                  int64_t now_ns);

/* What a sensor's clock says about a restart. */
enum memory_run {
    MEMORY_SAME_RUN,
    MEMORY_OTHER_RUN, /* it has restarted, or is another sensor; or the host's
                         clock was set */
    MEMORY_RUN_UNKNOWN
};

/* Compares two readings. *missed gets the chance, 0 to 1, that a restart in
 * between does not show, because the clock returns to 0 every 71.6 minutes and
 * both clocks drift; above MEMORY_MISSED_MAX the result is not known. */
#define MEMORY_MISSED_MAX 0.1
enum memory_run memory_compare(const struct memory_clock *before,
                               const struct memory_clock *now, double *missed);

/* Takes a reading, or that there was none (is_known false). After a restart all
 * settings are gone; if it is not known whether there was one, they become
 * MEMORY_OLD. */
enum memory_run memory_see_clock(struct memory *memory,
                                 const struct memory_clock *now,
                                 double *missed);

/* Who a state file is of. */
struct memory_key {
    uint32_t address;
    uint16_t port;
    char interface[MEMORY_NAME_BYTES]; /* empty: as the routes say */
};

/* Writes the text of a state file. Its length. */
size_t memory_write(const struct memory_key *key, const struct memory *memory,
                    char out[MEMORY_TEXT_BYTES]);

/* Reads one: 0, or -1 with the reason in error, out not to be used then. */
int memory_read(const char *text, const struct memory_key *key,
                struct memory *out, lum_error *error);

/* The value for people: "640" for lines 0, "15 degrees". */
struct memory_value {
    char text[64];
};
struct memory_value memory_value(const struct memory *memory,
                                 lum_command_id id);

#endif
