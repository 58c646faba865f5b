#include "lum/net/resolve.h"

#include "net/resolve.h"
#include "net/sockaddr.h"

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
    return lum_system_resolve(host, address, error);
}
