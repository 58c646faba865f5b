/* The page and its WebSocket, on one thread. */
#ifndef LUMVIEW_SERVER_H
#define LUMVIEW_SERVER_H

#include "feed.h"
#include "options.h"
#include "page_guard.h"

#include "lum/base/error.h"

struct server;

/* Listens from now on, answers in server_run(). 0, or -1 with the reason. */
int server_open(const struct options *options, struct server **out,
                lum_error *error);
void server_close(struct server *server); /* NULL is allowed */

/* Where it listens. */
const struct guard *server_guard(const struct server *server);

/* To be called by a feed's threads: there is something new. */
void server_wake(void *server);

/* Serve the feed's frames until a signal comes. 0, or -1: it cannot. */
int server_run(struct server *server, struct feed *feed, lum_error *error);

#endif
