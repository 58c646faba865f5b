/* A computer has no such counter; whether the packets of measure.c are taken as
 * they are meant shows without. */
#include "port/port.h"

uint32_t port_ticks(void)
{
    return 0;
}
