/* Endpoints and handles as sockets have them. */
#ifndef LUM_NET_SOCKADDR_H
#define LUM_NET_SOCKADDR_H

#if defined(_WIN32)
#include "net/winsock.h"
#else
#include <arpa/inet.h>
#include <netinet/in.h>
#endif

#include "lum/net/socket.h"

#include <string.h>

#if defined(_WIN32)

typedef SOCKET lum_system_handle;
#define LUM_SYSTEM_NONE INVALID_SOCKET

#else

typedef int lum_system_handle;
#define LUM_SYSTEM_NONE (-1)

#endif

static inline struct sockaddr_in lum_sockaddr_of(lum_endpoint endpoint)
{
    struct sockaddr_in out;
    memset(&out, 0, sizeof out);
    out.sin_family = AF_INET;
    out.sin_port = htons(endpoint.port);
    out.sin_addr.s_addr = htonl(endpoint.address);
    return out;
}

static inline lum_endpoint lum_sockaddr_endpoint(
    const struct sockaddr_in *address)
{
    return (lum_endpoint){.address = ntohl(address->sin_addr.s_addr),
                          .port = ntohs(address->sin_port)};
}

#endif
