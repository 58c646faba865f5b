#define _GNU_SOURCE
#include "arp.h"
#include "time.h"
#include "trace.h"
#include "udp.h"

#include <arpa/inet.h>
#include <errno.h>
#include <string.h>
#include <sys/time.h>

static ssize_t refuse(int code)
{
    errno = code;
    return -1;
}

/* A limit of the host's clock, in true time. */
static int64_t end_of(const world_host *host, int64_t wait_ns)
{
    return wait_ns == 0
               ? WORLD_NEVER
               : world_host_true_ns(host, world_host_mono_ns(host) + wait_ns);
}

/* 0: look again; -1 and errno. */
static int wait_for(world_file *file, int flags, int64_t until_ns)
{
    if (!world_file_waits(file) || (flags & MSG_DONTWAIT) != 0 ||
        world_task_self() == NULL) {
        return (int)refuse(EAGAIN);
    }
    switch (world_wait(file->changed, until_ns)) {
    case WORLD_WOKEN:
        return 0;
    case WORLD_TIMED_OUT:
        return (int)refuse(EAGAIN);
    case WORLD_INTERRUPTED:
        break;
    }
    return (int)refuse(EINTR);
}

/* --- sending --- */

typedef struct target {
    uint32_t address;
    uint16_t port;
} target;

/* 0, or an errno. */
static int find_target(const struct world_udp *udp,
                       const struct msghdr *message, target *out)
{
    struct sockaddr_in in;
    if (message->msg_name == NULL) {
        *out = (target){udp->peer, udp->peer_port};
        return udp->is_connected ? 0 : EDESTADDRREQ;
    }
    if (message->msg_namelen < sizeof in) {
        return EINVAL;
    }
    memcpy(&in, message->msg_name, sizeof in);
    if (in.sin_family != AF_INET && in.sin_family != AF_UNSPEC) {
        return EAFNOSUPPORT;
    }
    *out = (target){ntohl(in.sin_addr.s_addr), ntohs(in.sin_port)};
    return out->port == 0 ? EINVAL : 0;
}

static size_t size_of(const struct msghdr *message)
{
    size_t size = 0;
    for (size_t i = 0; i < message->msg_iovlen; i++) {
        size += message->msg_iov[i].iov_len;
    }
    return size;
}

static void gather(const struct msghdr *message, uint8_t *out)
{
    for (size_t i = 0; i < message->msg_iovlen; i++) {
        const struct iovec *part = &message->msg_iov[i];
        if (part->iov_len > 0) {
            memcpy(out, part->iov_base, part->iov_len);
            out += part->iov_len;
        }
    }
}

/* 0, or an errno. */
static int send_by_way(const struct world_udp *udp, world_datagram *datagram,
                       const world_way *way)
{
    datagram->private.is_broadcast = way->kind == WORLD_WAY_BROADCAST;
    if (way->kind == WORLD_WAY_LOCAL ||
        world_interface_is_loopback(way->interface)) {
        datagram->in_at = way->interface;
        world_datagram_send(datagram);
        world_packet_hear_datagram(world_interface_first(udp->host), datagram);
        world_udp_deliver(udp->host, datagram);
        return 0;
    }
    datagram->out_at = way->interface;
    return world_net_output(datagram, way->next_hop);
}

static ssize_t send_one(struct world_udp *udp, const struct msghdr *message,
                        target to, size_t size)
{
    world_way way;
    if (world_udp_find_way(udp, to.address, &way) != 0 ||
        world_udp_bind_any(udp) != 0) {
        return -1;
    }
    world_datagram *datagram = world_datagram_new(size);
    gather(message, datagram->bytes);
    datagram->from = udp->source != 0 ? udp->source : way.source;
    datagram->to = to.address != 0 ? to.address : way.next_hop;
    datagram->from_port = udp->port;
    datagram->to_port = to.port;
    datagram->sender = udp->log;
    const int code = send_by_way(udp, datagram, &way);
    if (code != 0) {
        world_datagram_free(datagram);
        /* Linux tells only those who ask for errors. */
        return udp->tells_errors ? refuse(code) : (ssize_t)size;
    }
    return (ssize_t)size;
}

ssize_t world_udp_sendmsg(world_file *file, const struct msghdr *message,
                          int flags)
{
    struct world_udp *udp = world_udp_of(file);
    const size_t size = size_of(message);
    const int64_t until = end_of(udp->host, udp->send_wait_ns);
    target to = {0, 0};
    if (size > WORLD_UDP_MAX) {
        return refuse(EMSGSIZE);
    }
    if ((flags & MSG_OOB) != 0) {
        return refuse(EOPNOTSUPP);
    }
    if (message->msg_controllen > 0) {
        world_fail("sendmsg() with control messages is not modelled");
        return refuse(EINVAL);
    }
    int code = find_target(udp, message, &to);
    if (code == 0) {
        code = world_udp_take_error(udp);
    }
    if (code != 0) {
        return refuse(code);
    }
    while (udp->log->queued >= udp->send_room) {
        world_met("net:send-buffer-full");
        if (wait_for(file, flags, until) != 0) {
            return -1;
        }
    }
    return send_one(udp, message, to, size);
}

/* --- receiving --- */

static void scatter(const world_datagram *datagram, const struct msghdr *to,
                    size_t *copied)
{
    size_t done = 0;
    for (size_t i = 0; i < to->msg_iovlen && done < datagram->len; i++) {
        const size_t left = datagram->len - done;
        const struct iovec *part = &to->msg_iov[i];
        const size_t n = part->iov_len < left ? part->iov_len : left;
        if (n > 0) {
            memcpy(part->iov_base, datagram->bytes + done, n);
        }
        done += n;
    }
    *copied = done;
}

/* Control messages as far as there is room; room is what is left of it. */
static void put_control(struct msghdr *message, size_t *used, int level,
                        int type, const void *value, size_t size)
{
    struct cmsghdr head;
    char *at = (char *)message->msg_control + *used;
    const size_t room = message->msg_controllen - *used;
    memset(&head, 0, sizeof head);
    if (room < CMSG_LEN(size)) {
        message->msg_flags |= MSG_CTRUNC;
        return;
    }
    head.cmsg_len = CMSG_LEN(size);
    head.cmsg_level = level;
    head.cmsg_type = type;
    memcpy(at, &head, sizeof head);
    memcpy(at + CMSG_LEN(0), value, size);
    *used += room < CMSG_SPACE(size) ? room : CMSG_SPACE(size);
}

static void put_time(const struct world_udp *udp, int64_t utc_ns,
                     struct msghdr *message, size_t *used)
{
    if (udp->tells_time) {
        const struct timespec at = {.tv_sec = (time_t)(utc_ns / WORLD_S),
                                    .tv_nsec = (long)(utc_ns % WORLD_S)};
        put_control(message, used, SOL_SOCKET, SCM_TIMESTAMPNS, &at, sizeof at);
    } else if (udp->tells_time_us) {
        const struct timeval at = {
            .tv_sec = (time_t)(utc_ns / WORLD_S),
            .tv_usec = (suseconds_t)(utc_ns % WORLD_S / WORLD_US)};
        put_control(message, used, SOL_SOCKET, SCM_TIMESTAMP, &at, sizeof at);
    }
}

static void put_controls(const struct world_udp *udp,
                         const world_datagram *datagram, struct msghdr *message)
{
    size_t used = 0;
    put_time(udp, datagram->private.utc_ns, message, &used);
    if (udp->tells_drops && datagram->private.drops != 0) {
        put_control(message, &used, SOL_SOCKET, SO_RXQ_OVFL,
                    &datagram->private.drops, sizeof datagram->private.drops);
    }
    if (udp->tells_packet) {
        const struct in_pktinfo info = {
            .ipi_ifindex = (int)datagram->in_at->index,
            .ipi_spec_dst = {htonl(
                datagram->private.is_broadcast
                    ? world_interface_source(datagram->in_at, datagram->from)
                    : datagram->to)},
            .ipi_addr = {htonl(datagram->to)}};
        put_control(message, &used, IPPROTO_IP, IP_PKTINFO, &info, sizeof info);
    }
    message->msg_controllen = used;
}

static void put_sender(const world_datagram *datagram, struct msghdr *message)
{
    struct sockaddr_in in;
    if (message->msg_name == NULL) {
        return;
    }
    memset(&in, 0, sizeof in);
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(datagram->from);
    in.sin_port = htons(datagram->from_port);
    world_put_address(message->msg_name, &message->msg_namelen, &in, sizeof in);
}

static void remove_first(struct world_udp *udp)
{
    world_datagram *datagram = udp->first;
    udp->first = datagram->private.next;
    if (udp->first == NULL) {
        udp->last = NULL;
    }
    udp->held -= datagram->private.truesize;
}

/* The sum is looked at when it is read: so poll() has spoken of nothing. */
void world_udp_drop_bad(struct world_udp *udp)
{
    while (udp->first != NULL && udp->first->is_bad) {
        world_datagram *datagram = udp->first;
        remove_first(udp);
        udp->drops++;
        world_met("net:checksum");
        world_datagram_end(datagram, WORLD_LOST_CHECKSUM);
    }
}

static ssize_t give(struct world_udp *udp, struct msghdr *message, int flags)
{
    world_datagram *datagram = udp->first;
    const world_process *process = world_process_self();
    const size_t len = datagram->len;
    size_t copied = 0;
    scatter(datagram, message, &copied);
    message->msg_flags = copied < len ? MSG_TRUNC : 0;
    put_sender(datagram, message);
    put_controls(udp, datagram, message);
    if ((flags & MSG_PEEK) == 0) {
        remove_first(udp);
        datagram->receiver_pid = process != NULL ? process->pid : 0;
        world_datagram_end(datagram, WORLD_RECEIVED);
    }
    return (ssize_t)((flags & MSG_TRUNC) != 0 ? len : copied);
}

ssize_t world_udp_recvmsg(world_file *file, struct msghdr *message, int flags)
{
    struct world_udp *udp = world_udp_of(file);
    const int64_t until = end_of(udp->host, udp->receive_wait_ns);
    if ((flags & MSG_ERRQUEUE) != 0) {
        return refuse(EAGAIN);
    }
    for (;;) {
        const int error = world_udp_take_error(udp);
        if (error != 0) {
            return refuse(error);
        }
        world_udp_drop_bad(udp);
        if (udp->first != NULL) {
            return give(udp, message, flags);
        }
        if (wait_for(file, flags, until) != 0) {
            return -1;
        }
    }
}
