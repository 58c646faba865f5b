#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/clock_calls.h"
#include "kernel/disk_calls.h"
#include "kernel/file_calls.h"
#include "kernel/net.h"
#include "kernel/process.h"
#include "kernel/socket_calls.h"
#include "kernel/task.h"
#include "kernel/time.h"
#include "kernel/trace.h"
#include "kernel/world.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/un.h>
#include <sys/wait.h>

#define SEED   7
#define HOST   WORLD_ADDRESS(10, 42, 0, 1)
#define SENSOR WORLD_ADDRESS(10, 42, 0, 37)
#define PORT   4000

/* Programs without an image: their calls are the world's by name. */
__attribute__((section("program_data"), used)) static int unused = 3;
extern char __start_program_data[];
extern char __stop_program_data[];

static world_host *bench, *sensor;
static world_interface *eth0;
static int (*run_program)(void);
static void (*script)(void);

static int program_main(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    return run_program();
}

/* Right away: it takes run_program at its first turn. */
static world_process *start(world_host *host, int (*run)(void))
{
    static const char *const none[] = {NULL};
    const world_start s = {
        .host = host, .program = "program", .arguments = none};
    run_program = run;
    world_process *process = world_process_start(&s);
    assert_non_null(process);
    assert_false(world_process_wait(process, world_now() + WORLD_MS / 10) &&
                 process->status != 0);
    return process;
}

static void finish(world_process *process)
{
    assert_true(world_process_wait(process, world_now() + 60 * WORLD_S));
    assert_int_equal(process->status, 0);
}

static void *run_user(void *argument)
{
    (void)argument;
    bench = world_host_new("bench");
    sensor = world_host_new("sensor");
    world_segment *wire = world_segment_new("wire");
    eth0 = world_interface_new(bench, wire, "eth0");
    world_interface_add(eth0, HOST, 24);
    world_interface_add(world_interface_new(sensor, wire, "eth0"), SENSOR, 24);
    script();
    return NULL;
}

static void run(void (*user)(void))
{
    script = user;
    world_begin(SEED);
    const bool has_ended =
        world_run(world_task_begin(NULL, run_user, NULL), WORLD_NEVER);
    assert_string_equal(world_failure(), "");
    assert_true(has_ended);
    world_net_check();
    assert_string_equal(world_failure(), "");
    world_end();
}

static struct sockaddr_in at(uint32_t address, uint16_t port)
{
    struct sockaddr_in in;
    memset(&in, 0, sizeof in);
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(address);
    in.sin_port = htons(port);
    return in;
}

static int bound(uint32_t address, uint16_t port)
{
    const struct sockaddr_in in = at(address, port);
    const int fd = world_call_socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(
        world_call_bind(fd, (const struct sockaddr *)&in, sizeof in), 0);
    return fd;
}

/* --- datagrams --- */

static int echo(void)
{
    const int fd = bound(0, PORT);
    char bytes[100];
    struct sockaddr_in from;
    socklen_t size = sizeof from;
    for (int i = 0; i < 3; i++) {
        const ssize_t n = world_call_recvfrom(fd, bytes, sizeof bytes, 0,
                                              (struct sockaddr *)&from, &size);
        assert_int_equal(size, sizeof from);
        assert_int_equal(world_call_sendto(fd, bytes, (size_t)n, 0,
                                           (const struct sockaddr *)&from,
                                           size),
                         n);
    }
    return world_call_close(fd);
}

static int ask(void)
{
    const struct sockaddr_in to = at(SENSOR, PORT);
    const int fd = world_call_socket(AF_INET, SOCK_DGRAM, 0);
    struct mmsghdr out[3], in[8];
    struct iovec parts[3], rooms[8];
    char bytes[8][16];
    char texts[3][8] = {"one", "two", "three"};
    struct sockaddr_in peer;
    socklen_t size = sizeof peer;
    memset(out, 0, sizeof out);
    memset(in, 0, sizeof in);
    for (size_t i = 0; i < 8; i++) {
        rooms[i] = (struct iovec){bytes[i], sizeof bytes[i]};
        in[i].msg_hdr.msg_iov = &rooms[i];
        in[i].msg_hdr.msg_iovlen = 1;
    }
    for (size_t i = 0; i < 3; i++) {
        parts[i] = (struct iovec){texts[i], strlen(texts[i])};
        out[i].msg_hdr.msg_iov = &parts[i];
        out[i].msg_hdr.msg_iovlen = 1;
    }
    assert_int_equal(world_call_sendmmsg(fd, out, 3, 0), -1);
    assert_int_equal(errno, EDESTADDRREQ);
    assert_int_equal(
        world_call_getpeername(fd, (struct sockaddr *)&peer, &size), -1);
    assert_int_equal(errno, ENOTCONN);
    assert_int_equal(
        world_call_connect(fd, (const struct sockaddr *)&to, sizeof to), 0);
    assert_int_equal(
        world_call_getpeername(fd, (struct sockaddr *)&peer, &size), 0);
    assert_int_equal(ntohs(peer.sin_port), PORT);
    assert_int_equal(world_call_recvmmsg(fd, in, 8, MSG_DONTWAIT, NULL), -1);
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(world_call_sendmmsg(fd, out, 3, 0), 3);
    assert_int_equal(out[2].msg_len, 5);
    int came = 0;
    while (came < 3) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};
        assert_int_equal(world_call_poll(&wait, 1, 1000), 1);
        came += world_call_recvmmsg(fd, in + came, (unsigned)(8 - came),
                                    MSG_DONTWAIT, NULL);
    }
    assert_int_equal(came, 3);
    assert_memory_equal(bytes[0], "one", 3);
    assert_int_equal(in[2].msg_len, 5);
    return 0;
}

static void two_talk(void)
{
    world_process *server = start(sensor, echo);
    finish(start(bench, ask));
    finish(server);
    const world_socket_log *log = world_net_sockets();
    assert_int_equal(log->pid, server->pid);
    assert_int_equal(log->got[WORLD_RECEIVED], 3);
    assert_int_equal(log->sent[WORLD_RECEIVED], 3);
}

static void datagrams_go_by_calls_for_one_and_for_several(void **state)
{
    (void)state;
    run(two_talk);
}

static int refuse_wrong_ones(void)
{
    int ends[2];
    char byte = 0;
    assert_int_equal(world_call_send(7, &byte, 1, 0), -1);
    assert_int_equal(errno, EBADF);
    assert_int_equal(world_call_pipe(ends), 0);
    assert_int_equal(world_call_recv(ends[0], &byte, 1, 0), -1);
    assert_int_equal(errno, ENOTSOCK);
    assert_int_equal(world_call_socket(AF_PACKET, SOCK_DGRAM, 0), -1);
    assert_int_equal(errno, EPERM);
    assert_int_equal(world_call_socket(AF_INET, SOCK_RAW, 1), -1);
    assert_int_equal(errno, EPERM);
    assert_int_equal(world_call_socket(AF_INET6, SOCK_DGRAM, 0), -1);
    assert_int_equal(errno, EAFNOSUPPORT);
    assert_int_equal(world_call_listen(bound(0, 0), 1), -1);
    assert_int_equal(errno, EOPNOTSUPP);
    return 0;
}

static void one_that_is_wrong(void)
{
    finish(start(bench, refuse_wrong_ones));
}

static void what_is_no_socket_is_refused(void **state)
{
    (void)state;
    run(one_that_is_wrong);
}

/* --- interfaces and names --- */

static int list_interfaces(void)
{
    struct ifaddrs *all = NULL;
    unsigned links = 0;
    unsigned addresses = 0;
    assert_int_equal(world_call_getifaddrs(&all), 0);
    for (const struct ifaddrs *i = all; i != NULL; i = i->ifa_next) {
        if (i->ifa_addr->sa_family == AF_PACKET) {
            struct sockaddr_ll link;
            memcpy(&link, i->ifa_addr, sizeof link);
            assert_int_equal(link.sll_hatype,
                             links == 0 ? ARPHRD_LOOPBACK : ARPHRD_ETHER);
            assert_string_equal(i->ifa_name, links == 0 ? "lo" : "eth0");
            links++;
        } else {
            const struct sockaddr_in *mask =
                (const struct sockaddr_in *)(const void *)i->ifa_netmask;
            assert_int_equal(ntohl(mask->sin_addr.s_addr),
                             addresses == 0 ? 0xff000000u : 0xffffff00u);
            assert_true((i->ifa_flags & IFF_UP) != 0);
            addresses++;
        }
    }
    assert_int_equal(links, 2);
    assert_int_equal(addresses, 2);
    world_call_freeifaddrs(all);
    return 0;
}

static int name_interfaces(void)
{
    char name[IFNAMSIZ];
    struct if_nameindex *all = world_call_if_nameindex();
    assert_int_equal(world_call_if_nametoindex("eth0"), 2);
    assert_int_equal(world_call_if_nametoindex("eth1"), 0);
    assert_int_equal(errno, ENODEV);
    assert_string_equal(world_call_if_indextoname(1, name), "lo");
    assert_null(world_call_if_indextoname(9, name));
    assert_int_equal(errno, ENXIO);
    assert_string_equal(all[1].if_name, "eth0");
    assert_int_equal(all[2].if_index, 0);
    world_call_if_freenameindex(all);
    return 0;
}

static int ask_socket(void)
{
    struct ifreq request;
    const int fd = bound(0, 0);
    memset(&request, 0, sizeof request);
    (void)snprintf(request.ifr_name, sizeof request.ifr_name, "eth0");
    assert_int_equal(world_call_ioctl(fd, SIOCGIFMTU, &request), 0);
    assert_int_equal(request.ifr_mtu, 1500);
    assert_int_equal(world_call_ioctl(fd, SIOCGIFINDEX, &request), 0);
    assert_int_equal(request.ifr_ifindex, 2);
    (void)snprintf(request.ifr_name, sizeof request.ifr_name, "eth9");
    assert_int_equal(world_call_ioctl(fd, SIOCGIFMTU, &request), -1);
    assert_int_equal(errno, ENODEV);
    assert_int_equal(world_call_ioctl(fd, TCGETS, &request), -1);
    assert_int_equal(errno, ENOTTY);
    return 0;
}

static void those_that_list(void)
{
    finish(start(bench, list_interfaces));
    finish(start(bench, name_interfaces));
    finish(start(bench, ask_socket));
}

static void interfaces_are_listed_as_linux_does(void **state)
{
    (void)state;
    run(those_that_list);
}

static uint32_t resolve(const char *name, int *code)
{
    const struct addrinfo wanted = {.ai_family = AF_INET,
                                    .ai_socktype = SOCK_DGRAM};
    struct addrinfo *found = NULL;
    struct sockaddr_in in = at(0, 0);
    *code = world_call_getaddrinfo(name, NULL, &wanted, &found);
    if (*code == 0) {
        memcpy(&in, found->ai_addr, sizeof in);
        world_call_freeaddrinfo(found);
    }
    return ntohl(in.sin_addr.s_addr);
}

static int look_up(void)
{
    int code = 0;
    assert_int_equal(resolve("localhost", &code), WORLD_ADDRESS(127, 0, 0, 1));
    assert_int_equal(resolve("10.42.0.9", &code), WORLD_ADDRESS(10, 42, 0, 9));
    assert_int_equal(resolve("sensor", &code), SENSOR);
    assert_int_equal(resolve("lidar.example", &code), HOST);
    (void)resolve("nobody", &code);
    assert_int_equal(code, EAI_NONAME);
    (void)resolve("new", &code);
    assert_int_equal(code, EAI_NODATA);
    world_net_name_server(5 * WORLD_S, true);
    const int64_t began = world_now();
    (void)resolve("sensor", &code);
    assert_int_equal(code, EAI_AGAIN);
    assert_true(world_now() - began >= 5 * WORLD_S);
    (void)resolve("localhost", &code);
    assert_int_equal(code, 0);
    return 0;
}

static void one_that_resolves(void)
{
    world_net_name("lidar.example", HOST);
    world_net_name("new", 0);
    finish(start(bench, look_up));
}

static void names_are_those_of_hosts_and_of_the_server(void **state)
{
    (void)state;
    run(one_that_resolves);
}

/* --- local names --- */

static socklen_t local_name(struct sockaddr_un *out, const char *name)
{
    memset(out, 0, sizeof *out);
    out->sun_family = AF_UNIX;
    (void)snprintf(out->sun_path + 1, sizeof out->sun_path - 1u, "%s", name);
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1u +
                       strlen(name));
}

static int local_socket(void)
{
    return world_call_socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
}

static bool keeps;

static int keep_a_name(void)
{
    struct sockaddr_un name;
    const socklen_t size = local_name(&name, "session");
    const int fd = local_socket();
    assert_int_equal(world_call_listen(fd, 1), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(world_call_bind(fd, (const struct sockaddr *)&name, size),
                     0);
    assert_int_equal(world_call_listen(fd, 1), 0);
    while (keeps) {
        const struct timespec second = {.tv_sec = 1};
        (void)world_call_clock_nanosleep(CLOCK_MONOTONIC, 0, &second, NULL);
    }
    return 0;
}

static long holder;

static int ask_for_a_name(void)
{
    struct sockaddr_un name;
    const socklen_t size = local_name(&name, "session");
    const int fd = local_socket();
    const int other = local_socket();
    struct ucred who;
    socklen_t who_size = sizeof who;
    assert_int_equal(world_call_bind(fd, (const struct sockaddr *)&name, size),
                     -1);
    assert_int_equal(errno, EADDRINUSE);
    assert_int_equal(
        world_call_connect(other, (const struct sockaddr *)&name, size), 0);
    assert_int_equal(
        world_call_getsockopt(other, SOL_SOCKET, SO_PEERCRED, &who, &who_size),
        0);
    assert_int_equal(who.pid, holder);
    /* Nobody accepts, and the list of those that wait is short. */
    assert_int_equal(world_call_connect(local_socket(),
                                        (const struct sockaddr *)&name, size),
                     0);
    assert_int_equal(world_call_connect(local_socket(),
                                        (const struct sockaddr *)&name, size),
                     -1);
    assert_int_equal(errno, EAGAIN);
    return 0;
}

static int ask_in_vain(void)
{
    struct sockaddr_un name;
    const socklen_t size = local_name(&name, "session");
    assert_int_equal(world_call_connect(local_socket(),
                                        (const struct sockaddr *)&name, size),
                     -1);
    assert_int_equal(errno, ECONNREFUSED);
    return 0;
}

static void one_that_keeps_a_name(void)
{
    keeps = true;
    world_process *keeper = start(bench, keep_a_name);
    holder = keeper->pid;
    finish(start(bench, ask_for_a_name));
    finish(start(sensor, ask_in_vain)); /* names are of a host */
    world_process_signal(keeper, SIGKILL);
    finish(start(bench, ask_in_vain)); /* and gone with the process */
    keeps = false;
}

static void a_local_name_is_held_by_one_process(void **state)
{
    (void)state;
    run(one_that_keeps_a_name);
}

/* --- the wire --- */

static struct sockaddr_ll link_of(uint16_t protocol)
{
    struct sockaddr_ll link;
    memset(&link, 0, sizeof link);
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(protocol);
    link.sll_ifindex = (int)eth0->index;
    link.sll_halen = 6;
    memset(link.sll_addr, 0xff, 6);
    return link;
}

static int listen_to(uint16_t protocol, const struct sock_fprog *filter)
{
    const struct sockaddr_ll link = link_of(protocol);
    const int fd = world_call_socket(AF_PACKET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    assert_true(fd >= 0);
    if (filter != NULL) {
        assert_int_equal(world_call_setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER,
                                               filter, sizeof *filter),
                         0);
    }
    assert_int_equal(
        world_call_bind(fd, (const struct sockaddr *)&link, sizeof link), 0);
    return fd;
}

static void pause_ms(long ms)
{
    const struct timespec while_ns = {.tv_sec = ms / 1000,
                                      .tv_nsec = ms % 1000 * 1000000};
    assert_int_equal(
        world_call_clock_nanosleep(CLOCK_MONOTONIC, 0, &while_ns, NULL), 0);
}

static void ask_by_arp(int fd, uint32_t address)
{
    const struct sockaddr_ll everybody = link_of(ETH_P_ARP);
    uint8_t packet[28] = {0, 1, 8, 0, 6, 4, 0, 1};
    const uint32_t own = htonl(HOST);
    const uint32_t wanted = htonl(address);
    memcpy(packet + 8, eth0->mac, 6);
    memcpy(packet + 14, &own, 4);
    memcpy(packet + 24, &wanted, 4);
    assert_int_equal(world_call_sendto(fd, packet, sizeof packet, 0,
                                       (const struct sockaddr *)&everybody,
                                       sizeof everybody),
                     sizeof packet);
}

static int hear_arp(void)
{
    const int fd = listen_to(ETH_P_ARP, NULL);
    struct sockaddr_ll from;
    socklen_t size = sizeof from;
    uint8_t packet[64];
    uint32_t sender = 0;
    ask_by_arp(fd, SENSOR);
    ask_by_arp(fd, WORLD_ADDRESS(10, 42, 0, 99));
    pause_ms(1);
    assert_int_equal(world_call_recvfrom(fd, packet, sizeof packet, 0,
                                         (struct sockaddr *)&from, &size),
                     28);
    memcpy(&sender, packet + 14, sizeof sender);
    assert_int_equal(packet[7], 2);
    assert_int_equal(ntohl(sender), SENSOR);
    assert_memory_equal(packet + 8, world_interface_find(sensor, "eth0")->mac,
                        6);
    assert_memory_equal(from.sll_addr, packet + 8, 6);
    assert_int_equal(from.sll_pkttype, PACKET_HOST);
    assert_int_equal(world_call_recv(fd, packet, sizeof packet, 0), -1);
    assert_int_equal(errno, EAGAIN);
    return 0;
}

/* As lumctl find does: UDP, the first fragment, from a port. */
static int hear_frames(void)
{
    struct sock_filter code[] = {
        {0x30, 0, 0, 9},    {0x15, 0, 6, 17}, {0x28, 0, 0, 6},
        {0x45, 4, 0, 8191}, {0xb1, 0, 0, 0},  {0x48, 0, 0, 0},
        {0x15, 0, 1, PORT}, {0x06, 0, 0, 40}, {0x06, 0, 0, 0},
    };
    const struct sock_fprog filter = {sizeof code / sizeof code[0], code};
    const int ear = listen_to(ETH_P_IP, &filter);
    const int all = listen_to(ETH_P_ALL, NULL);
    const int deaf = listen_to(ETH_P_ARP, NULL);
    world_interface *const kept = eth0;
    eth0 = world_interface_first(bench);
    const int elsewhere = listen_to(ETH_P_ALL, NULL);
    eth0 = kept;
    struct tpacket_stats stats;
    socklen_t size = sizeof stats;
    uint8_t frame[200];
    pause_ms(1000);
    assert_int_equal(world_call_recv(ear, frame, sizeof frame, 0), 40);
    assert_memory_equal(frame + 28, "0123456789ab", 12);
    assert_int_equal(frame[0], 0x45);
    assert_int_equal(frame[20] << 8 | frame[21], PORT);
    assert_int_equal(world_call_recv(ear, frame, sizeof frame, 0), -1);
    /* Two datagrams, and the question of ARP before them. */
    assert_int_equal(world_call_getsockopt(all, SOL_PACKET, PACKET_STATISTICS,
                                           &stats, &size),
                     0);
    assert_int_equal(stats.tp_packets, 3);
    assert_int_equal(world_call_recv(deaf, frame, sizeof frame, 0), 28);
    assert_int_equal(world_call_recv(deaf, frame, sizeof frame, 0), -1);
    assert_int_equal(world_call_recv(elsewhere, frame, sizeof frame, 0), -1);
    return 0;
}

static int send_twice(void)
{
    const struct sockaddr_in to = at(HOST, 9);
    const int one = bound(0, PORT);
    const int other = bound(0, PORT + 1);
    const char text[] = "0123456789abcdef";
    assert_int_equal(world_call_sendto(one, text, 16, 0,
                                       (const struct sockaddr *)&to, sizeof to),
                     16);
    assert_int_equal(world_call_sendto(other, text, 16, 0,
                                       (const struct sockaddr *)&to, sizeof to),
                     16);
    return 0;
}

static void those_that_hear(void)
{
    world_net_rights_of(bench)->is_root = true;
    finish(start(bench, hear_arp));
    world_process *ear = start(bench, hear_frames);
    world_interface_set_carrier(world_interface_find(sensor, "eth0"), false);
    world_interface_set_carrier(world_interface_find(sensor, "eth0"), true);
    finish(start(sensor, send_twice));
    finish(ear);
}

static void root_hears_what_comes_to_an_interface(void **state)
{
    (void)state;
    run(those_that_hear);
}

/* --- routes and files of the system --- */

typedef struct route_request {
    struct nlmsghdr header;
    struct rtmsg route;
    struct rtattr attribute;
    uint32_t address;
} route_request;

/* The type of the answer; its bytes go to reply. */
static int ask_route(uint32_t address, unsigned flags, char reply[512])
{
    route_request request;
    struct nlmsghdr head;
    memset(&request, 0, sizeof request);
    request.header.nlmsg_len = sizeof request;
    request.header.nlmsg_type = RTM_GETROUTE;
    request.header.nlmsg_flags = NLM_F_REQUEST;
    request.route.rtm_family = AF_INET;
    request.route.rtm_dst_len = 32;
    request.route.rtm_flags = flags;
    request.attribute = (struct rtattr){RTA_LENGTH(4), RTA_DST};
    request.address = htonl(address);
    const int fd = world_call_socket(AF_NETLINK, SOCK_RAW, NETLINK_ROUTE);
    assert_int_equal(world_call_send(fd, &request, sizeof request, 0),
                     sizeof request);
    const ssize_t n = world_call_recv(fd, reply, 512, 0);
    assert_true(n >= (ssize_t)sizeof head);
    memcpy(&head, reply, sizeof head);
    assert_int_equal(head.nlmsg_len, n);
    assert_int_equal(world_call_close(fd), 0);
    return head.nlmsg_type;
}

/* Of an answer; 0: it has none. */
static uint32_t attribute(const char *reply, unsigned short type)
{
    struct nlmsghdr head;
    memcpy(&head, reply, sizeof head);
    size_t i = NLMSG_SPACE(sizeof(struct rtmsg));
    while (i < head.nlmsg_len) {
        struct rtattr a;
        uint32_t value = 0;
        memcpy(&a, reply + i, sizeof a);
        memcpy(&value, reply + i + sizeof a, sizeof value);
        if (a.rta_type == type) {
            return value;
        }
        i += RTA_ALIGN(a.rta_len);
    }
    return 0;
}

static struct rtmsg route_of(const char *reply)
{
    struct rtmsg route;
    memcpy(&route, reply + NLMSG_HDRLEN, sizeof route);
    return route;
}

static int find_ways(void)
{
    char reply[512];
    const uint32_t elsewhere = WORLD_ADDRESS(10, 99, 0, 1);
    assert_int_equal(ask_route(SENSOR, 0, reply), RTM_NEWROUTE);
    assert_int_equal(attribute(reply, RTA_OIF), 2);
    assert_int_equal(ntohl(attribute(reply, RTA_PREFSRC)), HOST);
    assert_int_equal(route_of(reply).rtm_type, RTN_UNICAST);
    assert_int_equal(ask_route(HOST, 0, reply), RTM_NEWROUTE);
    assert_int_equal(attribute(reply, RTA_OIF), 1);
    assert_int_equal(route_of(reply).rtm_type, RTN_LOCAL);
    assert_int_equal(ask_route(elsewhere, 0, reply), NLMSG_ERROR);
    int code = 0;
    memcpy(&code, reply + NLMSG_HDRLEN, sizeof code);
    assert_int_equal(code, -ENETUNREACH);
    world_route_add(eth0, 0, 0, SENSOR);
    assert_int_equal(ask_route(elsewhere, 0, reply), RTM_NEWROUTE);
    assert_int_equal(ntohl(attribute(reply, RTA_GATEWAY)), SENSOR);
    assert_int_equal(ask_route(elsewhere, RTM_F_FIB_MATCH, reply),
                     RTM_NEWROUTE);
    assert_int_equal(route_of(reply).rtm_dst_len, 0);
    assert_int_equal(ask_route(SENSOR, RTM_F_FIB_MATCH, reply), RTM_NEWROUTE);
    assert_int_equal(route_of(reply).rtm_dst_len, 24);
    return 0;
}

static void one_that_finds(void)
{
    finish(start(bench, find_ways));
}

static void a_route_is_found_as_the_routes_say(void **state)
{
    (void)state;
    run(one_that_finds);
}

static void read_file(const char *path, char out[2048])
{
    const int fd = world_call_open64(path, O_RDONLY);
    assert_true(fd >= 0);
    const ssize_t n = world_call_read(fd, out, 2047);
    assert_true(n >= 0);
    out[n] = '\0';
    assert_int_equal(world_call_close(fd), 0);
}

static int read_files(void)
{
    char text[2048];
    char wanted[64];
    struct sockaddr_in to = at(SENSOR, PORT);
    const int fd = bound(HOST, PORT);
    struct stat about;
    read_file("/proc/net/udp", text);
    assert_non_null(strstr(text, ": 01002A0A:0FA0 00000000:0000 07 "));
    assert_int_equal(world_call_fstat64(fd, &about), 0);
    (void)snprintf(wanted, sizeof wanted, " %llu 2 ",
                   (unsigned long long)about.st_ino);
    assert_non_null(strstr(text, wanted));
    (void)world_call_sendto(fd, "x", 1, 0, (const struct sockaddr *)&to,
                            sizeof to);
    to = at(WORLD_ADDRESS(10, 42, 0, 99), PORT);
    (void)world_call_sendto(fd, "x", 1, 0, (const struct sockaddr *)&to,
                            sizeof to);
    const struct timespec while_ns = {.tv_nsec = 1000000};
    (void)world_call_clock_nanosleep(CLOCK_MONOTONIC, 0, &while_ns, NULL);
    read_file("/proc/net/arp", text);
    assert_non_null(
        strstr(text, "10.42.0.37       0x1         0x2         02:"));
    assert_non_null(strstr(text, "10.42.0.99       0x1         0x0         "
                                 "00:00:00:00:00:00     *        eth0\n"));
    read_file("/proc/sys/net/core/rmem_max", text);
    assert_string_equal(text, "212992\n");
    read_file("/proc/sys/net/ipv4/conf/eth0/rp_filter", text);
    assert_string_equal(text, "0\n");
    return 0;
}

static void one_that_reads(void)
{
    finish(start(bench, read_files));
}

static void the_systems_files_show_sockets_and_neighbours(void **state)
{
    (void)state;
    run(one_that_reads);
}

int main(void)
{
    static const world_image image = {
        "program", program_main, __start_program_data, __stop_program_data};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(datagrams_go_by_calls_for_one_and_for_several),
        cmocka_unit_test(what_is_no_socket_is_refused),
        cmocka_unit_test(interfaces_are_listed_as_linux_does),
        cmocka_unit_test(names_are_those_of_hosts_and_of_the_server),
        cmocka_unit_test(a_local_name_is_held_by_one_process),
        cmocka_unit_test(root_hears_what_comes_to_an_interface),
        cmocka_unit_test(a_route_is_found_as_the_routes_say),
        cmocka_unit_test(the_systems_files_show_sockets_and_neighbours),
    };
    world_process_images(&image, 1);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
