/* Who may talk to the server. A browser runs pages of others beside ours: they
 * can send requests to this host (a foreign Origin), and give a name of theirs
 * its address (a foreign Host). */
#ifndef LUMVIEW_PAGE_GUARD_H
#define LUMVIEW_PAGE_GUARD_H

#include <stdbool.h>
#include <stdint.h>

#define GUARD_TOKEN_DIGITS 32u /* 128 bits in hex */

struct guard {
    uint32_t address; /* listened on; host order */
    uint16_t port;
    char token[GUARD_TOKEN_DIGITS + 1u]; /* "": none is needed */
};

/* Room for the texts below. */
#define GUARD_TEXT_BYTES 96u

/* http://ADDRESS:PORT/, with the token if there is one. */
void guard_url(const struct guard *guard, char out[GUARD_TEXT_BYTES]);

/* A Host header; the own address, or localhost when that is 127.0.0.1. */
bool guard_knows_host(const struct guard *guard, const char *host);

/* An Origin header. */
bool guard_knows_origin(const struct guard *guard, const char *origin);

/* The token of the query counts if there is one, else that of the cookies.
 * Either may be NULL: there is none. */
bool guard_knows_token(const struct guard *guard, const char *query,
                       const char *cookies);

/* The Set-Cookie header that carries the token. */
void guard_cookie(const struct guard *guard, char out[GUARD_TEXT_BYTES]);

#endif
