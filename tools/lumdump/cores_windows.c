/* Cores that this process may use, by its affinity on Windows. */
#include "options.h"

#include <windows.h>

/* Those of its group: at most 64, or 32 in a program of 32 bits. */
unsigned cores_count(void)
{
    DWORD_PTR mine = 0;
    DWORD_PTR all = 0;
    unsigned n = 0;
    if (GetProcessAffinityMask(GetCurrentProcess(), &mine, &all) == 0) {
        return 1;
    }
    for (; mine != 0; mine &= mine - 1u) {
        n++;
    }
    return n > 0 ? n : 1u;
}
