/* Looking up a name by getaddrinfo(), which every system has, each in headers
 * of its own: include them before this. */
#ifndef LUM_NET_RESOLVE_LOOK_UP_H
#define LUM_NET_RESOLVE_LOOK_UP_H

#include "net/resolve.h"

#include <stdbool.h>
#include <string.h>

/* Say what a code means. Returns -1. */
static int fail(const char *name, int code, bool lacks_address,
                lum_error *error)
{
    if (lacks_address) {
        return lum_error_set(error,
                             "'%.80s': this host has no IPv4 address; sensors "
                             "use only IPv4",
                             name);
    }
    if (code == EAI_NONAME) {
        return lum_error_set(error,
                             "'%.80s': no host of this name is known; give its "
                             "address, such as 10.42.0.37",
                             name);
    }
    return lum_error_set(error,
                         "'%.80s': the name cannot be looked up: %s; give its "
                         "address, such as 10.42.0.37",
                         name, gai_strerror(code));
}

/* As lum_system_resolve(); lacks_address: whether a code of getaddrinfo() says
 * that a name has only other addresses. */
static int look_up(const char *name, bool (*lacks_address)(int code),
                   uint32_t *out, lum_error *error)
{
    struct addrinfo *found = NULL;
    struct sockaddr_in address;
    const struct addrinfo wanted = {.ai_family = AF_INET,
                                    .ai_socktype = SOCK_DGRAM};
    const int code = getaddrinfo(name, NULL, &wanted, &found);
    if (code != 0) {
        return fail(name, code, lacks_address(code), error);
    }
    memcpy(&address, found->ai_addr, sizeof address);
    freeaddrinfo(found);
    *out = ntohl(address.sin_addr.s_addr);
    return 0;
}

#endif
