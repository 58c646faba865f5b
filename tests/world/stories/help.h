/* What stories of lumctl share. */
#ifndef STORIES_HELP_H
#define STORIES_HELP_H

#include "user.h"

/* Exit statuses of lumctl. */
enum {
    DONE,
    FAILED,
    BAD,
    NO_ANSWER,
    HAZARD
};

/* A value of the JSON that a tool printed; fails the story if it is another, or
 * not there. */
#define expect_value(TOOL, PATH, VALUE)                                        \
    help_expect_value(USER_HERE, TOOL, PATH, VALUE)
void help_expect_value(user_place at, const user_tool *tool, const char *path,
                       const char *value);

/* Asks again and again, until a text is in what is printed. */
user_tool *ask_until(world_host *host, const char *command, const char *text);

/* A session of the bench that holds the sensor: `lumctl heartbeat`. */
user_tool *hold(const user_bench *bench);

/* A tool to its end, with a text as its input. */
user_tool *run_fed(world_host *host, const char *command, const char *text);

/* Each line without the time before its first blank is another one than the
 * line before. */
bool tells_changes_alone(const char *text);

#endif
