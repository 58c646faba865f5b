/* A computer of the world: its clocks, its disk, its interfaces. */
#ifndef WORLD_HOST_H
#define WORLD_HOST_H

#include <stdbool.h>
#include <stdint.h>

struct world_disk;
struct world_net_host;

typedef struct world_host {
    char name[24];
    struct world_host *next;
    /* Clocks: monotonic = start + (true time) * (1 + drift_ppb / 10^9). */
    int64_t mono_start_ns;
    int64_t drift_ppb;
    int64_t utc_offset_ns; /* of the calendar's clock over the monotonic one */
    unsigned slowness;     /* a call costs so many times the usual; 1: idle */
    struct world_disk *disk;    /* disk.h */
    struct world_net_host *net; /* net.h */
} world_host;

world_host *world_host_new(const char *name);
world_host *world_host_first(void);

int64_t world_host_mono_ns(const world_host *host);
int64_t world_host_utc_ns(const world_host *host);
/* The true time at which the host's monotonic clock shows this. */
int64_t world_host_true_ns(const world_host *host, int64_t mono_ns);
/* The calendar's clock is set forward or back. */
void world_host_step_utc(world_host *host, int64_t by_ns);
/* Monotonic goes on from where it is, at another speed. */
void world_host_set_drift(world_host *host, int64_t drift_ppb);

#endif
