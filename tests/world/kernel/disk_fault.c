#define _GNU_SOURCE
#include "disk_internal.h"

#include "process.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* In the order of the bits. */
static const struct {
    const char *name;
    const char *stalled, *slow, *failed;
} calls[] = {
    {"read", "fault:disk-stall-read", "fault:disk-slow-read",
     "fault:disk-fail-read"},
    {"write", "fault:disk-stall-write", "fault:disk-slow-write",
     "fault:disk-fail-write"},
    {"sync", "fault:disk-stall-sync", "fault:disk-slow-sync",
     "fault:disk-fail-sync"},
    {"close", "fault:disk-stall-close", "fault:disk-slow-close",
     "fault:disk-fail-close"},
    {"open", "fault:disk-stall-open", "fault:disk-slow-open",
     "fault:disk-fail-open"},
    {"rename", "fault:disk-stall-rename", "fault:disk-slow-rename",
     "fault:disk-fail-rename"},
    {"unlink", "fault:disk-stall-remove", "fault:disk-slow-remove",
     "fault:disk-fail-remove"},
    {"look", "fault:disk-stall-look", "fault:disk-slow-look",
     "fault:disk-fail-look"},
};

static unsigned number_of(unsigned call)
{
    unsigned n = 0;
    while (call >> n > 1u) {
        n++;
    }
    return n;
}

/* --- What befalls a call --- */

static void slow_down(struct disk_fault *fault, unsigned call)
{
    world_queue nothing = {NULL, NULL};
    if ((fault->slow_calls & call) == 0) {
        return;
    }
    const int64_t by = world_random_between(&fault->random, fault->slow_low_ns,
                                            fault->slow_high_ns);
    world_met(calls[number_of(call)].slow);
    world_wait_deaf(&nothing, world_now() + by);
}

static bool is_stalled(const struct disk_fault *fault, unsigned call)
{
    return (fault->stall_calls & call) != 0 &&
           fault->stall_until_ns > world_now();
}

static void stall(struct disk_fault *fault, unsigned call)
{
    if (!is_stalled(fault, call)) {
        return;
    }
    world_met(calls[number_of(call)].stalled);
    WORLD_TRACE("the disk stalls a %s", calls[number_of(call)].name);
    while (is_stalled(fault, call)) {
        world_wait_deaf(&fault->healed, fault->stall_until_ns);
    }
}

static bool is_nth(struct disk_fault *fault, unsigned call)
{
    if ((fault->nth_calls & call) == 0 || fault->nth == 0) {
        return false;
    }
    fault->nth--;
    return fault->nth == 0;
}

static int fail(unsigned call, int code)
{
    world_met(calls[number_of(call)].failed);
    WORLD_TRACE("the disk fails a %s: %s", calls[number_of(call)].name,
                strerror(code));
    return code;
}

int disk_pass(world_disk *disk, unsigned call)
{
    struct disk_fault *fault = &disk->fault;
    const unsigned writes =
        WORLD_DISK_WRITE | WORLD_DISK_RENAME | WORLD_DISK_REMOVE;
    if (world_process_self() == NULL) {
        return 0;
    }
    slow_down(fault, call);
    stall(fault, call);
    if (fault->is_read_only && (call & writes) != 0) {
        return fail(call, EROFS);
    }
    if (is_nth(fault, call)) {
        return fail(call, fault->nth_code);
    }
    if ((fault->fail_calls & call) != 0 &&
        world_random_chance(&fault->random, fault->fail_chance)) {
        return fail(call, fault->fail_code);
    }
    return 0;
}

/* --- What the user or the dice set --- */

/* Nothing but the stream and what fits is left. */
static void begin(struct disk_fault *fault)
{
    fault->stall_calls = fault->slow_calls = 0;
    fault->fail_calls = fault->nth_calls = 0;
    fault->is_limited = false;
    fault->is_read_only = false;
}

void disk_fault_begin(world_disk *disk)
{
    char name[64];
    (void)snprintf(name, sizeof name, "disk:%s", disk->host->name);
    begin(&disk->fault);
    disk->fault.random = world_stream(name, 0);
}

void world_disk_stall(world_disk *disk, unsigned for_calls, int64_t until_ns)
{
    disk->fault.stall_calls = for_calls;
    disk->fault.stall_until_ns = until_ns;
    world_wake_all(&disk->fault.healed); /* to wait for the new moment */
}

void world_disk_slow(world_disk *disk, unsigned for_calls, int64_t low_ns,
                     int64_t high_ns)
{
    disk->fault.slow_calls = for_calls;
    disk->fault.slow_low_ns = low_ns;
    disk->fault.slow_high_ns = high_ns;
}

void world_disk_fill(world_disk *disk, uint64_t room)
{
    disk->fault.is_limited = true;
    disk->fault.room = room;
}

void world_disk_fail(world_disk *disk, unsigned for_calls, double chance,
                     int code)
{
    disk->fault.fail_calls = for_calls;
    disk->fault.fail_chance = chance;
    disk->fault.fail_code = code;
}

void world_disk_fail_nth(world_disk *disk, unsigned for_calls, uint64_t n,
                         int code)
{
    disk->fault.nth_calls = for_calls;
    disk->fault.nth = n;
    disk->fault.nth_code = code;
}

void world_disk_set_read_only(world_disk *disk, bool is_read_only)
{
    disk->fault.is_read_only = is_read_only;
}

void world_disk_heal(world_disk *disk)
{
    begin(&disk->fault);
    world_wake_all(&disk->fault.healed);
    WORLD_TRACE("the disk of %s is healed", disk->host->name);
}

/* --- Power --- */

void world_disk_cut(world_disk *disk, double kept)
{
    for (disk_inode *i = disk->inodes; i != NULL; i = i->next) {
        disk_revert_bytes(i, kept);
    }
    disk_revert_names(disk, kept);
    world_met("fault:power-cut");
}

/* Each ends as if it had been killed. */
void world_host_power_cut(world_host *host, double kept)
{
    const int killed = 9;
    WORLD_TRACE("the power of %s is cut", host->name);
    for (world_process *p = world_process_first(); p != NULL; p = p->next) {
        if (p->host == host && !p->has_ended) {
            world_process_end(p, killed);
        }
    }
    world_disk_cut(world_disk_of(host), kept);
}
