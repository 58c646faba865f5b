/* The kernel's route by netlink, and its table of neighbours. */
#define _GNU_SOURCE

#include "host_route.h"

#include "doctor/doctor_neighbour.h"

#include <arpa/inet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

unsigned host_route_mtu(const char *interface)
{
    struct ifreq request;
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    memset(&request, 0, sizeof request);
    (void)snprintf(request.ifr_name, sizeof request.ifr_name, "%s", interface);
    const bool is_known = fd >= 0 && ioctl(fd, SIOCGIFMTU, &request) == 0;
    if (fd >= 0) {
        (void)close(fd);
    }
    return is_known && request.ifr_mtu > 0 ? (unsigned)request.ifr_mtu : 0;
}

/* A request for a route, see rtnetlink(7). */
struct route_request {
    struct nlmsghdr header;
    struct rtmsg route;
    char attributes[64];
};

static void add_attribute(struct route_request *r, unsigned short type,
                          const void *value, size_t len)
{
    const struct rtattr a = {(unsigned short)(sizeof a + len), type};
    char *to = (char *)r + NLMSG_ALIGN(r->header.nlmsg_len);
    memcpy(to, &a, sizeof a);
    memcpy(to + sizeof a, value, len);
    r->header.nlmsg_len += (uint32_t)(sizeof a + len);
}

static bool send_request(int fd, uint32_t address, unsigned index,
                         unsigned flags)
{
    struct route_request r;
    const uint32_t destination = htonl(address);
    memset(&r, 0, sizeof r);
    r.header.nlmsg_len = NLMSG_LENGTH(sizeof r.route);
    r.header.nlmsg_type = RTM_GETROUTE;
    r.header.nlmsg_flags = NLM_F_REQUEST;
    r.route.rtm_family = AF_INET;
    r.route.rtm_dst_len = 32;
    r.route.rtm_flags = flags;
    add_attribute(&r, RTA_DST, &destination, sizeof destination);
    if (index != 0) {
        const uint32_t oif = index;
        add_attribute(&r, RTA_OIF, &oif, sizeof oif);
    }
    return send(fd, &r, r.header.nlmsg_len, 0) == (ssize_t)r.header.nlmsg_len;
}

static void take_attribute(const struct rtattr *a, const void *value,
                           struct host_route *out)
{
    uint32_t word = 0;
    if (a->rta_len < sizeof *a + sizeof word) {
        return;
    }
    memcpy(&word, value, sizeof word);
    if (a->rta_type == RTA_OIF) {
        char name[IF_NAMESIZE] = "";
        (void)if_indextoname(word, name);
        (void)snprintf(out->interface, sizeof out->interface, "%s", name);
    } else if (a->rta_type == RTA_GATEWAY) {
        out->has_gateway = true;
        out->gateway = ntohl(word);
    } else if (a->rta_type == RTA_PREFSRC) {
        out->source = ntohl(word);
    }
}

static void take_attributes(const char *p, size_t len, struct host_route *out)
{
    struct rtattr a;
    while (len >= sizeof a) {
        memcpy(&a, p, sizeof a);
        if (a.rta_len < sizeof a || a.rta_len > len) {
            return;
        }
        take_attribute(&a, p + sizeof a, out);
        const size_t step = RTA_ALIGN(a.rta_len);
        if (step > len) {
            return;
        }
        p += step;
        len -= step;
    }
}

/* The answer is one message. */
static bool take_reply(const char *bytes, size_t len, struct host_route *out,
                       struct rtmsg *route)
{
    struct nlmsghdr header;
    struct nlmsgerr refusal;
    if (len < sizeof header) {
        return false;
    }
    memcpy(&header, bytes, sizeof header);
    if (header.nlmsg_type == NLMSG_ERROR &&
        len >= NLMSG_LENGTH(sizeof refusal)) {
        memcpy(&refusal, bytes + NLMSG_HDRLEN, sizeof refusal);
        out->error = -refusal.error;
        return true;
    }
    if (header.nlmsg_type != RTM_NEWROUTE ||
        header.nlmsg_len < NLMSG_SPACE(sizeof *route) ||
        header.nlmsg_len > len) {
        return false;
    }
    memcpy(route, bytes + NLMSG_HDRLEN, sizeof *route);
    out->exists = true;
    take_attributes(bytes + NLMSG_SPACE(sizeof *route),
                    header.nlmsg_len - NLMSG_SPACE(sizeof *route), out);
    return true;
}

static bool ask(int fd, uint32_t address, unsigned index, unsigned flags,
                struct host_route *out, struct rtmsg *route)
{
    char reply[4096];
    if (!send_request(fd, address, index, flags)) {
        return false;
    }
    const ssize_t n = recv(fd, reply, sizeof reply, 0);
    return n > 0 && take_reply(reply, (size_t)n, out, route);
}

/* Asked twice: for the route, and for the entry of the table that gave it. */
struct host_route host_route_find(uint32_t address, const char *interface)
{
    const struct timeval limit = {0, 500000};
    const unsigned index = interface == NULL ? 0 : if_nametoindex(interface);
    struct host_route out = {.is_known = false};
    struct host_route entry = {.exists = false};
    struct rtmsg route;
    memset(&route, 0, sizeof route);
    const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    if (fd < 0) {
        return out;
    }
    out.is_known =
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) == 0 &&
        ask(fd, address, index, 0, &out, &route);
    out.is_local = route.rtm_type == RTN_LOCAL;
    out.is_default = out.is_known && out.exists &&
                     ask(fd, address, index, RTM_F_FIB_MATCH, &entry, &route) &&
                     entry.exists && route.rtm_dst_len == 0;
    (void)close(fd);
    return out;
}

bool host_route_neighbour(uint32_t address, const char *interface,
                          char mac[INTERFACE_MAC_TEXT_BYTES])
{
    return neighbours_look_up(address, interface, mac) == ARP_COMPLETE;
}
