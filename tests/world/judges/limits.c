/* No tool runs beyond its own limits. All of them in the tool's own time: stops
 * do not count. */
#include "limits.h"

#include "judge.h"

#include <stdlib.h>
#include <string.h>

static const char alone[] = "limit";
static const char told[] = "limit-after-signal";

/* `laser off`: the command for 10 s (docs/man/lumctl.1, laser off); in each of
 * its two parts, 3 s and 7 s, a look that began before the end may still take
 * 0.3 s and the 2 s of the second look (docs/safety.md, "What turns it off").
 */
#define OFF_NS (14600 * RECORD_MS)

/* A signal is followed by ticks that end a process after 3 s which does not end
 * by itself (tools/common/interrupt.h). */
#define TOLD_NS (3050 * RECORD_MS)

/* Without data a recording ends (docs/man/lumdump.1, A SENSOR). */
#define FIRST_DATA_NS (5 * RECORD_S)
/* What waits in the kernel at the end. */
#define DRAIN_NS (500 * RECORD_MS)
/* Outputs that make no progress at the end: a pipe after 3 s or, if it is slow,
 * a minute, a file after 30 s (docs/man/lumdump.1, A SENSOR). */
#define OUTPUT_NS (60 * RECORD_S)

/* A dropped recording and the manifest of a sweep, or the last lines of
 * --every, 3 s each (tools/lumctl/sweep_run.c, file_writer.c). */
#define FILES_NS (6 * RECORD_S)

/* doctor: each of its checks waits for some answers, two seconds for data
 * (docs/troubleshooting.md: a run takes a few seconds; docs/man/lumctl.1: up
 * to five on a busy host for the trace). */
#define DOCTOR_NS (40 * RECORD_S)

static int64_t seconds(double s)
{
    return (int64_t)(s * 1e9);
}

static int64_t longer(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/* All tries of a request, and the look for late answers that ends it
 * (docs/man/lumctl.1, --timeout, --retries). */
static int64_t request_ns(const record_tool *tool)
{
    const double timeout_ms = record_number(tool, "--timeout", 400);
    const double retries = record_number(tool, "--retries", 4);
    return seconds((retries + 2.0) * timeout_ms * 1e-3);
}

/* Five seconds, or all tries if that is longer (docs/man/lumctl.1, set-ip), but
 * at least seven rounds of looks at both addresses of 1.2 s; before that a look
 * for other devices, and behind it the last looks at the old address and the
 * reversed one. */
static int64_t set_ip_ns(const record_tool *tool)
{
    return longer(longer(request_ns(tool), 5 * RECORD_S), 8400 * RECORD_MS) +
           6 * RECORD_S;
}

/* 256 addresses a second (docs/man/lumctl.1, find), all tries of them. */
static int64_t find_ns(const record_tool *tool)
{
    const char *subnet = record_option(tool, "--subnet");
    const char *slash = subnet != NULL ? strchr(subnet, '/') : NULL;
    const long bits = slash != NULL ? strtol(slash + 1, NULL, 10) : 22;
    const double addresses = (double)(1u << (unsigned)(32 - bits));
    const double retries = record_number(tool, "--retries", 4);
    return request_ns(tool) + seconds((retries + 1.0) * addresses / 256.0) +
           3 * RECORD_S;
}

/* What it set is remembered under a lock: another lumctl of the host that is
 * stopped there is waited for (tools/lumctl/remember.c). */
#define LOCK_NS (10 * RECORD_S)

int64_t limits_of_lock(const struct record *record, const record_tool *tool)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *other = &record->tools[i];
        if (other != tool && other->host == tool->host &&
            record_is_program(other, "lumctl") &&
            record_is_program(tool, "lumctl") &&
            record_stopped_ns(other, tool->began_ns, tool->ended_ns) > 0) {
            return LOCK_NS;
        }
    }
    return 0;
}

static bool is_word(const record_tool *tool, const char *word)
{
    return strcmp(record_word(tool, 0), word) == 0;
}

static int64_t duration_ns(const record_tool *tool, const char *option)
{
    const double s = record_number(tool, option, 0.0);
    return s > 0.0 ? seconds(s) : RECORD_NEVER;
}

static int64_t end_ns(const record_tool *tool)
{
    return record_option(tool, "--laser") != NULL ? OFF_NS : 0;
}

/* What waits for its files at the end. */
static int64_t files_ns(const record_tool *tool)
{
    return is_word(tool, "sweep") || record_option(tool, "--every") != NULL
               ? FILES_NS
               : 0;
}

static bool is_about_laser(const record_tool *tool)
{
    return is_word(tool, "laser") || is_word(tool, "send");
}

int64_t limits_of_lumctl(const record_tool *tool)
{
    if (is_word(tool, "shell") || is_word(tool, "sweep")) {
        return RECORD_NEVER;
    }
    if (is_word(tool, "heartbeat") || record_watches(tool)) {
        const int64_t lasts_ns = duration_ns(tool, "--duration");
        return lasts_ns != RECORD_NEVER
                   ? lasts_ns + end_ns(tool) + files_ns(tool)
                   : RECORD_NEVER;
    }
    if (is_word(tool, "wait")) {
        return duration_ns(tool, "--for");
    }
    if (is_about_laser(tool)) {
        return request_ns(tool) + OFF_NS;
    }
    if (is_word(tool, "set-ip")) {
        return set_ip_ns(tool);
    }
    if (is_word(tool, "find")) {
        return find_ns(tool);
    }
    if (is_word(tool, "doctor")) {
        return DOCTOR_NS;
    }
    /* Eight exchanges of time stamps, 10 ms apart. */
    return is_word(tool, "time") ? 8 * (request_ns(tool) + 10 * RECORD_MS)
                                 : request_ns(tool);
}

/* When the first data was read; RECORD_NEVER: none. */
static int64_t first_data_ns(const struct record *record, int index)
{
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->reader == index && d->fate == RECORD_READ &&
            d->packet == RECORD_IS_DATA) {
            return d->fate_ns;
        }
    }
    return RECORD_NEVER;
}

static int64_t session_ns(const struct record *record, int index)
{
    const record_tool *tool = &record->tools[index];
    const int64_t data_ns = first_data_ns(record, index);
    const int64_t lasts_ns = duration_ns(tool, "--duration");
    if (data_ns == RECORD_NEVER) {
        return FIRST_DATA_NS + end_ns(tool);
    }
    return lasts_ns == RECORD_NEVER
               ? RECORD_NEVER
               : data_ns - tool->began_ns + lasts_ns + DRAIN_NS + end_ns(tool);
}

static int64_t alone_ns(const struct record *record, int index)
{
    const record_tool *tool = &record->tools[index];
    if (record_is_program(tool, "lumctl")) {
        return limits_of_lumctl(tool);
    }
    return record_is_program(tool, "lumdump") ? session_ns(record, index)
                                              : duration_ns(tool, "--duration");
}

/* A shell first ends the command that it is at, which may take a laser on back,
 * and then switches the laser off itself. */
static int64_t told_ns(const record_tool *tool)
{
    if (is_word(tool, "shell")) {
        return request_ns(tool) + 2 * OFF_NS;
    }
    if (record_is_program(tool, "lumctl")) {
        return is_about_laser(tool) ? request_ns(tool) + OFF_NS
                                    : TOLD_NS + end_ns(tool) + files_ns(tool) +
                                          (tool->has_stalled ? OUTPUT_NS : 0);
    }
    if (record_owns(tool)) {
        return DRAIN_NS + end_ns(tool) + (tool->has_stalled ? OUTPUT_NS : 0);
    }
    return TOLD_NS;
}

int64_t limits_with_grace(int64_t limit_ns)
{
    return limit_ns + limit_ns / 100 + LIMITS_GRACE_NS;
}

static void check(const struct record *record, const record_tool *tool,
                  const char *rule, int64_t from_ns, int64_t limit_ns,
                  struct verdict *out)
{
    const int64_t until_ns =
        tool->ended_ns != RECORD_NEVER ? tool->ended_ns : record->now_ns;
    verdict_asked(out, rule);
    const int64_t took_ns =
        until_ns - from_ns - record_stopped_ns(tool, from_ns, until_ns);
    if (took_ns > limits_with_grace(limit_ns)) {
        verdict_broken(
            out, rule, until_ns,
            "%s %s %s [%ld] %s %.3f s%s; its limit is %.3f s",
            tool->arguments[0], record_word(tool, 0), record_word(tool, 1),
            tool->id, tool->ended_ns != RECORD_NEVER ? "took" : "has run for",
            (double)took_ns * 1e-9, rule == told ? " after a signal" : "",
            (double)limit_ns * 1e-9);
    }
}

void judge_limits(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        const int64_t asked_ns = record_asked_to_end(tool);
        const int64_t limit_ns = alone_ns(record, (int)i);
        /* A recording waits for its disk as long as that takes; what prints
         * into a pipe that nobody reads waits too. */
        if (limit_ns != RECORD_NEVER && !tool->has_stalled) {
            check(record, tool, alone, tool->began_ns,
                  limit_ns + limits_of_lock(record, tool), out);
        }
        if (asked_ns != RECORD_NEVER &&
            (!tool->has_stalled || record_owns(tool))) {
            check(record, tool, told, asked_ns,
                  told_ns(tool) + limits_of_lock(record, tool), out);
        }
    }
}
