#include "net/winsock.h"

#include "net/resolve.h"
#include "net/resolve_look_up.h"
#include "net/resolve_messages.h"

/* inet_pton() needs no Winsock that was started. */
bool lum_system_parse_address(const char *text, uint32_t *out)
{
    struct in_addr address;
    if (inet_pton(AF_INET, text, &address) != 1) {
        return false;
    }
    *out = ntohl(address.s_addr);
    return true;
}

static int say(const char *name, int code, lum_error *error)
{
    if (code == WSANO_DATA) {
        return lum_resolve_say_no_address(name, error);
    }
    return code == WSAHOST_NOT_FOUND
               ? lum_resolve_say_unknown(name, error)
               : lum_resolve_say_failed(name, gai_strerrorA(code), error);
}

int lum_system_resolve(const char *name, uint32_t *out, lum_error *error)
{
    if (lum_winsock_start(error) != 0) {
        return -1;
    }
    const int result = look_up(name, say, out, error);
    lum_winsock_stop();
    return result;
}
