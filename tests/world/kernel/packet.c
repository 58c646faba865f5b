#define _GNU_SOURCE
#include "arp.h"

#include "trace.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if_arp.h>
#include <stdlib.h>
#include <string.h>

#define ROOM      212992u /* of a receive buffer */
#define FILTER    64u     /* instructions */
#define IP_BYTES  20u
#define UDP_BYTES 8u

/* Sockets of AF_PACKET without the Ethernet header (SOCK_DGRAM): they hear what
 * comes to their interface, and send ARP. */
struct world_packet {
    struct world_packet *next; /* of the host */
    world_host *host;
    world_file *file;
    const world_interface *at; /* NULL: any */
    uint16_t protocol;         /* 0: nothing is heard */
    struct sock_filter filter[FILTER];
    unsigned filter_len;
    world_datagram *first, *last; /* carriers of frames, without a number */
    uint32_t held;
    unsigned count, drops; /* since they were asked for */
};

static int refuse(int code)
{
    errno = code;
    return -1;
}

static struct world_packet *packet_of(const world_file *file)
{
    return file->data;
}

bool world_packet_listens(const world_host *host)
{
    return world_net_of(host)->packets != NULL;
}

/* --- filters --- */

/* A frame as a filter sees it, and its two registers. */
typedef struct machine {
    const uint8_t *bytes;
    size_t len;
    uint16_t protocol;
    uint8_t type;
    uint32_t a, x;
} machine;

/* Big-endian; false: it is not in the frame. */
static bool load(machine *m, uint32_t at, unsigned size)
{
    uint32_t value = 0;
    if (at == (uint32_t)SKF_AD_OFF + SKF_AD_PROTOCOL) {
        m->a = m->protocol;
        return true;
    }
    if (at == (uint32_t)SKF_AD_OFF + SKF_AD_PKTTYPE) {
        m->a = m->type;
        return true;
    }
    if (at > m->len || m->len - at < size) {
        return false;
    }
    for (unsigned i = 0; i < size; i++) {
        value = value << 8 | m->bytes[at + i];
    }
    m->a = value;
    return true;
}

static unsigned size_of(uint16_t code)
{
    switch (BPF_SIZE(code)) {
    case BPF_B:
        return 1;
    case BPF_H:
        return 2;
    default:
        return 4;
    }
}

static bool jumps(const machine *m, const struct sock_filter *f)
{
    const uint32_t value = BPF_SRC(f->code) == BPF_X ? m->x : f->k;
    switch (BPF_OP(f->code)) {
    case BPF_JEQ:
        return m->a == value;
    case BPF_JGT:
        return m->a > value;
    case BPF_JGE:
        return m->a >= value;
    case BPF_JSET:
        return (m->a & value) != 0;
    default:
        return true; /* BPF_JA is told apart before */
    }
}

static bool is_known(const struct sock_filter *f)
{
    switch (BPF_CLASS(f->code)) {
    case BPF_LD:
        return BPF_MODE(f->code) == BPF_ABS || BPF_MODE(f->code) == BPF_IND;
    case BPF_LDX:
        return f->code == (BPF_LDX | BPF_B | BPF_MSH);
    case BPF_JMP:
        return true;
    case BPF_RET:
        return BPF_RVAL(f->code) == BPF_K;
    default:
        return false;
    }
}

/* One step. False: the frame is too short for it. */
static bool step(machine *m, const struct sock_filter *f, unsigned *next)
{
    switch (BPF_CLASS(f->code)) {
    case BPF_LD:
        return load(m, BPF_MODE(f->code) == BPF_IND ? m->x + f->k : f->k,
                    size_of(f->code));
    case BPF_LDX:
        if (f->k >= m->len) {
            return false;
        }
        m->x = 4u * (m->bytes[f->k] & 15u);
        return true;
    default:
        if (BPF_OP(f->code) == BPF_JA) {
            *next += f->k;
        } else {
            *next += jumps(m, f) ? f->jt : f->jf;
        }
        return true;
    }
}

/* How many bytes of a frame a socket takes; 0: not the frame. */
static size_t filtered(const struct world_packet *p, machine m)
{
    unsigned at = 0;
    if (p->filter_len == 0) {
        return m.len;
    }
    while (at < p->filter_len) {
        const struct sock_filter *f = &p->filter[at++];
        if (BPF_CLASS(f->code) == BPF_RET) {
            return f->k < m.len ? f->k : m.len;
        }
        if (!step(&m, f, &at)) {
            return 0;
        }
    }
    return 0;
}

static int attach(struct world_packet *p, const void *value, socklen_t size)
{
    struct sock_fprog program;
    if (size != sizeof program) {
        return refuse(EINVAL);
    }
    memcpy(&program, value, sizeof program);
    if (program.len == 0 || program.len > FILTER) {
        return refuse(EINVAL);
    }
    for (unsigned i = 0; i < program.len; i++) {
        if (!is_known(&program.filter[i])) {
            world_fail("a filter has the instruction 0x%02x, which is not "
                       "modelled",
                       program.filter[i].code);
            return refuse(EINVAL);
        }
    }
    memcpy(p->filter, program.filter, program.len * sizeof p->filter[0]);
    p->filter_len = program.len;
    return 0;
}

/* --- hearing --- */

static void take(struct world_packet *p, world_interface *at,
                 world_interface *from, const machine *frame, size_t len)
{
    p->count++;
    if (p->held + world_truesize(frame->len) > ROOM) {
        p->drops++;
        return;
    }
    world_datagram *carrier = world_datagram_new(len);
    memcpy(carrier->bytes, frame->bytes, len);
    carrier->private.truesize = world_truesize(frame->len);
    carrier->to_port = frame->protocol;
    carrier->from_port = frame->type;
    carrier->in_at = at;
    carrier->out_at = from;
    if (p->last != NULL) {
        p->last->private.next = carrier;
    } else {
        p->first = carrier;
    }
    p->last = carrier;
    p->held += carrier->private.truesize;
    world_wake_all(p->file->changed);
}

void world_packet_hear(world_interface *at, world_interface *from,
                       uint16_t protocol, uint8_t type, const uint8_t *bytes,
                       size_t len)
{
    const machine frame = {
        .bytes = bytes, .len = len, .protocol = protocol, .type = type};
    for (struct world_packet *p = world_net_of(at->host)->packets; p != NULL;
         p = p->next) {
        if ((p->at != NULL && p->at != at) ||
            (p->protocol != ETH_P_ALL && p->protocol != protocol)) {
            continue;
        }
        const size_t wanted = filtered(p, frame);
        if (wanted > 0) {
            take(p, at, from, &frame, wanted);
        }
    }
}

static void put_u16(uint8_t *to, size_t value)
{
    to[0] = (uint8_t)(value >> 8);
    to[1] = (uint8_t)value;
}

static void put_u32(uint8_t *to, uint32_t value)
{
    const uint32_t wire = htonl(value);
    memcpy(to, &wire, sizeof wire);
}

/* As one frame, however long. Checksums are not filled in. */
void world_packet_hear_datagram(world_interface *at,
                                const world_datagram *datagram)
{
    static uint8_t frame[IP_BYTES + UDP_BYTES + WORLD_UDP_MAX];
    const size_t len = IP_BYTES + UDP_BYTES + datagram->len;
    if (!world_packet_listens(at->host)) {
        return;
    }
    memset(frame, 0, IP_BYTES + UDP_BYTES);
    frame[0] = 0x45;
    put_u16(frame + 2, len);
    frame[8] = 64;
    frame[9] = IPPROTO_UDP;
    put_u32(frame + 12, datagram->from);
    put_u32(frame + 16, datagram->to);
    put_u16(frame + 20, datagram->from_port);
    put_u16(frame + 22, datagram->to_port);
    put_u16(frame + 24, UDP_BYTES + datagram->len);
    memcpy(frame + IP_BYTES + UDP_BYTES, datagram->bytes, datagram->len);
    world_packet_hear(
        at, datagram->out_at != NULL ? datagram->out_at : at, ETH_P_IP,
        datagram->private.is_broadcast ? PACKET_BROADCAST : PACKET_HOST, frame,
        len);
}

/* --- the file --- */

static int packet_bind(world_file *file, const struct sockaddr *address,
                       socklen_t size)
{
    struct world_packet *p = packet_of(file);
    struct sockaddr_ll link;
    if (size < sizeof link || address->sa_family != AF_PACKET) {
        return refuse(EINVAL);
    }
    memcpy(&link, address, sizeof link);
    const world_interface *at =
        world_interface_by_index(p->host, (unsigned)link.sll_ifindex);
    if (link.sll_ifindex != 0 && at == NULL) {
        return refuse(ENODEV);
    }
    p->at = at;
    if (link.sll_protocol != 0) {
        p->protocol = ntohs(link.sll_protocol);
    }
    return 0;
}

static ssize_t packet_sendmsg(world_file *file, const struct msghdr *message,
                              int flags)
{
    const struct world_packet *p = packet_of(file);
    struct sockaddr_ll link;
    (void)flags;
    if (message->msg_name == NULL || message->msg_namelen < sizeof link ||
        message->msg_iovlen != 1) {
        return refuse(EINVAL);
    }
    memcpy(&link, message->msg_name, sizeof link);
    world_interface *from =
        world_interface_by_index(p->host, (unsigned)link.sll_ifindex);
    if (from == NULL || !from->is_up) {
        return refuse(from == NULL ? ENXIO : ENETDOWN);
    }
    if (ntohs(link.sll_protocol) != ETH_P_ARP ||
        message->msg_iov[0].iov_len != WORLD_ARP_BYTES) {
        world_fail("a packet socket sends something other than ARP: this is "
                   "not modelled");
        return refuse(EINVAL);
    }
    if (from->segment != NULL) {
        world_arp_send(from, message->msg_iov[0].iov_base);
    }
    return WORLD_ARP_BYTES;
}

static void give(const world_datagram *carrier, struct msghdr *message,
                 ssize_t *len)
{
    struct sockaddr_ll link;
    const struct iovec *part = &message->msg_iov[0];
    const size_t n =
        part->iov_len < carrier->len ? part->iov_len : carrier->len;
    memcpy(part->iov_base, carrier->bytes, n);
    memset(&link, 0, sizeof link);
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(carrier->to_port);
    link.sll_ifindex = (int)carrier->in_at->index;
    link.sll_hatype = ARPHRD_ETHER;
    link.sll_pkttype = (unsigned char)carrier->from_port;
    link.sll_halen = sizeof carrier->out_at->mac;
    memcpy(link.sll_addr, carrier->out_at->mac, sizeof carrier->out_at->mac);
    if (message->msg_name != NULL) {
        world_put_address(message->msg_name, &message->msg_namelen, &link,
                          sizeof link);
    }
    message->msg_flags = n < carrier->len ? MSG_TRUNC : 0;
    message->msg_controllen = 0;
    *len = (ssize_t)n;
}

static ssize_t packet_recvmsg(world_file *file, struct msghdr *message,
                              int flags)
{
    struct world_packet *p = packet_of(file);
    ssize_t len = 0;
    if (message->msg_iovlen != 1) {
        return refuse(EINVAL);
    }
    while (p->first == NULL) {
        if (!world_file_waits(file) || (flags & MSG_DONTWAIT) != 0) {
            return refuse(EAGAIN);
        }
        if (world_wait(file->changed, INT64_MAX) == WORLD_INTERRUPTED) {
            return refuse(EINTR);
        }
    }
    world_datagram *carrier = p->first;
    p->first = carrier->private.next;
    p->last = p->first != NULL ? p->last : NULL;
    p->held -= carrier->private.truesize;
    give(carrier, message, &len);
    world_datagram_free(carrier);
    return len;
}

static int packet_setsockopt(world_file *file, int level, int name,
                             const void *value, socklen_t size)
{
    return level == SOL_SOCKET && name == SO_ATTACH_FILTER
               ? attach(packet_of(file), value, size)
               : refuse(ENOPROTOOPT);
}

/* The counts begin anew with each look. */
static int packet_getsockopt(world_file *file, int level, int name, void *value,
                             socklen_t *size)
{
    struct world_packet *p = packet_of(file);
    const struct tpacket_stats stats = {p->count, p->drops};
    if (level != SOL_PACKET || name != PACKET_STATISTICS) {
        return refuse(ENOPROTOOPT);
    }
    *size = *size < sizeof stats ? *size : (socklen_t)sizeof stats;
    memcpy(value, &stats, *size);
    p->count = 0;
    p->drops = 0;
    return 0;
}

static short packet_poll(world_file *file)
{
    return (short)(packet_of(file)->first != NULL
                       ? POLLIN | POLLRDNORM | POLLOUT | POLLWRNORM
                       : POLLOUT | POLLWRNORM);
}

static void packet_close(world_file *file)
{
    struct world_packet *p = packet_of(file);
    struct world_packet **at = &world_net_of(p->host)->packets;
    while (*at != p) {
        at = &(*at)->next;
    }
    *at = p->next;
    while (p->first != NULL) {
        world_datagram *carrier = p->first;
        p->first = carrier->private.next;
        world_datagram_free(carrier);
    }
    free(p);
}

static const world_file_kind packet_kind = {
    .name = "packet",
    .poll = packet_poll,
    .bind = packet_bind,
    .setsockopt = packet_setsockopt,
    .getsockopt = packet_getsockopt,
    .sendmsg = packet_sendmsg,
    .recvmsg = packet_recvmsg,
    .close = packet_close,
};

world_file *world_packet_file(world_host *host, int flags, uint16_t protocol)
{
    world_net_host *net = world_net_of(host);
    struct world_packet *p = calloc(1, sizeof *p);
    if (p == NULL) {
        abort();
    }
    p->host = host;
    p->protocol = protocol;
    p->next = net->packets;
    net->packets = p;
    p->file = world_file_new(&packet_kind, flags, p);
    return p->file;
}
