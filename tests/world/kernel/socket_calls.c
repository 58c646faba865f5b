#define _GNU_SOURCE
#include "socket_calls.h"
#include "arp.h"
#include "net_internal.h"
#include "time.h"

#include <arpa/inet.h>
#include <errno.h>
#include <string.h>

/* What a call costs, and each further datagram of one call. */
#define CALL_NS WORLD_US
#define NEXT_NS (WORLD_US / 4)

static int refuse(int code)
{
    errno = code;
    return -1;
}

bool world_file_is_socket(const world_file *file)
{
    return file->kind->sendmsg != NULL;
}

/* NULL and EBADF or ENOTSOCK. To be released. */
static world_file *hold(int fd)
{
    world_file *file = world_fd_hold(fd);
    if (file != NULL && !world_file_is_socket(file)) {
        world_fd_release(file);
        errno = ENOTSOCK;
        return NULL;
    }
    return file;
}

/* A release must not change what a call has said. */
static ssize_t release(world_file *file, ssize_t result)
{
    const int kept = errno;
    world_fd_release(file);
    errno = kept;
    return result;
}

/* --- making --- */

static world_file *make(world_host *host, int domain, int type, int protocol,
                        int flags)
{
    if (domain == AF_INET && type == SOCK_DGRAM &&
        (protocol == 0 || protocol == IPPROTO_UDP)) {
        return world_udp_file(host, flags);
    }
    if (domain == AF_UNIX && type == SOCK_STREAM && protocol == 0) {
        return world_local_file(host, flags);
    }
    if (domain == AF_NETLINK && (type == SOCK_RAW || type == SOCK_DGRAM) &&
        protocol == 0) { /* NETLINK_ROUTE */
        return world_netlink_file(host, flags);
    }
    if (domain == AF_PACKET && type == SOCK_DGRAM &&
        world_net_rights_of(host)->is_root) {
        return world_packet_file(host, flags, ntohs((uint16_t)protocol));
    }
    /* Only root may look at the wire; the rest is not in this system. */
    errno = domain == AF_PACKET || type == SOCK_RAW ? EPERM : EAFNOSUPPORT;
    return NULL;
}

int world_call_socket(int domain, int type, int protocol)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    const int flags = O_RDWR | ((type & SOCK_NONBLOCK) != 0 ? O_NONBLOCK : 0);
    world_file *file =
        make(process->host, domain, type & ~(SOCK_NONBLOCK | SOCK_CLOEXEC),
             protocol, flags);
    return file == NULL
               ? -1
               : world_fd_take(process, file,
                               (type & SOCK_CLOEXEC) != 0 ? FD_CLOEXEC : 0);
}

int world_call_bind(int fd, const struct sockaddr *address, socklen_t size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file, file->kind->bind != NULL
                                  ? file->kind->bind(file, address, size)
                                  : refuse(EOPNOTSUPP));
}

int world_call_connect(int fd, const struct sockaddr *address, socklen_t size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file, file->kind->connect != NULL
                                  ? file->kind->connect(file, address, size)
                                  : refuse(EOPNOTSUPP));
}

int world_call_listen(int fd, int backlog)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file, file->kind->listen != NULL
                                  ? file->kind->listen(file, backlog)
                                  : refuse(EOPNOTSUPP));
}

/* Nothing that waits to be accepted is modelled. */
int world_call_accept(int fd, struct sockaddr *address, socklen_t *size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    (void)address;
    (void)size;
    return file == NULL ? -1 : (int)release(file, refuse(EOPNOTSUPP));
}

int world_call_shutdown(int fd, int how)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    (void)how;
    return file == NULL ? -1 : (int)release(file, refuse(ENOTCONN));
}

/* --- names and options --- */

int world_call_getsockname(int fd, struct sockaddr *out, socklen_t *size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file, file->kind->getsockname != NULL
                                  ? file->kind->getsockname(file, out, size)
                                  : refuse(EOPNOTSUPP));
}

int world_call_getpeername(int fd, struct sockaddr *out, socklen_t *size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    return file == NULL ? -1
                        : (int)release(file, world_peer_name(file, out, size));
}

int world_call_setsockopt(int fd, int level, int name, const void *value,
                          socklen_t size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file,
                        file->kind->setsockopt(file, level, name, value, size));
}

int world_call_getsockopt(int fd, int level, int name, void *value,
                          socklen_t *size)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    return (int)release(file,
                        file->kind->getsockopt(file, level, name, value, size));
}

/* --- sending --- */

/* A send to a peer that is gone raises SIGPIPE unless the flags say no; no
 * socket of this world sends to one. */
ssize_t world_call_sendmsg(int fd, const struct msghdr *message, int flags)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    return file == NULL
               ? -1
               : release(file, file->kind->sendmsg(file, message, flags));
}

static ssize_t send_to(int fd, const void *bytes, size_t size, int flags,
                       const struct sockaddr *to, socklen_t to_size)
{
    struct iovec part = {.iov_len = size};
    struct msghdr message = {
        .msg_namelen = to_size, .msg_iov = &part, .msg_iovlen = 1};
    world_file *file = hold(fd);
    /* It is only read, but its type does not say so. */
    memcpy(&part.iov_base, &bytes, sizeof bytes);
    memcpy(&message.msg_name, &to, sizeof(void *));
    return file == NULL
               ? -1
               : release(file, file->kind->sendmsg(file, &message, flags));
}

ssize_t world_call_sendto(int fd, const void *bytes, size_t size, int flags,
                          const struct sockaddr *to, socklen_t to_size)
{
    world_call(CALL_NS);
    return send_to(fd, bytes, size, flags, to, to_size);
}

ssize_t world_call_send(int fd, const void *bytes, size_t size, int flags)
{
    world_call(CALL_NS);
    return send_to(fd, bytes, size, flags, NULL, 0);
}

/* How many went; an error after the first one is told by the next call. */
static int send_all(world_file *file, struct mmsghdr *messages, unsigned count,
                    int flags)
{
    for (unsigned i = 0; i < count; i++) {
        const ssize_t n =
            file->kind->sendmsg(file, &messages[i].msg_hdr, flags);
        if (n < 0) {
            return i > 0 ? (int)i : -1;
        }
        messages[i].msg_len = (unsigned)n;
        world_spend(i > 0 ? NEXT_NS : 0);
    }
    return (int)count;
}

int world_call_sendmmsg(int fd, struct mmsghdr *messages, unsigned count,
                        int flags)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    return file == NULL
               ? -1
               : (int)release(file, send_all(file, messages, count, flags));
}

/* --- receiving --- */

ssize_t world_call_recvmsg(int fd, struct msghdr *message, int flags)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    return file == NULL
               ? -1
               : release(file, file->kind->recvmsg(file, message, flags));
}

static ssize_t receive_from(int fd, void *out, size_t size, int flags,
                            struct sockaddr *from, socklen_t *from_size)
{
    struct iovec part = {.iov_base = out, .iov_len = size};
    struct msghdr message = {
        .msg_name = from,
        .msg_namelen = from != NULL && from_size != NULL ? *from_size : 0,
        .msg_iov = &part,
        .msg_iovlen = 1};
    world_file *file = hold(fd);
    if (file == NULL) {
        return -1;
    }
    const ssize_t n = release(file, file->kind->recvmsg(file, &message, flags));
    if (n >= 0 && from != NULL && from_size != NULL) {
        *from_size = message.msg_namelen;
    }
    return n;
}

ssize_t world_call_recvfrom(int fd, void *out, size_t size, int flags,
                            struct sockaddr *from, socklen_t *from_size)
{
    world_call(CALL_NS);
    return receive_from(fd, out, size, flags, from, from_size);
}

ssize_t world_call_recv(int fd, void *out, size_t size, int flags)
{
    world_call(CALL_NS);
    return receive_from(fd, out, size, flags, NULL, NULL);
}

/* How many came. As Linux, the limit is looked at after each of them. */
static int receive_all(world_file *file, struct mmsghdr *messages,
                       unsigned count, int flags, const struct timespec *limit)
{
    const int64_t until =
        limit == NULL
            ? WORLD_NEVER
            : world_now() + (int64_t)limit->tv_sec * WORLD_S + limit->tv_nsec;
    for (unsigned i = 0; i < count; i++) {
        const ssize_t n = file->kind->recvmsg(file, &messages[i].msg_hdr,
                                              flags & ~MSG_WAITFORONE);
        if (n < 0) {
            return i > 0 ? (int)i : -1;
        }
        messages[i].msg_len = (unsigned)n;
        world_spend(i > 0 ? NEXT_NS : 0);
        if ((flags & MSG_WAITFORONE) != 0) {
            flags |= MSG_DONTWAIT;
        }
        if (world_now() >= until) {
            return (int)i + 1;
        }
    }
    return (int)count;
}

int world_call_recvmmsg(int fd, struct mmsghdr *messages, unsigned count,
                        int flags, struct timespec *limit)
{
    world_call(CALL_NS);
    world_file *file = hold(fd);
    return file == NULL ? -1
                        : (int)release(file, receive_all(file, messages, count,
                                                         flags, limit));
}
