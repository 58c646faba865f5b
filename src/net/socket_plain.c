/* Sockets on systems other than Linux: one datagram a call, and no drops
 * counted. */
#define _DEFAULT_SOURCE
#include "net/socket_system.h"

#include "lum/base/time.h"
#include "net/endpoint.h"

#if defined(_WIN32)
#include "net/adapter.h"
#else
#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>
#endif

#include <errno.h>
#include <limits.h>
#include <string.h>

#define NS_PER_MS INT64_C(1000000)

/* Systems refuse a receive buffer that is too large, instead of granting less;
 * they accept sizes below this. */
#define LEAST_BUFFER (64 * 1024)

static lum_net_result refuse_interface(const char *name, lum_error *error)
{
    (void)lum_error_set(error,
                        "cannot use interface %s: it has no IPv4 address; "
                        "give it one in the sensor's network",
                        name);
    return LUM_NET_FAILED;
}

#if defined(_WIN32)

#define poll WSAPoll

typedef int send_size;
typedef ULONG set_size;

/* Older headers lack the name. */
#ifndef IP_UNICAST_IF
#define IP_UNICAST_IF 31
#endif

static void set_number(SOCKET handle, int level, int name, int value)
{
    (void)setsockopt(handle, level, name, (const char *)&value, sizeof value);
}

lum_system_handle lum_system_socket(lum_error *error)
{
    if (lum_winsock_start(error) != 0) {
        return LUM_SYSTEM_NONE;
    }
    const SOCKET fd = lum_winsock_udp(error);
    if (fd == INVALID_SOCKET) {
        lum_winsock_stop();
        return LUM_SYSTEM_NONE;
    }
    set_number(fd, SOL_SOCKET, SO_EXCLUSIVEADDRUSE, 1);
    return fd;
}

/* Sent there, and bound to its address. */
lum_net_result lum_system_use_interface(lum_system_handle fd, const char *name,
                                        lum_endpoint *local, unsigned *only,
                                        lum_error *error)
{
    lum_adapter adapter = {.address = 0};
    *only = 0;
    if (!lum_adapter_find(name, local->address, &adapter) ||
        adapter.address == 0) {
        return refuse_interface(name, error);
    }
    set_number(fd, IPPROTO_IP, IP_UNICAST_IF, (int)htonl(adapter.index));
    local->address = local->address != 0 ? local->address : adapter.address;
    return LUM_NET_OK;
}

bool lum_system_tell(lum_system_handle fd)
{
    (void)fd;
    return false;
}

static int receive_one(lum_system_handle fd, uint8_t *buffer, lum_received *out)
{
    struct sockaddr_in peer = {0};
    int peer_len = sizeof peer;
    const int len = recvfrom(fd, (char *)buffer, (int)LUM_SOCKET_BYTES, 0,
                             (struct sockaddr *)&peer, &peer_len);
    if (len < 0 && lum_winsock_errno() != EMSGSIZE) {
        return -1;
    }
    *out = (lum_received){.bytes = buffer,
                          .len = len < 0 ? LUM_SOCKET_BYTES : (size_t)len,
                          .from = lum_sockaddr_endpoint(&peer),
                          .cut_short = len < 0};
    return 0;
}

#else

typedef size_t send_size;
typedef nfds_t set_size;

lum_system_handle lum_system_socket(lum_error *error)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0 || fcntl(fd, F_SETFL, O_NONBLOCK) < 0 ||
        fcntl(fd, F_SETFD, FD_CLOEXEC) < 0) {
        (void)lum_error_set(error, "cannot make a UDP socket: %s",
                            strerror(errno));
        if (fd >= 0) {
            (void)close(fd);
        }
        return LUM_SYSTEM_NONE;
    }
    return fd;
}

/* The interface's first address, or the one wanted; 0: it has none. */
static uint32_t address_of(const char *name, uint32_t wanted)
{
    struct ifaddrs *all = NULL;
    uint32_t found = 0;
    if (getifaddrs(&all) != 0) {
        return 0;
    }
    for (const struct ifaddrs *i = all; i != NULL; i = i->ifa_next) {
        struct sockaddr_in address;
        if (i->ifa_addr == NULL || i->ifa_addr->sa_family != AF_INET ||
            strcmp(i->ifa_name, name) != 0) {
            continue;
        }
        memcpy(&address, i->ifa_addr, sizeof address);
        const uint32_t theirs = ntohl(address.sin_addr.s_addr);
        if (found == 0 || theirs == wanted) {
            found = theirs;
        }
    }
    freeifaddrs(all);
    return found;
}

#if defined(IP_BOUND_IF)

static void stay_on(int fd, const char *name)
{
    const unsigned index = if_nametoindex(name);
    (void)setsockopt(fd, IPPROTO_IP, IP_BOUND_IF, &index, sizeof index);
}

#else

static void stay_on(int fd, const char *name)
{
    (void)fd;
    (void)name;
}

#endif

/* Bound to its address; the loopback has all that begin with 127. */
lum_net_result lum_system_use_interface(lum_system_handle fd, const char *name,
                                        lum_endpoint *local, unsigned *only,
                                        lum_error *error)
{
    const uint32_t address = address_of(name, local->address);
    *only = 0;
    if (address == 0) {
        return refuse_interface(name, error);
    }
    if (local->address != 0 && local->address != address &&
        (local->address >> 24 != 127u || address >> 24 != 127u)) {
        (void)lum_error_set(error, "interface %s does not have the address %s",
                            name,
                            lum_endpoint_show_address(local->address).text);
        return LUM_NET_FAILED;
    }
    local->address = local->address != 0 ? local->address : address;
    stay_on(fd, name);
    return LUM_NET_OK;
}

#if defined(SO_TIMESTAMP) && defined(SCM_TIMESTAMP)

bool lum_system_tell(lum_system_handle fd)
{
    const int on = 1;
    (void)setsockopt(fd, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);
    return false;
}

static void read_control(const struct cmsghdr *control, lum_received *out)
{
    struct timeval at;
    if (control->cmsg_level == SOL_SOCKET &&
        control->cmsg_type == SCM_TIMESTAMP) {
        memcpy(&at, CMSG_DATA(control), sizeof at);
        out->utc_ns = (int64_t)at.tv_sec * INT64_C(1000000000) +
                      (int64_t)at.tv_usec * 1000;
    }
}

#else

bool lum_system_tell(lum_system_handle fd)
{
    (void)fd;
    return false;
}

static void read_control(const struct cmsghdr *control, lum_received *out)
{
    (void)control;
    (void)out;
}

#endif

static int receive_one(lum_system_handle fd, uint8_t *buffer, lum_received *out)
{
    union {
        size_t align;
        char bytes[CMSG_SPACE(sizeof(struct timeval))];
    } control;
    struct sockaddr_in peer;
    struct iovec vector = {.iov_base = buffer, .iov_len = LUM_SOCKET_BYTES};
    struct msghdr header = {.msg_name = &peer,
                            .msg_namelen = sizeof peer,
                            .msg_iov = &vector,
                            .msg_iovlen = 1,
                            .msg_control = &control,
                            .msg_controllen = sizeof control.bytes};
    memset(&peer, 0, sizeof peer);
    const ssize_t len = recvmsg(fd, &header, 0);
    if (len < 0) {
        return -1;
    }
    *out = (lum_received){.bytes = buffer,
                          .len = (size_t)len,
                          .from = lum_sockaddr_endpoint(&peer),
                          .cut_short = (header.msg_flags & MSG_TRUNC) != 0};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(&header); c != NULL;
         c = CMSG_NXTHDR(&header, c)) {
        read_control(c, out);
    }
    return 0;
}

#endif

size_t lum_system_grow(lum_system_handle fd, size_t bytes, bool *enough)
{
    int granted = 0;
    socklen_t len = sizeof granted;
    int ask = (int)(bytes < INT_MAX ? bytes : INT_MAX);
    while (ask != 0 &&
           setsockopt(fd, SOL_SOCKET, SO_RCVBUF, (const char *)&ask,
                      sizeof ask) != 0 &&
           ask > LEAST_BUFFER) {
        ask /= 2;
    }
    if (getsockopt(fd, SOL_SOCKET, SO_RCVBUF, (char *)&granted, &len) != 0 ||
        granted < 0) {
        granted = 0;
    }
    *enough = (size_t)granted >= bytes;
    return (size_t)granted;
}

bool lum_system_drops(lum_system_handle fd, uint32_t *out)
{
    (void)fd;
    (void)out;
    return false;
}

int lum_system_poll(struct pollfd *set, size_t count, int64_t wait_ns)
{
    const int64_t most = INT_MAX;
    if (count == 0) { /* which Windows refuses to wait for */
        lum_time_sleep_until(lum_time_monotonic_ns() + wait_ns);
        return 0;
    }
    const int64_t wait_ms =
        wait_ns / NS_PER_MS + (wait_ns % NS_PER_MS != 0 ? 1 : 0);
    return poll(set, (set_size)count, (int)(wait_ms < most ? wait_ms : most));
}

bool lum_system_take_joined(lum_system_handle fd)
{
    (void)fd;
    return false;
}

int lum_system_receive(lum_system_handle fd, bool joined, uint8_t *buffers,
                       lum_received *out, lum_arrival *arrivals)
{
    int n = 0;
    (void)joined;
    while (n < (int)LUM_SOCKET_BATCH &&
           receive_one(fd, buffers + (size_t)n * LUM_SOCKET_BYTES, &out[n]) ==
               0) {
        arrivals[n] = (lum_arrival){0};
        n++;
    }
    return n > 0 ? n : -1;
}

bool lum_system_joins(lum_system_handle fd)
{
    (void)fd;
    return false;
}

int lum_system_send(lum_system_handle fd, bool *joins,
                    const lum_outgoing *datagrams, size_t count)
{
    int n = 0;
    (void)joins;
    while ((size_t)n < count) {
        const struct sockaddr_in to = lum_sockaddr_of(datagrams[n].to);
        if (sendto(fd, datagrams[n].bytes, (send_size)datagrams[n].len, 0,
                   (const struct sockaddr *)&to, sizeof to) < 0) {
            break;
        }
        n++;
    }
    return n > 0 ? n : -1;
}
