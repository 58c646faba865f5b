/* Answers to requests that are no WebSocket. */
#ifndef LUMVIEW_HTTP_H
#define LUMVIEW_HTTP_H

#include "assets.h"
#include "page_guard.h"
#include "served.h"

#include <stddef.h>

struct lws;

#define HTTP_POLICY_BYTES 512u

/* Of the WebSocket, as the page asks for it. */
#define SOCKET_PROTOCOL "lumview.1"

/* What is left to be sent of an answer. */
struct http_answer {
    const struct asset *asset;
    size_t sent;
};

/* The content security policy for a server at this place. */
void http_policy(const struct guard *guard, char out[HTTP_POLICY_BYTES]);

/* A request has come: its head is checked and answered. Returns as a callback
 * of libwebsockets. */
int http_begin(struct lws *wsi, const struct guard *guard,
               const struct served *served, const char *path,
               struct http_answer *answer);

/* The socket takes more of the answer. */
int http_go_on(struct lws *wsi, struct http_answer *answer);

/* A request for a WebSocket. 0: it is allowed; 1: it was refused with an
 * answer; -1: it was refused. */
int http_check_upgrade(struct lws *wsi, const struct guard *guard,
                       const char *kind);

#endif
