#include "net/sockaddr.h"

#include "base/sized.h"
#include "lum/base/time.h"
#include "net/adapter.h"
#include "net/cancel_handle.h"
#include "net/socket_messages.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_MS INT64_C(1000000)

/* Holds a few full batches, where the system's default may not hold one. */
#define SEND_BUFFER (4 * 1024 * 1024)

/* Errors of datagrams sent earlier that one receive skips. */
#define PENDING_ERRORS 16

/* Older headers lack the name. */
#ifndef IP_UNICAST_IF
#define IP_UNICAST_IF 31
#endif

struct lum_socket {
    SOCKET handle;
    lum_endpoint local;
    size_t receive_buffer;
    bool has_room;
    lum_received received[LUM_SOCKET_BATCH];
    uint8_t bytes[LUM_SOCKET_BATCH * LUM_SOCKET_BYTES];
};

static void set_number(SOCKET handle, int level, int name, int value)
{
    (void)setsockopt(handle, level, name, (const char *)&value, sizeof value);
}

static void grow(lum_socket *socket, size_t bytes)
{
    int granted = 0;
    int len = sizeof granted;
    if (bytes != 0) {
        set_number(socket->handle, SOL_SOCKET, SO_RCVBUF,
                   (int)(bytes < INT_MAX ? bytes : INT_MAX));
    }
    if (getsockopt(socket->handle, SOL_SOCKET, SO_RCVBUF, (char *)&granted,
                   &len) != 0 ||
        granted < 0) {
        granted = 0;
    }
    socket->receive_buffer = (size_t)granted;
    socket->has_room = (size_t)granted >= bytes;
}

/* Sent there, and bound to its address. */
static lum_net_result use_interface(const lum_socket *socket, const char *name,
                                    lum_endpoint *local, lum_error *error)
{
    lum_adapter adapter;
    char list[256];
    if (!lum_adapter_find(name, local->address, &adapter)) {
        lum_adapter_list(list, sizeof list);
        return lum_socket_say_no_interface(name, list, error);
    }
    if (adapter.address == 0) {
        (void)lum_error_set(error,
                            "cannot use interface %s: it has no IPv4 address; "
                            "give it one in the sensor's network",
                            name);
        return LUM_NET_FAILED;
    }
    set_number(socket->handle, IPPROTO_IP, IP_UNICAST_IF,
               (int)htonl(adapter.index));
    local->address = local->address != 0 ? local->address : adapter.address;
    return LUM_NET_OK;
}

static lum_net_result bind_local(lum_socket *socket, lum_endpoint local,
                                 lum_error *error)
{
    struct sockaddr_in address = lum_sockaddr_of(local);
    int len = sizeof address;
    if (bind(socket->handle, (const struct sockaddr *)&address, len) != 0 ||
        getsockname(socket->handle, (struct sockaddr *)&address, &len) != 0) {
        return lum_socket_say_unbound(local, lum_winsock_errno(), error);
    }
    socket->local = lum_sockaddr_endpoint(&address);
    return LUM_NET_OK;
}

static lum_net_result set_up(lum_socket *socket,
                             const lum_socket_options *options,
                             lum_error *error)
{
    lum_endpoint local = options->local;
    set_number(socket->handle, SOL_SOCKET, SO_EXCLUSIVEADDRUSE, 1);
    set_number(socket->handle, SOL_SOCKET, SO_SNDBUF, SEND_BUFFER);
    grow(socket, options->receive_buffer);
    if (options->interface_name != NULL) {
        const lum_net_result result =
            use_interface(socket, options->interface_name, &local, error);
        if (result != LUM_NET_OK) {
            return result;
        }
    }
    return bind_local(socket, local, error);
}

static lum_net_result open_started(const lum_socket_options *options,
                                   lum_socket **out, lum_error *error)
{
    lum_socket *socket = malloc(sizeof *socket);
    if (socket == NULL) {
        (void)lum_error_set(error, "no memory left for a socket");
        return LUM_NET_FAILED;
    }
    socket->handle = lum_winsock_udp(error);
    const lum_net_result result = socket->handle == INVALID_SOCKET
                                      ? LUM_NET_FAILED
                                      : set_up(socket, options, error);
    if (result != LUM_NET_OK) {
        (void)closesocket(socket->handle);
        free(socket);
        return result;
    }
    *out = socket;
    return LUM_NET_OK;
}

lum_net_result lum_socket_open(const lum_socket_options *options,
                               lum_socket **out, lum_error *error)
{
    lum_socket_options known;
    if (lum_sized_take(&known, sizeof known, options, "the socket's options",
                       "lum_socket_options", error) != 0 ||
        lum_winsock_start(error) != 0) {
        return LUM_NET_FAILED;
    }
    const lum_net_result result = open_started(&known, out, error);
    if (result != LUM_NET_OK) {
        lum_winsock_stop();
    }
    return result;
}

void lum_socket_close(lum_socket *socket)
{
    if (socket != NULL) {
        (void)closesocket(socket->handle);
        free(socket);
        lum_winsock_stop();
    }
}

void lum_socket_local(const lum_socket *socket, lum_endpoint *out)
{
    *out = socket->local;
}

size_t lum_socket_receive_buffer(const lum_socket *socket)
{
    return socket->receive_buffer;
}

bool lum_socket_has_room(const lum_socket *socket)
{
    return socket->has_room;
}

uint64_t lum_socket_joined(const lum_socket *socket)
{
    (void)socket;
    return 0;
}

uint64_t lum_socket_drops(lum_socket *socket)
{
    (void)socket;
    return 0;
}

bool lum_socket_counts_drops(const lum_socket *socket)
{
    (void)socket;
    return false;
}

/* Milliseconds that are left, rounded up. */
static int left_until(int64_t deadline_ns)
{
    const int64_t now = lum_time_monotonic_ns();
    if (deadline_ns <= now) {
        return 0;
    }
    const int64_t left_ms = (deadline_ns - now - 1) / NS_PER_MS + 1;
    return (int)(left_ms < INT_MAX ? left_ms : INT_MAX);
}

/* A poll without sockets is refused, so it is replaced by a sleep. */
static int poll_some(WSAPOLLFD *set, ULONG count, int64_t deadline_ns)
{
    if (count == 0) {
        lum_time_sleep_until(deadline_ns);
        return 0;
    }
    return WSAPoll(set, count, left_until(deadline_ns));
}

static lum_net_result poll_until(WSAPOLLFD *set, ULONG count, bool cancellable,
                                 int64_t deadline_ns)
{
    for (;;) {
        const int ready = poll_some(set, count, deadline_ns);
        if (ready > 0) {
            return cancellable && set[0].revents != 0 ? LUM_NET_CANCELLED
                                                      : LUM_NET_OK;
        }
        if (ready < 0) {
            return LUM_NET_FAILED;
        }
        if (deadline_ns <= lum_time_monotonic_ns()) {
            return LUM_NET_TIMEOUT;
        }
    }
}

lum_net_result lum_socket_wait(lum_socket *const *sockets, size_t count,
                               int extra_fd, const lum_cancel *cancel,
                               int64_t deadline_ns)
{
    WSAPOLLFD set[LUM_SOCKET_WAIT_MAX + 1u];
    ULONG used = 0;
    (void)extra_fd;
    if (count > LUM_SOCKET_WAIT_MAX) {
        return LUM_NET_FAILED;
    }
    if (cancel != NULL) {
        set[used++] = (WSAPOLLFD){.fd = (SOCKET)lum_cancel_handle(cancel),
                                  .events = POLLIN};
    }
    for (size_t i = 0; i < count; i++) {
        set[used++] = (WSAPOLLFD){.fd = sockets[i]->handle, .events = POLLIN};
    }
    return poll_until(set, used, cancel != NULL, deadline_ns);
}

/* 0, or -1 and the code. */
static int receive_one(lum_socket *socket, size_t n, int *code)
{
    struct sockaddr_in peer = {0};
    int peer_len = sizeof peer;
    uint8_t *buffer = socket->bytes + n * LUM_SOCKET_BYTES;
    int len = recvfrom(socket->handle, (char *)buffer, (int)LUM_SOCKET_BYTES, 0,
                       (struct sockaddr *)&peer, &peer_len);
    *code = len < 0 ? lum_winsock_errno() : 0;
    if (len < 0 && *code != EMSGSIZE) {
        return -1;
    }
    socket->received[n] = (lum_received){
        .bytes = buffer,
        .len = len < 0 ? LUM_SOCKET_BYTES : (size_t)len,
        .from = lum_sockaddr_endpoint(&peer),
        .utc_ns = lum_time_utc_ns(),
        .cut_short = len < 0,
    };
    return 0;
}

/* All other errors are of a datagram sent earlier, or temporary. */
static bool is_broken(int code)
{
    return code == ENOTSOCK || code == EINVAL || code == EFAULT;
}

lum_net_result lum_socket_receive(lum_socket *socket, lum_received **out,
                                  size_t *count, lum_error *error)
{
    int errors = 0;
    int code = 0;
    *out = socket->received;
    *count = 0;
    while (*count < LUM_SOCKET_BATCH && errors < PENDING_ERRORS) {
        if (receive_one(socket, *count, &code) == 0) {
            ++*count;
        } else if (code == EAGAIN) {
            break;
        } else if (is_broken(code)) {
            return lum_socket_say_broken(socket->local, code, error);
        } else {
            errors++;
        }
    }
    return LUM_NET_OK;
}

lum_net_result lum_socket_send(lum_socket *socket, const lum_outgoing *datagram,
                               lum_error *error)
{
    const struct sockaddr_in to = lum_sockaddr_of(datagram->to);
    const int most = INT_MAX;
    const int len =
        (int)(datagram->len < INT_MAX ? datagram->len : (size_t)most);
    if (sendto(socket->handle, datagram->bytes, len, 0,
               (const struct sockaddr *)&to, sizeof to) < 0) {
        return lum_socket_say_unsent(datagram, lum_winsock_errno(), error);
    }
    return LUM_NET_OK;
}

lum_net_result lum_socket_send_batch(lum_socket *socket,
                                     const lum_outgoing *datagrams,
                                     size_t count, size_t *sent,
                                     lum_error *error)
{
    *sent = 0;
    if (count > LUM_SOCKET_BATCH) {
        return lum_socket_say_too_many(count, error);
    }
    for (; *sent < count; ++*sent) {
        const lum_net_result result =
            lum_socket_send(socket, &datagrams[*sent], error);
        if (result != LUM_NET_OK) {
            return result;
        }
    }
    return LUM_NET_OK;
}
