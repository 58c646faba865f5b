#include "internal.h"

#include "kernel/trace.h"

#include <stdlib.h>
#include <string.h>

/* The addresses of hosts as they were said. */
typedef struct named {
    struct named *next;
    const world_host *host;
    const char *address;
} named;

static named *all;

static void name_host(const world_host *host, const char *address)
{
    named *n = user_keep(sizeof *n);
    n->host = host;
    n->address = user_keep_text(address, strcspn(address, "/"));
    n->next = all;
    all = n;
}

const char *user_address_of(const world_host *host)
{
    const char *first = NULL;
    for (const named *n = all; n != NULL; n = n->next) {
        first = n->host == host ? n->address : first;
    }
    if (first == NULL) {
        user_fail(USER_HERE, "%s has no address", host->name);
    }
    return first;
}

/* The number behind an address, "/24". */
static unsigned prefix_of(const char *address)
{
    const char *slash = strchr(address, '/');
    return slash != NULL ? (unsigned)strtoul(slash + 1, NULL, 10) : 24;
}

uint32_t user_ip(const char *address)
{
    uint32_t value = 0;
    const char *at = address;
    for (unsigned i = 0; i < 4; i++) {
        char *end = NULL;
        const unsigned long part = strtoul(at, &end, 10);
        if (end == at || part > 255 || (i < 3 && *end != '.')) {
            user_fail(USER_HERE, "%s is no address", address);
        }
        value = value << 8 | (uint32_t)part;
        at = end + 1;
    }
    return value;
}

world_host *user_host_new(const char *name)
{
    const bool is_traced = world_traces;
    world_traces = false; /* what it is made of is always the same */
    world_host *host = world_host_new(name);
    world_disk_make_folder(world_disk_of(host), "/state");
    world_traces = is_traced;
    user_trace("a computer: %s", name);
    return host;
}

world_interface *user_interface(world_host *host, const char *name,
                                world_segment *wire, const char *address)
{
    world_interface *interface = world_interface_new(host, wire, name);
    world_interface_add(interface, user_ip(address), prefix_of(address));
    name_host(host, address);
    return interface;
}

world_host *user_sensor_host(const char *name, world_segment *wire,
                             const char *address)
{
    world_host *host = user_host_new(name);
    world_interface *interface = world_interface_new(host, wire, "eth0");
    world_interface_roam(interface, prefix_of(address));
    name_host(host, address);
    return host;
}

user_bench user_bench_new(void)
{
    user_bench bench;
    bench.wire = world_segment_new("wire");
    bench.host = user_host_new("bench");
    bench.eth0 = user_interface(bench.host, "eth0", bench.wire, "10.42.0.1/24");
    bench.sensor = user_sensor_host("sensor", bench.wire, "10.42.0.37/24");
    return bench;
}

/* --- faults --- */

static void set_faults(world_link *link, user_faults faults)
{
    const world_link usual = {.delay_ns = 10 * WORLD_US};
    link->delay_ns = usual.delay_ns + (int64_t)(faults.delay_ms * 1e6);
    link->jitter_ns = (int64_t)(faults.jitter_ms * 1e6);
    link->lose = faults.lose;
    link->repeat = faults.repeat;
    link->reorder = faults.reorder;
    link->reorder_ns = (int64_t)(faults.reorder_ms * 1e6);
    link->corrupt = faults.corrupt;
}

static void tell_faults(const world_interface *interface, const char *way,
                        user_faults f)
{
    if (memcmp(&f, &(user_faults){0}, sizeof f) == 0) {
        user_trace("%s of %s %s: no faults", interface->name,
                   interface->host->name, way);
        return;
    }
    user_trace("%s of %s %s: loses %g, repeats %g, corrupts %g, reorders %g "
               "(%g ms), delay %g ms, jitter %g ms",
               interface->name, interface->host->name, way, f.lose, f.repeat,
               f.corrupt, f.reorder, f.reorder_ms, f.delay_ms, f.jitter_ms);
}

void user_fault_out(world_interface *interface, user_faults faults)
{
    tell_faults(interface, "out", faults);
    set_faults(&interface->out, faults);
}

void user_fault_in(world_interface *interface, user_faults faults)
{
    tell_faults(interface, "in", faults);
    set_faults(&interface->in, faults);
}

void user_fault(world_interface *interface, user_faults faults)
{
    user_fault_out(interface, faults);
    user_fault_in(interface, faults);
}

void user_cable(world_interface *interface, bool is_in)
{
    user_trace("%s the cable of %s", is_in ? "puts in" : "pulls",
               interface->host->name);
    world_interface_set_carrier(interface, is_in);
}

void user_bench_reset(void)
{
    all = NULL;
}
