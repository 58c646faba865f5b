/* What the files of user.h share. */
#ifndef WORLD_USER_INTERNAL_H
#define WORLD_USER_INTERNAL_H

#include "kernel/file.h"
#include "kernel/task.h"
#include "user.h"

#define USER_HOME "/home"

/* Memory until the end of the telling, zeroed. */
void *user_keep(size_t bytes);
char *user_keep_text(const char *text, size_t size);

/* A text that grows, with a 0 behind it. */
typedef struct user_text {
    char *bytes;
    size_t size, room;
    struct user_text *next;
} user_text;
user_text *user_text_new(void);
void user_text_add(user_text *text, const void *bytes, size_t size);

/* Something that a story can see has changed. */
void user_has_changed(void);

/* The moment at which the story has failed. */
int64_t user_limit_ns(void);

/* Waits on a queue until something is true; fails the story at its limit. */
void user_wait_on(world_queue *queue, const char *what);

/* A step of the story, for the log. */
__attribute__((format(printf, 1, 2))) void user_trace(const char *format, ...);

/* The words of a command line, NULL-terminated; 0 words: NULL. */
const char **user_words(const char *line, size_t *count);

/* A file that keeps what is written to it, and tells of each whole line. */
world_file *user_kept_file(user_text *text,
                           void (*line)(void *argument, const char *line),
                           void *argument);

/* Starts a tool by its command line, and enters it into the list. */
user_tool *user_tool_begin(world_start *start, const char *command);

/* What tools are started with, if nothing else is said. */
extern const char *const user_environment[];

/* The last lines that tools said, for a story that has failed. */
void user_tell_tools(char *out, size_t room);

/* Called at each call of a process, before it is done. */
void user_tool_calls(world_process *process, const char *name);

void user_tool_reset(void);
void user_text_reset(void);
void user_bench_reset(void);

#endif
