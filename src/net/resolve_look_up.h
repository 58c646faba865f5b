/* Looking up a name by getaddrinfo(), which every system has, each in headers
 * of its own: include them before this. */
#ifndef LUM_NET_RESOLVE_LOOK_UP_H
#define LUM_NET_RESOLVE_LOOK_UP_H

#include "lum/base/error.h"

#include <stdint.h>
#include <string.h>

/* Set the error for a code of getaddrinfo(). Returns -1. */
typedef int (*lum_resolve_say)(const char *name, int code, lum_error *error);

/* The first IPv4 address. 0; or what say returns. */
static int look_up(const char *name, lum_resolve_say say, uint32_t *out,
                   lum_error *error)
{
    struct addrinfo *found = NULL;
    struct sockaddr_in address;
    const struct addrinfo wanted = {.ai_family = AF_INET,
                                    .ai_socktype = SOCK_DGRAM};
    const int code = getaddrinfo(name, NULL, &wanted, &found);
    if (code != 0) {
        return say(name, code, error);
    }
    memcpy(&address, found->ai_addr, sizeof address);
    freeaddrinfo(found);
    *out = ntohl(address.sin_addr.s_addr);
    return 0;
}

#endif
