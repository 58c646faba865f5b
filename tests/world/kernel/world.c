#include "world.h"

#include "disk.h"
#include "file.h"
#include "host_internal.h"
#include "net.h"
#include "pipe.h"
#include "process_internal.h"
#include "task_internal.h"
#include "terminal.h"
#include "time_internal.h"
#include "trace_internal.h"

static uint64_t present_seed;

uint64_t world_seed(void)
{
    return present_seed;
}

/* Tasks first: they may hold what the others free. */
void world_end(void)
{
    world_task_reset();
    world_process_reset();
    world_pipe_reset();
    world_file_reset();
    world_terminal_reset();
    world_disk_reset();
    world_net_reset();
    world_time_reset();
    world_host_reset();
}

void world_begin(uint64_t seed)
{
    world_end();
    present_seed = seed;
    world_trace_reset();
    world_task_reset();
}
