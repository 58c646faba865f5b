/* Cores of the machine, on systems of POSIX other than Linux. */
#include "options.h"

#include <unistd.h>

unsigned cores_count(void)
{
    const long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (unsigned)n : 1u;
}
