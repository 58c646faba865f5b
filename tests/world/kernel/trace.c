#include "trace.h"

#include "process.h"
#include "task.h"
#include "time.h"
#include "trace_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool world_traces;

static struct {
    uint64_t digest;
    char failure[1024];
    struct met {
        const char *name;
        uint64_t times;
        int64_t last_ns;
        bool is_near[WORLD_MET_MAX];
    } met[WORLD_MET_MAX];
    unsigned met_count;
} record;

static void tell_who(FILE *out)
{
    const world_task *task = world_task_self();
    const world_process *process =
        task != NULL ? world_task_process(task) : NULL;
    if (process != NULL) {
        (void)fprintf(out, "%s %s[%ld]: ", process->host->name, process->name,
                      process->pid);
    } else if (task != NULL) {
        (void)fputs("user: ", out);
    }
}

static void tell_time(FILE *out)
{
    (void)fprintf(out, "%+.6f ", (double)world_now() / 1e9);
}

void world_trace(const char *format, ...)
{
    va_list arguments;
    tell_time(stderr);
    tell_who(stderr);
    va_start(arguments, format);
    (void)vfprintf(stderr, format, arguments);
    va_end(arguments);
    (void)fputc('\n', stderr);
}

uint64_t world_digest(void)
{
    return record.digest;
}

void world_digest_add(uint64_t value)
{
    record.digest = (record.digest ^ value) * UINT64_C(0x9e3779b97f4a7c15);
    record.digest ^= record.digest >> 29;
}

/* Eight at a time: most of what is sent is data. */
void world_digest_bytes(const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    uint64_t word = size;
    world_digest_add(word);
    for (; size >= sizeof word; size -= sizeof word, at += sizeof word) {
        memcpy(&word, at, sizeof word);
        world_digest_add(word);
    }
    for (word = 0; size > 0; size--) {
        word = word << 8 | at[size - 1];
    }
    world_digest_add(word);
}

void world_fail(const char *format, ...)
{
    va_list arguments;
    if (record.failure[0] != '\0') {
        return; /* the first one is the cause */
    }
    const int used = snprintf(record.failure, sizeof record.failure,
                              "at %+.6f s: ", (double)world_now() / 1e9);
    va_start(arguments, format);
    (void)vsnprintf(record.failure + used, sizeof record.failure - (size_t)used,
                    format, arguments);
    va_end(arguments);
    WORLD_TRACE("FAILED: %s", record.failure);
}

const char *world_failure(void)
{
    return record.failure;
}

/* The place of a name; WORLD_MET_MAX: there is no room for it. */
static unsigned place_of(const char *name)
{
    unsigned i = 0;
    while (i < record.met_count && record.met[i].name != name &&
           strcmp(record.met[i].name, name) != 0) {
        i++;
    }
    if (i == record.met_count && i < WORLD_MET_MAX) {
        record.met[record.met_count++].name = name;
    }
    return i;
}

void world_met(const char *name)
{
    const unsigned i = place_of(name);
    if (i == WORLD_MET_MAX) {
        world_fail("more than %d names were met", WORLD_MET_MAX);
        return;
    }
    struct met *met = &record.met[i];
    met->times++;
    if (met->times > 1 && met->last_ns == world_now()) {
        return; /* what is near it was noted */
    }
    met->last_ns = world_now();
    for (unsigned j = 0; j < record.met_count; j++) {
        if (met->last_ns - record.met[j].last_ns <= WORLD_MET_NEAR_NS) {
            met->is_near[j] = true;
            record.met[j].is_near[i] = true;
        }
    }
}

unsigned world_met_count(void)
{
    return record.met_count;
}

const char *world_met_name(unsigned i)
{
    return record.met[i].name;
}

uint64_t world_met_times(unsigned i)
{
    return record.met[i].times;
}

bool world_met_near(unsigned i, unsigned j)
{
    return record.met[i].is_near[j];
}

void world_trace_reset(void)
{
    memset(&record, 0, sizeof record);
}
