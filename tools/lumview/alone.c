/* What the feed has on a system without threads, in place of thread.c and
 * link.c: only captures that are files. */
#include "link.h"
#include "thread.h"

struct gate {
    char nobody_else;
};

/* --- Threads --- */

bool thread_exists(void)
{
    return false;
}

int thread_start(struct thread **out, void *(*run)(void *), void *argument,
                 lum_error *error)
{
    (void)run;
    (void)argument;
    *out = NULL;
    return lum_error_set(error, "there are no threads here");
}

void thread_join(struct thread *thread)
{
    (void)thread;
}

/* --- Gates --- */

struct gate *gate_new(void)
{
    static struct gate gate;
    return &gate;
}

void gate_free(struct gate *gate)
{
    (void)gate;
}

void gate_take(struct gate *gate)
{
    (void)gate;
}

void gate_leave(struct gate *gate)
{
    (void)gate;
}

bool gate_wait(struct gate *gate, int64_t wait_ns)
{
    (void)gate;
    (void)wait_ns;
    return false;
}

void gate_tell(struct gate *gate)
{
    (void)gate;
}

/* --- A source that needs threads --- */

int link_start(const struct link_options *options, struct link **out,
               lum_error *error)
{
    (void)options;
    *out = NULL;
    return lum_error_set(error, "a sensor cannot be reached from here");
}

int link_end(struct link *link, lum_error *error)
{
    (void)link;
    (void)error;
    return 0;
}
