#include "net/winsock.h"

#include "net/resolve_look_up.h"

static bool lacks_address(int code)
{
    return code == WSANO_DATA;
}

int lum_system_resolve(const char *name, uint32_t *out, lum_error *error)
{
    if (lum_winsock_start(error) != 0) {
        return -1;
    }
    const int result = look_up(name, lacks_address, out, error);
    lum_winsock_stop();
    return result;
}
