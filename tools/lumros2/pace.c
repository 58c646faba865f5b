#include "pace.h"

/* 30 days: a time that is further away is that of a wrong clock. */
#define NS_MAX UINT64_C(2592000000000000)

void pace_begin(struct pace *pace, double rate, int64_t host_ns)
{
    *pace = (struct pace){.rate = rate, .host_ns = host_ns};
}

int64_t pace_due(struct pace *pace, uint64_t log_ns)
{
    if (!pace->has_begun || log_ns < pace->log_ns ||
        log_ns - pace->log_ns > NS_MAX) {
        pace->has_begun = true;
        pace->host_ns +=
            (int64_t)((double)(pace->last_ns - pace->log_ns) / pace->rate);
        pace->log_ns = log_ns;
        pace->last_ns = log_ns;
    }
    if (log_ns > pace->last_ns) {
        pace->last_ns = log_ns;
    }
    return pace->host_ns +
           (int64_t)((double)(log_ns - pace->log_ns) / pace->rate);
}
