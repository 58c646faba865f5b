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

static bool join(int fd, lum_endpoint to, const char *interface)
{
    struct sockaddr_in address;
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_port = htons(to.port);
    address.sin_addr.s_addr = htonl(to.address);
    return (interface == NULL ||
            setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, interface,
                       (socklen_t)strlen(interface)) == 0) &&
           connect(fd, (const struct sockaddr *)&address, sizeof address) == 0;
}

enum knock_answer knock_begin(struct knock *knock, lum_endpoint to,
                              const char *interface)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp request = {1, 0};
    lum_timestamp_encode(packet, &request);
    knock->fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (knock->fd < 0) {
        return KNOCK_FAILED;
    }
    if (!join(knock->fd, to, interface) ||
        send(knock->fd, packet, sizeof packet, 0) < 0) {
        return answer_of(errno);
    }
    return KNOCK_SILENCE;
}

enum knock_answer knock_hear(struct knock *knock, int wait_ms)
{
    struct pollfd wait = {.fd = knock->fd, .events = POLLIN};
    uint8_t packet[64];
    if (knock->fd < 0) {
        return KNOCK_FAILED;
    }
    (void)poll(&wait, 1, wait_ms);
    if (recv(knock->fd, packet, sizeof packet, 0) >= 0) {
        return KNOCK_ANSWERED;
    }
    return answer_of(errno);
}

void knock_end(struct knock *knock)
{
    if (knock->fd >= 0) {
        (void)close(knock->fd);
    }
    knock->fd = -1;
}
