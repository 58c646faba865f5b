/* Programs on systems that do not say which one has a port. */
#include "net/program.h"

#include <stdio.h>

lum_program_text lum_program_show(long process)
{
    lum_program_text out = {"another program"};
    if (process > 0) {
        (void)snprintf(out.text, sizeof out.text, "process %ld", process);
    }
    return out;
}

long lum_program_of_port(lum_endpoint local)
{
    (void)local;
    return 0;
}

long lum_program_of_tcp_port(lum_endpoint local)
{
    (void)local;
    return 0;
}
