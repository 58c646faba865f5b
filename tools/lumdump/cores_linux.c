#define _GNU_SOURCE
#include "cores.h"

#include <sched.h>
#include <unistd.h>

/* The set of the process may be too small for a large machine's kernel. */
unsigned cores_count(void)
{
    cpu_set_t mine;
    if (sched_getaffinity(0, sizeof mine, &mine) == 0) {
        return (unsigned)CPU_COUNT(&mine);
    }
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (unsigned)n : 1u;
}
