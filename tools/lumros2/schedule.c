#include "schedule.h"

/* 30 days: a time that is further away is that of a wrong clock. */
#define NS_MAX UINT64_C(2592000000000000)

void schedule_begin(struct schedule *schedule, double rate, int64_t host_ns)
{
    *schedule = (struct schedule){.rate = rate, .host_ns = host_ns};
}

int64_t schedule_due(struct schedule *schedule, uint64_t log_ns)
{
    if (!schedule->has_begun || log_ns < schedule->log_ns ||
        log_ns - schedule->log_ns > NS_MAX) {
        schedule->has_begun = true;
        schedule->host_ns +=
            (int64_t)((double)(schedule->last_ns - schedule->log_ns) /
                      schedule->rate);
        schedule->log_ns = log_ns;
        schedule->last_ns = log_ns;
    }
    if (log_ns > schedule->last_ns) {
        schedule->last_ns = log_ns;
    }
    return schedule->host_ns +
           (int64_t)((double)(log_ns - schedule->log_ns) / schedule->rate);
}
