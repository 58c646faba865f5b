/* The interface by which datagrams for an address leave, on POSIX. */
#define _DEFAULT_SOURCE
#include "net/route.h"
#include "net/sockaddr.h"

#include <ifaddrs.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* A connected UDP socket has it without sending anything. */
uint32_t lum_route_source(uint32_t address)
{
    const struct sockaddr_in to = lum_sockaddr_of((lum_endpoint){address, 9});
    struct sockaddr_in own;
    socklen_t len = sizeof own;
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0) {
        return 0;
    }
    const bool found =
        connect(fd, (const struct sockaddr *)&to, sizeof to) == 0 &&
        getsockname(fd, (struct sockaddr *)&own, &len) == 0;
    (void)close(fd);
    return found ? ntohl(own.sin_addr.s_addr) : 0;
}

static bool is_address(const struct ifaddrs *entry, uint32_t address)
{
    struct sockaddr_in theirs;
    if (entry->ifa_addr == NULL || entry->ifa_addr->sa_family != AF_INET) {
        return false;
    }
    memcpy(&theirs, entry->ifa_addr, sizeof theirs);
    return ntohl(theirs.sin_addr.s_addr) == address;
}

/* Every address of 127/8 is the loopback's, although it lists only the
 * first. */
static uint32_t as_listed(uint32_t address)
{
    return address >> 24 == 127u ? INADDR_LOOPBACK : address;
}

/* If two interfaces have one address, it is not clear which is meant. */
bool lum_route_interface(uint32_t address, char *out, size_t room)
{
    const uint32_t wanted = as_listed(lum_route_source(address));
    struct ifaddrs *all = NULL;
    unsigned found = 0;
    if (wanted == 0 || getifaddrs(&all) != 0) {
        return false;
    }
    for (const struct ifaddrs *i = all; i != NULL; i = i->ifa_next) {
        if (is_address(i, wanted)) {
            (void)snprintf(out, room, "%s", i->ifa_name);
            found++;
        }
    }
    freeifaddrs(all);
    return found == 1;
}
