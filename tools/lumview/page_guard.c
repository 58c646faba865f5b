#include "page_guard.h"

#include "../common/number.h"

#include <stdio.h>
#include <string.h>

#define LOOPBACK  0x7f000001u
#define HTTP_PORT 80u

#define NAME_BYTES 20u /* of a cookie */

static const char scheme[] = "http://";

/* Browsers leave out the port that http has anyway. */
static bool is_name(const struct guard *guard, const char *name,
                    const char *host)
{
    char whole[GUARD_TEXT_BYTES];
    (void)snprintf(whole, sizeof whole, "%s:%u", name, (unsigned)guard->port);
    return strcmp(host, whole) == 0 ||
           (guard->port == HTTP_PORT && strcmp(host, name) == 0);
}

bool guard_knows_host(const struct guard *guard, const char *host)
{
    return is_name(guard, number_address(guard->address).text, host) ||
           (guard->address == LOOPBACK && is_name(guard, "localhost", host));
}

bool guard_knows_origin(const struct guard *guard, const char *origin)
{
    const size_t len = sizeof scheme - 1u;
    return strncmp(origin, scheme, len) == 0 &&
           guard_knows_host(guard, origin + len);
}

/* Takes constant time, so that the time does not show how much of it is
 * right. */
static bool is_token(const struct guard *guard, const char *text, size_t len)
{
    unsigned differences = 0;
    if (len != GUARD_TOKEN_DIGITS) {
        return false;
    }
    for (size_t i = 0; i < GUARD_TOKEN_DIGITS; i++) {
        differences |= (unsigned)guard->token[i] ^ (unsigned char)text[i];
    }
    return differences == 0;
}

/* Cookies know no ports, so the name has it. */
static int name_cookie(const struct guard *guard, char out[NAME_BYTES])
{
    return snprintf(out, NAME_BYTES, "lumview-%u=", (unsigned)guard->port);
}

static bool has_cookie(const struct guard *guard, const char *cookies)
{
    char name[NAME_BYTES];
    const size_t len = (size_t)name_cookie(guard, name);
    const char *at = cookies;
    while (*at != '\0') {
        at += strspn(at, "; ");
        const size_t n = strcspn(at, ";");
        if (n > len && strncmp(at, name, len) == 0 &&
            is_token(guard, at + len, n - len)) {
            return true;
        }
        at += n;
    }
    return false;
}

bool guard_knows_token(const struct guard *guard, const char *query,
                       const char *cookies)
{
    if (guard->token[0] == '\0') {
        return true;
    }
    if (query != NULL) {
        return is_token(guard, query, strlen(query));
    }
    return cookies != NULL && has_cookie(guard, cookies);
}

void guard_url(const struct guard *guard, char out[GUARD_TEXT_BYTES])
{
    (void)snprintf(out, GUARD_TEXT_BYTES, "%s%s:%u/%s%s", scheme,
                   number_address(guard->address).text, (unsigned)guard->port,
                   guard->token[0] != '\0' ? "?token=" : "", guard->token);
}

/* A strict cookie would be left out where a link in a file opens the page.
 * Requests that change something are refused by their origin. */
void guard_cookie(const struct guard *guard, char out[GUARD_TEXT_BYTES])
{
    char name[NAME_BYTES];
    (void)name_cookie(guard, name);
    (void)snprintf(out, GUARD_TEXT_BYTES,
                   "%s%s; Path=/; HttpOnly; SameSite=Lax", name, guard->token);
}
