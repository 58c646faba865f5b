/* The counts of lines and points are those of the datagrams that came. */
#include "cloud.h"
#include "judge.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char counted[] = "counts-of-lines";
static const char written[] = "points-written";

/* Whether nothing but the datagrams decides what its points are. */
static bool is_plain(const record_tool *tool)
{
    static const char *const options[] = {
        "--eye",     "--edge",       "--return",      "--frames",  "--range",
        "--box",     "--incomplete", "--calibration", "--profile", "--set",
        "--columns", "--organized",  "--smooth",      "--sensor",  "--rotate"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        if (record_option(tool, options[i]) != NULL) {
            return false;
        }
    }
    return true;
}

/* The datagrams that its summary is of. */
static bool find_cloud(const record_tool *tool, struct cloud *out)
{
    uint64_t received = 0;
    uint64_t dropped = 0;
    return record_is_program(tool, "lumdump") && record_owns(tool) &&
           is_plain(tool) && tool->ended_ns != RECORD_NEVER &&
           record_json_number(tool->out, "received", &received) &&
           record_json_number(tool->out, "ring_drops", &dropped) &&
           dropped == 0 && cloud_of(tool, received, out);
}

static void judge_counts_of(const record_tool *tool, const struct cloud *c,
                            struct verdict *out)
{
    const struct {
        const char *key;
        uint64_t value;
    } counts[] = {{"data", c->data},
                  {"angle_packets", c->angle_packets},
                  {"range_packets", c->range_packets},
                  {"frames", c->frames},
                  {"lines", c->lines},
                  {"words", c->words},
                  {"points", c->points},
                  {"lost_words", c->lost_words},
                  {"lines_missing_angles", c->missing_angles},
                  {"lines_skipped", c->skipped},
                  {"no_angle", c->no_angle},
                  {"no_range", c->no_range},
                  {"bad_words", c->bad_words},
                  {"late", c->late},
                  {"duplicate", c->duplicate},
                  {"conflict", c->conflict},
                  {"stray", c->stray},
                  {"malformed", c->malformed}};
    const char *sensor = strstr(tool->out, "\"sensors\":");
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        uint64_t said = 0;
        if (!record_json_number(sensor, counts[i].key, &said)) {
            continue;
        }
        verdict_asked(out, counted);
        if (said != counts[i].value) {
            verdict_broken(out, counted, tool->ended_ns,
                           "lumdump [%ld] says %s: %llu, and what it read has "
                           "%llu",
                           tool->id, counts[i].key, (unsigned long long)said,
                           (unsigned long long)counts[i].value);
            return;
        }
    }
}

void judge_points(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        struct cloud c;
        const record_tool *tool = &record->tools[i];
        const char *sensor =
            tool->out != NULL ? strstr(tool->out, "\"sensors\":") : NULL;
        if (sensor != NULL && find_cloud(tool, &c)) {
            judge_counts_of(tool, &c, out);
        }
    }
}

/* --- What is written --- */

/* An output that took all that the summary is of. */
static bool is_complete(const record_tool *tool, const char *name)
{
    char key[300];
    uint64_t dropped = 1;
    (void)snprintf(key, sizeof key, "{\"name\": \"%s\", \"end\": \"done\"",
                   name);
    const char *at = tool->out != NULL ? strstr(tool->out, key) : NULL;
    return at != NULL && record_json_number(at, "dropped", &dropped) &&
           dropped == 0;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t len = strlen(text);
    return len > strlen(end) && strcmp(text + len - strlen(end), end) == 0;
}

/* How many columns stand before that of the ranges. */
static unsigned column_of_ranges(const char *at, const char *end)
{
    unsigned column = 0;
    for (const char *p = at; p < end && strncmp(p, "range,", 6) != 0; p++) {
        column += *p == ',' ? 1 : 0;
    }
    return column;
}

static double range_of(const char *row, unsigned column)
{
    for (unsigned i = 0; i < column && row != NULL; i++) {
        row = strchr(row, ',');
        row = row != NULL ? row + 1 : NULL;
    }
    return row != NULL ? strtod(row, NULL) : 0;
}

/* Rows of a table, and the sum of its ranges; the first line has the names. */
static uint64_t read_csv(const judge_file *file, double *range_m)
{
    const char *at = (const char *)file->bytes;
    const char *end = at + file->size;
    const char *line = memchr(at, '\n', file->size);
    const unsigned column = line != NULL ? column_of_ranges(at, line) : 0;
    uint64_t rows = 0;
    *range_m = 0;
    for (; line != NULL && line + 1 < end; rows++) {
        *range_m += range_of(line + 1, column);
        line = memchr(line + 1, '\n', (size_t)(end - line - 1));
    }
    return rows;
}

static uint64_t read_ply(const judge_file *file)
{
    static const char vertex[] = "element vertex ";
    const char *at = strstr((const char *)file->bytes, vertex);
    return at != NULL ? strtoull(at + sizeof vertex - 1, NULL, 10) : 0;
}

void judge_cloud(const struct record *record, size_t writer,
                 const judge_file *file, struct verdict *out)
{
    struct cloud c;
    const record_tool *tool = &record->tools[writer];
    const bool is_csv = ends_with(file->name, ".csv");
    double range_m = 0;
    if ((!is_csv && !ends_with(file->name, ".ply")) || file->size == 0 ||
        !is_complete(tool, file->name) || !find_cloud(tool, &c)) {
        return;
    }
    const uint64_t points = is_csv ? read_csv(file, &range_m) : read_ply(file);
    verdict_asked(out, written);
    if (points != c.points || (is_csv && fabs(range_m - c.range_m) >
                                             0.001 * (double)(c.points + 1))) {
        verdict_broken(out, written, file->t_ns,
                       "%s has %llu points of %.3f m in all, and what came has "
                       "%llu of %.3f m",
                       file->name, (unsigned long long)points, range_m,
                       (unsigned long long)c.points, c.range_m);
    }
}
