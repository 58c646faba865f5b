/* What happened, for people and for judges. */
#ifndef WORLD_TRACE_H
#define WORLD_TRACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A line of the log, as printf: "+12.345678 bench lumctl[3]: ...", where host
 * and process are those of the task that runs. It costs nothing while the trace
 * is off. It must depend on the seed alone: no pointers. */
#define WORLD_TRACE(...)                                                       \
    do {                                                                       \
        if (world_traces) {                                                    \
            world_trace(__VA_ARGS__);                                          \
        }                                                                      \
    } while (0)
extern bool world_traces; /* whether the log goes to stderr */
__attribute__((format(printf, 1, 2))) void world_trace(const char *format, ...);

/* Of all that was decided until now: who ran when, and what the functions below
 * were told: the fates of datagrams, and the bytes that programs send and
 * write. Two runs of a seed give the same. */
uint64_t world_digest(void);
void world_digest_add(uint64_t value);
void world_digest_bytes(const void *bytes, size_t size);

/* A rule was broken, or the world itself was used wrongly: told with the time,
 * then the run ends as failed. */
__attribute__((format(printf, 1, 2))) void world_fail(const char *format, ...);

/* Something that the run met: a step of its user, a fault that happened. Names
 * are short and fixed ("step:cut", "fault:lose"); a run's set of them, and
 * pairs of it, are the coverage. */
#define WORLD_MET_MAX 128 /* names of one run */
void world_met(const char *name);
unsigned world_met_count(void);
const char *world_met_name(unsigned i);
uint64_t world_met_times(unsigned i);
/* Whether both were met within so much time. */
#define WORLD_MET_NEAR_NS (5 * INT64_C(1000000000))
bool world_met_near(unsigned i, unsigned j);

/* The first failure of this run; "" for none. */
const char *world_failure(void);

#endif
