#include "help.h"

#include <string.h>

void help_expect_value(user_place at, const user_tool *tool, const char *path,
                       const char *value)
{
    const char *got = user_value(user_out(tool), path);
    if (got == NULL || strcmp(got, value) != 0) {
        user_fail(at, "%s: %s is %s instead of %s", tool->command, path,
                  got == NULL ? "not there" : got, value);
    }
}

user_tool *ask_until(world_host *host, const char *command, const char *text)
{
    user_tool *tool = user_run(host, "%s", command);
    while (!user_has(user_out(tool), text)) {
        user_pause_ms(20);
        tool = user_run(host, "%s", command);
    }
    return tool;
}

user_tool *hold(const user_bench *bench)
{
    user_tool *session = user_start(bench->host, "lumctl heartbeat");
    user_until(user_has(user_err(session), "this is now the session"));
    user_until(*user_out(session) != '\0');
    return session;
}

user_tool *run_fed(world_host *host, const char *command, const char *text)
{
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *tool =
        user_start_with(host, (user_with){.input = end}, "%s", command);
    user_type(tool, input, text);
    world_writer_close(input);
    (void)user_wait(tool);
    return tool;
}

bool tells_changes_alone(const char *text)
{
    const char *before = NULL;
    size_t before_size = 0;
    while (*text != '\0') {
        const size_t size = strcspn(text, "\n");
        const size_t time = strcspn(text, " ");
        if (before != NULL && before_size == size - time &&
            memcmp(before, text + time, before_size) == 0) {
            return false;
        }
        before = text + time;
        before_size = size - time;
        text += size + (text[size] == '\n');
    }
    return true;
}
