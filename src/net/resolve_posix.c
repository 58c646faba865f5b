#define _GNU_SOURCE /* EAI_NODATA */
#include "net/resolve.h"
#include "net/resolve_messages.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "net/resolve_look_up.h"

bool lum_system_parse_address(const char *text, uint32_t *out)
{
    struct in_addr address;
    if (inet_pton(AF_INET, text, &address) != 1) {
        return false;
    }
    *out = ntohl(address.s_addr);
    return true;
}

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

static int say(const char *name, int code, lum_error *error)
{
    if (lacks_address(code)) {
        return lum_resolve_say_no_address(name, error);
    }
    return code == EAI_NONAME
               ? lum_resolve_say_unknown(name, error)
               : lum_resolve_say_failed(name, gai_strerror(code), error);
}

int lum_system_resolve(const char *name, uint32_t *out, lum_error *error)
{
    return look_up(name, say, out, error);
}
