/* Hears UDP on an interface of a Linux host, also what is for others. */
#define _GNU_SOURCE

#include "find.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <netpacket/packet.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define IP_BYTES_MIN  20u
#define UDP_BYTES     8u
#define FRAME_BYTES   192u /* of each frame, its IP header included */
#define PASS_OVER_MAX 64u

struct udp_listener {
    int fd;
};

/* UDP, the first fragment, from this port: the kernel drops all else. */
static bool attach(int fd, uint16_t port)
{
    struct sock_filter code[] = {
        {0x30, 0, 0, 9},           /* ldb [9]: protocol */
        {0x15, 0, 6, 17},          /* UDP, else drop */
        {0x28, 0, 0, 6},           /* ldh [6]: fragment */
        {0x45, 4, 0, 0x1fff},      /* a later one: drop */
        {0xb1, 0, 0, 0},           /* x = length of the IP header */
        {0x48, 0, 0, 0},           /* ldh [x]: source port */
        {0x15, 0, 1, port},        /* ours, else drop */
        {0x06, 0, 0, FRAME_BYTES}, /* take */
        {0x06, 0, 0, 0},           /* drop */
    };
    const struct sock_fprog program = {sizeof code / sizeof code[0], code};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program,
                      sizeof program) == 0;
}

struct udp_listener *udp_listener_open(const struct host_interface *interface,
                                       uint16_t port)
{
    struct sockaddr_ll link;
    struct udp_listener *listener = malloc(sizeof *listener);
    if (listener == NULL) {
        return NULL;
    }
    memset(&link, 0, sizeof link);
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(ETH_P_IP);
    link.sll_ifindex = (int)interface->index;
    listener->fd =
        socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (listener->fd < 0 || !attach(listener->fd, port) ||
        bind(listener->fd, (const struct sockaddr *)&link, sizeof link) != 0) {
        udp_listener_close(listener);
        return NULL;
    }
    return listener;
}

static bool read_frame(const uint8_t *frame, size_t len, struct udp_heard *out)
{
    const size_t head = len > 0 ? (size_t)(frame[0] & 15u) * 4u : 0;
    uint32_t address = 0;
    uint16_t port = 0;
    if (head < IP_BYTES_MIN || len < head + UDP_BYTES) {
        return false;
    }
    memcpy(&address, frame + 16, sizeof address);
    out->to = ntohl(address);
    memcpy(&address, frame + 12, sizeof address);
    memcpy(&port, frame + head, sizeof port);
    out->from = (lum_endpoint){ntohl(address), ntohs(port)};
    out->len = len - head - UDP_BYTES;
    if (out->len > sizeof out->bytes) {
        out->len = sizeof out->bytes;
    }
    memcpy(out->bytes, frame + head + UDP_BYTES, out->len);
    return true;
}

bool udp_listener_take(struct udp_listener *listener, struct udp_heard *out)
{
    for (unsigned passed = 0; passed < PASS_OVER_MAX; passed++) {
        uint8_t frame[FRAME_BYTES];
        struct sockaddr_ll from;
        socklen_t from_len = sizeof from;
        memset(&from, 0, sizeof from);
        const ssize_t n = recvfrom(listener->fd, frame, sizeof frame, 0,
                                   (struct sockaddr *)&from, &from_len);
        if (n < 0) {
            return false;
        }
        if (from.sll_pkttype != PACKET_OUTGOING &&
            read_frame(frame, (size_t)n, out)) {
            out->has_mac = from.sll_halen == INTERFACE_MAC_BYTES;
            memcpy(out->mac, from.sll_addr, sizeof out->mac);
            return true;
        }
    }
    return false;
}

void udp_listener_close(struct udp_listener *listener)
{
    if (listener != NULL) {
        if (listener->fd >= 0) {
            (void)close(listener->fd);
        }
        free(listener);
    }
}
