#define _GNU_SOURCE
#include "net_internal.h"
#include "trace.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <stdlib.h>
#include <string.h>

/* The one question that is answered: which way leads to an address, see
 * rtnetlink(7), RTM_GETROUTE. */

#define REPLY_BYTES 256u

struct world_netlink {
    world_host *host;
    uint8_t reply[REPLY_BYTES];
    size_t len; /* 0: none */
};

static ssize_t refuse(int code)
{
    errno = code;
    return -1;
}

static struct world_netlink *netlink_of(const world_file *file)
{
    return file->data;
}

/* --- the answer --- */

static void put_u32(struct world_netlink *n, unsigned short type,
                    uint32_t value)
{
    const struct rtattr head = {RTA_LENGTH(sizeof value), type};
    memcpy(n->reply + n->len, &head, sizeof head);
    memcpy(n->reply + n->len + sizeof head, &value, sizeof value);
    n->len += RTA_SPACE(sizeof value);
}

static void finish(struct world_netlink *n, const struct nlmsghdr *request,
                   unsigned short type)
{
    const struct nlmsghdr head = {.nlmsg_len = (uint32_t)n->len,
                                  .nlmsg_type = type,
                                  .nlmsg_seq = request->nlmsg_seq};
    memcpy(n->reply, &head, sizeof head);
}

static void put_error(struct world_netlink *n, const struct nlmsghdr *request,
                      int code)
{
    struct nlmsgerr error;
    memset(&error, 0, sizeof error);
    error.error = -code;
    error.msg = *request;
    memcpy(n->reply + NLMSG_HDRLEN, &error, sizeof error);
    n->len = NLMSG_LENGTH(sizeof error);
    finish(n, request, NLMSG_ERROR);
}

typedef struct question {
    uint32_t to;
    const world_interface *by;
    bool wants_entry; /* of the table, and not the way itself */
} question;

static unsigned char type_of(const world_way *way)
{
    switch (way->kind) {
    case WORLD_WAY_LOCAL:
        return RTN_LOCAL;
    case WORLD_WAY_BROADCAST:
        return RTN_BROADCAST;
    case WORLD_WAY_LINK:
        break;
    }
    return RTN_UNICAST;
}

static void put_way(struct world_netlink *n, const question *asked,
                    const world_way *way)
{
    const bool has_entry = asked->wants_entry && way->route != NULL;
    const unsigned prefix = has_entry ? way->route->prefix : 32u;
    const bool is_local = way->kind == WORLD_WAY_LOCAL;
    struct rtmsg route;
    memset(&route, 0, sizeof route);
    route.rtm_family = AF_INET;
    route.rtm_dst_len = (unsigned char)prefix;
    route.rtm_table = RT_TABLE_MAIN;
    route.rtm_type = type_of(way);
    memcpy(n->reply + NLMSG_HDRLEN, &route, sizeof route);
    n->len = NLMSG_SPACE(sizeof route);
    if (prefix > 0) {
        put_u32(n, RTA_DST, htonl(asked->to & world_mask(prefix)));
    }
    put_u32(n, RTA_OIF, is_local ? 1u : way->interface->index);
    if (!has_entry || way->route->source != 0) {
        put_u32(n, RTA_PREFSRC, htonl(way->source));
    }
    if (way->route != NULL && way->route->gateway != 0) {
        put_u32(n, RTA_GATEWAY, htonl(way->route->gateway));
    }
}

/* --- the question --- */

static void read_attributes(const struct world_netlink *n, const uint8_t *at,
                            size_t left, question *out)
{
    struct rtattr head;
    uint32_t value = 0;
    while (left >= sizeof head) {
        memcpy(&head, at, sizeof head);
        if (head.rta_len < sizeof head || head.rta_len > left) {
            return;
        }
        if (head.rta_len == RTA_LENGTH(sizeof value)) {
            memcpy(&value, at + sizeof head, sizeof value);
        }
        if (head.rta_type == RTA_DST) {
            out->to = ntohl(value);
        } else if (head.rta_type == RTA_OIF) {
            out->by = world_interface_by_index(n->host, value);
        }
        const size_t step = RTA_ALIGN(head.rta_len);
        at += step < left ? step : left;
        left -= step < left ? step : left;
    }
}

static void answer(struct world_netlink *n, const uint8_t *bytes, size_t len)
{
    struct nlmsghdr head;
    struct rtmsg route;
    question asked = {0, NULL, false};
    world_way way;
    memcpy(&head, bytes, sizeof head);
    if (head.nlmsg_type != RTM_GETROUTE || head.nlmsg_len > len ||
        head.nlmsg_len < NLMSG_LENGTH(sizeof route)) {
        put_error(n, &head, EOPNOTSUPP);
        return;
    }
    memcpy(&route, bytes + NLMSG_HDRLEN, sizeof route);
    asked.wants_entry = (route.rtm_flags & RTM_F_FIB_MATCH) != 0;
    read_attributes(n, bytes + NLMSG_LENGTH(sizeof route),
                    head.nlmsg_len - NLMSG_LENGTH(sizeof route), &asked);
    int code = world_way_find(n->host, asked.to, 0, asked.by, &way);
    if (code == 0 && asked.wants_entry && way.route == NULL &&
        way.kind == WORLD_WAY_LINK) {
        code = EHOSTUNREACH;
    }
    if (code != 0) {
        put_error(n, &head, code);
        return;
    }
    put_way(n, &asked, &way);
    finish(n, &head, RTM_NEWROUTE);
}

/* --- the file --- */

static ssize_t netlink_sendmsg(world_file *file, const struct msghdr *message,
                               int flags)
{
    struct world_netlink *n = netlink_of(file);
    (void)flags;
    if (message->msg_iovlen != 1 ||
        message->msg_iov[0].iov_len < sizeof(struct nlmsghdr)) {
        return refuse(EINVAL);
    }
    answer(n, message->msg_iov[0].iov_base, message->msg_iov[0].iov_len);
    world_wake_all(file->changed);
    return (ssize_t)message->msg_iov[0].iov_len;
}

static ssize_t netlink_recvmsg(world_file *file, struct msghdr *message,
                               int flags)
{
    struct world_netlink *n = netlink_of(file);
    (void)flags;
    if (n->len == 0) {
        return refuse(EAGAIN); /* each question was answered at once */
    }
    if (message->msg_iovlen != 1) {
        return refuse(EINVAL);
    }
    const struct iovec *part = &message->msg_iov[0];
    const size_t copied = part->iov_len < n->len ? part->iov_len : n->len;
    memcpy(part->iov_base, n->reply, copied);
    message->msg_flags = copied < n->len ? MSG_TRUNC : 0;
    message->msg_controllen = 0;
    n->len = 0;
    return (ssize_t)copied;
}

static int netlink_bind(world_file *file, const struct sockaddr *address,
                        socklen_t size)
{
    (void)file;
    (void)address;
    return size < sizeof(struct sockaddr_nl) ? (int)refuse(EINVAL) : 0;
}

static int netlink_setsockopt(world_file *file, int level, int name,
                              const void *value, socklen_t size)
{
    (void)file;
    (void)value;
    (void)size;
    return level == SOL_SOCKET && (name == SO_RCVTIMEO || name == SO_SNDTIMEO)
               ? 0
               : (int)refuse(ENOPROTOOPT);
}

static int netlink_getsockopt(world_file *file, int level, int name,
                              void *value, socklen_t *size)
{
    (void)file;
    (void)level;
    (void)name;
    (void)value;
    (void)size;
    return (int)refuse(ENOPROTOOPT);
}

static short netlink_poll(world_file *file)
{
    return (short)(netlink_of(file)->len > 0
                       ? POLLIN | POLLRDNORM | POLLOUT | POLLWRNORM
                       : POLLOUT | POLLWRNORM);
}

static void netlink_close(world_file *file)
{
    free(file->data);
}

static const world_file_kind netlink_kind = {
    .name = "netlink",
    .poll = netlink_poll,
    .bind = netlink_bind,
    .setsockopt = netlink_setsockopt,
    .getsockopt = netlink_getsockopt,
    .sendmsg = netlink_sendmsg,
    .recvmsg = netlink_recvmsg,
    .close = netlink_close,
};

world_file *world_netlink_file(world_host *host, int flags)
{
    struct world_netlink *n = calloc(1, sizeof *n);
    if (n == NULL) {
        abort();
    }
    n->host = host;
    return world_file_new(&netlink_kind, flags, n);
}
