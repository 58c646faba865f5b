/* Settings on their way to a sensor: what is sent, in which order, and what its
 * answers say of each. */
#ifndef LUMCTL_SETTINGS_PLAN_H
#define LUMCTL_SETTINGS_PLAN_H

#include "ctl.h"
#include "yscan/yscan_table.h"

#include "lum/config/settings.h"

#include <stdio.h>

/* One setting. */
struct plan_item {
    const char *setting;
    char value[YSCAN_TEXT_BYTES];
    char command[LUM_COMMAND_TEXT_BYTES + 1]; /* "table": the Y-scan table */
    bool was_answered;
    bool is_refused;
};

/* Settings in the order in which they are sent, and their results. */
struct settings_plan {
    const char *file; /* for messages */
    struct plan_item items[LUM_COMMANDS];
    size_t count;
    bool has_table;
    size_t table_at; /* its item */
    struct yscan_table table;
    bool has_answer;
    struct ctl_answer answer; /* the last */
    size_t refused;           /* items */
    bool has_unnamed; /* something was refused that no item is named by */
};

/* Fills in what these settings come to. Complains. */
enum exit_status plan_make(struct ctl *ctl, const char *file,
                           const lum_settings *from, struct settings_plan *out);

/* Sends them, or prints the packets of a dry run, and reads the answers: as
 * ctl_request(). */
enum exit_status plan_send(struct ctl *ctl, struct settings_plan *plan);

/* A row for each. */
void plan_print(FILE *out, const struct settings_plan *plan);

/* After plan_send(): EXIT_DONE, or EXIT_FAILED if anything was refused, with a
 * complaint of what. */
enum exit_status plan_judge(const struct settings_plan *plan);

#endif
