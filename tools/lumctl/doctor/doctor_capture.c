/* What comes in by an interface, before any rule can drop it; nothing on
 * systems other than Linux. */
#define _GNU_SOURCE
#include "doctor.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Positions in an IPv4 header, and in the UDP header after it. */
#define AT_PROTOCOL  9u
#define AT_SOURCE    12u
#define AT_FROM_PORT 0u
#define AT_TO_PORT   2u

/* This filter runs in the kernel: the sensor may be sending its data to another
 * program. On loopback, each packet is also seen as it leaves. */
static bool set_filter(int fd, lum_endpoint sensor, uint16_t to_port)
{
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_B | BPF_ABS,
                 (uint32_t)SKF_AD_OFF + SKF_AD_PKTTYPE),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PACKET_OUTGOING, 12, 0),
        BPF_STMT(BPF_LD | BPF_H | BPF_ABS,
                 (uint32_t)SKF_AD_OFF + SKF_AD_PROTOCOL),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 10),
        BPF_STMT(BPF_LD | BPF_B | BPF_ABS, AT_PROTOCOL),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 8),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, AT_SOURCE),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, sensor.address, 0, 6),
        BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, 0),
        BPF_STMT(BPF_LD | BPF_H | BPF_IND, AT_FROM_PORT),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, sensor.port, 0, 3),
        BPF_STMT(BPF_LD | BPF_H | BPF_IND, AT_TO_PORT),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, to_port, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, 1),
        BPF_STMT(BPF_RET | BPF_K, 0),
    };
    const struct sock_fprog program = {sizeof code / sizeof code[0], code};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program,
                      sizeof program) == 0;
}

/* Bound last, so that nothing comes before the filter is set. For all
 * protocols, because sockets for only one come after the device's own
 * chains. */
int capture_open(const char *interface, lum_endpoint sensor, uint16_t to_port)
{
    struct sockaddr_ll link;
    const unsigned index = if_nametoindex(interface);
    const int fd =
        index == 0
            ? -1
            : socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    memset(&link, 0, sizeof link);
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(ETH_P_ALL);
    link.sll_ifindex = (int)index;
    if (fd >= 0 &&
        (!set_filter(fd, sensor, to_port) ||
         bind(fd, (const struct sockaddr *)&link, sizeof link) != 0)) {
        (void)close(fd);
        return -1;
    }
    return fd;
}

bool capture_saw(int fd)
{
    uint8_t byte;
    return recv(fd, &byte, sizeof byte, 0) >= 0;
}

/* This includes packets that found no room, so none has to be read. */
uint64_t capture_end(int fd)
{
    struct tpacket_stats stats = {0, 0};
    socklen_t len = sizeof stats;
    if (fd < 0 ||
        getsockopt(fd, SOL_PACKET, PACKET_STATISTICS, &stats, &len) != 0) {
        stats.tp_packets = 0;
    }
    if (fd >= 0) {
        (void)close(fd);
    }
    return stats.tp_packets;
}
