/* Small facts of a WebAssembly host. */
#include "system.h"

#include <string.h>

/* Nothing is written there, and there are no other processes. */
const char *lum_system_base(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}
