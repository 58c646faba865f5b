#define _GNU_SOURCE

#include "doctor_knock.h"

#include "lum/wire.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define TRIES   3
#define WAIT_MS 200

static enum knock_answer answer_of(int error)
{
    switch (error) {
    case EAGAIN:
    case EINTR:
        return KNOCK_SILENCE;
    case ECONNREFUSED:
        return KNOCK_REFUSED;
    case EPERM:
    case EACCES:
        return KNOCK_DENIED;
    case EHOSTUNREACH:
    case ENETUNREACH:
    case EHOSTDOWN:
    case ENETDOWN:
        return KNOCK_UNREACHABLE;
    default:
        return KNOCK_FAILED;
    }
}

static struct sockaddr_in address_of(lum_endpoint to)
{
    struct sockaddr_in address;
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_port = htons(to.port);
    address.sin_addr.s_addr = htonl(to.address);
    return address;
}

/* -1: none, or choosing the interface is not allowed. */
static int open_socket(const char *interface)
{
    const int fd =
        socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && interface != NULL &&
        setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, interface,
                   (socklen_t)strlen(interface)) != 0) {
        (void)close(fd);
        return -1;
    }
    return fd;
}

enum knock_answer knock_open(struct knock *knock, lum_endpoint to,
                             const char *interface)
{
    const struct sockaddr_in address = address_of(to);
    struct sockaddr_in own = address;
    socklen_t len = sizeof own;
    *knock = (struct knock){open_socket(interface), 0};
    if (knock->fd < 0) {
        return KNOCK_FAILED;
    }
    if (connect(knock->fd, (const struct sockaddr *)&address, sizeof address) !=
        0) {
        return answer_of(errno);
    }
    if (getsockname(knock->fd, (struct sockaddr *)&own, &len) == 0) {
        knock->port = ntohs(own.sin_port);
    }
    return KNOCK_SILENCE;
}

static size_t make_request(uint8_t packet[LUM_TIMESTAMP_BYTES])
{
    const lum_timestamp request = {1, 0};
    lum_timestamp_encode(packet, &request);
    return LUM_TIMESTAMP_BYTES;
}

enum knock_answer knock_send(const struct knock *knock)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const size_t len = make_request(packet);
    return send(knock->fd, packet, len, 0) < 0 ? answer_of(errno)
                                               : KNOCK_SILENCE;
}

enum knock_answer knock_begin(struct knock *knock, lum_endpoint to,
                              const char *interface)
{
    const enum knock_answer answer = knock_open(knock, to, interface);
    return answer == KNOCK_SILENCE ? knock_send(knock) : answer;
}

static bool is_timestamp(const uint8_t *packet, ssize_t len)
{
    lum_timestamp answer;
    return len >= 0 &&
           lum_timestamp_decode(packet, (size_t)len, &answer) == LUM_OK;
}

enum knock_answer knock_hear(struct knock *knock, int wait_ms)
{
    struct pollfd wait = {.fd = knock->fd, .events = POLLIN};
    uint8_t packet[64];
    if (knock->fd < 0) {
        return KNOCK_FAILED;
    }
    (void)poll(&wait, 1, wait_ms);
    const ssize_t n = recv(knock->fd, packet, sizeof packet, 0);
    if (n < 0) {
        return answer_of(errno);
    }
    return is_timestamp(packet, n) ? KNOCK_ANSWERED : KNOCK_SILENCE;
}

void knock_end(struct knock *knock)
{
    if (knock->fd >= 0) {
        (void)close(knock->fd);
    }
    knock->fd = -1;
}

bool knock_reaches(lum_endpoint to, const char *interface)
{
    struct knock knock;
    enum knock_answer answer = knock_open(&knock, to, interface);
    for (int i = 0; i < TRIES && answer == KNOCK_SILENCE; i++) {
        answer = knock_send(&knock);
        if (answer == KNOCK_SILENCE) {
            answer = knock_hear(&knock, WAIT_MS);
        }
    }
    knock_end(&knock);
    return answer == KNOCK_ANSWERED;
}

/* Not connected, so that it receives from any port. */
static uint16_t hear_from(int fd, uint32_t address)
{
    struct pollfd wait = {.fd = fd, .events = POLLIN};
    struct sockaddr_in from = {.sin_family = AF_INET};
    socklen_t len = sizeof from;
    uint8_t packet[64];
    (void)poll(&wait, 1, WAIT_MS);
    const ssize_t n =
        recvfrom(fd, packet, sizeof packet, 0, (struct sockaddr *)&from, &len);
    return is_timestamp(packet, n) && ntohl(from.sin_addr.s_addr) == address
               ? ntohs(from.sin_port)
               : 0;
}

uint16_t knock_other_port(lum_endpoint to, const char *interface)
{
    const struct sockaddr_in address = address_of(to);
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const size_t len = make_request(packet);
    const int fd = open_socket(interface);
    uint16_t port = 0;
    for (int i = 0; i < TRIES && fd >= 0 && port == 0; i++) {
        if (sendto(fd, packet, len, 0, (const struct sockaddr *)&address,
                   sizeof address) >= 0) {
            port = hear_from(fd, to.address);
        }
    }
    if (fd >= 0) {
        (void)close(fd);
    }
    return port == to.port ? 0 : port;
}
