/* UDP sockets on every system, over what its own calls are
 * (net/socket_system.h). */
#define _POSIX_C_SOURCE 200809L
#include "net/socket_system.h"

#include "base/sized.h"
#include "base/text.h"
#include "lum/base/time.h"
#include "net/endpoint.h"
#include "net/program.h"

#if defined(_WIN32)
#include "net/adapter.h"
#else
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Holds a few full batches, where the system's default may not hold one. */
#define SEND_BUFFER (4 * 1024 * 1024)

/* Errors of datagrams sent earlier that one receive skips. */
#define PENDING_ERRORS 16

struct lum_socket {
    lum_system_handle fd;
    lum_endpoint local;
    unsigned only; /* interface that arrivals must be from; 0: any */
    size_t receive_buffer;
    bool has_room;
    bool counts_drops;
    bool joins;          /* datagrams that are sent */
    uint32_t drops_seen; /* the kernel's number, which wraps */
    uint64_t drops;
    bool takes_joined;
    uint64_t joined;
    lum_received *received;
    lum_arrival *arrivals;
    uint8_t *bytes;
};

/* --- Calls that differ by their names --- */

#if defined(_WIN32)

#define WAITS_FOR_DESCRIPTORS false

static int last_error(void)
{
    return lum_winsock_errno();
}

static void close_handle(lum_system_handle fd)
{
    (void)closesocket(fd);
    lum_winsock_stop();
}

static void list_interfaces(char *out, size_t room)
{
    lum_adapter_list(out, room);
}

static bool has_interface(const char *name)
{
    lum_adapter found;
    return lum_adapter_find(name, 0, &found);
}

#else

#define WAITS_FOR_DESCRIPTORS true

static int last_error(void)
{
    return errno;
}

static void close_handle(lum_system_handle fd)
{
    (void)close(fd);
}

/* "lo, eth0" */
static void list_interfaces(char *out, size_t room)
{
    struct if_nameindex *all = if_nameindex();
    *out = '\0';
    for (size_t i = 0; all != NULL && all[i].if_index != 0; i++) {
        lum_text_list(out, room, ", ", all[i].if_name);
    }
    if (all != NULL) {
        if_freenameindex(all);
    }
}

static bool has_interface(const char *name)
{
    return if_nametoindex(name) != 0;
}

#endif

/* --- What errors mean --- */

static lum_net_result say_taken(lum_endpoint local, lum_error *error)
{
    (void)lum_error_set(error,
                        "UDP port %s is taken by %s: end it, or use another "
                        "address or port",
                        lum_endpoint_show(local).text,
                        lum_program_show(lum_program_of_port(local)).text);
    return LUM_NET_BUSY;
}

/* A local endpoint could not be bound. */
static lum_net_result say_unbound(lum_endpoint local, int code,
                                  lum_error *error)
{
    const lum_endpoint_text where = lum_endpoint_show(local);
    if (code == EADDRINUSE) {
        return say_taken(local, error);
    }
    if (code == EACCES || code == EPERM) {
        (void)lum_error_set(error,
                            "no permission for UDP port %s: use a port above "
                            "1023, or run with more rights",
                            where.text);
        return LUM_NET_DENIED;
    }
    if (code == EADDRNOTAVAIL) {
        (void)lum_error_set(error,
                            "cannot use UDP port %s: no interface of this "
                            "host has that address",
                            where.text);
    } else {
        (void)lum_error_set(error, "cannot use UDP port %s: %s", where.text,
                            strerror(code));
    }
    return LUM_NET_FAILED;
}

/* What a send's error means, and what helps. */
typedef struct send_error {
    int code;
    lum_net_result result;
    const char *says;
} send_error;

static const send_error send_errors[] = {
    {EPERM, LUM_NET_DENIED, "the firewall of this host forbids it"},
    {EACCES, LUM_NET_DENIED,
     "it is a broadcast address, or the firewall of this host forbids it"},
    {ENETUNREACH, LUM_NET_FAILED,
     "this host has no route there; give an interface an address in that "
     "network"},
    {EHOSTUNREACH, LUM_NET_FAILED,
     "the host does not answer on the local network; look at cable, power and "
     "address"},
    {ENETDOWN, LUM_NET_FAILED, "the interface is down"},
    {ENODEV, LUM_NET_FAILED, "the interface is gone"},
    {ENXIO, LUM_NET_FAILED, "the interface is gone"},
    {EADDRNOTAVAIL, LUM_NET_FAILED,
     "this host has lost the address that the socket is bound to"},
    {EMSGSIZE, LUM_NET_FAILED, "it is too long for a datagram"},
    {EINVAL, LUM_NET_FAILED,
     "it cannot be reached from there; look at address, port and interface"},
    {EAGAIN, LUM_NET_FAILED,
     "the send buffer is full; the link is slower than the data"},
    {EWOULDBLOCK, LUM_NET_FAILED,
     "the send buffer is full; the link is slower than the data"},
    {ENOBUFS, LUM_NET_FAILED,
     "the interface's queue is full; the link is slower than the data"},
};

/* A datagram did not leave. */
static lum_net_result say_unsent(const lum_outgoing *datagram, int code,
                                 lum_error *error)
{
    const char *says = strerror(code);
    lum_net_result result = LUM_NET_FAILED;
    for (size_t i = 0; i < sizeof send_errors / sizeof send_errors[0]; i++) {
        if (send_errors[i].code == code) {
            says = send_errors[i].says;
            result = send_errors[i].result;
            break;
        }
    }
    (void)lum_error_set(error, "cannot send %lu bytes to %s: %s",
                        (unsigned long)datagram->len,
                        lum_endpoint_show(datagram->to).text, says);
    return result;
}

/* --- Opening --- */

static lum_net_result use_interface(lum_socket *socket, const char *name,
                                    lum_endpoint *local, lum_error *error)
{
    char list[256];
    if (has_interface(name)) {
        return lum_system_use_interface(socket->fd, name, local, &socket->only,
                                        error);
    }
    list_interfaces(list, sizeof list);
    (void)lum_error_set(error, "there is no interface %s; this host has: %s",
                        name, *list != '\0' ? list : "none");
    return LUM_NET_FAILED;
}

static lum_net_result bind_local(lum_socket *socket, lum_endpoint local,
                                 lum_error *error)
{
    struct sockaddr_in address = lum_sockaddr_of(local);
    socklen_t len = sizeof address;
    if (bind(socket->fd, (const struct sockaddr *)&address, len) != 0 ||
        getsockname(socket->fd, (struct sockaddr *)&address, &len) != 0) {
        return say_unbound(local, last_error(), error);
    }
    socket->local = lum_sockaddr_endpoint(&address);
    return LUM_NET_OK;
}

static lum_net_result set_up(lum_socket *socket,
                             const lum_socket_options *options,
                             lum_error *error)
{
    const int send_buffer = SEND_BUFFER;
    lum_endpoint local = options->local;
    uint32_t drops = 0;
    (void)setsockopt(socket->fd, SOL_SOCKET, SO_SNDBUF,
                     (const char *)&send_buffer, sizeof send_buffer);
    socket->receive_buffer =
        lum_system_grow(socket->fd, options->receive_buffer, &socket->has_room);
    socket->counts_drops =
        lum_system_tell(socket->fd) || lum_system_drops(socket->fd, &drops);
    socket->joins = options->sends_joined && lum_system_joins(socket->fd);
    socket->takes_joined =
        options->takes_joined && lum_system_take_joined(socket->fd);
    if (options->interface_name != NULL) {
        const lum_net_result result =
            use_interface(socket, options->interface_name, &local, error);
        if (result != LUM_NET_OK) {
            return result;
        }
    }
    return bind_local(socket, local, error);
}

static lum_net_result fail_memory(lum_error *error)
{
    (void)lum_error_set(error, "no memory left for a socket");
    return LUM_NET_FAILED;
}

/* Not cleared: its pages stay unused until data comes. */
static lum_net_result make_room(lum_socket *socket, lum_error *error)
{
    const size_t count =
        socket->takes_joined ? LUM_SOCKET_JOINED_BATCH : LUM_SOCKET_BATCH;
    socket->received = malloc(count * sizeof *socket->received);
    socket->arrivals = malloc(count * sizeof *socket->arrivals);
    socket->bytes = malloc(
        (size_t)LUM_SOCKET_BATCH *
        (socket->takes_joined ? LUM_SYSTEM_JOINED_BYTES : LUM_SOCKET_BYTES));
    return socket->received != NULL && socket->arrivals != NULL &&
                   socket->bytes != NULL
               ? LUM_NET_OK
               : fail_memory(error);
}

lum_net_result lum_socket_open(const lum_socket_options *options,
                               lum_socket **out, lum_error *error)
{
    lum_socket_options known;
    if (lum_sized_take(&known, sizeof known, options, "the socket's options",
                       "lum_socket_options", error) != 0) {
        return LUM_NET_FAILED;
    }
    lum_socket *socket = calloc(1, sizeof *socket);
    if (socket == NULL) {
        return fail_memory(error);
    }
    socket->fd = lum_system_socket(error);
    lum_net_result result = socket->fd == LUM_SYSTEM_NONE
                                ? LUM_NET_FAILED
                                : set_up(socket, &known, error);
    if (result == LUM_NET_OK) {
        result = make_room(socket, error);
    }
    if (result != LUM_NET_OK) {
        lum_socket_close(socket);
        return result;
    }
    *out = socket;
    return LUM_NET_OK;
}

void lum_socket_close(lum_socket *socket)
{
    if (socket != NULL) {
        if (socket->fd != LUM_SYSTEM_NONE) {
            close_handle(socket->fd);
        }
        free(socket->received);
        free(socket->arrivals);
        free(socket->bytes);
        free(socket);
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

bool lum_socket_counts_drops(const lum_socket *socket)
{
    return socket->counts_drops;
}

/* --- Waiting --- */

/* The cancel comes first: it must work under load too. */
static lum_net_result judge(const struct pollfd *set, size_t count,
                            bool has_cancel)
{
    if (has_cancel && set[0].revents != 0) {
        return LUM_NET_CANCELLED;
    }
    for (size_t i = 0; i < count; i++) {
        if ((set[i].revents & POLLNVAL) != 0) {
            return LUM_NET_FAILED;
        }
    }
    return LUM_NET_OK;
}

static lum_net_result poll_until(struct pollfd *set, size_t count,
                                 bool has_cancel, int64_t deadline_ns)
{
    for (;;) {
        const int64_t now = lum_time_monotonic_ns();
        const int64_t wait = deadline_ns > now ? deadline_ns - now : 0;
        const int ready = lum_system_poll(set, count, wait);
        const int code = ready < 0 ? last_error() : 0;
        if (ready > 0) {
            return judge(set, count, has_cancel);
        }
        if (ready == 0 && deadline_ns <= lum_time_monotonic_ns()) {
            return LUM_NET_TIMEOUT;
        }
        if (ready < 0 && code != EINTR && code != EAGAIN) {
            return LUM_NET_FAILED;
        }
    }
}

lum_net_result lum_socket_wait(lum_socket *const *sockets, size_t count,
                               int extra_fd, const lum_cancel *cancel,
                               int64_t deadline_ns)
{
    struct pollfd set[LUM_SOCKET_WAIT_MAX + 2u];
    size_t used = 0;
    if (count > LUM_SOCKET_WAIT_MAX) {
        return LUM_NET_FAILED;
    }
    if (cancel != NULL) {
        set[used++] =
            (struct pollfd){.fd = (lum_system_handle)lum_cancel_handle(cancel),
                            .events = POLLIN};
    }
    if (WAITS_FOR_DESCRIPTORS && extra_fd >= 0) {
        set[used++] = (struct pollfd){.fd = (lum_system_handle)extra_fd,
                                      .events = POLLIN};
    }
    for (size_t i = 0; i < count; i++) {
        set[used++] = (struct pollfd){.fd = sockets[i]->fd, .events = POLLIN};
    }
    return poll_until(set, used, cancel != NULL, deadline_ns);
}

/* --- Receiving --- */

/* The counts in datagrams may be older than one that was read already. */
static void note_drops(lum_socket *socket, uint32_t seen)
{
    const uint32_t step = seen - socket->drops_seen;
    if (step < UINT32_C(0x80000000)) {
        socket->drops += step;
        socket->drops_seen = seen;
    }
}

uint64_t lum_socket_drops(lum_socket *socket)
{
    uint32_t seen = 0;
    if (lum_system_drops(socket->fd, &seen)) {
        note_drops(socket, seen);
    }
    return socket->drops;
}

uint64_t lum_socket_joined(const lum_socket *socket)
{
    return socket->joined;
}

/* Note what came with the datagrams; remove those of other interfaces. */
static size_t sort_out(lum_socket *socket, size_t count)
{
    size_t kept = 0;
    int64_t now = 0;
    for (size_t i = 0; i < count; i++) {
        const lum_arrival *arrival = &socket->arrivals[i];
        lum_received *received = &socket->received[i];
        if (arrival->has_drops) {
            note_drops(socket, arrival->drops);
        }
        socket->joined += arrival->is_joined; /* as drops: of all interfaces */
        if (socket->only != 0 && socket->only != arrival->if_index) {
            continue;
        }
        if (received->utc_ns == 0) {
            now = now != 0 ? now : lum_time_utc_ns();
            received->utc_ns = now;
        }
        socket->received[kept++] = *received;
    }
    return kept;
}

/* All other errors are of a datagram sent earlier, or temporary. */
static bool is_broken(int code)
{
    return code == EBADF || code == ENOTSOCK || code == EINVAL ||
           code == EFAULT || code == ENOTCONN || code == EOPNOTSUPP;
}

lum_net_result lum_socket_receive(lum_socket *socket, lum_received **out,
                                  size_t *count, lum_error *error)
{
    *out = socket->received;
    *count = 0;
    for (int errors = 0; errors < PENDING_ERRORS; errors++) {
        const int n =
            lum_system_receive(socket->fd, socket->takes_joined, socket->bytes,
                               socket->received, socket->arrivals);
        if (n >= 0) {
            *count = sort_out(socket, (size_t)n);
            return LUM_NET_OK;
        }
        const int code = last_error();
        if (code == EAGAIN || code == EWOULDBLOCK) {
            return LUM_NET_OK;
        }
        if (is_broken(code)) {
            (void)lum_error_set(error, "cannot receive at %s any more: %s",
                                lum_endpoint_show(socket->local).text,
                                strerror(code));
            return LUM_NET_FAILED;
        }
    }
    return LUM_NET_OK;
}

/* --- Sending --- */

/* A send may report the error of an earlier one; then it is tried again.
 * Returns how many left; 0 with a code. */
static size_t send_some(lum_socket *socket, const lum_outgoing *datagrams,
                        size_t count, int *code)
{
    int n = -1;
    for (int tries = 0; tries < PENDING_ERRORS; tries++) {
        n = lum_system_send(socket->fd, &socket->joins, datagrams, count);
        *code = n < 0 ? last_error() : 0;
        if (n >= 0 || (*code != EINTR && *code != ECONNREFUSED)) {
            break;
        }
    }
    return n > 0 ? (size_t)n : 0;
}

lum_net_result lum_socket_send_batch(lum_socket *socket,
                                     const lum_outgoing *datagrams,
                                     size_t count, size_t *sent,
                                     lum_error *error)
{
    *sent = 0;
    if (count > LUM_SOCKET_BATCH) {
        (void)lum_error_set(error, "%lu datagrams in one send, at most %u",
                            (unsigned long)count, LUM_SOCKET_BATCH);
        return LUM_NET_FAILED;
    }
    while (*sent < count) {
        int code = 0;
        const size_t n =
            send_some(socket, datagrams + *sent, count - *sent, &code);
        if (n == 0) {
            return say_unsent(&datagrams[*sent], code, error);
        }
        *sent += n;
    }
    return LUM_NET_OK;
}

lum_net_result lum_socket_send(lum_socket *socket, const lum_outgoing *datagram,
                               lum_error *error)
{
    size_t sent = 0;
    return lum_socket_send_batch(socket, datagram, 1, &sent, error);
}
