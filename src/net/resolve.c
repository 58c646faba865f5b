/* Names of hosts to IPv4 addresses. */
#define _GNU_SOURCE /* EAI_NODATA */
#include "lum/net/resolve.h"

#include "net/sockaddr.h"

#if !defined(_WIN32)
#include <netdb.h>
#include <sys/socket.h>
#endif

#include <stdbool.h>
#include <string.h>

#define NAME_MAX_BYTES 253u

static const char digits[] = "0123456789";

/* A resolver may read a name with such a last part as an address in another
 * notation: 10.42.0 as 10.42.0.0, and 0x7f.1. */
static bool ends_as_number(const char *host)
{
    const char *point = strrchr(host, '.');
    const char *last = point != NULL ? point + 1 : host;
    return strspn(last, digits) == strlen(last) ||
           (last[0] == '0' && (last[1] == 'x' || last[1] == 'X'));
}

static bool may_be_name(const char *host)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz"
                                  "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                  "0123456789.-_";
    const size_t len = strlen(host);
    return len > 0 && len <= NAME_MAX_BYTES && strspn(host, letters) == len &&
           host[0] != '-' && host[0] != '.';
}

/* Systems report in several ways that a name has only other addresses. */
static bool lacks_address(int code)
{
    static const int codes[] = {
#if defined(_WIN32)
        WSANO_DATA,
#endif
#if defined(EAI_ADDRFAMILY)
        EAI_ADDRFAMILY,
#endif
#if defined(EAI_NODATA) && !defined(_WIN32)
        EAI_NODATA,
#endif
        0
    };
    size_t i = 0;
    while (codes[i] != 0 && codes[i] != code) {
        i++;
    }
    return codes[i] != 0;
}

/* Say what a code of getaddrinfo() means. Returns -1. */
static int fail(const char *name, int code, lum_error *error)
{
    if (lacks_address(code)) {
        return lum_error_set(error,
                             "'%.80s': this host has no IPv4 address; sensors "
                             "use only IPv4",
                             name);
    }
    if (code == EAI_NONAME) {
        return lum_error_set(error,
                             "'%.80s': no host of this name is known; give its "
                             "address, such as 10.42.0.37",
                             name);
    }
    return lum_error_set(error,
                         "'%.80s': the name cannot be looked up: %s; give its "
                         "address, such as 10.42.0.37",
                         name, gai_strerror(code));
}

/* The first IPv4 address of a name. */
static int look_up(const char *name, uint32_t *out, lum_error *error)
{
    struct addrinfo *found = NULL;
    struct sockaddr_in address;
    const struct addrinfo wanted = {.ai_family = AF_INET,
                                    .ai_socktype = SOCK_DGRAM};
    const int code = getaddrinfo(name, NULL, &wanted, &found);
    if (code != 0) {
        return fail(name, code, error);
    }
    memcpy(&address, found->ai_addr, sizeof address);
    freeaddrinfo(found);
    *out = ntohl(address.sin_addr.s_addr);
    return 0;
}

static int resolve(const char *name, uint32_t *out, lum_error *error)
{
#if defined(_WIN32)
    if (lum_winsock_start(error) != 0) {
        return -1;
    }
    const int result = look_up(name, out, error);
    lum_winsock_stop();
    return result;
#else
    return look_up(name, out, error);
#endif
}

int lum_resolve(const char *host, uint32_t *address, lum_error *error)
{
    struct in_addr parsed;
    if (inet_pton(AF_INET, host, &parsed) == 1) {
        *address = ntohl(parsed.s_addr);
        return 0;
    }
    if (strchr(host, ':') != NULL) {
        return lum_error_set(
            error,
            "'%.80s': this is not an IPv4 address; sensors use only IPv4",
            host);
    }
    if (ends_as_number(host) || !may_be_name(host)) {
        return lum_error_set(error,
                             "'%.80s' is neither an IPv4 address, four numbers "
                             "from 0 to 255 such as 10.42.0.37, nor the name "
                             "of a host",
                             host);
    }
    return resolve(host, address, error);
}
