#define _POSIX_C_SOURCE 200809L
#include "place.h"

#include "../common/number.h"
#include "net/program.h"

#include <errno.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define LOOPBACK 0x7f000001u

static int explain(uint32_t address, uint16_t port, int reason,
                   lum_error *error)
{
    char text[16];
    (void)number_format_address(address, text);
    if (reason == EADDRINUSE) {
        const lum_endpoint place = {address, port};
        const lum_program_text who =
            lum_program_show(lum_program_of_tcp_port(place));
        return lum_error_set(error,
                             "--port: port %u of %s is taken by %s: choose "
                             "another, or none for any that is free",
                             (unsigned)port, text, who.text);
    }
    if (reason == EADDRNOTAVAIL) {
        return lum_error_set(
            error, "--bind: %s is not an address of this host; see: ip addr",
            text);
    }
    return lum_error_set(error, "%s:%u: cannot be listened on: %s", text,
                         (unsigned)port, strerror(reason));
}

/* As a server would bind, so that what fails here is what would fail there. */
static int try_place(int fd, uint32_t address, uint16_t *port)
{
    const int yes = 1;
    struct sockaddr_in there = {.sin_family = AF_INET,
                                .sin_port = htons(*port),
                                .sin_addr.s_addr = htonl(address)};
    socklen_t len = sizeof there;
    if (setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(fd, (const struct sockaddr *)&there, sizeof there) != 0 ||
        listen(fd, 1) != 0 ||
        getsockname(fd, (struct sockaddr *)&there, &len) != 0) {
        return errno;
    }
    *port = ntohs(there.sin_port);
    return 0;
}

int place_find(const struct listen_options *options, uint32_t *address,
               uint16_t *port, lum_error *error)
{
    *address = options->has_address ? options->address : LOOPBACK;
    *port = options->port;
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    const int reason = fd < 0 ? errno : try_place(fd, *address, port);
    if (fd >= 0) {
        (void)close(fd);
    }
    return reason == 0 ? 0 : explain(*address, *port, reason, error);
}
