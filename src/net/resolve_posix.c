#define _GNU_SOURCE /* EAI_NODATA */

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "net/resolve_look_up.h"

/* Systems report in two ways that a name has only other addresses. */
static bool lacks_address(int code)
{
#ifdef EAI_ADDRFAMILY
    if (code == EAI_ADDRFAMILY) {
        return true;
    }
#endif
#ifdef EAI_NODATA
    if (code == EAI_NODATA) {
        return true;
    }
#endif
    return false;
}

int lum_system_resolve(const char *name, uint32_t *out, lum_error *error)
{
    return look_up(name, lacks_address, out, error);
}
