/* Cores that this process may use, by its affinity on Linux. */
#define _GNU_SOURCE
#include "options.h"

#include <sched.h>

/* A machine with more cores than the set holds is an error; then one works. */
unsigned cores_count(void)
{
    cpu_set_t mine;
    return sched_getaffinity(0, sizeof mine, &mine) == 0
               ? (unsigned)CPU_COUNT(&mine)
               : 1u;
}
