#define _POSIX_C_SOURCE 200809L
#include "own_address.h"

#include "interfaces.h"

#include <stdlib.h>
#include <string.h>
#if defined(_WIN32)
#include "net/winsock.h"
#else
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#define closesocket close
typedef int SOCKET;
#endif

static uint32_t of_interface(const char *name)
{
    lum_error error;
    struct host_interface *all = NULL;
    size_t count = 0;
    if (interfaces_list(&all, &count, &error) != 0) {
        return 0;
    }
    const struct host_interface *found = interfaces_find(all, count, name);
    const uint32_t address = found != NULL && found->address_count > 0
                                 ? found->addresses[0].address
                                 : 0;
    free(all);
    return address;
}

/* Connecting a UDP socket looks the route up. */
static uint32_t of_route(lum_endpoint to)
{
    struct sockaddr_in address;
    struct sockaddr_in own;
    socklen_t len = sizeof own;
    uint32_t found = 0;
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_port = htons(to.port);
    address.sin_addr.s_addr = htonl(to.address);
    /* of one that could not be made the rest fails, too */
    const SOCKET s = socket(AF_INET, SOCK_DGRAM, 0);
    if (connect(s, (const struct sockaddr *)&address, sizeof address) == 0 &&
        getsockname(s, (struct sockaddr *)&own, &len) == 0) {
        found = ntohl(own.sin_addr.s_addr);
    }
    (void)closesocket(s);
    return found;
}

uint32_t own_address(lum_endpoint to, const char *interface)
{
    return interface != NULL ? of_interface(interface) : of_route(to);
}
