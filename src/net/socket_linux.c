/* What sockets of Linux can do: many datagrams a call, joined ones, drops
 * counted. */
#define _GNU_SOURCE
#include "net/socket_system.h"

#include <errno.h>
#include <limits.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <netinet/udp.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#define NS_PER_S INT64_C(1000000000)

/* Since Linux 4.12; older headers lack the name. */
#ifndef SO_MEMINFO
#define SO_MEMINFO 55
#endif

/* Since Linux 4.18. */
#ifndef UDP_SEGMENT
#define UDP_SEGMENT 103
#endif

/* Since Linux 5.0. */
#ifndef UDP_GRO
#define UDP_GRO 104
#endif

/* Payload of the longest datagram of IPv4, which a message is before it is
 * cut. */
#define JOINED_BYTES_MAX 65507u

/* Room for a time stamp, a drop count, the interface of arrival and the size of
 * joined datagrams. */
typedef union control_room {
    size_t align; /* as struct cmsghdr has it */
    char bytes[CMSG_SPACE(sizeof(struct timespec)) +
               CMSG_SPACE(sizeof(uint32_t)) +
               CMSG_SPACE(sizeof(struct in_pktinfo)) + CMSG_SPACE(sizeof(int))];
} control_room;

/* Room for the size of the datagrams in one message. */
typedef union cut_room {
    size_t align;
    char bytes[CMSG_SPACE(sizeof(uint16_t))];
} cut_room;

/* --- Opening --- */

lum_system_handle lum_system_socket(lum_error *error)
{
    const int fd =
        socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) {
        (void)lum_error_set(error, "cannot make a UDP socket: %s",
                            strerror(errno));
    }
    return fd;
}

/* Without the right to bind to a device: send there, and check the interface of
 * arrivals. */
static int use_index(int fd, unsigned index)
{
    const uint32_t wire = htonl(index);
    const int on = 1;
    if (setsockopt(fd, IPPROTO_IP, IP_UNICAST_IF, &wire, sizeof wire) != 0) {
        return -1;
    }
    return setsockopt(fd, IPPROTO_IP, IP_PKTINFO, &on, sizeof on);
}

lum_net_result lum_system_use_interface(int fd, const char *name,
                                        lum_endpoint *local, unsigned *only,
                                        lum_error *error)
{
    const unsigned index = if_nametoindex(name);
    (void)local;
    *only = 0;
    if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, name,
                   (socklen_t)strlen(name)) == 0) {
        return LUM_NET_OK;
    }
    if (errno == EPERM && use_index(fd, index) == 0) {
        *only = index;
        return LUM_NET_OK;
    }
    const int code = errno;
    (void)lum_error_set(error, "cannot use interface %s alone: %s", name,
                        strerror(code));
    return code == EPERM ? LUM_NET_DENIED : LUM_NET_FAILED;
}

static size_t granted(int fd)
{
    int bytes = 0;
    socklen_t len = sizeof bytes;
    if (getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, &len) != 0 || bytes < 0) {
        return 0;
    }
    return (size_t)bytes;
}

/* The kernel doubles the requested size, and counts about two bytes for each
 * byte of payload: so it holds the requested size of payload. */
size_t lum_system_grow(int fd, size_t bytes, bool *enough)
{
    const size_t most = INT_MAX / 2;
    const int ask = (int)(bytes < most ? bytes : most);
    if (bytes != 0) {
        (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &ask, sizeof ask);
    }
    if (granted(fd) / 2u < bytes) {
        (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &ask, sizeof ask);
    }
    *enough = granted(fd) / 2u >= bytes;
    return granted(fd);
}

/* A kernel that refuses supports neither; the calls work without them. */
bool lum_system_tell(int fd)
{
    const int on = 1;
    (void)setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    return setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0;
}

/* SO_RXQ_OVFL reports with the next datagram; this reports at once. */
bool lum_system_drops(int fd, uint32_t *out)
{
    uint32_t values[SK_MEMINFO_VARS] = {0};
    socklen_t len = sizeof values;
    if (getsockopt(fd, SOL_SOCKET, SO_MEMINFO, values, &len) != 0 ||
        len <= SK_MEMINFO_DROPS * sizeof values[0]) {
        return false;
    }
    *out = values[SK_MEMINFO_DROPS];
    return true;
}

int lum_system_poll(struct pollfd *set, size_t count, int64_t wait_ns)
{
    const struct timespec wait = {.tv_sec = (time_t)(wait_ns / NS_PER_S),
                                  .tv_nsec = (long)(wait_ns % NS_PER_S)};
    return ppoll(set, count, &wait, NULL);
}

/* --- Receiving --- */

static void read_time(const struct cmsghdr *control, lum_received *out)
{
    struct timespec at;
    memcpy(&at, CMSG_DATA(control), sizeof at);
    out->utc_ns = (int64_t)at.tv_sec * NS_PER_S + at.tv_nsec;
}

/* What a receive gave: a message, which is a datagram or several of one size,
 * of which only the last may be shorter. */
typedef struct parcel {
    lum_received whole;
    lum_arrival arrival;
    size_t each; /* bytes; 0: it is one */
} parcel;

static void read_control(const struct cmsghdr *control, parcel *out)
{
    lum_arrival *arrival = &out->arrival;
    if (control->cmsg_level == IPPROTO_IP && control->cmsg_type == IP_PKTINFO) {
        struct in_pktinfo info;
        memcpy(&info, CMSG_DATA(control), sizeof info);
        arrival->if_index = (unsigned)info.ipi_ifindex;
    } else if (control->cmsg_level == SOL_SOCKET &&
               control->cmsg_type == SCM_TIMESTAMPNS) {
        read_time(control, &out->whole);
    } else if (control->cmsg_level == SOL_SOCKET &&
               control->cmsg_type == SO_RXQ_OVFL) {
        memcpy(&arrival->drops, CMSG_DATA(control), sizeof arrival->drops);
        arrival->has_drops = true;
    } else if (control->cmsg_level == IPPROTO_UDP &&
               control->cmsg_type == UDP_GRO) {
        int each = 0;
        memcpy(&each, CMSG_DATA(control), sizeof each);
        out->each = each > 0 ? (size_t)each : 0;
    }
}

static void read_message(struct mmsghdr *message, parcel *out)
{
    struct msghdr *header = &message->msg_hdr;
    *out =
        (parcel){.whole = {.bytes = header->msg_iov->iov_base,
                           .len = message->msg_len,
                           .from = lum_sockaddr_endpoint(header->msg_name),
                           .cut_short = (header->msg_flags & MSG_TRUNC) != 0}};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(header); c != NULL;
         c = CMSG_NXTHDR(header, c)) {
        read_control(c, out);
    }
    out->arrival.is_joined = out->each != 0 && out->each < out->whole.len;
}

/* The buffer may be longer than what a caller gets. */
static void take_one(const parcel *from, size_t at, size_t len, bool is_cut,
                     lum_received *out)
{
    *out = from->whole;
    out->bytes += at;
    out->len = len < LUM_SOCKET_BYTES ? len : LUM_SOCKET_BYTES;
    out->cut_short = is_cut || len > LUM_SOCKET_BYTES;
}

/* Takes a message apart. How many datagrams it was. A kernel that joins more
 * than any does today loses none in silence: the last has the rest, and is
 * marked. */
static int take_apart(const parcel *from, lum_received *out,
                      lum_arrival *arrivals)
{
    const lum_received *whole = &from->whole;
    const size_t each = from->arrival.is_joined ? from->each : whole->len;
    size_t at = 0;
    size_t n = 0;
    do {
        const size_t rest = whole->len - at;
        const bool is_last = rest <= each || n + 1u == LUM_SYSTEM_JOINED_MAX;
        const size_t len = is_last ? rest : each;
        take_one(from, at, len, is_last && (whole->cut_short || rest > each),
                 &out[n]);
        arrivals[n++] = from->arrival;
        at += len;
    } while (at < whole->len);
    return (int)n;
}

/* Off by default: it changes what a message is. */
bool lum_system_take_joined(int fd)
{
    const int on = 1;
    return setsockopt(fd, IPPROTO_UDP, UDP_GRO, &on, sizeof on) == 0;
}

int lum_system_receive(int fd, bool joined, uint8_t *buffers, lum_received *out,
                       lum_arrival *arrivals)
{
    struct mmsghdr messages[LUM_SOCKET_BATCH];
    struct iovec vectors[LUM_SOCKET_BATCH];
    struct sockaddr_in peers[LUM_SOCKET_BATCH];
    control_room controls[LUM_SOCKET_BATCH];
    const size_t room = joined ? LUM_SYSTEM_JOINED_BYTES : LUM_SOCKET_BYTES;
    int taken = 0;
    for (size_t i = 0; i < LUM_SOCKET_BATCH; i++) {
        vectors[i] =
            (struct iovec){.iov_base = buffers + i * room, .iov_len = room};
        messages[i].msg_hdr =
            (struct msghdr){.msg_name = &peers[i],
                            .msg_namelen = sizeof peers[i],
                            .msg_iov = &vectors[i],
                            .msg_iovlen = 1,
                            .msg_control = &controls[i],
                            .msg_controllen = sizeof controls[i].bytes};
    }
    const int n = recvmmsg(fd, messages, LUM_SOCKET_BATCH, MSG_DONTWAIT, NULL);
    for (int i = 0; i < n; i++) {
        parcel got;
        read_message(&messages[i], &got);
        taken += take_apart(&got, out + taken, arrivals + taken);
    }
    return n < 0 ? n : taken;
}

/* --- Sending --- */

/* Without a size of 0, which means that nothing is cut. A kernel that does not
 * know the option would take no notice of it in a message either, and send one
 * long datagram. */
bool lum_system_joins(int fd)
{
    const int none = 0;
    return setsockopt(fd, IPPROTO_UDP, UDP_SEGMENT, &none, sizeof none) == 0;
}

/* How many datagrams, from the first on, one message can hold: all as long as
 * the first, except for the last, which may be shorter. */
static size_t count_joined(const lum_outgoing *first, size_t count)
{
    const size_t len = first->len;
    const size_t room = len != 0 ? JOINED_BYTES_MAX / len : 1;
    const size_t most = count < room ? count : room;
    size_t n = 1;
    while (n < most && first[n - 1].len == len && first[n].len <= len &&
           first[n].len != 0 && first[n].to.address == first->to.address &&
           first[n].to.port == first->to.port) {
        n++;
    }
    return n;
}

/* The size at which the kernel cuts a message into datagrams. */
static void set_cut(struct msghdr *message, size_t len, cut_room *room)
{
    const uint16_t size = (uint16_t)len;
    memset(room, 0, sizeof *room); /* the padding, too, is handed over */
    message->msg_control = room;
    message->msg_controllen = sizeof room->bytes;
    struct cmsghdr *control = CMSG_FIRSTHDR(message);
    control->cmsg_level = IPPROTO_UDP;
    control->cmsg_type = UDP_SEGMENT;
    control->cmsg_len = CMSG_LEN(sizeof size);
    memcpy(CMSG_DATA(control), &size, sizeof size);
}

/* The messages of one call, and how many datagrams are in each. */
typedef struct outbox {
    struct mmsghdr messages[LUM_SOCKET_BATCH];
    struct iovec vectors[LUM_SOCKET_BATCH];
    struct sockaddr_in peers[LUM_SOCKET_BATCH];
    cut_room cuts[LUM_SOCKET_BATCH];
    size_t held[LUM_SOCKET_BATCH];
    size_t count;
} outbox;

static void put_message(outbox *box, const lum_outgoing *first,
                        struct iovec *vectors, size_t n)
{
    const size_t at = box->count++;
    struct msghdr *message = &box->messages[at].msg_hdr;
    box->held[at] = n;
    box->peers[at] = lum_sockaddr_of(first->to);
    *message = (struct msghdr){.msg_name = &box->peers[at],
                               .msg_namelen = sizeof box->peers[at],
                               .msg_iov = vectors,
                               .msg_iovlen = n};
    if (n > 1) {
        set_cut(message, first->len, &box->cuts[at]);
    }
}

static void fill_outbox(outbox *box, bool joins, const lum_outgoing *datagrams,
                        size_t count)
{
    box->count = 0;
    for (size_t i = 0; i < count; i++) {
        /* sendmsg() only reads it, but its type does not say so. */
        memcpy(&box->vectors[i].iov_base, &datagrams[i].bytes, sizeof(void *));
        box->vectors[i].iov_len = datagrams[i].len;
    }
    for (size_t i = 0; i < count;) {
        const size_t n = joins ? count_joined(datagrams + i, count - i) : 1;
        put_message(box, datagrams + i, box->vectors + i, n);
        i += n;
    }
}

/* What a kernel says that cannot cut there: the interface has no checksums, or
 * its MTU is too small, so that the datagrams must be fragments. */
static bool is_refusal(int code)
{
    return code == EIO || code == EINVAL || code == EMSGSIZE ||
           code == EOPNOTSUPP;
}

int lum_system_send(int fd, bool *joins, const lum_outgoing *datagrams,
                    size_t count)
{
    outbox box;
    int left = 0;
    fill_outbox(&box, *joins, datagrams, count);
    int n = sendmmsg(fd, box.messages, (unsigned)box.count, MSG_DONTWAIT);
    if (n < 0 && box.held[0] > 1 && is_refusal(errno)) {
        *joins = false;
        fill_outbox(&box, false, datagrams, count);
        n = sendmmsg(fd, box.messages, (unsigned)box.count, MSG_DONTWAIT);
    }
    for (int i = 0; i < n; i++) {
        left += (int)box.held[i];
    }
    return n < 0 ? n : left;
}
