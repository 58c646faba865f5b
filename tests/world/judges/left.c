/* A run leaves its outputs, and nothing else (docs/man/lumdump.1, FILES). */
#include "judge.h"

#include <string.h>

static const char left[] = "file-left";
static const char there[] = "file-there";

/* What an output's names begin with: "f1" of "f1.csv". */
static size_t stem_of(const char *output)
{
    const char *dot = strrchr(output, '.');
    return dot != NULL ? (size_t)(dot - output) : strlen(output);
}

/* "f1.csv.0123.part", "f1-0001.csv" and ".f1.csv.lumsdk" are of f1.csv. */
static bool is_of(const char *name, const char *output)
{
    const size_t len = stem_of(output);
    name += name[0] == '.' ? 1 : 0;
    return strncmp(name, output, len) == 0 &&
           (name[len] == '.' || name[len] == '-');
}

static bool is_under_way(const char *name)
{
    const size_t len = strlen(name);
    return (len > 5 && strcmp(name + len - 5, ".part") == 0) ||
           (len > 7 && strcmp(name + len - 7, ".lumsdk") == 0);
}

/* It had the time to tidy up: neither killed, nor given up for a disk, nor told
 * twice to end, or once at its own end, which gives outputs up
 * (docs/man/lumdump.1, A SENSOR). */
static bool has_tidied(const record_tool *tool)
{
    return record_exit_status(tool) >= 0 && !tool->was_cut &&
           !tool->has_stalled && tool->signal_count < 2 &&
           (tool->err == NULL || strstr(tool->err, "is given up") == NULL);
}

static const char *next_output(const record_tool *tool, unsigned *at)
{
    for (; *at + 1 < tool->count; (*at)++) {
        if (strcmp(tool->arguments[*at], "-o") == 0 &&
            strcmp(tool->arguments[*at + 1], "-") != 0) {
            *at += 2;
            return tool->arguments[*at - 1];
        }
    }
    return NULL;
}

static void judge_name(const struct record *record, unsigned host,
                       const char *name, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        const char *output = NULL;
        unsigned at = 1;
        while (tool->host == host &&
               (output = next_output(tool, &at)) != NULL) {
            if (is_of(name, output) && has_tidied(tool)) {
                verdict_broken(out, left, tool->ended_ns,
                               "%s [%ld] ended with %d and left %s",
                               tool->arguments[0], tool->id,
                               record_exit_status(tool), name);
            }
        }
    }
}

static bool is_there(const char *const *names, const char *output)
{
    for (; *names != NULL; names++) {
        if (strcmp(*names, output) == 0) {
            return true;
        }
    }
    return false;
}

/* A recording that is done has all its outputs; those that rotate have other
 * names. */
static void judge_there(const record_tool *tool, const char *const *names,
                        struct verdict *out)
{
    const char *output = NULL;
    unsigned at = 1;
    if (!record_is_program(tool, "lumdump") || record_exit_status(tool) != 0 ||
        record_option(tool, "--rotate") != NULL) {
        return;
    }
    while ((output = next_output(tool, &at)) != NULL) {
        if (strchr(output, '%') != NULL) {
            continue; /* a file for each frame */
        }
        verdict_asked(out, there);
        if (!is_there(names, output)) {
            verdict_broken(out, there, tool->ended_ns,
                           "lumdump [%ld] ended with 0, and there is no %s",
                           tool->id, output);
        }
    }
}

void judge_left(const struct record *record, unsigned host,
                const char *const *names, struct verdict *out)
{
    verdict_asked(out, left);
    for (const char *const *n = names; *n != NULL; n++) {
        if (is_under_way(*n)) {
            judge_name(record, host, *n, out);
        }
    }
    for (size_t i = 0; i < record->tool_count; i++) {
        if (record->tools[i].host == host) {
            judge_there(&record->tools[i], names, out);
        }
    }
}
