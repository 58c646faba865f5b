/* What the feed has on a system without threads, in place of thread_monitor.c
 * and sensor_link.c: only captures that are files. */
#include "sensor_link.h"
#include "thread_monitor.h"

struct monitor {
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

/* --- Monitors --- */

struct monitor *monitor_new(void)
{
    static struct monitor monitor;
    return &monitor;
}

void monitor_free(struct monitor *monitor)
{
    (void)monitor;
}

void monitor_lock(struct monitor *monitor)
{
    (void)monitor;
}

void monitor_unlock(struct monitor *monitor)
{
    (void)monitor;
}

bool monitor_wait(struct monitor *monitor, int64_t wait_ns)
{
    (void)monitor;
    (void)wait_ns;
    return false;
}

void monitor_notify(struct monitor *monitor)
{
    (void)monitor;
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
