/* The lines that are typed into a shell, each as a command of its own. */
#ifndef WORLD_SHELL_H
#define WORLD_SHELL_H

#include "record.h"

#define SHELL_LINES 64
#define SHELL_BYTES 200

typedef enum shell_kind {
    SHELL_SETTING, /* words or raw text, without the laser */
    SHELL_LASER,   /* raw text with u or d, laser on, laser off */
    SHELL_STATUS,
    SHELL_MOVE,
    SHELL_TIME,
    SHELL_OTHER /* what it reports is not known here */
} shell_kind;

/* As a tool it began when the line before was over and it was typed, and ended
 * when it was reported as done, or at its limit. */
typedef struct shell_line {
    record_tool as; /* its status is 0 if it was reported as done, else 1 */
    shell_kind kind;
    int64_t typed_ns;
    int64_t due_ns; /* its limit, at which a shell that lives has ended it */
    bool is_done;
    char words[SHELL_BYTES];
} shell_line;

/* What is typed into one shell. */
struct shell {
    const record_tool *tool;
    size_t count;
    unsigned unclaimed; /* reports of what nobody typed */
    bool is_full;
    shell_line lines[SHELL_LINES];
};

bool shell_is_one(const record_tool *tool);
void shell_read(const struct record *record, const record_tool *tool,
                struct shell *out);
void shell_free(struct shell *shell);

#endif
