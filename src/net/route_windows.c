/* The interface by which datagrams for an address leave, on Windows. */
#include "net/winsock.h"

#include "net/adapter.h"
#include "net/route.h"
#include "net/sockaddr.h"

#include <iphlpapi.h>
#include <stdio.h>

bool lum_route_interface(uint32_t address, char *out, size_t room)
{
    DWORD index = 0;
    lum_adapter adapter;
    if (GetBestInterface(htonl(address), &index) != NO_ERROR ||
        !lum_adapter_at(index, &adapter)) {
        return false;
    }
    (void)snprintf(out, room, "%s", adapter.name);
    return true;
}

/* A connected UDP socket has it without sending anything. */
uint32_t lum_route_source(uint32_t address)
{
    const struct sockaddr_in to = lum_sockaddr_of((lum_endpoint){address, 9});
    struct sockaddr_in own;
    int len = sizeof own;
    const SOCKET s = socket(AF_INET, SOCK_DGRAM, 0);
    const bool found =
        s != INVALID_SOCKET &&
        connect(s, (const struct sockaddr *)&to, sizeof to) == 0 &&
        getsockname(s, (struct sockaddr *)&own, &len) == 0;
    (void)closesocket(s);
    return found ? ntohl(own.sin_addr.s_addr) : 0;
}
