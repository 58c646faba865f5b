/* The connected browsers: what libwebsockets sends to each, and gets from it.
 */
#ifndef LUMVIEW_CLIENT_H
#define LUMVIEW_CLIENT_H

#include "viewer.h"

#include <stddef.h>

struct lws;

struct client_refusal;

struct client {
    struct lws *wsi;
    struct viewer viewer;
    const struct client_refusal *refusal; /* it is to be closed; else NULL */
    char command[COMMAND_BYTES];          /* so far */
    size_t command_len;
};

struct clients {
    struct viewers viewers;
};

/* -1: there is no memory. */
int clients_init(struct clients *clients, const struct options *options);
void clients_free(struct clients *clients);

/* A connection begins, and ends. */
void clients_add(struct clients *clients, struct client *client,
                 struct lws *wsi);
void clients_remove(struct clients *clients, struct client *client);

/* The feed has something new. */
void clients_wake(struct clients *clients);

/* Half a second has passed. */
void clients_tick(struct clients *clients);

/* The socket takes more. -1: the connection is to be closed. */
int clients_write(struct clients *clients, struct client *client);

/* A piece of a message came. What is no command ends the connection. */
void clients_read(struct clients *clients, struct client *client,
                  const char *bytes, size_t len);

#endif
