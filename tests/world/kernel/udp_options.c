#define _GNU_SOURCE
#include "trace.h"
#include "udp.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <string.h>
#include <sys/time.h>

#define ROOM_MIN      2304u /* of Linux */
#define SEND_ROOM_MIN 4608u
#define NS_PER_S      INT64_C(1000000000)

#ifndef SO_MEMINFO
#define SO_MEMINFO 55
#endif

static int refuse(int code)
{
    errno = code;
    return -1;
}

/* --- setting --- */

/* Twice what is asked, as Linux counts. */
static uint32_t room_for(int asked, uint32_t most, uint32_t least)
{
    const uint32_t wish = asked < 0 ? most : (uint32_t)asked;
    const uint32_t room = 2u * (wish < most ? wish : most);
    return room > least ? room : least;
}

static int set_room(struct world_udp *udp, int name, int value)
{
    const world_net_rights *rights = world_net_rights_of(udp->host);
    const bool is_forced = name == SO_RCVBUFFORCE || name == SO_SNDBUFFORCE;
    const uint32_t most = is_forced ? INT32_MAX / 2 : 0;
    if (is_forced && !rights->is_root) {
        return refuse(EPERM);
    }
    if (name == SO_RCVBUF || name == SO_RCVBUFFORCE) {
        udp->receive_room =
            room_for(value, is_forced ? most : rights->receive_max, ROOM_MIN);
    } else {
        udp->send_room =
            room_for(value, is_forced ? most : rights->send_max, SEND_ROOM_MIN);
    }
    return 0;
}

/* Of a value that ends at its NUL or its size. */
static int set_device(struct world_udp *udp, const void *value, socklen_t size)
{
    const world_net_rights *rights = world_net_rights_of(udp->host);
    char name[IFNAMSIZ] = "";
    memcpy(name, value, size < sizeof name ? size : sizeof name - 1u);
    const world_interface *device = world_interface_find(udp->host, name);
    if (!rights->is_root && (!rights->may_bind_device || udp->device != NULL)) {
        return refuse(EPERM);
    }
    if (name[0] != '\0' && device == NULL) {
        return refuse(ENODEV);
    }
    udp->device = device;
    return 0;
}

static int set_limit(int64_t *out, const void *value, socklen_t size)
{
    struct timeval limit;
    if (size < sizeof limit) {
        return refuse(EINVAL);
    }
    memcpy(&limit, value, sizeof limit);
    if (limit.tv_usec < 0 || limit.tv_usec >= 1000000) {
        return refuse(EDOM);
    }
    *out = limit.tv_sec < 0
               ? 0
               : (int64_t)limit.tv_sec * NS_PER_S + limit.tv_usec * 1000;
    return 0;
}

static bool *socket_flag(struct world_udp *udp, int name)
{
    switch (name) {
    case SO_REUSEADDR:
        return &udp->reuses_address;
    case SO_REUSEPORT:
        return &udp->reuses_port;
    case SO_BROADCAST:
        return &udp->may_broadcast;
    case SO_TIMESTAMPNS:
        return &udp->tells_time;
    case SO_TIMESTAMP:
        return &udp->tells_time_us;
    case SO_RXQ_OVFL:
        return &udp->tells_drops;
    default:
        return NULL;
    }
}

static bool *ip_flag(struct world_udp *udp, int name)
{
    switch (name) {
    case IP_PKTINFO:
        return &udp->tells_packet;
    case IP_RECVERR:
        return &udp->tells_errors;
    case IP_FREEBIND:
        return &udp->is_free;
    default:
        return NULL;
    }
}

static int read_int(const void *value, socklen_t size, int *out)
{
    if (size < sizeof *out) {
        return refuse(EINVAL);
    }
    memcpy(out, value, sizeof *out);
    return 0;
}

static int set_socket(struct world_udp *udp, int name, const void *value,
                      socklen_t size)
{
    int number = 0;
    if (name == SO_BINDTODEVICE) {
        return set_device(udp, value, size);
    }
    if (name == SO_RCVTIMEO || name == SO_SNDTIMEO) {
        return set_limit(name == SO_RCVTIMEO ? &udp->receive_wait_ns
                                             : &udp->send_wait_ns,
                         value, size);
    }
    if (read_int(value, size, &number) != 0) {
        return -1;
    }
    bool *flag = socket_flag(udp, name);
    if (flag != NULL) {
        *flag = number != 0;
        return 0;
    }
    if (name == SO_RCVBUF || name == SO_RCVBUFFORCE || name == SO_SNDBUF ||
        name == SO_SNDBUFFORCE) {
        return set_room(udp, name, number);
    }
    return refuse(ENOPROTOOPT);
}

/* The index in network order. */
static int set_send_by(struct world_udp *udp, int wire)
{
    const unsigned index = ntohl((uint32_t)wire);
    const world_interface *by =
        index != 0 ? world_interface_by_index(udp->host, index) : NULL;
    if (index != 0 && by == NULL) {
        return refuse(EADDRNOTAVAIL);
    }
    if (udp->device != NULL && by != NULL && by != udp->device) {
        return refuse(EINVAL);
    }
    udp->send_by = by;
    return 0;
}

static int set_ip(struct world_udp *udp, int name, const void *value,
                  socklen_t size)
{
    int number = 0;
    bool *flag = ip_flag(udp, name);
    if (read_int(value, size, &number) != 0) {
        return -1;
    }
    if (flag != NULL) {
        *flag = number != 0;
        return 0;
    }
    return name == IP_UNICAST_IF ? set_send_by(udp, number)
                                 : refuse(ENOPROTOOPT);
}

int world_udp_setsockopt(world_file *file, int level, int name,
                         const void *value, socklen_t size)
{
    if (level == SOL_SOCKET) {
        return set_socket(world_udp_of(file), name, value, size);
    }
    return level == IPPROTO_IP ? set_ip(world_udp_of(file), name, value, size)
                               : refuse(ENOPROTOOPT);
}

/* --- getting --- */

static int put(void *out, socklen_t *size, const void *value, socklen_t len)
{
    *size = *size < len ? *size : len;
    memcpy(out, value, *size);
    return 0;
}

static int put_int(void *out, socklen_t *size, int value)
{
    return put(out, size, &value, sizeof value);
}

static int get_memory(const struct world_udp *udp, void *out, socklen_t *size)
{
    uint32_t values[SK_MEMINFO_VARS] = {0};
    values[SK_MEMINFO_RMEM_ALLOC] = udp->held;
    values[SK_MEMINFO_RCVBUF] = udp->receive_room;
    values[SK_MEMINFO_WMEM_ALLOC] = udp->log->queued;
    values[SK_MEMINFO_SNDBUF] = udp->send_room;
    values[SK_MEMINFO_DROPS] = udp->drops;
    return put(out, size, values, sizeof values);
}

static int get_limit(int64_t limit_ns, void *out, socklen_t *size)
{
    const struct timeval limit = {
        .tv_sec = (time_t)(limit_ns / NS_PER_S),
        .tv_usec = (suseconds_t)(limit_ns % NS_PER_S / 1000)};
    return put(out, size, &limit, sizeof limit);
}

static int get_device(const struct world_udp *udp, void *out, socklen_t *size)
{
    if (udp->device == NULL) {
        *size = 0;
        return 0;
    }
    if (*size < IFNAMSIZ) {
        return refuse(EINVAL);
    }
    return put(out, size, udp->device->name,
               (socklen_t)strlen(udp->device->name) + 1u);
}

static int get_number(struct world_udp *udp, int name, int *out)
{
    const bool *flag = socket_flag(udp, name);
    if (flag != NULL) {
        *out = *flag;
        return 0;
    }
    switch (name) {
    case SO_TYPE:
        *out = SOCK_DGRAM;
        return 0;
    case SO_DOMAIN:
        *out = AF_INET;
        return 0;
    case SO_PROTOCOL:
        *out = IPPROTO_UDP;
        return 0;
    case SO_ERROR:
        *out = world_udp_take_error(udp);
        return 0;
    case SO_RCVBUF:
        *out = (int)udp->receive_room;
        return 0;
    case SO_SNDBUF:
        *out = (int)udp->send_room;
        return 0;
    default:
        return refuse(ENOPROTOOPT);
    }
}

static int get_socket(struct world_udp *udp, int name, void *value,
                      socklen_t *size)
{
    int number = 0;
    switch (name) {
    case SO_MEMINFO:
        return get_memory(udp, value, size);
    case SO_BINDTODEVICE:
        return get_device(udp, value, size);
    case SO_RCVTIMEO:
        return get_limit(udp->receive_wait_ns, value, size);
    case SO_SNDTIMEO:
        return get_limit(udp->send_wait_ns, value, size);
    default:
        return get_number(udp, name, &number) == 0
                   ? put_int(value, size, number)
                   : -1;
    }
}

static int get_ip(struct world_udp *udp, int name, void *value, socklen_t *size)
{
    const bool *flag = ip_flag(udp, name);
    if (flag != NULL) {
        return put_int(value, size, *flag);
    }
    if (name == IP_UNICAST_IF) {
        const uint32_t index = udp->send_by != NULL ? udp->send_by->index : 0;
        return put_int(value, size, (int)htonl(index));
    }
    return refuse(ENOPROTOOPT);
}

int world_udp_getsockopt(world_file *file, int level, int name, void *value,
                         socklen_t *size)
{
    if (level == SOL_SOCKET) {
        return get_socket(world_udp_of(file), name, value, size);
    }
    return level == IPPROTO_IP ? get_ip(world_udp_of(file), name, value, size)
                               : refuse(ENOPROTOOPT);
}
