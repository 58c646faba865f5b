#define _DEFAULT_SOURCE /* getifaddrs */
#include "own_address.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <stddef.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static uint32_t address_of(const struct sockaddr *address)
{
    struct sockaddr_in in;
    memcpy(&in, address, sizeof in);
    return ntohl(in.sin_addr.s_addr);
}

static uint32_t of_interface(const char *name)
{
    struct ifaddrs *all = NULL;
    uint32_t found = 0;
    if (getifaddrs(&all) != 0) {
        return 0;
    }
    for (const struct ifaddrs *i = all; i != NULL && found == 0;
         i = i->ifa_next) {
        if (i->ifa_addr != NULL && i->ifa_addr->sa_family == AF_INET &&
            strcmp(i->ifa_name, name) == 0) {
            found = address_of(i->ifa_addr);
        }
    }
    freeifaddrs(all);
    return found;
}

/* Connecting a UDP socket looks the route up. */
static uint32_t of_route(lum_endpoint to)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons(to.port),
                                  .sin_addr = {htonl(to.address)}};
    struct sockaddr own;
    socklen_t len = sizeof own;
    uint32_t found = 0;
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0) {
        return 0;
    }
    if (connect(fd, (const struct sockaddr *)&address, sizeof address) == 0 &&
        getsockname(fd, &own, &len) == 0) {
        found = address_of(&own);
    }
    (void)close(fd);
    return found;
}

uint32_t own_address(lum_endpoint to, const char *interface)
{
    return interface != NULL ? of_interface(interface) : of_route(to);
}
