#define _DEFAULT_SOURCE
#include "net/route.h"
#include "net/sockaddr.h"

#include <ifaddrs.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* The address that the host would send from: a connected UDP socket has it
 * without sending anything. */
static bool source_for(uint32_t address, struct sockaddr_in *out)
{
    const struct sockaddr_in to = lum_sockaddr_of((lum_endpoint){address, 9});
    socklen_t len = sizeof *out;
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0) {
        return false;
    }
    const bool found =
        connect(fd, (const struct sockaddr *)&to, sizeof to) == 0 &&
        getsockname(fd, (struct sockaddr *)out, &len) == 0;
    (void)close(fd);
    return found;
}

static bool is_address(const struct ifaddrs *entry, struct in_addr address)
{
    struct sockaddr_in theirs;
    if (entry->ifa_addr == NULL || entry->ifa_addr->sa_family != AF_INET) {
        return false;
    }
    memcpy(&theirs, entry->ifa_addr, sizeof theirs);
    return theirs.sin_addr.s_addr == address.s_addr;
}

/* Every address of 127/8 is the loopback's, although it lists only the
 * first. */
static struct in_addr as_listed(struct in_addr address)
{
    if (ntohl(address.s_addr) >> 24 == 127u) {
        address.s_addr = htonl(INADDR_LOOPBACK);
    }
    return address;
}

/* If two interfaces have one address, it is not clear which is meant. */
bool lum_route_interface(uint32_t address, char *out, size_t room)
{
    struct sockaddr_in source;
    struct ifaddrs *all = NULL;
    unsigned found = 0;
    if (!source_for(address, &source) || getifaddrs(&all) != 0) {
        return false;
    }
    const struct in_addr wanted = as_listed(source.sin_addr);
    for (const struct ifaddrs *i = all; i != NULL; i = i->ifa_next) {
        if (is_address(i, wanted)) {
            (void)snprintf(out, room, "%s", i->ifa_name);
            found++;
        }
    }
    freeifaddrs(all);
    return found == 1;
}
