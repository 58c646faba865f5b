/* ARP by a packet socket of Linux. */
#define _GNU_SOURCE

#include "arp.h"

#include "lum/base/time.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/if_ether.h>
#include <netpacket/packet.h>
#include <poll.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define MS_NS INT64_C(1000000)

/* A packet of RFC 826 for IPv4 on Ethernet, after the Ethernet header. */
#define PACKET_BYTES   28u
#define AT_OPERATION   6u
#define AT_SENDER_MAC  8u
#define AT_SENDER      14u
#define AT_TARGET      24u
#define PACKET_REQUEST 1u
#define PACKET_REPLY   2u

/* The limit of other packets that are read, so that a flood of them delays
 * nobody. */
#define PASS_OVER_MAX 1024u

/* Ethernet, IPv4, 6 and 4 bytes long. */
static const uint8_t kind[AT_OPERATION] = {0, 1, 8, 0, 6, 4};

struct arp {
    int fd;
    unsigned index;
    uint8_t mac[INTERFACE_MAC_BYTES];
    size_t address_count;
    struct interface_address addresses[];
};

static void put_u32(uint8_t *to, uint32_t value)
{
    const uint32_t wire = htonl(value);
    memcpy(to, &wire, sizeof wire);
}

static uint32_t get_u32(const uint8_t *from)
{
    uint32_t wire = 0;
    memcpy(&wire, from, sizeof wire);
    return ntohl(wire);
}

static struct sockaddr_ll link_of(unsigned index)
{
    struct sockaddr_ll link;
    memset(&link, 0, sizeof link);
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(ETH_P_ARP);
    link.sll_ifindex = (int)index;
    link.sll_halen = INTERFACE_MAC_BYTES;
    memset(link.sll_addr, 0xff, INTERFACE_MAC_BYTES);
    return link;
}

static enum arp_opened fail(const struct host_interface *interface, int number,
                            lum_error *error)
{
    const bool is_right = number == EPERM || number == EACCES;
    (void)lum_error_set(error, "raw ARP on %s: %s", interface->name,
                        is_right ? "only root may" : strerror(number));
    return is_right ? ARP_NO_RIGHT : ARP_NO_WAY;
}

/* Bound, so that other interfaces' packets never come; opened without a
 * protocol, so that none comes before that. */
static int open_socket(unsigned index)
{
    const struct sockaddr_ll link = link_of(index);
    const int fd =
        socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && bind(fd, (const struct sockaddr *)&link, sizeof link) != 0) {
        const int number = errno;
        (void)close(fd);
        errno = number;
        return -1;
    }
    return fd;
}

enum arp_opened arp_open(const struct host_interface *interface,
                         struct arp **out, lum_error *error)
{
    const size_t bytes =
        interface->address_count * sizeof(struct interface_address);
    if (!interface->has_mac) {
        return fail(interface, EAFNOSUPPORT, error);
    }
    struct arp *arp = malloc(sizeof *arp + bytes);
    if (arp == NULL) {
        return fail(interface, ENOMEM, error);
    }
    arp->fd = open_socket(interface->index);
    if (arp->fd < 0) {
        const int number = errno;
        free(arp);
        return fail(interface, number, error);
    }
    arp->index = interface->index;
    memcpy(arp->mac, interface->mac, sizeof arp->mac);
    arp->address_count = interface->address_count;
    if (bytes > 0) {
        memcpy(arp->addresses, interface->addresses, bytes);
    }
    *out = arp;
    return ARP_OPENED;
}

static uint32_t source_for(const struct arp *arp, uint32_t address)
{
    const struct host_interface own = {.addresses = arp->addresses,
                                       .address_count = arp->address_count};
    const struct interface_address *from = interfaces_subnet(&own, address);
    return from != NULL && from->address != address ? from->address : 0;
}

int arp_ask(struct arp *arp, uint32_t address, lum_error *error)
{
    uint8_t packet[PACKET_BYTES] = {0};
    const struct sockaddr_ll everybody = link_of(arp->index);
    memcpy(packet, kind, sizeof kind);
    packet[AT_OPERATION + 1u] = PACKET_REQUEST;
    memcpy(packet + AT_SENDER_MAC, arp->mac, sizeof arp->mac);
    put_u32(packet + AT_SENDER, source_for(arp, address));
    put_u32(packet + AT_TARGET, address);
    if (sendto(arp->fd, packet, sizeof packet, 0,
               (const struct sockaddr *)&everybody, sizeof everybody) < 0) {
        return lum_error_set(error, "sending ARP: %s", strerror(errno));
    }
    return 0;
}

/* False: not ARP of IPv4, or the sender has no address yet. */
static bool read_packet(const uint8_t *packet, size_t len,
                        struct arp_speaker *out)
{
    if (len < PACKET_BYTES || memcmp(packet, kind, sizeof kind) != 0 ||
        packet[AT_OPERATION] != 0 ||
        (packet[AT_OPERATION + 1u] != PACKET_REQUEST &&
         packet[AT_OPERATION + 1u] != PACKET_REPLY)) {
        return false;
    }
    out->is_answer = packet[AT_OPERATION + 1u] == PACKET_REPLY;
    out->address = get_u32(packet + AT_SENDER);
    memcpy(out->mac, packet + AT_SENDER_MAC, sizeof out->mac);
    return out->address != 0;
}

/* 1: somebody spoke; 0: nothing more for now; -1: go on. */
static int take_one(const struct arp *arp, struct arp_speaker *out)
{
    uint8_t packet[64];
    struct sockaddr_ll from = link_of(arp->index);
    socklen_t len = sizeof from;
    const ssize_t n = recvfrom(arp->fd, packet, sizeof packet, 0,
                               (struct sockaddr *)&from, &len);
    if (n < 0) {
        return 0;
    }
    const bool is_own = from.sll_pkttype == PACKET_OUTGOING;
    return !is_own && read_packet(packet, (size_t)n, out) ? 1 : -1;
}

bool arp_receive(struct arp *arp, int64_t deadline_ns, struct arp_speaker *out)
{
    for (unsigned passed = 0; passed < PASS_OVER_MAX; passed++) {
        const int found = take_one(arp, out);
        if (found != 0) {
            if (found > 0) {
                return true;
            }
            continue;
        }
        const int64_t left = deadline_ns - lum_time_monotonic_ns();
        struct pollfd wait = {.fd = arp->fd, .events = POLLIN};
        if (left <= 0 ||
            poll(&wait, 1, (int)((left + MS_NS - 1) / MS_NS)) <= 0) {
            return false;
        }
    }
    return false;
}

int arp_descriptor(const struct arp *arp)
{
    return arp->fd;
}

void arp_close(struct arp *arp)
{
    if (arp != NULL) {
        (void)close(arp->fd);
        free(arp);
    }
}
