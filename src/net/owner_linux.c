/* Names that one process at a time holds, on Linux: sockets with abstract
 * names. */
#define _GNU_SOURCE
#include "net/owner.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/* A listening socket with an abstract name: known in its network namespace, as
 * the sensor is, and gone with its last descriptor. */
typedef struct local_name {
    struct sockaddr_un address;
    socklen_t len;
} local_name;

static local_name name_of(const char *name)
{
    local_name out = {.address = {.sun_family = AF_UNIX}};
    const size_t room = sizeof out.address.sun_path - 1u;
    const int n =
        snprintf(out.address.sun_path + 1, room, "lumsdk/session/%.80s", name);
    const size_t used = n > 0 ? (size_t)n : 0;
    out.len = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1u + used);
    return out;
}

static int local_socket(void)
{
    return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

/* Whether somebody listens there, and who. The connection is never accepted:
 * when there is no room for more of them, only the second remains unknown. */
static bool ask_process(const local_name *name, long *process)
{
    struct ucred peer = {0};
    socklen_t len = sizeof peer;
    const int fd = local_socket();
    if (fd < 0) {
        return false;
    }
    const bool is_connected =
        connect(fd, (const struct sockaddr *)&name->address, name->len) == 0;
    const bool is_there = is_connected || errno == EAGAIN;
    if (is_connected &&
        getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &len) == 0) {
        *process = peer.pid;
    }
    (void)close(fd);
    return is_there;
}

lum_net_result lum_owner_system_hold(const char *name, intptr_t *held,
                                     long *process, lum_error *error)
{
    const local_name local = name_of(name);
    const int fd = local_socket();
    if (fd >= 0 &&
        bind(fd, (const struct sockaddr *)&local.address, local.len) == 0 &&
        listen(fd, SOMAXCONN) == 0) {
        *held = fd;
        return LUM_NET_OK;
    }
    const int code = errno;
    if (fd >= 0) {
        (void)close(fd);
    }
    if (code == EADDRINUSE) {
        (void)ask_process(&local, process);
        return LUM_NET_BUSY;
    }
    (void)lum_error_set(error,
                        "cannot mark the session with %s as taken by a local "
                        "socket: %s",
                        name, strerror(code));
    return LUM_NET_FAILED;
}

bool lum_owner_system_look(const char *name, long *process)
{
    const local_name local = name_of(name);
    return ask_process(&local, process);
}

void lum_owner_system_drop(intptr_t held)
{
    (void)close((int)held);
}
