#define _GNU_SOURCE
#include "net_internal.h"
#include "trace.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>

#define UID_OF_TOOLS 1000u /* disk.h: WORLD_UID */

/* Stream sockets with abstract names, known to their host. Connections are made
 * and counted; nobody accepts them, and nothing is sent through them. */
struct world_local {
    struct world_local *next; /* of the host's names */
    world_host *host;
    struct sockaddr_un name;
    socklen_t name_len; /* 0: none */
    bool listens;
    unsigned backlog, waiting;
    long pid;                   /* of who began to listen */
    struct world_local *peer;   /* whom it is connected to */
    long peer_pid;              /* 0: not connected */
    bool is_reset;              /* the other end is gone */
    struct world_local *others; /* connected to this one */
    struct world_local *next_other;
    world_file *file;
};

static int refuse(int code)
{
    errno = code;
    return -1;
}

static struct world_local *local_of(const world_file *file)
{
    return file->data;
}

static struct world_local *find(const world_host *host, const void *name,
                                socklen_t size)
{
    struct world_local *l = world_net_of(host)->locals;
    while (l != NULL &&
           (l->name_len != size || memcmp(&l->name, name, size) != 0)) {
        l = l->next;
    }
    return l;
}

/* 0, or an errno: only abstract names, which begin with a NUL, are known. */
static int check_name(const struct sockaddr *address, socklen_t size)
{
    char first = 0;
    const size_t at = offsetof(struct sockaddr_un, sun_path);
    if (size <= at || size > sizeof(struct sockaddr_un) ||
        address->sa_family != AF_UNIX) {
        return EINVAL;
    }
    memcpy(&first, (const char *)address + at, sizeof first);
    return first != '\0' ? EACCES : 0;
}

static int local_bind(world_file *file, const struct sockaddr *address,
                      socklen_t size)
{
    struct world_local *local = local_of(file);
    world_net_host *net = world_net_of(local->host);
    const int code = check_name(address, size);
    if (code != 0 || local->name_len != 0) {
        return refuse(code != 0 ? code : EINVAL);
    }
    if (find(local->host, address, size) != NULL) {
        return refuse(EADDRINUSE);
    }
    memcpy(&local->name, address, size);
    local->name_len = size;
    local->next = net->locals;
    net->locals = local;
    return 0;
}

static long self(void)
{
    const world_process *process = world_process_self();
    return process != NULL ? process->pid : 0;
}

static int local_listen(world_file *file, int backlog)
{
    struct world_local *local = local_of(file);
    if (local->name_len == 0) {
        return refuse(EINVAL);
    }
    local->listens = true;
    local->backlog = backlog < 0 ? SOMAXCONN : (unsigned)backlog;
    local->pid = self();
    return 0;
}

static int local_connect(world_file *file, const struct sockaddr *address,
                         socklen_t size)
{
    struct world_local *local = local_of(file);
    const int code = check_name(address, size);
    if (code != 0) {
        return refuse(code == EACCES ? ENOENT : code);
    }
    if (local->peer_pid != 0) {
        return refuse(EISCONN);
    }
    struct world_local *other = find(local->host, address, size);
    if (other == NULL || !other->listens) {
        return refuse(ECONNREFUSED);
    }
    while (other->waiting > other->backlog) {
        if (!world_file_waits(file)) {
            return refuse(EAGAIN);
        }
        if (world_wait(other->file->changed, INT64_MAX) == WORLD_INTERRUPTED) {
            return refuse(EINTR);
        }
        other = find(local->host, address, size);
        if (other == NULL || !other->listens) {
            return refuse(ECONNREFUSED);
        }
    }
    local->peer = other;
    local->peer_pid = other->pid;
    local->next_other = other->others;
    other->others = local;
    other->waiting++;
    world_wake_all(other->file->changed);
    return 0;
}

static int local_getsockname(world_file *file, struct sockaddr *out,
                             socklen_t *size)
{
    const struct world_local *local = local_of(file);
    const sa_family_t family = AF_UNIX;
    if (local->name_len == 0) {
        world_put_address(out, size, &family, sizeof family);
    } else {
        world_put_address(out, size, &local->name, local->name_len);
    }
    return 0;
}

/* Those that are known and change nothing here. */
static int local_setsockopt(world_file *file, int level, int name,
                            const void *value, socklen_t size)
{
    (void)file;
    (void)value;
    (void)size;
    return level == SOL_SOCKET && (name == SO_RCVBUF || name == SO_SNDBUF ||
                                   name == SO_RCVTIMEO || name == SO_SNDTIMEO)
               ? 0
               : refuse(ENOPROTOOPT);
}

static int local_getsockopt(world_file *file, int level, int name, void *value,
                            socklen_t *size)
{
    const struct world_local *local = local_of(file);
    struct ucred who = {0, (uid_t)-1, (gid_t)-1};
    if (level != SOL_SOCKET || name != SO_PEERCRED) {
        return refuse(ENOPROTOOPT);
    }
    if (local->peer_pid != 0 || local->listens) {
        who = (struct ucred){
            (pid_t)(local->listens ? local->pid : local->peer_pid),
            UID_OF_TOOLS, UID_OF_TOOLS};
    }
    *size = *size < sizeof who ? *size : (socklen_t)sizeof who;
    memcpy(value, &who, *size);
    return 0;
}

static short local_poll(world_file *file)
{
    const struct world_local *local = local_of(file);
    if (local->is_reset) {
        return POLLIN | POLLRDNORM | POLLOUT | POLLERR | POLLHUP;
    }
    if (local->listens) {
        return local->waiting > 0 ? POLLIN | POLLRDNORM : 0;
    }
    return local->peer_pid != 0 ? POLLOUT | POLLWRNORM
                                : POLLOUT | POLLWRNORM | POLLHUP;
}

static ssize_t local_sendmsg(world_file *file, const struct msghdr *message,
                             int flags)
{
    const struct world_local *local = local_of(file);
    (void)message;
    (void)flags;
    if (local->is_reset) {
        return refuse(EPIPE);
    }
    if (local->peer_pid == 0) {
        return refuse(ENOTCONN);
    }
    world_fail("a local socket is sent data: this is not modelled");
    return refuse(EAGAIN);
}

static ssize_t local_recvmsg(world_file *file, struct msghdr *message,
                             int flags)
{
    struct world_local *local = local_of(file);
    (void)message;
    if (local->listens || (local->peer_pid == 0 && !local->is_reset)) {
        return refuse(EINVAL);
    }
    while (!local->is_reset) {
        if (!world_file_waits(file) || (flags & MSG_DONTWAIT) != 0) {
            return refuse(EAGAIN);
        }
        if (world_wait(file->changed, INT64_MAX) == WORLD_INTERRUPTED) {
            return refuse(EINTR);
        }
    }
    return refuse(ECONNRESET);
}

static int local_ioctl(world_file *file, unsigned long request, void *argument)
{
    return world_socket_ioctl(local_of(file)->host, request, argument);
}

/* Those that nobody accepted are reset. */
static void leave_others(struct world_local *local)
{
    while (local->others != NULL) {
        struct world_local *other = local->others;
        local->others = other->next_other;
        other->peer = NULL;
        other->is_reset = true;
        world_wake_all(other->file->changed);
    }
}

static void leave_peer(struct world_local *local)
{
    if (local->peer == NULL) {
        return;
    }
    struct world_local **at = &local->peer->others;
    while (*at != local) {
        at = &(*at)->next_other;
    }
    *at = local->next_other;
}

static void local_close(world_file *file)
{
    struct world_local *local = local_of(file);
    struct world_local **at = &world_net_of(local->host)->locals;
    leave_others(local);
    leave_peer(local);
    while (*at != NULL && *at != local) {
        at = &(*at)->next;
    }
    if (*at != NULL) {
        *at = local->next;
    }
    free(local);
}

static const world_file_kind local_kind = {
    .name = "local socket",
    .poll = local_poll,
    .ioctl = local_ioctl,
    .bind = local_bind,
    .connect = local_connect,
    .listen = local_listen,
    .getsockname = local_getsockname,
    .setsockopt = local_setsockopt,
    .getsockopt = local_getsockopt,
    .sendmsg = local_sendmsg,
    .recvmsg = local_recvmsg,
    .close = local_close,
};

world_file *world_local_file(world_host *host, int flags)
{
    struct world_local *local = calloc(1, sizeof *local);
    if (local == NULL) {
        abort();
    }
    local->host = host;
    local->file = world_file_new(&local_kind, flags, local);
    return local->file;
}
