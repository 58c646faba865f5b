#define _GNU_SOURCE
#include "udp.h"

#include "time.h"
#include "trace.h"

#include <arpa/inet.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>

#define BUFFER         212992u /* net.core.rmem_default of Linux */
#define PORTS_FIRST    32768
#define PORTS_LAST     60999
#define PRIVILEGED     1024u
#define PORT_TRIES_MAX 100000

static struct world_udp *sockets; /* all of them */

static int refuse(int code)
{
    errno = code;
    return -1;
}

struct world_udp *world_udp_of(const world_file *file)
{
    return file->data;
}

/* --- ports --- */

static struct world_udp **port_list(const world_host *host, uint16_t port)
{
    return &world_net_of(host)->by_port[port % WORLD_PORT_LISTS];
}

struct world_udp *world_udp_at_port(const world_host *host, uint16_t port)
{
    return *port_list(host, port);
}

/* The newest is found first, as in Linux. */
static void enter_port(struct world_udp *udp, uint16_t port)
{
    struct world_udp **list = port_list(udp->host, port);
    udp->port = port;
    udp->log->port = port;
    udp->next_of_port = *list;
    *list = udp;
}

static void leave_port(struct world_udp *udp)
{
    struct world_udp **at = port_list(udp->host, udp->port);
    if (udp->port == 0) {
        return;
    }
    while (*at != udp) {
        at = &(*at)->next_of_port;
    }
    *at = udp->next_of_port;
    udp->port = 0;
}

/* Two that would get the same datagrams. */
static bool excludes(const struct world_udp *a, const struct world_udp *b,
                     uint32_t address)
{
    if (a->device != NULL && b->device != NULL && a->device != b->device) {
        return false;
    }
    if ((a->reuses_address && b->reuses_address) ||
        (a->reuses_port && b->reuses_port)) {
        return false;
    }
    return a->address == address || a->address == 0 || address == 0;
}

static bool is_taken(const struct world_udp *udp, uint32_t address,
                     uint16_t port)
{
    const struct world_udp *other = *port_list(udp->host, port);
    while (other != NULL && (other->port != port || other == udp ||
                             !excludes(other, udp, address))) {
        other = other->next_of_port;
    }
    return other != NULL;
}

static uint16_t free_port(struct world_udp *udp, uint32_t address)
{
    world_random *random = &world_net_of(udp->host)->ports;
    for (int i = 0; i < PORT_TRIES_MAX; i++) {
        const uint16_t port =
            (uint16_t)world_random_between(random, PORTS_FIRST, PORTS_LAST);
        if (!is_taken(udp, address, port)) {
            return port;
        }
    }
    return 0;
}

int world_udp_bind_any(struct world_udp *udp)
{
    if (udp->port != 0) {
        return 0;
    }
    const uint16_t port = free_port(udp, udp->address);
    if (port == 0) {
        return refuse(EAGAIN);
    }
    enter_port(udp, port);
    return 0;
}

/* --- bind and connect --- */

static int take_address(struct world_udp *udp, uint32_t address)
{
    const world_interface *owner = world_net_owner(udp->host, address);
    const world_address *entry =
        owner != NULL ? world_interface_address(owner, address) : NULL;
    const bool is_fixed = owner != NULL && (entry == NULL || entry->bound == 0);
    udp->address = address;
    udp->source = address;
    if (address == 0 || is_fixed || udp->is_free) {
        return 0;
    }
    if (world_net_is_broadcast(udp->host, address)) {
        udp->source = 0;
        return 0;
    }
    udp->has_taken_address =
        world_net_take_address(udp->host, udp->device, address);
    if (udp->has_taken_address) {
        return 0;
    }
    udp->address = 0;
    udp->source = 0;
    return refuse(EADDRNOTAVAIL);
}

static void leave_address(struct world_udp *udp)
{
    if (udp->has_taken_address) {
        udp->has_taken_address = false;
        world_net_leave_address(udp->host, udp->address);
    }
    udp->address = 0;
    udp->source = 0;
}

static int bind_to(struct world_udp *udp, uint32_t address, uint16_t port)
{
    if (port != 0 && port < PRIVILEGED &&
        !world_net_rights_of(udp->host)->is_root) {
        return refuse(EACCES);
    }
    if (udp->port != 0) {
        return refuse(EINVAL);
    }
    if (take_address(udp, address) != 0) {
        return -1;
    }
    const uint16_t wanted = port != 0 ? port : free_port(udp, address);
    if (wanted == 0 || is_taken(udp, address, wanted)) {
        leave_address(udp);
        return refuse(EADDRINUSE);
    }
    enter_port(udp, wanted);
    udp->log->address = udp->address;
    udp->has_way = false;
    return 0;
}

static int udp_bind(world_file *file, const struct sockaddr *address,
                    socklen_t size)
{
    struct sockaddr_in in;
    if (size < sizeof in) {
        return refuse(EINVAL);
    }
    memcpy(&in, address, sizeof in);
    if (in.sin_family != AF_INET &&
        (in.sin_family != AF_UNSPEC || in.sin_addr.s_addr != 0)) {
        return refuse(EAFNOSUPPORT);
    }
    return bind_to(world_udp_of(file), ntohl(in.sin_addr.s_addr),
                   ntohs(in.sin_port));
}

int world_udp_find_way(struct world_udp *udp, uint32_t to, world_way *out)
{
    const world_interface *by =
        udp->device != NULL ? udp->device : udp->send_by;
    if (!udp->has_way || udp->generation != world_net_generation() ||
        udp->way_to != to || udp->way_by != by) {
        const int code =
            world_way_find(udp->host, to, udp->source, by, &udp->way);
        udp->has_way = code == 0;
        if (code != 0) {
            return refuse(code);
        }
        udp->generation = world_net_generation();
        udp->way_to = to;
        udp->way_by = by;
    }
    *out = udp->way;
    if (out->kind == WORLD_WAY_BROADCAST && !udp->may_broadcast) {
        return refuse(EACCES);
    }
    return 0;
}

static int disconnect(struct world_udp *udp)
{
    udp->is_connected = false;
    udp->peer = 0;
    udp->peer_port = 0;
    return 0;
}

static int connect_to(struct world_udp *udp, uint32_t to, uint16_t port)
{
    world_way way;
    if (world_udp_find_way(udp, to, &way) != 0 ||
        world_udp_bind_any(udp) != 0) {
        return -1;
    }
    if (udp->source == 0) {
        udp->source = way.source;
        udp->has_way = false;
    }
    if (udp->address == 0) {
        udp->address = way.source;
        udp->log->address = way.source;
    }
    udp->peer = to != 0 ? to : way.next_hop;
    udp->peer_port = port;
    udp->is_connected = true;
    return 0;
}

static int udp_connect(world_file *file, const struct sockaddr *address,
                       socklen_t size)
{
    struct sockaddr_in in;
    if (size >= sizeof address->sa_family && address->sa_family == AF_UNSPEC) {
        return disconnect(world_udp_of(file));
    }
    if (size < sizeof in) {
        return refuse(EINVAL);
    }
    memcpy(&in, address, sizeof in);
    if (in.sin_family != AF_INET) {
        return refuse(EAFNOSUPPORT);
    }
    return connect_to(world_udp_of(file), ntohl(in.sin_addr.s_addr),
                      ntohs(in.sin_port));
}

/* --- names --- */

/* As the system does it: as much as there is room for, and the whole size. */
void world_put_address(struct sockaddr *out, socklen_t *size,
                       const void *address, socklen_t len)
{
    memcpy(out, address, *size < len ? *size : len);
    *size = len;
}

static void put(struct sockaddr *out, socklen_t *size, uint32_t address,
                uint16_t port)
{
    struct sockaddr_in in;
    memset(&in, 0, sizeof in);
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(address);
    in.sin_port = htons(port);
    world_put_address(out, size, &in, sizeof in);
}

static int udp_getsockname(world_file *file, struct sockaddr *out,
                           socklen_t *size)
{
    const struct world_udp *udp = world_udp_of(file);
    put(out, size, udp->address, udp->port);
    return 0;
}

static int get_peer_name(const world_file *file, struct sockaddr *out,
                         socklen_t *size)
{
    const struct world_udp *udp = world_udp_of(file);
    if (!udp->is_connected) {
        return refuse(ENOTCONN);
    }
    put(out, size, udp->peer, udp->peer_port);
    return 0;
}

/* --- taking what comes --- */

static bool takes(const struct world_udp *udp, const world_datagram *datagram)
{
    return udp->port == datagram->to_port &&
           (udp->address == 0 || udp->address == datagram->to) &&
           (udp->device == NULL || udp->device == datagram->in_at) &&
           (!udp->is_connected || (udp->peer == datagram->from &&
                                   udp->peer_port == datagram->from_port));
}

/* One with the address before one with none, then the one that says most. */
static unsigned score_of(const struct world_udp *udp)
{
    return (udp->address != 0 ? 4u : 0) + (udp->is_connected ? 2u : 0) +
           (udp->device != NULL ? 1u : 0) + 1u;
}

static struct world_udp *best(const world_host *host,
                              const world_datagram *datagram)
{
    struct world_udp *found = NULL;
    unsigned most = 0;
    for (struct world_udp *u = *port_list(host, datagram->to_port); u != NULL;
         u = u->next_of_port) {
        if (takes(u, datagram) && score_of(u) > most) {
            most = score_of(u);
            found = u;
        }
    }
    return found;
}

/* The system's clock stamps it when it comes. */
static void take(struct world_udp *udp, world_datagram *datagram)
{
    const uint32_t size = datagram->private.truesize;
    datagram->receiver = udp->log;
    if (udp->held + size > udp->receive_room) {
        udp->drops++;
        world_met("net:buffer-full");
        world_datagram_end(datagram, WORLD_LOST_BUFFER);
        return;
    }
    udp->held += size;
    datagram->private.utc_ns = world_host_utc_ns(udp->host);
    datagram->private.drops = udp->drops;
    datagram->private.next = NULL;
    if (udp->last != NULL) {
        udp->last->private.next = datagram;
    } else {
        udp->first = datagram;
    }
    udp->last = datagram;
    world_wake_all(udp->file->changed);
}

/* Each socket that takes it gets one; the last one the original. */
static void deliver_to_all(const world_host *host, world_datagram *datagram)
{
    struct world_udp *last = NULL;
    for (struct world_udp *u = *port_list(host, datagram->to_port); u != NULL;
         u = u->next_of_port) {
        if (takes(u, datagram)) {
            if (last != NULL) {
                take(last, world_datagram_copy(datagram));
            }
            last = u;
        }
    }
    if (last != NULL) {
        take(last, datagram);
    } else {
        world_datagram_end(datagram, datagram->is_bad ? WORLD_LOST_CHECKSUM
                                                      : WORLD_LOST_NO_SOCKET);
    }
}

void world_udp_deliver(const world_host *host, world_datagram *datagram)
{
    if (datagram->private.is_broadcast) {
        deliver_to_all(host, datagram);
        return;
    }
    struct world_udp *udp = best(host, datagram);
    if (udp != NULL) {
        take(udp, datagram);
    } else if (datagram->is_bad) {
        world_datagram_end(datagram, WORLD_LOST_CHECKSUM);
    } else {
        world_udp_refuse(datagram);
        world_datagram_end(datagram, WORLD_LOST_NO_SOCKET);
    }
}

/* The host's own sockets hear its broadcasts too. */
void world_udp_hear_own(world_datagram *datagram)
{
    const world_host *host = datagram->out_at->host;
    datagram->in_at = datagram->out_at;
    for (const struct world_udp *u = *port_list(host, datagram->to_port);
         u != NULL; u = u->next_of_port) {
        if (takes(u, datagram)) {
            world_udp_deliver(host, world_datagram_copy(datagram));
            break;
        }
    }
    datagram->in_at = NULL;
}

/* --- errors --- */

int world_udp_take_error(struct world_udp *udp)
{
    const int error = udp->error;
    udp->error = 0;
    return error;
}

static void tell_error(struct world_udp *udp, int code)
{
    udp->error = code;
    world_wake_all(udp->file->changed);
}

void world_udp_unreachable(struct world_udp *udp)
{
    if (udp->tells_errors) {
        tell_error(udp, EHOSTUNREACH);
    }
}

/* What an answer of the network is about: a datagram without a number. */
static void hear_refusal(void *argument)
{
    world_datagram *about = argument;
    struct world_udp *udp = about->sender->socket;
    if (udp != NULL &&
        (udp->tells_errors || (udp->is_connected && udp->peer == about->to &&
                               udp->peer_port == about->to_port))) {
        world_met("net:refused");
        tell_error(udp, ECONNREFUSED);
    }
    world_datagram_free(about);
}

void world_udp_refuse(const world_datagram *datagram)
{
    int64_t ns = 0;
    const bool is_own = datagram->out_at == NULL;
    if (!is_own &&
        !world_link_answers(datagram->in_at, datagram->out_at, &ns)) {
        return;
    }
    world_datagram *about = world_datagram_new(0);
    about->sender = datagram->sender;
    about->to = datagram->to;
    about->to_port = datagram->to_port;
    if (is_own) {
        hear_refusal(about);
    } else {
        (void)world_at(world_now() + ns / 2, hear_refusal, about);
    }
}

void world_udp_drained(struct world_udp *udp)
{
    if (world_udp_can_send(udp)) {
        world_wake_all(udp->file->changed);
    }
}

/* --- the file --- */

bool world_udp_has_data(const struct world_udp *udp)
{
    return udp->first != NULL;
}

bool world_udp_can_send(const struct world_udp *udp)
{
    return udp->log->queued < udp->send_room / 2u;
}

/* As Linux: who does not wait hears of a corrupt datagram too, and then finds
 * nothing. */
static short udp_poll(world_file *file)
{
    struct world_udp *udp = world_udp_of(file);
    if (world_file_waits(file)) {
        world_udp_drop_bad(udp);
    }
    int events = udp->error != 0 ? POLLERR : 0;
    events |= world_udp_has_data(udp) ? POLLIN | POLLRDNORM : 0;
    events |= world_udp_can_send(udp) ? POLLOUT | POLLWRNORM | POLLWRBAND : 0;
    return (short)events;
}

static ssize_t udp_read(world_file *file, void *out, size_t size)
{
    struct iovec part = {.iov_base = out, .iov_len = size};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
    return world_udp_recvmsg(file, &message, 0);
}

static ssize_t udp_write(world_file *file, const void *bytes, size_t size)
{
    struct iovec part = {.iov_len = size};
    const struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
    memcpy(&part.iov_base, &bytes, sizeof bytes);
    return world_udp_sendmsg(file, &message, 0);
}

static int udp_ioctl(world_file *file, unsigned long request, void *argument)
{
    const struct world_udp *udp = world_udp_of(file);
    int value = 0;
    if (request == FIONREAD) {
        value = udp->first != NULL ? (int)udp->first->len : 0;
    } else if (request == TIOCOUTQ) {
        value = (int)udp->log->queued;
    } else {
        return world_socket_ioctl(udp->host, request, argument);
    }
    memcpy(argument, &value, sizeof value);
    return 0;
}

static void free_socket(struct world_udp *udp)
{
    if (udp->before != NULL) {
        udp->before->after = udp->after;
    } else {
        sockets = udp->after;
    }
    if (udp->after != NULL) {
        udp->after->before = udp->before;
    }
    free(udp);
}

static void udp_close(world_file *file)
{
    struct world_udp *udp = world_udp_of(file);
    udp->log->socket = NULL;
    while (udp->first != NULL) {
        world_datagram *datagram = udp->first;
        udp->first = datagram->private.next;
        world_datagram_end(datagram, datagram->is_bad ? WORLD_LOST_CHECKSUM
                                                      : WORLD_LOST_UNREAD);
    }
    leave_port(udp);
    leave_address(udp);
    free_socket(udp);
}

static const world_file_kind udp_kind = {
    .name = "udp",
    .read = udp_read,
    .write = udp_write,
    .poll = udp_poll,
    .ioctl = udp_ioctl,
    .bind = udp_bind,
    .connect = udp_connect,
    .getsockname = udp_getsockname,
    .setsockopt = world_udp_setsockopt,
    .getsockopt = world_udp_getsockopt,
    .sendmsg = world_udp_sendmsg,
    .recvmsg = world_udp_recvmsg,
    .close = udp_close,
};

int world_peer_name(const world_file *file, struct sockaddr *out,
                    socklen_t *size)
{
    return file->kind == &udp_kind ? get_peer_name(file, out, size)
                                   : refuse(ENOTCONN);
}

world_file *world_udp_file(world_host *host, int flags)
{
    struct world_udp *udp = calloc(1, sizeof *udp);
    if (udp == NULL) {
        abort();
    }
    udp->host = host;
    udp->receive_room = BUFFER;
    udp->send_room = BUFFER;
    udp->log = world_socket_log_new(host);
    udp->log->socket = udp;
    udp->after = sockets;
    if (sockets != NULL) {
        sockets->before = udp;
    }
    sockets = udp;
    udp->file = world_file_new(&udp_kind, flags, udp);
    udp->log->number = udp->file->number;
    return udp->file;
}

/* Files are gone before; this is for those that nobody closed. */
void world_udp_reset(void)
{
    while (sockets != NULL) {
        free_socket(sockets);
    }
}
