#include "host.h"

#include "host_internal.h"
#include "time.h"
#include "trace.h"

#include <stdio.h>
#include <stdlib.h>

#define PPB 1000000000

/* 2026-01-01 00:00:00 UTC; the monotonic clock begins after some days of
 * running. */
#define UTC_AT_START INT64_C(1767225600000000000)

static world_host *hosts;

world_host *world_host_first(void)
{
    return hosts;
}

world_host *world_host_new(const char *name)
{
    world_host *host = calloc(1, sizeof *host);
    world_host **last = &hosts;
    if (host == NULL) {
        abort();
    }
    (void)snprintf(host->name, sizeof host->name, "%s", name);
    host->mono_start_ns = 200000 * WORLD_S;
    host->utc_offset_ns = UTC_AT_START - host->mono_start_ns;
    host->slowness = 1;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = host;
    return host;
}

/* Parts of a second apart, so that years of ns times ppb do not overflow. */
static int64_t scaled(int64_t ns, int64_t ppb)
{
    return ns / PPB * ppb + ns % PPB * ppb / PPB;
}

int64_t world_host_mono_ns(const world_host *host)
{
    const int64_t now = world_now();
    return host->mono_start_ns + now + scaled(now, host->drift_ppb);
}

int64_t world_host_utc_ns(const world_host *host)
{
    return world_host_mono_ns(host) + host->utc_offset_ns;
}

/* The inverse by a first guess and corrections: the drift is small. */
int64_t world_host_true_ns(const world_host *host, int64_t mono_ns)
{
    const int64_t since = mono_ns - host->mono_start_ns;
    int64_t guess = since;
    for (int i = 0; i < 3; i++) {
        guess += since - (guess + scaled(guess, host->drift_ppb));
    }
    while (guess + scaled(guess, host->drift_ppb) < since) {
        guess++;
    }
    return guess;
}

void world_host_step_utc(world_host *host, int64_t by_ns)
{
    host->utc_offset_ns += by_ns;
    WORLD_TRACE("the clock of %s is set by %+.3f s", host->name,
                (double)by_ns / 1e9);
    world_met("fault:clock-step");
}

void world_host_set_drift(world_host *host, int64_t drift_ppb)
{
    const int64_t now = world_now();
    const int64_t mono = world_host_mono_ns(host);
    host->drift_ppb = drift_ppb;
    host->mono_start_ns = mono - now - scaled(now, drift_ppb);
    world_met("fault:clock-drift");
}

void world_host_reset(void)
{
    while (hosts != NULL) {
        world_host *next = hosts->next;
        free(hosts);
        hosts = next;
    }
}
